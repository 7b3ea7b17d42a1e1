"""One impact of one point: Newton's restitution along the normal, Coulomb's friction along the plane.

The impulse P along the normal grows from zero.  The slip s of the point, of length r, and its velocity u_n along the
normal obey

    ds/dP = d - mu M s/r,     du_n/dP = K_nn - mu K_nt . s/r,

and the impact is over where u_n = -e u_n(0).  In T with dP = r dT all is linear but r, and r^2 = s . s: Taylor series
in T, whose recurrence is one convolution.  The direction of s goes to one that keeps itself, along which all is a
straight line: Routh's case.  Sources: Routh, "Dynamics of a System of Rigid Bodies", Elementary Part (1905), arts.
181-198; Keller, J. Appl. Mech. 53 (1986) 1; Bhatt & Koechling, J. Appl. Mech. 62 (1995) 893; step length: Jorba & Zou,
Experiment. Math. 14 (2005) 99.
"""

import math

import numpy as np
from numpy.typing import NDArray

from tumble.solver.compilation import inner
from tumble.solver.contact.ground import Symmetric
from tumble.solver.fused import fused
from tumble.solver.vectors import Vector

Array = NDArray[np.float64]
Pair = tuple[float, float]
# d and mu M over the unit of P: d_x, d_y, M_xx, M_yy, M_xy.
Rates = tuple[float, float, float, float, float]

# Terms of the series in T; of a slip, what the last one may be, a tenth of which is left out.
ORDER, LAST_TERM = 22, 2.0**-47
# Of the speed of approach and of the first slip: what is no slip.
NO_SLIP = 1e-15
# Of the rates of the flow: turns slower than this are none.
STEADY = 1e-15
# How near to a root Newton's next step ends, of the interval: its error squared is rounding.
NEARLY = 1e-9
# How far from the direction that keeps itself a series about it is tried [rad], its terms, and steps towards it.
NEAR, TERMS, MOST_NEWTON = 0.3, 32, 12
# Of the turn rate where the series did not settle: where it is tried again.
TRY_AGAIN = 0.6
LONGEST_STEP, MOST_STEPS, MOST_HALVINGS = 8.0, 400, 80


@inner
def velocity_after(K: Symmetric, u: Vector, restitution: float, friction: float) -> Vector:
    """Return the velocity of the point after the impact [m/s]; K: of `response`; u: before, u[2] < 0."""
    target = -restitution * u[2]
    if friction == 0.0:
        gained = (target - u[2]) / K[2]
        return (u[0] + K[4] * gained, u[1] + K[5] * gained, target)
    slip = math.sqrt(u[0] * u[0] + u[1] * u[1])
    if slip <= NO_SLIP * -u[2]:
        return _from_stick(K, u[2], target, friction)
    return _slipping(K, u, slip, target, friction)


@inner
def _solved(K: Symmetric, a: Pair) -> Pair:
    """Return M^-1 a for M the block of K along the plane."""
    determinant = K[0] * K[1] - K[3] * K[3]
    return ((K[1] * a[0] - K[3] * a[1]) / determinant, (K[0] * a[1] - K[3] * a[0]) / determinant)


@inner
def sticking_friction(K: Symmetric, d: Pair) -> Pair:
    """Return the friction per P that keeps the point from slipping: -M^-1 d."""
    held = _solved(K, d)
    return (-held[0], -held[1])


@inner
def outgoing(K: Symmetric, d: Pair, friction: float) -> tuple[Pair, float]:
    """Return the direction in which a slip begins that friction cannot hold, and its rate l > 0: (mu M + l) c = d.

    In the axes of M it is (d1 / (mu a + l))^2 + (d2 / (mu b + l))^2 = 1, whose left side falls to 0 as l grows.
    """
    angle = 0.5 * math.atan2(2.0 * K[3], K[0] - K[1])
    cos, sin = math.cos(angle), math.sin(angle)
    a = friction * (K[0] * cos * cos + 2.0 * K[3] * cos * sin + K[1] * sin * sin)
    b = friction * (K[0] * sin * sin - 2.0 * K[3] * cos * sin + K[1] * cos * cos)
    first, second = cos * d[0] + sin * d[1], cos * d[1] - sin * d[0]
    rate = 0.0
    for _ in range(60):
        along, across = first / (a + rate), second / (b + rate)
        square = along * along + across * across
        slope = along * along / (a + rate) + across * across / (b + rate)
        step = (math.sqrt(square) - 1.0) * square / slope
        rate += step
        if abs(step) <= NEARLY * rate:
            break
    along, across = first / (a + rate), second / (b + rate)
    size = math.sqrt(along * along + across * across)
    return ((cos * along - sin * across) / size, (sin * along + cos * across) / size), rate


@inner
def _from_stick(K: Symmetric, rising: float, target: float, friction: float) -> Vector:
    """Return the velocity after, from where the point has no slip and rises at that rate."""
    d = (K[4], K[5])
    held = sticking_friction(K, d)
    if held[0] * held[0] + held[1] * held[1] <= friction * friction:
        return (0.0, 0.0, target)
    c, rate = outgoing(K, d, friction)
    slip = rate * (target - rising) / (K[2] - friction * (K[4] * c[0] + K[5] * c[1]))
    return (c[0] * slip, c[1] * slip, target)


@inner
def _rates(rates: Rates, c: Pair) -> Pair:
    """Return h and k: how fast the slip grows and turns, per T."""
    d_x, d_y, xx, yy, xy = rates
    along, across = d_x - xx * c[0] - xy * c[1], d_y - xy * c[0] - yy * c[1]
    return c[0] * along + c[1] * across, c[0] * across - c[1] * along


@inner
def _straight(K: Symmetric, c: Pair, r: float, rising: float, rate: float, target: float, friction: float) -> Vector:
    """Return the velocity after, from a slip along a direction that keeps itself; rate: dr/dP."""
    climb = K[2] - friction * (K[4] * c[0] + K[5] * c[1])
    needed = (target - rising) / climb if climb > 0.0 else math.inf
    if rate >= 0.0 or needed * -rate <= r:
        return (c[0] * (r + rate * needed), c[1] * (r + rate * needed), target)
    return _from_stick(K, rising + climb * (r / -rate), target, friction)


@inner
def _slipping(K: Symmetric, u: Vector, slip: float, target: float, friction: float) -> Vector:
    """Return the velocity after an impact that begins with a slip.

    Velocities are counted in the first slip, P in slip times unit, so that all numbers of the flow are about 1.
    """
    unit = 1.0 / max(friction * K[0], friction * K[1], abs(K[4]), abs(K[5]))
    push = friction * unit
    rates = (K[4] * unit, K[5] * unit, K[0] * push, K[1] * push, K[3] * push)
    climbs = (K[2] * unit, K[4] * push, K[5] * push)
    x, y, rising, needed = u[0] / slip, u[1] / slip, u[2] / slip, target / slip
    series = np.empty((6, TERMS + 1))
    tried = NEAR
    for _ in range(MOST_STEPS):
        r = math.sqrt(x * x + y * y)
        if r <= NO_SLIP:
            return _from_stick(K, rising * slip, target, friction)
        c = (x / r, y / r)
        h, k = _rates(rates, c)
        if abs(k) <= STEADY:
            return _straight(K, c, r * slip, rising * slip, h / unit, target, friction)
        if h < 0.0 and abs(k) <= tried:
            left = _to_stick(rates, c, r, series) * unit
            if math.isfinite(left):
                held = _solved(K, (x + K[4] * left, y + K[5] * left))
                at_end = rising + K[2] * left - K[4] * held[0] - K[5] * held[1]
                if at_end < needed:
                    return _from_stick(K, at_end * slip, target, friction)
                tried = 0.0
            tried = TRY_AGAIN * min(tried, abs(k))
        length = _grow(series, x, y, r, rising - needed, rates, climbs)
        begins = series[4, 0]
        x, y, below, climb = _values(series, length)
        if begins > 0.0 > climb:
            # It rises to a greatest value, which may be beyond the target.
            length = _zero(series[4], length)
            x, y, below, _ = _values(series, length)
        if below >= 0.0:
            x, y, _, _ = _values(series, _zero(series[3], length))
            return (x * slip, y * slip, target)
        rising = needed + below
    return (math.nan, math.nan, math.nan)


@inner
def _grow(series: Array, x: float, y: float, r: float, below: float, rates: Rates, climbs: Vector) -> float:
    """Write the Taylor series in T of s, r, u_n less its target, and du_n/dT, and return how far they hold."""
    d_x, d_y, xx, yy, xy = rates
    first, second, speed, rising, climb, pairs = series
    pairs[: ORDER + 1] = 0.0
    over_r = 1.0 / r
    along, across = x * over_r, y * over_r
    first[0], second[0], speed[0], rising[0] = x, y, r, below
    for n in range(1, ORDER + 1):
        part = 1.0 / n
        climb[n - 1] = climbs[0] * r - climbs[1] * x - climbs[2] * y
        rising[n] = part * climb[n - 1]
        x, y = part * fused(d_x, r, -xx * x - xy * y), part * fused(d_y, r, -xy * x - yy * y)
        r = fused(along, x, fused(across, y, over_r * pairs[n]))
        first[n], second[n], speed[n] = x, y, r
        # Of later terms of s . s - r r, the products with this one: so they are many at once.
        for j in range(1, min(n - 1, ORDER - n) + 1):
            pairs[n + j] = fused(-r, speed[j], fused(x, first[j], fused(y, second[j], pairs[n + j])))
        if 2 * n <= ORDER:
            pairs[2 * n] += 0.5 * (x * x + y * y - r * r)
    climb[ORDER] = 0.0
    last = max(abs(first[ORDER]), abs(second[ORDER]), abs(speed[ORDER]))
    before = max(abs(first[ORDER - 1]), abs(second[ORDER - 1]), abs(speed[ORDER - 1]))
    return min(LONGEST_STEP, (LAST_TERM / (over_r * max(last, before))) ** (1.0 / ORDER))


@inner
def _values(series: Array, t: float) -> tuple[float, float, float, float]:
    """Return s, u_n less its target, and du_n/dT, a way t of T on."""
    x, y, below, climb = series[0, ORDER], series[1, ORDER], series[3, ORDER], series[4, ORDER]
    for n in range(ORDER - 1, -1, -1):
        x, y = x * t + series[0, n], y * t + series[1, n]
        below, climb = below * t + series[3, n], climb * t + series[4, n]
    return x, y, below, climb


@inner
def _zero(terms: Array, length: float) -> float:
    """Return where a polynomial changes its sign between 0 and length: by Newton's steps and halving."""
    low, high, t = 0.0, length, length
    for _ in range(MOST_HALVINGS):
        value, slope = terms[ORDER], 0.0
        for n in range(ORDER - 1, -1, -1):
            slope = slope * t + value
            value = value * t + terms[n]
        low, high = (t, high) if (value < 0.0) == (terms[0] < 0.0) else (low, t)
        moved = t - value / slope if slope != 0.0 else math.inf
        if not low <= moved <= high:
            moved = 0.5 * (low + high)
        change, t = abs(moved - t), moved
        if change <= NEARLY * length:
            break
    return t


@inner
def _to_stick(rates: Rates, c: Pair, r: float, series: Array) -> float:
    """Return the P until a slip of length r along c ends, nan where it is too far from the direction that keeps itself.

    With z the angle to that direction, z' = k(z) and r' = h(z) r, so P' = r makes P = const + r q(z) with

        k q' + h q = 1,     q = sum of q_n z^n,     k, h: sums of sines and cosines of z and 2 z,

    and nothing is left of r at z = 0.  series: (6, TERMS + 1), three of them for the coefficients.
    """
    d_x, d_y, xx, yy, xy = rates
    mean, half = 0.5 * (xx + yy), 0.5 * (xx - yy)
    cos, sin = c
    along, across, along_2, across_2, is_near = 0.0, 0.0, 0.0, 0.0, False
    for _ in range(MOST_NEWTON):
        cos_2, sin_2 = cos * cos - sin * sin, 2.0 * cos * sin
        along, across = d_x * cos + d_y * sin, d_y * cos - d_x * sin
        along_2, across_2 = half * cos_2 + xy * sin_2, half * sin_2 - xy * cos_2
        slope = 2.0 * along_2 - along
        if slope >= 0.0:
            return math.nan
        if is_near:
            break
        change = (across + across_2) / slope
        size = math.sqrt(1.0 + change * change)
        cos, sin = (cos + change * sin) / size, (sin - change * cos) / size
        is_near = abs(change) <= NEARLY
    z = math.atan2(cos * c[1] - sin * c[0], cos * c[0] + sin * c[1])
    if abs(z) > NEAR or along - mean - along_2 >= 0.0:
        return math.nan
    k_series, h_series, q, _, _, _ = series
    # Derivatives of sines and cosines go round in four; those of 2 z double each time.
    single, double, factor = (across, along), (across_2, along_2), 1.0
    for n in range(TERMS + 1):
        k_series[n] = factor * (single[0] + double[0])
        h_series[n] = factor * (single[1] - double[1])
        single, double = (-single[1], single[0]), (2.0 * double[1], -2.0 * double[0])
        factor /= n + 1.0
    h_series[0] -= mean
    total, power, term = 0.0, 1.0, math.inf
    for n in range(TERMS):
        left = 1.0 if n == 0 else 0.0
        for j in range(1, n + 1):
            left -= h_series[j] * q[n - j] + k_series[j + 1] * (n - j) * q[n - j]
        q[n] = left / (h_series[0] + n * k_series[1])
        before, term = term, q[n] * power
        total += term
        power *= z
        # One term may be small by itself: every second one is nothing where the motion has a mirror.
        if abs(before) + abs(term) <= 2.0**-56 * abs(total):
            return -r * total
    return math.nan
