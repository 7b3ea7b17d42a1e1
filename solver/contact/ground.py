"""The plane and the body above it, as numbers of the plane's frame, and how a point of the body answers an impulse."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tumble.solver.compilation import inner
from tumble.solver.quaternion import Quaternion, rotate, rotate_back
from tumble.solver.vectors import Vector, add, cross, dot, scale, times

Array = NDArray[np.float64]
# A symmetric matrix as (xx, yy, zz, xy, xz, yz).
Symmetric = tuple[float, float, float, float, float, float]
# Of a rim: points that stand for its face.
QUARTERS = 4


class Ground(NamedTuple):
    """Plane and body.

    Parameters
    ----------
    restitution
    friction
    gravity : (3,), m/s2
        plane's frame
    mass : kg
    moments : (3,), kg m2
    inverse_moments : (3,), 1/(kg m2)
    gyroscopic : (3,), 1/(kg m2)
        of `Body.gyroscopic`, zeros for equal moments
    points : (n, 3), m
        that can touch the plane, body axes; empty for a sphere, for a disc and without a plane
    radius : m
        of a sphere, else 0
    rim, half : m
        of a disc about the body's third axis, radius and half the thickness, else 0
    reach : m
        how far the furthest point is from the centre
    far : m
        how far the frame's origin is from the world's
    """

    restitution: float
    friction: float
    gravity: Vector
    mass: float
    moments: Vector
    inverse_moments: Vector
    gyroscopic: Vector
    points: Array
    radius: float
    rim: float
    half: float
    reach: float
    far: float


@inner
def spin_of(q: Quaternion, l_body: Vector, ground: Ground) -> Vector:
    """Return the angular velocity [rad/s], plane's frame."""
    return rotate(q, times(ground.inverse_moments, l_body))


@inner
def momentum_of(q: Quaternion, w: Vector, ground: Ground) -> Vector:
    """Return the angular momentum along body axes [kg m2/s]."""
    return times(ground.moments, rotate_back(q, w))


@inner
def gained_spin(q: Quaternion, torque: Vector, ground: Ground) -> Vector:
    """Return I^-1 times a vector of the plane's frame."""
    return rotate(q, times(ground.inverse_moments, rotate_back(q, torque)))


@inner
def point_count(ground: Ground) -> int:
    """Return how many points can touch the plane; of a disc, the lowest of each rim and three more, for a face."""
    if ground.rim > 0.0:
        return QUARTERS * rim_count(ground)
    return 1 if ground.radius > 0.0 else len(ground.points)


@inner
def rim_count(ground: Ground) -> int:
    """Return how many rims a disc has; 0 of another body."""
    if ground.rim == 0.0:
        return 0
    return 2 if ground.half > 0.0 else 1


@inner
def on_rim(normal: Vector, number: int, ground: Ground) -> Vector:
    """Return a point of a disc, body axes [m], as its normal there stands: first the lowest of each rim."""
    rims = rim_count(ground)
    size = math.hypot(normal[0], normal[1])
    x, y = (-ground.rim * normal[0] / size, -ground.rim * normal[1] / size) if size > 0.0 else (ground.rim, 0.0)
    for _ in range(number // rims):
        x, y = -y, x
    return x, y, ground.half * (2.0 * (number % rims) - 1.0)


@inner
def lever_rate(q: Quaternion, w: Vector, number: int, ground: Ground) -> Vector:
    """Return how fast the place of a touching point changes, from the centre [m/s]: of a rim's lowest, which is another

    point of the rim at each instant.
    """
    if ground.rim == 0.0:
        return cross(w, lever_of(q, number, ground))
    axis = rotate(q, (0.0, 0.0, 1.0))
    axis_rate = cross(w, axis)
    below = (axis[0] * axis[2], axis[1] * axis[2], axis[2] * axis[2] - 1.0)
    size = math.sqrt(dot(below, below))
    d = scale(1.0 / size, below)
    rate = add(scale(axis[2], axis_rate), scale(axis_rate[2], axis))
    turn = scale(ground.rim / size, add(rate, scale(-dot(d, rate), d)))
    return add(turn, scale(ground.half * (2.0 * number - 1.0), axis_rate))


@inner
def lever_of(q: Quaternion, number: int, ground: Ground) -> Vector:
    """Return a point that can touch, from the centre [m], plane's frame; of a sphere its lowest."""
    if ground.radius > 0.0:
        return (0.0, 0.0, -ground.radius)
    if ground.rim > 0.0:
        return rotate(q, on_rim(rotate_back(q, (0.0, 0.0, 1.0)), number, ground))
    points = ground.points
    return rotate(q, (points[number, 0], points[number, 1], points[number, 2]))


@inner
def velocity_at(v: Vector, w: Vector, lever: Vector) -> Vector:
    """Return the velocity of a point of the body [m/s]."""
    return add(v, cross(w, lever))


@inner
def response(q: Quaternion, lever: Vector, ground: Ground) -> Symmetric:
    """Return K, the velocity that a point gains per impulse there [1/kg]: 1/m - [r] I^-1 [r]."""
    x, y, z = lever
    about_x, about_y, about_z = (0.0, z, -y), (-z, 0.0, x), (y, -x, 0.0)  # r x e_i
    turned_x, turned_y, turned_z = (
        gained_spin(q, about_x, ground),
        gained_spin(q, about_y, ground),
        gained_spin(q, about_z, ground),
    )
    own = 1.0 / ground.mass
    return (
        own + dot(about_x, turned_x),
        own + dot(about_y, turned_y),
        own + dot(about_z, turned_z),
        dot(about_x, turned_y),
        dot(about_x, turned_z),
        dot(about_y, turned_z),
    )


@inner
def applied(matrix: Symmetric, a: Vector) -> Vector:
    """Return a symmetric matrix times a vector."""
    xx, yy, zz, xy, xz, yz = matrix
    return (xx * a[0] + xy * a[1] + xz * a[2], xy * a[0] + yy * a[1] + yz * a[2], xz * a[0] + yz * a[1] + zz * a[2])


@inner
def solved(matrix: Symmetric, a: Vector) -> Vector:
    """Return the inverse of a positive definite matrix times a vector, by Cholesky's factors."""
    xx, yy, zz, xy, xz, yz = matrix
    l_11 = math.sqrt(zz)
    l_21, l_31 = xz / l_11, yz / l_11
    l_22 = math.sqrt(xx - l_21 * l_21)
    l_32 = (xy - l_31 * l_21) / l_22
    l_33 = math.sqrt(yy - l_31 * l_31 - l_32 * l_32)
    first = a[2] / l_11
    second = (a[0] - l_21 * first) / l_22
    third = (a[1] - l_31 * first - l_32 * second) / l_33
    y = third / l_33
    x = (second - l_32 * y) / l_22
    return (x, y, (first - l_21 * x - l_31 * y) / l_11)


@inner
def struck(
    q: Quaternion, v: Vector, w: Vector, lever: Vector, impulse: Vector, ground: Ground
) -> tuple[Vector, Vector]:
    """Return velocity and spin after an impulse at a point, all in the plane's frame."""
    return (
        add(v, scale(1.0 / ground.mass, impulse)),
        add(w, gained_spin(q, cross(lever, impulse), ground)),
    )
