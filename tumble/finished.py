"""The exit code of a study: a run in which no contestant finished is a failed one."""

from collections.abc import Iterable

from tumble.compare.run.status import FINISHED
from tumble.notes import note

DONE, FAILED = 0, 1


def exit_code(statuses: Iterable[str]) -> int:
    """Return 0 where any run finished, else 1, and say so on standard error."""
    if any(status in FINISHED for status in statuses):
        return DONE
    note("no contestant finished a run: exit code 1; the reasons stand with the results")
    return FAILED
