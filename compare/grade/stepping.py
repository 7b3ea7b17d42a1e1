"""A flight as a program with mistakes makes it: smooth, or in steps of some Euler method, with parts missing or wrong.

The solver's own methods are right but for their steps.  Here every term has a switch, so that a mistake is a number and
one compiled kernel flies them all.  A row of what is found, (22,): x [m], the matrix body to world by rows as the
program has it, v [m/s], w [rad/s], world axes, and q, nan where the program keeps none.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from solver.compilation import inner, kernel
from solver.forces import Forces, wrench
from solver.quaternion import (
    Quaternion,
    exponential,
    norm_squared,
    normalise,
    plus,
    product,
    product_vector,
    rotate,
    rotate_back,
    stretch,
)
from solver.vectors import Vector, add, cross, dot, scale, times

Array = NDArray[np.float64]

WIDTH = 22
# A row of events: its instant [s], what happens, the impulse or force that moves, the one that turns, where it lands,
# whether that is in body axes; then, of a force, its lever arm, and the row in which it began.
EVENT = 16
JUMP, BEGIN, END = 0.0, 1.0, 2.0
# A flight takes no more steps than this, a smooth one no more than so many radians have steps.
MOST_STEPS, MOST_RADIANS = 100_000, 1_000.0
# What a step does to the attitude, and to the angular velocity.
SMOOTH, QUATERNION, EXPONENTIAL, MATRIX = 0, 1, 2, 3
EXPLICIT, MOMENTUM, IMPLICIT, WORLD = 0, 1, 2, 3
# Which angular velocity a program turns the attitude by: the right one; that in world axes as if it were in body axes,
# where it keeps L, or w; that in body axes as if it were in world axes.
UNMIXED, MIXED_MOMENTUM, MIXED_WORLD, MIXED_BODY = 0, 1, 2, 3
# What becomes of the lever arm of a force that lasts: the torque stays as it began; the point moves with the body; the
# point stays where it was in the world.
TORQUE_STAYS, POINT_MOVES, POINT_STAYS = 0, 1, 2
# When a step damps: as a force, with its others; what they have made of the velocities; or those, once it has moved.
AS_FORCE, AFTER_FORCES, LAST = 0, 1, 2


class Laws(NamedTuple):
    """What moves the body, as the program has it.

    moments [kg m2]; forces: of the scene; damping: a = -(d0 + d1 |v|) v and alpha = -(d2 + d3 |w|) w [1/s, 1/m, 1/s,
    1]; gyroscopic: 1 right, 0 left out, -1 of the wrong sign; damps, mixed, held: of the constants above; arm: sign,
    share of x and a point [m], for a lever arm sign (r - share x - point).
    """

    moments: Vector
    forces: Forces
    damping: tuple[float, float, float, float]
    damps: int
    gyroscopic: float
    mixed: int
    arm: tuple[float, float, float, float, float]
    held: int


class Scheme(NamedTuple):
    """What is done in a step: its length [s], of a smooth flight the turn in one [rad]; then the constants above.

    semi: the angular velocity first, and the attitude with the new one; fall: positions with the old velocity, 0, the
    new one, 1, or their mean; lengthens: q is never normalised.
    """

    step: float
    attitude: int
    spin: int
    semi: bool
    fall: float
    lengthens: bool


class Push(NamedTuple):
    """Forces that last: how many act, their sum [N], and their torque [N m] about x, world axes.

    It is torque - x x drawn + (R a) x F summed over forces F with an arm a in body axes, of which rows are the sums
    a_k F [N m].
    """

    acting: int
    force: Vector
    torque: Vector
    drawn: Vector
    rows: tuple[Vector, Vector, Vector]


class Motion(NamedTuple):
    """x [m], q, v [m/s], world axes; w [rad/s], body axes."""

    x: Vector
    q: Quaternion
    v: Vector
    w_body: Vector


@inner
def _turning(q: Quaternion, w_body: Vector, mixed: int) -> Vector:
    """Return the rate at which the program turns the attitude, body axes: q' = q turning~ / 2."""
    if mixed == UNMIXED:
        return w_body
    return rotate_back(q, w_body) if mixed == MIXED_BODY else rotate(q, w_body)


@inner
def _twist(x: Vector, q: Quaternion, push: Push) -> Vector:
    """Return the torque of forces that last, world axes."""
    carried = cross(rotate(q, (1.0, 0.0, 0.0)), push.rows[0])
    carried = add(carried, cross(rotate(q, (0.0, 1.0, 0.0)), push.rows[1]))
    carried = add(carried, cross(rotate(q, (0.0, 0.0, 1.0)), push.rows[2]))
    return add(add(push.torque, carried), cross(push.drawn, x))


@inner
def _accelerations(motion: Motion, laws: Laws, push: Push) -> tuple[Vector, Vector]:
    """Return a, world axes, and alpha, body axes, without damping and the gyroscopic term."""
    force, torque = wrench(motion.x, motion.q, motion.v, motion.w_body, laws.forces)
    if push.acting > 0:
        force = add(force, push.force)
        torque = add(torque, rotate_back(motion.q, _twist(motion.x, motion.q, push)))
    a, b, c = laws.moments
    return scale(1.0 / laws.forces.mass, force), (torque[0] / a, torque[1] / b, torque[2] / c)


@inner
def _damped(v: Vector, w: Vector, dt: float, old_v: Vector, old_w: Vector, laws: Laws) -> tuple[Vector, Vector]:
    """Return v and w after damping for dt [s] by what it is at the old ones."""
    d0, d1, d2, d3 = laws.damping
    if d0 + d1 + d2 + d3 == 0.0:
        return v, w
    slow, brake = d0 + d1 * math.sqrt(dot(old_v, old_v)), d2 + d3 * math.sqrt(dot(old_w, old_w))
    return add(v, scale(-dt * slow, old_v)), add(w, scale(-dt * brake, old_w))


@inner
def _gyroscopic(w_body: Vector, turning: Vector, laws: Laws) -> Vector:
    """Return I^-1 (L x w), and w x turning where w is kept in world axes; where L is, I^-1 (L x turning)."""
    keeps_momentum = laws.mixed == MIXED_MOMENTUM and laws.gyroscopic != 0.0
    rate = scale(laws.gyroscopic, cross(times(laws.moments, w_body), turning if keeps_momentum else w_body))
    rate = (rate[0] / laws.moments[0], rate[1] / laws.moments[1], rate[2] / laws.moments[2])
    return rate if keeps_momentum or laws.mixed == MIXED_BODY else add(rate, cross(w_body, turning))


@inner
def _slope(motion: Motion, laws: Laws, push: Push) -> Motion:
    turning = _turning(motion.q, motion.w_body, laws.mixed)
    a, alpha = _accelerations(motion, laws, push)
    alpha = add(alpha, _gyroscopic(motion.w_body, turning, laws))
    a, alpha = _damped(a, alpha, 1.0, motion.v, motion.w_body, laws)
    return Motion(motion.v, product_vector(motion.q, scale(0.5, turning)), a, alpha)


@inner
def _along(motion: Motion, dt: float, slope: Motion) -> Motion:
    return Motion(
        add(motion.x, scale(dt, slope.x)),
        plus(motion.q, stretch(dt, slope.q)),
        add(motion.v, scale(dt, slope.v)),
        add(motion.w_body, scale(dt, slope.w_body)),
    )


@inner
def _smooth_step(motion: Motion, dt: float, laws: Laws, push: Push) -> Motion:
    """Return the motion dt [s] on, by the classical Runge-Kutta method of order 4."""
    first = _slope(motion, laws, push)
    second = _slope(_along(motion, dt / 2.0, first), laws, push)
    third = _slope(_along(motion, dt / 2.0, second), laws, push)
    fourth = _slope(_along(motion, dt, third), laws, push)
    found = _along(_along(motion, dt / 6.0, first), dt / 3.0, second)
    found = _along(_along(found, dt / 3.0, third), dt / 6.0, fourth)
    return Motion(found.x, normalise(found.q), found.v, found.w_body)


@inner
def _implicit_gyroscopic(w: Vector, dt: float, moments: Vector) -> Vector:
    """Return w after the torque -w x I w, by one Newton step of implicit Euler.

    Source: Catto, "Numerical methods" (Game Developers Conference 2015); so in Bullet's btRigidBody.
    """
    a, b, c = moments
    momentum = times(moments, w)
    off = scale(dt, cross(w, momentum))
    # The derivative of I w' + dt w' x I w' at w: its rows, solved by Cramer's rule.
    first = (a, dt * (c - b) * w[2], dt * (c - b) * w[1])
    second = (dt * (a - c) * w[2], b, dt * (a - c) * w[0])
    third = (dt * (b - a) * w[1], dt * (b - a) * w[0], c)
    minors = cross(second, third), cross(third, first), cross(first, second)
    determinant = dot(first, minors[0])
    change = add(add(scale(off[0], minors[0]), scale(off[1], minors[1])), scale(off[2], minors[2]))
    return add(w, scale(-1.0 / determinant, change))


@inner
def _spun(motion: Motion, dt: float, laws: Laws, alpha: Vector, spin: int) -> Vector:
    """Return w_body after a step's torques, the attitude standing still; with MOMENTUM the turn comes later."""
    w = motion.w_body
    if spin in (EXPLICIT, WORLD):
        w = add(w, scale(dt, _gyroscopic(w, _turning(motion.q, w, laws.mixed), laws)))
    elif spin == IMPLICIT:
        w = _implicit_gyroscopic(w, dt, laws.moments)
    return add(w, scale(dt, alpha))


@inner
def _carried(q: Quaternion, q_next: Quaternion, w: Vector, laws: Laws) -> Vector:
    """Return w_body at the next attitude when what the program keeps in world axes, L or w, is kept."""
    if laws.gyroscopic == 0.0:
        return rotate_back(q_next, rotate(q, w))
    momentum = rotate_back(q_next, rotate(q, times(laws.moments, w)))
    return (momentum[0] / laws.moments[0], momentum[1] / laws.moments[1], momentum[2] / laws.moments[2])


@inner
def _turned(q: Quaternion, turn: Vector, attitude: int) -> tuple[Quaternion, float]:
    """Return q turned by a vector [rad], body axes, and how much longer the program has made it."""
    if attitude == EXPONENTIAL:
        return normalise(product(q, exponential(scale(0.5, turn)))), 1.0
    longer = plus(q, product_vector(q, scale(0.5, turn)))
    return normalise(longer), math.sqrt(norm_squared(longer))


@inner
def _euler_step(motion: Motion, dt: float, laws: Laws, push: Push, scheme: Scheme) -> tuple[Motion, float]:
    """Return the motion one step of dt [s] on, and how much longer q would have become."""
    turning = _turning(motion.q, motion.w_body, laws.mixed)
    a, alpha = _accelerations(motion, laws, push)
    v, w = add(motion.v, scale(dt, a)), _spun(motion, dt, laws, alpha, scheme.spin)
    if laws.damps == AS_FORCE:
        v, w = _damped(v, w, dt, motion.v, motion.w_body, laws)
    elif laws.damps == AFTER_FORCES:
        v, w = _damped(v, w, dt, v, w, laws)
    x = add(motion.x, scale(dt, add(motion.v, scale(scheme.fall, add(v, scale(-1.0, motion.v))))))
    turn = scale(dt, _turning(motion.q, w, laws.mixed) if scheme.semi else turning)
    q, growth = _turned(motion.q, turn, scheme.attitude)
    if scheme.spin == MOMENTUM:
        w = _carried(motion.q, q, w, laws)
    elif scheme.spin == WORLD:
        w = rotate_back(q, rotate(motion.q, w))
    if laws.damps == LAST:
        v, w = _damped(v, w, dt, v, w, laws)
    return Motion(x, q, v, w), growth


@inner
def _matrix_step(columns: Array, dt: float, momentum: Vector, moments: Vector) -> Vector:
    """Take one step of R += dt [w]x R in place, w = R I^-1 R^T L, and return w (IGR202 report, section 3.1).

    columns: of R, (3, 3), one a row.
    """
    e1 = (columns[0, 0], columns[0, 1], columns[0, 2])
    e2 = (columns[1, 0], columns[1, 1], columns[1, 2])
    e3 = (columns[2, 0], columns[2, 1], columns[2, 2])
    w = scale(dot(e1, momentum) / moments[0], e1)
    w = add(w, add(scale(dot(e2, momentum) / moments[1], e2), scale(dot(e3, momentum) / moments[2], e3)))
    columns[0, 0], columns[0, 1], columns[0, 2] = add(e1, scale(dt, cross(w, e1)))
    columns[1, 0], columns[1, 1], columns[1, 2] = add(e2, scale(dt, cross(w, e2)))
    columns[2, 0], columns[2, 1], columns[2, 2] = add(e3, scale(dt, cross(w, e3)))
    return w


@inner
def _smooth_count(motion: Motion, interval: float, laws: Laws, push: Push, spring_rate: float, turn: float) -> float:
    """Return in how many steps the body turns, and the stiffest spring swings, by no more than so many radians each.

    L and, but where frames are mixed up, the energy say how fast a free body can come to turn.
    """
    least = min(laws.moments)
    momentum = times(laws.moments, motion.w_body)
    rate = math.sqrt(dot(momentum, momentum)) / least
    if laws.mixed == UNMIXED:
        rate = min(rate, math.sqrt(dot(momentum, motion.w_body) / least))
    twist = _twist(motion.x, motion.q, push)
    rate += math.sqrt(dot(twist, twist)) / least * interval
    d0, d1, d2, d3 = laws.damping
    return (rate + spring_rate + d0 + d1 + d2 + d3) * interval / turn


@inner
def _lever(motion: Motion, event: Array, laws: Laws) -> Vector:
    """Return the lever arm of an impulse as the program has it, world axes."""
    point = (event[8], event[9], event[10])
    if event[11] != 0.0:
        point = add(motion.x, rotate(motion.q, point))
    sign, share, x, y, z = laws.arm
    return scale(sign, add(point, add(scale(-share, motion.x), (-x, -y, -z))))


@inner
def _struck(motion: Motion, laws: Laws, moves: Vector, twist: Vector) -> Motion:
    """Return the motion after an impulse [N s] and an angular one [N m s], world axes."""
    turned = rotate_back(motion.q, twist)
    a, b, c = laws.moments
    w = add(motion.w_body, (turned[0] / a, turned[1] / b, turned[2] / c))
    return Motion(motion.x, motion.q, add(motion.v, scale(1.0 / laws.forces.mass, moves)), w)


@inner
def _happen(motion: Motion, push: Push, events: Array, number: int, laws: Laws) -> tuple[Motion, Push, Vector]:
    """Return motion and push after an event, and by how much the angular momentum has jumped, world axes."""
    event = events[number]
    moves, turns = (event[2], event[3], event[4]), (event[5], event[6], event[7])
    nothing = (0.0, 0.0, 0.0)
    if event[1] == END:
        begun = events[int(event[15])]
        return motion, _pushed(push, -1, moves, turns, (begun[12], begun[13], begun[14]), laws), nothing
    lever = _lever(motion, event, laws)
    if event[1] == JUMP:
        twist = cross(lever, turns)
        return _struck(motion, laws, moves, twist), push, twist
    if laws.held == POINT_MOVES:
        lever = rotate_back(motion.q, lever)
    elif laws.held == POINT_STAYS:
        lever = add(lever, scale(laws.arm[0] * laws.arm[1], motion.x))
    event[12], event[13], event[14] = lever
    return motion, _pushed(push, 1, moves, turns, lever, laws), nothing


@inner
def _pushed(push: Push, sign: int, moves: Vector, turns: Vector, lever: Vector, laws: Laws) -> Push:
    """Return what lasts once a force that moves, the same that turns and its lever begin, or with sign -1 end."""
    acting, force, turns = push.acting + sign, add(push.force, scale(sign, moves)), scale(sign, turns)
    if laws.held == POINT_MOVES:
        first, second, third = push.rows
        a, b, c = lever
        rows = add(first, scale(a, turns)), add(second, scale(b, turns)), add(third, scale(c, turns))
        return Push(acting, force, push.torque, push.drawn, rows)
    torque = add(push.torque, cross(lever, turns))
    share = laws.arm[0] * laws.arm[1] if laws.held == POINT_STAYS else 0.0
    return Push(acting, force, torque, add(push.drawn, scale(share, turns)), push.rows)


@inner
def _write(row: Array, motion: Motion, q: Quaternion, columns: Array, w_matrix: Vector, attitude: int) -> None:
    """Write a row; q: as long as the program has it."""
    row[0], row[1], row[2] = motion.x
    row[12], row[13], row[14] = motion.v
    row[15], row[16], row[17] = rotate(motion.q, motion.w_body)
    row[18], row[19], row[20], row[21] = q
    w, x, y, z = q
    row[3], row[4], row[5] = w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)
    row[6], row[7], row[8] = 2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)
    row[9], row[10], row[11] = 2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z
    if attitude == MATRIX:
        row[15], row[16], row[17] = w_matrix
        row[18:22] = math.nan
        for i in range(3):
            for j in range(3):
                row[3 + 3 * j + i] = columns[i, j]


@kernel
def fly(
    start: Array, times_s: Array, found: Array, laws: Laws, events: Array, spring_rate: float, scheme: Scheme
) -> None:
    """Fly from a state of ours, (13,), at t = 0 to instants [s] that do not decrease, (T,); found: rows, (T, 22).

    events: in the order in which they happen, (E, 16); spring_rate: of the stiffest swing there may be [rad/s].
    Between two instants there are whole steps and a shorter last one; a smooth flight takes equal ones.
    """
    q = normalise((start[3], start[4], start[5], start[6]))
    w_matrix = (start[10], start[11], start[12])
    motion = Motion((start[0], start[1], start[2]), q, (start[7], start[8], start[9]), rotate_back(q, w_matrix))
    momentum = rotate(q, times(laws.moments, motion.w_body))
    columns = np.empty((3, 3))
    columns[0, 0], columns[0, 1], columns[0, 2] = rotate(q, (1.0, 0.0, 0.0))
    columns[1, 0], columns[1, 1], columns[1, 2] = rotate(q, (0.0, 1.0, 0.0))
    columns[2, 0], columns[2, 1], columns[2, 2] = rotate(q, (0.0, 0.0, 1.0))
    nothing = (0.0, 0.0, 0.0)
    push = Push(0, nothing, nothing, nothing, (nothing, nothing, nothing))
    length, now, number, row = 1.0, 0.0, 0, 0
    while row < len(times_s):
        happens = number < len(events) and events[number, 0] <= times_s[row]
        stop = events[number, 0] if happens else times_s[row]
        interval = stop - now
        if interval > 0.0:
            smooth = scheme.attitude == SMOOTH
            ratio = interval / scheme.step
            if smooth:
                ratio = _smooth_count(motion, interval, laws, push, spring_rate, scheme.step)
            most = (MOST_RADIANS / scheme.step if smooth else MOST_STEPS) * interval / times_s[-1]
            count = max(1, math.ceil(min(ratio * (1.0 - 1e-9), most)))
            for done in range(count):
                dt = interval / count if smooth or ratio > most else min(scheme.step, interval - done * scheme.step)
                if smooth:
                    motion = _smooth_step(motion, dt, laws, push)
                    continue
                motion, growth = _euler_step(motion, dt, laws, push, scheme)
                length *= growth
                if scheme.attitude == MATRIX:
                    momentum = add(momentum, scale(dt, _twist(motion.x, motion.q, push)))
                    w_matrix = _matrix_step(columns, dt, momentum, laws.moments)
            now = stop
        if happens:
            motion, push, jump = _happen(motion, push, events, number, laws)
            momentum = add(momentum, jump)
            number += 1
        else:
            shown = stretch(length, motion.q) if scheme.lengthens else motion.q
            _write(found[row], motion, shown, columns, w_matrix, scheme.attitude)
            row += 1
