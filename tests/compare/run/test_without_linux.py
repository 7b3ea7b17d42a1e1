"""What is done where the system is not Linux: each call that others lack is taken away, and what is left must do."""

import os
import resource
import select
import subprocess
import sys
import time
from pathlib import Path

import pytest
from patience import PATIENCE_S

from tumble.compare.run import serve
from tumble.compare.run.process import process
from tumble.compare.run.process.process import Died, Process
from tumble.compare.run.provenance import processor
from tumble.compare.run.timing import others, timer

# Starts a child that holds all that it has open, and ends; or waits.
HOLDS = "import os, sys, time; os.fork() or time.sleep(6000); sys.exit(int({code!r}))"
WATCHED = """
import fcntl, sys
del fcntl.F_SETSIG
from tumble.compare.run.process.process import end_with_parent
end_with_parent(int(sys.argv[1]))
print("watched", flush=True)
while True: pass
"""


@pytest.fixture
def no_pidfd(monkeypatch):
    monkeypatch.delattr(os, "pidfd_open")
    assert not hasattr(select, "kqueue"), "this is Linux"


@pytest.mark.usefixtures("no_pidfd")
def test_death_is_seen_without_pidfd_though_a_child_holds_the_line():
    started = Process([sys.executable, "-c", HOLDS.format(code=7)], {})
    with pytest.raises(Died):  # and no TimeoutError
        started.receive(str, 0, time.monotonic() + PATIENCE_S)
    assert started.end(PATIENCE_S) == 7


@pytest.mark.usefixtures("no_pidfd")
def test_a_process_that_hangs_is_ended_without_pidfd():
    started = Process([sys.executable, "-c", "import time; time.sleep(6000)"], {})
    with pytest.raises(TimeoutError):
        started.receive(str, 0, time.monotonic() + 0.5)
    assert started.end() is None


def test_a_kernel_that_knows_no_pidfd_is_done_without(monkeypatch):
    def refuse(pid: int) -> int:
        raise OSError(38, "Function not implemented")

    monkeypatch.setattr(os, "pidfd_open", refuse)
    started = Process([sys.executable, "-c", "pass"], {})
    assert started.end(PATIENCE_S) == 0


def test_the_group_ends_with_the_parent_without_signals_for_pipes():
    far, lifeline = os.pipe()
    command = [sys.executable, "-c", WATCHED, str(far)]
    root = str(Path(process.__file__).parents[2])
    child = subprocess.Popen(
        command, pass_fds=[far], stdout=subprocess.PIPE, start_new_session=True, env=os.environ | {"PYTHONPATH": root}
    )
    os.close(far)
    try:
        assert child.stdout is not None
        assert child.stdout.readline() == b"watched\n"
        assert child.poll() is None
        os.close(lifeline)
        assert child.wait(PATIENCE_S) == -9
    finally:
        child.kill()
        child.communicate()


def nowhere(*_: object, **__: object):
    raise FileNotFoundError("/proc")


def test_what_proc_tells_is_done_without(monkeypatch):
    held = timer.peak_bytes()
    monkeypatch.setattr(Path, "read_text", nowhere)
    monkeypatch.setattr(os, "open", nowhere)
    # By both it has held some hundred megabytes; ru_maxrss begins with what the parent held.
    assert 0.5 * held < timer.peak_bytes() < 1e3 * held
    assert timer.schedule() is None
    monkeypatch.setattr(timer, "SCHEDULE", None)
    assert timer.queued_ns() == 0
    assert others.machine() is None
    monkeypatch.setattr(os, "getloadavg", lambda: (3.0, 3.0, 3.0))
    assert others.other_work(None, None).startswith("other processes used about 2.0 of ")
    assert processor()


def test_a_limit_of_memory_that_is_refused_is_no_crash(monkeypatch):
    def refuse(*_: object) -> None:
        raise ValueError("current limit exceeds maximum limit")

    monkeypatch.setattr(resource, "setrlimit", refuse)
    serve.limit_memory(1 << 30)
