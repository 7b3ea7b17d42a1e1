"""Jacobi's functions and Carlson's integrals, written once for doubles and for numbers of 32 digits.

The formulas and their sources are those of `tumble.scenarios.truth.elliptic`.  An angle is told by its cosine and sine,
so that no inverse function is needed but once a throw.
"""

from typing import Any, NamedTuple

from tumble.scenarios.frames import Array
from tumble.scenarios.truth.bulk.number import Number, bits, cos_sin, near, number, rest, root, where
from tumble.scenarios.truth.compilation import inner
from tumble.scenarios.truth.lanes import any_of, arctangent, lanes, load, size, store

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
def means_of(kprime: Number, means: Array) -> tuple[Number, Any, int]:
    """Return the arithmetic-geometric mean of 1 and k', how many steps to it are written, and the most of any lane.

    means: room, (MOST, 4, WIDTH).
    """
    arithmetic, geometric = number(kprime, 1.0, 0.0), kprime
    gap, count, steps = lanes(1.0), lanes(0.0), 0
    near_enough = 2.0 ** (-(bits(kprime) // 2))
    going = gap > near(arithmetic) * near_enough
    while any_of(going) and steps < MOST:
        store(means, 4 * steps, near(arithmetic))
        store(means, 4 * steps + 1, rest(arithmetic))
        store(means, 4 * steps + 2, near(geometric))
        store(means, 4 * steps + 3, rest(geometric))
        gap, count, steps = size(near(arithmetic - geometric)), where(going, count + 1.0, count), steps + 1
        arithmetic, geometric = (
            where(going, (arithmetic + geometric) * 0.5, arithmetic),
            where(going, root(arithmetic * geometric), geometric),
        )
        going = going & (gap > near(arithmetic) * near_enough)
    return arithmetic, count, steps


@inner
def jacobi(u: Number, mean: Number, means: Array, count: Any, steps: int) -> Amplitude:
    """Return Jacobi's functions at u within a quarter period of 0, by Landen's descending steps on cs = cn/sn."""
    cos, sin = cos_sin(mean * u)
    one = number(u, 1.0, 0.0)
    dn, mean_below, cs = one, mean, mean * cos / sin
    for step in range(steps - 1, -1, -1):
        arithmetic = number(u, load(means, 4 * step), load(means, 4 * step + 1))
        geometric = number(u, load(means, 4 * step + 2), load(means, 4 * step + 3))
        ratio = cs * cs / mean_below
        is_own = count > 1.0 * step
        cs = where(is_own, cs * dn, cs)
        dn = where(is_own, (geometric + ratio) / (arithmetic + ratio), dn)
        mean_below = where(is_own, arithmetic, mean_below)
    sn = 1.0 / root(1.0 + cs * cs)
    sn = where(near(sin) < 0.0, -sn, sn)
    none = near(sin) == 0.0
    return Amplitude(where(none, sin, sn), where(none, cos, cs * sn), where(none, one, dn))


@inner
def first_kind(x: Number, y: Number, z: Number) -> Number:
    """Return RF(x, y, z) by Carlson's duplication; last term to the 7th degree: DLMF 19.36.1."""
    mean = (x + y + z) / 3.0
    X, Y = mean - x, mean - y
    spread = larger(size(near(X)), size(near(Y)), size(near(mean - z))) * 2.0 ** (bits(x) / 8 + 1)
    share = lanes(1.0)
    going = spread > near(mean)
    while any_of(going):
        root_x, root_y, root_z = root(x), root(y), root(z)
        shift = root_x * root_y + root_y * root_z + root_z * root_x
        x, y = where(going, (x + shift) * 0.25, x), where(going, (y + shift) * 0.25, y)
        z, mean = where(going, (z + shift) * 0.25, z), where(going, (mean + shift) * 0.25, mean)
        share = where(going, share * 0.25, share)
        going = going & (share * spread > near(mean))
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
def larger(a: Any, b: Any, c: Any) -> Any:
    """Return the largest of three doubles."""
    most = where(b > a, b, a)
    return where(c > most, c, most)


@inner
def third_kind_angle(x: Number, y: Number, p: Number, scale: Number, angles: Array) -> tuple[Unit, Any, int]:
    """Return the angle (scale / 3) RJ(x, y, 1, p), for 1 >= x, y >= 0 and p > 1, what its last part is, and the steps.

    scale: sqrt((p - x)(p - y)(p - 1)); angles: room, (MOST, 2, WIDTH).  Carlson's duplication; the angles whose
    tangents it sums, each twice the one before, are put together by doubling what there is and adding the next.
    """
    one, none = number(x, 1.0, 0.0), number(x, 0.0, 0.0)
    z = one
    mean = (x + y + z + p * 2.0) / 5.0
    X, Y, Z = mean - x, mean - y, mean - z
    spread = larger(size(near(X)), size(near(Y)), size(near(Z)))
    spread = larger(spread, size(near(mean - p)), spread) * 2.0 ** (bits(x) / 8 + 1)
    share, part, count, steps = lanes(1.0), lanes(1.0), lanes(0.0), 0
    going = spread > near(mean)
    while any_of(going) and steps < MOST:
        root_x, root_y, root_z, root_p = root(x), root(y), root(z), root(p)
        tangent = scale * part / ((root_p + root_x) * (root_p + root_y) * (root_p + root_z))
        tangent = where(going, tangent, none)
        store(angles, 2 * steps, near(tangent))
        store(angles, 2 * steps + 1, rest(tangent))
        shift = root_x * root_y + root_y * root_z + root_z * root_x
        x, y = where(going, (x + shift) * 0.25, x), where(going, (y + shift) * 0.25, y)
        z, p = where(going, (z + shift) * 0.25, z), where(going, (p + shift) * 0.25, p)
        mean = where(going, (mean + shift) * 0.25, mean)
        share, part = where(going, share * 0.25, share), where(going, part * 0.125, part)
        count, steps = where(going, count + 1.0, count), steps + 1
        going = going & (share * spread > near(mean))
    total = Unit(one, none)
    for step in range(steps - 1, -1, -1):
        doubled = summed(total, total)
        doubled = summed(doubled, Unit(one, number(x, load(angles, 2 * step), load(angles, 2 * step + 1))))
        is_own = count > 1.0 * step
        total = Unit(where(is_own, doubled.cos, total.cos), where(is_own, doubled.sin, total.sin))
    total = summed(total, total)
    length = root(total.cos * total.cos + total.sin * total.sin)
    left = scale * share / (mean * root(mean)) * near_mean(X * share / mean, Y * share / mean, Z * share / mean) / 3.0
    cos, sin = cos_sin(left)
    return summed(Unit(total.cos / length, total.sin / length), Unit(cos, sin)), near(left), steps


@inner
def about(angles: Array, steps: int, left: Any) -> Any:
    """Return about how many radians the angle is whose parts `third_kind_angle` has written."""
    total = lanes(0.0)
    for step in range(steps):
        total = total + 2.0 ** (step + 1) * arctangent(load(angles, 2 * step))
    return total + left


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
