"""The exit code of a study, which fails if no contestant finished."""

from collections.abc import Iterable

from tumble.compare.run.status import FINISHED
from tumble.notes import note

DONE, FAILED = 0, 1


def exit_code(statuses: Iterable[str]) -> int:
    """Return 0 if any run finished, else 1, with a note."""
    if any(status in FINISHED for status in statuses):
        return DONE
    note("exit code 1: no contestant finished a run; the reasons are in the results")
    return FAILED
