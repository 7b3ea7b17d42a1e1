"""Mass properties of uniform solids, and the axes in which the inertia tensor is diagonal.

A tensor is the full one with products of inertia, [[A, -H, -G], [-H, B, -F], [-G, -F, C]] (CE1051A report, eq. 2.6).
"""

from collections.abc import Iterator
from itertools import pairwise, permutations, product
from typing import NamedTuple

import numpy as np

from tumble.scenarios.frames import Array
from tumble.scenarios.scene import frozen_array

# The axes of a tensor whose products of inertia are no more than rounding are left alone.
DIAGONAL = 1e-15
# Moments as close as this are one moment: a dozen roundings, which is what the integrals of a small mesh leave.
EQUAL = 1e-14
ROOT_HALF = float(np.sqrt(0.5))

# Into box_corners.  Two triangles a face, counter-clockwise from outside: -x, +x, -y, +y, -z, +z.
BOX_FACES = frozen_array(
    [
        (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5),
        (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6),
        (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3),
    ],
    dtype=int,
)  # fmt: skip


class Solid(NamedTuple):
    """volume [m3]; centre of mass [m], (3,); inertia tensor about it [kg m2], (3, 3), along the axes of the input."""

    volume: float
    centre: Array
    tensor: Array


def box(mass: float, size: Array) -> Solid:
    """Return the mass properties of a uniform box about its middle.

    Parameters
    ----------
    mass : kg
    size : (3,), m
        full edges

    Returns
    -------
    solid

    Notes
    -----
    Source: IGR202 report, section 2.1.
    """
    return Solid(float(np.prod(size)), np.zeros(3), mass * _tensor(np.diag(np.asarray(size, dtype=float) ** 2 / 12)))


def box_corners(size: Array) -> Array:
    """Return the corners of a box.

    Parameters
    ----------
    size : (3,), m
        full edges

    Returns
    -------
    corners : (8, 3), m
        0 is (-, -, -), 1 is (-, -, +), 7 is (+, +, +)
    """
    return np.array(list(product((-1, 1), repeat=3))) * (np.asarray(size, dtype=float) / 2)


def sphere(mass: float, radius: float) -> Solid:
    """Return the mass properties of a uniform sphere about its middle; mass [kg], radius [m]."""
    return Solid(4 / 3 * np.pi * radius**3, np.zeros(3), 2 / 5 * mass * radius**2 * np.eye(3))


def sphere_points(radius: float) -> Array:
    """Return the centre of a sphere and the ends of its axes [m], (7, 3): 1 is -x, 2 is +x, then y and z."""
    ends = [sign * axis for axis in np.eye(3) for sign in (-1, 1)]
    return radius * np.array([np.zeros(3), *ends])


def disc(mass: float, radius: float, thickness: float) -> Solid:
    """Return the mass properties of a uniform disc about its middle; mass [kg], radius and thickness along z [m]."""
    across = mass * (3 * radius**2 + thickness**2) / 12
    return Solid(np.pi * radius**2 * thickness, np.zeros(3), np.diag((across, across, mass * radius**2 / 2)))


def disc_points(radius: float, thickness: float) -> Array:
    """Return the centre of a disc and points of its rims [m], (17, 3), of a disc without thickness (9, 3).

    Eight of each rim, every eighth of a turn from x over y; first those of the rim below, z < 0.
    """
    ends = np.array([(1.0, 0.0), (ROOT_HALF, ROOT_HALF)])
    turned = [ends @ turn for turn in (((1, 0), (0, 1)), ((0, 1), (-1, 0)), ((-1, 0), (0, -1)), ((0, -1), (1, 0)))]
    circle = radius * np.concatenate(turned)
    rims = [np.column_stack((circle, np.full(8, z))) for z in sorted({-thickness / 2, thickness / 2})]
    return np.concatenate((np.zeros((1, 3)), *rims))


def mesh(mass: float, points: Array, faces: np.ndarray) -> Solid:
    """Return the mass properties of the uniform solid inside a closed surface of triangles.

    Parameters
    ----------
    mass : kg
    points : (n, 3), m
    faces : (m, 3)
        indices into points, all with the same orientation

    Returns
    -------
    solid
        with a negative volume if the faces are clockwise seen from outside

    Raises
    ------
    ValueError
        The surface encloses no volume.

    Notes
    -----
    Source: the integrals of CE1051A report, eqs. 2.1-2.11, as a sum of signed tetrahedra: Tonon, "Explicit exact
    formulas for the 3-D tetrahedron inertia tensor in terms of its vertex coordinates" (2004).
    """
    # Near its own middle and in units of its own size the sums lose nothing, wherever the file has put the mesh.
    low, high = points.min(axis=0), points.max(axis=0)
    middle, size = low + (high - low) / 2, float((high - low).max())
    if not size > 0:
        raise ValueError("must enclose a volume")
    unit_points = (points - middle) / size
    volume, moment = _tetrahedra(unit_points[faces])[:2]
    if abs(volume) < 1e-15:  # of the cube around it: no more than the rounding of the sum
        raise ValueError("must enclose a volume")
    centre = moment / volume
    second = _tetrahedra(unit_points[faces] - centre)[2] / volume
    tensor = _tensor(second)
    np.fill_diagonal(tensor, _as_one(np.diag(tensor)))
    return Solid(volume * size**3, middle + size * centre, mass * size**2 * tensor)


def _tensor(second: Array) -> Array:
    """Return the inertia tensor from the mean of r r^T, (3, 3) (CE1051A report, eqs. 2.6-2.8)."""
    xx, yy, zz = np.diag(second)
    # Not trace - second: on a needle along x, A would be the small difference of two large sums.
    return np.diag((yy + zz, zz + xx, xx + yy)) - (second - np.diag((xx, yy, zz)))


def _tetrahedra(triangles: Array) -> tuple[float, Array, Array]:
    """Return the integrals of 1, r, (3,), and r r^T, (3, 3), over the tetrahedra from the origin to each triangle."""
    a, b, c = np.moveaxis(triangles, 1, 0)
    six_volumes = np.einsum("ij,ij->i", a, np.cross(b, c))
    corners = np.stack((a, b, c, a + b + c))
    second = np.einsum("i,kip,kiq->pq", six_volumes, corners, corners) / 120
    return float(six_volumes.sum() / 6), six_volumes @ corners[3] / 24, second


def principal_axes(tensor: Array) -> tuple[Array, Array]:
    """Return the principal moments [kg m2], (3,), and the quaternion w x y z, (4,), input axes -> principal axes.

    tensor: symmetric [kg m2], (3, 3).  Of the many choices (order, signs, any axes where moments are equal) the one
    that turns least is taken; a tensor that is diagonal already keeps its axes exactly.
    """
    scale = np.abs(tensor).max()
    if np.abs(tensor - np.diag(np.diag(tensor))).max() <= DIAGONAL * scale:
        return np.diag(tensor).copy(), np.array([1.0, 0.0, 0.0, 0.0])
    moments, columns = np.linalg.eigh(tensor / scale)
    moments = _as_one(moments)
    # A reflection among the choices has a trace of 1 at most and never wins; the best rotation has 1.9 or more.
    ordered, turn = max(_choices(moments, columns.T), key=lambda choice: np.trace(choice[1]))
    return ordered * scale, _quaternion(turn)


def _as_one(moments: Array) -> Array:
    """Return the moments, (3,), with those made equal that no more than rounding tells apart."""
    rising = np.argsort(moments)
    found = moments.copy()
    for lower, upper in pairwise(rising):
        if found[upper] - found[lower] <= EQUAL * moments[rising[2]]:
            found[upper] = found[lower]
    return found


def _choices(moments: Array, axes: Array) -> Iterator[tuple[Array, Array]]:
    """Yield the moments, (3,), and their axes, (3, 3), one a row, in every order, each laid nearest the input's axes.

    That settles the sign of an axis, and how axes of equal moments lie among themselves: Schonemann, "A generalized
    solution of the orthogonal Procrustes problem" (1966).
    """
    for order in map(list, permutations(range(3))):
        ordered, turn = moments[order], axes[order]
        for moment in set(ordered.tolist()):
            equal = np.flatnonzero(ordered == moment)
            u, _, vt = np.linalg.svd(turn[np.ix_(equal, equal)])
            turn[equal] = (u @ vt).T @ turn[equal]
        yield ordered, turn


def _quaternion(turn: Array) -> Array:
    """Return the quaternion w x y z, (4,), of a rotation matrix that turns by less than 63 degrees.

    The 24 rotations of the cube leave nothing further apart (Mackenzie, 1958), so w is far from zero.
    """
    w = np.sqrt(1 + np.trace(turn)) / 2
    x, y, z = turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]
    q = np.array([w, x / (4 * w), y / (4 * w), z / (4 * w)])
    return q / np.linalg.norm(q)
