"""Drag and tethers of the scene by another law than the scene's."""

import math

from tumble.compare.grade.model.kernel.dynamics import (
    AS_AT_THE_START,
    AS_THE_BODY,
    FROM_ORIGIN,
    NO_LEVER,
    Array,
    Dynamics,
    Motion,
)
from tumble.solver.compilation import borrowing
from tumble.solver.quaternion import rotate, rotate_back
from tumble.solver.vectors import Vector, add, cross, dot, scale


@borrowing
def other_drag(motion: Motion, dynamics: Dynamics) -> tuple[Vector, Vector, Vector]:
    """Return a force, world axes, a torque and an angular acceleration, body axes."""
    quadratic, quadratic_spin, undivided = dynamics.other_drag
    v, w = motion.v, motion.w_body
    force = scale(-quadratic * math.sqrt(dot(v, v)), v)
    return force, scale(-quadratic_spin * math.sqrt(dot(w, w)), w), scale(-undivided, w)


@borrowing
def other_tethers(motion: Motion, tethers: Array, dynamics: Dynamics) -> tuple[Vector, Vector]:
    """Return the force of all tethers, world axes, and their torque, body axes."""
    force, torque = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    for number in range(len(tethers)):
        one, twist = _other_tether(motion, tethers, number, dynamics)
        force, torque = add(force, one), add(torque, twist)
    return scale(dynamics.tether_law.moves, force), rotate_back(motion.q, torque)


@borrowing
def _other_tether(motion: Motion, tethers: Array, number: int, dynamics: Dynamics) -> tuple[Vector, Vector]:
    """Return the force of a tether and its torque, world axes."""
    law = dynamics.tether_law
    point = (tethers[number, 0], tethers[number, 1], tethers[number, 2])
    anchor = (tethers[number, 3], tethers[number, 4], tethers[number, 5])
    stiffness, damping, rest_length = tethers[number, 6], tethers[number, 7], tethers[number, 8]
    lever = _lever(motion, point, law.lever, dynamics)
    offset = add(add(motion.x, lever), scale(-1.0, anchor))
    velocity = motion.v
    if not law.damps_centre:
        velocity = add(velocity, cross(rotate(motion.q, motion.w_body), lever))
    length = math.sqrt(dot(offset, offset))
    tension = 0.0
    if length > 0.0:
        tension = stiffness * (length - rest_length)
        if (rest_length != 0.0) != law.other_damper:
            tension += damping * dot(velocity, offset) / length
            damping = 0.0
        tension /= length
    if law.pulls_only and length < rest_length:
        tension, damping = 0.0, 0.0
    force = add(scale(-tension, offset), scale(-damping, velocity))
    return force, cross(_lever(motion, point, law.torque_lever, dynamics), force)


@borrowing
def _lever(motion: Motion, point: Vector, lever: int, dynamics: Dynamics) -> Vector:
    """Return the vector from the centre of mass to a point of the body, as the program has it, world axes."""
    if lever == AS_THE_BODY:
        return rotate(motion.q, point)
    if lever == AS_AT_THE_START:
        return rotate(dynamics.first, point)
    if lever == FROM_ORIGIN:
        return add(motion.x, rotate(motion.q, point))
    if lever == NO_LEVER:
        return (0.0, 0.0, 0.0)
    return rotate_back(dynamics.file_axes, point)
