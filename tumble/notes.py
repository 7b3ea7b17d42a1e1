"""What goes to standard error: notes and progress, so that standard output holds results alone."""

import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from time import monotonic

from tumble.scenarios.format import visible

# Where nobody watches a bar, into a file or a pipe, a line is written so often [s].
PERIOD_S = 10.0
_quiet = False


def be_quiet(quiet: bool) -> None:
    """Report no progress from now on, or report it again; notes are written all the same."""
    global _quiet
    _quiet = quiet


def note(line: str) -> None:
    """Print one line to standard error."""
    sys.stderr.write(visible(f"tumble: {line}") + "\n")


def notes(lines: Iterable[str]) -> None:
    """Print lines to standard error."""
    for line in lines:
        note(line)


class Meter:
    """How far a command is: is called with each piece that is done, or with a share of one (`compare.run.progress`).

    doing: what the command does; total: how many pieces there will be, 0 where that is not known.
    """

    def __init__(self, doing: str, total: float) -> None:
        self.doing, self.total, self.done, self.last = doing, total, 0.0, ""
        self._begun = monotonic()
        # Engines run side by side.
        self._one_at_a_time = threading.Lock()
        self.changed: Callable[[], object] = lambda: None

    def __call__(self, what: str, share: float = 1.0, /) -> None:
        """Take in that this share of what is named is done."""
        with self._one_at_a_time:
            self.done, self.last = self.done + share, what
            self.changed()

    @property
    def line(self) -> str:
        """How far it is, in words."""
        of = f", {self.done:.0f} of {self.total:.0f} done" if self.total else ""
        last = f"; last: {self.last}" if self.last else ""
        return f"{monotonic() - self._begun:.0f} s: {self.doing}{of}{last}"


@contextmanager
def progress(total: float = 0.0, doing: str = "running") -> Iterator[Meter]:
    """Give what is to be called with each piece done: a bar in a terminal, else a line every PERIOD_S seconds.

    total: pieces there will be, 0 where that is not known; doing: what the command does meanwhile.
    """
    told = Meter(doing, total)
    if _quiet:
        yield told
    elif sys.stderr.isatty():
        with bar(told):
            yield told
    else:
        with lines(told):
            yield told


@contextmanager
def lines(told: Meter) -> Iterator[None]:
    """Write a line again and again until the end."""
    ended = threading.Event()

    def write() -> None:
        while not ended.wait(PERIOD_S):
            note(told.line)

    writer = threading.Thread(target=write, daemon=True, name="progress")
    writer.start()
    try:
        yield
    finally:
        ended.set()
        writer.join()


@contextmanager
def bar(told: Meter) -> Iterator[None]:
    """Draw a bar until the end, with the time that has passed, so that it moves whatever takes long."""
    from rich.console import Console  # slow to import, and only for who watches
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    rest = (MofNCompleteColumn(), TimeElapsedColumn(), TimeRemainingColumn()) if told.total else (TimeElapsedColumn(),)
    layout = TextColumn("{task.description}", markup=False), BarColumn(), *rest
    with Progress(*layout, console=Console(stderr=True), transient=True) as drawn:
        task = drawn.add_task(told.doing, total=told.total or None)
        told.changed = lambda: drawn.update(task, completed=told.done, description=visible(told.last))
        yield
