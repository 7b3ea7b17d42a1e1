"""How far a study is: who is told, and a truth that tells its share of it."""

import threading
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from typing import Protocol

# A truth that takes longer [s] tells what share of it is done, in pieces as large as this and larger.
QUICK_S, PIECE = 1.0, 0.01


class ProgressCallback(Protocol):
    """Is told of every flight and truth as it is done, and of a long truth piece by piece: shares that come to one."""

    def __call__(self, what: str, share: float = 1.0, /) -> object:
        """Hear that this share of what is named is done."""


def no_progress(what: str, share: float = 1.0) -> None:
    """Report nothing.

    Parameters
    ----------
    what : name of the piece of work, ignored
    share : share of it that is done, ignored
    """


class Display(Protocol):
    """Shows the progress of one stage of a study: a context that gives the stage's callback."""

    def __call__(self, total: float = 0.0, doing: str = "running") -> AbstractContextManager[ProgressCallback]:
        """Begin a stage; total: number of pieces, 0 if unknown; doing: what the stage does."""
        ...


@contextmanager
def no_display(total: float = 0.0, doing: str = "running") -> Iterator[ProgressCallback]:
    """Show nothing.

    Parameters
    ----------
    total : number of pieces, ignored
    doing : what the stage does, ignored

    Returns
    -------
    a context that gives a callback without effect
    """
    yield no_progress


class Progress:
    """Tells of a truth, or another long piece of work, in shares that come to one, or at once where it is quick."""

    def __init__(self, what: str, on_progress: ProgressCallback) -> None:
        self._what, self._tick, self._told, self._begun = what, on_progress, 0.0, time.monotonic()
        # The end may be told before the last piece has been heard of.
        self._one_at_a_time = threading.Lock()

    def __call__(self, share: float) -> None:
        """Tell that this share of it is done."""
        with self._one_at_a_time:
            if share - self._told >= PIECE and share < 1 and time.monotonic() - self._begun > QUICK_S:
                self._tick(self._what, share - self._told)
                self._told = share

    def end(self) -> None:
        """Tell that all of it is done."""
        with self._one_at_a_time:
            rest = (1 - self._told,) if self._told else ()
            self._tick(self._what, *rest)
            self._told = 1.0
