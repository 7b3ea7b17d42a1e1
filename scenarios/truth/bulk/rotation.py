"""The closed form of a free rotation, written once for doubles and for numbers of 32 digits.

The formulas and their sources are those of `tumble.scenarios.truth.rotation`.  Differences of moments come from the
caller, right to their last digit, and what is subtracted here is never close but on the separatrix.
"""

from typing import Any, NamedTuple

from tumble.scenarios.frames import Array
from tumble.scenarios.truth.bulk.elliptic import (
    Unit,
    about,
    first_kind,
    jacobi,
    means_of,
    opposite,
    summed,
    third_kind_angle,
)
from tumble.scenarios.truth.bulk.number import (
    RIGHT_ANGLE,
    Columns,
    Number,
    Vector,
    along,
    angle,
    cos_sin,
    dot,
    near,
    number,
    root,
    stretched,
    where,
)
from tumble.scenarios.truth.compilation import inner
from tumble.scenarios.truth.lanes import below, whole


class Moments(NamedTuple):
    """Principal moments, the least first, and second - first, third - first, third - second [kg m2], (3,) each."""

    values: Vector
    gaps: Vector


class Frame(NamedTuple):
    """The axes of Euler's curve: their signs, and whether the first is along the body's third."""

    flipped: Any
    signs: tuple[Any, Any, Any]


class Curve(NamedTuple):
    """L = (a1 cn, a2 sn, a3 dn)(u0 + rate t) and, about L, precession t less what psi(u) has become since psi0.

    mean, count, steps: of Landen's steps; n, size: of psi; start: the axes less the angle about L, columns, world.
    """

    frame: Frame
    a: Vector
    rate: Number
    u0: Number
    mean: Number
    count: Any
    steps: int
    quarter_period: Number
    n: Number
    size: Number
    psi_quarter: Number
    psi0: Unit
    L: Number
    precession: Number
    start: Columns


@inner
def is_steady(moments: Moments, L: Vector) -> Any:
    """Return whether w is along L: no two axes with different moments both have a part of it."""
    first, second, third = near(L[0]) != 0.0, near(L[1]) != 0.0, near(L[2]) != 0.0
    return ~(
        (first & second & (near(moments.gaps[0]) != 0.0))
        | (first & third & (near(moments.gaps[1]) != 0.0))
        | (second & third & (near(moments.gaps[2]) != 0.0))
    )


@inner
def spun(axes: Columns, w_body: Vector, t: Number) -> Columns:
    """Return the axes after a steady spin.  Source: Rodrigues' formula, Goldstein (1980), eq. 4-92."""
    speed = root(dot(w_body, w_body))
    cos, sin = cos_sin(speed * t)
    x, y, z = w_body[0] / speed, w_body[1] / speed, w_body[2] / speed
    less, still = 1.0 - cos, near(speed) == 0.0
    return (
        where(still, axes[0], along(axes, (x * x * less + cos, x * y * less + z * sin, x * z * less - y * sin))),
        where(still, axes[1], along(axes, (x * y * less - z * sin, y * y * less + cos, y * z * less + x * sin))),
        where(still, axes[2], along(axes, (x * z * less + y * sin, y * z * less - x * sin, z * z * less + cos))),
    )


@inner
def encircling(moments: Moments, L: Vector) -> Frame:
    """Return the frame in which L3 > 0 circles axis 3 and L1 >= 0; on the separatrix axis 3 has the greatest moment."""
    least, _, greatest = moments.values
    side = L[2] * L[2] * moments.gaps[2] / greatest - L[0] * L[0] * moments.gaps[0] / least
    flipped = ~(near(side) >= 0.0)
    one = where(near(where(flipped, L[2], L[0])) >= 0.0, 1.0, -1.0)
    three = where(near(where(flipped, L[0], L[2])) >= 0.0, 1.0, -1.0)
    return Frame(flipped, (one, one * three * where(flipped, -1.0, 1.0), three))


@inner
def in_frame(frame: Frame, a: Vector) -> Vector:
    """Return what the body's axes have, a vector's components or three vectors' one, along the frame's."""
    first, third = where(frame.flipped, a[2], a[0]), where(frame.flipped, a[0], a[2])
    return first * frame.signs[0], a[1] * frame.signs[1], third * frame.signs[2]


@inner
def polhode(moments: Moments, axes: Columns, L_body: Vector, means: Array, angles: Array) -> Curve:
    """Return the motion from given axes, columns, world, with an angular momentum along them [kg m2/s].

    means, angles: room, (MOST, 4, WIDTH) and (MOST, 2, WIDTH), of which the means are to be kept.
    """
    frame = encircling(moments, L_body)
    L = in_frame(frame, L_body)
    flipped, (least, I2, greatest), (low_gap, outer, high_gap) = frame.flipped, moments.values, moments.gaps
    I1, I3 = where(flipped, greatest, least), where(flipped, least, greatest)
    inner_gap, rest_gap = where(flipped, high_gap, low_gap), where(flipped, low_gap, high_gap)
    # (I2 - I1) and (I3 - I2) over (I3 - I1).
    s, r = inner_gap / outer, rest_gap / outer
    # (L^2 - 2E I1), (L^2 - 2E I2) and (2E I3 - L^2), over (I3 - I1).
    above_1 = L[1] * L[1] * s / I2 + L[2] * L[2] / I3
    above_2 = L[2] * L[2] * r / I3 - L[0] * L[0] * s / I1
    below_3 = L[0] * L[0] / I1 + L[1] * L[1] * r / I2
    a = root(I1 * below_3), root(I2 * below_3 / r), root(I3 * above_1)
    rate = root(above_1 * outer * rest_gap / (I1 * I2 * I3))
    rate = where(flipped, -rate, rate)

    kprime = root(above_2 / (above_1 * r))
    n = -(I3 * s / (I1 * r))
    size = s / r * root(I3 / I1 * (1.0 - n) * (below_3 / above_1 + I3 / I1))
    mean, count, steps = means_of(kprime, means)
    quarter_period = number(mean, RIGHT_ANGLE[0], RIGHT_ANGLE[1]) / mean
    one, none = number(mean, 1.0, 0.0), number(mean, 0.0, 0.0)
    quarter, left, parts = third_kind_angle(none, kprime * kprime, 1.0 - n, size, angles)
    psi_quarter = angle(quarter.cos, quarter.sin, about(angles, parts, left))

    cn, sn, dn = L[0] / a[0], L[1] / a[1], L[2] / a[2]
    u0 = sn * first_kind(cn * cn, dn * dn, one)
    total = root(dot(L, L))
    start_frame = (
        stretched(where(flipped, axes[2], axes[0]), frame.signs[0]),
        stretched(axes[1], frame.signs[1]),
        stretched(where(flipped, axes[0], axes[2]), frame.signs[2]),
    )
    polar, azimuthal, up = momentum_frame(L, total)
    start = along(start_frame, polar), along(start_frame, azimuthal), along(start_frame, up)
    return Curve(
        frame, a, rate, u0, mean, count, steps, quarter_period, n, size, psi_quarter,
        psi(sn, cn, dn, n, size, angles), total, total / I1, start,
    )  # fmt: skip


@inner
def psi(sn: Number, cn: Number, dn: Number, n: Number, size: Number, angles: Array) -> Unit:
    """Return the angle psi for u within a quarter period of 0."""
    square = sn * sn
    cube, back = square * sn, near(sn) < 0.0
    cube = where(back, -cube, cube)
    found, _, _ = third_kind_angle(cn * cn, dn * dn, 1.0 - n * square, size * cube, angles)
    return Unit(found.cos, where(back, -found.sin, found.sin))


@inner
def momentum_frame(L: Vector, total: Number) -> Columns:
    """Return three vectors: down L's meridian, along its parallel, along L."""
    across = root(L[0] * L[0] + L[1] * L[1])
    cos, sin = L[0] / across, L[1] / across
    up, out = L[2] / total, across / total
    return (cos * up, sin * up, -out), (-sin, cos, number(total, 0.0, 0.0)), (cos * out, sin * out, up)


@inner
def turned(curve: Curve, t: Number, means: Array, angles: Array) -> tuple[Columns, Vector]:
    """Return the axes, columns, world, and the angular momentum along them at t [s] after the start."""
    u = curve.u0 + curve.rate * t
    half_periods = whole(near(u) / (2.0 * near(curve.quarter_period)))
    sn, cn, dn = jacobi(u - curve.quarter_period * (2.0 * half_periods), curve.mean, means, curve.count, curve.steps)
    cos, sin = cos_sin(curve.precession * t - curve.psi_quarter * (2.0 * half_periods))
    since = summed(curve.psi0, opposite(psi(sn, cn, dn, curve.n, curve.size, angles)))
    cos, sin = summed(Unit(cos, sin), since)
    is_odd = below(half_periods / 2.0) * 2.0 != half_periods
    sn, cn = where(is_odd, -sn, sn), where(is_odd, -cn, cn)
    L = curve.a[0] * cn, curve.a[1] * sn, curve.a[2] * dn
    polar, azimuthal, up = momentum_frame(L, curve.L)
    # The columns of start times the rows (polar cos - azimuthal sin, polar sin + azimuthal cos, up).
    frame_axes = (
        along(curve.start, (polar[0] * cos - azimuthal[0] * sin, polar[0] * sin + azimuthal[0] * cos, up[0])),
        along(curve.start, (polar[1] * cos - azimuthal[1] * sin, polar[1] * sin + azimuthal[1] * cos, up[1])),
        along(curve.start, (polar[2] * cos - azimuthal[2] * sin, polar[2] * sin + azimuthal[2] * cos, up[2])),
    )
    one, two, three = curve.frame.signs
    first, second, third = stretched(frame_axes[0], one), stretched(frame_axes[1], two), stretched(frame_axes[2], three)
    L1, L2, L3 = L[0] * one, L[1] * two, L[2] * three
    flipped = curve.frame.flipped
    return (
        (where(flipped, third, first), second, where(flipped, first, third)),
        (where(flipped, L3, L1), L2, where(flipped, L1, L3)),
    )
