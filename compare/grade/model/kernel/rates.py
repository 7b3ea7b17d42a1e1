"""The rates of change of a motion in a program: forces, damping, gyroscopic term, attitude."""

import math

from tumble.compare.grade.model.kernel.dynamics import (
    EXPONENTIALLY,
    FROZEN,
    IN_BODY,
    LINEARLY,
    MIXED_BODY,
    MOMENTUM,
    MULTIPLIED,
    NEVER_TURNED,
    NO_OTHERS,
    OVER_MASS,
    OVER_MEAN,
    RESPONSE_UNTURNED,
    TORQUE_UNTURNED,
    TURNED,
    UNDIVIDED,
    UNMIXED,
    Dynamics,
    Motion,
    Push,
)
from tumble.compare.grade.model.kernel.laws import other_drag, other_tethers
from tumble.solver.compilation import borrowing, inlined
from tumble.solver.forces import Forces, wrench
from tumble.solver.quaternion import Quaternion, conjugate, plus, product, product_vector, rotate, rotate_back, stretch
from tumble.solver.vectors import Vector, add, cross, dot, scale, times


@borrowing
def attitude_rate(q: Quaternion, w_body: Vector, dynamics: Dynamics) -> Vector:
    """Return the angular velocity r with which the program rotates the attitude, body axes: q' = q r~ / 2."""
    rate = scale(dynamics.attitude_rate_factor, w_body)
    if dynamics.frame_mixup == UNMIXED:
        return rate
    if dynamics.frame_mixup == MIXED_BODY:
        return rotate_back(q, rotate_back(dynamics.file_axes, rate))
    return rotate(dynamics.file_axes, rotate(q, rate))


@borrowing
def to_tensor(q: Quaternion, dynamics: Dynamics, tensor: int) -> Quaternion:
    """Return the rotation from body axes to those in which the program's inertia tensor is diagonal."""
    if tensor == FROZEN:
        return product(conjugate(dynamics.first), q)
    unturned = product(dynamics.file_axes, q)
    return (
        unturned if tensor == NEVER_TURNED else product(product(dynamics.file_axes, product(q, dynamics.file_axes)), q)
    )


@borrowing
def divided(momentum: Vector, moments: Vector) -> Vector:
    """Return I^-1 L."""
    return (momentum[0] / moments[0], momentum[1] / moments[1], momentum[2] / moments[2])


@borrowing
def angular_response(q: Quaternion, torque: Vector, dynamics: Dynamics, tensor: int) -> Vector:
    """Return the change of w_body by a torque, or an angular impulse, with the program's inertia; body axes."""
    if tensor == TURNED:
        return divided(torque, dynamics.moments)
    if tensor == UNDIVIDED:
        return torque
    if tensor == MULTIPLIED:
        return times(dynamics.moments, torque)
    if tensor == OVER_MASS:
        return scale(1.0 / dynamics.forces.mass, torque)
    if tensor == OVER_MEAN:
        return scale(3.0 / (dynamics.moments[0] + dynamics.moments[1] + dynamics.moments[2]), torque)
    if tensor == RESPONSE_UNTURNED:
        return rotate_back(q, rotate_back(dynamics.file_axes, divided(torque, dynamics.moments)))
    if tensor == TORQUE_UNTURNED:
        return divided(rotate(dynamics.file_axes, rotate(q, torque)), dynamics.moments)
    there = to_tensor(q, dynamics, tensor)
    return rotate_back(there, divided(rotate(there, torque), dynamics.moments))


@borrowing
def twist(x: Vector, q: Quaternion, push: Push) -> Vector:
    """Return the torque of lasting forces, world axes."""
    carried = cross(rotate(q, (1.0, 0.0, 0.0)), push.rows[0])
    carried = add(carried, cross(rotate(q, (0.0, 1.0, 0.0)), push.rows[1]))
    carried = add(carried, cross(rotate(q, (0.0, 0.0, 1.0)), push.rows[2]))
    return add(add(push.torque, carried), cross(push.drawn, x))


@inlined
def accelerations(motion: Motion, dynamics: Dynamics, push: Push) -> tuple[Vector, Vector]:
    """Return a, world axes, and alpha, body axes, without damping and the gyroscopic term."""
    weight_alone = Forces(dynamics.forces.mass, dynamics.forces.gravity, None, None, None, None, *NO_OTHERS)
    force, torque = wrench(motion.x, motion.q, motion.v, motion.w_body, weight_alone)
    if dynamics.is_pulled:
        force, torque = wrench(motion.x, motion.q, motion.v, motion.w_body, dynamics.forces)
    if dynamics.has_floor:
        load, tip = wrench(motion.x, motion.q, motion.v, motion.w_body, dynamics.floor)
        force, torque = add(force, load), add(torque, tip)
    if push.acting > 0:
        force = add(force, push.force)
        torque = add(torque, rotate_back(motion.q, twist(motion.x, motion.q, push)))
    alpha = (0.0, 0.0, 0.0)
    if not dynamics.is_usual:
        slow, brake, alpha = other_drag(motion, dynamics)
        force, torque = add(force, slow), add(torque, brake)
        if dynamics.has_other_tethers:
            pull, turn = other_tethers(motion, dynamics.tethers, dynamics)
            force, torque = add(force, pull), add(torque, turn)
    a = scale(1.0 / dynamics.forces.mass, force)
    gravity = dynamics.forces.gravity
    if not dynamics.is_usual:
        if dynamics.gravity_in_body and gravity is not None:
            a = add(a, add(in_world(motion.q, gravity, dynamics), scale(-1.0, gravity)))
        a = add(a, scale(dynamics.swirl, cross(rotate(motion.q, motion.w_body), motion.v)))
    return a, add(alpha, angular_response(motion.q, torque, dynamics, dynamics.inverse_tensor))


@borrowing
def in_world(q: Quaternion, components: Vector, dynamics: Dynamics) -> Vector:
    """Return a vector whose components are in the file's axes of the body, world axes."""
    return rotate(q, rotate(dynamics.file_axes, components))


@borrowing
def _is_braked(dynamics: Dynamics) -> bool:
    """Whether something is damped along an axis."""
    of_v, of_body, of_world = dynamics.axis_damping
    return dot(of_v, of_v) + dot(of_body, of_body) + dot(of_world, of_world) > 0.0


@borrowing
def _friction(c: float, speed: float, step: float) -> float:
    """Return the rate [1/s] at which dry friction slows a speed down; it stops a body in a step, and reverses none."""
    if speed <= 0.0:
        return 0.0
    return c / speed if c * step < speed else 1.0 / step


@inlined
def _slowed(
    v: Vector, w: Vector, dt: float, step: float, old_v: Vector, old_w: Vector, q: Quaternion, dynamics: Dynamics
) -> tuple[Vector, Vector]:
    """Return v and w after dt [s] of all damping but that in proportion to a velocity, from the old velocities.

    step: length [s] of the program's step.
    """
    if not dynamics.is_usual:
        c0, c1, c2, c3 = dynamics.drag
        speed, spin = math.sqrt(dot(old_v, old_v)), math.sqrt(dot(old_w, old_w))
        slow = dt * (c1 * speed * speed + _friction(c0, speed, step))
        squares = (abs(old_v[0]) * old_v[0], abs(old_v[1]) * old_v[1], abs(old_v[2]) * old_v[2])
        v = add(v, add(scale(-slow, old_v), scale(-dt * c2, squares)))
        w = add(w, scale(-dt * _friction(c3, spin, step), old_w))
    if _is_braked(dynamics):
        of_v, of_body, of_world = dynamics.axis_damping
        v = add(v, scale(-dt, times(of_v, old_v)))
        braked = add(times(of_body, old_w), rotate_back(q, times(of_world, rotate(q, old_w))))
        w = add(w, scale(-dt, braked))
    torque = dynamics.damping[4]
    return v, w if torque == 0.0 else add(w, scale(-dt * torque, divided(old_w, dynamics.moments)))


@inlined
def damped(
    v: Vector, w: Vector, dt: float, step: float, old_v: Vector, old_w: Vector, q: Quaternion, dynamics: Dynamics
) -> tuple[Vector, Vector]:
    """Return v and w after damping for dt [s] as a force, from the old velocities.

    step: length [s] of the program's step.
    """
    v, w = _slowed(v, w, dt, step, old_v, old_w, q, dynamics)
    d0, d1, d2, d3, _ = dynamics.damping
    if d0 + d1 + d2 + d3 == 0.0:
        return v, w
    slow, brake = d0 + d1 * math.sqrt(dot(old_v, old_v)), d2 + d3 * math.sqrt(dot(old_w, old_w))
    return add(v, scale(-dt * slow, old_v)), add(w, scale(-dt * brake, old_w))


@borrowing
def decayed(v: Vector, w: Vector, dt: float, q: Quaternion, dynamics: Dynamics) -> tuple[Vector, Vector]:
    """Return v and w after the damping of a step."""
    if dynamics.damping_form == LINEARLY:
        return damped(v, w, dt, dt, v, w, q, dynamics)
    d0, d1, d2, d3, _ = dynamics.damping
    slow, brake = dt * (d0 + d1 * math.sqrt(dot(v, v))), dt * (d2 + d3 * math.sqrt(dot(w, w)))
    if dynamics.damping_form == EXPONENTIALLY:
        v, w = scale(math.exp(-slow), v), scale(math.exp(-brake), w)
    else:
        v, w = scale(1.0 / (1.0 + slow), v), scale(1.0 / (1.0 + brake), w)
    return _slowed(v, w, dt, dt, v, w, q, dynamics)


@borrowing
def _held(change: Vector, rate: Vector, cap: float) -> Vector:
    """Return the rate of change of a vector whose length is limited by a cap."""
    square = dot(rate, rate)
    grows = dot(change, rate)
    return add(change, scale(-grows / square, rate)) if grows > 0.0 and square >= cap * cap else change


@borrowing
def _held_components(change: Vector, rate: Vector, cap: float) -> Vector:
    """Return the rate of change of a vector each of whose components is limited by a cap."""
    return (
        0.0 if change[0] * rate[0] > 0.0 and abs(rate[0]) >= cap else change[0],
        0.0 if change[1] * rate[1] > 0.0 and abs(rate[1]) >= cap else change[1],
        0.0 if change[2] * rate[2] > 0.0 and abs(rate[2]) >= cap else change[2],
    )


@inlined
def gyroscopic_rate(q: Quaternion, w_body: Vector, dynamics: Dynamics) -> Vector:
    """Return I^-1 (L x w), the gyroscopic term with the program's tensors, body axes."""
    if dynamics.tensor != dynamics.inverse_tensor:
        momentum = times(dynamics.moments, w_body)
        if dynamics.tensor != TURNED:
            there = to_tensor(q, dynamics, dynamics.tensor)
            momentum = rotate_back(there, times(dynamics.moments, rotate(there, w_body)))
        torque = scale(dynamics.gyroscopic, cross(momentum, w_body))
        return angular_response(q, torque, dynamics, dynamics.inverse_tensor)
    if dynamics.tensor == TURNED:
        rate = divided(cross(times(dynamics.moments, w_body), w_body), dynamics.moments)
        return scale(dynamics.gyroscopic, rate)
    there = to_tensor(q, dynamics, dynamics.tensor)
    w = rotate(there, w_body)
    rate = divided(cross(times(dynamics.moments, w), w), dynamics.moments)
    return rotate_back(there, scale(dynamics.gyroscopic, rate))


@borrowing
def _turned_rate(motion: Motion, turns: Vector, dynamics: Dynamics, stored: int) -> Vector:
    """Return the rate of change of w_body without a torque, in a body that rotates with an angular velocity `turns`.

    If w in world axes is stored, it is I^-1 (L x w) + w x r, r: turns; if L is stored, I^-1 (L x r).
    """
    w = motion.w_body
    if stored == MOMENTUM and dynamics.gyroscopic != 0.0:
        return divided(cross(times(dynamics.moments, w), turns), dynamics.moments)
    rate = gyroscopic_rate(motion.q, w, dynamics)
    return rate if stored == IN_BODY else add(rate, cross(w, turns))


@inlined
def slope(motion: Motion, dynamics: Dynamics, push: Push, stored: int, step: float) -> Motion:
    """Return the rates of change in a continuous run, in a step of this length [s]; stored: as in `Scheme`."""
    turns = attitude_rate(motion.q, motion.w_body, dynamics)
    a, alpha = accelerations(motion, dynamics, push)
    alpha = add(alpha, _turned_rate(motion, turns, dynamics, stored))
    a, alpha = damped(a, alpha, 1.0, step, motion.v, motion.w_body, motion.q, dynamics)
    if dynamics.is_capped:
        a, alpha = _held(a, motion.v, dynamics.caps[0]), _held(alpha, motion.w_body, dynamics.caps[1])
        most, most_w = dynamics.component_caps
        if min(most, most_w) < math.inf:
            a = _held_components(a, motion.v, most)
            w, change = rotate(motion.q, motion.w_body), rotate(motion.q, alpha)
            alpha = rotate_back(motion.q, _held_components(change, w, most_w))
    return Motion(motion.v, product_vector(motion.q, scale(0.5, turns)), a, alpha)


@borrowing
def along(motion: Motion, dt: float, slope: Motion) -> Motion:
    """Return the motion after a time [s] at constant rates of change."""
    return Motion(
        add(motion.x, scale(dt, slope.x)),
        plus(motion.q, stretch(dt, slope.q)),
        add(motion.v, scale(dt, slope.v)),
        add(motion.w_body, scale(dt, slope.w_body)),
    )
