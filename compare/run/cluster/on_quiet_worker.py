"""What runs on a worker of a cluster that does nothing else: all contestants of a scene are timed in one task.

Their engines are started for the task, all on one core, and end with it.
"""

import os
import platform
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace

import psutil

from tumble.compare.run.cluster.on_worker import Needed, end_engines, engine_of, one_at_a_time
from tumble.compare.run.process.message import frame
from tumble.compare.run.provenance import processor
from tumble.compare.run.status import Failure
from tumble.compare.run.timing import machine_load
from tumble.compare.run.timing.readings import Sampling
from tumble.compare.run.timing.timing import Cost, costs


@dataclass(frozen=True)
class Measured:
    """What a quiet worker measured.

    costs: by the keys of the loads; where: the machine; under: the core, and the load average before and after.
    """

    costs: dict[str, Cost | Failure]
    where: str
    under: str


def measure(needed: Mapping[str, Needed], loads: bytes, sampling: Sampling) -> bytes:
    """On a quiet worker: return what each load costs, as a frame of `Measured`.  Raises BadCluster.

    needed: engines by their titles; loads: by their keys, each with a title in place of the engine.
    """
    import cloudpickle

    with one_at_a_time, pinned() as core:
        end_engines()  # those of other tasks are not on this core
        try:
            engines = {title: engine_of(one) for title, one in needed.items()}
            asked = {
                key: replace(load, running_engine=engines[title])
                for key, (title, load) in cloudpickle.loads(loads).items()
            }
            machine_load.seen.clear()
            before = psutil.getloadavg()[0]
            found = costs(asked, sampling)
            load = f"load average {before:.2f} before, {psutil.getloadavg()[0]:.2f} after"
            return b"".join(frame(Measured(found, where(), ", ".join((core, load, *machine_load.seen)))))
        finally:
            end_engines()


def where() -> str:
    """Return what tells a machine from others."""
    return f"{platform.node()} ({processor()}, {os.cpu_count()} cores)"


@contextmanager
def pinned() -> Iterator[str]:
    """Run this thread, and the processes that it starts in the block, on one core where the system can do that."""
    if not hasattr(os, "sched_setaffinity"):
        yield "not pinned to a core"
        return
    cores = os.sched_getaffinity(0)
    core = max(cores)  # the first one often has the interrupts
    os.sched_setaffinity(0, {core})
    try:
        yield f"pinned to core {core}"
    finally:
        os.sched_setaffinity(0, cores)
