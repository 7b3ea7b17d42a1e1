"""What `tumble grade` says of a file before and during a search, in lines of text."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from tumble.compare.grade.hypotheses.explanation import Explanation
from tumble.compare.grade.measure.errors import Measured
from tumble.reports.lengths import length

if TYPE_CHECKING:  # most files have no readings
    from tumble.compare.grade.measure.readings import MeasuredReadings


def first_lines(file: str, m: Measured, observed: Sequence[str] = ()) -> Iterator[str]:
    """Yield what is known before a search, a line each.

    Parameters
    ----------
    file : name of the file
    m : its errors
    observed : observations, sentences

    Returns
    -------
    lines of text
    """
    yield f"{file}: largest error {length(m.worst_m)} at t = {m.worst_t_s:g} s; searching for its cause"
    yield from (f"observed: {sentence}" for sentence in observed)


def nearest_line(nearest: Explanation) -> str:
    """Return the nearest engine scheme, if none explains the file.

    Parameters
    ----------
    nearest : the explanation by that scheme

    Returns
    -------
    one line of text
    """
    left = length(nearest.max_m)
    return f"no engine's default explains it; closest so far ({left} left): {mistakes_text(nearest)}; searching"


def mistakes_text(explanation: Explanation) -> str:
    """Return the mistakes of an explanation in one line."""
    return "; and ".join(mistake.text for mistake in explanation.mistakes) or "nothing wrong"


def first_reading_lines(file: str, measured: "Sequence[MeasuredReadings]") -> Iterator[str]:
    """Yield what is known of readings before a search, a line a device.

    Parameters
    ----------
    file : name of the file
    measured : the errors of each device

    Returns
    -------
    lines of text
    """
    for m in measured:
        where = f"largest error {size(m, m.worst)} at t = {m.worst_t_s:g} s"
        yield f"{file}: {m.device}: {where}; searching for its cause"


def size(m: "MeasuredReadings", value: float) -> str:
    """Return an error with its unit, in three significant digits."""
    return f"{float(f'{value:.3g}'):g} {m.unit}"
