"""What else the machine does while times are taken: other work, time that its host has taken, slow processors."""

import logging
import os
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from time import monotonic

import psutil

# More than that of a core, of the time or of the frequency is not the machine's own housekeeping.
WORK, STOLEN, SLOW = 0.25, 0.02, 0.8
FREQUENCIES = Path("/sys/devices/system/cpu")
log = logging.getLogger(__name__)
# What was seen, once a process.
seen: list[str] = []
# Where a quiet worker took the times of a scene, and the load there, each time it did so in a study.
measured: dict[str, list[str]] = {}


@dataclass(frozen=True)
class Machine:
    """What the machine has done so far: wall time, time at work and time stolen by its host, over all cores [s]."""

    wall_s: float
    busy_s: float
    stolen_s: float


def machine() -> Machine | None:
    """Return what the machine has done, None where the system does not tell."""
    with suppress(OSError):
        so_far = psutil.cpu_times()
        names = ("user", "nice", "system", "irq", "softirq")
        busy_s = sum(getattr(so_far, name, 0.0) for name in names)
        return Machine(monotonic(), busy_s, getattr(so_far, "steal", 0.0))
    return None


def other_work(begin: Machine | None, end: Machine | None) -> str:
    """Say what else there was between two looks, while one core was ours; '' where there was nothing."""
    cores = os.cpu_count() or 1
    if begin is None or end is None:
        load = psutil.getloadavg()[0] - 1
        return f"other processes used about {load:.1f} of {cores} cores" if load > 2 * WORK else ""
    wall_s = max(end.wall_s - begin.wall_s, 1e-9)
    work = (end.busy_s - begin.busy_s) / wall_s - 1
    stolen = (end.stolen_s - begin.stolen_s) / wall_s / cores
    frequency = share_of_frequency()
    found = [
        (work > WORK, f"other processes used {work:.1f} of {cores} cores"),
        (stolen > STOLEN, f"the host took {stolen:.0%} of the time"),
        (frequency < SLOW, f"the processors ran at {frequency:.0%} of their frequency"),
    ]
    return ", ".join(words for so, words in found if so)


def share_of_frequency() -> float:
    """Return how fast the processors run, of their highest frequency; 1 where the system does not tell."""
    shares = []
    for folder in FREQUENCIES.glob("cpu[0-9]*/cpufreq"):
        with suppress(OSError, ValueError, ZeroDivisionError):
            now, most = (int((folder / name).read_text()) for name in ("scaling_cur_freq", "cpuinfo_max_freq"))
            shares.append(now / most)
    # The one that works is asked, not those that rest.
    return max(shares, default=1.0)


def say(words: str) -> None:
    """Log once a process what else the machine did while times were taken."""
    if words and not seen:
        seen.append(words)
        log.warning(f"{words} while timing; confidence intervals are wider")
