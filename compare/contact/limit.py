"""The limit of a number for steps that go to zero, with an interval, from a ladder of steps.

Where the differences between neighbouring steps fall by one order, Richardson's extrapolation gives the limit
(Richardson, Phil. Trans. R. Soc. A 210 (1911) 307).  Where they fall, but irregularly, the limit is the last value,
to within the last differences.  Where they do not fall there is no limit: the interval is what the last steps span.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from tumble.compare.judge.ladder import one_order
from tumble.scenarios.frames import Array

# A smaller order is none that a ladder can extrapolate.
LEAST_ORDER = 0.4
# Of a ladder that converges, the last levels span at most this share of what the levels before them span.
FALLS = 0.6
LAST = 3
# An order this near to a whole number is that number.
NEARLY = 0.1


@dataclass(frozen=True)
class Level:
    """A number at one step dt_s, (P,): at P positions of the contact within a step, or one."""

    dt_s: float
    values: Array

    @property
    def mean(self) -> float:
        """The mean over the positions."""
        return float(self.values.mean())

    @property
    def spread(self) -> float:
        """Half the range over the positions."""
        return float(np.ptp(self.values)) / 2


@dataclass(frozen=True)
class Limit:
    """The limit for dt -> 0 with its interval; order: None where none shows; converges: whether there is a limit."""

    value: float
    low: float
    high: float
    order: float | None
    converges: bool


UNKNOWN = Limit(math.nan, math.nan, math.nan, None, converges=False)


def limit(ladder: Sequence[Level], resolution: float) -> Limit:
    """Return the limit of a ladder, the longest step first; resolution: half the least width of the interval.

    Levels at which the number could not be read are left out; without one at the finest step there is no limit.
    """
    if not ladder or not np.isfinite(ladder[-1].values).all():
        return UNKNOWN
    known = [level for level in ladder if np.isfinite(level.values).all()]
    last = known[-1]
    if len(known) < LAST or width(known[-LAST:]) <= resolution:
        return around(last.mean, max(resolution, width(known)))
    if not falls(known, resolution):
        low = min(level.mean - level.spread for level in known[-LAST:])
        high = max(level.mean + level.spread for level in known[-LAST:])
        middle = (low + high) / 2
        return Limit(middle, min(low, middle - resolution), max(high, middle + resolution), None, converges=False)
    slopes = regular_slopes(known)
    order = one_order(slopes[-LAST:])
    if order is None or order < LEAST_ORDER:
        remains = float(abs(np.diff([level.mean for level in known[-LAST:]])).max()) + last.spread
        return around(last.mean, max(resolution, remains))
    plain = round(order) if abs(order - round(order)) <= NEARLY else order
    best, before = (richardson(known[at - 1], known[at], plain) for at in (-1, -2))
    measured = richardson(known[-2], last, order)
    return around(best, max(resolution, abs(best - before), abs(best - measured), last.spread), order)


def falls(ladder: Sequence[Level], resolution: float) -> bool:
    """Whether the last levels differ by less than those before, and so do the positions within a step."""
    late, early = ladder[-LAST:], ladder[-2 * LAST + 1 : -LAST + 1] or ladder
    spread = ladder[-1].spread
    settles = spread <= max(resolution, FALLS * max(level.spread for level in late))
    return settles and width(late) <= FALLS * width(early)


def around(value: float, half: float, order: float | None = None) -> Limit:
    """Return a limit with that interval to both sides."""
    return Limit(value, value - half, value + half, order, converges=True)


def shifted(found: Limit, by: float) -> Limit:
    """Return a limit of numbers that are all larger by as much."""
    return replace(found, value=found.value + by, low=found.low + by, high=found.high + by)


def width(levels: Sequence[Level]) -> float:
    """Return what the values of levels span, at all positions."""
    values = np.concatenate([level.values for level in levels])
    return float(np.ptp(values))


def regular_slopes(ladder: Sequence[Level]) -> list[float]:
    """Return the order that each three neighbours show, the coarsest first, nan where the value turns back."""
    slopes = []
    for coarse, middle, fine in zip(ladder, ladder[1:], ladder[2:], strict=False):
        first, second = coarse.mean - middle.mean, middle.mean - fine.mean
        regular = first * second > 0
        slopes.append(math.log(first / second) / math.log(coarse.dt_s / middle.dt_s) if regular else math.nan)
    return slopes


def richardson(coarse: Level, fine: Level, order: float) -> float:
    """Return the extrapolation of two levels."""
    return fine.mean + (fine.mean - coarse.mean) / ((coarse.dt_s / fine.dt_s) ** order - 1)
