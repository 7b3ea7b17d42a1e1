"""Starts the engines of a study, and reports that they are starting."""

from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager

from tumble.compare.run.local import Asked
from tumble.compare.run.progress import Display, no_display
from tumble.compare.run.running_engines import TIME_LIMIT_S, RunningEngine, launched
from tumble.compare.run.timing import machine_load
from tumble.compare.run.worker import MEMORY_LIMIT


@contextmanager
def started(
    contestants: Iterable[Asked] = (),
    time_limit: float = TIME_LIMIT_S,
    memory_limit: int = MEMORY_LIMIT,
    display: Display = no_display,
    few: bool = False,
    beside: Iterable[str] = (),
) -> Iterator[list[RunningEngine]]:
    """Start the engines of a study, and end their processes when the study ends.

    Parameters
    ----------
    contestants : ENGINE[@RELEASE][:METHOD] or FILE[:METHOD] of each; empty: the engines installed with Tumble
    time_limit : for each answer of an engine [s]
    memory_limit : for each engine's process [B]
    display : shows that engines are starting
    few : of an engine without a method, only the methods that the page shows
    beside : contestants of another run, from which the titles of these must differ

    Returns
    -------
    a context that gives the running engines

    Raises
    ------
    BadEngine : an engine or a method is unknown
    """
    machine_load.seen.clear()  # what was seen while another study took times is none of this one's conditions
    machine_load.measured.clear()
    with ExitStack() as engines:
        with display(doing="starting engines"):
            running_engines = engines.enter_context(launched(contestants, time_limit, memory_limit, few, beside))
        yield running_engines
