"""An engine's process: what it sends is data, it ends with its parent, and all it started ends with it."""

import gc
import json
import os
import pickle
import re
import signal
import struct
import subprocess
import sys
import venv
import weakref
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeVar, get_args

import numpy as np
import pytest
from patience import PATIENCE_S, until, without_progress
from typing_extensions import TypeAliasType

from tumble.compare.run.engines.environments import Place
from tumble.compare.run.flight import Trajectory
from tumble.compare.run.process.message import PREFIX, Malformed, frame, lengths, split, unpacked
from tumble.compare.run.process.start import environment
from tumble.compare.run.questions import Question, Simulate
from tumble.compare.run.status import Failure, Status
from tumble.compare.run.worker import Worker
from tumble.scenarios.read import read_scene
from tumble.scenarios.scene import Scene

ENGINE = """
import os, signal, sys, time
import numpy as np
METHODS = ("still",)
FEATURES = {"gravity"}
ABOUT = {"version": "1", "precision": "double", "switched_off": []}
def build(scene, method): return {}
def write(world, states): world["states"] = states
def read(world): return world["states"]
def advance(world, n, dt):
"""
SCENE = read_scene("brick-tumble")
ROOT = Path(__file__).parents[3]


def engine(folder: Path, advance: str) -> str:
    path = folder / "mine.py"
    path.write_text(ENGINE + "".join(f"    {line}\n" for line in advance.splitlines()))
    return str(path)


def flown(path: str, **limits) -> str:
    with Worker(path, **{"time_limit": PATIENCE_S, **limits}) as worker:
        worker.describe()
        answer = worker.simulate(SCENE, "still", SCENE.step)
    return str(answer) if isinstance(answer, Failure) else "ok"


def running(marker: Path) -> list[int]:
    """The processes that were started with this file among their words, and what those have forked."""
    found = []
    for each in Path("/proc").glob("[0-9]*"):
        try:
            words, state = (each / "cmdline").read_bytes(), (each / "stat").read_text().rpartition(")")[2].split()[0]
        except (FileNotFoundError, ProcessLookupError):
            continue
        if os.fsencode(marker) in words.split(b"\0") and state != "Z" and b"serve.py" in words:
            found.append(int(each.name))
    return found


# Each holds a core and would for ever; none lets a thread of Python run.
LOOPS = {
    "python": "while True: pass",
    "forks": "for _ in range(5):\n    if not os.fork(): break\nwhile True: time.sleep(0.1)",
    "holds the lock": "import ctypes\nctypes.PyDLL(None).pause()",
}


@pytest.mark.parametrize("how", ["SIGKILL", "SIGTERM", "SIGHUP"])
@pytest.mark.parametrize("loop", LOOPS)
def test_nothing_of_an_engine_outlives_its_parent(tmp_path, loop, how):
    path = Path(engine(tmp_path, f"open({str(tmp_path / 'begun')!r}, 'w').close()\n{LOOPS[loop]}"))
    words = [
        sys.executable,
        "-P",
        "-m",
        "tumble",
        "compare",
        "brick-tumble",
        "-e",
        str(path),
        "--time-limit",
        str(PATIENCE_S),
    ]
    with subprocess.Popen(words, cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as parent:
        until((tmp_path / "begun").exists)
        assert running(path)
        parent.send_signal(signal.Signals[how])
        _, said = parent.communicate(timeout=PATIENCE_S)
    until(lambda: not running(path))
    if how == "SIGKILL":
        assert parent.returncode == -signal.SIGKILL
    else:
        assert (parent.returncode, without_progress(said)) == (130, "tumble: interrupted; nothing was written\n")


def test_what_an_engine_forked_ends_with_it(tmp_path):
    path = engine(tmp_path, "for _ in range(50):\n    if not os.fork():\n        while True: time.sleep(1)")
    assert flown(path) == "ok"
    until(lambda: not running(Path(path)))


def test_a_death_is_seen_though_its_forks_hold_the_line(tmp_path):
    path = engine(tmp_path, "if os.fork(): os._exit(7)\nwhile True: time.sleep(1)")
    assert flown(path) == "crashed: its process ended with code 7", "seen, and not waited for until the limit"
    until(lambda: not running(Path(path)))


TO_ALL_LINES = """
for name in os.listdir("/proc/self/fd"):
    try: os.write(int(name), {}) if int(name) > 2 else None
    except OSError: pass
"""


def test_stray_bytes_are_a_crash_and_no_wait(tmp_path):
    seen = "crashed: what it sent is no message"  # and not a timeout
    assert flown(engine(tmp_path, TO_ALL_LINES.format("b'abcd'"))) == seen


class Bomb:
    def __reduce__(self):
        return os.mkdir, ("executed",)


def test_an_answer_cannot_execute(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    pickled = pickle.dumps(Bomb())
    for bomb in (struct.pack("!i", len(pickled)) + pickled, frame_of(pickled), pickled):
        status = flown(engine(tmp_path, TO_ALL_LINES.format(repr(bomb))))
        assert status.startswith("crashed: what it sent"), status
    assert not Path("executed").exists()


def frame_of(head: bytes, body: bytes = b"") -> bytes:
    return PREFIX.pack(b"TMBL", len(head), len(body)) + head + body


FLOATS = '{"array": ["<f8", [1], 0]}'
HEADS = {
    "nothing": "",
    "another type": '"flown"',
    "a list": "[1, 2]",
    "too deep": "[" * 100_000,
    "an array of objects": '{"times": {"array": ["|O", [1], 0]}}',
    "an array beyond the body": '{"array": ["<f8", [1000000], 0]}',
    "a negative shape": '{"array": ["<f8", [-1], 0]}',
    "a huge shape": '{"array": ["<f8", [1e300], 0]}',
    "a number of 10000 digits": "1" * 10_000,
}


@pytest.mark.parametrize("head", HEADS)
def test_a_malformed_answer_is_a_crash(tmp_path, head):
    bomb = frame_of(HEADS[head].encode(), bytes(8))
    assert flown(engine(tmp_path, TO_ALL_LINES.format(repr(bomb)))).startswith("crashed: what it sent")


def test_an_answer_longer_than_the_question_allows_is_a_crash(tmp_path):
    endless = PREFIX.pack(b"TMBL", 2, 1 << 60)
    status = flown(engine(tmp_path, TO_ALL_LINES.format(repr(endless))))
    assert status == f"crashed: what it sent is longer than any answer: {1 << 60} bytes"


@pytest.mark.parametrize("off", [{"times": SCENE.rows + 1}, {"steps": -1}, {"wall_s": np.inf}, {"states": np.ones(3)}])
def test_a_flight_that_is_not_of_the_scene_is_a_crash(tmp_path, off):
    rows = len(SCENE.rows)
    flight = Trajectory(SCENE.rows, np.ones((rows, 1, 13)), np.ones((rows, 1, *SCENE.body.points.shape)), 1, 1.0, ())
    forged = b"".join(map(bytes, frame(replace(flight, **off))))
    status = flown(engine(tmp_path, TO_ALL_LINES.format(repr(forged))))
    assert status == "crashed: what it sent is no trajectory of this scene"


def test_a_question_arrives_as_it_was_asked():
    question = Simulate(read_scene("tether-critical"), "rk4", 0.1 + 0.2, frozenset({"drag", "floor"}))
    parts = [bytes(part) for part in frame(question)]
    head, body = lengths(parts[0][: PREFIX.size])
    assert len(parts[0]) == PREFIX.size + head
    assert sum(map(len, parts[1:])) == body
    found = unpacked(Question, parts[0][PREFIX.size :], b"".join(parts[1:]))
    assert isinstance(found, Simulate)
    assert (found.method, found.dt, found.keep) == ("rk4", 0.1 + 0.2, {"drag", "floor"})
    assert spelled(found.scene) == spelled(question.scene)
    assert not found.scene.start.flags.writeable


# As numpy 2.5 has NDArray on Python 3.12 and later: `type Numbers[T] = np.ndarray[Any, np.dtype[T]]`.
T = TypeVar("T", bound=np.generic)
Numbers = TypeAliasType("Numbers", np.ndarray[Any, np.dtype[T]], type_params=(T,))
Floats = TypeAliasType("Floats", Numbers[np.float64])


@dataclass(frozen=True, eq=False)
class Aliased:
    states: Numbers[np.float64]
    times: Floats
    again: tuple[Numbers[np.float64], ...]


def test_an_alias_of_arrays_is_an_array():
    sent = Aliased(np.ones((2, 3)), np.arange(4.0), (np.zeros(1), np.full(2, 0.1)))
    parts = [bytes(part) for part in frame(sent)]
    found = unpacked(Aliased | Failure, parts[0][PREFIX.size :], b"".join(parts[1:]))
    assert spelled(found) == spelled(sent)


@dataclass
class Keyed:
    by_pair: dict[tuple[str, int | None], list[float]]
    numbers: set[int | None]


def test_dicts_by_what_is_no_text_and_sets_with_none_arrive_as_they_are():
    sent = Keyed({("a", 1): [0.5], ("b", None): []}, {3, None, 1})
    (data,) = frame(sent)
    assert unpacked(Keyed, bytes(data[PREFIX.size :]), b"") == sent
    assert unpacked(Keyed, b'{"by_pair": {}, "numbers": []}', b"") == Keyed({}, set())
    with pytest.raises(Malformed):
        unpacked(Keyed, b'{"by_pair": [[["a", 1.5], []]], "numbers": []}', b"")


@pytest.mark.parametrize(
    ("plain", "said"),
    [
        (
            {"key": "k", "scene": 1, "method": "rk4", "pace": {"legs": [], "by_step": True}, "keep": []},
            "what it sent is no Scene (scene)",
        ),
        ({"check": "light", "method": 3}, "what it sent has a int where a str belongs (method)"),
        ({"check": "light"}, f"what it sent is no {' or '.join(each.__name__ for each in get_args(Question))}"),
    ],
)
def test_what_is_none_of_several_types_says_what_is_wrong_with_the_nearest(plain, said):
    with pytest.raises(Malformed) as refused:
        unpacked(Question, json.dumps(plain).encode(), b"")
    assert str(refused.value) == said


def test_how_deep_a_wrong_value_lies_is_said():
    parts = [bytes(part) for part in frame(Simulate(SCENE, "rk4", 0.1, frozenset()))]
    asked = json.loads(parts[0][PREFIX.size :])
    asked["scene"]["body"]["mass"] = "heavy"
    with pytest.raises(Malformed, match=re.escape("has a str where a float belongs (mass of body of scene)")):
        unpacked(Question, json.dumps(asked).encode(), b"".join(parts[1:]))


def test_a_question_that_cannot_be_read_is_one_line_and_no_traceback(tmp_path, capfd):
    with Worker(engine(tmp_path, "pass"), 30.0) as worker:
        worker.describe()
        answer = worker.check_failure("light", 3)  # type: ignore[arg-type]
    assert answer == Failure(
        Status.CRASHED, "it could not read what it was asked: what it sent has a int where a str belongs (method)"
    )
    assert capfd.readouterr().err == ""


def spelled(value: object) -> object:
    if isinstance(value, np.ndarray):
        return value.dtype.str, value.shape, value.tobytes()
    if hasattr(value, "__dataclass_fields__"):
        return {name: spelled(getattr(value, name)) for name in value.__dataclass_fields__}
    return [spelled(item) for item in value] if isinstance(value, tuple) else repr(value)


def test_what_is_no_plain_value_is_not_sent():
    for value in (object(), np.array([None]), np.array([1j]), {1: object()}, b"bytes"):
        with pytest.raises(TypeError):
            frame([value])
    with pytest.raises(Malformed):
        unpacked(Scene, b"{}", b"")


@pytest.mark.parametrize("kind", ["(01)f8", "f8,f8", "(1,", "<f99", "O", "|V8", "<U1", "<f8\n", 8, None, {}, ["<f8"]])
def test_a_type_of_an_array_is_one_of_ours_or_malformed(kind):
    """numpy parses some of these as Python, and raises SyntaxError."""
    with pytest.raises(Malformed):
        unpacked(np.ndarray, json.dumps({"array": [kind, [1], 0]}).encode(), bytes(64))


HOARDS = {
    "at once": "world['hoard'] = np.ones(1 << 28)",
    "bit by bit": "world['hoard'] = []\nwhile True: world['hoard'].append(bytearray(1 << 22))",
    "in C": """
import ctypes
libc = ctypes.CDLL(None)
libc.malloc.restype = libc.memset.argtypes = None
libc.malloc.restype = ctypes.c_void_p
libc.memset.argtypes = ctypes.c_void_p, ctypes.c_int, ctypes.c_size_t
while found := libc.malloc(1 << 22): libc.memset(found, 1, 1 << 22)
os.abort()
""",
}


@pytest.mark.parametrize("hoard", HOARDS)
def test_memory_has_its_limit(tmp_path, hoard):
    path = engine(tmp_path, HOARDS[hoard])
    assert flown(path, memory_limit=1 << 29) == "crashed: more than 0.5 GiB of memory (--memory-limit)"


def test_what_a_large_parent_holds_is_not_taken_for_its_childs(tmp_path):
    path = engine(tmp_path, "os._exit(3)")
    large = "from test_process import *\nheld = b'x' * (1 << 29)\nprint(flown(sys.argv[1], memory_limit=1 << 29))"
    words = [sys.executable, "-P", "-c", large, path]
    folders = (ROOT, Path(__file__).parent, ROOT / "tests/support")
    env = {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, folders))}
    done = subprocess.run(words, env=env, capture_output=True, text=True, timeout=PATIENCE_S)
    assert done.stdout == "crashed: its process ended with code 3\n", done.stderr


def test_memory_that_is_held_all_along_counts_from_the_start(tmp_path, tumble):
    (tmp_path / "mine.py").write_text("import numpy\nheld = numpy.ones(1 << 27)\n" + ENGINE + "    pass\n")
    done = tumble("compare", "brick-tumble", "-e", "mine.py", "--memory-limit", "0.5")
    assert done.returncode == 2
    assert (
        without_progress(done.stderr)
        == "tumble: mine.py: cannot be loaded: crashed: more than 0.5 GiB of memory (--memory-limit)\n"
    )


def test_files_of_the_working_folder_do_not_run(tmp_path):
    for name in ("struct", "json", "numpy", "resource", "signal", "compare", "solver", "sitecustomize"):
        (tmp_path / f"{name}.py").write_text("import os; os.path.exists('ran') or os.mkdir('ran')")
    # As a user starts it: with -P the test would say it of every child for it.
    command = [str(Path(sys.executable).with_name("tumble"))]
    for words in (
        ("compare", "table-4-1"),
        ("check", "table-4-1", "die-straight", "--no-times", "--accept", "-o", "base"),
    ):
        done = subprocess.run(
            [*command, *words, "-e", "tumble:rk4", "-e", "mujoco:euler"],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            timeout=PATIENCE_S,
        )
        assert done.returncode == 0, done.stderr
        assert not (tmp_path / "ran").exists()


def test_an_interpreter_with_nothing_but_numpy_serves(tmp_path):
    """As the releases of other engines have it: an environment of its own, in which nothing of ours is installed."""
    venv.create(tmp_path / "env", symlinks=True)
    (packages,) = (tmp_path / "env").glob("lib/python*/site-packages")
    for folder in Path(np.__file__).parents[1].glob("numpy*"):
        (packages / folder.name).symlink_to(folder)
    path = engine(tmp_path, "pass")
    text = "import importlib.util\nassert not any(map(importlib.util.find_spec, ('numba', 'msgspec', 'mpmath')))\n"
    Path(path).write_text(text + Path(path).read_text())
    with Worker(path, PATIENCE_S, place=Place(str(tmp_path / "env" / "bin" / "python"))) as worker:
        assert worker.describe().methods == ("still",)  # type: ignore[union-attr]
        flight = worker.simulate(SCENE, "still", SCENE.step)
    assert not isinstance(flight, Failure), flight
    assert flight.states.shape == (len(SCENE.rows), 1, 13)


def test_an_interpreter_that_is_not_there_is_a_failure():
    with Worker("tumble", 5.0, place=Place("/no/such/python")) as worker:
        assert str(worker.describe()) == "crashed: its process cannot be started: No such file or directory"
        assert not worker.alive


def test_an_engine_that_ends_says_why(tmp_path):
    assert flown(engine(tmp_path, "sys.exit('no licence\\nhere')")) == "crashed: its process ended: no licence here"
    assert flown(engine(tmp_path, "os.kill(os.getpid(), 40)")) == "crashed: its process was killed by signal 40"


class Fleeting(dict):
    """Environment variables of which another thread takes one away while they are read."""

    def __iter__(self):
        yield from [*super().__iter__(), "GONE"]

    keys = __iter__  # pyright: ignore[reportAssignmentType]


def test_a_variable_that_another_thread_takes_away_is_no_reason_not_to_start(monkeypatch):
    monkeypatch.setattr(os, "environ", Fleeting(os.environ))
    with pytest.raises(KeyError):
        _ = {**os.environ}
    assert environment()["PATH"] == os.environ["PATH"]
    assert "GONE" not in environment()


def test_what_was_read_is_gone_as_soon_as_it_is_not_needed():
    class Body(bytearray):
        """One that can be watched."""

    data = b"".join(frame(np.arange(9.0)))
    head, body = split(data)
    watched = Body(body)
    gone = weakref.ref(watched)
    gc.disable()
    try:
        found = unpacked(Failure | np.ndarray, head, watched)
        assert found.sum() == 36
        del found, watched
        assert gone() is None, "a cycle holds it"
    finally:
        gc.enable()
