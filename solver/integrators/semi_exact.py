"""Semi-exact steps: the angular momentum by Jacobi's functions, the angle about it by a quadrature.

L runs round axis 3, that of the least or the greatest moment, on Euler's curve

    L = (a1 cn u, a2 sn u, a3 dn u),   du/dt = sqrt(alpha),   alpha = g1 (g3 L2^2 + g2 L3^2) = beta / m,
                                                              beta = g3 (g2 L1^2 + g1 L2^2),

with g the absolute differences of the inverse moments.  What it is after a step follows by the addition theorem from
what it is, and from sn, cn and dn of sqrt(alpha) dt: no phase is ever found, and no root, for sn/sqrt(alpha), cn and dn
are series in alpha t^2 and beta t^2.  The body, seen from L, is the shortest turn of L onto axis 3 followed by one
about L by psi,

    dpsi/dt = |L|/I3 + (2E - L^2/I3) / (|L| + |L3|),

which is integrated by Lobatto's rule: the only error, and it falls as dt^8.

Source: Celledoni, Fasso, Safstrom & Zanna, "The exact computation of the free rigid body motion and its use in
splitting methods" (2008), which calls such methods semi-exact; DLMF 22.6.5-7, 22.8.1-3, 22.10.4.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tumble.solver.body import by_moment
from tumble.solver.compilation import inner, kernel
from tumble.solver.four import Four, all_four, fused_four, minus_four, over_four, plus_four, times_four
from tumble.solver.fused import fused, fused_half_turn, fused_product
from tumble.solver.quaternion import Quaternion, steady_turn, stretch
from tumble.solver.spins import load, store
from tumble.solver.vectors import Vector, scale, times

# Lobatto's nodes in [0, 1] but the first, which is 0, and the weights of all.
# Source: Abramowitz & Stegun, "Handbook of Mathematical Functions" (1964), table 25.6, n = 5.
NODES = ((1.0 - math.sqrt(3 / 7)) / 2.0, 0.5, (1.0 + math.sqrt(3 / 7)) / 2.0, 1.0)
WEIGHT_END, WEIGHT_BETWEEN, WEIGHT_MIDDLE = 1 / 20, 49 / 180, 16 / 45

# The series are summed at a 2^DOUBLINGS-th of the step, where alpha t^2 < LIMIT and seven terms do, and their times
# doubled: as often for a short step as for one that turns L by a right angle or three; more often for a longer one.
DOUBLINGS, LIMIT = 6, 1 / 64
# t, t^3, ..., t^13 at the nodes, and their derivatives.
POWERS = tuple(tuple(node**k for node in NODES) for k in range(1, 14, 2))
SLOPES = tuple(tuple(k * node ** (k - 1) for node in NODES) for k in range(1, 14, 2))

Axes = tuple[int, int, int]

ONE, TWO = (1.0, 1.0, 1.0, 1.0), (2.0, 2.0, 2.0, 2.0)


class Functions(NamedTuple):
    """Jacobi's functions at four times: sn/sqrt(alpha), 1 - cn, 1 - dn and 1, all times a factor, each time its own."""

    sn: Four
    lack_cn: Four
    lack_dn: Four
    unit: Four


@inner
def _coefficients(alpha: float, beta: float) -> tuple[float, ...]:
    """Return those of t^3, t^5, ... t^13 in the series of sn/sqrt(alpha).

    Source: DLMF 22.10.4, and its recurrence on, in the sum and the product of alpha and beta.
    """
    p, q = alpha + beta, alpha * beta
    p2, q2 = p * p, q * q
    return (
        p * (-1 / 6),
        fused(12.0, q, p2) * (1 / 120),
        p * fused(132.0, q, p2) * (-1 / 5040),
        fused(p2, fused(1224.0, q, p2), 3024.0 * q2) * (1 / 362880),
        p * fused(p2, fused(11064.0, q, p2), 132624.0 * q2) * (-1 / 39916800),
        fused(p2, fused(p2, fused(99636.0, q, p2), 4095792.0 * q2), 4390848.0 * q2 * q) * (1 / 6227020800),
    )


@inner
def _summed(powers: tuple[Four, ...], coefficients: tuple[float, ...]) -> Four:
    """Return the sum of the first power and of the coefficients times the others."""
    c3, c5, c7, c9, c11, c13 = coefficients
    low = fused_four(all_four(c3), powers[1], powers[0])
    middle = fused_four(all_four(c7), powers[3], times_four(all_four(c5), powers[2]))
    high = fused_four(
        all_four(c13), powers[6], fused_four(all_four(c11), powers[5], times_four(all_four(c9), powers[4]))
    )
    # The last coefficients come last.
    return plus_four(plus_four(low, middle), high)


@inner
def _doubled(half: Functions, alpha: Four, beta: Four) -> Functions:
    """Return the functions at twice the times.

    sn 2u = 2 sn cn dn / D, 1 - cn 2u = 2 sn^2 dn^2 / D, 1 - dn 2u = 2 m sn^2 cn^2 / D, D = cn^2 + sn^2 dn^2: carried as
    what they lack of 1, cn and dn lose no digit at small times.
    """
    cn, dn = minus_four(half.unit, half.lack_cn), minus_four(half.unit, half.lack_dn)
    sn2, cn2, dn2 = times_four(half.sn, half.sn), times_four(cn, cn), times_four(dn, dn)
    sn2_dn2 = times_four(times_four(alpha, sn2), dn2)
    return Functions(
        times_four(times_four(TWO, times_four(half.sn, cn)), times_four(dn, half.unit)),
        times_four(TWO, sn2_dn2),
        times_four(TWO, times_four(times_four(beta, sn2), cn2)),
        fused_four(cn2, times_four(half.unit, half.unit), sn2_dn2),
    )


@inner
def _functions(alpha: float, beta: float) -> Functions:
    """Return the functions at the nodes, alpha and beta in units of 2^DOUBLINGS over the step."""
    more = 0
    while LIMIT < alpha < math.inf:
        alpha, beta, more = alpha / 4.0, beta / 4.0, more + 1
    coefficients = _coefficients(alpha, beta)
    alphas, betas = all_four(alpha), all_four(beta)
    # The first doubling needs cn and dn only as squares and as their product, the derivative of sn.
    sn, cn_dn = _summed(POWERS, coefficients), _summed(SLOPES, coefficients)
    sn2 = times_four(sn, sn)
    alpha_sn2, beta_sn2 = times_four(alphas, sn2), times_four(betas, sn2)
    cn2, dn2 = minus_four(ONE, alpha_sn2), minus_four(ONE, beta_sn2)
    sn2_dn2 = times_four(alpha_sn2, dn2)
    found = Functions(
        times_four(times_four(TWO, sn), cn_dn),
        times_four(TWO, sn2_dn2),
        times_four(TWO, times_four(beta_sn2, cn2)),
        fused_four(ONE, sn2_dn2, cn2),
    )
    for _ in range(DOUBLINGS - 1):
        found = _doubled(found, alphas, betas)
    for _ in range(more):
        split = over_four(ONE, found.unit)
        found = Functions(
            times_four(split, found.sn), times_four(split, found.lack_cn), times_four(split, found.lack_dn), ONE
        )
        found = _doubled(found, alphas, betas)
    if more:
        found = Functions(times_four(all_four(0.5**more), found.sn), found.lack_cn, found.lack_dn, found.unit)
    return found


@inner
def _load_ordered(spin: NDArray[np.float64], axes: Axes, handed: float) -> tuple[Quaternion, Vector]:
    """Return q and L of a row in the axes of the least, the middle and the greatest moment; handed: the sign of one."""
    x, y, z = axes
    return (spin[0], spin[1 + x], handed * spin[1 + y], spin[1 + z]), (spin[4 + x], handed * spin[4 + y], spin[4 + z])


@inner
def _store_ordered(spin: NDArray[np.float64], axes: Axes, handed: float, q: Quaternion, momentum: Vector) -> None:
    """Write q and L, in those axes, into a row."""
    x, y, z = axes
    spin[0], spin[1 + x], spin[1 + y], spin[1 + z] = q[0], q[1], handed * q[2], q[3]
    spin[4 + x], spin[4 + y], spin[4 + z] = momentum[0], handed * momentum[1], momentum[2]


@inner
def _exchanged(swapped: bool, a: Vector) -> Vector:
    """Return a vector in axes half a turn about (1, 0, 1) away, or as it is."""
    return (a[2], -a[1], a[0]) if swapped else a


@inner
def _step(
    q: Quaternion, momentum: Vector, dt: float, g: Vector, inverse_least: float, inverse_greatest: float
) -> tuple[Quaternion, Vector]:
    """Return q and L after one step of dt [s], in right-handed axes in the order of their moments.

    g: the absolute differences of the inverse moments, times |dt|/2^DOUBLINGS; inverse_least, inverse_greatest: the
    inverse moments of the first and the third axis.
    """
    swapped = momentum[2] * momentum[2] * g[0] < momentum[0] * momentum[0] * g[2]
    l1, l2, l3 = _exchanged(swapped, momentum)
    sense = math.copysign(1.0, dt)
    g1, g2, g3, sense = (g[2], g[1], g[0], -sense) if swapped else (g[0], g[1], g[2], sense)
    square1, square2, square3 = l1 * l1, l2 * l2, l3 * l3
    square = square1 + square2 + square3
    if square == 0.0:
        return q, momentum
    speed = math.sqrt(square)
    above, below = fused(square2, g3, square3 * g2), fused(square1, g2, square2 * g1)
    found = _functions(above * g1, below * g3)
    sn, unit = found.sn, found.unit
    cn, dn = minus_four(unit, found.lack_cn), minus_four(unit, found.lack_dn)

    # D = 1 - m sn^2 u sn^2 v = cn^2 v + sn^2 v dn^2 u, and D times L3, at the nodes.
    divisor = fused_four(cn, cn, times_four(all_four(g1 * g2 * square3), times_four(sn, sn)))
    slope3 = -sense * g3 * (l1 * l2)
    third = fused_four(all_four(l3), times_four(dn, unit), times_four(all_four(slope3), times_four(sn, cn)))
    side = math.copysign(1.0, l3)
    shares = over_four(divisor, fused_four(all_four(speed), divisor, times_four(all_four(side), third)))
    upright = fused(side, l3, speed)
    mean = fused(
        WEIGHT_END, 1.0 / upright + shares[3], fused(WEIGHT_BETWEEN, shares[0] + shares[2], WEIGHT_MIDDLE * shares[1])
    )
    inverse3 = inverse_least if swapped else inverse_greatest
    # 2E - L^2/I3 of sums without cancellation, times dt.
    off = sense * fused(square1, g2, square2 * g1) * 2.0**DOUBLINGS
    psi = side * fused(dt * speed, inverse3, off * mean)

    # L after the step, by what it gains.
    s, lack_cn, lack_dn, one, c, d = sn[3], found.lack_cn[3], found.lack_dn[3], unit[3], cn[3], dn[3]
    per = 1.0 / divisor[3]
    both = g1 * g3 * square2 * (s * s)
    lack = fused(lack_cn, lack_dn, both) - one * (lack_cn + lack_dn)
    gain1 = fused(l1, fused(-one, lack_cn, both), -sense * g1 * (l2 * l3) * (s * d))
    gain2 = fused(l2, lack, sense * g2 * (l3 * l1) * (s * one))
    gain3 = fused(l3, fused(-one, lack_dn, both), slope3 * (s * c))
    m1, m2, m3 = fused(gain1, per, l1), fused(gain2, per, l2), fused(gain3, per, l3)

    # Back from axis 3 onto L as it was, round L by psi, and from L as it is onto axis 3.
    cosine, sine = fused_half_turn(psi)
    upright_after = fused(side, m3, speed)
    a, b = side * m2, -side * m1
    w, x, y, z = (
        cosine * upright_after,
        fused(cosine, a, -(sine * b)),
        fused(cosine, b, sine * a),
        sine * upright_after,
    )
    a, b = -side * l2, side * l1
    turn = (
        fused(upright, w, fused(-a, x, -(b * y))),
        fused(upright, x, fused(a, w, b * z)),
        fused(upright, y, fused(-a, z, b * w)),
        fused(upright, z, fused(a, y, -(b * x))),
    )
    w, x, y, z = stretch(0.5 / (speed * math.sqrt(upright * upright_after)), turn)
    x, y, z = _exchanged(swapped, (x, y, z))
    return fused_product(q, (w, x, y, z)), _exchanged(swapped, (m1, m2, m3))


@kernel
def semi_exact(
    spins: NDArray[np.float64], n: int, dt: float, inverse_moments: Vector, gyroscopic: Vector | None
) -> None:
    """Take n steps of the closed form of L, and of the attitude by a quadrature of the angle about L.

    spins: q, then L in body axes, (N, 7).
    L is exact at any step, so that L in the world and the energy are kept; a product of unit quaternions keeps its
    length but for rounding, so nothing is normalised.
    Source: as of the file; Lobatto's rule with five nodes; order 8.
    """
    axes = by_moment(inverse_moments)
    handed = 1.0 if (axes[1] - axes[0]) % 3 == 1 else -1.0
    for spin in spins:
        if gyroscopic is None:
            q, momentum = load(spin)
            store(spin, steady_turn(q, scale(dt / 2.0, times(inverse_moments, momentum)), n), momentum)
        else:
            q, momentum = _load_ordered(spin, axes, handed)
            part = abs(dt) / 2.0**DOUBLINGS
            g = (part * abs(gyroscopic[axes[0]]), part * abs(gyroscopic[axes[1]]), part * abs(gyroscopic[axes[2]]))
            least, greatest = inverse_moments[axes[0]], inverse_moments[axes[2]]
            for _ in range(n):
                q, momentum = _step(q, momentum, dt, g, least, greatest)
            _store_ordered(spin, axes, handed, q, momentum)
