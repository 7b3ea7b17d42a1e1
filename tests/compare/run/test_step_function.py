"""A file with one function is an engine: it keeps the laws, is flown, and its mistakes are lines."""

from pathlib import Path

import numpy as np

from tumble.compare.engines import CHECKS
from tumble.compare.run.running_engines import launched
from tumble.scenarios.read import read_scene

# Semi-implicit Euler of a cube, which has no gyroscopic torque; a state is changed in place, or returned.
CUBE = """
import numpy as np

FEATURES = {"gravity"}

def times(p, q):
    return np.array([p[0] * q[0] - p[1:] @ q[1:], *(p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:]))])

def step(state, dt, body):
    v = state[7:10] + dt * body.gravity
    turn = dt * state[10:13]
    half = np.linalg.norm(turn) / 2
    q = times(np.array([np.cos(half), *(np.sinc(half / np.pi) * turn / 2)]), state[3:7])
    return np.concatenate((state[0:3] + dt * v, q / np.linalg.norm(q), v, state[10:13]))
"""


def test_a_function_keeps_the_laws_of_engines(tumble, tmp_path):
    (tmp_path / "cube.py").write_text(CUBE)
    done = tumble("engines", "--check", "./cube.py")
    assert done.returncode == 1, "a brick does not tumble as a cube does"
    assert done.stdout.startswith("cube: step\n")
    assert done.stdout.count("passed") == len(CHECKS) - 3
    assert "FAILED   converges         step: half the step leaves the error" in done.stdout
    assert "it has no gyroscopic torque: I w' = (I w) x w in body axes" in done.stdout


def test_what_a_function_states_of_itself_is_taken_at_its_word(tumble, tmp_path):
    (tmp_path / "cube.py").write_text(CUBE + 'GYROSCOPIC = {"step": "none"}\n')
    done = tumble("engines", "--check", "./cube.py")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "skipped  converges         it states that it leaves the gyroscopic torque out" in done.stdout


def test_it_is_flown_as_any_engine(tmp_path):
    (tmp_path / "cube.py").write_text(CUBE)
    scene = read_scene("table-4-1")
    with launched([str(tmp_path / "cube.py"), "tumble:exact"]) as (own, exact):
        mine, true = (each.simulate(scene, each.methods[0], scene.step) for each in (own, exact))
    np.testing.assert_allclose(mine.vertices, true.vertices, rtol=0, atol=1e-9)


def test_a_state_may_be_changed_in_place(tmp_path):
    (tmp_path / "straight.py").write_text("def step(state, dt, body):\n    state[0:3] += dt * state[7:10]\n")
    with launched([str(tmp_path / "straight.py")]) as (own,):
        assert own.info.features == frozenset()
        assert own.worker.check_failure("straight", "step") == ""


def test_what_raises_is_a_row(tumble, tmp_path: Path):
    (tmp_path / "bad.py").write_text("def step(state, dt, body):\n    return state[:7]\n")
    done = tumble("compare", "table-4-1", "-e", "./bad.py")
    assert done.returncode == 1
    assert "bad:step: crashed: ValueError: could not broadcast" in done.stdout
