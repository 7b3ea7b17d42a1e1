"""The update of the attitude in a step: how far a vector of an angular velocity and a step rotates the body."""

import math

from tumble.compare.grade.model.kernel.dynamics import (
    AXIS_BY_AXIS,
    EXPONENTIAL,
    GRAM_SCHMIDT,
    HALF_ANGLE,
    SECOND_ORDER,
    TANGENT,
)
from tumble.solver.compilation import borrowing
from tumble.solver.quaternion import (
    Quaternion,
    conjugate,
    exponential,
    norm_squared,
    normalise,
    plus,
    product,
    product_vector,
    rotate,
    rotate_back,
)
from tumble.solver.vectors import Vector, add, cross, dot, scale

# Square of a rotation in a step [rad] below which its third order is rounding.
SMALL_SQUARE = 1e-12


@borrowing
def turned(q: Quaternion, turn: Vector, attitude: int, file_axes: Quaternion) -> tuple[Quaternion, float]:
    """Return q rotated by a vector [rad], body axes, and the factor on its length in the program.

    file_axes: rotation from the axes of the body in which the program has its matrix.
    """
    if attitude == EXPONENTIAL:
        return normalise(product(q, exponential(scale(0.5, turn)))), 1.0
    if attitude in (SECOND_ORDER, HALF_ANGLE, TANGENT):
        return normalise(product(q, _by_another_angle(turn, attitude))), 1.0
    if attitude == GRAM_SCHMIDT:
        return normalise(product(_orthonormalised(rotate(q, turn), product(q, file_axes)), q)), 1.0
    if attitude == AXIS_BY_AXIS:
        return _axis_by_axis(q, rotate(q, turn)), 1.0
    longer = plus(q, product_vector(q, scale(0.5, turn)))
    return normalise(longer), math.sqrt(norm_squared(longer))


@borrowing
def _by_another_angle(turn: Vector, attitude: int) -> Quaternion:
    """Return a rotation about a vector whose angle is not quite its length a: see `dynamics`."""
    square = dot(turn, turn)
    if attitude == SECOND_ORDER:
        x, y, z = scale(0.5, turn)
        return normalise((1.0 - square / 8.0, x, y, z))
    angle = math.sqrt(square)
    half = math.asin(min(1.0, 0.5 * angle)) if attitude == HALF_ANGLE else 0.5 * math.atan(angle)
    ratio = half / angle if square > SMALL_SQUARE else 0.5
    return exponential(scale(ratio, turn))


@borrowing
def _orthonormalised(turn_world: Vector, q: Quaternion) -> Quaternion:
    """Return the rotation, world axes, from R to (1 + [t]) R whose columns are made orthonormal, the first first."""
    first, second = rotate(q, (1.0, 0.0, 0.0)), rotate(q, (0.0, 1.0, 0.0))
    x = add(first, cross(turn_world, first))
    y = add(second, cross(turn_world, second))
    x = scale(1.0 / math.sqrt(dot(x, x)), x)
    y = add(y, scale(-dot(x, y), x))
    y = scale(1.0 / math.sqrt(dot(y, y)), y)
    return _between(first, second, x, y)


@borrowing
def _between(x: Vector, y: Vector, x_new: Vector, y_new: Vector) -> Quaternion:
    """Return the smaller rotation of an orthonormal pair of vectors onto another one, less than half a turn."""
    # Of a rotation with an axis a and an angle b, the sum of e x e' over three unit vectors is 2 sin b a.
    z, z_new = cross(x, y), cross(x_new, y_new)
    axis = add(add(cross(x, x_new), cross(y, y_new)), cross(z, z_new))
    cosine = 0.5 * (dot(x, x_new) + dot(y, y_new) + dot(z, z_new) - 1.0)
    a, b, c = scale(0.5, axis)
    return normalise((1.0 + cosine, a, b, c))


@borrowing
def _axis_by_axis(q: Quaternion, turn_world: Vector) -> Quaternion:
    """Return q rotated about x, then y, then z of the world."""
    x, y, z = scale(0.5, turn_world)
    about_x, about_y, about_z = exponential((x, 0.0, 0.0)), exponential((0.0, y, 0.0)), exponential((0.0, 0.0, z))
    return normalise(product(about_z, product(about_y, product(about_x, q))))


@borrowing
def recovered(old: Quaternion, new: Quaternion, dt: float) -> Vector:
    """Return the angular velocity 2 Im(q' q*)/dt of two attitudes, in the body axes of the new one.

    Source: Mueller et al., "Detailed rigid body simulation with extended position based dynamics" (2020), alg. 2.
    """
    w, x, y, z = product(new, conjugate(old))
    return rotate_back(new, scale(2.0 / dt if w >= 0.0 else -2.0 / dt, (x, y, z)))
