"""The inertia of a body as its file gives it: the exact tensor, and its principal axes to any number of digits.

Numbers are fractions; a mesh is summed in whole numbers.  Only principal axes that are no axes of the file are
irrational, and they come with the working precision.
"""

from math import isqrt, lcm, sqrt
from typing import Any, NamedTuple

import numpy as np

from tumble.scenarios.truth.rational import Fraction, cross, gmpy2

Numbers = np.ndarray
# What stands for a root that is no fraction: more digits than any flight is worked out with.
ROOT_BITS = 4400


class Solid(NamedTuple):
    """mass [kg]; centre of mass [m], (3,); inertia tensor about it [kg m2], (3, 3): fractions, the file's axes."""

    mass: Fraction
    centre: Numbers
    tensor: Numbers


class Principal(NamedTuple):
    """Principal moments [kg m2], (3,), and the axes they are about, the columns of a rotation, (3, 3), file axes.

    Where the tensor is diagonal the axes are the file's, in whole numbers, and the moments fractions.
    """

    moments: Numbers
    axes: Numbers


def box(mass: Fraction, size: Numbers) -> Solid:
    """Return a uniform box of full edges (3,) [m] about its middle.  Source: IGR202 report, section 2.1."""
    return Solid(mass, _zeros(3), _tensor(mass, np.diag(size * size / 12)))


def sphere(mass: Fraction, radius: Fraction) -> Solid:
    """Return a uniform sphere about its middle; mass [kg], radius [m]."""
    return Solid(mass, _zeros(3), mass * radius * radius * Fraction(2, 5) * identity())


def disc(mass: Fraction, radius: Fraction, thickness: Fraction) -> Solid:
    """Return a uniform disc about its middle, its axis along z; mass [kg], radius and thickness [m]."""
    across = mass * (3 * radius * radius + thickness * thickness) / 12
    moments = np.array([across, across, mass * radius * radius / 2], dtype=object)
    return Solid(mass, _zeros(3), identity() * moments)


def mesh(mass: Fraction, points: Numbers, faces: np.ndarray) -> Solid:
    """Return the uniform solid inside a closed surface; points: [m], (n, 3), faces: (m, 3), all turning the same way.

    Source: Tonon, "Explicit exact formulas for the 3-D tetrahedron inertia tensor in terms of its vertex coordinates"
    (2004), as sums of signed tetrahedra, which are whole numbers where the points are.
    """
    grain = lcm(*{coordinate.denominator for coordinate in points.flat})
    # From a corner of its own the numbers are as short as the mesh is small.
    whole = np.array([int(coordinate * grain) for coordinate in (points - points[0]).flat], dtype=object)
    a, b, c = (whole.reshape(-1, 3)[faces[:, corner]] for corner in range(3))
    volumes = (a * np.roll(b, -1, axis=1) * np.roll(c, -2, axis=1)).sum(axis=1)
    volumes = volumes - (a * np.roll(b, -2, axis=1) * np.roll(c, -1, axis=1)).sum(axis=1)
    far = a + b + c
    volume = Fraction(int(volumes.sum()), 6)
    centre = np.array([Fraction(int(total), 24) for total in volumes @ far]) / volume
    second = np.empty((3, 3), dtype=object)
    for row in range(3):
        for column in range(row + 1):
            products = a[:, row] * a[:, column] + b[:, row] * b[:, column] + c[:, row] * c[:, column]
            total = Fraction(int(volumes @ (products + far[:, row] * far[:, column])), 120)
            second[row, column] = second[column, row] = total / volume - centre[row] * centre[column]
    return Solid(mass, points[0] + centre / grain, _tensor(mass, second / grain**2))


def _tensor(mass: Fraction, second: Numbers) -> Numbers:
    """Return the inertia tensor from the mean of r r^T, (3, 3) (CE1051A report, eqs. 2.6-2.8)."""
    return mass * (np.trace(second) * identity() - second)


def _zeros(count: int) -> Numbers:
    return np.array([Fraction(0)] * count)


def identity() -> Numbers:
    """Return the unit matrix, (3, 3), in fractions."""
    return np.array([[Fraction(int(row == column)) for column in range(3)] for row in range(3)])


def inverse(tensor: Numbers) -> Numbers:
    """Return the inverse of a symmetric tensor, (3, 3), exactly."""
    cofactors = np.array([cross(tensor[row - 2], tensor[row - 1]) for row in range(3)])
    return cofactors.T / (tensor[0] @ cofactors[0])


def square_root(value: Fraction) -> Fraction:
    """Return the root of a fraction: exactly where it is one, else to ROOT_BITS."""
    n, d = value.numerator, value.denominator
    if isqrt(n) ** 2 == n and isqrt(d) ** 2 == d:
        return Fraction(isqrt(n), isqrt(d))
    shift = ROOT_BITS + max(0, d.bit_length() - n.bit_length()) // 2
    return Fraction(isqrt((n << 2 * shift) // d), 1 << shift)


def root_of(value: Any) -> Any:
    """Return the root of a fraction, of a double, or of an extended-precision number to its digits."""
    if isinstance(value, Fraction):
        return square_root(value)
    if isinstance(value, float):
        return sqrt(value)
    return value.context.sqrt(value) if hasattr(value, "context") else gmpy2.sqrt(value)


def principal(mp: Any, tensor: Numbers) -> Principal:
    """Return principal moments and axes; which moments are equal is decided in fractions.

    mp: mpmath context at the wanted precision; tensor: symmetric, fractions, (3, 3).
    """
    if not any((tensor[0, 1], tensor[0, 2], tensor[1, 2])):
        return Principal(tensor.diagonal().copy(), identity())
    mean = np.trace(tensor) / 3
    off = tensor - mean * identity()
    # The moments less their mean are the roots of t^3 - p t - q.
    p, q = (off * off).sum() / 2, off[0] @ cross(off[1], off[2])
    if 4 * p**3 == 27 * q**2:
        return _symmetric(mp, tensor, mean + 3 * q / p, mean - 3 * q / (2 * p))
    bits = mp.prec
    try:
        # Close moments share out their digits: as many again for them.
        mp.prec = 2 * bits + 64
        moments, columns = mp.eigsy(mp.matrix(tensor.tolist()))
        axes = np.array(columns.tolist(), dtype=object)
        if cross(axes[:, 0], axes[:, 1]) @ axes[:, 2] < 0:
            axes = -axes
        return Principal(np.array(list(moments), dtype=object), axes)
    finally:
        mp.prec = bits


def _symmetric(mp: Any, tensor: Numbers, single: Fraction, double: Fraction) -> Principal:
    """Return the principal moments and some axes of a tensor with one moment of its own and two that are equal."""
    # What is left of the tensor without the double moment is along the single one's axis.
    rest = tensor - double * identity()
    line = max(rest, key=lambda row: row @ row)
    third = line / mp.sqrt(line @ line)
    across = cross(third, identity()[min(range(3), key=lambda axis: abs(third[axis]))])
    first = across / mp.sqrt(across @ across)
    return Principal(np.array([double, double, single]), np.array([first, cross(third, first), third]).T)
