"""The change of the angular velocity in a step: the engines' schemes for the gyroscopic term."""

import math

from tumble.compare.grade.model.kernel.dynamics import (
    BACKWARD,
    EXPLICIT,
    IMPLICIT,
    MIDPOINT,
    RESCALED,
    TURNED,
    WORLD,
    Dynamics,
    Motion,
)
from tumble.compare.grade.model.kernel.rates import attitude_rate, divided, gyroscopic_rate, to_tensor
from tumble.solver.compilation import inner
from tumble.solver.quaternion import Quaternion, rotate, rotate_back
from tumble.solver.vectors import Vector, add, cross, dot, scale, times

# Fixed-point iterations of the midpoint rule; each reduces the error by |w| dt.
ROUNDS = 12


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
    return divided(scale(math.sqrt(dot(momentum, momentum) / size), after), moments) if size > 0.0 else w


@inner
def _midpoint_gyroscopic(w: Vector, dt: float, moments: Vector) -> Vector:
    """Return w after the torque -w x I w at the mean of the old and the new w."""
    after = w
    for _ in range(ROUNDS):
        mean = scale(0.5, add(w, after))
        after = add(w, scale(dt, divided(cross(times(moments, mean), mean), moments)))
    return after


@inner
def _by_scheme(w: Vector, dt: float, moments: Vector, spin: int) -> Vector:
    """Return w, in the axes of the inertia tensor, after a step of the gyroscopic term by one of the schemes."""
    if spin == IMPLICIT:
        return _implicit_gyroscopic(w, dt, moments)
    if spin == RESCALED:
        return _rescaled_gyroscopic(w, dt, moments)
    if spin == BACKWARD:
        return _backward_gyroscopic(w, dt, moments)
    return _midpoint_gyroscopic(w, dt, moments) if spin == MIDPOINT else w


@inner
def spun(motion: Motion, w: Vector, dt: float, dynamics: Dynamics, alpha: Vector, spin: int) -> Vector:
    """Return w_body after the torques of a step at constant attitude; with MOMENTUM, the rotation comes later."""
    if spin in (EXPLICIT, WORLD):
        w = add(w, scale(dt, gyroscopic_rate(motion.q, w, attitude_rate(motion.q, w, dynamics), dynamics)))
    elif dynamics.gyroscopic == 1.0 and dynamics.tensor == TURNED:
        w = _by_scheme(w, dt, dynamics.moments, spin)
    elif dynamics.gyroscopic == 1.0:
        there = to_tensor(motion.q, dynamics, dynamics.tensor)
        w = rotate_back(there, _by_scheme(rotate(there, w), dt, dynamics.moments, spin))
    return add(w, scale(dt, alpha))


@inner
def carried(q: Quaternion, q_next: Quaternion, w: Vector, dynamics: Dynamics) -> Vector:
    """Return w_body at the next attitude if L, or w, in world axes is constant."""
    if dynamics.gyroscopic == 0.0:
        return rotate_back(q_next, rotate(q, w))
    return divided(rotate_back(q_next, rotate(q, times(dynamics.moments, w))), dynamics.moments)
