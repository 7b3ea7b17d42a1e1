"""Forks begin sooner than processes do, and are as well apart: session, lifeline, limits, folder, standard error."""

import os
import signal
import socket
import subprocess
import sys

import psutil
import pytest
from patience import PATIENCE_S, until

from tests.attack.left_running import carrying, gone
from tumble.compare.run.flight import Trajectory
from tumble.compare.run.process import forks
from tumble.compare.run.process.caller import Caller
from tumble.compare.run.process.child import Spawned
from tumble.compare.run.process.process import Died, Process
from tumble.compare.run.worker import Worker
from tumble.scenarios.read import read_scene

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="no forks elsewhere")


@pytest.fixture
def caller():
    made = Caller()
    yield made
    made.end()


def in_fork(caller: Caller, expression: str) -> object:
    """Return what an expression is there, of what any process can import."""
    return caller.submit(eval, expression).result()


def parent_of(pid: int) -> psutil.Process:
    """The process that started one: of a fork, its server."""
    found = psutil.Process(pid).parent()
    assert found is not None
    return found


def test_forks_have_one_server_and_sessions_of_their_own(caller):
    other = Caller()
    pids = [in_fork(each, "__import__('os').getpid()") for each in (caller, other)]
    assert isinstance(pids[0], int)
    assert isinstance(pids[1], int)
    server = parent_of(pids[0])
    assert server == parent_of(pids[1])
    assert server.pid != os.getpid()
    assert len({os.getsid(pid) for pid in (*pids, server.pid, os.getpid())}) == 4
    assert in_fork(caller, "'numpy' in __import__('sys').modules")
    other.end()
    assert server.is_running()
    caller.end()
    assert not server.is_running(), "the last fork has ended"


def test_a_fork_is_where_its_parent_is(caller, tmp_path, monkeypatch, capfd):
    here = in_fork(caller, "1")
    assert here == 1
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("OF_THE_PARENT", "now")
    cores = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {min(cores)})
    later = Caller()
    try:
        assert in_fork(later, "__import__('os').getcwd()") == str(tmp_path)
        assert in_fork(later, "__import__('os').environ['OF_THE_PARENT']") == "now"
        assert in_fork(later, "__import__('os').sched_getaffinity(0)") == {min(cores)}
        in_fork(later, "__import__('os').write(2, b'said there')")
        assert "said there" in capfd.readouterr().err
    finally:
        os.sched_setaffinity(0, cores)
        later.end()


def test_ends_of_forks_are_seen():
    for call, code in (((os._exit, 7), 7), ((os.abort,), -signal.SIGABRT)):
        made = Caller()
        with pytest.raises(Died):
            made.submit(*call).result()
        assert made._process is not None
        assert made._process.end(PATIENCE_S) == code
    made = Caller()
    made.submit(eval, "len(bytearray(200 << 20))").result()
    process = made._process
    assert process is not None
    made.end()
    assert process.peak_bytes > 200 << 20
    assert process.peak_is_its_own


def test_a_memory_limit_holds_in_a_fork():
    with Worker("tumble", 60.0, 1 << 30) as worker:
        worker.describe()
        assert worker._process is not None
        limit = psutil.Process(worker._process._process.pid).rlimit(psutil.RLIMIT_DATA)  # type: ignore[attr-defined]
    assert limit == (1 << 30, 1 << 30)


def test_what_a_file_of_a_user_does_is_done_in_no_fork(tmp_path):
    (tmp_path / "mine.py").write_text("raise SystemExit('not now')")
    with Worker(str(tmp_path / "mine.py"), 60.0) as worker:
        assert worker._process is not None
        assert not isinstance(worker._process._process, forks.Fork)


def test_without_its_server_a_fork_works_and_the_next_has_another(caller):
    pid = in_fork(caller, "__import__('os').getpid()")
    assert isinstance(pid, int)
    server = parent_of(pid)
    server.kill()
    until(lambda: not server.is_running() or server.status() == psutil.STATUS_ZOMBIE)
    assert in_fork(caller, "1 + 1") == 2
    scene = read_scene("die-straight")
    for kind in (Spawned, forks.Fork):
        with Worker("tumble", 60.0) as worker:
            worker.describe()
            assert worker._process is not None
            assert isinstance(worker._process._process, kind)
            assert isinstance(worker.simulate(scene, "rk4", scene.step), Trajectory)
    caller.end()
    until(lambda: not psutil.pid_exists(pid) or psutil.Process(pid).status() == psutil.STATUS_ZOMBIE)


def test_where_there_is_no_server_a_process_is_started(monkeypatch):
    monkeypatch.setattr(forks, "PROGRAM", forks.PROGRAM.with_name("none.py"))
    with Worker("tumble", 60.0) as worker:
        worker.describe()
        assert worker._process is not None
        assert not isinstance(worker._process._process, forks.Fork)
        assert worker.alive


def test_a_fork_that_is_never_asked_ends_with_its_line():
    line, far = socket.socketpair()
    with far:
        fork = forks.fork((forks.CALLS,), far)
    assert fork is not None
    line.close()
    until(lambda: fork.gone)
    fork.reap()
    assert fork.returncode == 0


PARENT = """
import time
from tumble.compare.run.process.caller import Caller
from tumble.compare.run.worker import Worker
worker, caller = Worker("tumble", 60.0), Caller()
worker.describe()
caller.submit(eval, "__import__('os').fork()").result()
print("begun", flush=True)
caller.submit(time.sleep, 6000).result()
"""


@pytest.mark.parametrize("how", ["SIGKILL", "SIGTERM"])
def test_server_and_forks_end_with_their_parent(tmp_path, how):
    mark = f"OF_THIS_TEST={tmp_path.name}-{os.getpid()}"
    environment = os.environ | dict([mark.split("=")])
    command = [sys.executable, "-P", "-c", PARENT]
    with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True) as parent:
        assert parent.stdout is not None
        assert parent.stdout.readline() == "begun\n"
        assert len(carrying(mark)) >= 5, "parent, server, engine, caller and its fork"
        parent.send_signal(signal.Signals[how])
    gone(lambda: carrying(mark))


def test_a_process_can_still_be_started_as_a_command():
    started = Process([sys.executable, "-c", "import sys; sys.exit(3)"], {})
    assert started.end(PATIENCE_S) == 3
