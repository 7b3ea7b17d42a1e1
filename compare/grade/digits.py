"""What printed figures can tell: the place of the last digit, and how far off a right number may be by rounding."""

import re
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from scenarios.frames import Array

NUMBER = re.compile(r"[+-]?(\d*)\.?(\d*)(?:[eE]([+-]?\d+))?", re.ASCII)
# Nine significant digits tell every single-precision number from its neighbours, and from most doubles.
TELLING = 9
# Intervals of a clock in doubles are as even as this.
ROUNDING = 1e-8


class Digits(NamedTuple):
    """How a column is printed: the finest place of a last digit, and the most significant figures.

    single: every cell is a number of single precision as far as its figures go; telling: in one of them they go far.
    """

    place: float = 0.0
    figures: int = 17
    single: bool = False
    telling: bool = False

    def half(self, values: Array) -> Array:
        """Return half a unit of the last place of values, in the column's own unit."""
        size = np.abs(values)
        with np.errstate(divide="ignore"):
            leading = np.floor(np.log10(size))
        return 0.5 * np.maximum(self.place, 10.0 ** (np.where(size > 0, leading, -np.inf) + 1 - self.figures))


def digits(cells: Iterable[str]) -> Digits:
    """Return how cells that hold numbers are printed; whether they are numbers of single precision."""
    place, figures, single, telling = np.inf, 0, True, False
    cells = list(cells)
    if len(set(cells)) == 1:
        return Digits()  # nothing says that it is rounded
    for cell in cells:
        match = NUMBER.fullmatch(cell.strip())
        if match is None:
            continue
        whole, part, power = match[1], match[2], int(match[3] or 0)
        if not (whole + part).strip("0") and not part:
            continue  # a plain 0 does not say to how many places
        place = min(place, 10.0 ** max(power - len(part), -400)) if power > -400 else place
        written = len((whole + part).lstrip("0"))
        figures = max(figures, written)
        if written >= TELLING:
            telling = True
            value = float(cell)
            slack = 0.5 * 10.0 ** max(power - len(part), -400)
            single = single and abs(value - _single(value)) <= slack
    return Digits(place if np.isfinite(place) else 0.0, max(figures, 1), single, telling)


def _single(value: float) -> float:
    with np.errstate(over="ignore"):
        return float(np.float32(value))


def rounded_times(times: Array, place: float) -> bool:
    """Whether instants, (T,), are those of an even clock rounded to a place: 0.017, 0.033, 0.05, 0.067."""
    if len(times) < 3:
        return False
    intervals = np.diff(times)
    uneven = float(np.ptp(intervals))
    return ROUNDING * intervals.max() < uneven <= 2.01 * place
