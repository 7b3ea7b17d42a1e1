"""Jacobi's functions and Carlson's integrals, written once for doubles and for numbers of 32 digits.

The formulas and their sources are those of `tumble.scenarios.truth.elliptic`.  An angle is told by its cosine and sine,
so that no inverse function is needed but once a throw.
"""

from typing import NamedTuple

import numpy as np

from tumble.scenarios.frames import Array
from tumble.scenarios.truth.bulk.number import Number, bits, cos_sin, near, number, rest, root
from tumble.scenarios.truth.compilation import inner

# More steps than the means, or a duplication, take for any modulus that doubles can hold.
MOST = 20


class Unit(NamedTuple):
    """The cosine and sine of an angle."""

    cos: Number
    sin: Number


class Amplitude(NamedTuple):
    """Jacobi's functions at u."""

    sn: Number
    cn: Number
    dn: Number


@inner
def summed(a: Unit, b: Unit) -> Unit:
    """Return the sum of two angles."""
    return Unit(a.cos * b.cos - a.sin * b.sin, a.cos * b.sin + a.sin * b.cos)


@inner
def opposite(a: Unit) -> Unit:
    """Return the opposite angle."""
    return Unit(a.cos, -a.sin)


@inner
def means_of(kprime: Number, means: Array) -> tuple[Number, int]:
    """Return the arithmetic-geometric mean of 1 and k', and how many steps to it are written to means, (MOST, 4)."""
    arithmetic, geometric = number(kprime, 1.0, 0.0), kprime
    gap, count = 1.0, 0
    while gap > near(arithmetic) * 2.0 ** (-(bits(kprime) // 2)) and count < MOST:
        means[count, 0], means[count, 1] = near(arithmetic), rest(arithmetic)
        means[count, 2], means[count, 3] = near(geometric), rest(geometric)
        gap, count = abs(near(arithmetic - geometric)), count + 1
        arithmetic, geometric = (arithmetic + geometric) * 0.5, root(arithmetic * geometric)
    return arithmetic, count


@inner
def jacobi(u: Number, mean: Number, means: Array, count: int) -> Amplitude:
    """Return Jacobi's functions at u within a quarter period of 0, by Landen's descending steps on cs = cn/sn."""
    cos, sin = cos_sin(mean * u)
    dn = number(u, 1.0, 0.0)
    if near(sin) == 0.0:
        return Amplitude(sin, cos, dn)
    mean_below, cs = mean, mean * cos / sin
    for step in range(count - 1, -1, -1):
        arithmetic = number(u, means[step, 0], means[step, 1])
        geometric = number(u, means[step, 2], means[step, 3])
        ratio = cs * cs / mean_below
        cs = cs * dn
        dn = (geometric + ratio) / (arithmetic + ratio)
        mean_below = arithmetic
    sn = 1.0 / root(1.0 + cs * cs)
    if near(sin) < 0.0:
        sn = -sn
    return Amplitude(sn, cs * sn, dn)


@inner
def first_kind(x: Number, y: Number, z: Number) -> Number:
    """Return RF(x, y, z) by Carlson's duplication; last term to the 7th degree: DLMF 19.36.1."""
    mean = (x + y + z) / 3.0
    X, Y = mean - x, mean - y
    spread = max(abs(near(X)), abs(near(Y)), abs(near(mean - z))) * 2.0 ** (bits(x) / 8 + 1)
    share = 1.0
    while share * spread > near(mean):
        root_x, root_y, root_z = root(x), root(y), root(z)
        shift = root_x * root_y + root_y * root_z + root_z * root_x
        x, y, z, mean = (x + shift) * 0.25, (y + shift) * 0.25, (z + shift) * 0.25, (mean + shift) * 0.25
        share *= 0.25
    X, Y = X * share / mean, Y * share / mean
    Z = -(X + Y)
    E2, E3 = X * Y - Z * Z, X * Y * Z
    square = E2 * E2
    sum_of_terms = (
        1.0 - E2 / 10.0 + E3 / 14.0 + square / 24.0 - E2 * E3 * 3.0 / 44.0
        - square * E2 * 5.0 / 208.0 + E3 * E3 * 3.0 / 104.0 + square * E3 / 16.0
    )  # fmt: skip
    return sum_of_terms / root(mean)


@inner
def third_kind_angle(x: Number, y: Number, p: Number, size: Number, angles: Array) -> tuple[Unit, float]:
    """Return the angle (size / 3) RJ(x, y, 1, p), for 1 >= x, y >= 0 and p > 1, and about how many radians it is.

    size: sqrt((p - x)(p - y)(p - 1)); angles: room, (MOST, 2).  Carlson's duplication; the angles whose tangents it
    sums, each twice the one before, are put together by doubling what there is and adding the next.
    """
    z = number(x, 1.0, 0.0)
    mean = (x + y + z + p * 2.0) / 5.0
    X, Y, Z = mean - x, mean - y, mean - z
    spread = max(abs(near(X)), abs(near(Y)), abs(near(Z)), abs(near(mean - p))) * 2.0 ** (bits(x) / 8 + 1)
    share, part, about, count = 1.0, 1.0, 0.0, 0
    while share * spread > near(mean) and count < MOST:
        root_x, root_y, root_z, root_p = root(x), root(y), root(z), root(p)
        tangent = size * part / ((root_p + root_x) * (root_p + root_y) * (root_p + root_z))
        angles[count, 0], angles[count, 1] = near(tangent), rest(tangent)
        about += 2.0 ** (count + 1) * np.arctan(near(tangent))
        shift = root_x * root_y + root_y * root_z + root_z * root_x
        x, y, z, p = (x + shift) * 0.25, (y + shift) * 0.25, (z + shift) * 0.25, (p + shift) * 0.25
        mean = (mean + shift) * 0.25
        share, part, count = share * 0.25, part * 0.125, count + 1
    total = Unit(number(x, 1.0, 0.0), number(x, 0.0, 0.0))
    for step in range(count - 1, -1, -1):
        total = summed(total, total)
        total = summed(total, Unit(number(x, 1.0, 0.0), number(x, angles[step, 0], angles[step, 1])))
    total = summed(total, total)
    length = root(total.cos * total.cos + total.sin * total.sin)
    left = size * share / (mean * root(mean)) * near_mean(X * share / mean, Y * share / mean, Z * share / mean) / 3.0
    cos, sin = cos_sin(left)
    return summed(Unit(total.cos / length, total.sin / length), Unit(cos, sin)), about + near(left)


@inner
def near_mean(X: Number, Y: Number, Z: Number) -> Number:
    """Return RJ for a mean of 1 and small deviations X, Y, Z (DLMF 19.36.2)."""
    P = (X + Y + Z) * -0.5
    XYZ, PP = X * Y * Z, P * P
    E2 = X * Y + X * Z + Y * Z - PP * 3.0
    E3 = XYZ + P * 2.0 * (E2 + PP * 2.0)
    E4 = P * (XYZ * 2.0 + P * (E2 + PP * 3.0))
    E5 = XYZ * PP
    return (
        1.0 - E2 * 3.0 / 14.0 + E3 / 6.0 + E2 * E2 * 9.0 / 88.0 - E4 * 3.0 / 22.0 - E2 * E3 * 9.0 / 52.0
        + E5 * 3.0 / 26.0 - E2 * E2 * E2 / 16.0 + E3 * E3 * 3.0 / 40.0 + E2 * E4 * 3.0 / 20.0
        + E2 * E2 * E3 * 45.0 / 272.0 - (E3 * E4 + E2 * E5) * 9.0 / 68.0
    )  # fmt: skip
