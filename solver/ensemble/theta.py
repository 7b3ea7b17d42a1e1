"""Theta series in lanes: six terms, nomes up to 0.35; what needs a logarithm is had from Gauss's mean and square roots.

An angle is a point of the unit circle, as a complex number.  Source: as in `tumble.solver.theta`; Gauss's mean with its
angles: Bulirsch, "Numerical calculation of elliptic integrals and elliptic functions" (1965).
"""

import math

from tumble.solver.ensemble.lanes import lane
from tumble.solver.vectors import Vector

Pair = tuple[float, float]
Terms = tuple[float, ...]

# 2 pi in three parts, of 33 bits but for the last: whole turns up to 2^20 are taken off without rounding.
TURN_HIGH, TURN_MIDDLE, TURN_LOW = 6.2831853069365025, 2.4308402025215864e-10, 8.089064995183803e-21
# Adding and taking off 3 * 2^51 rounds to whole numbers.
WHOLE = 6755399441055744.0


@lane
def unit(a: Pair) -> Pair:
    """Return a over its length."""
    shrink = 1.0 / math.sqrt(a[0] * a[0] + a[1] * a[1])
    return (shrink * a[0], shrink * a[1])


@lane
def square(a: Pair) -> Pair:
    """Return the square of a complex number."""
    return ((a[0] - a[1]) * (a[0] + a[1]), 2.0 * a[0] * a[1])


@lane
def times_conjugate(a: Pair, b: Pair) -> Pair:
    """Return a times the conjugate of b."""
    return (a[0] * b[0] + a[1] * b[1], a[1] * b[0] - a[0] * b[1])


@lane
def turned(a: Pair, b: Pair) -> Pair:
    """Return the product of two complex numbers."""
    return (a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0])


@lane
def direction(angle: float) -> Pair:
    """Return the cosine and the sine of an angle [rad]: Taylor's series of its half, whole turns taken off."""
    whole = (angle * 0.15915494309189535 + WHOLE) - WHOLE
    half = 0.5 * (((angle - whole * TURN_HIGH) - whole * TURN_MIDDLE) - whole * TURN_LOW)
    s = half * half
    s2 = s * s
    s4 = s2 * s2
    cosine = (
        ((1.0 - s * (1 / 2)) + s2 * (1 / 24 - s * (1 / 720)))
        + s4 * ((1 / 40320 - s * (1 / 3628800)) + s2 * (1 / 479001600 - s * (1 / 87178291200)))
        + s4 * s4 * (1 / 20922789888000 - s * (1 / 6402373705728000))
        + s4 * s4 * s2 * (1 / 2432902008176640000 - s * (1 / 1124000727777607680000))
    )
    sine = half * (
        ((1.0 - s * (1 / 6)) + s2 * (1 / 120 - s * (1 / 5040)))
        + s4 * ((1 / 362880 - s * (1 / 39916800)) + s2 * (1 / 6227020800 - s * (1 / 1307674368000)))
        + s4 * s4 * (1 / 355687428096000 - s * (1 / 121645100408832000))
        + s4 * s4 * s2 * (1 / 51090942171709440000)
    )
    return (1.0 - 2.0 * sine * sine, 2.0 * sine * cosine)


@lane
def levels(m: float, m1: float) -> tuple[Vector, Vector, Pair, Pair]:
    """Return three steps of Gauss's mean, downward from the modulus k of m = k^2 = 1 - m1, each to the square nome.

    Returned are k' and 1 - k' of the levels 0, 1, 2; sqrt(k') and 1 - sqrt(k') of level 3; the nome of level 0 and its
    sqrt(k').  Nothing cancels where k is small.
    """
    ratio0 = math.sqrt(m1)
    root0 = math.sqrt(ratio0)
    split = 1.0 / ((1.0 + ratio0) * (1.0 + root0))
    per_sum0 = split * (1.0 + root0)
    lack0 = m * per_sum0
    gap = lack0 * split * (1.0 + ratio0)
    ratio1, lack1 = 2.0 * root0 * per_sum0, gap * gap * per_sum0
    root1 = math.sqrt(ratio1)
    split = 1.0 / ((1.0 + ratio1) * (1.0 + root1))
    per_sum1 = split * (1.0 + root1)
    gap = lack1 * split * (1.0 + ratio1)
    ratio2, lack2 = 2.0 * root1 * per_sum1, gap * gap * per_sum1
    root2 = math.sqrt(ratio2)
    split = 1.0 / ((1.0 + ratio2) * (1.0 + root2))
    per_sum2 = split * (1.0 + root2)
    per_root2 = split * (1.0 + ratio2)
    gap = lack2 * per_root2
    ratio3, lack3 = 2.0 * root2 * per_sum2, gap * gap * per_sum2
    root3 = math.sqrt(ratio3)
    half = 0.5 * gap * per_root2
    fourth = half * half * half * half
    nome = math.sqrt(math.sqrt(half * (1.0 + fourth * (2.0 + 15.0 * fourth))))
    return (ratio0, ratio1, ratio2), (lack0, lack1, lack2), (root3, lack3 / (1.0 + root3)), (nome, root0)


@lane
def halved(whole: Pair, near: Pair) -> Pair:
    """Return half the angle of a unit number: of the two halves that nearer to another number's angle."""
    other = times_conjugate(whole, near)
    return unit((near[0] + other[0], near[1] + other[1]))


@lane
def doubled(amplitude: Pair, ratio: float) -> Pair:
    """Return the amplitude at the next level, where its angle is twice as large; both at any length."""
    cn, sn = amplitude
    return (cn * cn - ratio * sn * sn, (1.0 + ratio) * cn * sn)


@lane
def phase_angle(amplitude: Pair, ratios: Vector, root3: float, nome8: float) -> Pair:
    """Return the angle pi u/(2 K) of u from its amplitude, (cn u, sn u), both as points of the unit circle.

    Gauss's steps double the angle, of which no branch is lost: the way back is by halves, near what the way out met.
    At the third level the amplitude is the angle but for sines of its multiples times nome8^2 < 6e-8.
    """
    first = doubled(amplitude, ratios[0])
    second = doubled(first, ratios[1])
    third = doubled(second, ratios[2])
    point = unit((third[0], root3 * third[1]))
    fourfold = square(square(point))
    small = nome8 * nome8
    rest = small * fourfold[1] * (1.0 + 3.0 * small * fourfold[0])
    octuple = turned(point, (1.0 - 0.5 * rest * rest, rest))
    return halved(halved(halved(octuple, second), first), amplitude)


@lane
def decay_of_shift(
    sn: float, lack: float, ratios: Vector, lacks: Vector, root3: float, lack_root3: float, nome8: float
) -> Vector:
    """Return exp(2 x), exp(-2 x) and 1 - exp(-2 x) for x = pi v/(2 K), where sn = sn(v, k') and v <= K'/2.

    lack: 1 - sn.  The steps of phase_angle at an imaginary angle, with the difference of the hyperbolic cosine and sine
    carried along, where it would cancel.
    """
    cosh1 = 1.0 + ratios[0] * sn * sn
    sinh1 = (1.0 + ratios[0]) * sn
    gap1 = lack * (lack + lacks[0] * sn)
    cosh2 = cosh1 * cosh1 + ratios[1] * sinh1 * sinh1
    sinh2 = (1.0 + ratios[1]) * cosh1 * sinh1
    gap2 = gap1 * (gap1 + lacks[1] * sinh1)
    cosh3 = cosh2 * cosh2 + ratios[2] * sinh2 * sinh2
    sinh3 = (1.0 + ratios[2]) * cosh2 * sinh2
    gap3 = gap2 * (gap2 + lacks[2] * sinh2)
    low, high = gap3 + lack_root3 * sinh3, cosh3 + root3 * sinh3
    split = 1.0 / (low * high)
    grown, shrunk = high * high * split, low * low * split
    grown_less_1 = 2.0 * root3 * sinh3 * high * split
    # x (1 + nome8^2/x^2) = grown (1 + nome8^2 x^2), by Lagrange's series.
    small = nome8 * nome8
    g = small * grown * grown
    rest = grown * (g * (1.0 + g * (2.0 + g * (5.0 + 14.0 * g))) - small * shrunk * shrunk)
    x16 = grown + rest
    x8 = math.sqrt(x16)
    x4 = math.sqrt(x8)
    x2 = math.sqrt(x4)
    steps = (x8 + 1.0) * (x4 + 1.0) * (x2 + 1.0)
    split = 1.0 / (x2 * steps)
    return x2, split * steps, (grown_less_1 + rest) * split


@lane
def shift_waves(decay: float, lack: float, growth: float, nome: float) -> tuple[Terms, Terms]:
    """Return nome^(n (n + 1)) times 2 cosh and 2 sinh of (2n + 1) x, over e^x, n = 0 ... 5.

    decay: exp(-2 x); lack: 1 - decay; growth: nome exp(2 x).
    """
    n2 = nome * nome
    n4 = n2 * n2
    n6 = n4 * n2
    n8 = n4 * n4
    up1, down1 = nome * growth, n2 * decay * decay
    up2, down2 = up1 * n2 * nome * growth, down1 * n4 * decay
    up3, down3 = up2 * n4 * nome * growth, down2 * n6 * decay
    up4, down4 = up3 * n6 * nome * growth, down3 * n8 * decay
    up5, down5 = up4 * n8 * nome * growth, down4 * n8 * n2 * decay
    return (
        (1.0 + decay, up1 + down1, up2 + down2, up3 + down3, up4 + down4, up5 + down5),
        (lack, up1 - down1, up2 - down2, up3 - down3, up4 - down4, up5 - down5),
    )


@lane
def odd_waves(angle: Pair) -> tuple[Terms, Terms]:
    """Return the cosines and the sines of 1, 3, ... 11 times an angle."""
    c1, s1 = angle
    double = 2.0 * (c1 - s1) * (c1 + s1)
    c3, s3 = c1 * (double - 1.0), s1 * (double + 1.0)
    c5, s5 = double * c3 - c1, double * s3 - s1
    c7, s7 = double * c5 - c3, double * s5 - s3
    c9, s9 = double * c7 - c5, double * s7 - s5
    c11, s11 = double * c9 - c7, double * s9 - s7
    return (c1, c3, c5, c7, c9, c11), (s1, s3, s5, s7, s9, s11)


@lane
def sum_of(a: Terms, b: Terms) -> float:
    """Return the scalar product of six terms."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] + a[4] * b[4] + a[5] * b[5]


@lane
def alternating_sum_of(a: Terms, b: Terms) -> float:
    """Return the scalar product of six terms, the signs of every second one turned."""
    return a[0] * b[0] - a[1] * b[1] + a[2] * b[2] - a[3] * b[3] + a[4] * b[4] - a[5] * b[5]


@lane
def half_phase(cosh: Terms, sinh: Terms, cosines: Terms, sines: Terms, seen: Pair) -> Pair:
    """Return a complex number whose phase is p/2: p that of theta1 at the complex angle, less that of L1 + i L2."""
    phase = times_conjugate((alternating_sum_of(sinh, cosines), alternating_sum_of(cosh, sines)), seen)
    return (phase[0] + math.sqrt(phase[0] * phase[0] + phase[1] * phase[1]), phase[1])
