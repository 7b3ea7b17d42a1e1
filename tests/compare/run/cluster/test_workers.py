"""Tasks on the workers of a Dask cluster, real ones on this machine: results, dead workers, versions, settings."""

import multiprocessing
import os
import signal
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any
from urllib.request import urlopen

import pytest

from tumble.compare.comparison.in_parts import ensemble_runs
from tumble.compare.run.cluster import connecting, on_worker
from tumble.compare.run.cluster.connecting import connected
from tumble.compare.run.cluster.on_worker import BadCluster
from tumble.compare.run.cluster.sending import Sending
from tumble.compare.run.digest import digest
from tumble.compare.run.execution import Execution, executing
from tumble.compare.run.flight import Trajectory
from tumble.compare.run.running_engines import RunningEngine, launched
from tumble.compare.run.status import Failure
from tumble.compare.run.task_cache import TaskCache
from tumble.compare.run.tasks import Task, run
from tumble.compare.run.truths import Answer, Truths
from tumble.scenarios import ensemble
from tumble.scenarios.read import CATALOGUE, read_document, read_scene, scene_of_document

ENGINE = """
METHODS = ("still",)
FEATURES = {"gravity", "drag"}
ABOUT = {"version": "1", "precision": "double", "switched_off": []}
def build(scene, method): return {}
def write(world, states): world["states"] = states
def advance(world, n, dt): world["states"][:, 0:3] += n * dt * world["states"][:, 7:10]
def read(world): return world["states"]
"""
SCENE = read_scene("die-straight")


@pytest.fixture(scope="module")
def workers():
    with connected(None, 2) as found:
        yield found


@pytest.fixture
def engine(tmp_path):
    (tmp_path / "mine.py").write_text(ENGINE)
    with launched([str(tmp_path / "mine.py")]) as (running_engine,):
        yield running_engine


def where(able: RunningEngine, number: int, answer: "Answer") -> tuple[int, int, float]:
    """Return the number, the process, and the last height of the reference solution that was waited for."""
    return number, os.getpid(), float(answer.result().truth.states[-1, 0, 1])  # pyright: ignore


def fatal(able: RunningEngine, home: int, log: Path, most: int) -> Trajectory | Failure:
    """End the process unless it is the one at home, or as many have been ended."""
    if os.getpid() != home and (not log.exists() or len(log.read_text().split()) < most):
        with log.open("a") as file:
            print(os.getpid(), file=file)
        os._exit(3)
    return able.simulate(SCENE, "still", SCENE.step)


def fatal_at_second_run(able: RunningEngine, log: Path) -> Trajectory | Failure:
    with log.open("a") as file:
        print(os.getpid(), file=file)
    if len(log.read_text().split()) == 2:
        os._exit(3)
    return able.simulate(SCENE, "still", SCENE.step)


def failing(able: RunningEngine, log: Path) -> int:
    with log.open("a") as file:
        print(os.getpid(), file=file)
    raise ValueError("a mistake in a task")


def tasks_of(engine: RunningEngine, truths: Truths, count: int) -> list[Task]:
    return [
        Task(("die-straight", "mine", str(number)), engine, partial(where, number=number, answer=truths.futures[0]))
        for number in range(count)
    ]


def simulating(engine: RunningEngine) -> Task:
    return Task(
        ("die-straight", "mine", "still"),
        engine,
        partial(RunningEngine.simulate, scene=SCENE, method="still", dt=SCENE.step),
    )


def test_workers_answer_in_order_and_what_they_answer_is_saved_at_home(workers, engine, tmp_path):
    cache = TaskCache(tmp_path / "cache")
    with Truths([SCENE]) as truths, executing(Execution((cache,), work=workers.work)):
        found = run(tasks_of(engine, truths, 12), truths)
        again = run(tasks_of(engine, truths, 12), truths)
        height = truths.futures[0].result().truth.states[-1, 0, 1]
    assert [number for number, _, _ in found] == [*range(12)]
    processes = {pid for _, pid, _ in found}
    assert os.getpid() not in processes
    assert len(processes) == 2
    assert {seen for _, _, seen in found} == {height}
    assert again == found
    assert len([*(tmp_path / "cache").iterdir()]) == 12
    with executing(Execution(work=workers.work)):
        (there,) = run([simulating(engine)])
    (here,) = run([simulating(engine)])
    assert there.vertices.tobytes() == here.vertices.tobytes()


def test_own_workers_have_one_thread_and_no_memory_limit_of_dask_and_link_their_dashboard(workers):
    def limit(dask_worker: Any) -> tuple[int, int | None]:
        return dask_worker.state.nthreads, dask_worker.memory_manager.memory_limit

    assert {*workers.client.run(limit).values()} == {(1, None)}
    assert {*workers.client.run(lambda dask_worker: dask_worker.memory_manager.memory_limit, nanny=True).values()} == {
        None
    }
    with urlopen(connecting.dashboard_of(workers.client), timeout=20) as page:
        assert b"Dask" in page.read()


def test_a_task_that_fails_is_run_once(workers, engine, tmp_path):
    task = Task(("die-straight", "mine", "still"), engine, partial(failing, log=tmp_path / "log"))
    with executing(Execution(work=workers.work)), pytest.raises(ValueError, match="a mistake in a task"):
        run([task])
    assert len((tmp_path / "log").read_text().split()) == 1


def test_a_forced_ensemble_needs_no_process_that_a_worker_may_not_start(workers, engine, monkeypatch):
    """A worker is a daemon, which multiprocessing allows no children (distributed.worker.daemon)."""
    assert all(workers.client.run(lambda: multiprocessing.current_process().daemon).values())
    monkeypatch.setattr(ensemble, "TOGETHER", 5)
    document = read_document(CATALOGUE / "many-throws.toml", "many-throws")
    document |= {"duration": 0.02, "times": [0.02], "drag": {"linear": 0.3, "angular": 0.02}}
    document["ensemble"]["throws"] = 6
    scene = scene_of_document(document, Path("forced.toml"), "forced", in_parts=True)
    (here,) = ensemble_runs([engine], scene)
    with executing(Execution(work=workers.work)):
        (there,) = ensemble_runs([engine], scene)
    assert (here.spread.known, here.spread.status) == (6, "ok")
    assert here.spread.worst_m[0] > 0
    assert digest(replace(there.spread, wall_s=0.0)) == digest(replace(here.spread, wall_s=0.0))


@pytest.mark.parametrize(("most", "kills"), [(99, 3), (2, 2)], ids=["deadly", "killed twice"])
def test_a_task_that_ends_every_worker_is_a_row_and_its_neighbours_are_run(most, kills, workers, engine, tmp_path):
    log = tmp_path / "log"
    ending = Task(("two-hits", "mine", "ending"), engine, partial(fatal, home=os.getpid(), log=log, most=most))
    with Truths([SCENE]) as truths, executing(Execution(work=workers.work)):
        found: list = run([*tasks_of(engine, truths, 60), ending, *tasks_of(engine, truths, 30)], truths)
    result = found.pop(60)
    assert [number for number, _, _ in found] == [*range(60), *range(30)], "also those of its batch"
    assert len(set(log.read_text().split())) == kills, "whatever failures the scheduler allows"
    if kills == most:
        assert isinstance(result, Trajectory), "someone else may have killed the workers"
    else:
        assert str(result) == "crashed: 3 workers ended while they ran it"


def test_results_that_ended_with_their_worker_are_asked_for_again(workers, engine, monkeypatch):
    from patience import until  # workers, which import this file, do not find it

    workers.client.wait_for_workers(2)  # a test before may have ended one
    taken, ended = Sending._results, []

    def after_its_workers_ended(sending: Sending, future: Any) -> Any:
        if not ended:
            ended.extend(workers.client.run(os.getpid).values())
            for process in ended:
                os.kill(process, signal.SIGKILL)
            until(lambda: future.status in ("lost", "error"))  # also made again by the second, just before it ended
        return taken(sending, future)

    monkeypatch.setattr(Sending, "_results", after_its_workers_ended)
    with Truths([SCENE]) as truths, executing(Execution(work=workers.work)):
        found: list = run(tasks_of(engine, truths, 30), truths)
    assert [number for number, _, _ in found] == [*range(30)]
    assert len(ended) == 2
    assert os.getpid() not in {process for _, process, _ in found}, "the scheduler is not gone"


def test_a_worker_that_ends_while_it_makes_lost_results_again_is_one_that_ended_with_the_task(
    workers, engine, monkeypatch, tmp_path
):
    """The results are there, their worker ends before they are fetched, and the next worker ends too."""
    from patience import until  # workers, which import this file, do not find it

    workers.client.wait_for_workers(2)
    runs = tmp_path / "runs"

    class SeenBefore:
        def __init__(self, future: Any) -> None:
            self.status, self.key, self.result = future.status, future.key, future.result

    taken, seen = Sending._results, []

    def after_its_worker_ended(sending: Sending, future: Any) -> Any:
        if not seen:
            seen.append(SeenBefore(future))
            (ran,) = runs.read_text().split()
            os.kill(int(ran), signal.SIGKILL)
            until(lambda: future.status in ("lost", "error"))
            future = seen[0]
        return taken(sending, future)

    monkeypatch.setattr(Sending, "_results", after_its_worker_ended)
    task = Task(("die-straight", "mine", "still"), engine, partial(fatal_at_second_run, log=runs))
    with executing(Execution(work=workers.work)):
        (found,) = run([task])
    assert seen[0].status == "finished"
    assert isinstance(found, Trajectory)
    assert len(set(runs.read_text().split())) == 3, "each in another worker, none of them at home"
    assert str(os.getpid()) not in runs.read_text().split()


def test_commands_that_share_workers_leave_each_others_tasks_and_engines_alone(workers, tmp_path):
    from patience import until  # workers, which import this file, do not find it

    slow, go, begun = (tmp_path / name for name in ("slow.py", "go", "begun"))
    waiting = f"""
def build(scene, method):
    import os, pathlib, time
    with open({str(begun)!r}, "a") as file: print(os.getppid(), file=file)
    while not pathlib.Path({str(go)!r}).exists(): time.sleep(0.01)
    return {{}}
"""
    slow.write_text(ENGINE.replace("def build(scene, method): return {}", waiting))
    workers.client.wait_for_workers(2)  # a test before may have ended one
    address = workers.client.scheduler.address
    with (
        launched([str(slow)]) as (engine,),
        connected(address) as one,
        connected(address) as other,
        ThreadPoolExecutor(2) as beside,
    ):
        same = [beside.submit(each.work, [simulating(engine)]) for each in (one, other)]
        until(lambda: begun.exists() and len(begun.read_text().split()) == 2)
        with connected(address):
            pass  # a third one that ends
        go.touch()
        assert [type(each.result()[0]) for each in same] == 2 * [Trajectory]
    assert len(set(begun.read_text().split())) == 2, "each has an engine of its own"


def test_a_worker_with_another_version_is_refused(workers, engine, monkeypatch):
    monkeypatch.setattr(on_worker, "here", lambda: (("numpy", "0.1"),))
    with (
        executing(Execution(work=workers.work)),
        pytest.raises(BadCluster, match=r"worker tcp://127\.0\.0\.1:\d+ has numpy .*, here is 0\.1"),
    ):
        run([simulating(engine)])
    monkeypatch.undo()
    Path(engine.engine).write_text(ENGINE.replace('"1"', '"2"'))
    with executing(Execution(work=workers.work)), pytest.raises(BadCluster, match="another mine than here: version 2"):
        run([simulating(engine)])
