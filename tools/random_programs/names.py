"""What `tumble grade` calls the mistakes of this package: one table, and what translates its answers back.

A label that is not in the table, or stands there with nothing, has no name: the honest answer is then that the file is
not explained, or is explained in part.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tools.random_programs.contact import Claim
from tools.random_programs.mistakes import Params
from tools.random_programs.scene import Scene
from tools.random_programs.scheme import NORMALISED, RAW, RAW_INVERSE, UNIT_IN_R

Value = Callable[[Params, Scene], float | str]


@dataclass(frozen=True)
class Name:
    """A name that is right for a mistake; value: what its parameter must be, None where any is.

    same: it means something else that makes the same motion in every scene; what makes it in some is found by a run.
    """

    name: str
    value: Value | None = None
    same: bool = False


def of(key: str) -> Value:
    """Return a parameter of the mistake."""
    return lambda params, scene: params[key]


def same(name: str, value: Value | None = None) -> Name:
    """Return a name of another mistake that makes the same motion."""
    return Name(name, value, True)


def vertex(params: Params, scene: Scene) -> str:
    """Return how a vertex is called."""
    return f"vertex {params['vertex']}"


def _torque(params: Params, scene: Scene) -> float:
    return float(params["share"]) * float(scene.moments.mean())


def _friction(params: Params, scene: Scene) -> float:
    return float(params["rate"]) * float(np.linalg.norm(scene.w)) / scene.duration


def _turning(params: Params, scene: Scene) -> float:
    return float(params["turn"]) / scene.duration


def _behind(params: Params, scene: Scene) -> float:
    return -float(params["time"])


STARTS = same("wrong-start-velocity")
TURNED = same("wrong-start-attitude")
ACCELERATION = same("constant-acceleration")

MISTAKES: dict[str, tuple[Name, ...]] = {
    "start velocity missing": (Name("start-velocity-missing"), STARTS),
    "start velocity reversed": (Name("start-velocity-reversed"), STARTS),
    "start velocity in body axes": (Name("start-velocity-in-body-axes"), STARTS),
    "start velocity in other axes": (Name("start-velocity-in-wrong-axes"), STARTS),
    "start spin missing": (Name("start-spin-missing"),),
    "start spin reversed": (Name("start-spin-reversed"),),
    "start spin in body axes": (Name("start-spin-in-body-axes"),),
    "start spin in other axes": (Name("start-spin-in-wrong-axes"),),
    "start spin taken for degrees": (Name("start-spin-read-as-degrees"),),
    "start spin turned into degrees": (Name("start-spin-converted-to-degrees"),),
    "start attitude missing": (Name("start-attitude-missing"), TURNED),
    "start attitude inverted": (Name("start-attitude-inverted"), TURNED),
    "start attitude read x y z w": (Name("start-attitude-wxyz-read-as-xyzw"), TURNED),
    "start position missing": (Name("start-position-missing"), same("wrong-start-position")),
    "another start position": (Name("wrong-start-position"),),
    "impulse missing": (Name("impulse-missing"),),
    "one impulse missing": (Name("one-impulse-missing"),),
    "impulse doubled": (Name("impulse-doubled"), same("impulse-wrong-magnitude", lambda p, s: 2.0)),
    "impulse reversed": (Name("impulse-reversed"),),
    "impulse of another size": (Name("impulse-wrong-magnitude", of("factor")),),
    "impulse times dt": (Name("impulse-wrong-magnitude", of("factor")),),
    "one impulse of another size": (Name("one-impulse-wrong-magnitude", of("factor")),),
    "mass left out": (Name("mass-missing"), same("wrong-mass", lambda p, s: 1 / s.mass)),
    "impulse divided by another mass": (Name("wrong-mass", of("factor")),),
    "impulse only turns": (Name("impulse-linear-part-missing"),),
    "impulse at the centre": (Name("impulse-at-centre-of-mass"),),
    "impulse lever reversed": (Name("impulse-lever-reversed"),),
    "impulse point from the origin": (Name("impulse-lever-from-origin"),),
    "impulse lever not turned": (Name("impulse-lever-not-rotated"), same("one-impulse-lever-not-rotated")),
    "impulse lever as at the start": (
        Name("impulse-lever-from-start-attitude"),
        same("one-impulse-lever-from-start-attitude"),
    ),
    "impulse at another vertex": (Name("impulse-at-wrong-vertex", vertex), same("one-impulse-at-wrong-vertex")),
    "impulse in body axes": (Name("impulse-in-body-axes"), same("one-impulse-in-body-axes")),
    "impulse torque in body axes": (Name("impulse-torque-in-body-axes"),),
    "impulse without inertia": (Name("impulse-not-divided-by-inertia"),),
    "impulse torque over the mass": (Name("impulse-divided-by-mass"),),
    "impulse with a mean inertia": (Name("impulse-of-spherical-inertia"),),
    "impulse at another time": (Name("impulse-at-wrong-time", of("late")),),
    "impulse fired twice, the second later": (Name("impulses-repeated", of("later")),),
    "impulse as force": (
        Name("impulse-as-force", of("lasts")),
        Name("impulse-as-force-over-one-step", of("lasts")),
    ),
    "impulse as force without end": (Name("impulse-as-permanent-force"),),
    "impulse inertia not turned": (Name("impulse-inertia-not-rotated"),),
    "gravity missing": (Name("gravity-missing"), ACCELERATION),
    "gravity doubled": (Name("gravity-doubled"), ACCELERATION),
    "gravity reversed": (Name("gravity-reversed"), ACCELERATION),
    "gravity of another size": (Name("gravity-wrong-magnitude", of("factor")), ACCELERATION),
    "gravity times dt": (Name("gravity-wrong-magnitude", of("factor")), ACCELERATION),
    "gravity along another axis": (Name("gravity-along-wrong-axis"), ACCELERATION),
    "gravity added": (Name("gravity-added", of("along")), ACCELERATION),
    "gravity in body axes": (Name("gravity-in-body-axes"),),
    "gravity late": (Name("gravity-delayed", of("time")),),
    "constant acceleration": (Name("constant-acceleration"),),
    "linear damping": (Name("linear-damping", of("rate")),),
    "angular damping": (Name("angular-damping", of("rate")),),
    "quadratic drag": (Name("quadratic-drag", of("rate")),),
    "drag torque": (Name("drag-torque", _torque),),
    "dry friction of the velocity": (Name("dry-friction", of("rate")),),
    "dry friction of the spin": (Name("dry-angular-friction", _friction),),
    "spin capped per component": (Name("spin-cap-of-components", of("cap")),),
    "speed cap": (Name("speed-cap", of("cap")),),
    "spin cap": (Name("spin-cap", of("cap")),),
    "tether missing": (Name("tether-missing"),),
    "drag missing": (Name("drag-missing"),),
    "drag's torque missing": (Name("angular-drag-missing"),),
    "tether pulls at the centre": (Name("tether-torque-missing"),),
    # All of its force is another one: of the spring and of the damper, each of which has a name.
    "tether of another stiffness": (
        Name("tether-stiffness-wrong-magnitude", of("factor")),
        Name("tether-damping-wrong-magnitude", of("factor")),
    ),
    "inertia of a sphere": (Name("spherical-inertia"),),
    "inertia of permuted axes": (Name("inertia-axes-permuted"), same("edges-permuted")),
    "inverse for inertia": (Name("inertia-inverted"),),
    "another inertia": (Name("wrong-inertia", of("factor")),),
    "edges in another order": (Name("edges-permuted"), same("inertia-axes-permuted")),
    "another size along an axis": (),  # below: its name has the axis in it
    "inertia never turned": (Name("inertia-never-rotated"),),
    "tensor in body axes, its inverse in world axes": (Name("momentum-inertia-not-rotated"),),
    "inertia frozen at the start": (Name("inertia-frozen-at-start"),),
    "inertia turned the wrong way": (Name("inertia-rotated-inversely"),),
    "gyroscopic term missing": (Name("gyroscopic-term-missing"),),
    "gyroscopic term reversed": (Name("gyroscopic-term-reversed"),),
    "angular velocity in the wrong frame": (Name("angular-velocity-in-wrong-frame"),),
    "half of q' missing": (Name("quaternion-rate-doubled"),),
    "half of q' twice": (Name("quaternion-rate-halved"),),
    "clock offset": (Name("clock-offset", of("time")), Name("log-lag", of("time"))),
    "clock rate": (Name("clock-rate", of("rate")),),
    "stops": (Name("body-stops", of("time")),),
    "quaternion x y z w under w x y z": (Name("quaternion-xyzw-read-as-wxyz"),),
    "quaternion w x y z under x y z w": (Name("quaternion-wxyz-read-as-xyzw"),),
    "conjugate": (Name("attitude-inverted"),),
    "a sign of the quaternion's vector": (
        Name("quaternion-vector-mirrored"),
        same("attitude-only-in-wrong-axes"),
    ),
    "whole angle for half": (Name("half-angle-missing"),),
    "a vertex logged for the centre": (
        Name("wrong-point-logged", vertex),
        same("constant-offset-in-body-axes"),
    ),
    "another point logged": (Name("constant-offset-in-body-axes"), Name("wrong-point-logged")),
    "another unit of length": (Name("wrong-length-unit", of("unit")),),
    "only the centre in other axes": (Name("position-only-in-wrong-axes"),),
    "only the attitude in other axes": (Name("attitude-only-in-wrong-axes"), same("quaternion-vector-mirrored")),
    "floor at zero": (Name("floor-at-zero"),),
    "other axes": (Name("wrong-axes"),),
    "turned about the origin": (Name("rotation-about-origin"),),
    "turning axes": (Name("rotating-axes", _turning),),
}

# --- schemes --------------------------------------------------------------------------------------------------------

VELOCITY = {"screw": "screw", "body": "straight"}
BETWEEN = (Name("interpolated-rows", of("tick")), Name("fixed-physics-step", of("tick")))
SCHEME: dict[str, tuple[Name, ...]] = {
    "rows late": (Name("log-lag", of("time")), Name("clock-offset", _behind), *BETWEEN),
    "gravity idle": (Name("gravity-delayed", of("time")), same("wrong-position-update")),
    "asleep at first": (Name("log-lag", of("time")), Name("clock-offset", _behind)),
    "velocity in body axes": (Name("velocity-in-body-axes", lambda params, scene: VELOCITY[str(params["how"])]),),
    "spin of the difference of attitudes": (Name("spin-from-attitude-difference"),),
    "another step of x": (Name("wrong-position-update"), Name("explicit-euler"), same("gravity-delayed")),
}
STEPS = {
    "split": "symplectic-euler",
    "Verlet": "velocity-verlet",
    "explicit Euler": "explicit-euler",
    "midpoint": "midpoint",
    "Heun": "heun",
    "order 3": "runge-kutta-3",
    "order 4": "runge-kutta-4",
    "Ralston": "ralston",
    "order 3, Shu and Osher": "runge-kutta-3-shu-osher",
    "order 4, three eighths": "runge-kutta-4-three-eighths",
}
# A step that a file without a torque cannot distinguish from one of these.
SAME_STEPS = {"explicit-euler": ("quaternion-never-normalised", "quaternion-rarely-normalised", "matrix-euler")}
GYROSCOPIC = {
    "none": "",
    "explicit": "explicit",
    "implicit": "implicit",
    "rescaled": "rescaled",
    "Lacoursiere": "backward",
    "midpoint": "midpoint",
    "momentum": "momentum",
    "midpoint, turned by the new": "midpoint, then new",
    "implicit, converged": "implicit, converged",
    "energy kept": "energy kept",
    "Heun": "heun",
    "order 4": "runge-kutta-4",
}
STAGES = {
    UNIT_IN_R: "",
    NORMALISED: "normalised",
    RAW: "not normalised",
    RAW_INVERSE: "not normalised, R I^-1 R^T",
}
TURNING = {
    "exponential": "exponential",
    "first order": "first order",
    "second order": "second order",
    "half angle": "half angle",
    "tangent": "tangent",
    "Gram-Schmidt": "gram-schmidt",
    "axis by axis": "axis by axis",
}
PLACES = {
    "before the forces of a step": "before",
    "after the forces of a step": "between",
    "after a step has moved the body": "after",
    "as a force": "before",
}
DECAYS = {"by c dt": "1 - c dt", "by exp(-c dt)": "exp", "by 1/(1 + c dt)": "1/(1 + c dt)"}
# Parameters whose value is held against a mistake's.
MAIN = ("step", "time", "rate", "factor", "choice")
SIGNLESS = ("log-lag", "rotating-axes")


def names(label: str, params: Params) -> tuple[Name, ...]:
    """Return the names of a mistake or of a part of a scheme; none where it has none."""
    match label:
        case "another size along an axis":
            return (Name(f"wrong-body-size-along-{'xyz'[int(params['axis'])]}", of("factor")),)
        case "rows between ticks":
            found = {
                "held": "fixed-physics-step",
                "straight": "interpolated-rows",
                "arcs": "interpolated-rows",
                "ahead": "extrapolated-rows",
            }
            name = found.get(str(params["how"]))
            extra = (Name("log-lag", of("tick")),) if name == "interpolated-rows" else ()
            return (Name(name, of("tick")), *extra) if name else ()
        case "centre in substeps":
            return (Name("symplectic-euler", lambda params, scene: str(params["substeps"])),)
        case "normalised":
            if params["every"]:
                return (Name("quaternion-rarely-normalised"),)
            never = ("symplectic-euler", "quaternion-never-normalised")
            return *(Name(name, lambda params, scene: "never") for name in never), Name("quaternion-never-normalised")
        case "step":
            return _step(params)
    return MISTAKES.get(label, SCHEME.get(label, ()))


def _step(params: Params) -> tuple[Name, ...]:
    method = str(params["method"])
    if method == "split" and params["moves"] == "old, all":
        method = "explicit Euler"
    name = STEPS.get(method)
    if name is None:
        return ()
    if params["method"] == "split" and (params["gyroscopic"] not in GYROSCOPIC or params["turning"] not in TURNING):
        return ()
    return Name(name, of("step")), *(Name(other, of("step")) for other in SAME_STEPS.get(name, ()))


def fits(name: Name, claim: Claim, params: Params, scene: Scene, tolerance: float) -> bool:
    """Whether a claim is of a name, with the value that is right to a relative tolerance."""
    if claim.name != name.name:
        return False
    if name.value is None:
        return True
    right = name.value(params, scene)
    if isinstance(right, str):
        return right in claim.parameters.values()
    said = claim.number(*MAIN)
    if said is None:
        return True
    if name.name in SIGNLESS:
        said, right = abs(said), abs(right)
    return abs(said - right) <= tolerance * max(abs(right), 1e-12)


def step_fits(claim: Claim, params: Params) -> bool:
    """Whether the details of a step that a claim has are those of the scheme; what it leaves open is right."""
    said = claim.parameters
    if params["method"] != "split":
        return said.get("stages", "") in ("", STAGES[str(params["stages"])])
    gyroscopic, rotation = said.get("gyroscopic", ""), said.get("rotation", "")
    return gyroscopic in ("", GYROSCOPIC.get(str(params["gyroscopic"]))) and rotation in (
        "",
        TURNING.get(str(params["turning"])),
    )


# Names that mean one kind of mistake of this package, and the parameter of it that they have; "" where there is none.
BACK: Mapping[str, tuple[str, str]] = {
    entry.name: (label, "") for label, entries in MISTAKES.items() for entry in entries[:1] if entry.value is None
} | {
    "impulse-wrong-magnitude": ("impulse of another size", "factor"),
    "wrong-mass": ("impulse divided by another mass", "factor"),
    "gravity-wrong-magnitude": ("gravity of another size", "factor"),
    "gravity-delayed": ("gravity late", "time"),
    "linear-damping": ("linear damping", "rate"),
    "angular-damping": ("angular damping", "rate"),
    "quadratic-drag": ("quadratic drag", "rate"),
    "speed-cap": ("speed cap", "cap"),
    "spin-cap": ("spin cap", "cap"),
    "wrong-inertia": ("another inertia", "factor"),
}


def in_words(claims: Sequence[Claim]) -> str:
    """Return claims in words."""
    return "; ".join(map(str, claims))
