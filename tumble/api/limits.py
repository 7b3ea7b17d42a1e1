"""What every study takes beside its scenes and contestants."""

from typing import TypedDict

from tumble.compare.run.progress import Display


class Limits(TypedDict):
    """Limits of each run, time [s] and memory [B], and what shows the progress."""

    time_limit: float
    memory_limit: int
    display: Display
