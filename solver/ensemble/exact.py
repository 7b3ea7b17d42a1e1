"""The closed form of free rotation for many throws: theta series with no function in them that a lane has not got.

The motion is that of `solver.integrators.exact`, whose docstring tells it, in the nome q of m alone: up to 0.35, which
is all but the throws within a hundredth of the separatrix, its first form does, with six terms where that one has four.
What needs a logarithm there is had here from the arithmetic-geometric mean and square roots.  Throws beyond, symmetric
bodies, and a body at rest come out as nan and go through the scalar kernel.  `throw` is what time does not change,
`flown` the rest: `solver.ensemble.poses` calls it alone.

Source: as there; Gauss's mean with its angles: Bulirsch, "Numerical calculation of elliptic integrals and elliptic
functions" (1965).
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from solver import quaternion
from solver.ensemble.blocks import LANES, share_out
from solver.ensemble.lanes import lane, lanes_kernel, product, scale, widest_vectors
from solver.integrators.exact import exact as one_by_one
from solver.quaternion import Quaternion
from solver.vectors import Vector

Pair = tuple[float, float]

LARGEST_NOME = 0.35
# |L1|^2 and |L2|^2 over |L|^2, weighted: below this the spin is steady, whatever its phase.
LEAST_BELOW = 1e-280
# A throw's additions and multiplications, a root or a quotient counted as ten.
FLOPS = 1500
# 2 pi in three parts, of 33 bits but for the last: whole turns up to 2^20 are taken off without rounding.
TURN_HIGH, TURN_MIDDLE, TURN_LOW = 6.2831853069365025, 2.4308402025215864e-10, 8.089064995183803e-21
# Adding and taking off 3 * 2^51 rounds to whole numbers.
WHOLE = 6755399441055744.0

norm_squared = lane(quaternion.norm_squared)
stretch = lane(quaternion.stretch)


class Throw(NamedTuple):
    """What of a throw does not depend on time, in the axes of its frame, whose third L runs round.

    least: whether that is the axis of the least moment; signs: of the frame's axes among the body's;
    steady: whether L keeps to axis 3; speed: |L|;
    before: q, then the turn of axis 3 onto L at the start; before_squared: the square of the latter's length, nan
    beyond LARGEST_NOME;
    rate: of the angle pi u/(2 K) [rad/s]; angle: where that began; half_turning: A/2 [rad/s]; began: a number whose
    phase was p/2;
    cosh, sinh: the waves of the shift; odd_weights, even_weights: of the thetas' harmonics;
    meridian: what theta2 and theta1 need to be as L1 and L2 to each other; amplitudes: what they and theta3 need to be
    L/|L| times theta4.
    """

    least: bool
    signs: Vector
    steady: bool
    speed: float
    before: Quaternion
    before_squared: float
    rate: float
    half_turning: float
    angle: Pair
    began: Pair
    cosh: tuple[float, ...]
    sinh: tuple[float, ...]
    meridian: Pair
    amplitudes: Vector
    odd_weights: tuple[float, ...]
    even_weights: tuple[float, ...]


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
def shift_waves(decay: float, lack: float, growth: float, nome: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
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
def odd_waves(angle: Pair) -> tuple[tuple[float, ...], tuple[float, ...]]:
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
def sum_of(a: tuple[float, ...], b: tuple[float, ...]) -> float:
    """Return the scalar product of six terms."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] + a[4] * b[4] + a[5] * b[5]


@lane
def alternating_sum_of(a: tuple[float, ...], b: tuple[float, ...]) -> float:
    """Return the scalar product of six terms, the signs of every second one turned."""
    return a[0] * b[0] - a[1] * b[1] + a[2] * b[2] - a[3] * b[3] + a[4] * b[4] - a[5] * b[5]


@lane
def half_phase(
    cosh: tuple[float, ...], sinh: tuple[float, ...], cosines: tuple[float, ...], sines: tuple[float, ...], seen: Pair
) -> Pair:
    """Return a complex number whose phase is p/2: p that of theta1 at the complex angle, less that of L1 + i L2."""
    phase = times_conjugate((alternating_sum_of(sinh, cosines), alternating_sum_of(cosh, sines)), seen)
    return (phase[0] + math.sqrt(phase[0] * phase[0] + phase[1] * phase[1]), phase[1])


@lane
def framed(least: bool, signs: Vector, a: Vector) -> Vector:
    """Return a vector of the order of the moments in the axes of its throw's frame."""
    return (signs[0] * (a[2] if least else a[0]), signs[1] * a[1], signs[2] * (a[0] if least else a[2]))


@lane
def placed(least: bool, signs: Vector, a: Vector) -> Vector:
    """Return a vector of the frame in the order of the moments."""
    first, third = signs[0] * a[0], signs[2] * a[2]
    return (third if least else first, signs[1] * a[1], first if least else third)


@lane
def throw(q: Quaternion, momentum: Vector, inverse_middle: float, g: Vector, handed: float) -> Throw:
    """Return what a throw keeps: q and L in the axes of the least, the middle and the greatest moment.

    g: the absolute differences of the inverse moments; handed: -1 where those axes are left-handed, else 1.
    """
    speed = math.sqrt(momentum[0] * momentum[0] + momentum[1] * momentum[1] + momentum[2] * momentum[2])
    direct = scale(1.0 / speed, momentum)
    # L runs round axis 3; where that is the axis of the least moment, half a turn about (1, 0, 1) exchanges the two,
    # and half a turn about axis 1 brings L to the side of axis 3.
    least = direct[2] * direct[2] * g[0] < direct[0] * direct[0] * g[2]
    sense = -1.0 if least else 1.0
    side = -1.0 if (direct[0] if least else direct[2]) < 0.0 else 1.0
    signs = (1.0, handed * sense * side, side)
    l1, l2, l3 = framed(least, signs, direct)
    g1, g2, g3 = (g[2] if least else g[0]), g[1], (g[0] if least else g[2])

    above = l2 * l2 * g3 + l3 * l3 * g2
    below = l1 * l1 * g2 + l2 * l2 * g1
    beyond = l3 * l3 * g1 - l1 * l1 * g3
    per_above = 1.0 / (above * g1)
    m, m1 = below * g3 * per_above, beyond * g2 * per_above
    ratios, lacks, (root3, lack_root3), (nome, root_modulus) = levels(m, m1)
    n2 = nome * nome
    n4 = n2 * n2
    n6, n8 = n4 * n2, n4 * n4
    n12, n16, n20 = n6 * n6, n8 * n8, n8 * n8 * n4
    root_g1, root_g2 = math.sqrt(g1), math.sqrt(g2)

    steady = below < LEAST_BELOW
    root_below = math.sqrt(below)
    per_root_below = 1.0 / root_below
    amplitude = (
        1.0 if steady else l1 * root_g2 * per_root_below,
        0.0 if steady else l2 * root_g1 * per_root_below,
    )
    angle = phase_angle(amplitude, ratios, root3, n8)

    far = m * g1 * g1 > g3 * g3
    per_sum = 1.0 / (g3 + (m if far else 1.0) * g1)
    sn_squared = per_sum * (g3 if far else g1)
    cn_squared = per_sum * (m * g1 if far else g3)
    sn = math.sqrt(sn_squared)
    x2, decay, lack = decay_of_shift(sn, cn_squared / (1.0 + sn), ratios, lacks, root3, lack_root3, n8)
    growth = nome * x2
    lack = 1.0 - growth if far else lack
    swapped = growth if far else decay
    growth = decay if far else growth
    cosh, sinh = shift_waves(swapped, lack, growth, nome)
    sinh_slope = sinh[0] + 3.0 * sinh[1] + 5.0 * sinh[2] + 7.0 * sinh[3] + 9.0 * sinh[4] + 11.0 * sinh[5]
    cosh_sum = cosh[0] + cosh[1] + cosh[2] + cosh[3] + cosh[4] + cosh[5]
    null2 = 1.0 + n2 + n6 + n12 + n20 + n20 * n8 * n2
    null3 = 1.0 + 2.0 * (nome + n4 + n8 * nome + n16 + n16 * n8 * nome)
    root_above = math.sqrt(above)
    split = 1.0 / (null3 * null3 * cosh_sum)
    rate = sense * speed * root_above * root_g1 * cosh_sum * split
    pull = sinh_slope * null3 * null3 * split
    cosines, sines = odd_waves(angle)
    began = half_phase(cosh, sinh, cosines, sines, (root_g1 * amplitude[0], root_g2 * amplitude[1]))

    per_null = 1.0 / (null2 * root_g1 * root_g2)
    meridian = (root_g1 * root_modulus, root_g2)
    across, upward = root_below * null3 * per_null, root_above * root_g1 * null2 * root_modulus * per_null
    onto_axis3 = (1.0 + l3, -l2, l1, 0.0)
    squared = norm_squared(onto_axis3) if nome < LARGEST_NOME else math.nan
    x, y, z = framed(least, signs, (q[1], q[2], q[3]))
    return Throw(
        least=least,
        signs=signs,
        steady=steady,
        speed=speed,
        before=product((q[0], x, y, z), onto_axis3),
        before_squared=squared,
        rate=rate,
        half_turning=(speed * inverse_middle - rate * pull) * 0.5,
        angle=angle,
        began=began,
        cosh=cosh,
        sinh=sinh,
        meridian=meridian,
        amplitudes=(across * meridian[0], across * meridian[1], upward),
        odd_weights=(1.0, n2, n6, n12, n20, n20 * n8 * n2),
        even_weights=(2.0 * nome, 2.0 * n4, 2.0 * n8 * nome, 2.0 * n16, 2.0 * n16 * n8 * nome),
    )


@lane
def flown(thrown: Throw, t: float) -> tuple[Quaternion, Vector]:
    """Return q and L after t [s], in the axes that `throw` had them in; nan beyond LARGEST_NOME."""
    angle = turned(thrown.angle, direction(thrown.rate * t))
    cosines, sines = odd_waves(angle)
    c2 = (angle[0] - angle[1]) * (angle[0] + angle[1])
    double = 2.0 * c2
    c4 = double * c2 - 1.0
    c6 = double * c4 - c2
    c8 = double * c6 - c4
    c10 = double * c8 - c6
    w2, w4, w6, w8, w10 = thrown.even_weights
    even = 1.0 + (w4 * c4 + w8 * c8)
    odd = w2 * c2 + (w6 * c6 + w10 * c10)
    theta1 = alternating_sum_of(thrown.odd_weights, sines)
    theta2 = sum_of(thrown.odd_weights, cosines)
    theta4 = even - odd
    a1, a2, a3 = thrown.amplitudes
    # L/|L| times theta4: one quotient then does for it and for the length of q.
    e1, e2, e3 = a1 * theta2, a2 * theta1, a3 * (even + odd)

    along, aside = thrown.meridian
    now = half_phase(thrown.cosh, thrown.sinh, cosines, sines, (along * theta2, aside * theta1))
    spin = turned(direction(thrown.half_turning * t), times_conjugate(now, thrown.began))
    # The spin about L, then the turn of axis 3 onto L: each is nought in two of its four numbers or in one.
    upright, tilt = theta4 + e3, turned(spin, (e2, -e1))
    after = (spin[0] * upright, tilt[0], tilt[1], spin[1] * upright)
    length = math.sqrt(thrown.before_squared * norm_squared(after))
    split = 1.0 / (length * theta4)
    w, x, y, z = stretch(split * theta4, product(thrown.before, after))
    x, y, z = placed(thrown.least, thrown.signs, (x, y, z))
    momentum = scale(thrown.speed * split * length, placed(thrown.least, thrown.signs, (e1, e2, e3)))
    return (w, x, y, z), momentum


@lanes_kernel
def _exact(
    first: int,
    last: int,
    spins: NDArray[np.float64],
    n: int,
    dt: float,
    axes: tuple[int, int, int],
    handed: float,
    g: Vector,
    inverse_moments: Vector,
    gyroscopic: Vector,
) -> None:
    widest_vectors()
    block = np.empty(7 * LANES)
    t, inverse_middle = n * dt, inverse_moments[axes[1]]
    x, y, z = axes
    for begin in range(first, last, LANES):
        for i in range(LANES):
            row = min(begin + i, last - 1)
            block[i], block[4 * LANES + i] = spins[row, 7], spins[row, 11 + x]
            block[LANES + i], block[5 * LANES + i] = spins[row, 8 + x], spins[row, 11 + y]
            block[2 * LANES + i], block[6 * LANES + i] = spins[row, 8 + y], spins[row, 11 + z]
            block[3 * LANES + i] = spins[row, 8 + z]
        for i in range(LANES):
            q = (block[i], block[LANES + i], block[2 * LANES + i], block[3 * LANES + i])
            momentum = (block[4 * LANES + i], block[5 * LANES + i], block[6 * LANES + i])
            q, momentum = flown(throw(q, momentum, inverse_middle, g, handed), t)
            block[i], block[LANES + i], block[2 * LANES + i], block[3 * LANES + i] = q
            block[4 * LANES + i], block[5 * LANES + i], block[6 * LANES + i] = momentum
        for i in range(min(LANES, last - begin)):
            row = begin + i
            spins[row, 0], spins[row, 4 + x] = block[i], block[4 * LANES + i]
            spins[row, 1 + x], spins[row, 4 + y] = block[LANES + i], block[5 * LANES + i]
            spins[row, 1 + y], spins[row, 4 + z] = block[2 * LANES + i], block[6 * LANES + i]
            spins[row, 1 + z] = block[3 * LANES + i]
            if math.isnan(block[i]):
                one_by_one(spins[row : row + 1], n, dt, inverse_moments, gyroscopic)


@lanes_kernel
def _one_by_one(
    first: int,
    last: int,
    spins: NDArray[np.float64],
    n: int,
    dt: float,
    inverse_moments: Vector,
    gyroscopic: Vector | None,
) -> None:
    one_by_one(spins[first:last], n, dt, inverse_moments, gyroscopic)


def ordered(inverse_moments: Vector, gyroscopic: Vector) -> tuple[tuple[int, int, int], float, Vector]:
    """Return the axes of the least, the middle and the greatest moment, and handed and g of `throw` in that order."""
    least, middle, greatest = sorted(range(3), key=lambda axis: -inverse_moments[axis])
    handed = 1.0 if (middle - least) % 3 == 1 else -1.0
    return (
        (least, middle, greatest),
        handed,
        (abs(gyroscopic[least]), abs(gyroscopic[middle]), abs(gyroscopic[greatest])),
    )


def exact(spins: NDArray[np.float64], n: int, dt: float, inverse_moments: Vector, gyroscopic: Vector | None) -> None:
    """Turn for n dt, at once, from where the rows were when the count of n began.

    spins: q, then L in body axes, then both at the start of the count, (N, 14) or wider, C order, altered in place; as
    `solver.integrators.exact` has it.
    """
    if gyroscopic is None or 0.0 in gyroscopic:
        share_out(_one_by_one, len(spins), FLOPS, spins, n, dt, inverse_moments, gyroscopic)
        return
    axes, handed, g = ordered(inverse_moments, gyroscopic)
    share_out(_exact, len(spins), FLOPS, spins, n, dt, axes, handed, g, inverse_moments, gyroscopic)
