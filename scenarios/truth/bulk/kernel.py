"""The compiled loop over many free throws of one body: in numbers of 32 digits, and in doubles what the inputs do."""

from typing import NamedTuple

import numpy as np

from tumble.scenarios.frames import Array
from tumble.scenarios.truth.bulk.elliptic import MOST
from tumble.scenarios.truth.bulk.number import (
    Columns,
    Number,
    Vector,
    along,
    dot,
    long,
    near,
    number,
    rest,
    root,
    vector,
)
from tumble.scenarios.truth.bulk.rotation import Moments, is_steady, polhode, spun, turned
from tumble.scenarios.truth.compilation import inner, kernel
from tumble.scenarios.truth.resolution import OPPOSITE, PATTERNS, PROPORTIONAL, SMALL

# Where the numbers of a body stand: principal moments and their gaps, the principal axes along those of a state column
# by column, and gravity.
MOMENTS, GAPS, AXES, GRAVITY, NUMBERS = 0, 3, 6, 15, 18
# A start's: as in every state of the harness.
PLACE, QUATERNION, VELOCITY, SPIN, STATE = 0, 3, 7, 10, 13
# Of the bodies that a share makes: as it is, changed by each pattern of signs, and by the first turned round.
READINGS = PATTERNS + 2


class Bodies(NamedTuple):
    """A body as it is and as its numbers are changed, for some shares: pairs.

    numbers: (shares, READINGS, 2, NUMBERS); points from the centre of mass, principal axes [m]: (..., 2, n, 3); times
    [s]: (..., 2, R).
    """

    numbers: Array
    points: Array
    times: Array


class Inputs(NamedTuple):
    """How the inputs are changed: by some shares of half their last bits, those of a start by signs, (PATTERNS, STATE),

    or to starts that are given, (shares, READINGS, STATE), if any are.
    """

    bodies: Bodies
    shares: Array
    signs: Array
    starts: Array


class Room(NamedTuple):
    """What a flight is worked out in: (MOST, 4) and (MOST, 2)."""

    means: Array
    angles: Array


@inner
def axes_of(q0: Number, q1: Number, q2: Number, q3: Number) -> Columns:
    """Return the rotation matrix of a quaternion of any length, its columns.  Source: Shoemake (1985) over |q|^2."""
    ww, xx, yy, zz = q0 * q0, q1 * q1, q2 * q2, q3 * q3
    share = 2.0 / (ww + xx + yy + zz)
    wx, wy, wz, xy, xz, yz = q0 * q1, q0 * q2, q0 * q3, q1 * q2, q1 * q3, q2 * q3
    return (
        (1.0 - (yy + zz) * share, (xy + wz) * share, (xz - wy) * share),
        ((xy - wz) * share, 1.0 - (xx + zz) * share, (yz + wx) * share),
        ((xz + wy) * share, (yz - wx) * share, 1.0 - (xx + yy) * share),
    )


@inner
def write_quaternion(axes: Columns, before: Array, q: Array) -> None:
    """Write the unit quaternion of a rotation matrix, (4,), of the two the one nearer to that before.

    Source: Shepperd, "Quaternion from rotation matrix", J. Guidance and Control 1 (1978) 223.
    """
    x, y, z = axes
    trace = x[0] + y[1] + z[2]
    squares = 1.0 + trace, 1.0 - trace + x[0] * 2.0, 1.0 - trace + y[1] * 2.0, 1.0 - trace + z[2] * 2.0
    w_x, w_y, w_z = y[2] - z[1], z[0] - x[2], x[1] - y[0]
    x_y, x_z, y_z = y[0] + x[1], z[0] + x[2], z[1] + y[2]
    largest = 0
    for place in range(1, 4):
        if near(squares[place]) > near(squares[largest]):
            largest = place
    # Four times the products of the quaternion's numbers by the largest of them.
    if largest == 0:
        line = squares[0], w_x, w_y, w_z
    elif largest == 1:
        line = w_x, squares[1], x_y, x_z
    elif largest == 2:
        line = w_y, x_y, squares[2], y_z
    else:
        line = w_z, x_z, y_z, squares[3]
    length = root(squares[largest]) * 2.0
    total = 0.0
    for place in range(4):
        q[place] = near(line[place] / length)
        total += q[place] * before[place]
    if total < 0.0:
        for place in range(4):
            q[place] = -q[place]


@inner
def write_poses(
    kind: Number, start: Array, body: Array, points: Array, times: Array, room: Room, vertices: Array, states: Array
) -> None:
    """Write where the vertices are at the times, (2, R, n, 3), and where there is room the states, (R, STATE).

    start: pairs, (2, STATE).
    """
    x, v, w = vector(kind, start, PLACE), vector(kind, start, VELOCITY), vector(kind, start, SPIN)
    q0, (q1, q2, q3) = number(kind, start[0, QUATERNION], start[1, QUATERNION]), vector(kind, start, QUATERNION + 1)
    gravity = vector(kind, body, GRAVITY)
    own = vector(kind, body, AXES), vector(kind, body, AXES + 3), vector(kind, body, AXES + 6)
    moments = Moments(vector(kind, body, MOMENTS), vector(kind, body, GAPS))
    state_axes = axes_of(q0, q1, q2, q3)
    axes = along(state_axes, own[0]), along(state_axes, own[1]), along(state_axes, own[2])
    w_body = dot(axes[0], w), dot(axes[1], w), dot(axes[2], w)
    first, second, third = moments.values
    L = first * w_body[0], second * w_body[1], third * w_body[2]
    steady = is_steady(moments, L)
    if not steady:
        curve = polhode(moments, axes, L, room.means, room.angles)
    before = start[0, QUATERNION:VELOCITY]
    for row in range(times.shape[1]):
        t = number(kind, times[0, row], times[1, row])
        here, L_here = axes, L
        if near(t) != 0.0:
            if steady:
                here = spun(axes, w_body, t)
            else:
                here, L_here = turned(curve, t, room.means, room.angles)  # type: ignore[reportPossiblyUnboundVariable]
        fallen = t * t * 0.5
        place = (
            x[0] + v[0] * t + gravity[0] * fallen,
            x[1] + v[1] * t + gravity[1] * fallen,
            x[2] + v[2] * t + gravity[2] * fallen,
        )
        write_vertices(kind, place, here, points, vertices, row)
        if len(states):
            speed = v[0] + gravity[0] * t, v[1] + gravity[1] * t, v[2] + gravity[2] * t
            turning = along(here, (L_here[0] / first, L_here[1] / second, L_here[2] / third))
            for axis in range(3):
                states[row, axis] = near(place[axis])
                states[row, VELOCITY + axis] = near(speed[axis])
                states[row, SPIN + axis] = near(turning[axis])
            turned_axes = (
                along(here, (own[0][0], own[1][0], own[2][0])),
                along(here, (own[0][1], own[1][1], own[2][1])),
                along(here, (own[0][2], own[1][2], own[2][2])),
            )
            write_quaternion(turned_axes, before, states[row, QUATERNION:VELOCITY])
            before = states[row, QUATERNION:VELOCITY]


@inner
def write_vertices(kind: Number, place: Vector, axes: Columns, points: Array, vertices: Array, row: int) -> None:
    """Write x + R p of one instant."""
    for vertex in range(points.shape[1]):
        point = vector(kind, points[:, vertex], 0)
        arm = along(axes, point)
        for axis in range(3):
            coordinate = place[axis] + arm[axis]
            vertices[0, row, vertex, axis] = near(coordinate)
            vertices[1, row, vertex, axis] = rest(coordinate)


@inner
def write_input_error(
    start: Array, inputs: Inputs, trial: int, size: float, room: Room, here: Array, there: Array, input_error: Array
) -> bool:
    """Write the largest move of a vertex when each number is changed by half its last bit [m], (R,), where it is not

    known yet and the moves for this share are a derivative; return whether it is known everywhere then.
    start: pairs, (2, STATE); here, there: room for vertices; the rest as in `tumble.scenarios.truth.resolution`.
    """
    bodies, share = inputs.bodies, inputs.shares[trial]
    rows, last = len(input_error), READINGS - 1
    moves, turns = np.empty((READINGS, rows)), np.empty((READINGS, rows))
    changed, no_states = np.zeros((2, STATE)), np.empty((0, STATE))
    for reading in range(READINGS):
        part = share * (OPPOSITE if reading == last else 1.0)
        for place in range(STATE):
            if len(inputs.starts):
                changed[0, place] = inputs.starts[trial, reading, place]
            else:
                value = start[0, place]
                half_bit = np.spacing(abs(value)) / 2.0 if value and reading > 0 else 0.0
                changed[0, place] = value + inputs.signs[0 if reading == last else reading - 1, place] * part * half_bit
        write_poses(
            0.0, changed, bodies.numbers[trial, reading], bodies.points[trial, reading],
            bodies.times[trial, reading], room, there if reading else here, no_states,
        )  # fmt: skip
        for row in range(rows):
            furthest = widest = 0.0
            for vertex in range(here.shape[2]):
                total = apart = 0.0
                for axis in range(3):
                    move = there[0, row, vertex, axis] - here[0, row, vertex, axis]
                    # Where the body turns, vertices do not move alike; one alone is not told from the centre.
                    alike = there[0, row, 0, axis] - here[0, row, 0, axis] if here.shape[2] > 1 else 0.0
                    total += move**2
                    apart += (move - alike) ** 2
                furthest, widest = max(furthest, total), max(widest, apart)
            moves[reading, row], turns[reading, row] = np.sqrt(furthest) / abs(part), np.sqrt(widest) / abs(part)
    known = True
    for row in range(rows):
        one, back = moves[1, row], moves[last, row]
        far = max(abs(here[0, row, 0, 0]), abs(here[0, row, 0, 1]), abs(here[0, row, 0, 2]))
        small = share * one <= SMALL * size + share * 2.0**-50 * far
        small = small and share * turns[1, row] <= SMALL * size + 2.0**-50 * far  # but for the rounding of places
        uneven = max(abs(one - back), abs(turns[1, row] - turns[last, row]))
        if np.isnan(input_error[row]) and small and uneven <= PROPORTIONAL * max(one, back):
            for reading in range(1, last):
                input_error[row] = moves[reading, row] if reading == 1 else max(input_error[row], moves[reading, row])
        known = known and not np.isnan(input_error[row])
    return known


@kernel
def throws(starts: Array, inputs: Inputs, vertices: Array, states: Array, input_error: Array) -> None:
    """Write every throw's vertices, pairs, (2, R, N, n, 3), states, (R, N, STATE), and floor, (R, N), nan where the

    inputs' effect is no derivative.  starts: pairs, (N, 2, STATE).
    """
    count, points = vertices.shape[1], vertices.shape[3]
    room, bodies = Room(np.empty((MOST, 4)), np.empty((MOST, 2))), inputs.bodies
    exact, here = np.empty((2, count, points, 3)), np.empty((2, count, points, 3))
    there, rounded, moved = np.empty((2, count, points, 3)), np.empty((count, STATE)), np.empty(count)
    size = 0.0
    for vertex in range(points):
        total = 0.0
        for axis in range(3):
            total += bodies.points[0, 0, 0, vertex, axis] ** 2
        size = max(size, np.sqrt(total))
    for place in range(len(starts)):
        start, known = starts[place], False
        point, time = bodies.points[0, 0], bodies.times[0, 0]
        write_poses(long(0.0, 0.0), start, bodies.numbers[0, 0], point, time, room, exact, rounded)  # type: ignore[call-arg]
        for row in range(count):
            moved[row] = np.nan
        for trial in range(len(inputs.shares)):
            known = known or write_input_error(start, inputs, trial, size, room, here, there, moved)
        for row in range(count):
            input_error[row, place] = moved[row]
            for component in range(STATE):
                states[row, place, component] = rounded[row, component]
            for vertex in range(points):
                for axis in range(3):
                    vertices[0, row, place, vertex, axis] = exact[0, row, vertex, axis]
                    vertices[1, row, place, vertex, axis] = exact[1, row, vertex, axis]
