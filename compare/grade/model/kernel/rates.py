"""The rates of change of a motion in a program: forces, damping, gyroscopic term, attitude."""

import math

from tumble.compare.grade.model.kernel.dynamics import (
    EXPONENTIALLY,
    FROZEN,
    IN_BODY,
    LINEARLY,
    MIXED_BODY,
    MOMENTUM,
    NEVER_TURNED,
    TORQUE_UNTURNED,
    TURNED,
    UNMIXED,
    Dynamics,
    Motion,
    Push,
)
from tumble.solver.compilation import inner
from tumble.solver.forces import wrench
from tumble.solver.quaternion import Quaternion, conjugate, plus, product, product_vector, rotate, rotate_back, stretch
from tumble.solver.vectors import Vector, add, cross, dot, scale, times


@inner
def attitude_rate(q: Quaternion, w_body: Vector, dynamics: Dynamics) -> Vector:
    """Return the angular velocity r with which the program rotates the attitude, body axes: q' = q r~ / 2."""
    rate = scale(dynamics.attitude_rate_factor, w_body)
    if dynamics.frame_mixup == UNMIXED:
        return rate
    if dynamics.frame_mixup == MIXED_BODY:
        return rotate_back(q, rotate_back(dynamics.file_axes, rate))
    return rotate(dynamics.file_axes, rotate(q, rate))


@inner
def to_tensor(q: Quaternion, dynamics: Dynamics, tensor: int) -> Quaternion:
    """Return the rotation from body axes to those in which the program's inertia tensor is diagonal."""
    if tensor == FROZEN:
        return product(conjugate(dynamics.first), q)
    unturned = product(dynamics.file_axes, q)
    return (
        unturned if tensor == NEVER_TURNED else product(product(dynamics.file_axes, product(q, dynamics.file_axes)), q)
    )


@inner
def divided(momentum: Vector, moments: Vector) -> Vector:
    """Return I^-1 L."""
    return (momentum[0] / moments[0], momentum[1] / moments[1], momentum[2] / moments[2])


@inner
def angular_response(q: Quaternion, torque: Vector, dynamics: Dynamics, tensor: int) -> Vector:
    """Return the change of w_body by a torque, or an angular impulse, with the program's inertia; body axes."""
    if tensor == TURNED:
        return divided(torque, dynamics.moments)
    if tensor == TORQUE_UNTURNED:
        return divided(rotate(dynamics.file_axes, rotate(q, torque)), dynamics.moments)
    there = to_tensor(q, dynamics, tensor)
    return rotate_back(there, divided(rotate(there, torque), dynamics.moments))


@inner
def twist(x: Vector, q: Quaternion, push: Push) -> Vector:
    """Return the torque of lasting forces, world axes."""
    carried = cross(rotate(q, (1.0, 0.0, 0.0)), push.rows[0])
    carried = add(carried, cross(rotate(q, (0.0, 1.0, 0.0)), push.rows[1]))
    carried = add(carried, cross(rotate(q, (0.0, 0.0, 1.0)), push.rows[2]))
    return add(add(push.torque, carried), cross(push.drawn, x))


@inner
def accelerations(motion: Motion, dynamics: Dynamics, push: Push) -> tuple[Vector, Vector]:
    """Return a, world axes, and alpha, body axes, without damping and the gyroscopic term."""
    force, torque = wrench(motion.x, motion.q, motion.v, motion.w_body, dynamics.forces)
    if push.acting > 0:
        force = add(force, push.force)
        torque = add(torque, rotate_back(motion.q, twist(motion.x, motion.q, push)))
    return scale(1.0 / dynamics.forces.mass, force), angular_response(motion.q, torque, dynamics, dynamics.tensor)


@inner
def _is_braked(dynamics: Dynamics) -> bool:
    """Whether something is damped along an axis."""
    of_v, of_body, of_world = dynamics.axis_damping
    return dot(of_v, of_v) + dot(of_body, of_body) + dot(of_world, of_world) > 0.0


@inner
def damped(
    v: Vector, w: Vector, dt: float, old_v: Vector, old_w: Vector, q: Quaternion, dynamics: Dynamics
) -> tuple[Vector, Vector]:
    """Return v and w after damping for dt [s] as a force, from the old velocities."""
    d0, d1, d2, d3, d4 = dynamics.damping
    if _is_braked(dynamics):
        of_v, of_body, of_world = dynamics.axis_damping
        v = add(v, scale(-dt, times(of_v, old_v)))
        braked = add(times(of_body, old_w), rotate_back(q, times(of_world, rotate(q, old_w))))
        w = add(w, scale(-dt, braked))
    if d0 + d1 + d2 + d3 + d4 == 0.0:
        return v, w
    slow, brake = d0 + d1 * math.sqrt(dot(old_v, old_v)), d2 + d3 * math.sqrt(dot(old_w, old_w))
    w = add(add(w, scale(-dt * brake, old_w)), scale(-dt * d4, divided(old_w, dynamics.moments)))
    return add(v, scale(-dt * slow, old_v)), w


@inner
def decayed(v: Vector, w: Vector, dt: float, q: Quaternion, dynamics: Dynamics) -> tuple[Vector, Vector]:
    """Return v and w after the damping of a step."""
    if dynamics.damping_form == LINEARLY:
        return damped(v, w, dt, v, w, q, dynamics)
    d0, d1, d2, d3, _ = dynamics.damping
    slow, brake = dt * (d0 + d1 * math.sqrt(dot(v, v))), dt * (d2 + d3 * math.sqrt(dot(w, w)))
    if dynamics.damping_form == EXPONENTIALLY:
        return scale(math.exp(-slow), v), scale(math.exp(-brake), w)
    return scale(1.0 / (1.0 + slow), v), scale(1.0 / (1.0 + brake), w)


@inner
def _held(change: Vector, rate: Vector, cap: float) -> Vector:
    """Return the rate of change of a vector whose length is limited by a cap."""
    square = dot(rate, rate)
    grows = dot(change, rate)
    return add(change, scale(-grows / square, rate)) if grows > 0.0 and square >= cap * cap else change


@inner
def gyroscopic_rate(q: Quaternion, w_body: Vector, dynamics: Dynamics) -> Vector:
    """Return I^-1 (L x w), the gyroscopic term with the program's tensor, body axes."""
    if dynamics.tensor == TURNED:
        rate = divided(cross(times(dynamics.moments, w_body), w_body), dynamics.moments)
        return scale(dynamics.gyroscopic, rate)
    there = to_tensor(q, dynamics, dynamics.tensor)
    w = rotate(there, w_body)
    rate = divided(cross(times(dynamics.moments, w), w), dynamics.moments)
    return rotate_back(there, scale(dynamics.gyroscopic, rate))


@inner
def _turned_rate(motion: Motion, turns: Vector, dynamics: Dynamics, stored: int) -> Vector:
    """Return the rate of change of w_body without a torque, in a body that rotates with an angular velocity `turns`.

    If w in world axes is stored, it is I^-1 (L x w) + w x r, r: turns; if L is stored, I^-1 (L x r).
    """
    w = motion.w_body
    if stored == MOMENTUM and dynamics.gyroscopic != 0.0:
        return divided(cross(times(dynamics.moments, w), turns), dynamics.moments)
    rate = gyroscopic_rate(motion.q, w, dynamics)
    return rate if stored == IN_BODY else add(rate, cross(w, turns))


@inner
def slope(motion: Motion, dynamics: Dynamics, push: Push, stored: int) -> Motion:
    """Return the rates of change in a continuous run; stored: what the program stores of the rotation."""
    turns = attitude_rate(motion.q, motion.w_body, dynamics)
    a, alpha = accelerations(motion, dynamics, push)
    alpha = add(alpha, _turned_rate(motion, turns, dynamics, stored))
    a, alpha = damped(a, alpha, 1.0, motion.v, motion.w_body, motion.q, dynamics)
    a, alpha = _held(a, motion.v, dynamics.caps[0]), _held(alpha, motion.w_body, dynamics.caps[1])
    return Motion(motion.v, product_vector(motion.q, scale(0.5, turns)), a, alpha)


@inner
def along(motion: Motion, dt: float, slope: Motion) -> Motion:
    """Return the motion after a time [s] at constant rates of change."""
    return Motion(
        add(motion.x, scale(dt, slope.x)),
        plus(motion.q, stretch(dt, slope.q)),
        add(motion.v, scale(dt, slope.v)),
        add(motion.w_body, scale(dt, slope.w_body)),
    )
