"""What became of a run: a status of a fixed list, and the reason."""

from dataclasses import dataclass
from enum import StrEnum


class Status(StrEnum):
    """The status of a run, as it stands in the column `status`."""

    OK = "ok"
    FLAGGED = "flagged"  # finished, but clamped, reset, frozen, under-rotated, ...
    DIVERGED = "diverged"  # a state was not finite
    SKIPPED = "skipped"  # the engine does not support the scene
    MISSING = "missing"  # the engine is not installed
    CRASHED = "crashed"
    TIMEOUT = "timeout"
    UNTIMED = "untimed"  # its time cannot be measured; the status of a timer, never of a run


FINISHED = (Status.OK, Status.FLAGGED)


@dataclass(frozen=True)
class Failure:
    """Why there is no trajectory, or no time.

    Parameters
    ----------
    status : kind of the failure
    reason : the reason, in words
    process_died : whether the process of the engine ended by itself, or could not be started
    """

    status: Status
    reason: str
    process_died: bool = False

    def __str__(self) -> str:
        """Return status and reason as text for a person."""
        return described(self.status, self.reason)


def described(status: str, reason: str) -> str:
    """Return a status and its reason as text for a person: `ok`, `skipped: no floor`, `diverged at 2 s`.

    Parameters
    ----------
    status : one of Status
    reason : empty if there is none

    Returns
    -------
    text
    """
    if not reason:
        return str(status)
    return f"{status} {reason}" if status == Status.DIVERGED else f"{status}: {reason}"
