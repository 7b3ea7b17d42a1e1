"""Processes that a command's fork server makes: they are what a program would be that is started for each."""

import os
import signal
import subprocess
import sys

import numpy as np
import psutil
import pytest
from patience import PATIENCE_S, until

from tumble.compare.run.process import fork_server as module
from tumble.compare.run.process.callers import Call, Callers
from tumble.compare.run.process.fork_server import fork_server
from tumble.compare.run.status import Failure
from tumble.compare.run.worker import Worker
from tumble.scenarios.read import read_scene

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="elsewhere nothing is forked")

SCENE = read_scene("table-4-1")
HELD = """
import time
from tumble.compare.run.process.fork_server import fork_server, running
from tumble.compare.run.worker import Worker
with fork_server():
    worker = Worker("handcalc", 60.0)
    worker.describe()
    print(running[0]._process.pid, worker._process._process.pid, flush=True)
    time.sleep(6000)
"""


@pytest.fixture
def server():
    with fork_server():
        # For the test itself pytest sets this variable anew.
        module.running[0].env["PYTEST_CURRENT_TEST"] = os.environ["PYTEST_CURRENT_TEST"].replace("(setup)", "(call)")
        yield module.running[0]


def worker(engine: str = "handcalc") -> Worker:
    found = Worker(engine, PATIENCE_S)
    assert not isinstance(found.describe(), Failure)
    return found


def process_of(one: Worker) -> psutil.Process:
    assert one._process is not None
    return psutil.Process(one._process._process.pid)


def test_a_fork_answers_as_a_program_does_and_has_a_session_of_its_own(server):
    with worker() as forked, Worker("handcalc", PATIENCE_S) as other:
        assert process_of(forked).ppid() == server._process.pid
        assert process_of(forked).pid != process_of(other).pid
        assert os.getsid(process_of(forked).pid) == process_of(forked).pid
        method = forked.describe().methods[0]
        answer = forked.simulate(SCENE, method, SCENE.step)
    module.running.remove(server)
    try:
        with worker() as program:
            assert process_of(program).ppid() == os.getpid()
            same = program.simulate(SCENE, method, SCENE.step)
    finally:
        module.running.append(server)
    assert np.array_equal(answer.states, same.states)


def test_a_fork_that_dies_says_how_and_is_replaced(server):
    one = worker()
    process_of(one).send_signal(signal.SIGSEGV)
    assert str(one.simulate(SCENE, "any", SCENE.step)) == "crashed: its process was killed by SIGSEGV"
    with one.renewed() as other:
        assert not isinstance(other.describe(), Failure)
        assert process_of(other).ppid() == server._process.pid
        pid = process_of(other).pid
    assert not psutil.pid_exists(pid), "it was waited for"


def test_another_environment_and_a_users_file_start_as_programs(server, monkeypatch, tmp_path):
    path = tmp_path / "mine.py"
    path.write_text("def step(state, dt, body): return state\n")
    with worker(str(path)) as mine:
        assert process_of(mine).ppid() == os.getpid()
    monkeypatch.setenv("SET_SINCE", "1")
    with worker() as one:
        assert process_of(one).ppid() == os.getpid()
        assert process_of(one).environ()["SET_SINCE"] == "1"


def test_without_its_server_a_fork_goes_on_and_others_start_as_programs(server):
    with worker() as forked:
        os.kill(server._process.pid, signal.SIGKILL)
        until(lambda: psutil.Process(server._process.pid).status() == psutil.STATUS_ZOMBIE)
        assert not isinstance(forked.simulate(SCENE, forked.describe().methods[0], SCENE.step), Failure)
        with worker() as other:
            assert process_of(other).ppid() == os.getpid()
        pid = process_of(forked).pid
    until(lambda: not psutil.pid_exists(pid))


def test_forks_have_folder_and_clock_of_their_own(server, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    clock = "__import__('tumble.compare.run.timing.timer').compare.run.timing.timer.SCHEDULE[0]"
    seen = f"(__import__('os').getcwd(), __import__('os').pread({clock}, 64, 0).split()[2])"
    own = "open('/proc/thread-self/schedstat', 'rb').read().split()[2]"
    callers = Callers(1, ())
    try:
        call = Call(eval, (f"({seen}, {own}, __import__('os').getppid())",))
        (folder, slices), its_own, parent = callers.share_out([call], [True])[0].result()
    finally:
        callers.end()
    assert parent == server._process.pid
    assert folder == str(tmp_path)
    # How often it was given a core: of the server's thread, which has imported numpy, it would be another number.
    assert abs(int(slices) - int(its_own)) <= 1


def test_neither_outlives_its_command():
    with subprocess.Popen([sys.executable, "-P", "-c", HELD], stdout=subprocess.PIPE, text=True) as command:
        assert command.stdout is not None
        pids = [int(word) for word in command.stdout.readline().split()]
        assert all(map(psutil.pid_exists, pids))
        command.kill()
    until(lambda: not any(psutil.pid_exists(pid) and psutil.Process(pid).status() != "zombie" for pid in pids))


def test_what_all_forks_need_is_imported_once_and_before_they_are_asked_for():
    loaded = "(__import__('os').getppid(), 'colorsys' in __import__('sys').modules)"
    with fork_server(["colorsys", "no_such_module"]):
        callers = Callers(1, ())
        try:
            parent, is_there = callers.share_out([Call(eval, (loaded,))], [True])[0].result()
        finally:
            callers.end()
        assert parent == module.running[0]._process.pid
    assert is_there
