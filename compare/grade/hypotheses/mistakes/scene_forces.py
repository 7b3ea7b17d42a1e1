"""Mistakes with the forces that the scene has, drag, tethers and a floor: their coefficients, and other laws."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from tumble.compare.grade.hypotheses.hypothesis import Context, Hypothesis, choice, grid
from tumble.compare.grade.model.kernel.dynamics import AS_AT_THE_START, FROM_ORIGIN, NO_LEVER, NOT_TURNED
from tumble.compare.grade.model.program_model import NO_STRENGTH, ProgramModel, scaled_force
from tumble.scenarios.forces import DRAG, GRAVITY, TETHER, Law, acting, stiffness, takes_energy
from tumble.scenarios.frames import Array, vertices
from tumble.scenarios.scene import Scene
from tumble.solver.forces import gives_torque

# Factors on a coefficient that are tried: a much stiffer spring takes long to simulate.
FACTORS = grid(0.1, 10.0, 9)
USUAL_FACTORS = {0.5: "half", 2.0: "double"}
# First digits of thresholds that people choose, and powers of ten.
PLAIN, POWERS = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0), range(-3, 3)
# A speed that falls below this share of its largest value can fall below a threshold.
MUCH_SLOWER = 0.5
POINT, ANCHOR, REST_LENGTH = slice(0, 3), slice(3, 6), 8


def scene_forces(context: Context) -> Iterator[Hypothesis]:
    """Yield mistakes with the forces that the scene has, besides gravity."""
    for law in acting(context.scene):
        if law is not GRAVITY:
            yield from _left_out(law, context.scene)
            yield from _coefficients(law, context)
    if DRAG in acting(context.scene):
        yield from _drag(context)
    if TETHER in acting(context.scene):
        yield from _tethers(context)
    if takes_energy(context.scene):
        yield from _thresholds(context)


def _left_out(law: Law, scene: Scene) -> Iterator[Hypothesis]:
    """Yield that a force is missing; it keeps no strength, so that no kernel is compiled for it."""
    rest = scaled_force(law, scene, NO_STRENGTH)
    yield Hypothesis(
        f"{law.name.replace(' ', '-')}-missing",
        law.name,
        f"{law.name} missing",
        lambda program, _, part=law.part, rest=rest: program.but(forces=program.forces._replace(**{part: rest})),
    )


def turns_by_drag_only(context: Context) -> bool:
    """Return whether angular drag gives the only torque: half of it then moves the body as twice the inertia does."""
    program = context.program
    is_only = not program.impulses and not gives_torque(program.forces._replace(drag=None), turning=True)
    return is_only and gives_torque(program.forces, turning=True)


def _coefficients(law: Law, context: Context) -> Iterator[Hypothesis]:
    """Yield that a coefficient of a force, or all of them, has another value, is missing, or has the wrong sign."""
    scene = context.scene
    keys = {label.partition(" [")[0]: (key,) for label, key in law.numbers.items()}
    keys = {label: key for label, key in keys.items() if any(getattr(one, *key) for one in law.all_of(scene))}
    for label, key in keys.items():
        scaled = _scaling(law, scene, *key)
        name = label.replace(" ", "-")
        factors = {**_of_mass(scene.body.mass), **USUAL_FACTORS}
        more = ""
        if law is DRAG and key == ("angular",) and turns_by_drag_only(context):
            factors, more = {**_of_inertia(scene), **USUAL_FACTORS}, ", or the inertia divided by that"
        yield _with_factor(f"{name}-wrong-magnitude", label, label, scaled, factors, more)
        if len(keys) > 1:
            yield Hypothesis(f"{name}-missing", label, f"{label} missing", lambda p, _, s=scaled: s(p, NO_STRENGTH))
        yield Hypothesis(
            f"{name}-reversed", label, f"{label} with the wrong sign", lambda p, _, scaled=scaled: scaled(p, -1.0)
        )
    if law is DRAG and len(keys) > 1:
        every = " and ".join(label.removeprefix(law.name + " ") for label in keys)
        scaled = _scaling(law, scene, *(key for (key,) in keys.values()))
        factors = {**_of_mass(scene.body.mass), **USUAL_FACTORS}
        yield _with_factor(f"{law.name}-wrong-magnitude", law.name, every, scaled, factors)


def _of_mass(mass: float) -> dict[float, str]:
    """Return the factors on a coefficient of a force that a mistake with the mass [kg] gives."""
    return {mass: "not divided by the mass", 1 / mass: "divided by the mass twice"} if mass != 1 else {}


def _of_inertia(scene: Scene) -> dict[float, str]:
    """Return the factors on a torque that a mistake with the inertia gives."""
    mass = scene.body.mass
    found = {4.0: "inertia of half edges used as edges", 0.25: "inertia of edges used as half edges"}
    return ({mass: "mass left out of the inertia"} if mass != 1 else {}) | found


def _with_factor(
    name: str, part: str, what: str, scaled: "Scaling", factors: dict[float, str], more: str = ""
) -> Hypothesis:
    """Return that coefficients are times a factor, which may be one with a name."""
    text = f"{what} {{}} times the scene's{more}"
    tried = tuple(sorted({*FACTORS, *factors}))
    return Hypothesis(name, part, text, scaled, tried, named_values=factors, neutral=1.0)


Scaling = Callable[[ProgramModel, Any], ProgramModel]


def _scaling(law: Law, scene: Scene, *keys: str) -> Scaling:
    """Return what multiplies coefficients of a force in a program by a factor."""
    once, twice = (scaled_force(law, scene, by, *keys) for by in (1.0, 2.0))
    is_spring = stiffness(law.scaled(scene, 2.0, *keys)) > stiffness(scene)
    if isinstance(once, np.ndarray):
        is_scaled = once != twice
    else:
        is_scaled = np.array([one != two for one, two in zip(once, twice, strict=True)])

    def scaled(program: ProgramModel, factor: float) -> ProgramModel:
        numbers, found = getattr(program.forces, law.part), None
        if isinstance(numbers, np.ndarray):
            found = np.where(is_scaled, factor * numbers, numbers)
        else:
            found = tuple(
                factor * number if number is not None and by else number
                for number, by in zip(numbers, is_scaled, strict=True)
            )
        return program.but(
            forces=program.forces._replace(**{law.part: found}),
            stiffness=program.stiffness * (max(1.0, abs(factor)) if is_spring else 1.0),
        )

    return scaled


def _drag(context: Context) -> Iterator[Hypothesis]:
    """Yield another law of drag in the place of the scene's, with its coefficients."""
    drag = context.scene.drag
    assert drag is not None
    for is_there, number, name, part, text in (
        (drag.linear, 0, "drag-quadratic", "linear drag", "linear drag -c |v| v instead of -c v, with the scene's c"),
        (
            drag.angular,
            1,
            "angular-drag-quadratic",
            "angular drag",
            "angular drag -c |w| w instead of -c w, with the scene's c",
        ),
        (
            drag.angular,
            2,
            "angular-drag-not-divided-by-inertia",
            "angular drag",
            "angular drag not divided by the inertia: w' = -c w",
        ),
    ):
        if is_there:
            yield Hypothesis(
                name,
                f"law of {part}",
                text,
                lambda program, _, number=number: program.but(
                    drag_law=tuple(place == number or other for place, other in enumerate(program.drag_law))
                ),
            )


def _tethers(context: Context) -> Iterator[Hypothesis]:
    """Yield another law of the scene's tethers, and other points."""
    scene = context.scene
    has_lever = any(tether.point_body.any() for tether in scene.tethers)
    has_damper = any(tether.damping for tether in scene.tethers)
    has_length = any(tether.rest_length for tether in scene.tethers)
    yield from _levers() if has_lever else ()
    if has_damper:
        if has_lever:
            yield _with_law(
                "tether-damps-centre",
                "tether damper",
                "tether's damper with the velocity of the centre of mass instead of the attachment's",
                damps_centre=True,
            )
        along, whole = "the whole velocity of its end", "the velocity along the line only"
        if all(bool(tether.rest_length) == has_length for tether in scene.tethers):
            yield _with_law(
                "tether-damper-direction",
                "tether damper",
                f"tether's damper with {along if has_length else whole}",
                other_damper=True,
            )
    if has_length:
        yield _with_row("tether-rest-length-missing", "tether rest length", "tether's rest length missing", _slack)
        yield _with_law(
            "tether-pulls-only", "tether force", "tether that does not push where it is slack", pulls_only=True
        )
    mass = float(scene.body.mass)
    if mass != 1:
        yield _with_law(
            "tether-not-divided-by-mass", "tether force", "tether's force not divided by the mass: v' = F", moves=mass
        )
    yield from _lengths(context)
    yield from _points(context)


def _levers() -> Iterator[Hypothesis]:
    """Yield that the point where a tether acts, or only the lever of its torque, is another one."""
    for name, part, text, changes in (
        (
            "tether-torque-missing",
            "tether torque",
            "tether's torque missing: its force acts at the centre of mass",
            {"torque_lever": NO_LEVER},
        ),
        (
            "tether-lever-not-rotated",
            "tether torque",
            "lever of the tether's torque in body axes, not rotated with the body",
            {"torque_lever": NOT_TURNED},
        ),
        (
            "tether-lever-from-origin",
            "tether torque",
            "lever of the tether's torque from the world's origin",
            {"torque_lever": FROM_ORIGIN},
        ),
        (
            "tether-point-not-rotated",
            "tether point",
            "tether's attachment in body axes, not rotated with the body",
            {"lever": NOT_TURNED, "torque_lever": NOT_TURNED},
        ),
        (
            "tether-point-from-start-attitude",
            "tether point",
            "tether's attachment rotated as at the start",
            {"lever": AS_AT_THE_START, "torque_lever": AS_AT_THE_START},
        ),
    ):
        yield _with_law(name, part, text, **changes)
    yield _with_row(
        "tether-at-centre-of-mass",
        "tether point",
        "tether attached at the centre of mass",
        lambda rows, program: _set(rows, POINT, 0.0),
    )


def _points(context: Context) -> Iterator[Hypothesis]:
    """Yield another anchor, or another vertex where a tether is attached."""
    scene = context.scene
    anchors = np.array([tether.anchor for tether in scene.tethers])
    if anchors.any():
        yield _with_row(
            "tether-anchor-at-origin",
            "tether anchor",
            "tether's anchor at the world's origin",
            lambda rows, program: _set(rows, ANCHOR, 0.0),
        )
    if context.program.start[0:3].any():
        yield _with_row(
            "tether-anchor-from-start",
            "tether anchor",
            "tether's anchor measured from the start position",
            lambda rows, program: _set(rows, ANCHOR, rows[:, ANCHOR] + program.start[0:3]),
        )
    points = scene.body.points
    (first, *others) = scene.tethers
    if not others and (points == first.point_body).all(axis=1).any():
        free = [number for number, point in enumerate(points) if (point != first.point_body).any()]
        yield Hypothesis(
            "tether-at-wrong-vertex",
            "tether point",
            "tether attached at {}",
            lambda program, number: _changed(program, lambda rows, _: _set(rows, POINT, points[free[int(number)]])),
            choice(len(free)),
            tuple(f"vertex {number}" for number in free),
        )


def _lengths(context: Context) -> Iterator[Hypothesis]:
    """Yield that tethers are relaxed at the start, as joints of engines are by default."""
    has_damper = any(tether.damping for tether in context.scene.tethers)
    for is_along in (True, False) if has_damper else (True,):
        where = ", damped along the line" if is_along else ", the whole velocity of its end damped"

        def change(program: ProgramModel, _: float, is_along: bool = is_along) -> ProgramModel:
            relaxed = _changed(program, _relaxed)
            return relaxed.but(tether_law=relaxed.tether_law._replace(other_damper=not is_along))

        yield Hypothesis(
            "tether-relaxed-at-start",
            "tether rest length",
            f"tether's rest length is its length at the start{where if has_damper else ''}",
            change,
        )


def _with_law(name: str, part: str, text: str, **changes: Any) -> Hypothesis:
    """Return that a program computes the tethers otherwise."""
    return Hypothesis(
        name, part, text, lambda program, _: program.but(tether_law=program.tether_law._replace(**changes))
    )


# Returns other rows of tethers, as in `solver.forces`, of a program.
Rows = Callable[[Array, ProgramModel], Array]


def _with_row(name: str, part: str, text: str, change: Rows) -> Hypothesis:
    """Return that the tethers of a program have other numbers."""
    return Hypothesis(name, part, text, lambda program, _: _changed(program, change))


def _changed(program: ProgramModel, change: Rows) -> ProgramModel:
    assert program.forces.tethers is not None
    return program.but(forces=program.forces._replace(tethers=change(program.forces.tethers.copy(), program)))


def _set(rows: Array, columns: Any, value: Any) -> Array:
    rows[:, columns] = value
    return rows


def _slack(rows: Array, program: ProgramModel) -> Array:
    return _set(rows, REST_LENGTH, 0.0)


def _relaxed(rows: Array, program: ProgramModel) -> Array:
    ends = vertices(program.start, rows[:, POINT])
    return _set(rows, REST_LENGTH, np.linalg.norm(ends - rows[:, ANCHOR], axis=1))


def _thresholds(context: Context) -> Iterator[Hypothesis]:
    """Yield that a slow body is put to rest, below a threshold that a person chose."""
    for name, what, place, unit in (
        ("speed-threshold", "velocity", 0, "m/s"),
        ("spin-threshold", "angular velocity", 1, "rad/s"),
    ):
        speeds = context.speeds[place]
        least, most = float(speeds.min()), float(speeds.max())
        chosen = [digit * 10.0**power for power in POWERS for digit in PLAIN]
        thresholds = tuple(value for value in chosen if least < value < most)
        if thresholds and least < MUCH_SLOWER * most:
            yield Hypothesis(
                name,
                name.replace("-", " "),
                f"{what} set to 0 below {{}} {unit}",
                lambda program, value, place=place: program.but(
                    thresholds=(program.thresholds[0], value) if place else (value, program.thresholds[1])
                ),
                thresholds,
                only_named=True,
                named_values=dict.fromkeys(thresholds, ""),
                unit=unit,
            )
