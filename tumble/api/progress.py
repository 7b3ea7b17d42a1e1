"""A bar while a function runs, in a terminal or a notebook; anywhere else nothing is written."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from tumble.compare.run.progress import Display, no_display
from tumble.notes import Meter, bar


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
    return shown if wanted and (in_notebook() or (sys.stderr is not None and sys.stderr.isatty())) else no_display


@contextmanager
def shown(total: float = 0.0, doing: str = "running") -> Iterator[Meter]:
    """Draw a bar for one stage of a study."""
    meter = Meter(doing, total)
    with bar(meter):
        yield meter


def in_notebook() -> bool:
    """Return whether a notebook's kernel runs this process.

    Returns
    -------
    bool
    """
    shell = sys.modules.get("IPython")
    own = shell.get_ipython() if shell else None
    return type(own).__name__ == "ZMQInteractiveShell" or "marimo._runtime" in sys.modules
