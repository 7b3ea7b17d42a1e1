"""The equations of motion and the force laws: one function a law, one sum.

The body is told by its centre of mass x, its velocity v, its three axes as world vectors, and its angular momentum L
in world axes, all of them numbers of one array of `SIZE`.  Every law is written for real and for complex numbers alike:
the derivatives that an implicit step needs are taken from these same lines by a complex step.

A force is a function here, a table in `Forces` (of no rows where the scene has none) and a line of `pull`.
"""

from typing import NamedTuple

import numpy as np

from scenarios.frames import Array
from scenarios.truth.forced.compilation import inlined

Vector = tuple  # of three numbers, all real or all complex

# Where the numbers of a state stand: x, v, axis 1, axis 2, axis 3, L.
X, V, AXES, MOMENTUM, SIZE = 0, 3, 6, 15, 18


class Forces(NamedTuple):
    """Tables of the forces, one row each.

    gravity [m/s2], (0 or 1, 3); tethers: point in body axes [m], anchor [m], stiffness [N/m], damping [N s/m], rest
    length [m], (k, 9); drag: linear [N s/m], angular [N m s/rad], (0 or 1, 2); floor: normal, height [m], stiffness
    [N/m], damping [N s/m], (0 or 1, 6).
    """

    gravity: Array
    tethers: Array
    drag: Array
    floor: Array


class Solid(NamedTuple):
    """mass [kg], principal moments [kg m2], (3,), vertices in body axes [m], (n, 3), the farthest of them [m]."""

    mass: float
    moments: Array
    points: Array
    radius: float


class Motion(NamedTuple):
    """x [m], v [m/s], the body's axes 1, 2 and 3, L [kg m2/s] and w [rad/s], each a world vector."""

    x: Vector
    v: Vector
    axis_1: Vector
    axis_2: Vector
    axis_3: Vector
    L: Vector
    w: Vector


@inlined
def add(a: Vector, b: Vector) -> Vector:
    """Return a + b."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


@inlined
def scale(factor: float, a: Vector) -> Vector:
    """Return a times a number."""
    return (factor * a[0], factor * a[1], factor * a[2])


@inlined
def dot(a: Vector, b: Vector) -> float:
    """Return a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inlined
def cross(a: Vector, b: Vector) -> Vector:
    """Return a x b."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@inlined
def three(row: Array, at: int) -> Vector:
    """Return three numbers of a row as a vector."""
    return (row[at], row[at + 1], row[at + 2])


@inlined
def motion_of(y: Array, solid: Solid) -> Motion:
    """Return what a state (SIZE,) says, with w = R I^-1 R^T L."""
    axis_1, axis_2, axis_3, L = three(y, AXES), three(y, AXES + 3), three(y, AXES + 6), three(y, MOMENTUM)
    w_1, w_2, w_3 = (
        dot(axis_1, L) / solid.moments[0],
        dot(axis_2, L) / solid.moments[1],
        dot(axis_3, L) / solid.moments[2],
    )
    w = add(add(scale(w_1, axis_1), scale(w_2, axis_2)), scale(w_3, axis_3))
    return Motion(three(y, X), three(y, V), axis_1, axis_2, axis_3, L, w)


@inlined
def slope(y: np.ndarray, solid: Solid, forces: Forces, pressing: np.ndarray, rates: np.ndarray) -> None:
    """Write dy/dt of a state into rates, (SIZE,): x' = v, m v' = F, each axis e' = w x e, L' = torque.

    pressing: which vertices the floor pushes, (n,).  Source: Goldstein, "Classical Mechanics" (1980), eqs. 1-24, 4-86.
    """
    motion = motion_of(y, solid)
    force, torque = pull(motion, solid, forces, pressing)
    put(rates, X, motion.v)
    put(rates, V, scale(1.0 / solid.mass, force))
    put(rates, AXES, cross(motion.w, motion.axis_1))
    put(rates, AXES + 3, cross(motion.w, motion.axis_2))
    put(rates, AXES + 6, cross(motion.w, motion.axis_3))
    put(rates, MOMENTUM, torque)


@inlined
def put(row: Array, at: int, a: Vector) -> None:
    """Write a vector into three numbers of a row."""
    row[at], row[at + 1], row[at + 2] = a


@inlined
def pull(motion: Motion, solid: Solid, forces: Forces, pressing: np.ndarray) -> tuple[Vector, Vector]:
    """Return the sum of all forces [N] and of their torques about the centre of mass [N m]."""
    total = (scale(0.0, motion.v), scale(0.0, motion.L))
    for row in range(len(forces.gravity)):
        total = both(total, weight(forces.gravity[row], solid))
    for row in range(len(forces.tethers)):
        total = both(total, tether_pull(forces.tethers[row], motion))
    for row in range(len(forces.drag)):
        total = both(total, drag_pull(forces.drag[row], motion))
    for row in range(len(forces.floor)):
        total = both(total, floor_push(forces.floor[row], motion, solid, pressing))
    return total


@inlined
def both(a: tuple[Vector, Vector], b: tuple[Vector, Vector]) -> tuple[Vector, Vector]:
    """Return the sum of two pairs of force and torque."""
    return add(a[0], b[0]), add(a[1], b[1])


@inlined
def acting_at(lever: Vector, force: Vector) -> tuple[Vector, Vector]:
    """Return a force and its torque, lever x F."""
    return force, cross(lever, force)


@inlined
def weight(gravity: Array, solid: Solid) -> tuple[Vector, Vector]:
    """Return F = m g."""
    return scale(solid.mass, three(gravity, 0)), (0.0, 0.0, 0.0)


@inlined
def tether_pull(tether: Array, motion: Motion) -> tuple[Vector, Vector]:
    """Return F = -k d - c p', or with a rest length along the line only: F = -(k (|d| - l0) + c d'.u) u, u = d/|d|."""
    lever, d, d_rate = tether_line(tether, motion)
    stiffness, damping, rest_length = tether[6], tether[7], tether[8]
    if rest_length == 0.0:
        return acting_at(lever, add(scale(-stiffness, d), scale(-damping, d_rate)))
    length = np.sqrt(dot(d, d))
    u = scale(1.0 / length, d)
    return acting_at(lever, scale(-(stiffness * (length - rest_length) + damping * dot(d_rate, u)), u))


@inlined
def tether_line(tether: Array, motion: Motion) -> tuple[Vector, Vector, Vector]:
    """Return lever R p, d = p - anchor and p' of a tether's point."""
    lever, velocity = spot(three(tether, 0), motion)
    return lever, add(add(motion.x, lever), scale(-1.0, three(tether, 3))), velocity


@inlined
def spot(point: Vector, motion: Motion) -> tuple[Vector, Vector]:
    """Return lever R p and velocity v + w x R p of a point in body axes."""
    lever = add(add(scale(point[0], motion.axis_1), scale(point[1], motion.axis_2)), scale(point[2], motion.axis_3))
    return lever, add(motion.v, cross(motion.w, lever))


@inlined
def drag_pull(drag: Array, motion: Motion) -> tuple[Vector, Vector]:
    """Return F = -linear v and torque = -angular w."""
    return scale(-drag[0], motion.v), scale(-drag[1], motion.w)


@inlined
def floor_push(floor: Array, motion: Motion, solid: Solid, pressing: np.ndarray) -> tuple[Vector, Vector]:
    """Return the sum over the vertices that the floor pushes of N n, N = -k y - c y'.

    Which they are, y < 0 and N > 0, is not asked here: between two switches the law has no corner.
    """
    total = (scale(0.0, motion.v), scale(0.0, motion.L))
    for vertex in range(len(pressing)):
        if pressing[vertex]:
            lever, _, thrust = floor_gauge(floor, three(solid.points[vertex], 0), motion)
            total = both(total, acting_at(lever, scale(thrust, three(floor, 0))))
    return total


@inlined
def floor_gauge(floor: Array, point: Vector, motion: Motion) -> tuple[Vector, float, float]:
    """Return lever R p, height y above the floor [m] and -k y - c y' [N] of a vertex in body axes."""
    lever, velocity = spot(point, motion)
    normal = three(floor, 0)
    height = dot(normal, motion.x) + dot(normal, lever) - floor[3]
    return lever, height, -floor[4] * height - floor[5] * dot(normal, velocity)
