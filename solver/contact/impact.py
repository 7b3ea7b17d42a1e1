"""One impact of one point: Newton's restitution along the normal, Coulomb's friction along the plane.

The impulse P along the normal grows from zero.  The slip s of the point, of length r along the unit vector c, obeys

    ds/dP = d - mu M c,     u_n = u_n0 + K_nn P - mu K_nt . (integral of c over P),

and the impact is over where u_n = -e u_n0.  In T with dP = r dT direction and length come apart: c' = k(c) times c turned
by a right angle, r' = h(c) r, P' = r.  The direction goes to one that keeps itself, along which all is a straight line:
Routh's case.  Sources: Routh, "Dynamics of a System of Rigid Bodies", Elementary Part (1905), arts. 181-198; Keller,
J. Appl. Mech. 53 (1986) 1; Bhatt & Koechling, J. Appl. Mech. 62 (1995) 893.
"""

import math

import numpy as np
from numpy.typing import NDArray

from tumble.solver.compilation import inner
from tumble.solver.contact.ground import Symmetric
from tumble.solver.dop853 import ERROR_3, ERROR_5, STAGES, WEIGHTS
from tumble.solver.integrators.adaptive import combined
from tumble.solver.vectors import Vector

Array = NDArray[np.float64]
Pair = tuple[float, float]

# Of the slip that the impact begins with: what a step may be off, and what counts as none.
TOLERANCE, NO_SLIP = 1e-16, 1e-15
# Of the rates of the flow: turns slower than this are none; below the second what they still do is known to rounding.
STEADY, NEARLY_STEADY = 1e-15, 1e-7
FIRST_STEP, LONGEST_STEP, MOST_STEPS, MOST_HALVINGS = 0.2, 8.0, 400, 80


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
def _rates(K: Symmetric, friction: float, unit: float, c: Pair) -> Pair:
    """Return h and k: how fast the slip grows and turns, per T times unit."""
    along = (K[4] - friction * (K[0] * c[0] + K[3] * c[1])) * unit
    across = (K[5] - friction * (K[3] * c[0] + K[1] * c[1])) * unit
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
def _step(
    state: tuple[float, float, float, float], length: float, K: Symmetric, friction: float, unit: float, slopes: Array
) -> tuple[float, float, float, float]:
    """Return c, r and P a step of T on, and leave the stages' slopes in slopes, (12, 4)."""
    for stage in range(13):
        x, y, r, P = state
        for before in range(min(stage, 12)):
            weight = length * (STAGES[stage, before] if stage < 12 else WEIGHTS[before])
            x += weight * slopes[before, 0]
            y += weight * slopes[before, 1]
            r += weight * slopes[before, 2]
            P += weight * slopes[before, 3]
        if stage == 12:
            break
        h, k = _rates(K, friction, unit, (x, y))
        slopes[stage, 0], slopes[stage, 1], slopes[stage, 2], slopes[stage, 3] = -k * y, k * x, h * r, r
    size = math.sqrt(x * x + y * y)
    return x / size, y / size, r, P


@inner
def _off(slopes: Array, length: float) -> float:
    """Return about how far a step was off."""
    fifth, third = 0.0, 0.0
    for part in range(4):
        five, three = 0.0, 0.0
        for stage in range(12):
            five += ERROR_5[stage] * slopes[stage, part]
            three += ERROR_3[stage] * slopes[stage, part]
        fifth += five * five
        third += three * three
    return combined(fifth, third, length)


@inner
def _slipping(K: Symmetric, u: Vector, slip: float, target: float, friction: float) -> Vector:
    """Return the velocity after an impact that begins with a slip.

    r is counted in the first slip, P in slip times unit, so that all numbers of the flow are about 1.
    """
    unit = 1.0 / max(K[2], friction * K[0], friction * K[1], abs(K[4]), abs(K[5]))
    state = (u[0] / slip, u[1] / slip, 1.0, 0.0)
    slopes = np.empty((12, 4))
    length, per_P = FIRST_STEP, slip * unit
    for _ in range(MOST_STEPS):
        c, r, P = (state[0], state[1]), state[2] * slip, state[3] * per_P
        h, k = _rates(K, friction, unit, c)
        if abs(k) <= STEADY:
            return _straight(K, u, c, r, P, h / unit, target, friction)
        if r <= NO_SLIP * slip:
            return _from_stick(K, _rising(K, u, (0.0, 0.0), P), target, friction)
        if abs(k) <= NEARLY_STEADY and h < -0.01:
            ended, P_end = _tail(K, friction, unit, c, h, k, state[2])
            rising = _rising(K, u, (0.0, 0.0), P + P_end * per_P)
            if ended and rising < target:
                return _from_stick(K, rising, target, friction)
        then = _step(state, length, K, friction, unit, slopes)
        off = _off(slopes, length) / TOLERANCE
        if off <= 1.0:
            s = (then[0] * then[2] * slip, then[1] * then[2] * slip)
            if _rising(K, u, s, then[3] * per_P) >= target:
                return _met(K, u, state, length, slip, per_P, target, friction, unit, slopes)
            state = then
        length = min(LONGEST_STEP, length * min(6.0, max(0.2, 0.9 * off**-0.125 if off > 0.0 else 6.0)))
    return (math.nan, math.nan, math.nan)


@inner
def _tail(
    K: Symmetric, friction: float, unit: float, c: Pair, h: float, k: float, r: float
) -> tuple[bool, float]:
    """Return whether the slip ends along nearly this direction, and by what P, to the first order of what it turns.

    With z the angle to the direction that keeps itself, z' = b z and r' = (h0 + g z) r.
    """
    bend = 1e-4
    left, right = (c[0] - bend * c[1], c[1] + bend * c[0]), (c[0] + bend * c[1], c[1] - bend * c[0])
    (h_left, k_left), (h_right, k_right) = (
        _rates(K, friction, unit, left),
        _rates(K, friction, unit, right),
    )
    b, g = (k_left - k_right) / (2.0 * bend), (h_left - h_right) / (2.0 * bend)
    if b >= -0.01:
        return False, 0.0
    z = k / b
    h0 = h - g * z
    return h0 < 0.0, r * (-1.0 / h0 + g * z / b * (1.0 / h0 - 1.0 / (h0 + b)))


@inner
def _met(
    K: Symmetric,
    u: Vector,
    state: tuple[float, float, float, float],
    length: float,
    slip: float,
    per_P: float,
    target: float,
    friction: float,
    unit: float,
    slopes: Array,
) -> Vector:
    """Return the velocity where u_n is the target, within a step from state; by Newton's steps and halving."""
    low, high, T = 0.0, length, length
    s = (0.0, 0.0)
    for _ in range(MOST_HALVINGS):
        then = _step(state, T, K, friction, unit, slopes)
        r, c = then[2], (then[0], then[1])
        s = (c[0] * r * slip, c[1] * r * slip)
        beyond = _rising(K, u, s, then[3] * per_P) - target
        low, high = (T, high) if beyond < 0.0 else (low, T)
        slope = (K[2] - friction * (K[4] * c[0] + K[5] * c[1])) * r * per_P
        change = beyond / slope if slope > 0.0 else math.inf
        moved = T - change
        if not low <= moved <= high:
            moved = 0.5 * (low + high)
        if abs(moved - T) <= 1e-16 * length:
            break
        T = moved
    return (s[0], s[1], target)
