"""Steps of Euler's methods, explicit and symplectic, and their rounding to single precision."""

import math

import numpy as np

from tumble.compare.grade.model.kernel.dynamics import (
    AFTER_FORCES,
    ALONG_SCREW,
    AS_FORCE,
    BEFORE_FORCES,
    BIASED,
    CAP_BEFORE,
    CAP_FORCED,
    CAP_MOVED,
    CAP_WHEN_SET,
    IN_BODY,
    IN_WORLD_AXES,
    LAST,
    MIDPOINT,
    MOMENTUM,
    ROUNDED_TWICE,
    SCALED,
    Array,
    Dynamics,
    Motion,
    Push,
    Scheme,
)
from tumble.compare.grade.model.kernel.gyroscopic import carried, spun
from tumble.compare.grade.model.kernel.rates import accelerations, attitude_rate, damped, decayed
from tumble.compare.grade.model.kernel.turning import recovered, turned
from tumble.solver.compilation import borrowing, inlined
from tumble.solver.quaternion import Quaternion, normalise, rotate, rotate_back
from tumble.solver.vectors import Vector, add, cross, dot, scale

HALF_SINGLE = 2.0**-24
# Square of a rotation in a step [rad] below which its second order is rounding.
SMALL_SQUARE = 1e-16


@borrowing
def _capped(rate: Vector, cap: float) -> Vector:
    """Return a vector no longer than a cap."""
    size = math.sqrt(dot(rate, rate))
    return scale(cap / size, rate) if size > cap else rate


@borrowing
def limited(v: Vector, w: Vector, q: Quaternion, dynamics: Dynamics) -> tuple[Vector, Vector]:
    """Return v and w, body axes, below the caps."""
    v, w = _capped(v, dynamics.caps[0]), _capped(w, dynamics.caps[1])
    most, most_w = dynamics.component_caps
    if min(most, most_w) < math.inf:
        v = _capped_components(v, most)
        w = rotate_back(q, _capped_components(rotate(q, w), most_w))
    return v, w


@borrowing
def _capped_components(rate: Vector, cap: float) -> Vector:
    """Return a vector none of whose components is larger than a cap."""
    return (
        min(cap, max(-cap, rate[0])),
        min(cap, max(-cap, rate[1])),
        min(cap, max(-cap, rate[2])),
    )


@borrowing
def _along_screw(v: Vector, turn: Vector) -> Vector:
    """Return the mean of a velocity that is rotated by a vector [rad] in a step (the left Jacobian of SO(3))."""
    square = dot(turn, turn)
    if square < SMALL_SQUARE:
        return add(v, scale(0.5, cross(turn, v)))
    angle, across = math.sqrt(square), cross(turn, v)
    mean = add(v, scale((1.0 - math.cos(angle)) / square, across))
    return add(mean, scale((angle - math.sin(angle)) / (square * angle), cross(turn, across)))


@inlined
def euler_step(
    motion: Motion, dt: float, dynamics: Dynamics, push: Push, scheme: Scheme, falls: bool
) -> tuple[Motion, float]:
    """Return the motion after a step of dt [s], and the factor on the length of q; falls: gravity acts."""
    a, alpha = accelerations(motion, dynamics, push)
    if not falls and dynamics.forces.gravity is not None:
        a = add(a, scale(-1.0, dynamics.forces.gravity))
    old_v, old_w = motion.v, motion.w_body
    if dynamics.damping_place == BEFORE_FORCES:
        old_v, old_w = decayed(old_v, old_w, dt, motion.q, dynamics)
    if dynamics.is_capped and dynamics.cap_place in (CAP_WHEN_SET, CAP_BEFORE):
        old_v, old_w = limited(old_v, old_w, motion.q, dynamics)
    if scheme.velocity_axes != IN_WORLD_AXES:
        a = add(a, cross(old_v, rotate(motion.q, old_w)))
    v, w = add(old_v, scale(dt, a)), spun(motion, old_w, dt, dynamics, alpha, scheme)
    if dynamics.damping_place == AS_FORCE:
        v, w = damped(v, w, dt, dt, motion.v, motion.w_body, motion.q, dynamics)
    elif dynamics.damping_place == AFTER_FORCES:
        v, w = decayed(v, w, dt, motion.q, dynamics)
    if dynamics.is_capped and dynamics.cap_place in (CAP_FORCED, CAP_WHEN_SET):
        v, w = limited(v, w, motion.q, dynamics)
    moves = add(old_v, scale(scheme.position_weight, add(v, scale(-1.0, old_v))))
    mean = scale(0.5, add(old_w, w)) if scheme.spin == MIDPOINT and scheme.stored != MOMENTUM else w
    turn = scale(dt, attitude_rate(motion.q, mean if scheme.symplectic else old_w, dynamics))
    if scheme.velocity_axes == ALONG_SCREW:
        moves = _along_screw(moves, rotate(motion.q, scale(dt, w)))
    x = add(motion.x, scale(dt, moves))
    q, growth = turned(motion.q, turn, scheme.attitude, dynamics.file_axes)
    if scheme.velocity_axes != IN_WORLD_AXES:
        v = rotate(q, rotate_back(motion.q, v))
    if scheme.stored == MOMENTUM:
        w = carried(motion.q, q, w, dynamics)
    elif scheme.stored != IN_BODY:
        w = rotate_back(q, rotate(motion.q, w))
    if scheme.recovers:
        w = recovered(motion.q, q, dt)
    if dynamics.damping_place == LAST:
        v, w = decayed(v, w, dt, q, dynamics)
    if dynamics.is_capped and dynamics.cap_place == CAP_MOVED:
        v, w = limited(v, w, q, dynamics)
    return Motion(x, q, v, w), growth


@borrowing
def matrix_step(columns: Array, dt: float, momentum: Vector, moments: Vector) -> Vector:
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


@borrowing
def _single(a: float) -> float:
    """Return a number rounded to single precision."""
    return np.float64(np.float32(a))


@borrowing
def _rounded(a: Vector) -> Vector:
    """Return a vector rounded to single precision."""
    return (_single(a[0]), _single(a[1]), _single(a[2]))


@borrowing
def _to_single_twice(before: Vector, after: Vector) -> Vector:
    """Return a vector rounded to single precision after each half of its change in a step."""
    half = scale(0.5, add(after, scale(-1.0, before)))
    return _rounded(add(_rounded(add(before, half)), half))


@borrowing
def _summed(a: float, b: float, c: float, d: float) -> float:
    """Return the sum of four products in single precision."""
    return _single(_single(_single(_single(a) + _single(b)) + _single(c)) + _single(d))


@borrowing
def _recovered_in_single(old: Quaternion, new: Quaternion, dt: float) -> Vector:
    """Return `recovered` if each operation of the product is rounded, which is a large part of a small difference."""
    a, b, c, d = old
    w, x, y, z = new
    factor = 2.0 / dt if w * a + x * b + y * c + z * d >= 0.0 else -2.0 / dt
    about_x = _summed(-w * b, x * a, -y * d, z * c)
    about_y = _summed(-w * c, x * d, y * a, -z * b)
    about_z = _summed(-w * d, -x * c, y * b, z * a)
    return rotate_back(new, scale(factor, (about_x, about_y, about_z)))


@borrowing
def to_single(before: Motion, motion: Motion, precision: int, recovered_in: float) -> Motion:
    """Return a motion after a step in single precision: see `dynamics`; before: the step.

    recovered_in: the time between the attitudes of which w is taken [s], 0 if it is not.
    """
    if precision == SCALED:
        return Motion(motion.x, motion.q, motion.v, scale(1.0 + HALF_SINGLE, motion.w_body))
    if precision == BIASED:
        bias = HALF_SINGLE * math.sqrt(dot(motion.w_body, motion.w_body))
        return Motion(motion.x, motion.q, motion.v, add(motion.w_body, (bias, bias, bias)))
    q = normalise((_single(motion.q[0]), _single(motion.q[1]), _single(motion.q[2]), _single(motion.q[3])))
    w = motion.w_body
    if recovered_in > 0.0:
        exact = recovered(before.q, motion.q, recovered_in)
        w = add(w, add(_recovered_in_single(before.q, q, recovered_in), scale(-1.0, exact)))
    if precision == ROUNDED_TWICE:
        w = _to_single_twice(before.w_body, w)
        return Motion(_to_single_twice(before.x, motion.x), q, _to_single_twice(before.v, motion.v), w)
    w = rotate_back(q, _rounded(rotate(motion.q, w)))
    return Motion(_rounded(motion.x), q, _rounded(motion.v), w)
