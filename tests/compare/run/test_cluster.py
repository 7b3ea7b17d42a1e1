"""Tasks on the workers of a Dask cluster, real ones on this machine: results, dead workers, versions, addresses."""

import logging
import os
import subprocess
from functools import partial
from pathlib import Path
from urllib.request import urlopen

import pytest
from dask import config
from distributed import LocalCluster
from distributed.security import Security

from tumble.compare.run import cluster, on_worker
from tumble.compare.run.cluster import BadCluster, check_address, connected
from tumble.compare.run.execution import Execution, executing
from tumble.compare.run.flight import Trajectory
from tumble.compare.run.running_engines import RunningEngine, launched
from tumble.compare.run.status import Failure
from tumble.compare.run.task_cache import TaskCache
from tumble.compare.run.tasks import Task, run
from tumble.compare.run.truths import Answer, Truths
from tumble.scenarios.read import read_scene

ENGINE = """
METHODS = ("still",)
FEATURES = {"gravity"}
ABOUT = {"version": "1", "precision": "double", "switched_off": []}
def build(scene, method): return {}
def write(world, states): world["states"] = states
def advance(world, n, dt): world["states"][:, 0:3] += n * dt * world["states"][:, 7:10]
def read(world): return world["states"]
"""
SCENE = read_scene("die-straight")


@pytest.mark.parametrize(
    ("address", "tls", "said"),
    [
        ("10.0.0.1:8786", {}, "give|use tls"),
        ("tcp://node:8786", {"ca": "a", "cert": "b", "key": "c"}, "use tls"),
        ("tls://node:8786", {"ca": "a"}, "give --tls-ca, --tls-cert and --tls-key"),
        ("http://127.0.0.1:8786", {}, "must be HOST:PORT"),
        ("127.0.0.1", {}, "must be HOST:PORT"),
        ("127.0.0.1:x", {}, "must be HOST:PORT"),
    ],
)
def test_an_address_that_others_could_reach_needs_encryption(address, tls, said):
    with pytest.raises(BadCluster, match=said):
        check_address(address, tls, False)
    for safe in ("127.0.0.1:8786", "tcp://localhost:1", "[::1]:8786"):
        check_address(safe, {}, False)
    check_address("tcp://10.0.0.1:8786", {}, True)
    check_address("tls://node:8786", {"ca": "a", "cert": "b", "key": "c"}, False)


@pytest.fixture(scope="module")
def workers():
    with connected(None, 2, {}) as found:
        yield found


@pytest.fixture
def engine(tmp_path):
    (tmp_path / "mine.py").write_text(ENGINE)
    with launched([str(tmp_path / "mine.py")]) as (running_engine,):
        yield running_engine


def where(able: RunningEngine, number: int, answer: "Answer") -> tuple[int, int, float]:
    """Return the number, the process, and the last height of the reference solution that was waited for."""
    return number, os.getpid(), float(answer.result().truth.states[-1, 0, 1])  # pyright: ignore


def fatal(able: RunningEngine, home: int, log: Path) -> Trajectory | Failure:
    """End the process unless it is the one at home."""
    if os.getpid() != home:
        with log.open("a") as file:
            print(os.getpid(), file=file)
        os._exit(3)
    return able.simulate(SCENE, "still", SCENE.step)


def tasks_of(engine: RunningEngine, truths: Truths, count: int) -> list[Task]:
    return [
        Task(("die-straight", "mine", str(number)), engine, partial(where, number=number, answer=truths.futures[0]))
        for number in range(count)
    ]


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
    simulate = partial(RunningEngine.simulate, scene=SCENE, method="still", dt=SCENE.step)
    task = Task(("die-straight", "mine", "still"), engine, simulate)
    with executing(Execution(work=workers.work)):
        (there,) = run([task])
    (here,) = run([task])
    assert there.vertices.tobytes() == here.vertices.tobytes()


def test_a_task_that_ends_two_workers_is_a_row_and_the_others_are_run(workers, engine, tmp_path):
    with Truths([SCENE]) as truths, executing(Execution(work=workers.work)):
        deadly = Task(("two-hits", "mine", "fatal"), engine, partial(fatal, home=os.getpid(), log=tmp_path / "log"))
        found: list = run([*tasks_of(engine, truths, 60), deadly, *tasks_of(engine, truths, 30)], truths)
    assert str(found.pop(60)) == "crashed: 2 workers ended while they ran it"
    assert [number for number, _, _ in found] == [*range(60), *range(30)], "also those of its batch"
    assert len(set((tmp_path / "log").read_text().split())) == 2, "whatever failures the scheduler allows"


def test_a_worker_with_another_version_is_refused(workers, engine, monkeypatch):
    task = Task(
        ("die-straight", "mine", "still"), engine, partial(RunningEngine.simulate, scene=SCENE, method="still", dt=0.01)
    )
    monkeypatch.setattr(on_worker, "here", lambda: (("numpy", "0.1"),))
    with (
        executing(Execution(work=workers.work)),
        pytest.raises(BadCluster, match=r"a worker has numpy .*, here is 0\.1"),
    ):
        run([task])
    monkeypatch.undo()
    Path(engine.engine).write_text(ENGINE.replace('"1"', '"2"'))
    with executing(Execution(work=workers.work)), pytest.raises(BadCluster, match="another mine than here: version 2"):
        run([task])


def certificates(folder: Path) -> dict[str, str]:
    """Make an authority, and a certificate and key that it signed."""
    folder.mkdir()
    made = [
        "openssl",
        "req",
        "-x509",
        "-nodes",
        "-newkey",
        "ec",
        "-pkeyopt",
        "ec_paramgen_curve:prime256v1",
        "-days",
        "2",
    ]
    signed = ["-CA", "ca.pem", "-CAkey", "ca-key.pem"]
    for words in (
        [*made, "-subj", "/CN=authority", "-keyout", "ca-key.pem", "-out", "ca.pem"],
        [*made, "-subj", "/CN=tumble", "-keyout", "key.pem", "-out", "cert.pem", *signed],
    ):
        subprocess.run(words, cwd=folder, check=True, capture_output=True)
    return {name: str(folder / f"{name}.pem") for name in ("ca", "cert", "key")}


def test_a_cluster_over_tls_runs_tasks_for_who_has_its_certificates(engine, tmp_path, monkeypatch):
    ours, others = certificates(tmp_path / "ours"), certificates(tmp_path / "others")
    files = {f"tls_{role}_{end}": ours[end] for role in ("scheduler", "worker", "client") for end in ("cert", "key")}
    security = Security(tls_ca_file=ours["ca"], require_encryption=True, **files)
    monkeypatch.setattr(cluster, "CONNECT_S", 3)
    with (
        config.set(cluster.SETTINGS),
        LocalCluster(
            n_workers=1, threads_per_worker=1, protocol="tls", security=security, host="127.0.0.1",
            dashboard_address="127.0.0.1:0", silence_logs=logging.CRITICAL,
        ) as made,
    ):  # fmt: skip
        address = made.scheduler_address
        assert address.startswith("tls://127.0.0.1:")
        with (
            connected(address, None, ours) as secure,
            Truths([SCENE]) as truths,
            executing(Execution(work=secure.work)),
        ):
            found = run(tasks_of(engine, truths, 3), truths)
        assert [number for number, _, _ in found] == [0, 1, 2]
        assert {pid for _, pid, _ in found}.isdisjoint({os.getpid()})
        for refused in (others, {**ours, "cert": others["cert"], "key": others["key"]}):
            with pytest.raises(BadCluster, match="cannot be reached"), connected(address, None, refused):
                pass
        with pytest.raises(BadCluster, match="cannot be reached"), connected(address.replace("tls", "tcp"), None, {}):
            pass


def test_the_dashboard_is_linked_only_where_it_is_served(workers):
    with urlopen(workers.client.dashboard_link, timeout=5) as page:
        is_served = b"needs bokeh" not in page.read()
    assert workers.client.run_on_scheduler(cluster.has_dashboard()) is is_served
