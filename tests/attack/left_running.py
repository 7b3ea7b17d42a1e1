"""What nothing may be left of when it is over: processes, also those of other sessions."""

import os
import time
from collections.abc import Callable
from pathlib import Path

from patience import PATIENCE_S


def those(wanted: Callable[[Path], bool]) -> list[int]:
    """Return the numbers of the processes that are wanted, by their folders in /proc; none that has ended."""
    found = []
    for each in Path("/proc").glob("[0-9]*"):
        try:
            if wanted(each) and (each / "stat").read_text().rpartition(")")[2].split()[0] != "Z":
                found.append(int(each.name))
        except OSError:
            continue
    return found


def named(path: Path) -> list[int]:
    """Return the processes that have a path among their words, and what those have forked."""
    return those(lambda each: os.fsencode(path) in (each / "cmdline").read_bytes().split(b"\0"))


def carrying(mark: str) -> list[int]:
    """Return the processes whose environment carries a mark, NAME=VALUE."""
    return those(lambda each: mark.encode() in (each / "environ").read_bytes().split(b"\0"))


def left_running(path: Path) -> None:
    """Wait until no process is left that has a path among its words.  Raises AssertionError."""
    gone(lambda: named(path))


def gone(found: Callable[[], list[int]]) -> None:
    """Wait until none is found.  Raises AssertionError."""
    end = time.monotonic() + PATIENCE_S
    while left := found():
        assert time.monotonic() < end, f"left running: {left}"
        time.sleep(0.02)
