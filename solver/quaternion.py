"""Hamilton's quaternions w x y z: rotations, body axes to world axes.

First the algebra, compiled, on tuples; then, in numpy, whole arrays to and from rotation matrices.
Source: Hamilton (1844); Sola, "Quaternion kinematics for the error-state Kalman filter" (2017), whose conventions
(Hamilton, active, local to global) these are.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tumble.solver.compilation import scalar
from tumble.solver.vectors import Vector, add, cross, dot, scale

Quaternion = tuple[float, float, float, float]

# Below this |u|^2 five terms of the series for cos and sin(x)/x are exact: the first one left out is under 2^-55.
SERIES_LIMIT = 2.0**-7


@scalar
def product(p: Quaternion, q: Quaternion) -> Quaternion:
    """Return the Hamilton product p q: first the rotation q, then p.

    Parameters
    ----------
    p, q : (4,)

    Returns
    -------
    product : (4,)
    """
    pw, px, py, pz = p
    qw, qx, qy, qz = q
    return (
        pw * qw - px * qx - py * qy - pz * qz,
        pw * qx + px * qw + py * qz - pz * qy,
        pw * qy - px * qz + py * qw + pz * qx,
        pw * qz + px * qy - py * qx + pz * qw,
    )


@scalar
def product_vector(q: Quaternion, a: Vector) -> Quaternion:
    """Return q a~, the product with the pure quaternion a~ = (0, a).

    Parameters
    ----------
    q : (4,)
    a : (3,)

    Returns
    -------
    product : (4,)
    """
    w, x, y, z = q
    return (
        -x * a[0] - y * a[1] - z * a[2],
        w * a[0] + y * a[2] - z * a[1],
        w * a[1] - x * a[2] + z * a[0],
        w * a[2] + x * a[1] - y * a[0],
    )


@scalar
def vector_product(a: Vector, q: Quaternion) -> Quaternion:
    """Return a~ q, the product with the pure quaternion a~ = (0, a)."""
    w, x, y, z = q
    return (
        -a[0] * x - a[1] * y - a[2] * z,
        a[0] * w + a[1] * z - a[2] * y,
        a[1] * w + a[2] * x - a[0] * z,
        a[2] * w + a[0] * y - a[1] * x,
    )


@scalar
def plus(p: Quaternion, q: Quaternion) -> Quaternion:
    """Return p + q.

    Parameters
    ----------
    p, q : (4,)

    Returns
    -------
    sum : (4,)
    """
    return (p[0] + q[0], p[1] + q[1], p[2] + q[2], p[3] + q[3])


@scalar
def stretch(factor: float, q: Quaternion) -> Quaternion:
    """Return factor q.

    Parameters
    ----------
    factor
    q : (4,)

    Returns
    -------
    product : (4,)
    """
    return (factor * q[0], factor * q[1], factor * q[2], factor * q[3])


@scalar
def conjugate(q: Quaternion) -> Quaternion:
    """Return q*, the inverse of a unit quaternion.

    Parameters
    ----------
    q : (4,)

    Returns
    -------
    conjugate : (4,)
    """
    return (q[0], -q[1], -q[2], -q[3])


@scalar
def norm_squared(q: Quaternion) -> float:
    """Return |q|^2.

    Parameters
    ----------
    q : (4,)

    Returns
    -------
    norm squared
    """
    return q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]


@scalar
def normalise(q: Quaternion) -> Quaternion:
    """Return q / |q|.

    Parameters
    ----------
    q : (4,)

    Returns
    -------
    unit quaternion : (4,)
    """
    return stretch(1.0 / math.sqrt(norm_squared(q)), q)


@scalar
def rotate(q: Quaternion, a: Vector) -> Vector:
    """Return q a q*, a vector turned from body to world axes.

    Parameters
    ----------
    q : (4,)
        unit quaternion, body to world
    a : (3,)
        body axes

    Returns
    -------
    vector : (3,)
        world axes
    """
    axis = (q[1], q[2], q[3])
    # Twice the vector, not twice the product: many a loop turns the same vector.
    twice = cross(axis, scale(2.0, a))
    return add(add(a, scale(q[0], twice)), cross(axis, twice))


@scalar
def rotate_back(q: Quaternion, a: Vector) -> Vector:
    """Return q* a q, a vector turned from world to body axes.

    Parameters
    ----------
    q : (4,)
        unit quaternion, body to world
    a : (3,)
        world axes

    Returns
    -------
    vector : (3,)
        body axes
    """
    return rotate(conjugate(q), a)


@scalar
def cosine_and_sine_ratio(square: float) -> tuple[float, float]:
    """Return cos x and sin(x)/x from x^2, to rounding at every angle."""
    if square < SERIES_LIMIT:
        # Taylor's series, the odd and the even terms apart: half the waiting of Horner's scheme.
        fourth = square * square
        return (
            (1.0 - square * (1 / 2)) + fourth * ((1 / 24 - square * (1 / 720)) + fourth * (1 / 40320)),
            (1.0 - square * (1 / 6)) + fourth * ((1 / 120 - square * (1 / 5040)) + fourth * (1 / 362880)),
        )
    angle = math.sqrt(square)
    return math.cos(angle), math.sin(angle) / angle


@scalar
def exponential(u: Vector) -> Quaternion:
    """Return exp(u~) = (cos |u|, u sin |u| / |u|), the rotation by the angle 2 |u| about u.

    Parameters
    ----------
    u : (3,), rad
        half the rotation vector

    Returns
    -------
    unit quaternion : (4,)

    Notes
    -----
    Source: Sola (2017), section 1.3.4.
    """
    cosine, sine_ratio = cosine_and_sine_ratio(dot(u, u))
    return (cosine, sine_ratio * u[0], sine_ratio * u[1], sine_ratio * u[2])


@scalar
def steady_turn(q: Quaternion, u: Vector, n: int) -> Quaternion:
    """Return q exp(u~)^n, a step after the other, as w_body turns it where it is constant: u = dt/2 w_body."""
    turn = exponential(u)
    for _ in range(n):
        q = product(q, turn)
    return q


def to_matrix(q: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the matrices that turn body axes into world axes.

    Parameters
    ----------
    q : (..., 4)
        unit quaternions w x y z

    Returns
    -------
    matrices : (..., 3, 3)
    """
    # One throw is Python's own numbers: numpy would take ten times as long for each operation.
    parts = q.ravel().tolist() if q.size == 4 else np.moveaxis(q, -1, 0)
    matrices = np.empty((*q.shape[:-1], 9))
    for place, entry in enumerate(_entries(*parts)):
        matrices[..., place] = entry
    return matrices.reshape(*q.shape[:-1], 3, 3)


def _entries(w: Any, x: Any, y: Any, z: Any) -> tuple[Any, ...]:
    """Return the nine entries of a rotation matrix, row by row, of a unit quaternion of numbers or arrays."""
    ww, xx, yy, zz = w * w, x * x, y * y, z * z
    return (
        ww + xx - yy - zz,
        2 * (x * y - w * z),
        2 * (x * z + w * y),
        2 * (x * y + w * z),
        ww - xx + yy - zz,
        2 * (y * z - w * x),
        2 * (x * z - w * y),
        2 * (y * z + w * x),
        ww - xx - yy + zz,
    )


def from_matrix(matrices: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the unit quaternion of the rotation nearest to each matrix.

    Nearest in the Frobenius norm: a rotation's own quaternion, and for any other matrix of positive determinant
    that of its polar factor.

    Parameters
    ----------
    matrices : (..., 3, 3)

    Returns
    -------
    quaternions : (..., 4)
        of arbitrary sign; nan for a matrix that is not finite

    Notes
    -----
    Source: Davenport's q-method, in Markley & Crassidis, "Fundamentals of Spacecraft Attitude Determination"
    (2014), section 5.3.1: q is the eigenvector of the largest eigenvalue of a symmetric matrix made of the entries.
    """
    finite = np.isfinite(matrices).all(axis=(-2, -1))
    m = np.moveaxis(np.where(np.expand_dims(finite, (-2, -1)), matrices, 0.0), (-2, -1), (0, 1))
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = m
    davenport = (
        (xx + yy + zz, zy - yz, xz - zx, yx - xy),
        (zy - yz, xx - yy - zz, xy + yx, xz + zx),
        (xz - zx, xy + yx, yy - xx - zz, yz + zy),
        (yx - xy, xz + zx, yz + zy, zz - xx - yy),
    )
    _, eigenvectors = np.linalg.eigh(np.stack([np.stack(row, axis=-1) for row in davenport], axis=-2))
    return np.where(np.expand_dims(finite, -1), eigenvectors[..., -1], np.nan)


def turned(matrices: NDArray[np.float64], vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return matrix times vector, (..., 3); einsum, for matmul leaves the last bits of a throw to the BLAS."""
    return np.einsum("...ij,...j->...i", matrices, vectors)
