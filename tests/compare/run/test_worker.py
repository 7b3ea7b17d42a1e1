"""A user's engine may raise, hang, print, return nonsense or kill its process: each is a row with a reason."""

import pytest

from tumble.compare.comparison.against_truth import compare
from tumble.compare.run.engines.registry import BadEngine
from tumble.compare.run.running_engines import launched
from tumble.scenarios.read import read_scene

GOOD = """
import os, signal, sys, time
import numpy as np
METHODS = ("still",)
FEATURES = {"gravity"}
ABOUT = {"version": "1", "precision": "double", "switched_off": []}
def build(scene, method): return {}
def write(world, states): world["states"] = states
def advance(world, n, dt): world["states"][:, 0:3] += n * dt * world["states"][:, 7:10]
def read(world): return world["states"]
"""

ADVANCES = {
    "raise ValueError('lost\\nit')": "crashed: ValueError: lost it (bad.py:",
    "time.sleep(1000)": "timeout: no answer within 15 s (--time-limit)",
    "os.kill(os.getpid(), signal.SIGSEGV)": "crashed: its process was killed by SIGSEGV",
    "os._exit(7)": "crashed: its process ended with code 7",
    "sys.exit(5)": "crashed: its process ended with code 5",
    "world['states'] = np.zeros(13)": "crashed: ValueError: read() returned shape (13,), not (1, 13)",
    "world['states'][:, 3:7] = np.nan": "diverged at 0.05 s",
    "raise NotImplementedError('no such thing here')": "skipped: no such thing here",
    "world['states'] = world['states'] * (1 + 0j)": "crashed: ValueError: it answered complex numbers",
}


def engine_file(tmp_path, *changes: tuple[str, str]) -> str:
    text = GOOD
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path = tmp_path / "bad.py"
    path.write_text(text)
    return str(path)


@pytest.mark.parametrize("body", ADVANCES)
def test_what_an_engine_does_wrong_is_its_status(tmp_path, body):
    path = engine_file(tmp_path, ("def advance(world, n, dt): ", f"def advance(world, n, dt): {body} #"))
    scene = read_scene("brick-tumble")
    with launched([path, "tumble:rk4"], time_limit=15) as running_engines:
        bad, ours = compare(running_engines, [scene])[0].runs
    expected = ADVANCES[body].replace("0.05 s", f"{scene.times[0]:g} s")
    assert bad.outcome.startswith(expected), bad.outcome
    assert "\n" not in bad.reason
    assert ours.status == "ok", "another engine's run is unharmed"


def test_a_worker_that_died_is_replaced_for_the_next_scene(tmp_path):
    die_once = f"def build(scene, method): scene.gravity is None or os._exit(1); return {{}}  # {tmp_path}"
    path = engine_file(tmp_path, ("def build(scene, method): return {}", die_once))
    scenes = [read_scene("die-straight"), read_scene("table-4-1")]
    with launched([path]) as running_engines:
        statuses = [comparison.runs[0].outcome for comparison in compare(running_engines, scenes)]
    assert statuses[0].startswith("crashed: its process ended with code 1")
    assert not statuses[1].startswith("crashed")


def test_what_an_engine_prints_never_reaches_standard_output(tmp_path, tumble):
    chatter = "def read(world): print('chatter'); os.system('echo from C'); os.write(1, b'raw');"
    path = engine_file(tmp_path, ("def read(world): ", chatter), ("import os", "print('hello'); import os"))
    done = tumble("run", "table-4-1", "-e", path)
    assert done.returncode == 0
    lines = done.stdout.splitlines()
    assert lines[0].startswith("t_s,x_m")
    assert len(lines) == 7
    assert all(line.count(",") == lines[0].count(",") for line in lines)
    assert "chatter" in done.stderr, "its author can still read what it printed"


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        ("def read(world): return", "def read(world) return", "bad.py:10: expected ':'"),
        ("def read", "def reed", "has no read; an engine file needs METHODS, FEATURES, ABOUT, build, write"),
        ("METHODS = ", "METHOD = ", "has no METHODS;"),
        ('METHODS = ("still",)', "METHODS = ()", "METHODS is empty"),
        ('METHODS = ("still",)', "METHODS = 3", "METHODS and FEATURES must be names"),
        ("import numpy", "import no_such_package", "cannot be loaded: ModuleNotFoundError: No module named"),
        ("import numpy", "sys.exit(4); import numpy", "cannot be loaded: crashed: its process ended with code 4"),
        ("def read(world): return", "read = 3 #", "read is not a function"),
        ('"switched_off": []', '"switched_off": 5', "METHODS and FEATURES must be names, ABOUT a dict"),
        ("import numpy", "sys.exit('no licence'); import numpy", "crashed: its process ended: no licence"),
    ],
)  # fmt: skip
def test_an_engine_file_that_cannot_be_used_is_refused_in_one_line(tmp_path, tumble, old, new, line):
    done = tumble("compare", "table-4-1", "-e", engine_file(tmp_path, (old, new)))
    assert done.returncode == 2
    assert line in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert done.stdout == ""


def test_an_engine_may_not_alter_the_scene(tmp_path):
    path = engine_file(tmp_path, ("return {}", "scene.start[0, 0] = 1; return {}"))
    with launched([path]) as running_engines:
        (run,) = compare(running_engines, [read_scene("table-4-1")])[0].runs
    assert run.outcome.startswith("crashed: ValueError: assignment destination is read-only")


def test_the_nearest_name_is_offered():
    with pytest.raises(BadEngine, match="unknown engine 'mujocco': did you mean 'mujoco'"), launched(["mujocco"]):
        pass
    with pytest.raises(BadEngine, match="unknown method of mujoco 'rk5': did you mean 'rk4'"), launched(["mujoco:rk5"]):
        pass
