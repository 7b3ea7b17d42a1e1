"""What moves the body in a program, as a row of numbers: that passes to a kernel many times as fast as tuples do."""

import math
from itertools import accumulate
from typing import NamedTuple

from tumble.compare.grade.model.kernel.dynamics import (
    AS_THE_BODY,
    IN_ROW,
    NO_OTHERS,
    SMOOTH,
    Array,
    Dynamics,
    Scheme,
    TetherLaw,
)
from tumble.solver.compilation import borrowing, inner
from tumble.solver.forces import Forces
from tumble.solver.vectors import Vector, dot


class Layout(NamedTuple):
    """How many numbers each part of a row has.

    reach [m], stiffness [N/m]: of the body, and of what pulls at it; rounding: of the times [s]; scene_drag,
    scene_floor: of `solver.forces`; the others as in `Dynamics` and `Forces`.
    """

    moments: int = 3
    mass: int = 1
    reach: int = 1
    stiffness: int = 1
    rounding: int = 1
    gravity: int = 3
    scene_drag: int = 2
    scene_floor: int = 6
    damping: int = 5
    drag: int = 4
    other_drag: int = 3
    tether_law: int = 6
    axis_damping: int = 9
    swirl: int = 1
    gravity_in_body: int = 1
    damping_place: int = 1
    damping_form: int = 1
    gyroscopic: int = 1
    frame_mixup: int = 1
    tensor: int = 1
    inverse_tensor: int = 1
    impulse_tensor: int = 1
    first: int = 4
    file_axes: int = 4
    attitude_rate_factor: int = 1
    caps: int = 2
    component_caps: int = 2
    cap_place: int = 1
    lever: int = 5
    lever_motion: int = 1
    lever_axes: int = 1
    impulse_axes: int = 1
    impulse_sets: int = 1
    up: int = 3
    bounce: int = 1
    floor_place: int = 1
    thresholds: int = 2


COUNTS = Layout()
# Where each part begins.
AT = Layout(*accumulate((0, *COUNTS[:-1])))
NUMBERS = sum(COUNTS)


@borrowing
def _vector(row: Array, at: int) -> Vector:
    return row[at], row[at + 1], row[at + 2]


@inner
def _of_program(tethers: Array, number: int, count: int) -> Array:
    """Return a part of some rows of tethers, of so many parts."""
    size = len(tethers) // count
    return tethers[number * size : (number + 1) * size]


@inner
def dynamics_of(numbers: Array, program: int, scene: Forces, tethers: Array) -> Dynamics:
    """Return what moves the body in one of several programs, from their rows of numbers, (N, NUMBERS).

    scene: forces of which only the points are read, and the forces that are in no row; tethers: of each program those
    that obey the scene's law, then all, (2 N k, 9).
    """
    row, parts = numbers[program], 2 * len(numbers)
    law = TetherLaw(
        int(row[AT.tether_law]),
        int(row[AT.tether_law + 1]),
        row[AT.tether_law + 2] != 0.0,
        row[AT.tether_law + 3] != 0.0,
        row[AT.tether_law + 4] != 0.0,
        row[AT.tether_law + 5],
    )
    has_other_tethers = (
        law.lever != AS_THE_BODY
        or law.torque_lever != AS_THE_BODY
        or law.damps_centre
        or law.other_damper
        or law.pulls_only
        or law.moves != 1.0
    )
    up = _vector(row, AT.up)
    damping = (row[AT.damping], row[AT.damping + 1], row[AT.damping + 2], row[AT.damping + 3], row[AT.damping + 4])
    drag = (row[AT.drag], row[AT.drag + 1], row[AT.drag + 2], row[AT.drag + 3])
    other_drag = _vector(row, AT.other_drag)
    axes = AT.axis_damping
    caps, component_caps = (row[AT.caps], row[AT.caps + 1]), (row[AT.component_caps], row[AT.component_caps + 1])
    thresholds = (row[AT.thresholds], row[AT.thresholds + 1])
    acts = dot(up, up) + abs(drag[0]) + abs(drag[1]) + abs(drag[2]) + abs(drag[3]) + abs(row[AT.swirl])
    acts += abs(other_drag[0]) + abs(other_drag[1]) + abs(other_drag[2]) + thresholds[0] + thresholds[1]
    in_body = row[AT.gravity_in_body] != 0.0
    is_usual = acts == 0.0 and not in_body and not has_other_tethers
    forces = Forces(
        row[AT.mass],
        _vector(row, AT.gravity),
        _of_program(tethers, 2 * program, parts),
        (row[AT.scene_drag], row[AT.scene_drag + 1]),
        None,
        None,
        *scene[IN_ROW:],
    )
    at, points = AT.scene_floor, scene.points
    has_floor = points is not None and len(points) > 0
    is_pulled = len(scene) > IN_ROW or len(tethers) > 0 or row[AT.scene_drag] != 0.0 or row[AT.scene_drag + 1] != 0.0
    floor = row[at], row[at + 1], row[at + 2], row[at + 3], row[at + 4], row[at + 5]
    return Dynamics(
        _vector(row, AT.moments),
        forces,
        Forces(row[AT.mass], None, None, None, floor, points, *NO_OTHERS),
        damping,
        drag,
        other_drag,
        law,
        _of_program(tethers, 2 * program + 1, parts),
        (_vector(row, axes), _vector(row, axes + 3), _vector(row, axes + 6)),
        row[AT.swirl],
        in_body,
        int(row[AT.damping_place]),
        int(row[AT.damping_form]),
        row[AT.gyroscopic],
        int(row[AT.frame_mixup]),
        int(row[AT.tensor]),
        int(row[AT.inverse_tensor]),
        int(row[AT.impulse_tensor]),
        (row[AT.first], row[AT.first + 1], row[AT.first + 2], row[AT.first + 3]),
        (row[AT.file_axes], row[AT.file_axes + 1], row[AT.file_axes + 2], row[AT.file_axes + 3]),
        row[AT.attitude_rate_factor],
        caps,
        component_caps,
        int(row[AT.cap_place]),
        (row[AT.lever], row[AT.lever + 1], row[AT.lever + 2], row[AT.lever + 3], row[AT.lever + 4]),
        int(row[AT.lever_motion]),
        int(row[AT.lever_axes]),
        int(row[AT.impulse_axes]),
        row[AT.impulse_sets] != 0.0,
        up,
        row[AT.bounce],
        int(row[AT.floor_place]),
        thresholds,
        is_usual,
        min(caps[0], caps[1], component_caps[0], component_caps[1]) < math.inf,
        has_other_tethers,
        is_pulled,
        has_floor,
    )


@borrowing
def scheme_of(row: Array, fineness: float) -> Scheme:
    """Return a step from its row of numbers; fineness: rotation in a step of a continuous run [rad]."""
    attitude = int(row[1])
    step = fineness if attitude == SMOOTH else row[0]
    return Scheme(
        step,
        attitude,
        int(row[2]),
        row[3] != 0.0,
        row[4],
        int(row[5]),
        int(row[6]),
        int(row[7]),
        int(row[8]),
        int(row[9]),
        row[10] != 0.0,
        row[11] != 0.0,
        int(row[12]),
        int(row[13]),
    )
