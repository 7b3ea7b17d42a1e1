"""Processes that stand ready: few, whatever many pages ask for; none is left, and no throw waits for good."""

import gc
import os
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from tumble.compare.run.flight import Trajectory
from tumble.compare.run.status import Failure, Status
from tumble.lab import background, pool
from tumble.lab.background import Workers
from tumble.lab.draft import Draft
from tumble.lab.pool import Pool
from tumble.lab.session import Session
from tumble.lab.throw import Throw

THROWS, ENGINE = 24, "mujoco"
PATIENCE_S = 60.0
SLEEPS = """
import time

METHODS, FEATURES, ABOUT = ("slow",), {"gravity"}, {"version": "1"}


def build(scene, method): return scene
def write(world, states): pass
def read(world): return world.start
def advance(world, n, dt): time.sleep(0.02)
"""


def children() -> set[int]:
    """Return the processes of Python that this one has started, and theirs; a browser's are no matter of the lab."""
    parents = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                status = (entry / "stat").read_text().rpartition(")")[2].split()
                program = (entry / "exe").readlink().name
            except OSError:
                continue
            if status[0] != "Z" and program.startswith("python"):
                parents[int(entry.name)] = int(status[1])
    found = {os.getpid()}
    while more := {one for one, parent in parents.items() if parent in found} - found:
        found |= more
    return found - {os.getpid()}


def test_many_throws_at_once_are_all_answered_by_few_processes_of_which_few_stay(tmp_path, until):
    (tmp_path / "slow.py").write_text(SLEEPS, encoding="utf-8")
    scene = Draft.opened("table-4-1-ray").scene
    before = children()
    with Pool(time_limit=60.0) as engines:
        contestants = engines.ready([str(tmp_path / "slow.py"), f"{ENGINE}:euler"])
        throws = [Throw(scene, contestants, engines, lambda: None) for _ in range(THROWS)]
        most, end = 0, time.monotonic() + PATIENCE_S
        while not all(throw.is_complete for throw in throws):
            most = max(most, len(children() - before))
            assert time.monotonic() < end, "a throw was never answered"
            time.sleep(0.02)
        assert most <= 2 * pool.MOST + background.MOST + 2  # multiprocessing's own helper, and one that is just ending
        assert all(isinstance(answer, Trajectory) for throw in throws for answer in throw.answers.values())
        until(lambda: len(children() - before) <= 2 * pool.IDLE_OF_ONE + background.IDLE + 1)
    until(lambda: len(children() - before) <= 1)


@pytest.fixture
def no_collection() -> Iterator[None]:
    """Let nothing be freed by Python's cyclic garbage collector, which comes when it likes."""
    gc.collect()
    gc.disable()
    yield
    gc.enable()


def test_throw_upon_throw_leaves_no_more_processes_and_no_more_open_files(tmp_path, until, no_collection):
    with Pool(time_limit=60.0) as engines:
        contestants = engines.ready(["tumble:rk4", ENGINE])
        session = Session(Draft.opened("table-4-1-ray"), contestants, engines, tmp_path, lambda: None)
        processes, descriptors = len(children()), len(os.listdir("/proc/self/fd"))
        for number in range(THROWS):
            session.throw_own()
            if number % 3 == 0:
                until(lambda: session.throw.is_complete)
            session.reset()
        # As many of each engine as may stand idle, each with two descriptors or three, and so the workers.
        until(lambda: len(children()) <= processes + 2 * (pool.IDLE_OF_ONE - 1) + 1)
        until(lambda: len(os.listdir("/proc/self/fd")) <= descriptors + 20)
        session.close()


def test_of_the_idle_ones_those_stay_that_were_used_last(monkeypatch):
    monkeypatch.setattr(pool, "IDLE", 2)
    with Pool(time_limit=60.0) as engines:
        engines.ready(["tumble", "scipy", ENGINE])
        leases = [engines.lease(name, [""]) for name in ("tumble", "scipy", ENGINE)]
        for lease in leases:
            engines.take_back(lease)
        assert [lease.can_go_on for lease in leases] == [False, True, True]
        assert engines.lease(ENGINE, [""]) is leases[2]


def test_who_waits_for_a_process_is_given_the_next_that_is_free(monkeypatch):
    monkeypatch.setattr(pool, "MOST", 1)
    with Pool(time_limit=60.0) as engines:
        engines.ready([ENGINE])
        one = engines.lease(ENGINE, [""])
        got = []
        waiting = threading.Thread(target=lambda: got.append(engines.lease(ENGINE, [""])))
        waiting.start()
        waiting.join(0.5)
        assert got == []
        engines.take_back(one)
        waiting.join(PATIENCE_S)
        assert got == [one]


def test_who_is_not_wanted_any_more_waits_no_longer(monkeypatch):
    monkeypatch.setattr(pool, "MOST", 1)
    with Pool(time_limit=60.0) as engines:
        engines.ready([ENGINE])
        engines.lease(ENGINE, [""])
        wanted = threading.Event()
        wanted.set()
        got = []
        waiting = threading.Thread(target=lambda: got.append(engines.lease(ENGINE, [""], wanted.is_set)))
        waiting.start()
        wanted.clear()
        waiting.join(PATIENCE_S)
        assert got == [None]


def test_idle_processes_are_ended_at_the_same_time(monkeypatch):
    monkeypatch.setattr(pool, "IDLE_OF_ONE", 4)
    with Pool(time_limit=60.0) as engines:
        engines.ready([ENGINE])
        leases = [engines.lease(ENGINE, [""]) for _ in range(4)]
        together = threading.Barrier(len(leases), timeout=PATIENCE_S)
        for lease in leases:
            close = lease.close
            monkeypatch.setattr(lease, "close", lambda close=close: (together.wait(), close()))
            engines.take_back(lease)
    # Had one been ended after the other, the first would have waited for the others in vain.
    assert not together.broken


def test_what_is_not_installed_is_known_without_being_started():
    with Pool(time_limit=60.0) as engines:
        engines._not_installed["drake"] = "missing: not installed; tumble engines --install drake"
        assert "--install" in engines.why_not("drake")
        assert engines.why_not("tumble") == ""
        assert not engines.engines


def test_an_engine_that_cannot_be_started_says_why(tmp_path):
    with Pool(time_limit=60.0) as engines:
        engines._failed[ENGINE] = Failure(Status.MISSING, "no module named mujoco")
        assert engines.why_not(ENGINE) == "missing: no module named mujoco"


@pytest.fixture
def workers():
    found = Workers()
    yield found
    found.close()


def test_more_jobs_than_processes_are_done_in_turn(workers, until):
    before = children()
    jobs = [workers.send([(time.sleep, 0.05), (abs, -number)]) for number in range(3 * background.MOST)]
    most = 0
    while not all(job.futures[1].done() for job in jobs):
        most = max(most, len(children() - before))
        time.sleep(0.01)
    assert [job.futures[1].result() for job in jobs] == list(range(3 * background.MOST))
    assert most <= background.MOST + 2
    until(lambda: len(children() - before) <= background.IDLE + 1)


def test_a_job_that_waits_is_cancelled_and_the_others_are_done(workers):
    jobs = [workers.send([(time.sleep, 0.3)]) for _ in range(background.MOST + 1)]
    jobs[-1].stop()
    assert jobs[-1].futures[0].cancelled()
    for job in jobs[:-1]:
        job.futures[0].result(PATIENCE_S)


def test_what_a_call_raises_is_its_results(workers):
    (future,) = workers.send([(int, "x")]).futures
    with pytest.raises(ValueError, match="invalid literal"):
        future.result(PATIENCE_S)
