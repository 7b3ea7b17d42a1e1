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
    conjugate,
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
# What a step does to the attitude; RUNGE_KUTTA takes all of it in one step, of the order that stands for its spin.
SMOOTH, QUATERNION, EXPONENTIAL, MATRIX, RUNGE_KUTTA = 0, 1, 2, 3, 4
# What it does to the angular velocity: the gyroscopic term explicit, in body axes; L kept; by one Newton step of
# implicit Euler; w kept in world axes; explicit with |L| kept; (I - dt [L]) w' = L; by the implicit midpoint rule.
EXPLICIT, MOMENTUM, IMPLICIT, WORLD, RESCALED, BACKWARD, MIDPOINT = 0, 1, 2, 3, 4, 5, 6
# Which angular velocity a program turns the attitude by: the right one; that in world axes as if it were in body axes,
# where it keeps L, or w; that in body axes as if it were in world axes.
UNMIXED, MIXED_MOMENTUM, MIXED_WORLD, MIXED_BODY = 0, 1, 2, 3
# What becomes of the lever arm of a force that lasts: the torque stays as it began; the point moves with the body; the
# point stays where it was in the world.
TORQUE_STAYS, POINT_MOVES, POINT_STAYS = 0, 1, 2
# When a step damps: as a force, with its others; what they have made of the velocities; those, once it has moved; or
# what they were before.  How: v - c dt v, v exp(-c dt), or v / (1 + c dt).
AS_FORCE, AFTER_FORCES, LAST, BEFORE_FORCES = 0, 1, 2, 3
LINEARLY, EXPONENTIALLY, IMPLICITLY = 0, 1, 2
# In which axes the program has the inertia tensor: R I R^T; I; R0 I R0^T; R^T I R.
TURNED, NEVER_TURNED, FROZEN, TURNED_BACK = 0, 1, 2, 3
# What is kept from step to step: as it is, rounded to single precision, or with all of it that rounding can do alike.
AS_IT_IS, ROUNDED, BIASED = 0, 1, 2
HALF_SINGLE = 2.0**-24
# Fixed-point rounds of the midpoint rule, each better by |w| dt.
ROUNDS = 12
# Of a step: how much shorter or longer an interval of whole steps is by rounding of doubles.
NEARLY = 1e-9


class Laws(NamedTuple):
    """What moves the body, as the program has it.

    moments [kg m2]; forces: of the scene; damping: a = -(d0 + d1 |v|) v and alpha = -(d2 + d3 |w|) w - d4 I^-1 w [1/s,
    1/m, 1/s, 1, N m s]; gyroscopic: 1 right, 0 left out, -1 of the wrong sign; damps, decays, mixed, tensor, held: of
    the constants above; struck: tensor of impulses; first: q at the start; turning: q' = turning q w~ / 2; caps: of |v|
    [m/s] and |w| [rad/s]; arm: sign, share of x and a point [m], for a lever arm sign (r - share x - point); unturned:
    lever arms stay in body axes.
    """

    moments: Vector
    forces: Forces
    damping: tuple[float, float, float, float, float]
    damps: int
    decays: int
    gyroscopic: float
    mixed: int
    tensor: int
    struck: int
    first: Quaternion
    turning: float
    caps: tuple[float, float]
    arm: tuple[float, float, float, float, float]
    held: int
    unturned: bool


class Scheme(NamedTuple):
    """What is done in a step: its length [s], of a smooth flight the turn in one [rad]; then the constants above.

    semi: the angular velocity first, and the attitude with the new one; fall: positions with the old velocity, 0, the
    new one, 1, or their mean; lengthens: q is never normalised; idle: gravity acts from the step after so many;
    keeps: from step to step, of the constants above.
    """

    step: float
    attitude: int
    spin: int
    semi: bool
    fall: float
    lengthens: bool
    idle: int = 0
    keeps: int = AS_IT_IS


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
def _turning(q: Quaternion, w_body: Vector, laws: Laws) -> Vector:
    """Return the rate at which the program turns the attitude, body axes: q' = q turning~ / 2."""
    rate = scale(laws.turning, w_body)
    if laws.mixed == UNMIXED:
        return rate
    return rotate_back(q, rate) if laws.mixed == MIXED_BODY else rotate(q, rate)


@inner
def _to_tensor(q: Quaternion, laws: Laws, tensor: int) -> Quaternion:
    """Return the rotation from body axes to those in which the program's inertia tensor is diagonal."""
    if tensor == NEVER_TURNED:
        return q
    return product(conjugate(laws.first), q) if tensor == FROZEN else product(q, q)


@inner
def _divided(momentum: Vector, moments: Vector) -> Vector:
    """Return I^-1 L."""
    return (momentum[0] / moments[0], momentum[1] / moments[1], momentum[2] / moments[2])


@inner
def _yields(q: Quaternion, torque: Vector, laws: Laws, tensor: int) -> Vector:
    """Return what a torque, or a torque over a time, does to w_body as the program has its inertia; body axes."""
    if tensor == TURNED:
        return _divided(torque, laws.moments)
    there = _to_tensor(q, laws, tensor)
    return rotate_back(there, _divided(rotate(there, torque), laws.moments))


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
    return scale(1.0 / laws.forces.mass, force), _yields(motion.q, torque, laws, laws.tensor)


@inner
def _damped(v: Vector, w: Vector, dt: float, old_v: Vector, old_w: Vector, laws: Laws) -> tuple[Vector, Vector]:
    """Return v and w after damping for dt [s], as a force, by what it is at the old ones."""
    d0, d1, d2, d3, d4 = laws.damping
    if d0 + d1 + d2 + d3 + d4 == 0.0:
        return v, w
    slow, brake = d0 + d1 * math.sqrt(dot(old_v, old_v)), d2 + d3 * math.sqrt(dot(old_w, old_w))
    w = add(add(w, scale(-dt * brake, old_w)), scale(-dt * d4, _divided(old_w, laws.moments)))
    return add(v, scale(-dt * slow, old_v)), w


@inner
def _decayed(v: Vector, w: Vector, dt: float, laws: Laws) -> tuple[Vector, Vector]:
    """Return v and w after a step's damping that takes a share of what they are."""
    if laws.decays == LINEARLY:
        return _damped(v, w, dt, v, w, laws)
    d0, d1, d2, d3, _ = laws.damping
    slow, brake = dt * (d0 + d1 * math.sqrt(dot(v, v))), dt * (d2 + d3 * math.sqrt(dot(w, w)))
    if laws.decays == EXPONENTIALLY:
        return scale(math.exp(-slow), v), scale(math.exp(-brake), w)
    return scale(1.0 / (1.0 + slow), v), scale(1.0 / (1.0 + brake), w)


@inner
def _capped(rate: Vector, cap: float) -> Vector:
    """Return a vector no longer than a cap."""
    size = math.sqrt(dot(rate, rate))
    return scale(cap / size, rate) if size > cap else rate


@inner
def _held(change: Vector, rate: Vector, cap: float) -> Vector:
    """Return the change of a vector that is not let grow longer than a cap."""
    square = dot(rate, rate)
    grows = dot(change, rate)
    return add(change, scale(-grows / square, rate)) if grows > 0.0 and square >= cap * cap else change


@inner
def _gyroscopic(q: Quaternion, w_body: Vector, turning: Vector, laws: Laws) -> Vector:
    """Return I^-1 (L x w), and w x turning where w is kept in world axes; where L is, I^-1 (L x turning)."""
    if laws.tensor != TURNED:
        there = _to_tensor(q, laws, laws.tensor)
        w = rotate(there, w_body)
        return rotate_back(there, scale(laws.gyroscopic, _divided(cross(times(laws.moments, w), w), laws.moments)))
    keeps_momentum = laws.mixed == MIXED_MOMENTUM and laws.gyroscopic != 0.0
    rate = scale(laws.gyroscopic, cross(times(laws.moments, w_body), turning if keeps_momentum else w_body))
    rate = _divided(rate, laws.moments)
    return rate if keeps_momentum or laws.mixed == MIXED_BODY else add(rate, cross(w_body, turning))


@inner
def _slope(motion: Motion, laws: Laws, push: Push) -> Motion:
    turning = _turning(motion.q, motion.w_body, laws)
    a, alpha = _accelerations(motion, laws, push)
    alpha = add(alpha, _gyroscopic(motion.q, motion.w_body, turning, laws))
    a, alpha = _damped(a, alpha, 1.0, motion.v, motion.w_body, laws)
    a, alpha = _held(a, motion.v, laws.caps[0]), _held(alpha, motion.w_body, laws.caps[1])
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
def _runge_kutta_step(motion: Motion, dt: float, laws: Laws, push: Push, order: int) -> Motion:
    """Return the motion dt [s] on by the midpoint rule, Kutta's method of order 3, or the classical one of order 4."""
    if order == 4:
        return _smooth_step(motion, dt, laws, push)
    first = _slope(motion, laws, push)
    second = _slope(_along(motion, dt / 2.0, first), laws, push)
    if order == 2:
        found = _along(motion, dt, second)
    else:
        third = _slope(_along(_along(motion, -dt, first), 2.0 * dt, second), laws, push)
        found = _along(_along(_along(motion, dt / 6.0, first), 2.0 * dt / 3.0, second), dt / 6.0, third)
    return Motion(found.x, normalise(found.q), found.v, found.w_body)


@inner
def _implicit_gyroscopic(w: Vector, dt: float, moments: Vector) -> Vector:
    """Return w after the torque -w x I w, by one Newton step of implicit Euler.

    Source: Catto, "Numerical methods" (Game Developers Conference 2015); so in Bullet's btRigidBody.
    """
    a, b, c = moments
    momentum = times(moments, w)
    off = scale(dt, cross(w, momentum))
    # The derivative of I w' + dt w' x I w' at w.
    first = (a, dt * (c - b) * w[2], dt * (c - b) * w[1])
    second = (dt * (a - c) * w[2], b, dt * (a - c) * w[0])
    third = (dt * (b - a) * w[1], dt * (b - a) * w[0], c)
    return add(w, scale(-1.0, _solved(first, second, third, off)))


@inner
def _solved(first: Vector, second: Vector, third: Vector, right: Vector) -> Vector:
    """Return the solution of a system of three equations by their rows: Cramer's rule."""
    minors = cross(second, third), cross(third, first), cross(first, second)
    solution = add(add(scale(right[0], minors[0]), scale(right[1], minors[1])), scale(right[2], minors[2]))
    return scale(1.0 / dot(first, minors[0]), solution)


@inner
def _backward_gyroscopic(w: Vector, dt: float, moments: Vector) -> Vector:
    """Return w after the torque L x w' of the new w' and the old L, as in the Open Dynamics Engine."""
    a, b, c = moments
    x, y, z = scale(dt, times(moments, w))
    return _solved((a, z, -y), (-z, b, x), (y, -x, c), times(moments, w))


@inner
def _rescaled_gyroscopic(w: Vector, dt: float, moments: Vector) -> Vector:
    """Return w after the torque L x w, with L as long as it was; so in PhysX and Jolt."""
    momentum = times(moments, w)
    after = add(momentum, scale(dt, cross(momentum, w)))
    size = dot(after, after)
    return _divided(scale(math.sqrt(dot(momentum, momentum) / size), after), moments) if size > 0.0 else w


@inner
def _midpoint_gyroscopic(w: Vector, dt: float, moments: Vector) -> Vector:
    """Return w after the torque -w x I w at the mean of the old and the new w."""
    after = w
    for _ in range(ROUNDS):
        mean = scale(0.5, add(w, after))
        after = add(w, scale(dt, _divided(cross(times(moments, mean), mean), moments)))
    return after


@inner
def _spun(motion: Motion, w: Vector, dt: float, laws: Laws, alpha: Vector, spin: int) -> Vector:
    """Return w_body after a step's torques, the attitude standing still; with MOMENTUM the turn comes later."""
    if spin in (EXPLICIT, WORLD):
        w = add(w, scale(dt, _gyroscopic(motion.q, w, _turning(motion.q, w, laws), laws)))
    elif laws.gyroscopic == 1.0:
        if spin == IMPLICIT:
            w = _implicit_gyroscopic(w, dt, laws.moments)
        elif spin == RESCALED:
            w = _rescaled_gyroscopic(w, dt, laws.moments)
        elif spin == BACKWARD:
            w = _backward_gyroscopic(w, dt, laws.moments)
        elif spin == MIDPOINT:
            w = _midpoint_gyroscopic(w, dt, laws.moments)
    return add(w, scale(dt, alpha))


@inner
def _carried(q: Quaternion, q_next: Quaternion, w: Vector, laws: Laws) -> Vector:
    """Return w_body at the next attitude when what the program keeps in world axes, L or w, is kept."""
    if laws.gyroscopic == 0.0:
        return rotate_back(q_next, rotate(q, w))
    return _divided(rotate_back(q_next, rotate(q, times(laws.moments, w))), laws.moments)


@inner
def _turned(q: Quaternion, turn: Vector, attitude: int) -> tuple[Quaternion, float]:
    """Return q turned by a vector [rad], body axes, and how much longer the program has made it."""
    if attitude == EXPONENTIAL:
        return normalise(product(q, exponential(scale(0.5, turn)))), 1.0
    longer = plus(q, product_vector(q, scale(0.5, turn)))
    return normalise(longer), math.sqrt(norm_squared(longer))


@inner
def _euler_step(motion: Motion, dt: float, laws: Laws, push: Push, scheme: Scheme, falls: bool) -> tuple[Motion, float]:
    """Return the motion one step of dt [s] on, and how much longer q would have become; falls: gravity acts."""
    turning = _turning(motion.q, motion.w_body, laws)
    a, alpha = _accelerations(motion, laws, push)
    if not falls and laws.forces.gravity is not None:
        a = add(a, scale(-1.0, laws.forces.gravity))
    old_v, old_w = motion.v, motion.w_body
    if laws.damps == BEFORE_FORCES:
        old_v, old_w = _decayed(old_v, old_w, dt, laws)
    v, w = add(old_v, scale(dt, a)), _spun(motion, old_w, dt, laws, alpha, scheme.spin)
    if laws.damps == AS_FORCE:
        v, w = _damped(v, w, dt, motion.v, motion.w_body, laws)
    elif laws.damps == AFTER_FORCES:
        v, w = _decayed(v, w, dt, laws)
    v, w = _capped(v, laws.caps[0]), _capped(w, laws.caps[1])
    x = add(motion.x, scale(dt, add(motion.v, scale(scheme.fall, add(v, scale(-1.0, motion.v))))))
    turn = scale(dt, _turning(motion.q, w, laws) if scheme.semi else turning)
    q, growth = _turned(motion.q, turn, scheme.attitude)
    if scheme.spin == MOMENTUM:
        w = _carried(motion.q, q, w, laws)
    elif scheme.spin == WORLD:
        w = rotate_back(q, rotate(motion.q, w))
    if laws.damps == LAST:
        v, w = _decayed(v, w, dt, laws)
    return Motion(x, q, v, w), growth


@inner
def _single(a: float) -> float:
    """Return a number rounded to single precision."""
    return np.float64(np.float32(a))


@inner
def _rounded(a: Vector) -> Vector:
    """Return a vector rounded to single precision."""
    return (_single(a[0]), _single(a[1]), _single(a[2]))


@inner
def _kept_in_single(motion: Motion, keeps: int) -> Motion:
    """Return a motion as a program in single precision keeps it, w in world axes; or as far off as that can be."""
    if keeps == BIASED:
        spin = HALF_SINGLE * math.sqrt(dot(motion.w_body, motion.w_body))
        w = add(motion.w_body, (spin, spin, spin))
        return Motion(motion.x, motion.q, scale(1.0 + HALF_SINGLE, motion.v), w)
    q, w_world = motion.q, _rounded(rotate(motion.q, motion.w_body))
    q = (_single(q[0]), _single(q[1]), _single(q[2]), _single(q[3]))
    return Motion(_rounded(motion.x), q, _rounded(motion.v), rotate_back(normalise(q), w_world))


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
    if laws.mixed == UNMIXED and laws.tensor == TURNED:
        rate = min(rate, math.sqrt(dot(momentum, motion.w_body) / least))
    twist = _twist(motion.x, motion.q, push)
    rate += math.sqrt(dot(twist, twist)) / least * interval
    d0, d1, d2, d3, d4 = laws.damping
    return (max(laws.turning, 1.0) * rate + spring_rate + d0 + d1 + d2 + d3 + d4 / least) * interval / turn


@inner
def _lever(motion: Motion, event: Array, laws: Laws) -> Vector:
    """Return the lever arm of an impulse as the program has it, world axes."""
    point = (event[8], event[9], event[10])
    if event[11] != 0.0:
        point = add(motion.x, point if laws.unturned else rotate(motion.q, point))
    sign, share, x, y, z = laws.arm
    return scale(sign, add(point, add(scale(-share, motion.x), (-x, -y, -z))))


@inner
def _struck(motion: Motion, laws: Laws, moves: Vector, twist: Vector) -> Motion:
    """Return the motion after an impulse [N s] and an angular one [N m s], world axes."""
    w = add(motion.w_body, _yields(motion.q, rotate_back(motion.q, twist), laws, laws.struck))
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
    start: Array,
    times_s: Array,
    found: Array,
    laws: Laws,
    events: Array,
    spring_rate: float,
    scheme: Scheme,
    rounding: float,
) -> None:
    """Fly from a state of ours, (13,), at t = 0 to instants [s] that do not decrease, (T,); found: rows, (T, 22).

    events: in the order in which they happen, (E, 16); spring_rate: of the stiffest swing there may be [rad/s];
    rounding: of the instants [s].  Between two instants there are whole steps and a shorter last one, or whole ones
    only where that is the same but for rounding; a smooth flight takes equal ones.
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
    length, now, number, row, steps = 1.0, 0.0, 0, 0, 0
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
            count = max(1, math.ceil(min(ratio - (0.0 if smooth else NEARLY), most)))
            nearest = max(1, round(ratio))
            is_whole = not smooth and ratio <= most and abs(interval - nearest * scheme.step) <= 2.0 * rounding
            if is_whole:
                count = nearest
            for done in range(count):
                dt = scheme.step if is_whole or done < count - 1 else interval - done * scheme.step
                if smooth or ratio > most:
                    dt = interval / count
                if smooth or scheme.attitude == RUNGE_KUTTA:
                    motion = _runge_kutta_step(motion, dt, laws, push, 4 if smooth else scheme.spin)
                    v, w = _capped(motion.v, laws.caps[0]), _capped(motion.w_body, laws.caps[1])
                    motion = Motion(motion.x, motion.q, v, w)
                    continue
                motion, growth = _euler_step(motion, dt, laws, push, scheme, steps >= scheme.idle)
                steps += 1
                if scheme.keeps != AS_IT_IS:
                    motion = _kept_in_single(motion, scheme.keeps)
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
