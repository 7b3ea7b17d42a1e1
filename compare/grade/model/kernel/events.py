"""The effect of impulses, and of the start and end of lasting forces."""

from tumble.compare.grade.model.kernel.dynamics import (
    AS_AT_THE_START,
    AS_THE_BODY,
    AXES_OF_BODY,
    AXES_TURNED_BACK,
    END,
    JUMP,
    POINT_MOVES,
    POINT_STAYS,
    Array,
    Dynamics,
    Motion,
    Push,
)
from tumble.compare.grade.model.kernel.rates import angular_response, in_world
from tumble.solver.compilation import borrowing, inner
from tumble.solver.quaternion import rotate, rotate_back
from tumble.solver.vectors import Vector, add, cross, scale


@borrowing
def _lever(motion: Motion, event: Array, dynamics: Dynamics, length: float) -> Vector:
    """Return the program's lever of an impulse, world axes; length: of the quaternion, which scales its matrix."""
    point = (event[8], event[9], event[10])
    if event[11] != 0.0:
        if dynamics.lever_axes == AS_THE_BODY:
            point = scale(length * length, rotate(motion.q, point))
        elif dynamics.lever_axes == AS_AT_THE_START:
            point = rotate(dynamics.first, point)
        else:
            point = rotate_back(dynamics.file_axes, point)
        point = add(motion.x, point)
    sign, share, x, y, z = dynamics.lever
    return scale(sign, add(point, add(scale(-share, motion.x), (-x, -y, -z))))


@borrowing
def _after_impulse(motion: Motion, dynamics: Dynamics, moves: Vector, twist: Vector, length: float) -> Motion:
    """Return the motion after an impulse [N s] and an angular one [N m s], world axes; length: of the quaternion."""
    spins = angular_response(motion.q, rotate_back(motion.q, twist), dynamics, dynamics.impulse_tensor)
    kept = 0.0 if dynamics.impulse_sets else 1.0
    v = add(scale(kept, motion.v), scale(1.0 / dynamics.forces.mass, moves))
    return Motion(motion.x, motion.q, v, add(scale(kept, motion.w_body), scale(length**4, spins)))


@borrowing
def _turned(motion: Motion, impulse: Vector, dynamics: Dynamics) -> Vector:
    """Return an impulse as the program takes its components, world axes."""
    if dynamics.impulse_axes == AXES_OF_BODY:
        return in_world(motion.q, impulse, dynamics)
    if dynamics.impulse_axes == AXES_TURNED_BACK:
        return rotate_back(dynamics.file_axes, rotate_back(motion.q, impulse))
    return impulse


@inner
def happen(
    motion: Motion, push: Push, events: Array, number: int, dynamics: Dynamics, length: float
) -> tuple[Motion, Push, Vector]:
    """Return motion and lasting forces after an event, and the jump of the angular momentum, world axes."""
    event = events[number]
    moves, turns = (event[2], event[3], event[4]), (event[5], event[6], event[7])
    nothing = (0.0, 0.0, 0.0)
    if event[1] == JUMP:
        moves, turns = _turned(motion, moves, dynamics), _turned(motion, turns, dynamics)
    if event[1] == END:
        begun = events[int(event[15])]
        return motion, _pushed(push, -1, moves, turns, (begun[12], begun[13], begun[14]), dynamics), nothing
    lever = _lever(motion, event, dynamics, length)
    if event[1] == JUMP:
        twist = cross(lever, turns)
        return _after_impulse(motion, dynamics, moves, twist, length), push, twist
    if dynamics.lever_motion == POINT_MOVES:
        lever = rotate_back(motion.q, lever)
    elif dynamics.lever_motion == POINT_STAYS:
        lever = add(lever, scale(dynamics.lever[0] * dynamics.lever[1], motion.x))
    event[12], event[13], event[14] = lever
    return motion, _pushed(push, 1, moves, turns, lever, dynamics), nothing


@borrowing
def _pushed(push: Push, sign: int, moves: Vector, turns: Vector, lever: Vector, dynamics: Dynamics) -> Push:
    """Return the lasting forces after a force, its part for the rotation and its lever begin, or with sign -1 end."""
    acting, force, turns = push.acting + sign, add(push.force, scale(sign, moves)), scale(sign, turns)
    if dynamics.lever_motion == POINT_MOVES:
        first, second, third = push.rows
        a, b, c = lever
        rows = add(first, scale(a, turns)), add(second, scale(b, turns)), add(third, scale(c, turns))
        return Push(acting, force, push.torque, push.drawn, rows)
    torque = add(push.torque, cross(lever, turns))
    share = dynamics.lever[0] * dynamics.lever[1] if dynamics.lever_motion == POINT_STAYS else 0.0
    return Push(acting, force, torque, add(push.drawn, scale(share, turns)), push.rows)
