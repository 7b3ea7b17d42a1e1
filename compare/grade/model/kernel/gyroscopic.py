"""The change of the angular velocity in a step: the engines' schemes for the gyroscopic term."""

import math

from tumble.compare.grade.model.kernel.dynamics import (
    BACKWARD,
    CONVERGED,
    ENERGY_KEPT,
    EXPLICIT,
    HEUN_SPIN,
    IMPLICIT,
    MIDPOINT,
    MIDPOINT_BY_NEW,
    MOMENTUM,
    ORDER_4_SPIN,
    RESCALED,
    TURNED,
    Dynamics,
    Motion,
    Scheme,
)
from tumble.compare.grade.model.kernel.rates import divided, gyroscopic_rate, to_tensor
from tumble.solver.compilation import borrowing, inlined
from tumble.solver.quaternion import Quaternion, rotate, rotate_back
from tumble.solver.vectors import Vector, add, cross, dot, scale, times

# Fixed-point iterations of the midpoint rule at most, each of which reduces the error by |w| dt, and Newton steps of
# implicit Euler until it has converged.
ROUNDS, NEWTON_STEPS = 12, 5


@borrowing
def _implicit_gyroscopic(w: Vector, dt: float, moments: Vector, steps: int) -> Vector:
    """Return w after the torque -w x I w, by Newton steps of implicit Euler from w on.

    Source: Catto, "Numerical methods" (Game Developers Conference 2015); one step: so in Bullet's btRigidBody.
    """
    a, b, c = moments
    after = w
    for _ in range(steps):
        x, y, z = after
        off = add(times(moments, add(after, scale(-1.0, w))), scale(dt, cross(after, times(moments, after))))
        # The derivative of I w' + dt w' x I w'.
        first = (a, dt * (c - b) * z, dt * (c - b) * y)
        second = (dt * (a - c) * z, b, dt * (a - c) * x)
        third = (dt * (b - a) * y, dt * (b - a) * x, c)
        after = add(after, scale(-1.0, _solved(first, second, third, off)))
    return after


@borrowing
def _solved(first: Vector, second: Vector, third: Vector, right: Vector) -> Vector:
    """Return the solution of a system of three equations by their rows: Cramer's rule."""
    minors = cross(second, third), cross(third, first), cross(first, second)
    solution = add(add(scale(right[0], minors[0]), scale(right[1], minors[1])), scale(right[2], minors[2]))
    return scale(1.0 / dot(first, minors[0]), solution)


@borrowing
def _backward_gyroscopic(w: Vector, dt: float, moments: Vector) -> Vector:
    """Return w after the torque L x w' of the new w' and the old L, as in the Open Dynamics Engine."""
    a, b, c = moments
    x, y, z = scale(dt, times(moments, w))
    return _solved((a, z, -y), (-z, b, x), (y, -x, c), times(moments, w))


@borrowing
def _rescaled_gyroscopic(w: Vector, dt: float, moments: Vector) -> Vector:
    """Return w after the torque L x w, with L as long as it was; so in PhysX and Jolt."""
    momentum = times(moments, w)
    after = add(momentum, scale(dt, cross(momentum, w)))
    size = dot(after, after)
    return divided(scale(math.sqrt(dot(momentum, momentum) / size), after), moments) if size > 0.0 else w


@borrowing
def _midpoint_gyroscopic(w: Vector, dt: float, moments: Vector) -> Vector:
    """Return w after the torque -w x I w at the mean of the old and the new w."""
    after, before = w, (math.nan, math.nan, math.nan)
    for _ in range(ROUNDS):
        if after == before:
            break
        mean = scale(0.5, add(w, after))
        before, after = after, add(w, scale(dt, divided(cross(times(moments, mean), mean), moments)))
    return after


@borrowing
def _rate(w: Vector, moments: Vector) -> Vector:
    """Return I^-1 (L x w)."""
    return divided(cross(times(moments, w), w), moments)


@borrowing
def _energy_kept_gyroscopic(w: Vector, dt: float, moments: Vector) -> Vector:
    """Return w after an explicit step, scaled so that the energy stays."""
    after = add(w, scale(dt, _rate(w, moments)))
    old, new = dot(w, times(moments, w)), dot(after, times(moments, after))
    return scale(math.sqrt(old / new), after) if new > 0.0 else w


@borrowing
def _heun_gyroscopic(w: Vector, dt: float, moments: Vector) -> Vector:
    """Return w after a step of Heun's method."""
    first = _rate(w, moments)
    second = _rate(add(w, scale(dt, first)), moments)
    return add(w, scale(0.5 * dt, add(first, second)))


@borrowing
def _classical_gyroscopic(w: Vector, dt: float, moments: Vector) -> Vector:
    """Return w after a step of the classical Runge-Kutta method."""
    first = _rate(w, moments)
    second = _rate(add(w, scale(0.5 * dt, first)), moments)
    third = _rate(add(w, scale(0.5 * dt, second)), moments)
    fourth = _rate(add(w, scale(dt, third)), moments)
    return add(w, scale(dt / 6.0, add(add(first, fourth), scale(2.0, add(second, third)))))


@borrowing
def _by_scheme(w: Vector, dt: float, moments: Vector, spin: int) -> Vector:
    """Return w, in the axes of the inertia tensor, after a step of the gyroscopic term by one of the schemes."""
    if spin in (IMPLICIT, CONVERGED):
        return _implicit_gyroscopic(w, dt, moments, 1 if spin == IMPLICIT else NEWTON_STEPS)
    if spin == RESCALED:
        return _rescaled_gyroscopic(w, dt, moments)
    if spin == BACKWARD:
        return _backward_gyroscopic(w, dt, moments)
    if spin in (MIDPOINT, MIDPOINT_BY_NEW):
        return _midpoint_gyroscopic(w, dt, moments)
    if spin == ENERGY_KEPT:
        return _energy_kept_gyroscopic(w, dt, moments)
    if spin == HEUN_SPIN:
        return _heun_gyroscopic(w, dt, moments)
    return _classical_gyroscopic(w, dt, moments) if spin == ORDER_4_SPIN else w


@inlined
def spun(motion: Motion, w: Vector, dt: float, dynamics: Dynamics, alpha: Vector, scheme: Scheme) -> Vector:
    """Return w_body after the torques of a step at constant attitude; if L is stored, its rotation comes later."""
    if scheme.stored != MOMENTUM:
        is_mixed = dynamics.tensor != dynamics.inverse_tensor
        if scheme.spin == EXPLICIT or dynamics.gyroscopic not in (0.0, 1.0) or is_mixed:
            w = add(w, scale(dt, gyroscopic_rate(motion.q, w, dynamics)))
        elif dynamics.gyroscopic == 1.0 and dynamics.tensor == TURNED:
            w = _by_scheme(w, dt, dynamics.moments, scheme.spin)
        elif dynamics.gyroscopic == 1.0:
            there = to_tensor(motion.q, dynamics, dynamics.tensor)
            w = rotate_back(there, _by_scheme(rotate(there, w), dt, dynamics.moments, scheme.spin))
    return add(w, scale(dt, alpha))


@borrowing
def carried(q: Quaternion, q_next: Quaternion, w: Vector, dynamics: Dynamics) -> Vector:
    """Return w_body at the next attitude if L, or w, in world axes is constant."""
    if dynamics.gyroscopic == 0.0:
        return rotate_back(q_next, rotate(q, w))
    return divided(rotate_back(q_next, rotate(q, times(dynamics.moments, w))), dynamics.moments)
