"""The clock behind printed times: rows that are even but for the rounding of their times are at k / rate."""

from collections.abc import Callable
from decimal import Context, Decimal
from typing import NamedTuple

import numpy as np

from tumble.scenarios.frames import Array

# Returns half a unit in the last place of times, (n,), both in s.
HalfOf = Callable[[Array], Array]
# Relative spread of the intervals of an even clock in doubles.
EVEN = 1e-8
# Half a last digit, with a margin for rounding.
HALF = 1 + 1e-6
# A clock needs at least this many rows.
FEWEST = 4
# A number is believed if one as short is found by chance less often than this.
CHANCE = 0.05
# Usual row rates [1/s], believed if only one of them lies within this share.
RATES = (
    10,
    20,
    24,
    25,
    30,
    48,
    50,
    60,
    72,
    75,
    90,
    100,
    120,
    144,
    165,
    200,
    240,
    250,
    300,
    360,
    400,
    480,
    500,
    1000,
    2000,
)
USUALLY = 0.01
# Significant digits of a double.
MOST_DIGITS = 17


class EvenClock(NamedTuple):
    """Rows are at first + n interval for whole n; unknown: largest error of the interval; all in s.

    half_of: returns half a unit in the last place of printed times.
    """

    first: float
    interval: float
    unknown: float
    half_of: HalfOf

    def read(self, instants: Array) -> tuple[Array, Array]:
        """Return times without their rounding, and the error that each may still have, (n,).

        Times that are not on the clock stay as printed.
        """
        half = self.half_of(instants)
        count = np.round((instants - self.first) / self.interval)
        even = self.first + count * self.interval
        unknown = np.minimum(np.abs(count) * self.unknown, half)
        fits = np.abs(even - instants) <= HALF * half + unknown
        if len(even) > 1 and not (np.diff(even) > 0).all():
            fits = np.zeros_like(fits)
        return np.where(fits, even, instants), np.where(fits, unknown, half)


class PrintedClock(NamedTuple):
    """Times are as printed; half_of: returns half a unit in their last place, None if they are exact."""

    half_of: HalfOf | None = None

    def read(self, instants: Array) -> tuple[Array, Array]:
        """Return the times, and their rounding errors, (n,)."""
        return instants, np.zeros(len(instants)) if self.half_of is None else self.half_of(instants)


EXACT = PrintedClock()


def even_clock(instants: Array, later: Array, half_of: HalfOf, start: float) -> EvenClock | None:
    """Return the clock of a file's first rows, (n,), or None if they are exact or uneven.

    later: times from further on, which determine the rate better; half_of: returns half a unit in the last place;
    start: time of the scene's start; all in s.
    """
    if len(instants) < FEWEST or np.ptp(np.diff(instants)) <= EVEN * np.diff(instants).max():
        return None
    half = half_of(instants)
    for counts in _counts(instants, half):
        for first in (start, float(instants[0])):
            # A clock that begins at the scene's start has run since then.
            ticks = counts + round((instants[0] - first) * counts[-1] / (instants[-1] - instants[0]))
            bounds = _bounds(instants, half, ticks, first)
            if bounds is None:
                continue
            low, high = _narrowed(*bounds, later, half_of(later), first)
            interval = intended_interval(low, high)
            return EvenClock(first, interval or (low + high) / 2, 0.0 if interval else (high - low) / 2, half_of)
    return None


def _counts(instants: Array, half: Array) -> list[Array]:
    """Return the ticks of rows, counted from the first: consecutive, or with some rows missing."""
    found = [np.arange(len(instants), dtype=float)]
    steps = np.diff(instants)
    if 4 * half.max() < steps.min():
        found.append(np.append(0.0, np.cumsum(np.round(steps / steps.min()))))
    return found


def _bounds(instants: Array, half: Array, ticks: Array, first: float) -> tuple[float, float] | None:
    """Return bounds of the interval of a clock that shows these times, or None if there is none."""
    at_first = ticks == 0
    if (np.abs(instants - first)[at_first] > HALF * half[at_first]).any() or (ticks < 0).any():
        return None
    moved = ~at_first
    low = float(((instants - first - HALF * half)[moved] / ticks[moved]).max())
    high = float(((instants - first + HALF * half)[moved] / ticks[moved]).min())
    return (low, high) if 0 < low <= high else None


def _narrowed(low: float, high: float, further: Array, half: Array, first: float) -> tuple[float, float]:
    """Return narrower bounds from later times, as long as each can belong to only one tick of this clock."""
    for instant, room in sorted(zip((further - first).tolist(), (HALF * half).tolist(), strict=True)):
        fewest, most = np.ceil((instant - room) / high), np.floor((instant + room) / low)
        if fewest != most or fewest <= 0:
            break
        closer = max(low, (instant - room) / fewest), min(high, (instant + room) / fewest)
        if closer[0] > closer[1]:
            break
        low, high = closer
    return low, high


def intended_interval(low: float, high: float) -> float | None:
    """Return the interval between two bounds that the program used, None if too many are possible.

    It is a usual rate, or the number with fewest digits, as interval or as rate: 1/60 s is 60 Hz, and 0.0167 s is
    0.0167 s.
    """
    usual = [1 / rate for rate in RATES if low <= 1 / rate <= high]
    if len(usual) == 1 and high - low < USUALLY * high:
        return usual[0]
    rate, interval = _fewest_digits(1 / high, 1 / low), _fewest_digits(low, high)
    digits = min(len(rate.as_tuple().digits), len(interval.as_tuple().digits))
    # At most this many numbers with that many digits lie between the bounds.
    if 10.0**digits * (high - low) > CHANCE * high:
        return None
    return 1 / float(rate) if len(rate.as_tuple().digits) == digits else float(interval)


def _fewest_digits(low: float, high: float) -> Decimal:
    """Return the number from low to high with fewest significant digits, nearest to the middle."""
    middle = Decimal((low + high) / 2)
    rounded = (Context(prec=digits).plus(middle) for digits in range(1, MOST_DIGITS))
    return next((found.normalize() for found in rounded if low <= found <= high), middle)
