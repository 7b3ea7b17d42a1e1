"""Run times measured on the quiet worker of a real Dask cluster, and here where there is none."""

import logging
import os

import pytest
from distributed import Client, Nanny, Scheduler, SpecCluster

from tumble.compare.run.cluster.quiet import QuietWorkers
from tumble.compare.run.execution import Execution, executing
from tumble.compare.run.provenance import conditions
from tumble.compare.run.running_engines import launched
from tumble.compare.run.task_cache import TaskCache
from tumble.compare.run.timing import machine_load
from tumble.compare.run.timing.readings import Sampling
from tumble.compare.run.timing.timing import Cost, Load, costs
from tumble.scenarios.read import read_scene

# Leaves the process that started it and its cores; ends that process as often as asked, unless it is the home process.
ENGINE = """
import os
import signal
from pathlib import Path
METHODS = ("still",)
FEATURES = {"gravity"}
ABOUT = {"version": "1", "precision": "double", "switched_off": []}
HERE = Path(__file__).parent
def build(scene, method):
    with (HERE / "built").open("a") as file:
        print(os.getppid(), *sorted(os.sched_getaffinity(0)), file=file)
    left = int((HERE / "kills").read_text())
    if left and os.getppid() != int((HERE / "home").read_text()):
        (HERE / "kills").write_text(str(left - 1))
        os.kill(os.getppid(), signal.SIGKILL)
    return {}
def write(world, states): world["states"] = states
def advance(world, n, dt):
    for _ in range(n): world["states"][:, 0:3] += dt * world["states"][:, 7:10]
def read(world): return world["states"]
"""
SCENE = read_scene("two-hits")
BRIEF = Sampling(span_s=0.0, rounds=4, budget_s=0.0)


@pytest.fixture(scope="module")
def scheduler():
    """Start two workers, the second of which is quiet."""
    spec = {
        name: {"cls": Nanny, "options": {"nthreads": 1, "memory_limit": 0, "host": "127.0.0.1", "resources": resources}}
        for name, resources in enumerate(({}, {"quiet": 1}))
    }
    options = {"host": "127.0.0.1", "port": 0, "dashboard": False}
    with (
        SpecCluster(spec, {"cls": Scheduler, "options": options}, silence_logs=logging.CRITICAL) as made,
        Client(made, set_as_default=False) as client,
    ):
        client.wait_for_workers(2, timeout=60)
        yield client


@pytest.fixture
def measured(scheduler, tmp_path):
    """Measure two contestants on the cluster, which ends so many quiet workers first."""
    (tmp_path / "mine.py").write_text(ENGINE)
    (tmp_path / "home").write_text(str(os.getpid()))

    def measure(kills: int) -> tuple[dict, list[list[int]]]:
        (tmp_path / "kills").write_text(str(kills))
        (tmp_path / "built").write_text("")
        machine_load.measured.clear()
        execution = Execution((TaskCache(tmp_path / "cache"),), times=QuietWorkers(scheduler))
        with launched([str(tmp_path / "mine.py"), "tumble:rk4"]) as engines, executing(execution):
            found = costs({one.title: Load(one, SCENE, one.methods[0]) for one in engines}, BRIEF)
        return found, [[*map(int, line.split())] for line in (tmp_path / "built").read_text().splitlines()]

    return measure


def pids(client: Client) -> dict[str, int]:
    return client.run(os.getpid)  # type: ignore[return-value]


def times_row() -> str:
    return {row.what: row.value for row in conditions("")}.get(f"times of {SCENE.name}", "")


def test_a_scene_is_timed_on_one_core_of_a_quiet_worker_and_here_without_one(scheduler, measured, caplog, monkeypatch):
    caplog.set_level(logging.INFO)
    found, built = measured(kills=1)
    assert [cost for cost in found.values() if not isinstance(cost, Cost)] == []
    workers = {address: about["resources"] for address, about in scheduler.scheduler_info()["workers"].items()}
    (address,) = (address for address, resources in workers.items() if resources.get("quiet"))
    assert len({parent for parent, *_ in built}) == 2, "the worker that was ended, and its successor"
    assert built[-1][0] == pids(scheduler)[address]
    assert {parent for parent, *_ in built}.isdisjoint(
        pid for other, pid in pids(scheduler).items() if other != address
    )
    assert {tuple(cores) for _, *cores in built} == {(max(os.sched_getaffinity(0)),)}
    assert f"pinned to core {max(os.sched_getaffinity(0))}, load average" in times_row()
    assert "run times are measured on" in caplog.text

    again, built = measured(kills=0)
    assert not built, "found in the cache, of the same machine"
    assert {name: cost.reading.ns for name, cost in again.items()} == {n: c.reading.ns for n, c in found.items()}
    assert times_row()

    monkeypatch.setattr(QuietWorkers, "_workers", lambda self: [])
    found, built = measured(kills=0)
    assert {parent for parent, *_ in built} == {os.getpid()}
    assert len(found) == 2
    assert not times_row()
    assert "measured here, alone, and not on workers, for no worker has the resource quiet=1" in caplog.text
