"""Steps that evaluate the rates of change several times: Runge-Kutta methods, and velocity Verlet."""

import math

from tumble.compare.grade.model.kernel.dynamics import (
    AFTER_FORCES,
    AS_FORCE,
    BEFORE_FORCES,
    HEUN,
    IN_BODY,
    IN_WORLD,
    LAST,
    MOMENTUM,
    OF_UNIT,
    ORDER_2,
    ORDER_3,
    ORDER_4,
    RALSTON,
    RAW,
    SHU_OSHER,
    TURNED,
    UNMIXED,
    VERLET,
    Dynamics,
    Motion,
    Push,
    Scheme,
)
from tumble.compare.grade.model.kernel.rates import (
    accelerations,
    along,
    attitude_rate,
    damped,
    decayed,
    divided,
    gyroscopic_rate,
    slope,
    twist,
)
from tumble.compare.grade.model.kernel.turning import turned
from tumble.solver.compilation import borrowing, inlined
from tumble.solver.quaternion import (
    Quaternion,
    conjugate,
    normalise,
    product,
    product_vector,
    rotate,
    rotate_back,
)
from tumble.solver.vectors import Vector, add, cross, dot, scale, times

# Steps while a force spins the body up, over the root of the radians and over `turn`.
SPINNING_UP = 3.0

# Stages of an explicit method: their number, the rows of its matrix without zeros above the diagonal, and its weights.
Tableau = tuple[int, float, tuple[float, float], tuple[float, float, float], tuple[float, float, float, float]]


@borrowing
def _tableau(method: int) -> Tableau:
    """Return the coefficients of a method.  Source: Hairer, Norsett, Wanner I, Sec. II.1; Shu and Osher (1988)."""
    if method == ORDER_4:
        return 4, 1 / 2, (0.0, 1 / 2), (0.0, 0.0, 1.0), (1 / 6, 1 / 3, 1 / 3, 1 / 6)
    if method == ORDER_2:
        return 2, 1 / 2, (0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0)
    if method == HEUN:
        return 2, 1.0, (0.0, 0.0), (0.0, 0.0, 0.0), (1 / 2, 1 / 2, 0.0, 0.0)
    if method == RALSTON:
        return 2, 2 / 3, (0.0, 0.0), (0.0, 0.0, 0.0), (1 / 4, 3 / 4, 0.0, 0.0)
    if method == ORDER_3:
        return 3, 1 / 2, (-1.0, 2.0), (0.0, 0.0, 0.0), (1 / 6, 2 / 3, 1 / 6, 0.0)
    if method == SHU_OSHER:
        return 3, 1.0, (1 / 4, 1 / 4), (0.0, 0.0, 0.0), (1 / 6, 1 / 6, 2 / 3, 0.0)
    return 4, 1 / 3, (-1 / 3, 1.0), (1.0, -1.0, 1.0), (1 / 8, 3 / 8, 3 / 8, 1 / 8)


@borrowing
def _stored(motion: Motion, dynamics: Dynamics, stored: int) -> Motion:
    """Return a motion with what the program stores of the rotation, w or L in world axes, in the place of w_body."""
    if stored == IN_BODY:
        return motion
    spin = times(dynamics.moments, motion.w_body) if stored == MOMENTUM else motion.w_body
    return Motion(motion.x, motion.q, motion.v, rotate(motion.q, spin))


@borrowing
def _unrotated(q: Quaternion, a: Vector) -> Vector:
    """Return M^-1 a for the matrix M of a quaternion of any length by the formula for unit quaternions.

    It is the identity along the vector u of q, and a rotation times a factor across it.
    """
    w, axis = q[0], (q[1], q[2], q[3])
    square = dot(axis, axis)
    across = cross(axis, a)
    size = (1.0 - 2.0 * square) ** 2 + 4.0 * w * w * square
    twice = scale((4.0 * (w * w + square) - 2.0) / size, cross(axis, across))
    return add(add(a, scale(-2.0 * w / size, across)), twice)


@borrowing
def _in_file_axes(a: Vector, dynamics: Dynamics, is_divided: bool) -> Vector:
    """Return a vector in the file's axes of the body times the inertia tensor, or divided by it.

    The matrix of a quaternion that is not normalised is no product of two: so it is that of the file's axes.
    """
    there = rotate(dynamics.file_axes, a)
    there = divided(there, dynamics.moments) if is_divided else times(dynamics.moments, there)
    return rotate_back(dynamics.file_axes, there)


@borrowing
def _answered(q: Quaternion, torque: Vector, dynamics: Dynamics, stages: int) -> Vector:
    """Return J^-1 T with the inertia tensor in world axes of a stage whose quaternion is not normalised.

    J = M I M^T; or J^-1 is M I^-1 M^T.
    """
    own = product(q, dynamics.file_axes)
    if stages == RAW:
        return _unrotated(conjugate(own), _in_file_axes(_unrotated(own, torque), dynamics, True))
    return rotate(own, _in_file_axes(rotate_back(own, torque), dynamics, True))


@borrowing
def _is_raw(dynamics: Dynamics, scheme: Scheme) -> bool:
    """Return whether the tensor is of the quaternions of the stages as they are."""
    return scheme.stages >= RAW and scheme.stored != IN_BODY and dynamics.tensor == dynamics.inverse_tensor == TURNED


@borrowing
def _read(state: Motion, dynamics: Dynamics, scheme: Scheme, is_stage: bool) -> Motion:
    """Return the motion of a state that `_stored` returned, with a unit quaternion; is_stage: it was not normalised."""
    q = normalise(state.q)
    if scheme.stored == IN_BODY:
        return Motion(state.x, q, state.v, state.w_body)
    if scheme.stored == MOMENTUM and is_stage and _is_raw(dynamics, scheme):
        return Motion(state.x, q, state.v, rotate_back(q, _answered(state.q, state.w_body, dynamics, scheme.stages)))
    spin = rotate_back(q, state.w_body)
    return Motion(state.x, q, state.v, divided(spin, dynamics.moments) if scheme.stored == MOMENTUM else spin)


@inlined
def _slope(state: Motion, dynamics: Dynamics, push: Push, scheme: Scheme, step: float) -> Motion:
    """Return the rates of change of a state that is stored, in a step of this length [s].

    Levers of forces that last are rotated by unit quaternions whatever the stages are.
    """
    stored = scheme.stored
    motion = _read(state, dynamics, scheme, True)
    turns = attitude_rate(motion.q, motion.w_body, dynamics)
    a, alpha = accelerations(motion, dynamics, push)
    if stored == IN_WORLD and _is_raw(dynamics, scheme):
        torque = rotate(motion.q, times(dynamics.moments, alpha))
        own = product(state.q, dynamics.file_axes)
        momentum = rotate(own, _in_file_axes(rotate_back(own, state.w_body), dynamics, False))
        torque = add(torque, scale(dynamics.gyroscopic, cross(momentum, state.w_body)))
        alpha = rotate_back(motion.q, _answered(state.q, torque, dynamics, scheme.stages))
    elif stored != MOMENTUM or dynamics.gyroscopic == 0.0:
        alpha = add(alpha, gyroscopic_rate(motion.q, motion.w_body, dynamics))
    if dynamics.damping_place == AS_FORCE:
        a, alpha = damped(a, alpha, 1.0, step, motion.v, motion.w_body, motion.q, dynamics)
    if stored == MOMENTUM:
        alpha = times(dynamics.moments, alpha)
    if stored != IN_BODY:
        alpha = rotate(motion.q, alpha)
    q = motion.q if scheme.stages == OF_UNIT else state.q
    return Motion(motion.v, product_vector(q, scale(0.5, turns)), a, alpha)


@borrowing
def _explicit(state: Motion, dt: float, dynamics: Dynamics, push: Push, scheme: Scheme) -> Motion:
    """Return the state dt [s] on, by an explicit Runge-Kutta method."""
    stages, second_row, third_row, fourth_row, weights = _tableau(scheme.spin)
    one = _slope(state, dynamics, push, scheme, dt)
    two = _slope(along(state, dt * second_row, one), dynamics, push, scheme, dt)
    found = along(along(state, dt * weights[0], one), dt * weights[1], two)
    if stages == 2:
        return found
    three = _slope(along(along(state, dt * third_row[0], one), dt * third_row[1], two), dynamics, push, scheme, dt)
    found = along(found, dt * weights[2], three)
    if stages == 3:
        return found
    last = along(along(along(state, dt * fourth_row[0], one), dt * fourth_row[1], two), dt * fourth_row[2], three)
    return along(found, dt * weights[3], _slope(last, dynamics, push, scheme, dt))


@borrowing
def continuous_step(motion: Motion, dt: float, dynamics: Dynamics, push: Push, stored: int) -> Motion:
    """Return the motion dt [s] on in a run without steps of its own, by the classical method of order 4."""
    first = slope(motion, dynamics, push, stored, dt)
    second = slope(along(motion, dt / 2.0, first), dynamics, push, stored, dt)
    third = slope(along(motion, dt / 2.0, second), dynamics, push, stored, dt)
    fourth = slope(along(motion, dt, third), dynamics, push, stored, dt)
    found = along(along(motion, dt / 6.0, first), dt / 3.0, second)
    found = along(along(found, dt / 3.0, third), dt / 6.0, fourth)
    return Motion(found.x, normalise(found.q), found.v, found.w_body)


@inlined
def _kicked(motion: Motion, dt: float, dynamics: Dynamics, push: Push, stored: int) -> Motion:
    """Return a motion whose velocities have changed for dt [s], L by the torque only."""
    a, alpha = accelerations(motion, dynamics, push)
    if stored != MOMENTUM:
        alpha = add(alpha, gyroscopic_rate(motion.q, motion.w_body, dynamics))
    if dynamics.damping_place == AS_FORCE:
        a, alpha = damped(a, alpha, 1.0, dt, motion.v, motion.w_body, motion.q, dynamics)
    return Motion(motion.x, motion.q, add(motion.v, scale(dt, a)), add(motion.w_body, scale(dt, alpha)))


@borrowing
def _velocity_verlet(motion: Motion, dt: float, dynamics: Dynamics, push: Push, scheme: Scheme) -> Motion:
    """Return the motion dt [s] on: half a kick, a drift, half a kick.

    In the drift the body rotates about the new w; if L is stored, about the w that L gives after half of the rotation.
    """
    half = _kicked(motion, dt / 2.0, dynamics, push, scheme.stored)
    turns, w = attitude_rate(half.q, half.w_body, dynamics), half.w_body
    momentum = rotate(half.q, times(dynamics.moments, w))
    if scheme.stored == MOMENTUM:
        midway, _ = turned(half.q, scale(dt / 2.0, turns), scheme.rotation, dynamics.file_axes)
        turns = attitude_rate(midway, divided(rotate_back(midway, momentum), dynamics.moments), dynamics)
        if dynamics.frame_mixup == UNMIXED:
            turns = rotate_back(half.q, rotate(midway, turns))
    q, _ = turned(half.q, scale(dt, turns), scheme.rotation, dynamics.file_axes)
    if scheme.stored == MOMENTUM:
        w = divided(rotate_back(q, momentum), dynamics.moments)
    elif dynamics.frame_mixup != UNMIXED:
        w = rotate_back(q, rotate(half.q, w))
    moved = Motion(add(half.x, scale(dt, half.v)), q, half.v, w)
    return _kicked(moved, dt / 2.0, dynamics, push, scheme.stored)


@borrowing
def runge_kutta_step(motion: Motion, dt: float, dynamics: Dynamics, push: Push, scheme: Scheme) -> Motion:
    """Return the motion dt [s] on by the method of a scheme."""
    if dynamics.damping_place == BEFORE_FORCES:
        motion = _decayed(motion, dt, dynamics)
    if scheme.spin == VERLET:
        motion = _velocity_verlet(motion, dt, dynamics, push, scheme)
    else:
        state = _explicit(_stored(motion, dynamics, scheme.stored), dt, dynamics, push, scheme)
        motion = _read(state, dynamics, scheme, False)
    is_late = dynamics.damping_place in (AFTER_FORCES, LAST)
    return _decayed(motion, dt, dynamics) if is_late else motion


@borrowing
def _decayed(motion: Motion, dt: float, dynamics: Dynamics) -> Motion:
    """Return a motion after the damping of a step."""
    v, w = decayed(motion.v, motion.w_body, dt, motion.q, dynamics)
    return Motion(motion.x, motion.q, v, w)


@borrowing
def smooth_count(
    motion: Motion, interval: float, dynamics: Dynamics, push: Push, spring_rate: float, turn: float
) -> float:
    """Return the number of steps in which the body rotates, and the stiffest spring oscillates, by at most `turn`.

    L and, unless frames are mixed up, the energy limit the angular velocity of a free body.  While a lasting force
    spins it up, the error is of the square of the rotation, but of the fourth order of the step.
    """
    least = min(dynamics.moments)
    momentum = times(dynamics.moments, motion.w_body)
    rate = math.sqrt(dot(momentum, momentum)) / least
    if dynamics.frame_mixup == UNMIXED and dynamics.tensor == dynamics.inverse_tensor == TURNED:
        rate = min(rate, math.sqrt(dot(momentum, motion.w_body) / least))
    torque = twist(motion.x, motion.q, push)
    spun_up = math.sqrt(dot(torque, torque)) / least * interval
    rate += spun_up
    d0, d1, d2, d3, d4 = dynamics.damping
    braked = max(dynamics.axis_damping[0]) + max(dynamics.axis_damping[1]) + max(dynamics.axis_damping[2])
    turns = max(abs(dynamics.attitude_rate_factor), 1.0) * rate
    rate = turns + spring_rate + abs(d0) + d1 + abs(d2) + d3 + d4 / least + braked
    return max(rate * interval, SPINNING_UP * math.sqrt(spun_up * interval)) / turn
