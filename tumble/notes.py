"""What goes to standard error: notes and progress, so that standard output holds results alone."""

import logging
import sys
import threading
from argparse import Namespace
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import partial
from time import monotonic
from typing import TYPE_CHECKING

from tumble.scenarios.format import visible

if TYPE_CHECKING:
    from tumble.compare.run.progress import Display

# Interval of progress lines where standard error is not a terminal [s].
PERIOD_S = 10.0
# Pieces that are done before the time that is left is estimated.
FEW = 5


class ToStandardError(logging.Handler):
    """Prints what Tumble logs as notes."""

    def emit(self, record: logging.LogRecord) -> None:
        """Print one message."""
        note(record.getMessage())


def show_log() -> None:
    """Print what Tumble logs from now on."""
    log = logging.getLogger("tumble")
    if not any(isinstance(handler, ToStandardError) for handler in log.handlers):
        log.addHandler(ToStandardError())
        log.setLevel(logging.INFO)


def note(line: str) -> None:
    """Print one line to standard error."""
    sys.stderr.write(visible(f"tumble: {line}") + "\n")


def notes(lines: Iterable[str]) -> None:
    """Print lines to standard error."""
    for line in lines:
        note(line)


class Meter:
    """Progress of one stage: called with each piece that is done, or with a share of one (`compare.run.progress`).

    doing: what the command does; total: number of pieces, 0 if unknown.
    """

    def __init__(self, doing: str, total: float) -> None:
        # Loaded by what has workers: 30 ms that a command without engines does not need.
        execution = sys.modules.get("tumble.compare.run.execution")
        self._workers = execution.EXECUTION.get().workers if execution else None
        self.doing, self.total, self.done, self.last = doing, total, 0.0, ""
        self._begun = monotonic()
        # Engines run side by side.
        self._one_at_a_time = threading.Lock()
        self.changed: Callable[[], object] = lambda: None

    def __call__(self, what: str, share: float = 1.0, /) -> None:
        """Add a share of a named piece."""
        with self._one_at_a_time:
            self.done, self.last = self.done + share, what
            self.changed()

    @property
    def line(self) -> str:
        """The progress, in words."""
        of = f", {self.done:.0f} of {self.total:.0f} done" if self.total else ""
        last = f"; last: {self.last}" if self.last else ""
        took = monotonic() - self._begun
        # Of few pieces, the first say little of the others.
        left = took * (self.total - self.done) / self.done if self.total and self.done >= FEW else 0.0
        rest = f", about {left:.0f} s left" if left >= 1 else ""
        return f"{took:.0f} s: {self.doing}{self.where}{of}{rest}{last}"

    @property
    def where(self) -> str:
        """The workers that there are now, in words; empty of this machine."""
        return f" on {self._workers}" if self._workers and self.total else ""


def display(options: Namespace) -> "Display":
    """Return how a command shows its progress, by its options."""
    return partial(progress, quiet=options.quiet)


@contextmanager
def progress(total: float = 0.0, doing: str = "running", quiet: bool = False) -> Iterator[Meter]:
    """Give the callback of one stage: a bar in a terminal, else a line every PERIOD_S seconds.

    total: number of pieces, 0 if unknown; doing: what the stage does; quiet: show nothing.
    """
    meter = Meter(doing, total)
    if quiet:
        yield meter
    elif sys.stderr.isatty():
        with bar(meter):
            yield meter
    else:
        with lines(meter):
            yield meter


@contextmanager
def lines(meter: Meter) -> Iterator[None]:
    """Write a line every PERIOD_S seconds until the end."""
    ended = threading.Event()

    def write() -> None:
        while not ended.wait(PERIOD_S):
            note(meter.line)

    writer = threading.Thread(target=write, daemon=True, name="progress")
    writer.start()
    try:
        yield
    finally:
        ended.set()
        writer.join()


@contextmanager
def bar(meter: Meter) -> Iterator[None]:
    """Draw a bar until the end, with the elapsed time, so that it moves during a long piece."""
    from rich.console import Console  # slow to import
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    rest = (MofNCompleteColumn(), TimeElapsedColumn(), TimeRemainingColumn()) if meter.total else (TimeElapsedColumn(),)
    layout = TextColumn("{task.description}", markup=False), BarColumn(), *rest, TextColumn("{task.fields[where]}")
    with Progress(*layout, console=Console(stderr=True), transient=True) as drawn:
        task = drawn.add_task(meter.doing, total=meter.total or None, where=meter.where)
        meter.changed = lambda: drawn.update(
            task, completed=meter.done, description=visible(meter.last), where=meter.where
        )
        yield
