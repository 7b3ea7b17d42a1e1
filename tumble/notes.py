"""What goes to standard error: notes and progress, so that standard output holds results alone."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from reports.terminal import plain


def note(line: str) -> None:
    """Print one line to standard error."""
    Console(stderr=True, highlight=False, soft_wrap=True).print(plain(f"tumble: {line}"))


@contextmanager
def progress(total: int) -> Iterator[Callable[[str], None]]:
    """Give a function that is told of each piece done; a bar is shown only where somebody watches."""
    console = Console(stderr=True)
    layout = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*layout, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("flying", total=total)
        yield lambda what: bar.update(task, advance=1, description=what)
