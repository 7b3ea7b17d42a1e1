"""When the floor begins and ceases to push a vertex: the laws have a corner there, and a step has to end on it.

A vertex is ABOVE the floor, PRESSING on it, or IDLE: below, but leaving so fast that the damper would pull.  What would
end that state is watched as a number that is not negative while it lasts: the height, the depth, the thrust N or -N.
"""

from typing import NamedTuple

import numpy as np

from tumble.scenarios.frames import Array
from tumble.scenarios.truth.compilation import inner
from tumble.scenarios.truth.double_double import Pair, minus
from tumble.scenarios.truth.forced.series import value_at

ABOVE, PRESSING, IDLE = 0, 1, 2
NEVER = -1.0
HEIGHT, THRUST = 0, 1
# Below this share of a step a polynomial is not asked any more whether it dips under 0 and comes back.
FINEST = 2.0**-30
# The share of a polynomial's terms that their sum in doubles is not known to.
IN_DOUBLES = 1e-15
# Newton's corrections of an instant that doubles have found: each doubles its digits.
CORRECTIONS = 3


class Switch(NamedTuple):
    """When a vertex leaves its state, in units of the series; which vertex, by which gauge, and for what."""

    at: float
    vertex: int
    gauge: int
    then: int


@inner
def next_switch(high: Array, gauges: np.ndarray, contacts: np.ndarray, s: float, noise: Array) -> Switch:
    """Return the first switch before t/h = s; its instant is NEVER where there is none.

    noise: what of a height [m] and of a thrust [N] is rounding, (2,).
    """
    first = Switch(NEVER, 0, HEIGHT, ABOVE)
    polynomial = np.empty(high.shape[1])
    for vertex in range(len(gauges)):
        below = contacts[vertex] != ABOVE
        # What has to stay positive: the height above the floor, or the depth below it, ...
        write_polynomial(polynomial, high[gauges[vertex, HEIGHT]], -1.0 if below else 1.0, s)
        at = s * first_fall(polynomial, noise[HEIGHT])
        first = sooner(first, Switch(at, vertex, HEIGHT, ABOVE if below else PRESSING))
        if below:
            # ... and there the thrust while it presses, its opposite while it does not.
            pressing = contacts[vertex] == PRESSING
            write_polynomial(polynomial, high[gauges[vertex, THRUST]], 1.0 if pressing else -1.0, s)
            at = s * first_fall(polynomial, noise[THRUST])
            first = sooner(first, Switch(at, vertex, THRUST, IDLE if pressing else PRESSING))
    return first


@inner
def sooner(a: Switch, b: Switch) -> Switch:
    """Return the earlier of two switches."""
    return b if b.at >= 0.0 and (a.at < 0.0 or b.at < a.at) else a


@inner
def write_polynomial(polynomial: Array, coefficients: Array, sign: float, s: float) -> None:
    """Write a series in t/h as a polynomial in t/(s h), times a sign."""
    stretch = sign
    for power in range(len(polynomial)):
        polynomial[power] = stretch * coefficients[power]
        stretch *= s


@inner
def corrected(high: Array, low: Array | None, row: int, at: float, most: float) -> Pair:
    """Return the instant near t/h = at in which a series passes 0, to all its digits."""
    s = (at, 0.0)
    for _ in range(CORRECTIONS):
        slope = 0.0
        for power in range(high.shape[1] - 1, 0, -1):
            slope = slope * s[0] + power * high[row, power]
        if slope == 0.0:
            return s
        value = value_at(high, low, row, s)
        moved = minus(s, (value[0] / slope, value[1] / slope))
        if not 0.0 <= moved[0] <= most:
            return s
        s = moved
    return s


@inner
def first_fall(polynomial: Array, nothing: float) -> float:
    """Return the first z in [0, 1] after which a polynomial in z is negative, or NEVER.

    It is asked piece by piece, each half as long where neither the bounds of value nor those of slope decide: no dip
    wider than FINEST is overlooked.  Where it is `nothing` all along it is rounding, and so is a start below 0 that
    rises: a switch was made there.
    """
    piece = np.empty_like(polynomial)
    begin, width = 0.0, 1.0
    size = 0.0
    for coefficient in polynomial:
        size += abs(coefficient)
    nothing = max(nothing, IN_DOUBLES * size)
    while begin < 1.0:
        set_piece(piece, polynomial, begin, width)
        end, swing, bend = piece[0] + piece[1], abs(piece[1]), 0.0
        for power in range(2, len(piece)):
            end += piece[power]
            swing += abs(piece[power])
            bend += power * abs(piece[power])
        rises, falls, stays = piece[1] > bend, -piece[1] > bend, abs(piece[0]) > swing
        blank = abs(piece[0]) + swing <= nothing
        if not (rises or falls or stays or blank) and width > FINEST:
            width /= 2.0
            continue
        if end < 0.0 and not (rises or blank):
            return begin + (width * root_of(piece) if falls else 0.0)
        begin += width
        # The longest piece that may start here: a half of a half ... of the whole.
        while begin % (2.0 * width) == 0.0 and width < 1.0:
            width *= 2.0
    return NEVER


@inner
def set_piece(piece: Array, polynomial: Array, begin: float, width: float) -> None:
    """Write the same polynomial in u: over the piece z = begin + width (1 + u) / 2, u in [-1, 1] (Horner's scheme)."""
    centre = begin + width / 2.0
    degree = len(piece) - 1
    for power in range(degree + 1):
        piece[power] = polynomial[power]
    for lowest in range(degree):
        for power in range(degree - 1, lowest - 1, -1):
            piece[power] += centre * piece[power + 1]
    stretch = 1.0
    for power in range(degree + 1):
        piece[power] *= stretch
        stretch *= width / 2.0


@inner
def root_of(piece: Array) -> float:
    """Return where in [0, 1] a falling polynomial in u = 2 z - 1 passes 0, by bisection; 0 where it starts below."""
    low, high = 0.0, 1.0
    while True:
        middle = (low + high) / 2.0
        if not low < middle < high:
            return low
        value = 0.0
        for power in range(len(piece) - 1, -1, -1):
            value = value * (2.0 * middle - 1.0) + piece[power]
        if value < 0.0:
            high = middle
        else:
            low = middle
