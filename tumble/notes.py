"""What goes to standard error: notes and progress, so that standard output holds results alone."""

import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager

from scenarios.format import visible


def note(line: str) -> None:
    """Print one line to standard error."""
    sys.stderr.write(visible(f"tumble: {line}") + "\n")


def notes(lines: Iterable[str]) -> None:
    """Print lines to standard error."""
    for line in lines:
        note(line)


@contextmanager
def progress(total: int) -> Iterator[Callable[..., None]]:
    """Give a function that is told of each piece done, or of a share of one; a bar is shown where somebody watches."""
    from rich.console import Console  # slow to import, and no use to who flies one flight
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    console = Console(stderr=True)
    layout = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*layout, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("flying", total=total)
        yield lambda what, share=1.0: bar.update(task, advance=share, description=what)
