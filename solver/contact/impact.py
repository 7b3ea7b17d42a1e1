"""One impact of one point: Newton's restitution along the normal, Coulomb's friction along the plane.

The impulse P along the normal grows from zero.  The slip s of the point, of length r along the unit vector c, obeys

    ds/dP = d - mu M c,     u_n = u_n0 + K_nn P - mu K_nt . (integral of c over P),

and the impact is over where u_n = -e u_n0.  In T with dP = r dT direction and length come apart: c' is k(c) times c
turned by a right angle, r' = h(c) r, P' = r.  The direction goes to one that keeps itself, along which all is a
straight line: Routh's case.  Sources: Routh, "Dynamics of a System of Rigid Bodies", Elementary Part (1905), arts.
181-198; Keller, J. Appl. Mech. 53 (1986) 1; Bhatt & Koechling, J. Appl. Mech. 62 (1995) 893.
"""

import math

import numpy as np
from numpy.typing import NDArray

from tumble.solver.compilation import inner
from tumble.solver.contact.ground import Symmetric
from tumble.solver.dop853 import ERROR_3, ERROR_5, STAGES, WEIGHTS
from tumble.solver.fused import fused_stretch
from tumble.solver.integrators.adaptive import combined
from tumble.solver.quaternion import norm_squared
from tumble.solver.vectors import Vector

Array = NDArray[np.float64]
Pair = tuple[float, float]
# c, r and P.
Flow = tuple[float, float, float, float]
# d and mu M over the unit of P: d_x, d_y, M_xx, M_yy, M_xy; and what an error of P weighs, by the rise that it makes.
Rates = tuple[float, float, float, float, float, float]

A = STAGES
NOTHING = (0.0, 0.0, 0.0, 0.0)

# Of the slip that the impact begins with: what a step may seem to be off, a tenth of it in truth, and what is no slip.
TOLERANCE, NO_SLIP = 1e-14, 1e-15
# Of the rates of the flow: turns slower than this are none.
STEADY = 1e-15
# So short a way in T is a line, to rounding.
LINEAR = 1e-8
# How far from the direction that keeps itself a series about it is tried [rad], its terms, and steps towards it.
NEAR, TERMS, MOST_NEWTON = 0.3, 32, 12
# Of the turn rate where the series did not settle: where it is tried again.
TRY_AGAIN = 0.6
FIRST_STEP, LONGEST_STEP, MOST_STEPS, MOST_HALVINGS = 0.08, 8.0, 400, 80


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
        if abs(step) <= 1e-16 * rate:
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
    d_x, d_y, xx, yy, xy, _ = rates
    along, across = d_x - xx * c[0] - xy * c[1], d_y - xy * c[0] - yy * c[1]
    return c[0] * along + c[1] * across, c[0] * across - c[1] * along


@inner
def _rising(K: Symmetric, u: Vector, s: Pair, P: float) -> float:
    """Return u_n where the slip is s after P: friction is what has made s of it."""
    left = _solved(K, (u[0] + K[4] * P - s[0], u[1] + K[5] * P - s[1]))
    return u[2] + K[2] * P - K[4] * left[0] - K[5] * left[1]


@inner
def _straight(
    K: Symmetric, u: Vector, c: Pair, r: float, P: float, rate: float, target: float, friction: float
) -> Vector:
    """Return the velocity after, from a slip along a direction that keeps itself; rate: dr/dP."""
    rising = _rising(K, u, (c[0] * r, c[1] * r), P)
    climb = K[2] - friction * (K[4] * c[0] + K[5] * c[1])
    needed = (target - rising) / climb if climb > 0.0 else math.inf
    if rate >= 0.0 or needed * -rate <= r:
        return (c[0] * (r + rate * needed), c[1] * (r + rate * needed), target)
    return _from_stick(K, rising + climb * (r / -rate), target, friction)


@inner
def _slope(state: Flow, rates: Rates) -> Flow:
    """Return dc/dT, dr/dT and dP/dT."""
    x, y, r, _ = state
    h, k = _rates(rates, (x, y))
    return -k * y, k * x, h * r, r


@inner
def _step(state: Flow, t: float, rates: Rates) -> tuple[Flow, float]:
    """Return c, r and P a step t of T on, and about how far that is off: all twelve stages in registers."""
    k_0 = _slope(state, rates)
    k_1 = _slope(fused_stretch(t * A[1, 0], k_0, state), rates)
    k_2 = _slope(fused_stretch(t * A[2, 1], k_1, fused_stretch(t * A[2, 0], k_0, state)), rates)
    k_3 = _slope(fused_stretch(t * A[3, 2], k_2, fused_stretch(t * A[3, 0], k_0, state)), rates)
    k_4 = _slope(
        fused_stretch(t * A[4, 3], k_3, fused_stretch(t * A[4, 2], k_2, fused_stretch(t * A[4, 0], k_0, state))), rates
    )
    k_5 = _slope(
        fused_stretch(t * A[5, 4], k_4, fused_stretch(t * A[5, 3], k_3, fused_stretch(t * A[5, 0], k_0, state))), rates
    )
    at = fused_stretch(t * A[6, 4], k_4, fused_stretch(t * A[6, 3], k_3, fused_stretch(t * A[6, 0], k_0, state)))
    at = fused_stretch(t * A[6, 5], k_5, at)
    k_6 = _slope(at, rates)
    at = fused_stretch(t * A[7, 4], k_4, fused_stretch(t * A[7, 3], k_3, fused_stretch(t * A[7, 0], k_0, state)))
    at = fused_stretch(t * A[7, 6], k_6, fused_stretch(t * A[7, 5], k_5, at))
    k_7 = _slope(at, rates)
    at = fused_stretch(t * A[8, 4], k_4, fused_stretch(t * A[8, 3], k_3, fused_stretch(t * A[8, 0], k_0, state)))
    at = fused_stretch(t * A[8, 7], k_7, fused_stretch(t * A[8, 6], k_6, fused_stretch(t * A[8, 5], k_5, at)))
    k_8 = _slope(at, rates)
    at = fused_stretch(t * A[9, 4], k_4, fused_stretch(t * A[9, 3], k_3, fused_stretch(t * A[9, 0], k_0, state)))
    at = fused_stretch(t * A[9, 7], k_7, fused_stretch(t * A[9, 6], k_6, fused_stretch(t * A[9, 5], k_5, at)))
    at = fused_stretch(t * A[9, 8], k_8, at)
    k_9 = _slope(at, rates)
    at = fused_stretch(t * A[10, 4], k_4, fused_stretch(t * A[10, 3], k_3, fused_stretch(t * A[10, 0], k_0, state)))
    at = fused_stretch(t * A[10, 7], k_7, fused_stretch(t * A[10, 6], k_6, fused_stretch(t * A[10, 5], k_5, at)))
    at = fused_stretch(t * A[10, 9], k_9, fused_stretch(t * A[10, 8], k_8, at))
    k_10 = _slope(at, rates)
    at = fused_stretch(t * A[11, 4], k_4, fused_stretch(t * A[11, 3], k_3, fused_stretch(t * A[11, 0], k_0, state)))
    at = fused_stretch(t * A[11, 7], k_7, fused_stretch(t * A[11, 6], k_6, fused_stretch(t * A[11, 5], k_5, at)))
    at = fused_stretch(t * A[11, 10], k_10, fused_stretch(t * A[11, 9], k_9, fused_stretch(t * A[11, 8], k_8, at)))
    k_11 = _slope(at, rates)
    then = fused_stretch(
        t * WEIGHTS[6], k_6, fused_stretch(t * WEIGHTS[5], k_5, fused_stretch(t * WEIGHTS[0], k_0, state))
    )
    then = fused_stretch(
        t * WEIGHTS[9], k_9, fused_stretch(t * WEIGHTS[8], k_8, fused_stretch(t * WEIGHTS[7], k_7, then))
    )
    then = fused_stretch(t * WEIGHTS[11], k_11, fused_stretch(t * WEIGHTS[10], k_10, then))
    fifth = fused_stretch(ERROR_5[6], k_6, fused_stretch(ERROR_5[5], k_5, fused_stretch(ERROR_5[0], k_0, NOTHING)))
    fifth = fused_stretch(ERROR_5[9], k_9, fused_stretch(ERROR_5[8], k_8, fused_stretch(ERROR_5[7], k_7, fifth)))
    fifth = fused_stretch(ERROR_5[11], k_11, fused_stretch(ERROR_5[10], k_10, fifth))
    third = fused_stretch(ERROR_3[6], k_6, fused_stretch(ERROR_3[5], k_5, fused_stretch(ERROR_3[0], k_0, NOTHING)))
    third = fused_stretch(ERROR_3[9], k_9, fused_stretch(ERROR_3[8], k_8, fused_stretch(ERROR_3[7], k_7, third)))
    third = fused_stretch(ERROR_3[11], k_11, fused_stretch(ERROR_3[10], k_10, third))
    x, y, r, P = then
    size = math.sqrt(x * x + y * y)
    weight = rates[5]
    fifth, third = (*fifth[:3], weight * fifth[3]), (*third[:3], weight * third[3])
    return (x / size, y / size, r, P), combined(norm_squared(fifth), norm_squared(third), t)


@inner
def _slipping(K: Symmetric, u: Vector, slip: float, target: float, friction: float) -> Vector:
    """Return the velocity after an impact that begins with a slip.

    r is counted in the first slip, P in slip times unit, so that all numbers of the flow are about 1.
    """
    unit = 1.0 / max(friction * K[0], friction * K[1], abs(K[4]), abs(K[5]))
    push = friction * unit
    rates = (K[4] * unit, K[5] * unit, K[0] * push, K[1] * push, K[3] * push, max(1.0, K[2] * unit))
    state = (u[0] / slip, u[1] / slip, 1.0, 0.0)
    length, per_P = FIRST_STEP, slip * unit
    k_series, h_series, q = np.empty(TERMS + 1), np.empty(TERMS + 1), np.empty(TERMS + 1)
    tried = NEAR
    for _ in range(MOST_STEPS):
        c, r, P = (state[0], state[1]), state[2] * slip, state[3] * per_P
        h, k = _rates(rates, c)
        if abs(k) <= STEADY:
            return _straight(K, u, c, r, P, h / unit, target, friction)
        if r <= NO_SLIP * slip:
            return _from_stick(K, _rising(K, u, (0.0, 0.0), P), target, friction)
        if h < 0.0 and abs(k) <= tried:
            left = _to_stick(rates, c, state[2], k_series, h_series, q)
            if math.isfinite(left):
                rising = _rising(K, u, (0.0, 0.0), P + left * per_P)
                if rising < target:
                    return _from_stick(K, rising, target, friction)
                tried = 0.0
            tried = TRY_AGAIN * min(tried, abs(k))
        then, off = _step(state, length, rates)
        off /= TOLERANCE
        if off <= 1.0:
            s = (then[0] * then[2] * slip, then[1] * then[2] * slip)
            if _rising(K, u, s, then[3] * per_P) >= target:
                return _met(K, u, state, length, slip, per_P, target, friction, rates)
            state = then
        length = min(LONGEST_STEP, length * min(6.0, max(0.2, 0.9 * off**-0.125 if off > 0.0 else 6.0)))
    return (math.nan, math.nan, math.nan)


@inner
def _to_stick(rates: Rates, c: Pair, r: float, k_series: Array, h_series: Array, q: Array) -> float:
    """Return the P until a slip of length r along c ends, nan where it is too far from the direction that keeps itself.

    With z the angle to that direction, z' = k(z) and r' = h(z) r, so P' = r makes P = const + r q(z) with

        k q' + h q = 1,     q = sum of q_n z^n,     k, h: sums of sines and cosines of z and 2 z,

    and nothing is left of r at z = 0.  k_series, h_series, q: (TERMS + 1,), for the coefficients.
    """
    d_x, d_y, xx, yy, xy, _ = rates
    mean, half = 0.5 * (xx + yy), 0.5 * (xx - yy)
    first = math.atan2(c[1], c[0])
    angle = first
    along, across, along_2, across_2 = 0.0, 0.0, 0.0, 0.0
    for _ in range(MOST_NEWTON):
        cos, sin = math.cos(angle), math.sin(angle)
        cos_2, sin_2 = cos * cos - sin * sin, 2.0 * cos * sin
        along, across = d_x * cos + d_y * sin, d_y * cos - d_x * sin
        along_2, across_2 = half * cos_2 + xy * sin_2, half * sin_2 - xy * cos_2
        slope = 2.0 * along_2 - along
        if slope >= 0.0:
            return math.nan
        change = (across + across_2) / slope
        angle -= change
        if abs(change) <= 1e-9:
            break
    z = first - angle
    if abs(z) > NEAR or along - mean - along_2 >= 0.0:
        return math.nan
    # Derivatives of sines and cosines go round in four; those of 2 z double each time.
    single, double, factor = (across, along), (across_2, along_2), 1.0
    for n in range(TERMS + 1):
        k_series[n] = factor * (single[0] + double[0])
        h_series[n] = factor * (single[1] - double[1])
        single, double = (-single[1], single[0]), (2.0 * double[1], -2.0 * double[0])
        factor /= n + 1.0
    h_series[0] -= mean
    total, power = 0.0, 1.0
    for n in range(TERMS):
        left = 1.0 if n == 0 else 0.0
        for j in range(1, n + 1):
            left -= h_series[j] * q[n - j] + k_series[j + 1] * (n - j) * q[n - j]
        q[n] = left / (h_series[0] + n * k_series[1])
        term = q[n] * power
        total += term
        power *= z
        if n > 1 and abs(term) <= 1e-17 * abs(total):
            return -r * total
    return math.nan


@inner
def _met(
    K: Symmetric,
    u: Vector,
    state: Flow,
    length: float,
    slip: float,
    per_P: float,
    target: float,
    friction: float,
    rates: Rates,
) -> Vector:
    """Return the velocity where u_n is the target, within a step from state; by Newton's steps and halving."""
    low, high, T = 0.0, length, length
    s = (0.0, 0.0)
    for _ in range(MOST_HALVINGS):
        then, _ = _step(state, T, rates)
        r, c = then[2], (then[0], then[1])
        s = (c[0] * r * slip, c[1] * r * slip)
        beyond = _rising(K, u, s, then[3] * per_P) - target
        low, high = (T, high) if beyond < 0.0 else (low, T)
        slope = (K[2] - friction * (K[4] * c[0] + K[5] * c[1])) * r * per_P
        change = beyond / slope if slope > 0.0 else math.inf
        moved = T - change
        if not low <= moved <= high:
            moved = 0.5 * (low + high)
        if abs(moved - T) <= LINEAR:
            h, k = _rates(rates, c)
            grown = 1.0 + (moved - T) * h
            turned = (moved - T) * k
            s = (grown * s[0] - turned * s[1], grown * s[1] + turned * s[0])
            break
        T = moved
    return (s[0], s[1], target)
