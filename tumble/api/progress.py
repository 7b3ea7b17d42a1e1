"""A bar while a function runs, in a terminal or a notebook; anywhere else nothing is written."""

import html
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from tumble.compare.run.progress import Display, no_display
from tumble.notes import Meter, bar

# A bar in a notebook appears after this time [s], and is drawn again as often.
PERIOD_S = 0.5


def display(wanted: bool) -> Display:
    """Return what shows the progress of a study.

    Parameters
    ----------
    wanted : whether the caller wants a bar.

    Returns
    -------
    Display
        A bar where somebody can see it; nothing into a pipe or a file.
    """
    if not wanted:
        return no_display
    if in_jupyter():
        return below_the_cell
    if in_marimo():
        return in_marimos_cell
    return in_the_terminal if sys.stderr is not None and sys.stderr.isatty() else no_display


@contextmanager
def in_the_terminal(total: float = 0.0, doing: str = "running") -> Iterator[Meter]:
    """Draw a bar for one stage of a study."""
    meter = Meter(doing, total)
    with bar(meter):
        yield meter


@contextmanager
def below_the_cell(total: float = 0.0, doing: str = "running") -> Iterator[Meter]:
    """Draw a bar for one stage of a study in Jupyter, and remove it at the end."""
    from IPython.display import display as show

    meter, handles = Meter(doing, total), []

    def draw() -> None:
        shown = {"text/plain": meter.line, "text/html": markup(meter)}
        if handles:
            handles[0].update(shown, raw=True)
        else:
            handles.append(show(shown, raw=True, display_id=True))

    try:
        with again_and_again(draw, threading.Thread):
            yield meter
    finally:
        for handle in handles:
            handle.update({"text/plain": "", "text/html": ""}, raw=True)


@contextmanager
def in_marimos_cell(total: float = 0.0, doing: str = "running") -> Iterator[Meter]:
    """Draw a bar for one stage of a study in marimo, and remove it at the end."""
    import marimo  # type: ignore[import-not-found]

    meter = Meter(doing, total)
    with (
        marimo.status.spinner(title=doing, remove_on_exit=True) as spinner,
        again_and_again(lambda: spinner.update(subtitle=meter.line), marimo.Thread),
    ):
        yield meter


@contextmanager
def again_and_again(draw: Callable[[], object], thread: Callable[..., Any]) -> Iterator[None]:
    """Draw every PERIOD_S until the end, in a thread of its own, so that the time moves during a long piece."""
    ended = threading.Event()

    def run() -> None:
        while not ended.wait(PERIOD_S):
            draw()

    drawing = thread(target=run, daemon=True, name="progress")
    drawing.start()
    try:
        yield
    finally:
        ended.set()
        drawing.join()


def markup(meter: Meter) -> str:
    """Return a bar as HTML, without a value where the number of pieces is unknown."""
    value = f'value="{meter.done:g}" max="{meter.total:g}"' if meter.total else ""
    return f"<label><progress {value}></progress> {html.escape(meter.line)}</label>"


def in_notebook() -> bool:
    """Return whether a notebook's kernel runs this process.

    Returns
    -------
    bool
    """
    return in_jupyter() or in_marimo()


def in_jupyter() -> bool:
    """Return whether a kernel of Jupyter, or of a program that speaks its protocol, runs this process."""
    shell = sys.modules.get("IPython")
    own = shell.get_ipython() if shell else None
    return any(each.__name__ == "ZMQInteractiveShell" for each in type(own).__mro__)


def in_marimo() -> bool:
    """Return whether marimo runs this process."""
    return "marimo._runtime" in sys.modules
