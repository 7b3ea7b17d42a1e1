"""The precision of printed numbers: the place of the last digit, and the rounding error that it allows."""

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from tumble.scenarios.frames import Array

NUMBER = re.compile(r"[+-]?(\d*)(?:\.(\d*))?(?:[eE]([+-]?\d{1,9}))?", re.ASCII)
# Components below this share of the largest one are shown as 0.
NOTHING = 1e-6
# Nine significant digits distinguish a single-precision number from its neighbours, and from most doubles; with eight
# most doubles, and with seven some, are not the nearest to any.
DECISIVE, TELLING = 9, 8
# At least this many cells with equally many decimals were printed so; a shortest number ends in 0 one time in ten.
FIXED = 30
# So many rows show whether a smooth motion was rounded, by differences of this order.
SMOOTH, ORDER = 20, 4
# Significant digits of a double.
MOST = 17
# Decimal places that are tried.
MOST_PLACES = 10
# Relative spread of the intervals of an even clock in doubles; and of a clock that is uneven.
ROUNDING, UNEVEN = 1e-8, 0.02


class Digits(NamedTuple):
    """The print format of a column.

    place: finest place of a last digit, 0 of a constant; figures: most significant digits; single: every cell may be a
    single-precision number as far as its digits show; longest: most significant digits without zeros at either end;
    fixed: all cells have equally many decimals, as by %.4f, and not as many as a number needs.
    """

    place: float = 0.0
    figures: int = 17
    single: bool = False
    longest: int = 0
    fixed: bool = True

    @property
    def is_decisive(self) -> bool:
        """Whether some cell has enough digits to show that it is a single-precision number."""
        return self.longest >= DECISIVE

    @property
    def is_telling(self) -> bool:
        """Whether some cell has so many digits that most doubles are seen to be none of single precision."""
        return self.longest >= TELLING

    def half(self, values: Array) -> Array:
        """Return half a unit in the last place of values, in the column's own unit."""
        size = np.abs(values)
        with np.errstate(divide="ignore"):
            leading = np.floor(np.log10(size))
        return 0.5 * np.maximum(self.place, 10.0 ** (np.where(size > 0, leading, -np.inf) + 1 - self.figures))


def digits(cells: Iterable[str], factor: float = 1.0) -> Digits:
    """Return the print format of cells that hold numbers; factor: of their unit, in which they may not be stored."""
    figures, longest, ends = 1, 0, False
    places: set[float] = set()
    values, lasts = list[float](), list[float]()
    cells = [cell.strip() for cell in cells]
    distinct = dict.fromkeys(cells)
    for cell in distinct:
        match = NUMBER.fullmatch(cell)
        if match is None:
            continue
        whole, part = match[1], match[2] or ""
        power = min(max(int(match[3] or 0), -400), 300)  # the range of doubles
        if not (whole + part).strip("0") and not part:
            continue  # a plain 0 shows no decimal place
        last = 10.0 ** max(power - len(part), -400)
        places.add(last)
        written = len((whole + part).lstrip("0"))
        figures = max(figures, written)
        ends = ends or part.endswith("0")
        # A short number such as 169.3750000 is single precision by chance.
        longest = max(longest, len((whole + part).strip("0")))
        values.append(float(match[0]))
        lasts.append(last)
    single = any(_are_single(unit * np.array(values), unit * np.array(lasts)) for unit in {1.0, factor})
    if len(distinct) == 1:
        return Digits(single=single, longest=longest)  # a constant shows no rounding
    # Printed with fixed decimals, as by %.4f, the number of significant digits follows the size.
    fixed = len(places) == 1 and (ends or len(cells) >= FIXED)
    return Digits(min(places, default=0.0), figures if len(places) > 1 else Digits().figures, single, longest, fixed)


def with_shared_format(columns: Sequence[Digits]) -> list[Digits]:
    """Return the formats of columns that share one print format.

    A column of short numbers, such as 0.05, 0.1, 0.15, does not show how many digits it could have.
    """
    free = [column for column in columns if not column.fixed]
    if len(free) < 2:
        return list(columns)
    place, figures = min(column.place for column in free), max(min(column.figures, MOST) for column in free)
    return [column if column.fixed else column._replace(place=place, figures=figures) for column in columns]


def with_exact_numbers(
    formats: Mapping[str, Digits], groups: Sequence[Sequence[str]], rows: Mapping[str, Sequence[float]]
) -> dict[str, Digits]:
    """Return the formats of groups of columns, of which some hold numbers that are exact in few decimals.

    They are if they change smoothly: their last digits are none that were rounded, and a program that
    writes no zeros at the end would write as many digits as in other columns.  rows: the numbers of the first ones.
    """
    exact = [name for group in groups for name in _exact_columns(group, formats, rows)]
    others = (formats[name] for group in groups for name in group if name not in exact)
    figures = min(max((each.figures for each in others if not each.fixed), default=0), MOST)
    found = dict(formats)
    for name in (name for name in exact if formats[name].figures < figures):
        finer, numbers = formats[name]._replace(place=0.0, figures=figures), np.array(rows[name])
        found[name] = finer._replace(single=_are_single(numbers, 2.0 * finer.half(numbers)))
    return found


def _exact_columns(
    group: Sequence[str], formats: Mapping[str, Digits], rows: Mapping[str, Sequence[float]]
) -> list[str]:
    """Return the columns of a group that change, if all of them do so too smoothly for rounded numbers."""
    moving = [name for name in group if formats[name].place]
    are_exact = all(not formats[name].fixed and _is_exact(np.array(rows[name]), formats[name].place) for name in moving)
    return moving if are_exact else []


def _is_exact(numbers: Array, place: float) -> bool:
    """Whether numbers, (N,), change in most rows, and so smoothly that none was rounded to a place."""
    changes = np.diff(numbers)
    is_moving = len(numbers) >= SMOOTH and 2 * np.count_nonzero(changes) > len(changes)
    return bool(is_moving and np.abs(np.diff(changes, ORDER - 1)).max() < 0.5 * place)


def _are_single(values: Array, lasts: Array) -> bool:
    """Whether values may be single-precision numbers that were rounded to their last digits, (N,) both."""
    with np.errstate(over="ignore", invalid="ignore"):
        return bool((np.abs(values - values.astype(np.float32)) <= 0.501 * lasts).all())


def shared_place(numbers: Array) -> float:
    """Return the coarsest decimal place of which all numbers are multiples, 0 if there is none."""
    for place in 10.0 ** -np.arange(1, MOST_PLACES):
        if (np.abs(numbers - np.round(numbers / place) * place) <= ROUNDING * place).all():
            return float(place)
    return 0.0


def rounded_times(times: Array, place: float) -> bool:
    """Whether times, (T,), were rounded to a place.

    They are if the clock is even but for that, as 0.017, 0.033, 0.05, 0.067, or if many intervals are not multiples of
    the least one.
    """
    if len(times) < 3:
        return False
    intervals = np.diff(times)
    uneven, least = float(np.ptp(intervals)), float(intervals.min())
    if not uneven > ROUNDING * intervals.max():
        return False
    counts = intervals / least
    return uneven <= 2.01 * place or (len(times) >= FIXED and float(np.ptp(counts - np.round(counts))) > UNEVEN)


def vector_text(values: Iterable[float]) -> str:
    """Return numbers in four significant digits with commas, as 0 below a millionth of the largest one."""
    numbers = [*values]
    least = NOTHING * max(map(abs, numbers))
    return ", ".join(f"{number if abs(number) > least else 0.0:.4g}" for number in numbers)
