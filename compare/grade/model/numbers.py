"""The row of numbers that tells a kernel what moves the body in a program, and those of them that a change moves."""

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

import numpy as np

from tumble.compare.grade.model.kernel.parameters import AT, COUNTS
from tumble.scenarios.frames import Array

if TYPE_CHECKING:
    from tumble.compare.grade.model.program_model import ProgramModel

# Fields of a program that are parts of a row, under the same names.
SAME = (
    "moments", "mass", "stiffness", "rounding", "damping", "drag", "tether_law", "swirl", "gravity_in_body",
    "damping_place", "damping_form", "gyroscopic", "frame_mixup", "tensor", "inverse_tensor", "impulse_tensor",
    "attitude_rate_factor", "caps", "component_caps", "cap_place", "up", "bounce", "floor_place", "thresholds",
)  # fmt: skip
Write = Callable[[Array, "ProgramModel"], None]


def _place(name: str) -> int | slice:
    """Return where a part is in a row."""
    begin, count = getattr(AT, name), getattr(COUNTS, name)
    return begin if count == 1 else slice(begin, begin + count)


PLACES = {name: _place(name) for name in AT._fields}


def _write_body(row: Array, program: "ProgramModel") -> None:
    row[PLACES["reach"]], row[PLACES["file_axes"]] = program.body.reach, program.body.file_axes


def _write_start(row: Array, program: "ProgramModel") -> None:
    q = program.start[3:7]
    row[PLACES["first"]] = q / np.sqrt(q @ q)


def _write_gravity(row: Array, program: "ProgramModel") -> None:
    """Write gravity; what begins later is an event."""
    row[PLACES["gravity"]] = 0.0 if program.gravity_from else program.gravity


def _write_axis_damping(row: Array, program: "ProgramModel") -> None:
    row[PLACES["axis_damping"]] = np.ravel(program.axis_damping)


def _write_application(row: Array, program: "ProgramModel") -> None:
    application = program.application
    row[PLACES["lever"]], row[PLACES["lever_motion"]] = application.lever, application.lever_motion
    row[PLACES["lever_axes"]], row[PLACES["impulse_axes"]] = application.lever_axes, application.axes
    row[PLACES["impulse_sets"]] = application.sets


def _write_scene_forces(row: Array, program: "ProgramModel") -> None:
    """Write drag and floor of the scene: drag by its law, and what a program has by another law."""
    forces = program.forces
    if forces.floor is not None:
        row[PLACES["scene_floor"]] = forces.floor
    if forces.drag is not None:
        linear, angular = (each or 0.0 for each in forces.drag)
        is_quadratic, is_quadratic_spin, is_undivided = program.drag_law
        row[PLACES["scene_drag"]] = (
            0.0 if is_quadratic else linear,
            0.0 if is_quadratic_spin or is_undivided else angular,
        )
        row[PLACES["other_drag"]] = linear * is_quadratic, angular * is_quadratic_spin, angular * is_undivided


def _write_same(name: str) -> Write:
    place = PLACES[name]

    def write(row: Array, program: "ProgramModel") -> None:
        row[place] = getattr(program, name)

    return write


# What writes the parts of a row that depend on a field of a program.
WRITES: dict[str, Write] = {
    **{name: _write_same(name) for name in SAME},
    "body": _write_body,
    "start": _write_start,
    "gravity": _write_gravity,
    "gravity_from": _write_gravity,
    "axis_damping": _write_axis_damping,
    "application": _write_application,
    "forces": _write_scene_forces,
    "drag_law": _write_scene_forces,
}


def changed_numbers(row: Array, program: "ProgramModel", fields: Iterable[str] = tuple(WRITES)) -> Array:
    """Return the row of a program, from that of another one that differs in some fields; by default, in all."""
    writes = [WRITES[name] for name in fields if name in WRITES]
    if not writes:
        return row
    row = row.copy()
    for write in writes:
        write(row, program)
    return row
