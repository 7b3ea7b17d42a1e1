"""How long tests wait for what must happen, and lines of progress that only a busy machine brings.

Nothing here takes a minute on a quiet machine.  What is waited for ten times as long hangs, whatever else is running.
"""

import re
import time
from collections.abc import Callable

PATIENCE_S = 600.0
PROGRESS = re.compile(r"^tumble: \d+ s: .*\n", re.MULTILINE)


def until(happened: Callable[[], object]) -> None:
    """Wait until something has happened.  Raises AssertionError."""
    end = time.monotonic() + PATIENCE_S
    while not happened():
        assert time.monotonic() < end, "it never happened"
        time.sleep(0.02)


def without_progress(stderr: str) -> str:
    """Return what a command has said but for its lines of progress: the first comes after 10 s."""
    return PROGRESS.sub("", stderr)
