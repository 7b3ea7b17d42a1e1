"""What printed figures can tell: the place of the last digit, and how far off a right number may be by rounding."""

import re
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from tumble.scenarios.frames import Array

NUMBER = re.compile(r"[+-]?(\d*)(?:\.(\d*))?(?:[eE]([+-]?\d{1,9}))?", re.ASCII)
# Nine significant digits tell every single-precision number from its neighbours, and from most doubles.
TELLING = 9
# So many cells with as many decimals each were given them; shortest numbers end in a 0 one time in ten.
FIXED = 30
# Of a double.
MOST = 17
# Decimal places that are looked at.
MOST_PLACES = 10
# Intervals of a clock in doubles are as even as this; those of no clock are this share of the least interval apart.
ROUNDING, UNEVEN = 1e-8, 0.02


class Digits(NamedTuple):
    """How a column is printed: the finest place of a last digit, and the most significant figures.

    single: every cell is a number of single precision as far as its figures go; telling: in one of them they go far;
    fixed: all cells have as many decimals, as by %.4f; otherwise those that a number needs, as a short one may.
    """

    place: float = 0.0
    figures: int = 17
    single: bool = False
    telling: bool = False
    fixed: bool = True

    def half(self, values: Array) -> Array:
        """Return half a unit of the last place of values, in the column's own unit."""
        size = np.abs(values)
        with np.errstate(divide="ignore"):
            leading = np.floor(np.log10(size))
        return 0.5 * np.maximum(self.place, 10.0 ** (np.where(size > 0, leading, -np.inf) + 1 - self.figures))


def digits(cells: Iterable[str]) -> Digits:
    """Return how cells that hold numbers are printed; whether they are numbers of single precision."""
    figures, single, telling, ends = 1, True, False, False
    places: set[float] = set()
    cells = [cell.strip() for cell in cells]
    constant = len(set(cells)) == 1
    for cell in cells:
        match = NUMBER.fullmatch(cell)
        if match is None:
            continue
        whole, part = match[1], match[2] or ""
        power = min(max(int(match[3] or 0), -400), 300)  # what a number of double precision can have
        if not (whole + part).strip("0") and not part:
            continue  # a plain 0 does not say to how many places
        last = 10.0 ** max(power - len(part), -400)
        places.add(last)
        written = len((whole + part).lstrip("0"))
        figures = max(figures, written)
        ends = ends or part.endswith("0")
        # 169.3750000 is a number of single precision because it is a short one.
        if len((whole + part).strip("0")) >= TELLING:
            telling = True
            value = float(match[0])
            single = single and abs(value - _single(value)) <= 0.501 * last
    if constant:
        return Digits(single=single)  # nothing says that it is rounded
    # Printed to one place, as by %.4f, a number has as many figures as it is large.
    fixed = len(places) == 1 and (ends or len(cells) >= FIXED)
    return Digits(min(places, default=0.0), figures if len(places) > 1 else Digits().figures, single, telling, fixed)


def alike(columns: Sequence[Digits]) -> list[Digits]:
    """Return the digits of columns that one program printed in one way.

    A column of short numbers, as 0.05, 0.1, 0.15, does not show how many figures it would have been given.
    """
    free = [column for column in columns if not column.fixed]
    if len(free) < 2:
        return list(columns)
    place, figures = min(column.place for column in free), max(min(column.figures, MOST) for column in free)
    return [column if column.fixed else column._replace(place=place, figures=figures) for column in columns]


def _single(value: float) -> float:
    with np.errstate(over="ignore"):
        return float(np.float32(value))


def shared_place(numbers: Array) -> float:
    """Return the coarsest decimal place of which all of some numbers are multiples, 0 where there is none."""
    for place in 10.0 ** -np.arange(1, MOST_PLACES):
        if (np.abs(numbers - np.round(numbers / place) * place) <= ROUNDING * place).all():
            return float(place)
    return 0.0


def rounded_times(times: Array, place: float) -> bool:
    """Whether instants, (T,), show that they were rounded to a place.

    As those of an even clock do, 0.017, 0.033, 0.05, 0.067, or many that are no multiples of the least interval.
    """
    if len(times) < 3:
        return False
    intervals = np.diff(times)
    uneven, least = float(np.ptp(intervals)), float(intervals.min())
    if not uneven > ROUNDING * intervals.max():
        return False
    counts = intervals / least
    return uneven <= 2.01 * place or (len(times) >= FIXED and float(np.ptp(counts - np.round(counts))) > UNEVEN)
