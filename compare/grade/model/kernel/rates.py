"""The rates of change of a motion as the program has them: forces, damping, the gyroscopic term, the attitude."""

import math

from tumble.compare.grade.model.kernel.dynamics import (
    EXPONENTIALLY,
    FROZEN,
    LINEARLY,
    MIXED_BODY,
    MIXED_MOMENTUM,
    NEVER_TURNED,
    TORQUE_UNTURNED,
    TURNED,
    UNMIXED,
    Laws,
    Motion,
    Push,
)
from tumble.solver.compilation import inner
from tumble.solver.forces import wrench
from tumble.solver.quaternion import Quaternion, conjugate, plus, product, product_vector, rotate, rotate_back, stretch
from tumble.solver.vectors import Vector, add, cross, dot, scale, times


@inner
def turning(q: Quaternion, w_body: Vector, laws: Laws) -> Vector:
    """Return the rate at which the program turns the attitude, body axes: q' = q turning~ / 2."""
    rate = scale(laws.turning, w_body)
    if laws.mixed == UNMIXED:
        return rate
    return rotate_back(q, rate) if laws.mixed == MIXED_BODY else rotate(q, rate)


@inner
def to_tensor(q: Quaternion, laws: Laws, tensor: int) -> Quaternion:
    """Return the rotation from body axes to those in which the program's inertia tensor is diagonal."""
    if tensor == NEVER_TURNED:
        return q
    return product(conjugate(laws.first), q) if tensor == FROZEN else product(q, q)


@inner
def divided(momentum: Vector, moments: Vector) -> Vector:
    """Return I^-1 L."""
    return (momentum[0] / moments[0], momentum[1] / moments[1], momentum[2] / moments[2])


@inner
def angular_response(q: Quaternion, torque: Vector, laws: Laws, tensor: int) -> Vector:
    """Return what a torque, or a torque over a time, does to w_body as the program has its inertia; body axes."""
    if tensor == TURNED:
        return divided(torque, laws.moments)
    if tensor == TORQUE_UNTURNED:
        return divided(rotate(q, torque), laws.moments)
    there = to_tensor(q, laws, tensor)
    return rotate_back(there, divided(rotate(there, torque), laws.moments))


@inner
def twist(x: Vector, q: Quaternion, push: Push) -> Vector:
    """Return the torque of forces that last, world axes."""
    carried = cross(rotate(q, (1.0, 0.0, 0.0)), push.rows[0])
    carried = add(carried, cross(rotate(q, (0.0, 1.0, 0.0)), push.rows[1]))
    carried = add(carried, cross(rotate(q, (0.0, 0.0, 1.0)), push.rows[2]))
    return add(add(push.torque, carried), cross(push.drawn, x))


@inner
def accelerations(motion: Motion, laws: Laws, push: Push) -> tuple[Vector, Vector]:
    """Return a, world axes, and alpha, body axes, without damping and the gyroscopic term."""
    force, torque = wrench(motion.x, motion.q, motion.v, motion.w_body, laws.forces)
    if push.acting > 0:
        force = add(force, push.force)
        torque = add(torque, rotate_back(motion.q, twist(motion.x, motion.q, push)))
    return scale(1.0 / laws.forces.mass, force), angular_response(motion.q, torque, laws, laws.tensor)


@inner
def _is_braked(laws: Laws) -> bool:
    """Whether something is damped along an axis."""
    of_v, of_body, of_world = laws.brakes
    return dot(of_v, of_v) + dot(of_body, of_body) + dot(of_world, of_world) > 0.0


@inner
def damped(
    v: Vector, w: Vector, dt: float, old_v: Vector, old_w: Vector, q: Quaternion, laws: Laws
) -> tuple[Vector, Vector]:
    """Return v and w after damping for dt [s], as a force, by what it is at the old ones."""
    d0, d1, d2, d3, d4 = laws.damping
    if _is_braked(laws):
        of_v, of_body, of_world = laws.brakes
        v = add(v, scale(-dt, times(of_v, old_v)))
        braked = add(times(of_body, old_w), rotate_back(q, times(of_world, rotate(q, old_w))))
        w = add(w, scale(-dt, braked))
    if d0 + d1 + d2 + d3 + d4 == 0.0:
        return v, w
    slow, brake = d0 + d1 * math.sqrt(dot(old_v, old_v)), d2 + d3 * math.sqrt(dot(old_w, old_w))
    w = add(add(w, scale(-dt * brake, old_w)), scale(-dt * d4, divided(old_w, laws.moments)))
    return add(v, scale(-dt * slow, old_v)), w


@inner
def decayed(v: Vector, w: Vector, dt: float, q: Quaternion, laws: Laws) -> tuple[Vector, Vector]:
    """Return v and w after a step's damping that takes a share of what they are."""
    if laws.decays == LINEARLY:
        return damped(v, w, dt, v, w, q, laws)
    d0, d1, d2, d3, _ = laws.damping
    slow, brake = dt * (d0 + d1 * math.sqrt(dot(v, v))), dt * (d2 + d3 * math.sqrt(dot(w, w)))
    if laws.decays == EXPONENTIALLY:
        return scale(math.exp(-slow), v), scale(math.exp(-brake), w)
    return scale(1.0 / (1.0 + slow), v), scale(1.0 / (1.0 + brake), w)


@inner
def _held(change: Vector, rate: Vector, cap: float) -> Vector:
    """Return the change of a vector that is not let grow longer than a cap."""
    square = dot(rate, rate)
    grows = dot(change, rate)
    return add(change, scale(-grows / square, rate)) if grows > 0.0 and square >= cap * cap else change


@inner
def gyroscopic_rate(q: Quaternion, w_body: Vector, turning: Vector, laws: Laws) -> Vector:
    """Return I^-1 (L x w), and w x turning where w is kept in world axes; where L is, I^-1 (L x turning)."""
    if laws.tensor != TURNED:
        there = to_tensor(q, laws, laws.tensor)
        w = rotate(there, w_body)
        return rotate_back(there, scale(laws.gyroscopic, divided(cross(times(laws.moments, w), w), laws.moments)))
    keeps_momentum = laws.mixed == MIXED_MOMENTUM and laws.gyroscopic != 0.0
    rate = scale(laws.gyroscopic, cross(times(laws.moments, w_body), turning if keeps_momentum else w_body))
    rate = divided(rate, laws.moments)
    return rate if keeps_momentum or laws.mixed == MIXED_BODY else add(rate, cross(w_body, turning))


@inner
def slope(motion: Motion, laws: Laws, push: Push, smooth: bool) -> Motion:
    """Return the rates of change; smooth: speeds do not grow past their caps, which steps see to afterwards."""
    turns = turning(motion.q, motion.w_body, laws)
    a, alpha = accelerations(motion, laws, push)
    alpha = add(alpha, gyroscopic_rate(motion.q, motion.w_body, turns, laws))
    a, alpha = damped(a, alpha, 1.0, motion.v, motion.w_body, motion.q, laws)
    if smooth:
        a, alpha = _held(a, motion.v, laws.caps[0]), _held(alpha, motion.w_body, laws.caps[1])
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
