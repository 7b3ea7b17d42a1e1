"""Kills Dask workers, and the scheduler, while they run tasks, and checks that no result is lost, doubled or other.

    .venv/bin/python -m tools.kill_workers [--tasks 2000] [--kills 30] [--workers 4]

docs/many-machines.md has what it printed.  Needs the extra dask.
"""

import argparse
import random
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from socket import socket
from tempfile import TemporaryDirectory

import psutil

from tumble.compare.run.cluster.connecting import connected
from tumble.compare.run.execution import Execution, executing
from tumble.compare.run.running_engines import RunningEngine, launched
from tumble.compare.run.task_cache import TaskCache, apart_from_times
from tumble.compare.run.tasks import Task, run
from tumble.scenarios.read import read_scene

SCENE = read_scene("two-hits")


def free_port() -> int:
    """Return a port of this machine that nobody listens on."""
    with socket() as listening:
        listening.bind(("127.0.0.1", 0))
        return listening.getsockname()[1]


@contextmanager
def scheduler_and_workers(count: int, folder: Path) -> Iterator[tuple[str, subprocess.Popen, list[subprocess.Popen]]]:
    """Start a scheduler and workers as a user does, each worker with a nanny that starts it again; with its address."""
    dask = [sys.executable, "-m", "distributed.cli"]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "cwd": folder}
    port = free_port()
    address = f"127.0.0.1:{port}"
    scheduler = subprocess.Popen(
        [*dask[:2], "distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", str(port), "--no-dashboard"],
        **quiet,
    )
    words = [
        *dask[:2], "distributed.cli.dask_worker", address, "--nthreads", "1", "--memory-limit", "0", "--no-dashboard",
        "--host", "127.0.0.1",
    ]  # fmt: skip
    nannies = [subprocess.Popen(words, **quiet) for _ in range(count)]
    try:
        yield address, scheduler, nannies
    finally:
        for process in (*nannies, scheduler):
            process.send_signal(signal.SIGTERM)
        for process in (*nannies, scheduler):
            try:
                process.wait(5)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


def workers_of(nannies: list[subprocess.Popen]) -> list[psutil.Process]:
    """Return the processes of workers: the largest child of each nanny."""
    found = []
    for nanny in nannies:
        try:
            children = psutil.Process(nanny.pid).children()
            found += [max(children, key=lambda child: child.memory_info().rss)] if children else []
        except psutil.NoSuchProcess:
            continue
    return found


def tasks_of(engine: RunningEngine, count: int) -> list[Task]:
    """Return runs of one scene at as many steps."""
    asks = [
        partial(RunningEngine.simulate, scene=SCENE, method="rk4", dt=SCENE.step / (1 + number / 100))
        for number in range(count)
    ]
    return [Task((SCENE.name, engine.title, "rk4", str(n)), engine, ask) for n, ask in enumerate(asks)]


def check(name: str, count: int, workers: int, kills: int, end_scheduler: bool, expected: TaskCache) -> bool:
    """Run all tasks on a cluster while its processes are killed; return whether no result suffered.

    expected: has the results of `run_here`
    """
    finished: list[str] = []
    killed: list[int] = []
    with TemporaryDirectory() as place, scheduler_and_workers(workers, Path(place)) as (address, scheduler, nannies):
        cache, done = TaskCache(Path(place) / "cache"), threading.Event()

        def kill() -> None:
            for number in range(kills):
                while len(finished) < count * (number + random.random()) / (kills + 1) and not done.is_set():
                    time.sleep(0.05)
                while not (alive := workers_of(nannies)) and not done.is_set():
                    time.sleep(0.05)
                if alive:
                    victim = random.choice(alive)
                    victim.kill()
                    killed.append(victim.pid)
            while end_scheduler and len(finished) < count / 2:
                time.sleep(0.05)
            if end_scheduler:
                scheduler.kill()

        with launched(["tumble:rk4"]) as (engine,), connected(address) as cluster:
            cluster.client.wait_for_workers(workers, timeout=120)
            begun = time.monotonic()
            killer = threading.Thread(target=kill, daemon=True)
            killer.start()
            tasks = tasks_of(engine, count)
            with executing(Execution((cache,), work=cluster.work)):
                run(tasks, finished=lambda key, _: finished.append(key[-1]))
            done.set()
            killer.join(10)
        took = time.monotonic() - begun
        files = {path.name: path for path in cache.folder.iterdir()}
        same = all(apart_from_times(files[path.name]) == apart_from_times(path) for path in expected.folder.iterdir())
    once = sorted(finished, key=int) == [str(number) for number in range(count)]
    said = f"{len(killed)} workers killed" + " and the scheduler" * end_scheduler
    print(f"{name}: {count} tasks in {took:.0f} s, {said}; each once: {once}; equal: {same}")  # noqa: T201
    return once and same and len(killed) == kills


def run_here(count: int, cache: TaskCache) -> None:
    """Run all tasks in this process and its engine, and save their results."""
    with launched(["tumble:rk4"]) as (engine,), executing(Execution((cache,))):
        run(tasks_of(engine, count))


def main() -> int:
    """Run all checks; return 1 if one fails."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--tasks", type=int, default=2000)
    parser.add_argument("--kills", type=int, default=30)
    parser.add_argument("--workers", type=int, default=4)
    parser.add_argument("--skip-no-kill", action="store_true", help="leave out the run without kills")
    asked = parser.parse_args()
    with TemporaryDirectory() as place:
        expected = TaskCache(Path(place) / "cache")
        begun = time.monotonic()
        run_here(asked.tasks, expected)
        print(f"here: {asked.tasks} tasks in {time.monotonic() - begun:.0f} s")  # noqa: T201
        checks = [
            asked.skip_no_kill or check("no kill", asked.tasks, asked.workers, 0, False, expected),
            check("workers", asked.tasks, asked.workers, asked.kills, False, expected),
            check("scheduler", asked.tasks, asked.workers, 0, True, expected),
        ]
    return int(not all(checks))


if __name__ == "__main__":
    sys.exit(main())
