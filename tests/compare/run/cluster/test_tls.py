"""A scheduler over TLS, a real one: tasks run on its workers for who has its certificates, and for nobody else."""

import logging
from functools import partial

import pytest
from certificates import certificates
from distributed import LocalCluster
from distributed.security import Security

from tumble.compare.run.cluster import connecting
from tumble.compare.run.cluster.connecting import connected
from tumble.compare.run.cluster.on_worker import BadCluster
from tumble.compare.run.execution import Execution, executing
from tumble.compare.run.running_engines import RunningEngine, launched
from tumble.compare.run.tasks import Task, run
from tumble.scenarios.read import read_scene

SCENE = read_scene("die-straight")


def test_a_cluster_over_tls_runs_tasks_for_who_has_its_certificates(tmp_path, monkeypatch, caplog):
    caplog.set_level(logging.INFO)
    ours, others = certificates(tmp_path / "ours"), certificates(tmp_path / "others")
    files = {f"tls_{role}_{end}": ours[end] for role in ("scheduler", "worker", "client") for end in ("cert", "key")}
    security = Security(tls_ca_file=ours["ca"], require_encryption=True, **files)
    monkeypatch.setattr(connecting, "CONNECT_S", 3)
    with LocalCluster(
        n_workers=1, threads_per_worker=1, protocol="tls", security=security, host="127.0.0.1",
        dashboard_address="127.0.0.1:0", scheduler_kwargs={"dashboard": False}, silence_logs=logging.CRITICAL,
    ) as made:  # fmt: skip
        address = made.scheduler_address
        assert address.startswith("tls://127.0.0.1:")
        ask = partial(RunningEngine.simulate, scene=SCENE, method="rk4", dt=SCENE.step)
        with launched(["tumble:rk4"]) as (engine,):
            task = Task((SCENE.name, engine.title, "rk4"), engine, ask)
            (here,) = run([task])
            with connected(address, tls=ours) as secure, executing(Execution(work=secure.work)):
                (there,) = run([task])
        assert there.vertices.tobytes() == here.vertices.tobytes()
        assert (there.wall_s, there.cpu_s) != (here.wall_s, here.cpu_s), "it ran elsewhere"
        assert f"1 worker of {address}; dashboard: none" in caplog.text
        for refused in (others, {**ours, "cert": others["cert"], "key": others["key"]}):
            with pytest.raises(BadCluster, match="cannot be reached"), connected(address, tls=refused):
                pass
        with pytest.raises(BadCluster, match="cannot be reached"), connected(address.replace("tls", "tcp")):
            pass
