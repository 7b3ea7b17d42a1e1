"""Vectors, quaternions (w x y z, Hamilton, body to world) and 3x3 matrices as tuples, in double or single precision.

Tuples of plain numbers are several times as fast as small arrays, and numpy's float32 stays float32 in them.
"""

import math

import numpy as np

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
Matrix = tuple[Vector, Vector, Vector]
ZERO: Vector = (0.0, 0.0, 0.0)


def root(a: float) -> float:
    """Return the square root in the precision of its argument."""
    return type(a)(math.sqrt(a))


def add(a: Vector, b: Vector) -> Vector:
    """Return a + b."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def minus(a: Vector, b: Vector) -> Vector:
    """Return a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def scale(s: float, a: Vector) -> Vector:
    """Return s a."""
    return (s * a[0], s * a[1], s * a[2])


def along(a: Vector, s: float, b: Vector) -> Vector:
    """Return a + s b."""
    return (a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2])


def dot(a: Vector, b: Vector) -> float:
    """Return a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def norm(a: Vector) -> float:
    """Return |a|."""
    return root(dot(a, a))


def cross(a: Vector, b: Vector) -> Vector:
    """Return a x b."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def capped(a: Vector, most: float) -> Vector:
    """Return a, no longer than most."""
    length = norm(a)
    return scale(most / length, a) if length > most else a


def product(p: Quaternion, q: Quaternion) -> Quaternion:
    """Return the product of two quaternions."""
    return (
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
        p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
    )


def length(q: Quaternion) -> float:
    """Return |q|."""
    return root(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])


def normalised(q: Quaternion) -> Quaternion:
    """Return q / |q|."""
    size = length(q)
    return (q[0] / size, q[1] / size, q[2] / size, q[3] / size)


def conjugate(q: Quaternion) -> Quaternion:
    """Return the conjugate."""
    return (q[0], -q[1], -q[2], -q[3])


def about(turn: Vector, angle: float | None = None) -> Quaternion:
    """Return the rotation about a vector, by its length [rad] or another angle."""
    size = norm(turn)
    if size == 0:
        return (type(size)(1.0), turn[0], turn[1], turn[2])
    half = 0.5 * (size if angle is None else angle)
    part = type(size)(math.sin(half)) / size
    return (type(size)(math.cos(half)), part * turn[0], part * turn[1], part * turn[2])


def matrix(q: Quaternion) -> Matrix:
    """Return the matrix body to world; only of length 1 is it a rotation."""
    w, x, y, z = q
    return (
        (w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z),
    )


def matrix_of_unit(q: Quaternion) -> Matrix:
    """Return the matrix by the formula for quaternions of length 1; of no other quaternion is it a rotation."""
    w, x, y, z = q
    one = type(w)(1.0)
    return (
        (one - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), one - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), one - 2 * (x * x + y * y)),
    )


def transposed(m: Matrix) -> Matrix:
    """Return the transpose."""
    return ((m[0][0], m[1][0], m[2][0]), (m[0][1], m[1][1], m[2][1]), (m[0][2], m[1][2], m[2][2]))


def times(m: Matrix, a: Vector) -> Vector:
    """Return m a."""
    return (dot(m[0], a), dot(m[1], a), dot(m[2], a))


def times_transposed(m: Matrix, a: Vector) -> Vector:
    """Return m^T a."""
    return (
        m[0][0] * a[0] + m[1][0] * a[1] + m[2][0] * a[2],
        m[0][1] * a[0] + m[1][1] * a[1] + m[2][1] * a[2],
        m[0][2] * a[0] + m[1][2] * a[1] + m[2][2] * a[2],
    )


def solved(m: Matrix, right: Vector) -> Vector:
    """Return the solution of m a = right by Cramer's rule."""
    first, second, third = cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])
    inverse = 1 / dot(m[0], first)
    return (
        inverse * (first[0] * right[0] + second[0] * right[1] + third[0] * right[2]),
        inverse * (first[1] * right[0] + second[1] * right[1] + third[1] * right[2]),
        inverse * (first[2] * right[0] + second[2] * right[1] + third[2] * right[2]),
    )


def skew_times(a: Vector, m: Matrix) -> Matrix:
    """Return [a]x m."""
    columns = [cross(a, column) for column in transposed(m)]
    return transposed((columns[0], columns[1], columns[2]))


def skew(a: Vector) -> Matrix:
    """Return [a]x."""
    return ((0 * a[0], -a[2], a[1]), (a[2], 0 * a[0], -a[0]), (-a[1], a[0], 0 * a[0]))


def combined(m: Matrix, s: float, n: Matrix) -> Matrix:
    """Return m + s n."""
    return (along(m[0], s, n[0]), along(m[1], s, n[1]), along(m[2], s, n[2]))


def matrices(q: np.ndarray) -> np.ndarray:
    """Return the matrices body to world of quaternions as they are, (n, 4) -> (n, 3, 3)."""
    rows = matrix(tuple(q.T))  # type: ignore[arg-type]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=1)


def quaternions(m: np.ndarray) -> np.ndarray:
    """Return quaternions of rotation matrices, (n, 3, 3) -> (n, 4), each by its largest part (Shepperd 1978)."""
    diagonal = np.einsum("nii->ni", m)
    trace = diagonal.sum(axis=1)
    squares = 1 + np.stack((trace, *(2 * diagonal[:, i] - trace for i in range(3))), axis=1)
    found = np.empty((len(m), 4))
    pairs = np.stack((m[:, 2, 1] - m[:, 1, 2], m[:, 0, 2] - m[:, 2, 0], m[:, 1, 0] - m[:, 0, 1]), axis=1)
    sums = np.stack((m[:, 1, 0] + m[:, 0, 1], m[:, 2, 0] + m[:, 0, 2], m[:, 2, 1] + m[:, 1, 2]), axis=1)
    largest = squares.argmax(axis=1)
    parts = (
        lambda s: (squares[s, 0], pairs[s, 0], pairs[s, 1], pairs[s, 2]),
        lambda s: (pairs[s, 0], squares[s, 1], sums[s, 0], sums[s, 1]),
        lambda s: (pairs[s, 1], sums[s, 0], squares[s, 2], sums[s, 2]),
        lambda s: (pairs[s, 2], sums[s, 1], sums[s, 2], squares[s, 3]),
    )
    for number, part in enumerate(parts):
        chosen = largest == number
        found[chosen] = np.stack(part(chosen), axis=1)
    return found / np.linalg.norm(found, axis=1)[:, None]
