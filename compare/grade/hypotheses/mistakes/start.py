"""Mistakes with the start: not set, set in other axes, or different from the scene."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from tumble.compare.grade.hypotheses.explanation import Mistake, Mistakes
from tumble.compare.grade.hypotheses.hypothesis import Context, Hypothesis, choice
from tumble.compare.grade.hypotheses.mistakes.axes import axis_names, signed_permutations
from tumble.compare.grade.model.program_model import ProgramModel
from tumble.compare.grade.read.digits import vector_text
from tumble.scenarios.frames import Array, quaternion_product, rotation_matrix

POSITION, ATTITUDE, VELOCITY, SPIN = slice(0, 3), slice(3, 7), slice(7, 10), slice(10, 13)
PLACES = {"start position": POSITION, "start attitude": ATTITUDE}
# What becomes of a speed, and of an angular velocity, whose unit is mistaken or that is converted.
SPEED_UNITS = {
    1 / 3.6: "m/s read as km/h",
    3.6: "converted to km/h",
    0.3048: "m/s read as ft/s",
    1 / 0.3048: "converted to ft/s",
    0.5: "half",
    2.0: "double",
}
TURN = 2 * np.pi
SPIN_UNITS = {
    TURN: "rad/s read as turns/s",
    1 / TURN: "converted to turns/s",
    TURN / 60: "rad/s read as turns/min",
    60 / TURN: "converted to turns/min",
    0.5: "half",
    2.0: "double",
}
INVERSE = np.array([1.0, -1.0, -1.0, -1.0])


def start(context: Context) -> Iterator[Hypothesis]:
    """Yield wrong initial states, those that differ from the scene's."""
    program, first = context.program, context.first
    file_axes = program.body.file_axes
    attitude = quaternion_product(program.start[ATTITUDE], file_axes)
    turn = rotation_matrix(attitude)
    changes: list[tuple[str, str, str, slice, Array]] = [
        ("start-velocity-missing", "start velocity", "start velocity not set", VELOCITY, np.zeros(3)),
        ("start-spin-missing", "spin", "start angular velocity not set", SPIN, np.zeros(3)),
        ("start-attitude-missing", "start attitude", "start attitude not set", ATTITUDE, INVERSE * file_axes),
        ("start-position-missing", "start position", "start position not set", POSITION, np.zeros(3)),
    ]
    for name, part, what, place in (
        ("start-velocity", "start velocity", "velocity", VELOCITY),
        ("start-spin", "spin", "angular velocity", SPIN),
    ):
        value = program.start[place]
        changes += [
            (f"{name}-reversed", part, f"start {what} reversed", place, -value),
            (f"{name}-rotated-to-body-axes", part, f"start {what} rotated to body axes", place, turn.T @ value),
        ]
    velocity = program.start[VELOCITY]
    text = "start velocity taken in body axes"
    changes.append(("start-velocity-in-body-axes", "start velocity", text, VELOCITY, turn @ velocity))
    inverse = quaternion_product(INVERSE * attitude, INVERSE * file_axes)
    changes.append(("start-attitude-inverted", "start attitude", "start attitude inverted", ATTITUDE, inverse))
    for own, other, order in (("w x y z", "x y z w", (3, 0, 1, 2)), ("x y z w", "w x y z", (1, 2, 3, 0))):
        name = f"start-attitude-{own}-read-as-{other}".replace(" ", "")
        text = f"start attitude set as {own} and read as {other}"
        value = quaternion_product(attitude[[*order]], INVERSE * file_axes)
        changes.append((name, "start attitude", text, ATTITUDE, value))
    for name, part, text, place, value in changes:
        if _differs(program.start[place], value, place):
            yield Hypothesis(name, part, text, _set(place, value))
    if first is not None:
        for place, value in ((POSITION, first[:3]), (ATTITUDE, first[3:])):
            if _differs(program.start[place], value, place):
                yield _from_the_file(program, place, value)
    if context.has_centre:
        size = float(np.linalg.norm(np.ptp(context.scene.body.points, axis=0)))
        yield Hypothesis(
            "wrong-start-velocity",
            "start velocity",
            "start velocity ({}) m/s differs from the scene",
            lambda program, velocity: _set(VELOCITY, np.array(velocity))(program, 0.0),
            (tuple(velocity.tolist()),),
            unit="m/s",
            scale=float(np.linalg.norm(velocity)) + size / context.duration,
            vague=True,
        )
    yield from _in_other_units(program)
    yield from _in_other_axes(program)


def _from_the_file(program: ProgramModel, place: slice, value: Array) -> Hypothesis:
    """Return that the start position [m] or attitude is another one, a value that was taken from the file."""
    in_file = quaternion_product(value, program.body.file_axes) if place == ATTITUDE else value
    what = f"position x = ({vector_text(in_file)}) m" if place == POSITION else f"attitude ({vector_text(in_file)})"
    part = "start position" if place == POSITION else "start attitude"
    return Hypothesis(
        f"wrong-{part}".replace(" ", "-"),
        part,
        f"start {what} differs from the scene",
        _set(place, value),
        unit="m" if place == POSITION else "",
        from_data=3,
        value=tuple(in_file.tolist()),
    )


def with_free_start(mistakes: Mistakes, size_m: float) -> Mistakes:
    """Return mistakes in which a start that was taken from the first row, which has noise, may deviate from that.

    The deviation is fitted: of the position [m], or of the attitude by a rotation vector [rad], world axes.
    """
    found = []
    for one in mistakes:
        if one.hypothesis.from_data and one.hypothesis.part in PLACES:
            size = size_m if one.hypothesis.part == "start position" else 1.0
            free = replace(one.hypothesis, change=_deviating(one.hypothesis), values=((0.0, 0.0, 0.0),), scale=size)
            found.append(Mistake(free, (0.0, 0.0, 0.0)))
        else:
            found.append(one)
    return tuple(found)


def with_fixed_start(mistakes: Mistakes, program: ProgramModel) -> Mistakes:
    """Return mistakes of `with_free_start` in which the start is as it was fitted; program: a right one."""
    found = []
    for one in mistakes:
        if one.hypothesis.from_data and one.hypothesis.scale:
            place, start = PLACES[one.hypothesis.part], one.hypothesis.change(program, one.value).start
            found.append(Mistake(_from_the_file(program, place, start[place])))
        else:
            found.append(one)
    return tuple(found)


def _deviating(hypothesis: Hypothesis) -> Callable[[ProgramModel, Any], ProgramModel]:
    """Return a change of the start to a deviation from that of a hypothesis."""
    place = PLACES[hypothesis.part]

    def change(program: ProgramModel, by: Any) -> ProgramModel:
        changed = hypothesis.change(program, 0.0)
        value, by = changed.start[place], np.array(by)
        turned = quaternion_product(np.array((1.0, *(0.5 * by))), value) if place == ATTITUDE else value + by
        return _set(place, turned / np.linalg.norm(turned) if place == ATTITUDE else turned)(changed, 0.0)

    return change


def _in_other_units(program: ProgramModel) -> Iterator[Hypothesis]:
    """Yield a start velocity and a start angular velocity in another unit."""
    for name, part, what, place, units in (
        ("start-velocity-in-wrong-unit", "start velocity", "start velocity", VELOCITY, SPEED_UNITS),
        ("start-spin-in-wrong-unit", "spin", "start angular velocity", SPIN, SPIN_UNITS),
    ):
        value = program.start[place]
        if value.any():
            yield Hypothesis(
                name,
                part,
                f"{what} {{}} times its value",
                lambda program, factor, place=place, value=value: _set(place, factor * value)(program, 0.0),
                tuple(units),
                named_values=units,
                only_named=True,  # another factor explains a part of what many schemes do
            )


def _in_other_axes(program: ProgramModel) -> Iterator[Hypothesis]:
    """Yield that a part of the start was converted to other axes, for example from y up to z up."""
    renamings = [*signed_permutations(1), *signed_permutations(-1)]
    file_axes = program.body.file_axes
    q = quaternion_product(program.start[ATTITUDE], file_axes)
    for name, part, what, place, values in (
        ("start-velocity", "start velocity", "velocity", VELOCITY, [a @ program.start[VELOCITY] for a in renamings]),
        ("start-spin", "spin", "angular velocity", SPIN, [a @ program.start[SPIN] for a in renamings]),
        # An attitude in mirrored axes equals one in other axes without a mirror: the rotation axis is reversed as well.
        (
            "start-attitude",
            "start attitude",
            "attitude",
            ATTITUDE,
            [quaternion_product(_renamed(a, q), INVERSE * file_axes) for a in signed_permutations(1)],
        ),
    ):
        others = [number for number, value in enumerate(values) if _differs(program.start[place], value, place)]
        if others:
            yield Hypothesis(
                f"{name}-in-wrong-axes",
                part,
                f"start {what} in wrong axes: x y z replaced by {{}}",
                lambda program, number, place=place, values=values, others=others: _set(
                    place, values[others[int(number)]]
                )(program, 0.0),
                choice(len(others)),
                tuple(axis_names(renamings[number]) for number in others),
            )


def _renamed(axes: Array, q: Array) -> Array:
    return np.array([q[0], *(axes @ q[1:])])


def _set(place: slice, value: Array) -> Callable[[ProgramModel, float], ProgramModel]:
    def change(program: ProgramModel, _: float) -> ProgramModel:
        state = program.start.copy()
        state[place] = value
        return program.but(start=state)

    return change


def _differs(one: Array, other: Array, place: slice) -> bool:
    if place == ATTITUDE:
        return bool(abs(abs(one @ other) / np.linalg.norm(one) / np.linalg.norm(other) - 1) > 1e-12)
    return bool((one != other).any())
