"""Steps that evaluate the rates of change several times: Runge-Kutta methods, and velocity Verlet."""

import math

from tumble.compare.grade.model.kernel.dynamics import (
    HEUN,
    IN_WORLD,
    ORDER_3,
    ORDER_4,
    TURNED,
    UNMIXED,
    VERLET,
    Dynamics,
    Motion,
    Push,
)
from tumble.compare.grade.model.kernel.rates import along, attitude_rate, slope, twist
from tumble.solver.compilation import inner
from tumble.solver.quaternion import exponential, normalise, product, rotate, rotate_back
from tumble.solver.vectors import add, dot, scale, times


@inner
def _slope(motion: Motion, dynamics: Dynamics, push: Push, smooth: bool, in_world: bool) -> Motion:
    """Return the rates of change; in_world: motion has w in world axes, and so is its rate."""
    if not in_world:
        return slope(motion, dynamics, push, smooth)
    q = normalise(motion.q)
    found = slope(Motion(motion.x, q, motion.v, rotate_back(q, motion.w_body)), dynamics, push, smooth)
    x, y, z = scale(0.5, motion.w_body)
    return Motion(found.x, product((0.0, x, y, z), motion.q), found.v, rotate(q, found.w_body))


@inner
def _classical(motion: Motion, dt: float, dynamics: Dynamics, push: Push, smooth: bool, in_world: bool) -> Motion:
    """Return the motion dt [s] on, by the classical Runge-Kutta method of order 4."""
    first = _slope(motion, dynamics, push, smooth, in_world)
    second = _slope(along(motion, dt / 2.0, first), dynamics, push, smooth, in_world)
    third = _slope(along(motion, dt / 2.0, second), dynamics, push, smooth, in_world)
    fourth = _slope(along(motion, dt, third), dynamics, push, smooth, in_world)
    found = along(along(motion, dt / 6.0, first), dt / 3.0, second)
    return along(along(found, dt / 3.0, third), dt / 6.0, fourth)


@inner
def _lower_order(motion: Motion, dt: float, dynamics: Dynamics, push: Push, method: int, in_world: bool) -> Motion:
    """Return the motion dt [s] on by the midpoint rule, Heun's method or Kutta's of order 3."""
    first = _slope(motion, dynamics, push, False, in_world)
    if method == HEUN:
        second = _slope(along(motion, dt, first), dynamics, push, False, in_world)
        return along(along(motion, dt / 2.0, first), dt / 2.0, second)
    second = _slope(along(motion, dt / 2.0, first), dynamics, push, False, in_world)
    if method != ORDER_3:
        return along(motion, dt, second)
    third = _slope(along(along(motion, -dt, first), 2.0 * dt, second), dynamics, push, False, in_world)
    return along(along(along(motion, dt / 6.0, first), 2.0 * dt / 3.0, second), dt / 6.0, third)


@inner
def _velocity_verlet(motion: Motion, dt: float, dynamics: Dynamics, push: Push) -> Motion:
    """Return the motion dt [s] on: half a kick, a drift by rotation about the new w, half a kick."""
    kick = slope(motion, dynamics, push, False)
    v, w = add(motion.v, scale(dt / 2.0, kick.v)), add(motion.w_body, scale(dt / 2.0, kick.w_body))
    q = product(motion.q, exponential(scale(dt / 2.0, attitude_rate(motion.q, w, dynamics))))
    drifted = Motion(add(motion.x, scale(dt, v)), normalise(q), v, w)
    kick = slope(drifted, dynamics, push, False)
    return Motion(drifted.x, drifted.q, add(v, scale(dt / 2.0, kick.v)), add(w, scale(dt / 2.0, kick.w_body)))


@inner
def runge_kutta_step(motion: Motion, dt: float, dynamics: Dynamics, push: Push, method: int, smooth: bool) -> Motion:
    """Return the motion dt [s] on by one of the methods of `laws`; smooth: the run is continuous."""
    if method == VERLET:
        return _velocity_verlet(motion, dt, dynamics, push)
    in_world = method > IN_WORLD
    if in_world:
        method -= IN_WORLD
        motion = Motion(motion.x, motion.q, motion.v, rotate(motion.q, motion.w_body))
    if method == ORDER_4:
        found = _classical(motion, dt, dynamics, push, smooth, in_world)
    else:
        found = _lower_order(motion, dt, dynamics, push, method, in_world)
    q = normalise(found.q)
    return Motion(found.x, q, found.v, rotate_back(q, found.w_body) if in_world else found.w_body)


@inner
def smooth_count(
    motion: Motion, interval: float, dynamics: Dynamics, push: Push, spring_rate: float, turn: float
) -> float:
    """Return the number of steps in which the body rotates, and the stiffest spring oscillates, by at most `turn`.

    L and, unless frames are mixed up, the energy limit the angular velocity of a free body.
    """
    least = min(dynamics.moments)
    momentum = times(dynamics.moments, motion.w_body)
    rate = math.sqrt(dot(momentum, momentum)) / least
    if dynamics.frame_mixup == UNMIXED and dynamics.tensor == TURNED:
        rate = min(rate, math.sqrt(dot(momentum, motion.w_body) / least))
    torque = twist(motion.x, motion.q, push)
    rate += math.sqrt(dot(torque, torque)) / least * interval
    d0, d1, d2, d3, d4 = dynamics.damping
    braked = max(dynamics.axis_damping[0]) + max(dynamics.axis_damping[1]) + max(dynamics.axis_damping[2])
    return (
        (max(dynamics.attitude_rate_factor, 1.0) * rate + spring_rate + d0 + d1 + d2 + d3 + d4 / least + braked)
        * interval
        / turn
    )
