"""How long a truth may take, which the caller says: every loop that works on one looks at the same clock.

A truth is three parts: the answer, its check, and what rounded inputs do.  Each is given as long as a flight of an
engine.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from time import monotonic

PARTS = 3


class Late(Exception):
    """A truth takes longer than it may."""


class Deadline:
    """When wall time is up: so many parts of limit_s [s], from now on."""

    def __init__(self, limit_s: float, parts: int = 1) -> None:
        self.limit_s, self._end = limit_s, monotonic() + parts * limit_s

    def left_s(self) -> float:
        """Return what is left of it [s]."""
        return self._end - monotonic()

    def check(self) -> None:
        """Raise Late where it has passed."""
        if self.left_s() < 0:
            raise Late


# Of the truth that this thread works out: its loops are deep below what asks for it.
_deadline: ContextVar[Deadline] = ContextVar("_deadline", default=Deadline(float("inf")))  # noqa: B039


def current() -> Deadline:
    """Return the deadline of the truth that this thread works out."""
    return _deadline.get()


@contextmanager
def within(limit_s: float) -> Iterator[None]:
    """Let each part of the truth that is worked out meanwhile take so long [s] of wall time at most."""
    token = _deadline.set(Deadline(limit_s, PARTS))
    try:
        yield
    finally:
        _deadline.reset(token)
