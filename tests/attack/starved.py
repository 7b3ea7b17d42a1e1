"""Machines that lack something: the command says so in one line, or does without; it never fails as a bug of ours."""

import os
import resource
import signal
import subprocess
import sys
import uuid
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from left_running import carrying, gone
from patience import PATIENCE_S

RUN = ("run", "die-straight", "-e", "tumble:rk4")
FILE = (*RUN, "-o", "out.csv")
FOLDER = ("compare", "die-straight", "-e", "tumble:rk4", "-o", "out")


@dataclass(frozen=True)
class State:
    """What a machine lacks: words of the command, what is other in its environment, in its streams and its limits.

    codes: those it may end with.
    """

    words: tuple[str, ...] = RUN
    env: dict[str, str] = field(default_factory=dict)
    streams: dict[str, Any] = field(default_factory=dict)
    before: Callable[[], object] = lambda: None
    prepare: Callable[[Path], object] = lambda folder: None
    codes: tuple[int, ...] = (0,)


def limited(what: int, most: int) -> Callable[[], object]:
    """Return what sets a limit."""
    return lambda: resource.setrlimit(what, (most, most))


def closed(*streams: int) -> Callable[[], object]:
    """Return what closes standard streams."""
    return lambda: [os.close(stream) for stream in streams]


def ignored(*signals: int) -> Callable[[], object]:
    """Return what has signals ignored."""
    return lambda: [signal.signal(number, signal.SIG_IGN) for number in signals]


def removed() -> None:
    """Leave for a folder that is no more."""
    os.mkdir("gone")
    os.chdir("gone")
    os.rmdir("../gone")


def folder(path: Path) -> None:
    """Put a folder where a file belongs."""
    (path / "out.csv").mkdir()


def file(path: Path) -> None:
    """Put a file where a folder belongs."""
    (path / "out").write_text("in the way")


def endless(path: Path) -> None:
    """Put a link to itself where a file belongs."""
    (path / "out.csv").symlink_to("out.csv")
    (path / "out").symlink_to("out")


MIB = 1 << 20
STATES: dict[str, State] = {
    "no environment at all": State(env={"PATH": "", "HOME": "", "LANG": "", "USER": ""}),
    "no home": State(env={"HOME": "/nonexistent"}),
    "a home that is a file": State(env={"HOME": os.devnull}),
    "no temporary folder": State(FOLDER, {"TMPDIR": "/nonexistent"}),
    "a temporary folder that is a file": State(FOLDER, {"TMPDIR": os.devnull}),
    "no cache folder": State(env={"XDG_CACHE_HOME": "/proc/none", "HOME": "/proc/none"}),
    "a kernel cache that cannot be written": State(env={"NUMBA_CACHE_DIR": "/proc/none"}),
    "a kernel cache that is a file": State(env={"NUMBA_CACHE_DIR": os.devnull}),
    "a language that is none": State(env={"LANG": "xx_YY.none", "LC_ALL": "xx_YY.none"}),
    "ASCII only": State(FOLDER, {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}),
    "an encoding without our letters": State(FOLDER, {"PYTHONIOENCODING": "ascii"}),
    "a time zone that is none": State(env={"TZ": "Nowhere/Nothing"}),
    "a terminal that is none": State(FOLDER, {"TERM": "", "COLUMNS": "-1", "LINES": "x"}),
    "a terminal of one column": State(FOLDER, {"COLUMNS": "1"}),
    "a terminal of many columns": State(FOLDER, {"COLUMNS": "1000000"}),
    "colours by force": State(FOLDER, {"FORCE_COLOR": "1", "TTY_INTERACTIVE": "1"}),
    "no standard input": State(before=closed(0)),
    "no standard output": State(before=closed(1), codes=(0, 2)),
    "no standard error": State(before=closed(2)),
    "no standard streams": State(before=closed(0, 1, 2), codes=(0, 2)),
    "no standard streams, and a file": State(FILE, before=closed(0, 1, 2)),
    "standard output on a full disk": State(streams={"stdout": "/dev/full"}, codes=(2,)),
    "standard error on a full disk": State(streams={"stderr": "/dev/full"}),
    "a full disk": State((*RUN, "-o", "/dev/full"), codes=(2,)),
    "files of a kilobyte": State(FOLDER, before=limited(resource.RLIMIT_FSIZE, 1000), codes=(2,)),
    "files of no byte": State(FILE, before=limited(resource.RLIMIT_FSIZE, 0), codes=(2,)),
    "64 open files": State(FOLDER, before=limited(resource.RLIMIT_NOFILE, 64)),
    "16 open files": State(FOLDER, before=limited(resource.RLIMIT_NOFILE, 16), codes=(0, 1, 2)),
    "no core files": State(before=limited(resource.RLIMIT_CORE, 0)),
    "2 GiB of addresses": State(FOLDER, before=limited(resource.RLIMIT_AS, 2048 * MIB), codes=(0, 1, 2)),
    "a stack of a megabyte": State(FOLDER, before=limited(resource.RLIMIT_STACK, MIB)),
    "children that nobody waits for": State(FOLDER, before=ignored(signal.SIGCHLD)),
    "Ctrl-C ignored": State(FOLDER, before=ignored(signal.SIGINT, signal.SIGHUP, signal.SIGTERM)),
    "broken pipes ignored": State(before=ignored(signal.SIGPIPE)),
    "all signals blocked": State(FOLDER, before=lambda: signal.pthread_sigmask(signal.SIG_BLOCK, range(1, 32))),
    "a mask that allows nothing": State(FOLDER, before=lambda: os.umask(0o777)),
    "a folder that is gone": State(before=removed, codes=(0, 2)),
    "a folder that is gone, and a table for it": State(FOLDER, before=removed, codes=(2,)),
    "a folder where the file belongs": State(FILE, prepare=folder, codes=(2,)),
    "a file where the folder belongs": State(FOLDER, prepare=file, codes=(2,)),
    "a link to itself where the file belongs": State(FILE, prepare=endless, codes=(2,)),
    "a link to itself where the folder belongs": State(FOLDER, prepare=endless, codes=(2,)),
    "a folder that cannot be made": State((*FOLDER[:-1], "/proc/none"), codes=(2,)),
    "a name that is too long": State((*FOLDER[:-1], "x" * 300), codes=(2,)),
    "a name of nothing": State((*FOLDER[:-1], ""), codes=(0, 2)),
    "a name that is no text": State((*FOLDER[:-1], os.fsdecode(b"\xff\xfe"))),
    "an engine's name that is no text": State(
        ("compare", "die-straight", "-e", os.fsdecode(b"./\xff.py"), "-o", "out"),
        prepare=lambda path: (path / os.fsdecode(b"\xff.py")).write_bytes(
            (Path(__file__).parents[1] / "plugins" / "mine.py").read_bytes()
        ),
    ),
    "Python told to stop at warnings": State(FOLDER, {"PYTHONWARNINGS": "error"}),
    "Python told to run unbuffered": State(FOLDER, {"PYTHONUNBUFFERED": "1", "PYTHONDEVMODE": "1"}),
    "Python without hash seeds": State(FOLDER, {"PYTHONHASHSEED": "0"}),
    "Python without docstrings": State(FOLDER, {"PYTHONOPTIMIZE": "2"}),
    "Python that writes no bytecode": State(FOLDER, {"PYTHONDONTWRITEBYTECODE": "1"}),
    "no processors to spare": State(FOLDER, {"OMP_NUM_THREADS": "0", "NUMBA_NUM_THREADS": "1"}),
    "one processor": State(FOLDER, before=lambda: os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})),
    "the last in the queue": State(FOLDER, before=lambda: os.nice(19)),
}


def attack(folder: Path, name: str) -> None:
    """Run one command on one such machine.  Raises AssertionError where it fails as a bug, half writes, or stays."""
    state, own, mark = STATES[name], folder / name.replace(" ", "-"), f"TUMBLE_TEST={uuid.uuid4()}"
    own.mkdir(parents=True)
    state.prepare(own)
    left = {path.name for path in own.iterdir()}
    try:
        with ExitStack() as files:
            opened = {stream: files.enter_context(open(path, "w")) for stream, path in state.streams.items()}
            done = subprocess.run(  # pyright: ignore[reportCallIssue]
                [sys.executable, "-P", "-m", "tumble", *state.words],
                cwd=own,
                env=os.environ | state.env | dict([mark.split("=")]),
                preexec_fn=state.before,
                timeout=PATIENCE_S,
                **({"stdout": subprocess.PIPE, "stderr": subprocess.PIPE} | opened),
            )
    finally:
        gone(partial(carrying, mark))
    said = (done.stderr or b"").decode(errors="replace")
    assert done.returncode in state.codes, f"code {done.returncode}: {said[-500:]}"
    assert "Traceback" not in said, said[-500:]
    if done.returncode == 2 and done.stderr:
        assert len(said.splitlines()) == 1, said
    made = {path.name for path in own.iterdir()} - left
    if done.returncode == 2:
        assert all(not (own / each).is_file() and not any((own / each).glob("*.csv")) for each in made), made


def all_attacks() -> dict[str, Callable[[Path], None]]:
    """Return every attack by its name."""
    return {name: partial(attack, name=name) for name in STATES}
