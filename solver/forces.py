"""What pulls at a body: one short term a law, and their sum.

A term that is absent is None, and the compiler leaves no trace of it in a kernel: numba drops a branch on `is None`
where an argument of a function is None, so every term is a function of what it needs; and LLVM drops a sum with -0.0,
which changes no number.  Every term also takes the numbers of eight instants at once, and numbers with their
derivatives, as `tumble.solver.eight` and `tumble.solver.dual` have them: so no term branches on a number.  A new force
is one more term here, and its line in `wrench`.
"""

# Rotation is absent as a whole, which pyright cannot know: where q is not None neither is L or w.
# pyright: reportArgumentType=false

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tumble.solver.compilation import borrowing, scalar
from tumble.solver.eight import over, pressing, root
from tumble.solver.quaternion import Quaternion, conjugate, norm_squared
from tumble.solver.vectors import Vector, add, cross, dot, scale

Array = NDArray[np.float64]

NOTHING = (-0.0, -0.0, -0.0)


class Forces(NamedTuple):
    """The forces that act on a body; None for a force that is absent.

    Parameters
    ----------
    mass : kg
    gravity : (3,), m/s2
        world axes
    tethers : (k, 9)
        a row each: point [m], body axes; anchor [m], world axes; stiffness [N/m]; damping [N s/m]; rest length [m]
    drag
        linear [N s/m] and angular [N m s/rad], each None where absent
    floor
        height [m]; unit normal (3 numbers), world axes; stiffness [N/m]; damping [N s/m]
    points : (n, 3), m
        points that the floor can touch, body axes; None without a floor
    """

    mass: float
    gravity: Vector | None = None
    tethers: Array | None = None
    drag: tuple[float | None, float | None] | None = None
    floor: tuple[float, float, float, float, float, float] | None = None
    points: Array | None = None


LAWS = tuple(name for name in Forces._fields if name not in ("mass", "points"))


def only_gravity(forces: Forces) -> bool:
    """Return whether no force acts except gravity.

    Parameters
    ----------
    forces

    Returns
    -------
    answer
        true also where nothing acts at all
    """
    return all(getattr(forces, law) is None for law in LAWS if law != "gravity")


def gives_torque(forces: Forces, turning: bool) -> bool:
    """Return whether forces can rotate the body, or depend on how it is rotated.

    Parameters
    ----------
    forces : of the scene
    turning : whether the body rotates without them

    Returns
    -------
    whether they can; of a law that is not named here, always
    """
    if forces.drag is not None and forces.drag[1] is not None and turning:
        return True
    if forces.tethers is not None and forces.tethers[:, :3].any():
        return True
    return any(getattr(forces, law) is not None for law in LAWS if law not in ("gravity", "drag", "tethers"))


@scalar
def wrench(x: Vector, q: Quaternion | None, v: Vector, w_body: Vector | None, forces: Forces) -> tuple[Vector, Vector]:
    """Return force and torque at one instant.

    Parameters
    ----------
    x : (3,), m
        centre of mass, world axes
    q : (4,)
        attitude, of any length; None if no force gives a torque
    v : (3,), m/s
        world axes
    w_body : (3,), rad/s
        body axes; None if no force gives a torque
    forces

    Returns
    -------
    force : (3,), N
        world axes
    torque : (3,), N m
        about the centre of mass, body axes
    """
    pull, twist = _tethers(x, q, v, w_body, forces.tethers)
    push, tip = _floor(x, q, v, w_body, forces.floor, forces.points)
    force = add(add(_weight(forces.mass, forces.gravity), _linear_drag(v, forces.drag)), add(pull, push))
    return force, add(_angular_drag(w_body, forces.drag), add(twist, tip))


@borrowing
def _weight(mass: float, gravity: Vector | None) -> Vector:
    """Return F = m g."""
    if gravity is None:
        return NOTHING
    return scale(mass, gravity)


@borrowing
def _linear_drag(v: Vector, drag: tuple[float | None, float | None] | None) -> Vector:
    """Return F = -linear v."""
    if drag is None:
        return NOTHING
    return _against(v, drag[0])


@borrowing
def _angular_drag(w_body: Vector | None, drag: tuple[float | None, float | None] | None) -> Vector:
    """Return tau = -angular w."""
    if drag is None or w_body is None:
        return NOTHING
    return _against(w_body, drag[1])


@borrowing
def _against(rate: Vector, coefficient: float | None) -> Vector:
    """Return -coefficient rate."""
    if coefficient is None:
        return NOTHING
    return scale(-coefficient, rate)


@borrowing
def _tethers(
    x: Vector, q: Quaternion | None, v: Vector, w_body: Vector | None, tethers: Array | None
) -> tuple[Vector, Vector]:
    """Return the force of all tethers, world axes, and their torque, body axes."""
    if tethers is None:
        return NOTHING, NOTHING
    force, torque = NOTHING, NOTHING
    for number in range(len(tethers)):
        one_force, one_torque = _tether(x, q, v, w_body, tethers, number)
        force, torque = add(force, one_force), add(torque, one_torque)
    return force, torque


@borrowing
def _tether(
    x: Vector, q: Quaternion | None, v: Vector, w_body: Vector | None, tethers: Array, number: int
) -> tuple[Vector, Vector]:
    """Return the force of one tether at p = x + R p0, world axes, and its torque p0 x R^T F, body axes."""
    point = (tethers[number, 0], tethers[number, 1], tethers[number, 2])
    anchor = (tethers[number, 3], tethers[number, 4], tethers[number, 5])
    stiffness, damping, rest_length = tethers[number, 6], tethers[number, 7], tethers[number, 8]
    offset = add(add(x, _to_world(q, point)), scale(-1.0, anchor))
    velocity = add(v, _to_world(q, _swing(w_body, point)))
    force = _spring(offset, velocity, stiffness, damping, rest_length)
    return force, cross(point, _to_body(q, force))


@borrowing
def _swing(w_body: Vector | None, point: Vector) -> Vector:
    """Return w x p0 [m/s]."""
    if w_body is None:
        return NOTHING
    return cross(w_body, point)


@borrowing
def _spring(offset: Vector, velocity: Vector, stiffness: float, damping: float, rest_length: float) -> Vector:
    """Return F = -k d - c d' for a rest length of 0, otherwise F = -(k (|d| - l0) + c d'.u) u with u = d/|d|.

    A line of no length has no direction: there, with a rest length, the force is 0, its mean over all directions.
    """
    if rest_length == 0.0:
        return add(scale(-stiffness, offset), scale(-damping, velocity))
    length = root(dot(offset, offset))
    tension = stiffness * (length - rest_length) + over(damping * dot(velocity, offset), length)
    return scale(over(-tension, length), offset)


class Plane(NamedTuple):
    """The floor as the body sees it: unit normal, body axes, height of the centre over it [m], and their rates."""

    normal_body: Vector
    centre: float
    rise: float
    turn: Vector


@borrowing
def floor_under(x: Vector, q: Quaternion, v: Vector, w_body: Vector, height: float, normal: Vector) -> Plane:
    """Return the floor under the body.

    A point is y = n . (x + R p0) - height = (n . x - height) + (R^T n) . p0 over it: one product of vectors.
    """
    normal_body = _to_body(q, normal)
    return Plane(normal_body, dot(normal, x) - height, dot(normal, v), cross(normal_body, w_body))


@borrowing
def _floor(
    x: Vector,
    q: Quaternion | None,
    v: Vector,
    w_body: Vector | None,
    floor: tuple[float, float, float, float, float, float] | None,
    points: Array | None,
) -> tuple[Vector, Vector]:
    """Return the push N = max(0, -k y - c y') along the normal at every point with y < 0, and its torque."""
    if floor is None or points is None:
        return NOTHING, NOTHING
    normal, stiffness, damping = (floor[1], floor[2], floor[3]), floor[4], floor[5]
    plane = floor_under(x, q, v, w_body, floor[0], normal)
    push = 0.0 * plane.centre
    lever = scale(push, plane.normal_body)
    for number in range(len(points)):
        point = (points[number, 0], points[number, 1], points[number, 2])
        y = plane.centre + dot(plane.normal_body, point)
        load = pressing(y, -stiffness * y - damping * (plane.rise + dot(plane.turn, point)))
        push = push + load
        lever = add(lever, scale(load, point))
    return scale(push, normal), cross(lever, plane.normal_body)


@borrowing
def _to_world(q: Quaternion | None, a: Vector) -> Vector:
    """Return q a q* / |q|^2, the vector turned from body to world axes."""
    if q is None:
        return a
    axis = (q[1], q[2], q[3])
    twice = cross(axis, scale(2.0 / norm_squared(q), a))
    return add(add(a, scale(q[0], twice)), cross(axis, twice))


@borrowing
def _to_body(q: Quaternion | None, a: Vector) -> Vector:
    """Return q* a q / |q|^2, the vector turned from world to body axes."""
    if q is None:
        return a
    return _to_world(conjugate(q), a)
