"""What processes have used and what they may use, where the system counts and limits it: POSIX systems do."""

import os
import sys
from contextlib import suppress

try:
    import resource
except ImportError:  # Windows
    resource = None

# What ru_maxrss counts in [B].
MAXRSS = 1 if sys.platform == "darwin" else 1024


def peak_bytes() -> int:
    """Return the most memory that this process has held [B], 0 where the system does not count it.

    A process starts with the peak of the process that started it.
    """
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * MAXRSS if resource else 0


def children_ns() -> int:
    """Return the CPU time of the children that have ended [ns], 0 where the system does not count it."""
    if not resource:
        return 0
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return round(1e9 * (children.ru_utime + children.ru_stime))


def limit_memory(most: int) -> None:
    """Limit the memory of this process, and of each that it starts [B]; macOS and Windows ignore it."""
    if not resource:
        return
    _, hard = resource.getrlimit(resource.RLIMIT_DATA)
    most = most if hard == resource.RLIM_INFINITY else min(most, hard)
    with suppress(ValueError, OSError):  # macOS: more than that may be in use already
        resource.setrlimit(resource.RLIMIT_DATA, (most, most))


def reap(pid: int) -> tuple[int, int]:
    """Wait for a child; return its exit code, -N after signal N, and the most memory it has held [B]."""
    _, status, used = os.wait4(pid, 0)
    return os.waitstatus_to_exitcode(status), used.ru_maxrss * MAXRSS
