"""The closed form of free rotation for many throws: theta series with no function in them that a lane has not got.

The motion is that of `tumble.solver.integrators.exact`, whose docstring tells it, in the nome q of m alone: up to 0.35,
which is all but the throws within a hundredth of the separatrix, its first form does, with six terms where that one has
four.
Throws beyond, symmetric bodies, and a body at rest come out as nan and go through the scalar kernel.  `throw` is what
time does not change, `flown` the rest: `tumble.solver.ensemble.poses` calls it alone.  Sources: as there.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tumble.solver import quaternion
from tumble.solver.ensemble.blocks import LANES, load_block, order_of, share_out, store_block
from tumble.solver.ensemble.frames import frame_of, framed, ordered, placed
from tumble.solver.ensemble.lanes import lane, lanes_kernel, product, scale, widest_vectors
from tumble.solver.ensemble.theta import (
    Pair,
    Terms,
    alternating_sum_of,
    decay_of_shift,
    direction,
    half_phase,
    levels,
    odd_waves,
    phase_angle,
    shift_waves,
    sum_of,
    times_conjugate,
    turned,
)
from tumble.solver.integrators.exact import exact as one_by_one
from tumble.solver.quaternion import Quaternion
from tumble.solver.vectors import Vector

LARGEST_NOME = 0.35
# |L1|^2 and |L2|^2 over |L|^2, weighted: below this the spin is steady, whatever its phase.
LEAST_BELOW = 1e-280
# A throw's additions and multiplications, a root or a quotient counted as ten.
FLOPS = 1500

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
    cosh: Terms
    sinh: Terms
    meridian: Pair
    amplitudes: Vector
    odd_weights: Terms
    even_weights: Terms


@lane
def shift_of(
    g1: float, g3: float, m: float, nome: float, ratios: Vector, lacks: Vector, root3: float, lack_root3: float
) -> tuple[Terms, Terms]:
    """Return `shift_waves` of x = pi v/(2 K): at u = i v, where sn^2(v, k') = g1/(g1 + g3), L would lie along axis 3.

    Beyond v = K'/2 they are had from K' - v, where sn^2 = g3/(g3 + m g1): there exp(-2 x) and nome exp(2 x) are the
    other's.
    """
    far = m * g1 * g1 > g3 * g3
    per_sum = 1.0 / (g3 + (m if far else 1.0) * g1)
    sn_squared = per_sum * (g3 if far else g1)
    cn_squared = per_sum * (m * g1 if far else g3)
    sn = math.sqrt(sn_squared)
    nome2 = nome * nome
    nome4 = nome2 * nome2
    x2, decay, lack = decay_of_shift(sn, cn_squared / (1.0 + sn), ratios, lacks, root3, lack_root3, nome4 * nome4)
    growth = nome * x2
    lack = 1.0 - growth if far else lack
    swapped = growth if far else decay
    growth = decay if far else growth
    return shift_waves(swapped, lack, growth, nome)


@lane
def throw(q: Quaternion, momentum: Vector, inverse_middle: float, g: Vector, handedness: float) -> Throw:
    """Return what a throw keeps: q and L in the axes of the least, the middle and the greatest moment.

    g: the absolute differences of the inverse moments; handed: -1 where those axes are left-handed, else 1.
    """
    speed = math.sqrt(momentum[0] * momentum[0] + momentum[1] * momentum[1] + momentum[2] * momentum[2])
    direct = scale(1.0 / speed, momentum)
    least, signs = frame_of(direct, g, handedness)
    l1, l2, l3 = framed(least, signs, direct)
    g1, g2, g3 = (g[2] if least else g[0]), g[1], (g[0] if least else g[2])

    # L/|L| = (a1 cn u, a2 sn u, a3 dn u) with a1^2 = below/g2, a2^2 = below/g1, a3^2 = above/g2,
    # m = below g3/(above g1) and m1 = 1 - m = beyond g2/(above g1).
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

    # (cn, sn) at the start, and its angle pi u/(2 K).
    steady = below < LEAST_BELOW
    root_below = math.sqrt(below)
    per_root_below = 1.0 / root_below
    amplitude = (
        1.0 if steady else l1 * root_g2 * per_root_below,
        0.0 if steady else l2 * root_g1 * per_root_below,
    )
    angle = phase_angle(amplitude, ratios, root3, n8)

    cosh, sinh = shift_of(g1, g3, m, nome, ratios, lacks, root3, lack_root3)
    sinh_slope = sinh[0] + 3.0 * sinh[1] + 5.0 * sinh[2] + 7.0 * sinh[3] + 9.0 * sinh[4] + 11.0 * sinh[5]
    cosh_sum = cosh[0] + cosh[1] + cosh[2] + cosh[3] + cosh[4] + cosh[5]
    null2 = 1.0 + n2 + n6 + n12 + n20 + n20 * n8 * n2
    null3 = 1.0 + 2.0 * (nome + n4 + n8 * nome + n16 + n16 * n8 * nome)
    # pi/(2 K) = 1/theta3(0)^2, so the angle grows at |L| sqrt(above g1)/theta3(0)^2; and A = |L|/I2 - that rate times
    # the slope of log theta1 at i x, which is sinh_slope/cosh_sum.
    root_above = math.sqrt(above)
    split = 1.0 / (null3 * null3 * cosh_sum)
    rate = (-speed if least else speed) * root_above * root_g1 * cosh_sum * split
    pull = sinh_slope * null3 * null3 * split
    cosines, sines = odd_waves(angle)
    began = half_phase(cosh, sinh, cosines, sines, (root_g1 * amplitude[0], root_g2 * amplitude[1]))

    # cn = sqrt(k') theta3(0)/theta2(0) theta2/theta4, sn = theta3(0)/theta2(0) theta1/theta4,
    # dn = sqrt(k') theta3/theta4.
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
def angles(thrown: Throw, t: float) -> tuple[Pair, Pair]:
    """Return the angle pi u/(2 K) and half the steady angle about L, A t/2, after t [s]."""
    return turned(thrown.angle, direction(thrown.rate * t)), direction(thrown.half_turning * t)


@lane
def seen(thrown: Throw, angle: Pair) -> tuple[Vector, float, Pair]:
    """Return L/|L| times theta4, theta4, and a number whose phase is p/2, at an angle pi u/(2 K)."""
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
    a1, a2, a3 = thrown.amplitudes
    along, aside = thrown.meridian
    now = half_phase(thrown.cosh, thrown.sinh, cosines, sines, (along * theta2, aside * theta1))
    # One quotient by theta4 then does for L and for the length of q.
    return (a1 * theta2, a2 * theta1, a3 * (even + odd)), even - odd, now


@lane
def pose(thrown: Throw, steady: Pair, along: Vector, theta4: float, now: Pair) -> tuple[Quaternion, Vector]:
    """Return q and L from what `angles` and `seen` return, in the axes of the frame but for its signs."""
    e1, e2, e3 = along
    spin = turned(steady, times_conjugate(now, thrown.began))
    # The spin about L, then the turn of axis 3 onto L: each is nought in two of its four numbers or in one.
    upright, tilt = theta4 + e3, turned(spin, (e2, -e1))
    after = (spin[0] * upright, tilt[0], tilt[1], spin[1] * upright)
    length = math.sqrt(thrown.before_squared * norm_squared(after))
    split = 1.0 / (length * theta4)
    q = stretch(split * theta4, product(thrown.before, after))
    return q, scale(thrown.speed * split * length, along)


@lane
def advanced(thrown: Throw, t: float) -> tuple[Quaternion, Vector]:
    """Return q and L after t [s], in the axes that `throw` had them in; nan beyond LARGEST_NOME."""
    angle, steady = angles(thrown, t)
    along, theta4, now = seen(thrown, angle)
    (w, x, y, z), momentum = pose(thrown, steady, along, theta4, now)
    x, y, z = placed(thrown.least, thrown.signs, (x, y, z))
    return (w, x, y, z), placed(thrown.least, thrown.signs, momentum)


@lanes_kernel
def _exact(
    first: int,
    last: int,
    spins: NDArray[np.float64],
    n: int,
    dt: float,
    inverse_moments: Vector,
    gyroscopic: Vector,
) -> None:
    widest_vectors()
    axes, handedness, g = ordered(inverse_moments, gyroscopic)
    block, order = np.empty(7 * LANES), order_of(axes)
    t, inverse_middle = n * dt, inverse_moments[axes[1]]
    for begin in range(first, last, LANES):
        load_block(spins, 7, order, begin, last, block)
        for i in range(LANES):
            q = (block[i], block[LANES + i], block[2 * LANES + i], block[3 * LANES + i])
            momentum = (block[4 * LANES + i], block[5 * LANES + i], block[6 * LANES + i])
            q, momentum = advanced(throw(q, momentum, inverse_middle, g, handedness), t)
            block[i], block[LANES + i], block[2 * LANES + i], block[3 * LANES + i] = q
            block[4 * LANES + i], block[5 * LANES + i], block[6 * LANES + i] = momentum
        store_block(spins, order, begin, last, block)
        for i in range(min(LANES, last - begin)):
            if math.isnan(block[i]):
                one_by_one(spins[begin + i : begin + i + 1], n, dt, inverse_moments, gyroscopic)


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


def exact(spins: NDArray[np.float64], n: int, dt: float, inverse_moments: Vector, gyroscopic: Vector | None) -> None:
    """Turn for n dt, at once, from where the rows were when the count of n began.

    spins: q, then L in body axes, then both at the start of the count, (N, 14) or wider, C order, altered in place; as
    `tumble.solver.integrators.exact` has it.
    """
    kernel = _one_by_one if gyroscopic is None or 0.0 in gyroscopic else _exact
    share_out(kernel, len(spins), FLOPS, spins, n, dt, inverse_moments, gyroscopic)
