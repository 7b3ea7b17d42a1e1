"""Steps of Euler's methods, explicit and symplectic, and what single precision keeps of them."""

import math

import numpy as np

from tumble.compare.grade.model.kernel.dynamics import (
    AFTER_FORCES,
    AS_FORCE,
    BEFORE_FORCES,
    BIASED,
    EXPONENTIAL,
    LAST,
    MIDPOINT,
    MOMENTUM,
    WORLD,
    Array,
    Laws,
    Motion,
    Push,
    Scheme,
)
from tumble.compare.grade.model.kernel.gyroscopic import carried, spun
from tumble.compare.grade.model.kernel.rates import accelerations, damped, decayed, turning
from tumble.solver.compilation import inner
from tumble.solver.quaternion import (
    Quaternion,
    exponential,
    norm_squared,
    normalise,
    plus,
    product,
    product_vector,
    rotate,
    rotate_back,
)
from tumble.solver.vectors import Vector, add, cross, dot, scale

HALF_SINGLE = 2.0**-24


@inner
def capped(rate: Vector, cap: float) -> Vector:
    """Return a vector no longer than a cap."""
    size = math.sqrt(dot(rate, rate))
    return scale(cap / size, rate) if size > cap else rate


@inner
def _turned(q: Quaternion, turn: Vector, attitude: int) -> tuple[Quaternion, float]:
    """Return q turned by a vector [rad], body axes, and how much longer the program has made it."""
    if attitude == EXPONENTIAL:
        return normalise(product(q, exponential(scale(0.5, turn)))), 1.0
    longer = plus(q, product_vector(q, scale(0.5, turn)))
    return normalise(longer), math.sqrt(norm_squared(longer))


@inner
def euler_step(motion: Motion, dt: float, laws: Laws, push: Push, scheme: Scheme, falls: bool) -> tuple[Motion, float]:
    """Return the motion one step of dt [s] on, and how much longer q would have become; falls: gravity acts."""
    turns = turning(motion.q, motion.w_body, laws)
    a, alpha = accelerations(motion, laws, push)
    if not falls and laws.forces.gravity is not None:
        a = add(a, scale(-1.0, laws.forces.gravity))
    old_v, old_w = motion.v, motion.w_body
    if laws.damps == BEFORE_FORCES:
        old_v, old_w = decayed(old_v, old_w, dt, motion.q, laws)
    if laws.damps in (BEFORE_FORCES, AFTER_FORCES):  # engines that damp so let nothing past as it is set, or damped
        old_v, old_w = capped(old_v, laws.caps[0]), capped(old_w, laws.caps[1])
    v, w = add(old_v, scale(dt, a)), spun(motion, old_w, dt, laws, alpha, scheme.spin)
    if laws.damps == AS_FORCE:
        v, w = damped(v, w, dt, motion.v, motion.w_body, motion.q, laws)
    elif laws.damps == AFTER_FORCES:
        v, w = decayed(v, w, dt, motion.q, laws)
    v, w = capped(v, laws.caps[0]), capped(w, laws.caps[1])
    x = add(motion.x, scale(dt, add(motion.v, scale(scheme.fall, add(v, scale(-1.0, motion.v))))))
    mean = scale(0.5, add(motion.w_body, w)) if scheme.spin == MIDPOINT else w
    turn = scale(dt, turning(motion.q, mean, laws) if scheme.semi else turns)
    q, growth = _turned(motion.q, turn, scheme.attitude)
    if scheme.spin == MOMENTUM:
        w = carried(motion.q, q, w, laws)
    elif scheme.spin == WORLD:
        w = rotate_back(q, rotate(motion.q, w))
    if laws.damps == LAST:
        v, w = decayed(v, w, dt, q, laws)
    return Motion(x, q, v, w), growth


@inner
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


@inner
def _single(a: float) -> float:
    """Return a number rounded to single precision."""
    return np.float64(np.float32(a))


@inner
def _rounded(a: Vector) -> Vector:
    """Return a vector rounded to single precision."""
    return (_single(a[0]), _single(a[1]), _single(a[2]))


@inner
def kept_in_single(motion: Motion, keeps: int) -> Motion:
    """Return a motion as a program in single precision keeps it, w in world axes; or as far off as that can be."""
    if keeps == BIASED:
        spin = HALF_SINGLE * math.sqrt(dot(motion.w_body, motion.w_body))
        w = add(motion.w_body, (spin, spin, spin))
        return Motion(motion.x, motion.q, scale(1.0 + HALF_SINGLE, motion.v), w)
    q, w_world = motion.q, _rounded(rotate(motion.q, motion.w_body))
    q = (_single(q[0]), _single(q[1]), _single(q[2]), _single(q[3]))
    return Motion(_rounded(motion.x), q, _rounded(motion.v), rotate_back(normalise(q), w_world))
