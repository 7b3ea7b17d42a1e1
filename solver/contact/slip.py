"""Slip on an incline in closed form: s' = g - m s/|s|, where friction is the same in all directions.

With p the angle from g to s and u = tan(p/2), r = |s| is C u^(k-1) (1 + u^2) / 2, k = m/|g|, and the time is
dt = -r dp / (|g| sin p): time, slip and path are sums of powers of u (the hodograph).  Here u = u0 exp(y), and c, s are
cos(p0/2), sin(p0/2), so that nothing is lost where the slip is with gravity or against it.  Source: MacMillan,
"Statics and the Dynamics of a Particle" (1927), on a particle on a rough inclined plane.
"""

import math
from typing import NamedTuple

from tumble.solver.compilation import inner

Pair = tuple[float, float]
MOST_HALVINGS = 200
# exp of it is nothing beside 1.
NOTHING = -44.0


class Slip(NamedTuple):
    """A slip from t = 0: r [m/s]; half-angle's cos and sin; pull |g| and hold m [m/s2]; unit vector along g, and at a

    right angle to it, to the side of the slip.
    """

    r: float
    cos: float
    sin: float
    pull: float
    hold: float
    along: Pair
    across: Pair


@inner
def slip_from(s: Pair, g: Pair, hold: float) -> Slip:
    """Return the slip that starts as s [m/s], g [m/s2] not zero."""
    pull, r = math.hypot(g[0], g[1]), math.hypot(s[0], s[1])
    along = (g[0] / pull, g[1] / pull)
    x, y = s[0] * along[0] + s[1] * along[1], s[1] * along[0] - s[0] * along[1]
    side = math.copysign(1.0, y)
    half = 0.5 * math.atan2(abs(y), x)
    return Slip(r, math.cos(half), math.sin(half), pull, hold, along, (-side * along[1], side * along[0]))


@inner
def _fall(rate: float, y: float) -> float:
    """Return (1 - exp(rate y)) / rate."""
    return -y if rate == 0.0 else -math.expm1(rate * y) / rate


@inner
def ending(slip: Slip) -> float:
    """Return when the slip is zero [s], inf where it never is."""
    if slip.hold <= slip.pull and slip.cos > 0.0:
        return math.inf
    left = slip.sin * slip.sin / (slip.hold + slip.pull)
    if slip.cos > 0.0:
        left += slip.cos * slip.cos / (slip.hold - slip.pull)
    return slip.r * left


@inner
def time_at(slip: Slip, y: float) -> float:
    """Return t [s] of y."""
    k, cc, ss = slip.hold / slip.pull, slip.cos * slip.cos, slip.sin * slip.sin
    # Differences of hold and pull, not of their ratio and 1.
    less, more = (slip.hold - slip.pull) / slip.pull, k + 1.0
    return slip.r / slip.pull * ((cc * _fall(less, y) if cc > 0.0 else 0.0) + ss * _fall(more, y))


@inner
def velocity(slip: Slip, y: float) -> Pair:
    """Return the slip [m/s] along and across gravity."""
    less, k = (slip.hold - slip.pull) / slip.pull, slip.hold / slip.pull
    fallen = slip.r * math.exp(less * y)
    turned = math.exp(y)
    c, s = slip.cos, slip.sin * turned
    if c == 0.0:
        return -slip.r * slip.sin * slip.sin * math.exp((k + 1.0) * y), 0.0
    return fallen * (c * c - s * s), 2.0 * fallen * s * c


@inner
def path(slip: Slip, y: float) -> Pair:
    """Return the integral of the slip over time [m], along and across gravity."""
    less, k = (slip.hold - slip.pull) / slip.pull, slip.hold / slip.pull
    cc, ss = slip.cos * slip.cos, slip.sin * slip.sin
    size = slip.r * slip.r / slip.pull
    with_it = cc * cc * _fall(2.0 * less, y) if cc > 0.0 else 0.0
    x = size * (with_it - ss * ss * _fall(2.0 * k + 2.0, y))
    side = cc * _fall(2.0 * k - 1.0, y) + ss * _fall(2.0 * k + 1.0, y)
    return x, 2.0 * size * slip.sin * slip.cos * side if cc > 0.0 else 0.0


@inner
def y_at(slip: Slip, t: float) -> float:
    """Return the y <= 0 of an instant [s] before the end, by Newton's steps within a bracket."""
    if t <= 0.0:
        return 0.0
    k, less = slip.hold / slip.pull, (slip.hold - slip.pull) / slip.pull
    last = NOTHING / (less if slip.cos > 0.0 else k + 1.0) if less > 0.0 or slip.cos == 0.0 else -math.inf
    low, high = -1.0, 0.0
    while time_at(slip, low) < t:
        high, low = low, 2.0 * low
        if low < last:
            low = last
            break
    if time_at(slip, low) <= t:
        return low
    y = 0.5 * (low + high)
    cc, ss = slip.cos * slip.cos, slip.sin * slip.sin
    for _ in range(MOST_HALVINGS):
        beyond = time_at(slip, y) - t
        low, high = (y, high) if beyond > 0.0 else (low, y)
        slope = -slip.r / slip.pull * ((cc * math.exp(less * y) if cc > 0.0 else 0.0) + ss * math.exp((k + 1.0) * y))
        then = y - beyond / slope if slope < 0.0 else low
        if not low <= then <= high:
            then = 0.5 * (low + high)
        if abs(then - y) <= 1e-16 * max(1.0, abs(y)) or then == y:
            return then
        y = then
    return y


@inner
def bend(slip: Slip, y: float) -> float:
    """Return about how fast slip and its rate change with y, over their sizes."""
    k, less = slip.hold / slip.pull, (slip.hold - slip.pull) / slip.pull
    turned = slip.sin * math.exp(y)
    return k + 1.0 if slip.cos == 0.0 else abs(less) + 2.0 * turned / (slip.cos + turned)


@inner
def placed(slip: Slip, a: Pair) -> Pair:
    """Return a vector given along and across gravity in the plane's axes."""
    return (
        a[0] * slip.along[0] + a[1] * slip.across[0],
        a[0] * slip.along[1] + a[1] * slip.across[1],
    )
