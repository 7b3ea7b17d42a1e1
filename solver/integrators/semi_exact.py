"""Semi-exact steps: the angular momentum by Jacobi's functions, the angle about it by a quadrature.

L runs round axis 3, that of the least or the greatest moment, on Euler's curve

    L = (a1 cn u, a2 sn u, a3 dn u),   du/dt = sqrt(alpha),   alpha = g1 (g3 L2^2 + g2 L3^2) = beta / m,
                                                              beta = g3 (g2 L1^2 + g1 L2^2),

with g the absolute differences of the inverse moments.  What it is after a step follows by the addition theorem from
what it is, and from sn, cn and dn of sqrt(alpha) dt: no phase is ever found, and no root, for sn/sqrt(alpha), cn and dn
are series in alpha t^2 and beta t^2.  The body, seen from L, is the shortest turn of L onto axis 3 followed by one
about L by psi,

    dpsi/dt = (2E + |L L3|/I3) / (|L| + |L3|),

which is integrated by Lobatto's rule: the only error, and it falls as dt^8.

Source: Celledoni, Fasso, Safstrom & Zanna, "The exact computation of the free rigid body motion and its use in
splitting methods" (2008), which calls such methods semi-exact; DLMF 22.6.5-7, 22.8.1-3, 22.10.4.
"""

import math
from typing import NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from tumble.solver.body import by_moment
from tumble.solver.compilation import inner, kernel
from tumble.solver.four import Four, all_four, fused_four, minus_four, over_four, plus_four, times_four
from tumble.solver.fused import fused, fused_half_turn, fused_product
from tumble.solver.quaternion import Quaternion, steady_turn, stretch
from tumble.solver.spins import load, store
from tumble.solver.vectors import Vector, dot, scale, times

# Lobatto's nodes in [0, 1] but the first, which is 0, and the weights of all.
# Source: Abramowitz & Stegun, "Handbook of Mathematical Functions" (1964), table 25.6, n = 5.
NODES = ((1.0 - math.sqrt(3 / 7)) / 2.0, 0.5, (1.0 + math.sqrt(3 / 7)) / 2.0, 1.0)
WEIGHT_END, WEIGHT_BETWEEN, WEIGHT_MIDDLE = 1 / 20, 49 / 180, 16 / 45

# The series are summed at a 2^DOUBLINGS-th of the step, where alpha t^2 < LIMIT and seven terms do, and their times
# doubled: as often for a short step as for one that turns L by a right angle or three; more often for a longer one.
DOUBLINGS, LIMIT = 6, 1 / 64
# t, t^3, ..., t^13 at the nodes, and their derivatives.
POWERS = cast(tuple[Four, ...], tuple(tuple(node**k for node in NODES) for k in range(1, 14, 2)))
SLOPES = cast(tuple[Four, ...], tuple(tuple(k * node ** (k - 1) for node in NODES) for k in range(1, 14, 2)))

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
def _step(q: Quaternion, momentum: Vector, dt: float, g: Vector, inverse_moments: Vector) -> tuple[Quaternion, Vector]:
    """Return q and L after one step of dt [s], in right-handed axes in the order of their moments.

    g: the absolute differences of the inverse moments, times |dt|/2^DOUBLINGS.
    """
    swapped = momentum[2] * momentum[2] * g[0] < momentum[0] * momentum[0] * g[2]
    g1, g2, g3 = g_framed = (g[2], g[1], g[0]) if swapped else g
    l1, l2, l3 = start = _exchanged(swapped, momentum)
    speed = math.sqrt(dot(start, start))
    if speed == 0.0:
        return q, momentum
    above, below = fused(l2 * l2, g3, l3 * l3 * g2), fused(l1 * l1, g2, l2 * l2 * g1)
    functions = _functions(above * g1, below * g3)
    # D = 1 - m sn^2 u sn^2 v = cn^2 v + sn^2 v dn^2 u.
    cn = minus_four(functions.unit, functions.lack_cn)
    divisor = fused_four(cn, cn, times_four(all_four(g1 * g2 * (l3 * l3)), times_four(functions.sn, functions.sn)))
    slopes = scale(
        math.copysign(1.0, dt) * (-1.0 if swapped else 1.0), (-g1 * (l2 * l3), g2 * (l3 * l1), -g3 * (l1 * l2))
    )

    twice_energy = dot(momentum, times(inverse_moments, momentum))
    speed3 = speed * (inverse_moments[0] if swapped else inverse_moments[2])
    psi = dt * _mean_rate(start, functions, cn, divisor, slopes[2], speed, twice_energy, speed3)
    end = _gained(start, functions, divisor[3], slopes, g_framed)
    w, x, y, z = _turn(start, end, speed, psi)
    x, y, z = _exchanged(swapped, (x, y, z))
    return fused_product(q, (w, x, y, z)), _exchanged(swapped, end)


@inner
def _mean_rate(
    start: Vector,
    functions: Functions,
    cn: Four,
    divisor: Four,
    slope3: float,
    speed: float,
    twice_energy: float,
    speed3: float,
) -> float:
    """Return the mean of dpsi/dt over a step [rad/s]; speed: |L|; speed3: |L|/I3."""
    dn = minus_four(functions.unit, functions.lack_dn)
    # D times L3, at the nodes, on the side of axis 3 where it is.
    side = math.copysign(1.0, start[2])
    third = fused_four(
        all_four(side * start[2]),
        times_four(dn, functions.unit),
        times_four(all_four(side * slope3), times_four(functions.sn, cn)),
    )
    rates = over_four(
        fused_four(all_four(speed3), third, times_four(all_four(twice_energy), divisor)),
        fused_four(all_four(speed), divisor, third),
    )
    first = fused(speed3, side * start[2], twice_energy) / fused(side, start[2], speed)
    ends, between = first + rates[3], rates[0] + rates[2]
    return fused(WEIGHT_END, ends, fused(WEIGHT_BETWEEN, between, WEIGHT_MIDDLE * rates[1]))


@inner
def _gained(start: Vector, functions: Functions, divisor: float, slopes: Vector, g: Vector) -> Vector:
    """Return L at the end of a step, by what it gains; divisor: D there."""
    l1, l2, l3 = start
    sn, lack_cn, lack_dn, unit = (
        functions.sn[3],
        functions.lack_cn[3],
        functions.lack_dn[3],
        functions.unit[3],
    )
    per = 1.0 / divisor
    # D = 1 - m sn^2 sn^2, with what it lacks of 1; each gain is that of cn, cn dn or dn over D.
    lack = g[0] * g[2] * (l2 * l2) * (sn * sn)
    lack1, lack3 = fused(-unit, lack_cn, lack), fused(-unit, lack_dn, lack)
    lack2 = fused(lack_cn, lack_dn, lack) - unit * (lack_cn + lack_dn)
    return (
        fused(fused(l1, lack1, slopes[0] * (sn * (unit - lack_dn))), per, l1),
        fused(fused(l2, lack2, slopes[1] * (sn * unit)), per, l2),
        fused(fused(l3, lack3, slopes[2] * (sn * (unit - lack_cn))), per, l3),
    )


@inner
def _turn(start: Vector, end: Vector, speed: float, psi: float) -> Quaternion:
    """Return the turn of a step: from axis 3 onto L as it was, round L by psi [rad], and from L as it is onto axis 3.

    speed: |L|.  Axis 3 is taken on the side where L is.
    """
    side = math.copysign(1.0, start[2])
    before, after = fused(side, start[2], speed), fused(side, end[2], speed)
    cosine, sine = fused_half_turn(psi)
    a, b = side * end[1], -side * end[0]
    sine = side * sine
    w, x, y, z = cosine * after, fused(cosine, a, -(sine * b)), fused(cosine, b, sine * a), sine * after
    a, b = -side * start[1], side * start[0]
    return stretch(
        0.5 / (speed * math.sqrt(before * after)),
        (
            fused(before, w, fused(-a, x, -(b * y))),
            fused(before, x, fused(a, w, b * z)),
            fused(before, y, fused(-a, z, b * w)),
            fused(before, z, fused(a, y, -(b * x))),
        ),
    )


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
            inverses = (inverse_moments[axes[0]], inverse_moments[axes[1]], inverse_moments[axes[2]])
            for _ in range(n):
                q, momentum = _step(q, momentum, dt, g, inverses)
            _store_ordered(spin, axes, handed, q, momentum)
