"""What is done where the system is not Linux: each call that others lack is taken away, and what is left must do."""

import csv
import os
import resource
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest
from patience import PATIENCE_S, until

from tumble.compare.run.process import process, usage
from tumble.compare.run.process.process import Died, Process
from tumble.compare.run.provenance import processor
from tumble.compare.run.timing import machine_load, timer

ROOT = Path(process.__file__).absolute().parents[4]
# Starts a child that holds all that it has open, and ends; or waits.
HOLDS = "import os, sys, time; os.fork() or time.sleep(6000); sys.exit(int({code!r}))"
WATCHED = """
import sys
{without}
from tumble.compare.run.process.start import end_with_parent
end_with_parent(sys.argv[1])
print("watched", flush=True)
while True: pass
"""

# Python runs it before anything else, in each process.  Modules of POSIX cannot be imported, but by psutil, which on
# Windows does without.  Signals and calls of POSIX are hidden from Tumble; libraries have others there.
NO_POSIX = """
import builtins, os, select, signal, sys

MODULES = {"fcntl", "grp", "pwd", "resource", "termios"}
import_any = builtins.__import__

def importing(name, globals=None, *others, **named):
    if name in MODULES and not (globals or {}).get("__name__", "").startswith("psutil"):
        raise ModuleNotFoundError(f"No module named {name!r}", name=name)
    return import_any(name, globals, *others, **named)

builtins.__import__ = importing

SIGNALS = {"SIGABRT", "SIGBREAK", "SIGFPE", "SIGILL", "SIGINT", "SIGSEGV", "SIGTERM"}
CALLS = {
    os: {
        "chown", "fork", "getegid", "geteuid", "getgid", "getloadavg", "getpgrp", "getuid", "killpg", "pidfd_open",
        "pread", "sched_getaffinity", "setsid", "sysconf", "uname", "wait3", "wait4", "waitid",
    },
    select: {"epoll", "poll"},
    signal: {name for name in vars(signal) if name[:3] == "SIG" and name[3] != "_"} - SIGNALS,
}

def hide(module, names):
    hidden = {name: vars(module).pop(name) for name in names if hasattr(module, name)}

    def missing(name):
        if name in hidden and not sys._getframe(1).f_globals.get("__name__", "").startswith("tumble"):
            return hidden[name]
        raise AttributeError(f"module {module.__name__!r} has no attribute {name!r}")

    module.__getattr__ = missing

for module, names in CALLS.items():
    hide(module, names)
"""


def test_death_is_seen_though_a_child_holds_the_line():
    started = Process([sys.executable, "-c", HOLDS.format(code=7)], {})
    with pytest.raises(Died):  # and no TimeoutError
        started.receive(str, 0, time.monotonic() + PATIENCE_S)
    assert started.end(PATIENCE_S) == 7


def test_a_process_that_hangs_is_ended():
    started = Process([sys.executable, "-c", "import time; time.sleep(6000)"], {})
    with pytest.raises(TimeoutError):
        started.receive(str, 0, time.monotonic() + 0.5)
    assert started.end() is None


def test_without_groups_a_process_ends_with_its_children(monkeypatch):
    code = "import subprocess, sys; subprocess.run([sys.executable, '-c', 'import time; time.sleep(6000)'])"
    monkeypatch.delattr(os, "killpg")
    monkeypatch.delattr(os, "wait4")
    started = Process([sys.executable, "-c", code], {})
    until(lambda: psutil.Process(started._process.pid).children())
    (child,) = psutil.Process(started._process.pid).children()
    assert started.end() is None
    until(lambda: not child.is_running() or child.status() == psutil.STATUS_ZOMBIE)


@pytest.mark.parametrize(
    "without", ["", "import fcntl; del fcntl.F_SETSIG", "sys.modules['fcntl'] = None", "import os; del os.killpg"]
)
def test_the_group_ends_with_the_parent(without):
    far, lifeline = os.pipe()
    command = [sys.executable, "-c", WATCHED.format(without=without), str(far)]
    child = subprocess.Popen(
        command,
        pass_fds=[far],
        stdout=subprocess.PIPE,
        start_new_session=True,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
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
    monkeypatch.setattr(timer, "SCHEDULE", [None])
    assert timer.queued_ns() == 0
    monkeypatch.setattr(psutil, "cpu_times", nowhere)
    assert machine_load.machine() is None
    monkeypatch.setattr(psutil, "getloadavg", lambda: (3.0, 3.0, 3.0))
    assert machine_load.other_work(None, None).startswith("other processes used about 2.0 of ")
    assert processor()


def test_a_limit_of_memory_that_is_refused_is_no_crash(monkeypatch):
    def refuse(*_: object) -> None:
        raise ValueError("current limit exceeds maximum limit")

    monkeypatch.setattr(resource, "setrlimit", refuse)
    usage.limit_memory(1 << 30)


@pytest.fixture
def no_posix(tmp_path, monkeypatch) -> Path:
    """A folder to work in, where every process is without what POSIX has beyond Windows."""
    (tmp_path / "first").mkdir()
    (tmp_path / "first" / "sitecustomize.py").write_text(NO_POSIX)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path / "first"))
    (tmp_path / "throw.toml").write_text(THROW)
    return tmp_path


THROW = """
title = "A short throw"
duration = 0.2
samples = 4
step = 0.01

[body]
shape = "box"
size = [0.4, 0.15, 0.1]
mass = 2.4
angular_velocity = [0.2, 3.0, 0.4]
"""
TWO = ("-e", "tumble:rk4", "-e", "mujoco:euler")


@pytest.fixture
def done(no_posix, tumble):
    """Run a command that must end well; return what it prints."""

    def run(*words: str) -> str:
        command = tumble(*words)
        assert command.returncode == 0, command.stderr
        return command.stdout

    return run


HIDDEN = ("import fcntl", "import os; os.killpg", "import signal; signal.SIGHUP", "from select import poll")


@pytest.mark.parametrize("code", HIDDEN)
def test_what_posix_has_is_hidden(no_posix, code):
    for name, expected in (("tumble", 1), ("psutil", 0)):
        command = [sys.executable, "-c", f"__name__ = {name!r}; {code}"]
        assert subprocess.run(command, cwd=no_posix, stderr=subprocess.DEVNULL).returncode == expected


def test_commands_do_without_posix(no_posix, done):
    assert "table-4-1" in done("scenes")
    done("run", "throw.toml", "-e", "tumble:rk4", "-o", "throw.csv")
    done("compare", "throw.toml", *TWO, "-o", "tables")
    with (no_posix / "tables" / "runs.csv").open(newline="") as file:
        assert [row["status"] for row in csv.DictReader(file)] == ["ok", "ok"]
    assert done("grade", "throw.csv", "--scene", "throw.toml")


def test_a_report_does_without_posix(no_posix, done):
    done("report", "throw.toml", *TWO, "-o", "page.html")
    assert (no_posix / "page.html").stat().st_size > 100_000


def test_without_posix_an_engine_that_hangs_or_dies_is_a_row(no_posix, tumble):
    (no_posix / "hangs.py").write_text("while True: pass")
    (no_posix / "dies.py").write_text("import os; os._exit(7)")
    for name, said in (("hangs", "timeout"), ("dies", "code 7")):
        command = tumble("run", "throw.toml", "-e", f"./{name}.py", "--time-limit", "3")
        assert command.returncode != 0
        assert said in command.stderr
