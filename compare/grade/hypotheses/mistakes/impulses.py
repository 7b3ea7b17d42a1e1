"""Mistakes with impulses, all of them or one of several: duration, lever, strength, time."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from tumble.compare.grade.hypotheses.hypothesis import STEPS, Context, Hypothesis, choice, grid
from tumble.compare.grade.hypotheses.names import IMPULSE_OVER_ONE_STEP
from tumble.compare.grade.model.kernel.dynamics import (
    AS_AT_THE_START,
    AXES_OF_BODY,
    AXES_TURNED_BACK,
    MULTIPLIED,
    NOT_TURNED,
    OVER_MASS,
    OVER_MEAN,
    POINT_MOVES,
    POINT_STAYS,
    RESPONSE_UNTURNED,
    TORQUE_STAYS,
    TORQUE_UNTURNED,
    UNDIVIDED,
)
from tumble.compare.grade.model.program_model import FINE, ProgramModel
from tumble.scenarios.frames import Array, rotation_matrix
from tumble.scenarios.scene import Impulse

# Bodies with more vertices are meshes, whose vertices are not confused with one another.
MOST_VERTICES = 27
# Weight that it costs to assume that one of several impulses is wrong, where all may be.
UNLIKELY_ALONE = 1.0
N_S_AS_N = {1.0: "N s read as N"}
GRAMS = {1e3: "kg read as g", 1e-3: "g read as kg"}
# Motion of the point where a lasting force acts.
LEVER_MOTIONS = {
    POINT_MOVES: "",
    POINT_STAYS: " at a point fixed in the world",
    TORQUE_STAYS: " with a constant torque",
}

# Mistakes that all impulses may have, or only one of several: name, text, and how all of them are applied.
STRENGTHS = (("missing", "{} missing", 0.0), ("doubled", "{} applied twice", 2.0), ("reversed", "{} reversed", -1.0))
LEVERS: Mapping[str, tuple[str, dict[str, Any]]] = {
    "at-centre-of-mass": ("{} applied at the centre of mass, without a torque", {"lever": (0.0, 0.0, 0.0, 0.0, 0.0)}),
    "lever-from-origin": (
        "lever of {} measured from the origin, not from the centre of mass",
        {"lever": (1.0, 0.0, 0.0, 0.0, 0.0)},
    ),
    "lever-reversed": ("torque of {} reversed, F x r", {"lever": (-1.0, 1.0, 0.0, 0.0, 0.0)}),
    "lever-not-rotated": ("lever of {} in body axes, not rotated to the world", {"lever_axes": NOT_TURNED}),
    "lever-from-start-attitude": ("lever of {} rotated by the start attitude", {"lever_axes": AS_AT_THE_START}),
}
IN_BODY_AXES = ("in-body-axes", "{} taken in body axes")
AT_WRONG_VERTEX = ("at-wrong-vertex", "{} applied at {{}}")
WRONG_MAGNITUDE = ("wrong-magnitude", "{} {{}} times its value")


def impulses(context: Context) -> Iterator[Hypothesis]:
    """Yield mistakes with the impulses of a scene, or with the start velocity that one has left."""
    if context.program.impulses:
        yield from _lasting(context)
        yield from _levers(context)
        yield from _strengths(context)
        yield from _times(context)
        for number, impulse in enumerate(context.program.impulses):
            yield from _one_impulse(context, number, impulse)
    elif context.program.start[7:10].any():
        yield Hypothesis(
            "impulse-as-force",
            "impulse",
            "impulse applied as a permanent force: velocity grows from 0 by the start velocity in {} s",
            _accelerated_from_rest,
            grid(0.1 * context.duration, 10 * context.duration, 13),
            named_values=N_S_AS_N,
            unit="s",
        )


def _accelerated_from_rest(program: ProgramModel, seconds: float) -> ProgramModel:
    start = program.start.copy()
    start[7:10] = 0.0
    return program.but(start=start, gravity=program.gravity + program.start[7:10] / seconds)


def _lasting(context: Context) -> Iterator[Hypothesis]:
    """Yield that impulses act as forces."""
    left_s = context.duration - min(impulse.time for impulse in context.program.impulses)
    if left_s <= 0:
        return
    short, long = 2e-4 * left_s, 0.1 * left_s
    for motion, where in LEVER_MOTIONS.items():
        yield Hypothesis(
            "impulse-as-force",
            "impulse",
            f"impulse applied as a constant force over {{}} s{where}",
            lambda program, seconds, motion=motion: _applied(program, lasts=seconds, lever_motion=motion),
            grid(long, 2 * left_s, 13),
            named_values=N_S_AS_N,
            unit="s",
        )
        yield Hypothesis(
            "impulse-as-permanent-force",
            "impulse",
            f"impulse in N s applied as a permanent force in N{where}",
            lambda program, _, motion=motion: _applied(program, lasts=1.0, ends=False, lever_motion=motion),
        )
    for motion, where in LEVER_MOTIONS.items():
        yield Hypothesis(
            IMPULSE_OVER_ONE_STEP,
            "impulse",
            f"impulse applied as a force over a first step of {{}} s{where}: the motion lags by half a step",
            lambda program, seconds, motion=motion: _applied(program, lasts=seconds, lever_motion=motion),
            grid(short, long, 9),
            named_values=STEPS,
            unit="s",
        )
    yield Hypothesis(
        "impulse-linear-part-as-force",
        "impulse",
        "impulse applied to the centre of mass as a constant force over {} s, but to the rotation at once",
        lambda program, seconds: _applied(program, lasts=seconds, turns=False),
        grid(short, 2 * left_s, 15),
        named_values=N_S_AS_N,
        unit="s",
    )


def _levers(context: Context) -> Iterator[Hypothesis]:
    """Yield that impulses act at another point, or along other axes."""
    program, points = context.program, context.scene.body.points
    for name, (text, how) in LEVERS.items():
        yield Hypothesis(
            f"impulse-{name}",
            "lever",
            text.format("impulse"),
            lambda program, _, how=how: _applied(program, **how),
        )
    yield Hypothesis(
        "impulse-linear-part-missing",
        "strength",
        "impulse rotates the body but does not change the velocity of its centre of mass",
        lambda program, _: _applied(program, moves=0.0),
    )
    yield from _responses()
    yield Hypothesis(
        "impulse-sets-velocity",
        "added impulse",
        "impulse sets the velocity and the angular velocity, instead of being added to them",
        lambda program, _: _applied(program, sets=True),
    )
    if any(_differs_in_body_axes(impulse, program) for impulse in program.impulses):
        name, text = IN_BODY_AXES
        for name_of_all, text_of_all, axes in (
            (f"impulse-{name}", text.format("impulse"), AXES_OF_BODY),
            (
                "impulse-rotated-to-body-axes",
                "impulse rotated to body axes, R^T J, but used in world axes",
                AXES_TURNED_BACK,
            ),
        ):
            yield Hypothesis(
                name_of_all,
                "strength",
                text_of_all,
                lambda program, _, axes=axes: _applied(program, axes=axes),
            )
    if program.impulses[-1].time > 0:
        yield Hypothesis(
            "impulse-lever-from-start-position",
            "lever",
            "lever of the impulse measured from the start position of the centre of mass",
            lambda program, _: _applied(program, lever=(1.0, 0.0, *program.start[0:3].tolist())),
        )
    others = [number for number, point in enumerate(points) if not _all_at(program, point)]
    if len(points) <= MOST_VERTICES:
        name, text = AT_WRONG_VERTEX
        yield Hypothesis(
            f"impulse-{name}",
            "lever",
            text.format("impulse"),
            lambda program, number: _all_moved_to(program, points[others[int(number)]]),
            choice(len(others)),
            tuple(f"vertex {number}" for number in others),
        )


def _responses() -> Iterator[Hypothesis]:
    """Yield that the torque of an impulse, or its effect, is in other axes, or not divided by the inertia."""
    for name, text, tensor, how in (
        (
            "impulse-torque-in-body-axes",
            "torque of the impulse taken in body axes: I^-1 (r x J) without a rotation",
            TORQUE_UNTURNED,
            {},
        ),
        (
            "impulse-torque-of-mixed-axes",
            "torque of the impulse computed from its point in body axes and the impulse in world axes: R I^-1 (r x J)",
            TORQUE_UNTURNED,
            {"lever_axes": NOT_TURNED},
        ),
        (
            "impulse-spin-in-body-axes",
            "change of the angular velocity by the impulse in body axes, I^-1 R^T (r x J), added to w in world axes",
            RESPONSE_UNTURNED,
            {},
        ),
        (
            "impulse-not-divided-by-inertia",
            "torque of the impulse not divided by the inertia: w += r x J",
            UNDIVIDED,
            {},
        ),
        (
            "impulse-multiplied-by-inertia",
            "torque of the impulse multiplied by the inertia instead of divided: w += R I R^T (r x J)",
            MULTIPLIED,
            {},
        ),
        ("impulse-divided-by-mass", "torque of the impulse divided by the mass: w += r x J/m", OVER_MASS, {}),
        (
            "impulse-of-spherical-inertia",
            "torque of the impulse divided by the mean moment of inertia, that of a sphere",
            OVER_MEAN,
            {},
        ),
    ):
        yield Hypothesis(
            name,
            "lever",
            text,
            lambda program, _, tensor=tensor, how=how: _applied(program, **how).but(impulse_tensor=tensor),
        )


def _all_at(program: ProgramModel, point_body: Array) -> bool:
    places = (impulse.point_body for impulse in program.impulses)
    return all(place is not None and np.array_equal(place, point_body) for place in places)


def _all_moved_to(program: ProgramModel, point_body: Array) -> ProgramModel:
    moved = (replace(impulse, point_world=None, point_body=point_body) for impulse in program.impulses)
    return program.but(impulses=tuple(moved))


def _strengths(context: Context) -> Iterator[Hypothesis]:
    """Yield that impulses are of another strength, or the mass is."""
    for name, text, strength in STRENGTHS:
        yield Hypothesis(
            f"impulse-{name}",
            "strength",
            text.format("impulse"),
            lambda program, _, strength=strength: _applied(program, strength=strength),
        )
    mass = context.program.mass
    if mass != 1.0:
        yield Hypothesis(
            "mass-missing",
            "strength",
            "impulse not divided by the mass: v += J",
            lambda program, _: _applied(program, moves=program.mass),
        )
    sizes = {1e-3: GRAMS[1e3], 1e3: GRAMS[1e-3], 1 / mass: "1/m", mass: "m"}
    steps = {step: f"a step of {name}" for step, name in STEPS.items()}
    name, text = WRONG_MAGNITUDE
    yield Hypothesis(
        f"impulse-{name}",
        "strength",
        f"{text.format('impulse')}, or mass and inertia divided by that factor",
        lambda program, strength: _applied(program, strength=strength),
        grid(1e-4, 1e4, 49),
        named_values={size: name for size, name in (steps | sizes).items() if size != 1.0},
        neutral=1.0,
    )
    lengths = [float(np.linalg.norm(impulse.value)) for impulse in context.program.impulses]
    if len(lengths) > 1 and not np.allclose(lengths, lengths[0]):
        unit = tuple(
            replace(impulse, value=impulse.value / length)
            for impulse, length in zip(context.program.impulses, lengths, strict=True)
        )
        yield Hypothesis(
            "impulses-normalised",
            "strength",
            "impulses normalised to 1 N s",
            lambda program, _: program.but(impulses=unit),
        )
    yield Hypothesis(
        "wrong-mass",
        "mass",
        "impulse divided by {} times the mass in the scene, with the right inertia",
        lambda program, factor: _applied(program, moves=1.0 / factor),
        grid(1e-3, 1e3, 37),
        named_values=GRAMS,
        neutral=1.0,
    )


def _times(context: Context) -> Iterator[Hypothesis]:
    """Yield that all of several impulses are late, and that all act twice."""
    impulses, spacing = context.program.impulses, context.spacing_s
    late = (*(spacing * part for part in (0.02, 0.1, 0.25, 0.5, 1.0, 2.0, 3.0)), 0.05 * context.duration)
    kinds = [("impulses-repeated", "added impulse", "each impulse acts again {} s later", impulses)]
    if len(impulses) > 1:
        kinds.append(("impulses-late", "impulse time", "all impulses act {} s late", ()))
    for name, part, text, kept in kinds:
        yield Hypothesis(
            name,
            part,
            text,
            lambda program, seconds, kept=kept: program.but(
                impulses=_in_order((*kept, *(replace(each, time=each.time + seconds) for each in program.impulses)))
            ),
            late,
            named_values={spacing: "one row"} | {step: used for step, used in STEPS.items() if step < late[-1]},
            unit="s",
            at_ticks=True,
        )


def _in_order(impulses: Iterable[Impulse]) -> tuple[Impulse, ...]:
    return tuple(sorted(impulses, key=lambda impulse: impulse.time))


def _one_impulse(context: Context, number: int, impulse: Impulse) -> Iterator[Hypothesis]:
    """Yield mistakes with one of the impulses."""
    several = len(context.program.impulses) > 1
    which = f"impulse {number + 1}" if several else "the impulse"
    times = np.linspace(-impulse.time, context.duration - impulse.time, 25)
    yield Hypothesis(
        "impulse-at-wrong-time",
        "impulse time",
        f"{which} acts {{}} s after its time",
        lambda program, late: _changed(program, number, late=late),
        tuple(times.tolist()),
        named_values={step: name for step, name in STEPS.items() if step < times[-1]},
        unit="s",
        at_ticks=True,
        neutral=0.0,
    )
    signs = [axis for axis in range(3) if impulse.value[axis] != 0.0]
    yield Hypothesis(
        "impulse-component-reversed",
        "one impulse",
        f"{which} with the {{}} component reversed",
        lambda program, axis: _changed(program, number, value=impulse.value * (1 - 2 * np.eye(3)[signs[int(axis)]])),
        choice(len(signs)),
        tuple("xyz"[axis] for axis in signs),
    )
    if not several:
        return
    for name, text, factor in STRENGTHS:
        yield Hypothesis(
            f"one-impulse-{name}",
            "one impulse",
            text.format(which),
            lambda program, _, factor=factor: _changed(program, number, factor=factor),
            unlikely=UNLIKELY_ALONE,
        )
    name, text = WRONG_MAGNITUDE
    yield Hypothesis(
        f"one-impulse-{name}",
        "one impulse",
        text.format(which),
        lambda program, factor: _changed(program, number, factor=factor),
        grid(1e-3, 1e3, 25),
        unlikely=UNLIKELY_ALONE,
        neutral=1.0,
    )
    yield from _one_lever(context, number, impulse, which)


def _one_lever(context: Context, number: int, impulse: Impulse, which: str) -> Iterator[Hypothesis]:
    """Yield that one of the impulses acts at another point of the body, or along other axes."""
    program, points = context.program, context.scene.body.points
    row = program.simulate(np.array([impulse.time]), FINE)[0]  # an impulse does not change the pose
    x, axes = row[0:3], row[3:12].reshape(3, 3)
    at = axes.T @ (impulse.point_world - x) if impulse.point_body is None else impulse.point_body
    first, file_axes = rotation_matrix(program.start[3:7]), rotation_matrix(program.body.file_axes)
    for name, point in {
        "at-centre-of-mass": np.zeros(3),
        "lever-reversed": -at,
        "lever-not-rotated": axes.T @ file_axes.T @ at,
        "lever-from-start-attitude": axes.T @ first @ at,
        "lever-from-origin": at + axes.T @ x,
    }.items():
        if not np.allclose(point, at):
            yield Hypothesis(
                f"one-impulse-{name}",
                "one impulse",
                LEVERS[name][0].format(which),
                lambda program, _, point=point: _changed(program, number, point=point),
                unlikely=UNLIKELY_ALONE,
            )
    value = axes @ file_axes @ impulse.value
    if not np.allclose(value, impulse.value):
        name, text = IN_BODY_AXES
        yield Hypothesis(
            f"one-impulse-{name}",
            "one impulse",
            text.format(which),
            lambda program, _: _changed(program, number, value=value),
            unlikely=UNLIKELY_ALONE,
        )
    others = [k for k, point in enumerate(points) if not np.allclose(point, at)]
    if len(points) <= MOST_VERTICES:
        name, text = AT_WRONG_VERTEX
        yield Hypothesis(
            f"one-impulse-{name}",
            "one impulse",
            text.format(which),
            lambda program, k: _changed(program, number, point=points[others[int(k)]]),
            choice(len(others)),
            tuple(f"vertex {k}" for k in others),
            unlikely=UNLIKELY_ALONE,
        )


def _differs_in_body_axes(impulse: Impulse, program: ProgramModel) -> bool:
    """Whether an impulse in body axes would be a different one."""
    axes = program.simulate(np.array([impulse.time]))[0, 3:12].reshape(3, 3) @ rotation_matrix(program.body.file_axes)
    return not np.allclose(axes @ impulse.value, impulse.value)


def _applied(program: ProgramModel, **changes: object) -> ProgramModel:
    """Return the program with all impulses applied differently: fields of ImpulseApplication."""
    return program.but(application=program.application._replace(**changes))  # type: ignore[arg-type]


def _changed(
    program: ProgramModel,
    number: int,
    late: float = 0.0,
    factor: float = 1.0,
    point: Array | None = None,
    value: Array | None = None,
) -> ProgramModel:
    """Return the program with one impulse at another time, of another value, or at another point of the body."""
    impulses = list(program.impulses)
    old = impulses[number]
    new = replace(old, time=old.time + late, value=factor * (old.value if value is None else value))
    impulses[number] = new if point is None else replace(new, point_world=None, point_body=point)
    return program.but(impulses=_in_order(impulses))
