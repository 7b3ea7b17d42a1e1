"""Answers of `tumble grade` as programs: what each of its names does to a run, written here once more.

Where an answer leaves something open (which of several impulses, about which axis), each possibility is a program.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice, product

import numpy as np

from tools.random_programs.algebra import (
    ZERO,
    Matrix,
    Quaternion,
    Vector,
    add,
    along,
    cross,
    matrix,
    minus,
    norm,
    scale,
    times,
    times_transposed,
    transposed,
)
from tools.random_programs.contact import Claim
from tools.random_programs.dialect import VERTICES
from tools.random_programs.exact import Exact
from tools.random_programs.mistakes import KINDS
from tools.random_programs.mistakes.log import with_axes, with_q
from tools.random_programs.mistakes.rotation import resize
from tools.random_programs.names import BACK, DECAYS, GYROSCOPIC, MAIN, PLACES, STAGES, STEPS, TURNING, VELOCITY
from tools.random_programs.program import Case
from tools.random_programs.scene import Impulse, Scene
from tools.random_programs.scene_forces import MAKES
from tools.random_programs.scheme import RAW, RAW_INVERSE, SPLIT, VERLET, Damping, Reading, Scheme
from tools.random_programs.simulation import Load, Rows, Simulation

Plant = Callable[[Simulation], None]
# At most so many programs of one answer are simulated.
MOST = 60
G = 9.81
BULLET = 0.04
UNITS = {
    "cm for m": 100.0, "mm for m": 1000.0, "km for m": 1e-3, "feet for m": 1 / 0.3048, "inches for m": 1 / 0.0254,
    "m for cm": 0.01, "m for feet": 0.3048,
}  # fmt: skip
# How rows between ticks are read, and by how many ticks late they may be.
BETWEEN = {
    "interpolated-rows": (("arcs", "straight"), (0, 1)),
    "fixed-physics-step": (("held",), (0, 1, 0.5, -0.5)),
    "extrapolated-rows": (("ahead",), (0,)),
}
# Names of what a scheme has: they plant nothing by themselves.
IN_SCHEME = {
    *STEPS.values(), *BETWEEN, "velocity-in-body-axes", "wrong-position-update", "spin-from-attitude-difference",
    "quaternion-never-normalised", "quaternion-rarely-normalised",
}  # fmt: skip
IN_SPLIT = {*IN_SCHEME, "linear-damping", "angular-damping", "gyroscopic-term-missing"}
KEEPS = ("world", "body", "momentum")


@dataclass(frozen=True)
class Candidate:
    """A program that an answer describes; scheme: None where it names no method."""

    scheme: Scheme | None
    spacing: float
    keeps: str
    reading: Reading
    tick: float
    plants: tuple[Plant, ...]

    def rows(self, scene: Scene) -> Rows:
        """Return what it writes of a scene.  Raises BlownUp."""
        if self.scheme is None:
            sim: Simulation = Exact(scene, self.spacing, self.keeps, self.reading, self.tick)
        else:
            sim = Simulation(scene, self.scheme)
        for plant in self.plants:
            plant(sim)
        return sim.rows()


def candidates(case: Case, claims: Sequence[Claim]) -> Iterator[Candidate]:
    """Yield the programs that claims describe; none if a claim cannot be translated."""
    return islice(_candidates(case, claims), MOST)


def _candidates(case: Case, claims: Sequence[Claim]) -> Iterator[Candidate]:
    names = {claim.name: claim for claim in claims}
    # Late rows may be interpolated between ticks: the name is the same, and its time is the tick.
    lag = names.get("log-lag")
    if lag and not names.keys() & BETWEEN.keys():
        others = [claim for claim in claims if claim is not lag]
        yield from _candidates(case, [*others, Claim("interpolated-rows", {"step": lag.parameters["time"]})])
    for own in _schemes(case, names):
        is_split = own.scheme is not None and own.scheme.method == SPLIT
        planted = [claim for claim in claims if claim.name not in (IN_SPLIT if is_split else IN_SCHEME)]
        for plants in product(*(_plants(claim, case) for claim in planted)):
            yield replace(own, plants=plants)


# --- schemes --------------------------------------------------------------------------------------------------------


def _schemes(case: Case, names: dict[str, Claim]) -> Iterator[Candidate]:
    """Yield programs with the scheme of an answer and without its other mistakes."""
    spacing = case.program.scheme.spacing
    between = next((names[name] for name in BETWEEN if name in names), None)
    readings = [Reading()]
    if between:
        hows, lates = BETWEEN[between.name]
        readings = [Reading(late, how) for how, late in product(hows, lates)]  # type: ignore[arg-type]
    tick = (between and between.number("step")) or spacing
    steps = {name: method for method, name in STEPS.items()} | {"quaternion-never-normalised": "explicit Euler"}
    method = next((name for name in steps if name in names), None)
    for reading in readings:
        if method is None:
            yield from (Candidate(None, spacing, keeps, reading, tick, ()) for keeps in _kept(names))
            continue
        for scheme in _stepped(names[method], steps[method], names, spacing, tick if between else None):
            if scheme.reading.between or not between:
                yield Candidate(replace(scheme, reading=reading), spacing, scheme.keeps, reading, tick, ())


def _kept(names: dict[str, Claim]) -> Sequence[str]:
    """Return what an exact program may keep of its rotation, where that makes a difference."""
    mixed = (
        "angular-velocity-in-wrong-frame", "quaternion-rate-doubled", "quaternion-rate-halved",
        "quaternion-rate-reversed",
    )  # fmt: skip
    return KEEPS if any(name in names for name in mixed) else ("world",)


def _stepped(
    claim: Claim, method: str, names: dict[str, Claim], spacing: float, tick: float | None
) -> Iterator[Scheme]:
    """Yield the schemes of a step; tick: [s], where rows lie between ticks."""
    step = claim.number("step")
    if not step:
        return
    said = claim.parameters
    whole = tick or step * (claim.number("ticks") or 1)
    every = round(spacing / whole)
    if not tick:
        if every < 1 or abs(every * whole - spacing) > 1e-3 * spacing:
            return
        whole = spacing / every
    own = Scheme(
        whole,
        spacing,
        method,
        reading=Reading(0, "held") if tick else Reading(),
        substeps=max(1, round(whole / step)),
        centre=int(claim.number("substeps") or 1),
        recovers="spin-from-attitude-difference" in names,
        velocity=next((how for how, moves in VELOCITY.items() if moves == _moves(names)), "world"),
        stages=next(stages for stages, name in STAGES.items() if name == said.get("stages", "")),
    )
    if said.get("normalised") == "never" or claim.name == "quaternion-never-normalised":
        own = replace(own, normalises=0)
    elif "quaternion-rarely-normalised" in names:
        own = replace(own, normalises=int(names["quaternion-rarely-normalised"].parameters["choice"]))
    turns = {name: kind for kind, name in TURNING.items()}
    if method == VERLET:
        keeps = "momentum" if said.get("stored") else "world"
        yield replace(own, keeps=keeps, turning=turns.get(said.get("rotation", ""), "exponential"))
    elif method != SPLIT:
        stored = said.get("stored", "")
        kept = ("world", "momentum") if own.stages in (RAW, RAW_INVERSE) else KEEPS
        yield from (replace(own, keeps=keeps) for keeps in ((stored,) if stored in KEEPS else kept))
    if method not in (SPLIT, "explicit Euler"):
        return
    spins = {name: kind for kind, name in GYROSCOPIC.items() if name}
    spin = spins.get(said.get("gyroscopic", ""), "explicit")
    spin = "none" if "gyroscopic-term-missing" in names else spin
    damping = Damping()
    for kind in ("linear", "angular"):
        if f"{kind}-damping" in names:
            damping = _damping(damping, kind, names[f"{kind}-damping"])
    own = replace(
        own,
        method=SPLIT,
        gyroscopic="explicit" if spin == "momentum" else spin,
        turning=turns.get(said.get("rotation", ""), "exponential"),
        damping=damping,
    )
    kept = ("momentum",) if spin == "momentum" else (said.get("stored", "") or "world", "body")
    ways = ("old, all",) if method != SPLIT else ("new",)
    if "wrong-position-update" in names:
        ways = ("old", "parabola") if method == SPLIT else ("old turn",)
    for keeps, moves in product(dict.fromkeys(kept), ways):
        yield replace(own, keeps=keeps, moves=moves)


def _moves(names: dict[str, Claim]) -> str:
    """Return how the centre moves in an answer with its velocity in body axes; empty in another."""
    if "velocity-in-body-axes-without-correction" in names:
        return VELOCITY["body"]
    return names["velocity-in-body-axes"].parameters["moves"] if "velocity-in-body-axes" in names else ""


def _damping(damping: Damping, kind: str, claim: Claim) -> Damping:
    where = PLACES.get(claim.parameters.get("damping-place", ""), "before")
    how = DECAYS.get(claim.parameters.get("damping-form", ""), "1 - c dt")
    return replace(damping, where=where, how=how, **{kind: claim.number("rate") or 0.0})


# --- what a claim does to a run -------------------------------------------------------------------------------------


def _plants(claim: Claim, case: Case) -> list[Plant]:
    """Return what a claim may do to a run; nothing where that is not known."""
    if claim.name in OWN:
        return list(OWN[claim.name](claim, case))
    if claim.name.startswith("one-impulse-"):
        return _of_one(claim, case)
    if claim.name not in BACK:
        return []
    label, key = BACK[claim.name]
    return [partial(_of_kind, label=label, params={key: claim.number(*MAIN)} if key else {})]


def _of_kind(sim: Simulation, label: str, params: dict) -> None:
    KINDS[label].plant(sim, **params)
    if isinstance(sim, Exact) and "time" in params:
        sim.instants.append(params["time"])


Makes = Callable[[Claim, Case], Iterator[Plant]]
OWN: dict[str, Makes] = dict(MAKES)


def _named(*names: str) -> Callable[[Makes], Makes]:
    """Enter the translation of names."""

    def enter(make: Makes) -> Makes:
        OWN.update(dict.fromkeys(names, make))
        return make

    return enter


def _vector(claim: Claim) -> np.ndarray:
    return np.array(claim.parameters["vector"].split(), float)


def _axes(claim: Claim) -> np.ndarray:
    """Return the matrix of axes that replace x y z, as in `x -z y`."""
    names = claim.parameters["choice"].split()
    return np.array([(-1.0 if "-" in name else 1.0) * np.eye(3)["xyz".index(name[-1])] for name in names])


def _direction(claim: Claim) -> np.ndarray:
    name = claim.parameters["choice"]
    return (-1.0 if "-" in name else 1.0) * np.eye(3)["xyz".index(name[-1])]


def _set(**values: np.ndarray) -> Plant:
    """Set parts of the start."""

    def plant(sim: Simulation) -> None:
        for name, value in values.items():
            setattr(sim, name, tuple(sim.number(part) for part in value))

    return plant


# --- the start


@_named("wrong-start-position")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    yield _set(x=_vector(claim))


@_named("wrong-start-velocity")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    yield _set(v=_vector(claim))


@_named("wrong-start-attitude")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    yield _set(q=_vector(claim))


@_named("start-velocity-in-wrong-axes")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    yield _set(v=_axes(claim) @ case.scene.v)


@_named("start-spin-in-wrong-axes")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    yield _set(w=_axes(claim) @ case.scene.w)


@_named("start-attitude-in-wrong-axes")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    yield _set(q=np.concatenate((case.scene.q[:1], _axes(claim) @ case.scene.q[1:])))


@_named("start-attitude-wxyz-read-as-xyzw", "start-attitude-xyzw-read-as-wxyz")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    yield _set(q=np.roll(case.scene.q, 1 if claim.name.endswith("as-xyzw") else -1))


@_named("start-velocity-rotated-to-body-axes")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    yield _set(v=_attitude(case).T @ case.scene.v)


@_named("start-spin-rotated-to-body-axes")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    yield _set(w=_attitude(case).T @ case.scene.w)


def _attitude(case: Case) -> np.ndarray:
    return np.array(matrix(tuple(case.scene.q)))


@_named("start-velocity-in-wrong-unit")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    yield _set(v=(claim.number("factor") or 0.0) * case.scene.v)


@_named("start-spin-in-wrong-unit")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    yield _set(w=(claim.number("factor") or 0.0) * case.scene.w)


# --- forces


def _law(sim: Simulation, law: Callable[[Vector, Quaternion, Vector, Vector], Load]) -> None:
    sim.laws.append(law)


def _inertia_times(sim: Simulation, q: Quaternion, w: Vector) -> Vector:
    axes = matrix(q)
    return times(axes, times(sim.inertia, times_transposed(axes, w)))


@_named("constant-acceleration")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    more = tuple(_vector(claim))
    yield lambda sim: _law(sim, lambda x, q, v, w: (scale(sim.mass, more), ZERO))


@_named("gravity-added")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    yield lambda sim: setattr(sim, "gravity", sim.vector(G * _direction(claim)))


@_named("gravity-along-wrong-axis")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    size = float(np.linalg.norm(case.scene.gravity))
    yield lambda sim: setattr(sim, "gravity", sim.vector(size * _direction(claim)))


@_named("pybullet-default-damping")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    def law(sim: Simulation, x: Vector, q: Quaternion, v: Vector, w: Vector) -> Load:
        by_w = -BULLET * (1 + norm(w))
        return scale(-BULLET * (1 + norm(v)) * sim.mass, v), scale(by_w, _inertia_times(sim, q, w))

    yield lambda sim: _law(sim, partial(law, sim))


@_named("quadratic-angular-drag")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    rate = claim.number("rate") or 0.0

    def law(sim: Simulation, x: Vector, q: Quaternion, v: Vector, w: Vector) -> Load:
        return ZERO, scale(-rate * norm(w), _inertia_times(sim, q, w))

    yield lambda sim: _law(sim, partial(law, sim))


@_named("drag-torque")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    rate = claim.number("rate") or 0.0
    yield lambda sim: _law(sim, lambda x, q, v, w: (ZERO, scale(-rate, w)))


@_named(*(f"linear-damping-along-{axis}" for axis in "xyz"))
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    rate, one = claim.number("rate") or 0.0, np.eye(3)["xyz".index(claim.name[-1])]
    yield lambda sim: _law(sim, lambda x, q, v, w: (tuple(-rate * sim.mass * one * v), ZERO))


@_named(*(f"angular-damping-about-{frame}-{axis}" for frame in ("world", "body") for axis in "xyz"))
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    rate, one = claim.number("rate") or 0.0, np.eye(3)["xyz".index(claim.name[-1])]

    def law(sim: Simulation, x: Vector, q: Quaternion, v: Vector, w: Vector) -> Load:
        axes = np.array(matrix(q))
        slower = -rate * (one * w if "world" in claim.name else axes @ (one * (axes.T @ np.array(w))))
        return ZERO, _inertia_times(sim, q, tuple(slower))

    yield lambda sim: _law(sim, partial(law, sim))


@_named("linear-damping-reversed")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    rate = claim.number("rate") or 0.0
    yield lambda sim: _law(sim, lambda x, q, v, w: (scale(rate * sim.mass, v), ZERO))


@_named("angular-damping-reversed")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    rate = claim.number("rate") or 0.0
    yield lambda sim: _law(sim, lambda x, q, v, w: (ZERO, scale(rate, _inertia_times(sim, q, w))))


@_named("dry-friction")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    rate = claim.number("rate") or 0.0
    yield lambda sim: _law(sim, lambda x, q, v, w: (scale(-rate * sim.mass, _unit(v)), ZERO))


@_named("dry-angular-friction")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    rate = claim.number("rate") or 0.0
    yield lambda sim: _law(sim, lambda x, q, v, w: (ZERO, scale(-rate, _inertia_times(sim, q, _unit(w)))))


def _unit(a: Vector) -> Vector:
    """Return a / |a|, and 0 of 0."""
    size = norm(a)
    return scale(1 / size, a) if size else ZERO


@_named("cubic-drag")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    rate = claim.number("rate") or 0.0
    yield lambda sim: _law(sim, lambda x, q, v, w: (scale(-rate * sim.mass * norm(v) ** 2, v), ZERO))


@_named("quadratic-drag-by-component")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    rate = claim.number("rate") or 0.0
    yield lambda sim: _law(sim, lambda x, q, v, w: (tuple(-rate * sim.mass * abs(part) * part for part in v), ZERO))


@_named("velocity-in-body-axes-without-correction")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    """The velocity rotates with the body, as an acceleration w x v has it; steps in body axes take w x v away again."""
    yield lambda sim: _law(sim, lambda x, q, v, w: (scale(sim.mass, cross(w, v)), ZERO))


@_named("speed-cap-of-components")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    most = claim.number("rate") or 0.0
    yield lambda sim: sim.limits.append(lambda v, w: (_clipped(v, most), w))


@_named("spin-cap-of-components")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    most = claim.number("rate") or 0.0
    yield lambda sim: sim.limits.append(lambda v, w: (v, _clipped(w, most)))


def _clipped(a: Vector, most: float) -> Vector:
    return tuple(max(-most, min(most, part)) for part in a)  # type: ignore[return-value]


# --- impulses


@_named("impulses-normalised")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    yield lambda sim: setattr(
        sim, "value", lambda impulse: sim.vector(impulse.value / float(np.linalg.norm(impulse.value)))
    )


@_named("impulse-as-force", "impulse-as-force-over-one-step", "impulse-as-permanent-force")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    over = claim.number("time") or 1.0
    if not case.scene.impulses:
        pushed = case.scene.v / over
        yield lambda sim: (_set(v=np.zeros(3))(sim), setattr(sim, "gravity", add(sim.gravity, tuple(pushed))))[-1]
        return
    ends = claim.name != "impulse-as-permanent-force"
    for motion in ("point", "place", "torque"):
        yield partial(_lasting, over=over, ends=ends, motion=motion)


@_named("impulse-linear-part-as-force")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    yield partial(_lasting, over=claim.number("time") or 1.0, ends=True, motion="at once")


def _lasting(sim: Simulation, over: float, ends: bool, motion: str) -> None:
    """Have impulses act as forces: at a point of the body, at a place, with one torque, or only on the centre."""

    def strike(impulse: Impulse) -> None:
        force, arm = scale(1 / over, sim.value(impulse)), sim.lever(impulse)
        inside, place = times_transposed(matrix(sim.q), arm), add(sim.x, arm)
        until = impulse.time + over - 1e-6 * sim.dt if ends else np.inf
        if motion == "at once":
            sim.w = add(sim.w, sim.from_torque(sim.q, cross(arm, sim.value(impulse))))

        def law(x: Vector, q: Quaternion, v: Vector, w: Vector) -> Load:
            if sim.now >= until:
                return ZERO, ZERO
            arms = {"point": times(matrix(q), inside), "place": minus(place, x), "torque": arm, "at once": ZERO}
            return force, cross(arms[motion], force)

        sim.laws.append(law)

    sim.strike = strike  # type: ignore[method-assign]
    if ends and isinstance(sim, Exact):
        sim.instants += [impulse.time + over for impulse in sim.impulses]


@_named("impulse-lever-from-start-position")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    def plant(sim: Simulation) -> None:
        right, first = sim.lever, sim.x
        sim.lever = lambda impulse: minus(add(right(impulse), sim.x), first)  # type: ignore[method-assign]

    yield plant


@_named("impulse-at-wrong-vertex")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    yield partial(_of_kind, label="impulse at another vertex", params={"vertex": _number(claim)})


@_named("impulse-inertia-frozen-at-start", "impulse-inertia-rotated-inversely")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    def plant(sim: Simulation) -> None:
        def push(J: Vector, arm: Vector) -> None:
            axes = sim.first if "frozen" in claim.name else transposed(matrix(sim.q))
            spin = times(axes, times(sim.inverse, times_transposed(axes, cross(arm, J))))
            sim.v, sim.w = along(sim.v, 1 / sim.mass, J), add(sim.w, spin)

        sim.push = push  # type: ignore[method-assign]

    yield plant


@_named("impulse-multiplied-by-inertia", "impulse-spin-in-body-axes", "impulse-sets-velocity")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    def plant(sim: Simulation) -> None:
        def push(J: Vector, arm: Vector) -> None:
            twist = cross(arm, J)
            if claim.name == "impulse-sets-velocity":
                sim.v, sim.w = scale(1 / sim.mass, J), sim.from_torque(sim.q, twist)
                return
            inside = times_transposed(matrix(sim.q), twist)
            spin = times(sim.inverse, inside)
            if claim.name == "impulse-multiplied-by-inertia":
                spin = times(matrix(sim.q), times(sim.inertia, inside))
            sim.v, sim.w = along(sim.v, 1 / sim.mass, J), add(sim.w, spin)

        sim.push = push  # type: ignore[method-assign]

    yield plant


@_named("impulse-torque-of-mixed-axes")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    """A point in body axes and an impulse in world axes make a torque in body axes; a point in the world is right."""

    def plant(sim: Simulation) -> None:
        right = sim.lever

        def lever(impulse: Impulse) -> Vector:
            at = sim.scene.body_point(impulse)
            return right(impulse) if at is None else sim.vector(at)

        def push(J: Vector, arm: Vector) -> None:
            spin = times(matrix(sim.q), times(sim.inverse, cross(arm, J)))
            sim.v, sim.w = along(sim.v, 1 / sim.mass, J), add(sim.w, spin)

        sim.lever, sim.push = lever, push  # type: ignore[method-assign]

    yield plant


@_named("impulse-rotated-to-body-axes")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    def plant(sim: Simulation) -> None:
        right = sim.value
        sim.value = lambda impulse: times_transposed(matrix(sim.q), right(impulse))  # type: ignore[method-assign]

    yield plant


@_named("impulses-late", "impulses-repeated")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    late = claim.number("time") or 0.0

    def plant(sim: Simulation) -> None:
        more = [replace(impulse, time=impulse.time + late) for impulse in sim.impulses]
        sim.impulses = more if claim.name == "impulses-late" else sim.impulses + more

    yield plant


@_named("impulse-component-reversed")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    signs = 1 - 2 * np.eye(3)["xyz".index(claim.parameters["choice"])]

    def plant(sim: Simulation, which: int) -> None:
        one = sim.impulses[which]
        sim.impulses[which] = replace(one, value=signs * one.value)

    yield from (partial(plant, which=which) for which in range(len(case.scene.impulses)))


@_named("impulse-at-wrong-time")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    late = claim.number("time") or 0.0

    def plant(sim: Simulation, which: int) -> None:
        one = sim.impulses[which]
        sim.impulses[which] = replace(one, time=one.time + late)

    yield from (partial(plant, which=which) for which in range(len(case.scene.impulses)))


def _of_one(claim: Claim, case: Case) -> list[Plant]:
    """Return what a claim about one of several impulses may do: for each of them."""
    name = claim.name.removeprefix("one-")
    if name == "impulse-wrong-magnitude":
        label, params = "impulse of another size", {"factor": claim.number("factor")}
    elif name == "impulse-at-wrong-vertex":
        label, params = "impulse at another vertex", {"vertex": _number(claim)}
    elif name in BACK:
        label, params = BACK[name][0], {}
    else:
        return []

    def plant(sim: Simulation, which: int) -> None:
        chosen = sim.impulses[which]
        if name == "impulse-missing":
            sim.impulses.remove(chosen)
            return
        right = {how: getattr(sim, how) for how in ("value", "lever")}
        KINDS[label].plant(sim, **params)
        wrong = {how: getattr(sim, how) for how in right}
        for how in right:
            setattr(sim, how, lambda impulse, how=how: (wrong if impulse is chosen else right)[how](impulse))

    return [partial(plant, which=which) for which in range(len(case.scene.impulses))]


def _number(claim: Claim) -> int:
    """Return the number of a vertex, as in `vertex 3`."""
    return int(claim.parameters["choice"].split()[-1])


# --- the body


def _order(claim: Claim) -> list[int]:
    return ["xyz".index(axis) for axis in claim.parameters["choice"].split()]


@_named("angular-velocity-in-wrong-frame")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    """Yield Q w~ of w in world axes, and w~ Q of w in body axes."""
    yield lambda sim: setattr(sim, "turn_rate", lambda q, w: times(matrix(q), w))
    yield lambda sim: setattr(sim, "turn_rate", lambda q, w: times_transposed(matrix(q), w))


@_named("quaternion-rate-reversed")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    yield lambda sim: setattr(sim, "turn_rate", lambda q, w: scale(-1, w))


# Rotations body to world that a program takes for the right one.
WRONG_TURNS: dict[str, Callable[[Simulation, Quaternion], Matrix]] = {
    "not-rotated": lambda sim, q: sim.tensor(np.eye(3)),
    "frozen-at-start": lambda sim, q: sim.first,
    "rotated-inversely": lambda sim, q: transposed(matrix(q)),
}


@_named(*(f"gyroscopic-inertia-{how}" for how in WRONG_TURNS))
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    """The tensor of Euler's equations alone: impulses have the right one."""
    axes = WRONG_TURNS[claim.name.removeprefix("gyroscopic-inertia-")]

    def plant(sim: Simulation) -> None:
        _right_push(sim)
        sim.tensor_axes = sim.inverse_axes = partial(axes, sim)

    yield plant


# What a torque in world axes does to w, from the rotation, the tensor and its inverse.
WRONG_RESPONSES: dict[str, Callable[[Matrix, Matrix, Matrix, Vector], Vector]] = {
    "gyroscopic-torque-divided-in-wrong-axes": lambda axes, tensor, inverse, torque: times(inverse, torque),
    "gyroscopic-rate-in-body-axes": lambda axes, tensor, inverse, torque: times(
        inverse, times_transposed(axes, torque)
    ),
    "gyroscopic-torque-not-divided": lambda axes, tensor, inverse, torque: torque,
    "gyroscopic-torque-multiplied": lambda axes, tensor, inverse, torque: times(
        axes, times(tensor, times_transposed(axes, torque))
    ),
}


@_named(*WRONG_RESPONSES)
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    """All torques but those of impulses are divided so."""
    response = WRONG_RESPONSES[claim.name]

    def plant(sim: Simulation) -> None:
        _right_push(sim)
        sim.from_torque = lambda q, torque: response(matrix(q), sim.inertia, sim.inverse, torque)  # type: ignore[method-assign]
        sim.spin = lambda q, w, dt: along(w, dt, sim.euler(q, w, ZERO))  # type: ignore[method-assign]

    yield plant


def _right_push(sim: Simulation) -> None:
    """Have impulses be divided by the right tensor, whatever other torques are divided by."""

    def push(J: Vector, arm: Vector) -> None:
        axes = matrix(sim.q)
        spin = times(axes, times(sim.inverse, times_transposed(axes, cross(arm, J))))
        sim.v, sim.w = along(sim.v, 1 / sim.mass, J), add(sim.w, spin)

    sim.push = push  # type: ignore[method-assign]


@_named("inertia-axes-permuted")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    """Yield the moments about the file's axes where these are principal; else about axes in any order."""
    tensor = case.scene.inertia
    moments, axes = np.linalg.eigh(tensor)
    if np.abs(tensor - np.diag(np.diag(tensor))).max() < 1e-9 * moments[-1]:
        moments, axes = np.diag(tensor), np.eye(3)
    for order in (
        ([0, 1, 2], [1, 2, 0], [2, 0, 1], [1, 0, 2], [0, 2, 1], [2, 1, 0]) if axes[0, 0] != 1 else ([0, 1, 2],)
    ):
        m, a = moments[order], axes[:, order]
        yield lambda sim, m=m, a=a: sim.set_inertia(a @ np.diag(m[_order(claim)]) @ a.T)


@_named("edges-permuted")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    if case.scene.size is not None:
        yield partial(resize, size=case.scene.size[_order(claim)])


@_named("wrong-body-size", *(f"wrong-body-size-along-{axis}" for axis in "xyz"))
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    factor = claim.number("factor") or 1.0
    which = np.ones(3) if claim.name[-1] not in "xyz" else np.eye(3)["xyz".index(claim.name[-1])]
    if case.scene.size is not None:
        yield partial(resize, size=case.scene.size * factor**which)


# --- the clock


@_named("clock-offset")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    yield lambda sim: setattr(sim, "ahead", sim.ahead + (claim.number("time") or 0.0))


@_named("log-lag")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    late = claim.number("time") or 0.0
    yield lambda sim: setattr(sim, "ahead", sim.ahead - late)
    yield lambda sim: setattr(sim, "ahead", sim.ahead + late)
    if any(impulse.time > 0 for impulse in case.scene.impulses):

        def asleep(sim: Simulation) -> None:
            """The body does not move at first, and impulses act when the file's clock shows their times."""
            sim.ahead -= late
            sim.impulses = [replace(impulse, time=max(0.0, impulse.time - late)) for impulse in sim.impulses]

        yield asleep


@_named("clock-rate")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    """Yield that steps are longer than the file's times by a factor."""
    rate = claim.number("factor") or 1.0

    def plant(sim: Simulation) -> None:
        if isinstance(sim, Exact):
            sim.rate *= rate
        else:
            KINDS["clock rate"].plant(sim, rate=rate)

    def by_impulses(sim: Simulation) -> None:
        """The file's clock shows the times of impulses when they act."""
        plant(sim)
        sim.impulses = [replace(impulse, time=rate * impulse.time) for impulse in sim.impulses]

    yield plant
    if any(impulse.time > 0 for impulse in case.scene.impulses):
        yield by_impulses


@_named("body-stops", "body-never-moves")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    instant = claim.number("time") or 0.0

    def plant(sim: Simulation) -> None:
        if isinstance(sim, Exact):
            sim.stop = instant
        else:
            KINDS["stops"].plant(sim, time=instant)

    yield plant


# --- what is written


def _rewritten(change: Callable[[Rows], Rows]) -> Plant:
    return lambda sim: sim.rewrites.append(change)


@_named("wrong-axes", "left-handed-axes")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    names = _axes(claim)
    yield _rewritten(lambda rows: replace(with_axes(rows, names @ rows.axes @ names.T), x=rows.x @ names.T))
    if case.dialect.kind == VERTICES:
        yield _rewritten(lambda rows: replace(rows, own_axes=names @ rows.axes, x=rows.x @ names.T))


@_named("position-only-in-wrong-axes")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    yield _rewritten(lambda rows: replace(rows, x=rows.x @ _axes(claim).T))


@_named("attitude-only-in-wrong-axes")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    names = _axes(claim)
    yield _rewritten(lambda rows: with_axes(rows, names @ rows.axes @ names.T))


@_named("wrong-body-axes")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    if case.dialect.kind == VERTICES:
        yield _rewritten(lambda rows: replace(rows, own_axes=rows.axes @ _axes(claim)))
    else:
        yield _rewritten(lambda rows: with_axes(rows, rows.axes @ _axes(claim)))


@_named("quaternion-vector-mirrored")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    yield _rewritten(lambda rows: with_q(rows, np.column_stack((rows.q[:, 0], rows.q[:, 1:] @ _axes(claim).T))))


@_named("constant-offset-in-body-axes")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    yield _at_point(_vector(claim))


@_named("wrong-point-logged")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    what = claim.parameters["choice"]
    if what.startswith("vertex"):
        yield _at_point(case.scene.points[_number(claim)])
    elif case.scene.size is not None:
        yield _at_point(0.5 * case.scene.size * _direction(claim))


def _at_point(point: np.ndarray) -> Plant:
    return _rewritten(lambda rows: replace(rows, x=rows.x + rows.axes @ point))


@_named("wrong-length-unit")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    size = UNITS[claim.parameters["choice"]]
    yield _rewritten(lambda rows: replace(rows, x=size * rows.x))
    if case.dialect.kind == VERTICES:
        yield _rewritten(lambda rows: replace(rows, x=size * rows.x, own_axes=size * rows.axes))


@_named("rotating-axes")
def _(claim: Claim, case: Case) -> Iterator[Plant]:
    turn = (claim.number("rate") or 0.0) * case.scene.duration
    for axis in range(3):
        yield partial(_of_kind, label="turning axes", params={"axis": axis, "turn": turn})
