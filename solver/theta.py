"""Theta series of one throw: nomes up to exp(-pi), of which four terms are all that doubles can tell.

An angle is had as its cosine and sine, a phase as a complex number.  Source: theta functions: Whittaker & Watson,
"Modern Analysis" (1927), chapter 21; DLMF 20.2, 22.2, 22.20(ii).
"""

import math
from typing import NamedTuple

import numpy as np

from tumble.solver.compilation import inner
from tumble.solver.fused import fused
from tumble.solver.quaternion import normalise

Pair = tuple[float, float]
Terms = tuple[float, float, float, float]

# Steps of the arithmetic-geometric mean from a modulus of at most sqrt(1/2): the fifth would change nothing.
LANDEN_STEPS = 4


class Harmonics(NamedTuple):
    """Odd harmonics, n = 0 ... 3: nome^(n (n + 1)) times cosh and sinh of (2n + 1) x, all over e^x / 2."""

    cosh: Terms
    sinh: Terms


@inner
def _small_arctangent(t: float) -> float:
    """Return arctan t for |t| < 0.0076, to rounding."""
    square = t * t
    return t * (1.0 - square * (1 / 3 - square * (1 / 5 - square * (1 / 7))))


@inner
def landen(m: float, m1: float, real: Pair, imaginary: Pair) -> tuple[float, Pair, Pair]:
    """Return pi/(2 K(m)), then the angles pi u/(2 K) of a real and of an imaginary argument u, for m = 1 - m1 <= 1/2.

    real: cn u and sn u; returned are the cosine and the sine.  imaginary: 1 and sn(u)/i, or any multiple of the two;
    returned are multiples of 1 and of the hyperbolic sine.
    Source: Gauss's mean, DLMF 22.20(ii): am doubles and gains arctan((b - a) tan am / (a + b tan^2 am)), so the angle
    is am + gain/2 + gain/4 + ...; the first gain is halved by a bisector, the rest are small.  The imaginary argument:
    Landen's step DLMF 22.7.2, solved for the next sn.
    """
    a, b, c_squared = 1.0, math.sqrt(m1), m
    (cosine, sine), (one, sinh) = real, imaginary
    root = math.sqrt(m1 * sine * sine + cosine * cosine)
    bisector = normalise((cosine * (root + 1.0), sine * (root + b), 0.0, 0.0))
    rest, weight = 0.0, 0.25
    for _ in range(LANDEN_STEPS):
        one *= a
        one, sinh = one + math.sqrt(fused(one, one, c_squared * (sinh * sinh))), (a + b) * sinh
        cosine, sine = fused(a * cosine, cosine, -b * (sine * sine)), (a + b) * (sine * cosine)
        a, b = (a + b) / 2.0, math.sqrt(a * b)
        c = c_squared / (4.0 * a)
        c_squared = c * c
        tangent = (b - a) * (sine * cosine) / fused(a * cosine, cosine, b * (sine * sine))
        rest += weight * _small_arctangent(tangent)
        weight /= 2.0
    square = rest * rest
    turn_cosine = 1.0 - square / 2.0 * (1.0 - square / 12.0)
    turn_sine = rest * (1.0 - square / 6.0 * (1.0 - square / 20.0))
    cosine, sine = bisector[0], bisector[1]
    angle = (cosine * turn_cosine - sine * turn_sine, sine * turn_cosine + cosine * turn_sine)
    return a, angle, (one, sinh)


@inner
def nome_of(m: float, m1: float) -> float:
    """Return the nome q of m = 1 - m1 <= 1/2.  Source: DLMF 20.9.1 and 22.2.1; Hermite's series, to rounding."""
    modulus = math.sqrt(m1)
    half = m / (2.0 * (1.0 + modulus) * (1.0 + math.sqrt(modulus)) ** 2)
    fourth = half**4
    return half * (1.0 + fourth * (2.0 + fourth * (15.0 + fourth * 150.0)))


@inner
def hyperbolic(nome: float, decay: float, one_minus_decay: float) -> Harmonics:
    """Return the harmonics of x from decay = exp(-2 x), which is not below the nome."""
    growth = nome / decay if decay > 0.0 else 0.0
    up1, down1 = nome * growth, (nome * decay) ** 2
    up2, down2 = up1 * up1 * nome * nome, down1 * decay * nome**4
    up3 = up2 * growth * nome**5
    return Harmonics(
        (1.0 + decay, up1 + down1, up2 + down2, up3),
        (one_minus_decay, up1 - down1, up2 - down2, up3),
    )


@inner
def total(terms: Terms) -> float:
    """Return the sum of four terms."""
    return terms[0] + terms[1] + terms[2] + terms[3]


@inner
def alternating(terms: Terms) -> float:
    """Return the sum of four terms, the signs of every second one turned."""
    return terms[0] - terms[1] + terms[2] - terms[3]


@inner
def shifted(waves: Harmonics, angle: Pair) -> Pair:
    """Return the parts of theta1(angle + i x): sum (-1)^n sinh cos and sum (-1)^n cosh sin of the odd harmonics."""
    cosine, sine = angle
    double = 2.0 * (cosine - sine) * (cosine + sine)
    cosine3, sine3 = cosine * (double - 1.0), sine * (double + 1.0)
    cosine5, sine5 = double * cosine3 - cosine, double * sine3 - sine
    cosine7, sine7 = double * cosine5 - cosine3, double * sine5 - sine3
    cosh, sinh = waves
    return (
        alternating((sinh[0] * cosine, sinh[1] * cosine3, sinh[2] * cosine5, sinh[3] * cosine7)),
        alternating((cosh[0] * sine, cosh[1] * sine3, cosh[2] * sine5, cosh[3] * sine7)),
    )


@inner
def less(phase: Pair, other: Pair) -> Pair:
    """Return a complex number whose phase is the first's less the other's."""
    return (phase[0] * other[0] + phase[1] * other[1], phase[1] * other[0] - phase[0] * other[1])


@inner
def times_complex(a: Pair, b: Pair) -> Pair:
    """Return the product of two complex numbers."""
    return (a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0])


@inner
def power(a: Pair, n: float) -> Pair:
    """Return a complex number of length 1 to the power of a whole number, 1 where that is too large to be one."""
    found, square = (1.0, 0.0), a
    rest = np.int64(abs(n)) if abs(n) < 2.0**53 else 0
    while rest > 0:
        if rest & 1:
            found = times_complex(found, square)
        square, rest = times_complex(square, square), rest >> 1
    return found if n > 0.0 else (found[0], -found[1])


@inner
def half(phase: Pair) -> Pair:
    """Return a complex number whose phase is half of the other's, which is within a whole turn of 0."""
    length = math.sqrt(phase[0] * phase[0] + phase[1] * phase[1])
    if phase[0] < 0.0:
        return (abs(phase[1]), math.copysign(length - phase[0], phase[1]))
    return (phase[0] + length, phase[1])


@inner
def even_sums(nome: float, double: float) -> Pair:
    """Return theta3 and theta4 of an angle from twice the cosine of its double."""
    fourth = double * double - 2.0
    near, far = nome * double, nome**9 * (double * fourth - double)
    even = 1.0 + nome**4 * fourth
    return even + near + far, even - near - far
