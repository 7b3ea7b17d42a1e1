"""Sends very many simulated tasks through the runner: time of each, and the memory that all of them take.

    .venv/bin/python -m tools.many_tasks [--tasks 1000000] [--cache] [--workers 2]

A simulated task returns its number and asks no engine: what is measured is the runner.  docs/many-machines.md has what
it printed.
"""

import argparse
import resource
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

from tumble.compare.run.cluster.connecting import connected
from tumble.compare.run.execution import Execution, executing
from tumble.compare.run.running_engines import RunningEngine, launched
from tumble.compare.run.task_cache import TaskCache
from tumble.compare.run.tasks import Task, stream


def answer(running_engine: RunningEngine, number: int) -> int:
    """Return the number of a task."""
    return number


def tasks_of(engine: RunningEngine, count: int) -> Iterator[Task[int]]:
    """Yield simulated tasks."""
    for number in range(count):
        yield Task(("simulated", engine.title, str(number)), engine, partial(answer, number=number))


def peaks() -> str:
    """Say the peak memory of this process, and of the largest one that it started and that has ended [MB]."""
    own, others = (resource.getrusage(who).ru_maxrss for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return f"peak {own / 1000:.0f} MB, of what it started {others / 1000:.0f} MB"


def run_all(engine: RunningEngine, count: int) -> tuple[float, float, bool]:
    """Return wall and processor time of each task [ms], and whether every result came once and in order."""
    begun, begun_cpu, expected = time.monotonic(), time.process_time(), 0
    for _, number in stream(tasks_of(engine, count)):
        if number != expected:
            return 0.0, 0.0, False
        expected += 1
    return 1e3 * (time.monotonic() - begun) / count, 1e3 * (time.process_time() - begun_cpu) / count, expected == count


def main() -> int:
    """Run a tenth and then all of the tasks; return 1 if a result is missing."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--tasks", type=int, default=1_000_000)
    parser.add_argument("--cache", action="store_true", help="save every result")
    parser.add_argument("--workers", type=int, help="Dask workers")
    asked = parser.parse_args()
    right = True
    for count in (asked.tasks // 10, asked.tasks):
        with ExitStack() as stack:
            caches = (TaskCache(Path(stack.enter_context(TemporaryDirectory()))),) if asked.cache else ()
            work = stack.enter_context(connected(None, asked.workers)).work if asked.workers else None
            (engine,) = stack.enter_context(launched(["tumble:rk4"]))
            stack.enter_context(executing(Execution(caches, work=work)))
            wall, cpu, is_right = run_all(engine, count)
        print(f"{count} tasks: {wall:.3f} ms each, {cpu:.3f} ms processor time, {peaks()}")  # noqa: T201
        right = right and is_right
    return int(not right)


if __name__ == "__main__":
    sys.exit(main())
