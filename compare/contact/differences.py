"""What differs between two measurements of one contestant above a plane: its law, or an observable's error."""

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

from tumble.compare.contact.findings import law, verdict_rank
from tumble.compare.contact.schemas import ContactRow

Verdict = Literal["worse", "better", "changed"]


@dataclass(frozen=True)
class Difference:
    """One difference.

    what: contact (the gravest verdict), law_error, or contact_error (at the scene's step); old, new: verdicts or
    errors; observable: with the number of its impact, and its unit; empty of a verdict.
    """

    verdict: Verdict
    what: str
    old: str | float
    new: str | float
    observable: str = ""
    unit: str = ""


def contact_differences(
    old: Sequence[ContactRow], new: Sequence[ContactRow], law_share: float, step_share: float
) -> Iterator[Difference]:
    """Yield what differs: the gravest verdict, and the observable whose law error changed most.

    A law error changed if the intervals of both have no number in common.  Where none did, the observable whose error
    at the scene's step changed most follows.

    Parameters
    ----------
    old, new : rows of contact.csv, of one contestant in one scene
    law_share, step_share : relative changes of a law error and of an error at the scene's step that are none

    Yields
    ------
    at most two
    """
    pairs = [
        (one, other) for one in old for other in new if (one.observable, one.blow) == (other.observable, other.blow)
    ]
    if not pairs:
        return
    was, is_ = law(old)[0], law(new)[0]
    if without_numbers(was) != without_numbers(is_):
        yield Difference(lower_is_better(verdict_rank(was), verdict_rank(is_)), "contact", was, is_)
    for what, apart, share in (("law_error", law_change, law_share), ("contact_error", step_change, step_share)):
        if found := most_changed(pairs, apart, share):
            other = found[1]
            was_m, is_m = ((row.law_error if what == "law_error" else row.error) or 0.0 for row in found)
            name = f"{other.observable} {other.blow}" if other.blow else other.observable
            yield Difference(lower_is_better(abs(was_m), abs(is_m)), what, was_m, is_m, name, other.unit)
            return


def without_numbers(verdict: str) -> str:
    """Return a verdict without its numbers."""
    return re.sub(r"[-+]?\d[\d.e+-]*", "#", verdict)


def lower_is_better(old: float, new: float) -> Verdict:
    """Return the verdict on two numbers."""
    return "worse" if new > old else "better" if new < old else "changed"


Pair = tuple[ContactRow, ContactRow]


def most_changed(pairs: Sequence[Pair], apart: Callable[[Pair, float], float], share: float) -> Pair | None:
    """Return the pair that is furthest apart, None if none is."""
    found = max(pairs, key=lambda pair: apart(pair, share))
    return found if apart(found, share) else None


def law_change(pair: Pair, share: float) -> float:
    """Return how far two law errors are apart, in the widths of their intervals; 0 if they may be the same."""
    old, new = pair
    if old.law_error is None or new.law_error is None:
        return 0.0
    ends = [(row.law_error_low or 0.0, row.law_error_high or 0.0) for row in pair]
    gap = max(low for low, _ in ends) - min(high for _, high in ends)
    apart = abs(new.law_error - old.law_error)
    if gap <= 0 or apart <= share * max(abs(old.law_error), abs(new.law_error)):
        return 0.0
    return apart / sum(high - low for low, high in ends)


def step_change(pair: Pair, share: float) -> float:
    """Return how far two errors at the scene's step are apart, in widths of the intervals; 0 if by no more than one."""
    old, new = pair
    if old.error is None or new.error is None:
        return 0.0
    width = max((row.law_error_high or 0.0) - (row.law_error_low or 0.0) for row in pair)
    apart = abs(new.error - old.error)
    return apart / width if width and apart > width + share * max(abs(old.error), abs(new.error)) else 0.0
