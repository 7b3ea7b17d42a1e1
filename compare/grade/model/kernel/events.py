"""What impulses, and forces that last, do to a motion as they begin and end."""

from tumble.compare.grade.model.kernel.dynamics import (
    AS_AT_THE_START,
    AS_THE_BODY,
    END,
    JUMP,
    POINT_MOVES,
    POINT_STAYS,
    Array,
    Laws,
    Motion,
    Push,
)
from tumble.compare.grade.model.kernel.rates import angular_response
from tumble.solver.compilation import inner
from tumble.solver.quaternion import rotate, rotate_back
from tumble.solver.vectors import Vector, add, cross, scale


@inner
def _lever(motion: Motion, event: Array, laws: Laws) -> Vector:
    """Return the lever arm of an impulse as the program has it, world axes."""
    point = (event[8], event[9], event[10])
    if event[11] != 0.0:
        if laws.levers == AS_THE_BODY:
            point = rotate(motion.q, point)
        elif laws.levers == AS_AT_THE_START:
            point = rotate(laws.first, point)
        point = add(motion.x, point)
    sign, share, x, y, z = laws.arm
    return scale(sign, add(point, add(scale(-share, motion.x), (-x, -y, -z))))


@inner
def _struck(motion: Motion, laws: Laws, moves: Vector, twist: Vector) -> Motion:
    """Return the motion after an impulse [N s] and an angular one [N m s], world axes."""
    w = add(motion.w_body, angular_response(motion.q, rotate_back(motion.q, twist), laws, laws.struck))
    return Motion(motion.x, motion.q, add(motion.v, scale(1.0 / laws.forces.mass, moves)), w)


@inner
def happen(motion: Motion, push: Push, events: Array, number: int, laws: Laws) -> tuple[Motion, Push, Vector]:
    """Return motion and push after an event, and by how much the angular momentum has jumped, world axes."""
    event = events[number]
    moves, turns = (event[2], event[3], event[4]), (event[5], event[6], event[7])
    nothing = (0.0, 0.0, 0.0)
    if laws.strikes_in_body and event[1] == JUMP:
        moves, turns = rotate(motion.q, moves), rotate(motion.q, turns)
    if event[1] == END:
        begun = events[int(event[15])]
        return motion, _pushed(push, -1, moves, turns, (begun[12], begun[13], begun[14]), laws), nothing
    lever = _lever(motion, event, laws)
    if event[1] == JUMP:
        twist = cross(lever, turns)
        return _struck(motion, laws, moves, twist), push, twist
    if laws.held == POINT_MOVES:
        lever = rotate_back(motion.q, lever)
    elif laws.held == POINT_STAYS:
        lever = add(lever, scale(laws.arm[0] * laws.arm[1], motion.x))
    event[12], event[13], event[14] = lever
    return motion, _pushed(push, 1, moves, turns, lever, laws), nothing


@inner
def _pushed(push: Push, sign: int, moves: Vector, turns: Vector, lever: Vector, laws: Laws) -> Push:
    """Return what lasts once a force that moves, the same that turns and its lever begin, or with sign -1 end."""
    acting, force, turns = push.acting + sign, add(push.force, scale(sign, moves)), scale(sign, turns)
    if laws.held == POINT_MOVES:
        first, second, third = push.rows
        a, b, c = lever
        rows = add(first, scale(a, turns)), add(second, scale(b, turns)), add(third, scale(c, turns))
        return Push(acting, force, push.torque, push.drawn, rows)
    torque = add(push.torque, cross(lever, turns))
    share = laws.arm[0] * laws.arm[1] if laws.held == POINT_STAYS else 0.0
    return Push(acting, force, torque, add(push.drawn, scale(share, turns)), push.rows)
