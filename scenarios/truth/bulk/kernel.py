"""The compiled loop over many free throws of one body: in numbers of 32 digits, and in doubles what the inputs do."""

from typing import Any, NamedTuple

import numpy as np

from tumble.scenarios.frames import Array
from tumble.scenarios.truth.bulk.elliptic import MOST, larger
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
    vector_of,
    where,
)
from tumble.scenarios.truth.bulk.rotation import Moments, is_steady, polhode, spun, turned
from tumble.scenarios.truth.compilation import inner, kernel
from tumble.scenarios.truth.lanes import WIDTH, any_of, lanes, load, size, store
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
    [s]: (..., 2, R, N), or (..., 2, R, 1) where all throws have the same.
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
    """What a flight is worked out in: (MOST, 4, WIDTH) and (MOST, 2, WIDTH)."""

    means: Array
    angles: Array


class Group(NamedTuple):
    """WIDTH throws side by side, and room for what is made of them; the last axis of all is (WIDTH,).

    first: number of the first, (1,); start: pairs, (2, STATE), and half the last bits of its numbers; changed: as
    start; times: pairs, (2, R); here, there: vertices, (2, R, n, 3); input_error: (R,).
    """

    first: np.ndarray
    start: Array
    half_bits: Array
    changed: Array
    times: Array
    here: Array
    there: Array
    input_error: Array


Lines = tuple[Any, Any, Any, Any]


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
def quaternion_of(axes: Columns, before: Lines) -> Lines:
    """Return the unit quaternion of a rotation matrix in doubles, of the two the one nearer to that before.

    Source: Shepperd, "Quaternion from rotation matrix", J. Guidance and Control 1 (1978) 223.
    """
    x, y, z = axes
    trace = x[0] + y[1] + z[2]
    squares = 1.0 + trace, 1.0 - trace + x[0] * 2.0, 1.0 - trace + y[1] * 2.0, 1.0 - trace + z[2] * 2.0
    w_x, w_y, w_z = y[2] - z[1], z[0] - x[2], x[1] - y[0]
    x_y, x_z, y_z = y[0] + x[1], z[0] + x[2], z[1] + y[2]
    # Four times the products of the quaternion's numbers by the largest of them.
    most, q0, q1, q2, q3 = squares[0], squares[0], w_x, w_y, w_z
    is_more = near(squares[1]) > near(most)
    most, q0, q1 = where(is_more, squares[1], most), where(is_more, w_x, q0), where(is_more, squares[1], q1)
    q2, q3 = where(is_more, x_y, q2), where(is_more, x_z, q3)
    is_more = near(squares[2]) > near(most)
    most, q0, q1 = where(is_more, squares[2], most), where(is_more, w_y, q0), where(is_more, x_y, q1)
    q2, q3 = where(is_more, squares[2], q2), where(is_more, y_z, q3)
    is_more = near(squares[3]) > near(most)
    most, q0, q1 = where(is_more, squares[3], most), where(is_more, w_z, q0), where(is_more, x_z, q1)
    q2, q3 = where(is_more, y_z, q2), where(is_more, squares[3], q3)
    length = root(most) * 2.0
    a, b, c, d = near(q0 / length), near(q1 / length), near(q2 / length), near(q3 / length)
    is_other = 0.0 + a * before[0] + b * before[1] + c * before[2] + d * before[3] < 0.0
    return where(is_other, -a, a), where(is_other, -b, b), where(is_other, -c, c), where(is_other, -d, d)


@inner
def write_poses(
    kind: Number, start: Array, body: Array, points: Array, times: Array, room: Room, vertices: Array, states: Array
) -> None:
    """Write where the vertices are at the times, (2, R, n, 3, WIDTH), and where there is room the states.

    start: pairs, (2, STATE, WIDTH); times: pairs, (2, R, WIDTH); states: (R, STATE, WIDTH).
    """
    x, v = vector_of(kind, start, PLACE, STATE), vector_of(kind, start, VELOCITY, STATE)
    w, imaginary = vector_of(kind, start, SPIN, STATE), vector_of(kind, start, QUATERNION + 1, STATE)
    real = number(kind, load(start, QUATERNION), load(start, STATE + QUATERNION))
    gravity = vector(kind, body, GRAVITY)
    own = vector(kind, body, AXES), vector(kind, body, AXES + 3), vector(kind, body, AXES + 6)
    moments = Moments(vector(kind, body, MOMENTS), vector(kind, body, GAPS))
    state_axes = axes_of(real, imaginary[0], imaginary[1], imaginary[2])
    axes = along(state_axes, own[0]), along(state_axes, own[1]), along(state_axes, own[2])
    w_body = dot(axes[0], w), dot(axes[1], w), dot(axes[2], w)
    first, second, third = moments.values
    L = first * w_body[0], second * w_body[1], third * w_body[2]
    steady = is_steady(moments, L)
    curve = polhode(moments, axes, L, room.means, room.angles)
    before = near(real), near(imaginary[0]), near(imaginary[1]), near(imaginary[2])
    rows = times.shape[1]
    for row in range(rows):
        t = number(kind, load(times, row), load(times, rows + row))
        here, L_here = axes, L
        moved = near(t) != 0.0
        if any_of(moved & ~steady):
            here, L_here = turned(curve, t, room.means, room.angles)
        if any_of(steady):
            one, two, three = spun(axes, w_body, t)
            here = where(steady, one, here[0]), where(steady, two, here[1]), where(steady, three, here[2])
            L_here = where(steady, L, L_here)
        if any_of(~moved):
            here = where(moved, here[0], axes[0]), where(moved, here[1], axes[1]), where(moved, here[2], axes[2])
            L_here = where(moved, L_here, L)
        fallen = t * t * 0.5
        place = (
            x[0] + v[0] * t + gravity[0] * fallen,
            x[1] + v[1] * t + gravity[1] * fallen,
            x[2] + v[2] * t + gravity[2] * fallen,
        )
        write_vertices(kind, place, here, points, vertices, row)
        if len(states):
            speed = v[0] + gravity[0] * t, v[1] + gravity[1] * t, v[2] + gravity[2] * t
            spin = along(here, (L_here[0] / first, L_here[1] / second, L_here[2] / third))
            before = quaternion_of(
                (
                    along(here, (own[0][0], own[1][0], own[2][0])),
                    along(here, (own[0][1], own[1][1], own[2][1])),
                    along(here, (own[0][2], own[1][2], own[2][2])),
                ),
                before,
            )
            for axis in range(3):
                store(states, STATE * row + PLACE + axis, near(place[axis]))
                store(states, STATE * row + VELOCITY + axis, near(speed[axis]))
                store(states, STATE * row + SPIN + axis, near(spin[axis]))
            for axis in range(4):
                store(states, STATE * row + QUATERNION + axis, before[axis])


@inner
def write_vertices(kind: Number, place: Vector, axes: Columns, points: Array, vertices: Array, row: int) -> None:
    """Write x + R p of one instant."""
    rows, count = vertices.shape[1], vertices.shape[2]
    for vertex in range(count):
        arm = along(axes, vector(kind, points[:, vertex], 0))
        for axis in range(3):
            coordinate = place[axis] + arm[axis]
            store(vertices, (row * count + vertex) * 3 + axis, near(coordinate))
            store(vertices, ((rows + row) * count + vertex) * 3 + axis, rest(coordinate))


@inner
def write_input_error(group: Group, inputs: Inputs, trial: int, scale: float, room: Room) -> bool:
    """Write the largest move of a vertex when each number is changed by half its last bit [m], where it is not

    known yet and the moves for this share are a derivative; return whether it is known everywhere then.
    The rest as in `tumble.scenarios.truth.resolution`.
    """
    bodies, share, here, there = inputs.bodies, inputs.shares[trial], group.here, group.there
    rows, count, last = here.shape[1], here.shape[2], READINGS - 1
    moves, turns = np.empty((READINGS, rows, WIDTH)), np.empty((READINGS, rows, WIDTH))
    no_states = np.empty((0, STATE, WIDTH))
    for reading in range(READINGS):
        part = share * (OPPOSITE if reading == last else 1.0)
        for place in range(STATE):
            for lane in range(WIDTH):
                if len(inputs.starts):
                    group.changed[0, place, lane] = inputs.starts[trial, reading, place]
                else:
                    sign = inputs.signs[0 if reading == last else reading - 1, place] if reading else 0.0
                    change = sign * part * group.half_bits[place, lane]
                    group.changed[0, place, lane] = group.start[0, place, lane] + change
        write_times(bodies.times[trial, reading], group)
        write_poses(
            lanes(0.0), group.changed, bodies.numbers[trial, reading], bodies.points[trial, reading],
            group.times, room, there if reading else here, no_states,
        )  # fmt: skip
        for row in range(rows):
            furthest, widest = lanes(0.0), lanes(0.0)
            base = row * count * 3
            for vertex in range(count):
                total, apart = lanes(0.0), lanes(0.0)
                for axis in range(3):
                    corner = base + 3 * vertex + axis
                    move = load(there, corner) - load(here, corner)
                    # Where the body turns, vertices do not move alike; one alone is not told from the centre.
                    alike = load(there, base + axis) - load(here, base + axis) if count > 1 else lanes(0.0)
                    total = total + move * move
                    apart = apart + (move - alike) * (move - alike)
                furthest, widest = where(total > furthest, total, furthest), where(apart > widest, apart, widest)
            store(moves, reading * rows + row, root(furthest) / abs(part))
            store(turns, reading * rows + row, root(widest) / abs(part))
    known = True
    for row in range(rows):
        one, back, base = load(moves, rows + row), load(moves, last * rows + row), row * count * 3
        turn, turn_back = load(turns, rows + row), load(turns, last * rows + row)
        far = larger(size(load(here, base)), size(load(here, base + 1)), size(load(here, base + 2)))
        small = (share * one <= SMALL * scale + share * 2.0**-50 * far) & (
            share * turn <= SMALL * scale + 2.0**-50 * far  # but for the rounding of places
        )
        uneven = larger(size(one - back), size(turn - turn_back), size(turn - turn_back))
        found = load(group.input_error, row)
        is_found = (found != found) & small & (uneven <= PROPORTIONAL * larger(one, back, back))
        most = one
        for reading in range(2, last):
            move = load(moves, reading * rows + row)
            most = where(move > most, move, most)
        found = where(is_found, most, found)
        store(group.input_error, row, found)
        known = known and not any_of(found != found)
    return known


@inner
def write_times(times: Array, group: Group) -> None:
    """Write the instants of a group's throws, (2, R, WIDTH): times, (2, R, N), or (2, R, 1) where all have the same."""
    for part in range(2):
        for row in range(times.shape[1]):
            for lane in range(WIDTH):
                throw = min(group.first[0] + lane, times.shape[2] - 1)
                group.times[part, row, lane] = times[part, row, throw]


@kernel
def throws(starts: Array, inputs: Inputs, vertices: Array, states: Array, input_error: Array) -> None:
    """Write every throw's vertices, pairs, (2, R, N, n, 3), states, (R, N, STATE), and floor, (R, N), nan where the

    inputs' effect is no derivative.  starts: pairs, (N, 2, STATE).
    """
    rows, count, points = vertices.shape[1], len(starts), vertices.shape[3]
    room, bodies = Room(np.empty((MOST, 4, WIDTH)), np.empty((MOST, 2, WIDTH))), inputs.bodies
    group = Group(
        np.zeros(1, np.int64), np.empty((2, STATE, WIDTH)), np.empty((STATE, WIDTH)), np.zeros((2, STATE, WIDTH)),
        np.empty((2, rows, WIDTH)), np.empty((2, rows, points, 3, WIDTH)), np.empty((2, rows, points, 3, WIDTH)),
        np.empty((rows, WIDTH)),
    )  # fmt: skip
    exact, rounded = np.empty((2, rows, points, 3, WIDTH)), np.empty((rows, STATE, WIDTH))
    scale = 0.0
    for vertex in range(points):
        total = 0.0
        for axis in range(3):
            total += bodies.points[0, 0, 0, vertex, axis] ** 2
        scale = max(scale, np.sqrt(total))
    for first in range(0, count, WIDTH):
        group.first[0] = first
        for lane in range(WIDTH):
            # The last group is filled up with the last throw.
            start = starts[min(first + lane, count - 1)]
            for place in range(STATE):
                value = start[0, place]
                group.start[0, place, lane], group.start[1, place, lane] = value, start[1, place]
                group.half_bits[place, lane] = np.spacing(abs(value)) / 2.0 if value else 0.0
        write_times(bodies.times[0, 0], group)
        write_poses(
            long(0.0, 0.0), group.start, bodies.numbers[0, 0], bodies.points[0, 0], group.times, room, exact, rounded
        )
        group.input_error[:] = np.nan
        known = False
        for trial in range(len(inputs.shares)):
            known = known or write_input_error(group, inputs, trial, scale, room)
        for lane in range(min(WIDTH, count - first)):
            throw = first + lane
            for row in range(rows):
                input_error[row, throw] = group.input_error[row, lane]
                for component in range(STATE):
                    states[row, throw, component] = rounded[row, component, lane]
                for vertex in range(points):
                    for axis in range(3):
                        vertices[0, row, throw, vertex, axis] = exact[0, row, vertex, axis, lane]
                        vertices[1, row, throw, vertex, axis] = exact[1, row, vertex, axis, lane]
