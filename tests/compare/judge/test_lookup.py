"""Engines that answer for the start they were told of, and not for the one they are given, are found; no others are."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tumble.compare.judge.errors import Run
from tumble.compare.run.flight import altered
from tumble.compare.run.running_engines import launched
from tumble.compare.run.status import Failure
from tumble.compare.run.truths import true_answer
from tumble.scenarios.read import read_scene
from tumble.scenarios.scene import Scene, frozen_array

PLUGINS = Path(__file__).parents[2] / "plugins"
MINE = (PLUGINS / "mine.py").read_text()
# A fine answer for what the scene says, made before anybody asks: 40 steps of Runge-Kutta for each of those asked for.
ANSWERS = """
def turning(q, moments, L):
    R = rotation(q)
    w = R @ (R.T @ L / moments)
    return 0.5 * np.array([-q[1:] @ w, *(q[0] * w + np.cross(w, q[1:]))]), w
def rotation(q):
    w, x, y, z = q
    return np.array([[1 - 2*(y*y + z*z), 2*(x*y - w*z), 2*(x*z + w*y)],
                     [2*(x*y + w*z), 1 - 2*(x*x + z*z), 2*(y*z - w*x)],
                     [2*(x*z - w*y), 2*(y*z + w*x), 1 - 2*(x*x + y*y)]])
def answer(scene, state, t, parts=400):
    found, q, g = state.copy(), state[3:7].copy(), 0.0 if scene.gravity is None else scene.gravity
    R = rotation(q)
    L = R @ (scene.body.moments * (R.T @ state[10:13]))
    for _ in range(parts):
        h = t / parts
        a = turning(q, scene.body.moments, L)[0]
        b = turning(q + h / 2 * a, scene.body.moments, L)[0]
        c = turning(q + h / 2 * b, scene.body.moments, L)[0]
        d = turning(q + h * c, scene.body.moments, L)[0]
        q = q + h / 6 * (a + 2 * b + 2 * c + d)
        q = q / np.linalg.norm(q)
    found[0:3] += t * state[7:10] + t * t / 2 * g
    found[3:7] = q
    found[7:10] += t * g
    found[10:13] = turning(q, scene.body.moments, L)[1]
    return found
"""
HEAD = """
import numpy as np
METHODS = ("m",)
FEATURES = {"gravity"}
ABOUT = {"version": "1", "precision": "double", "switched_off": []}
def build(scene, method): return {"scene": scene}
def advance(world, n, dt): world["t"] += n * dt
"""
# Where it begins counts, and how it turns from there was known.
STARTS = """
def write(world, states): world.update(states=states, t=0.0)
"""
CHEATS = {
    "the scene": """
def read(world):
    scene, t = world["scene"], world["t"]
    return answer(scene, scene.start[0], t)[None] if t else world["states"]
""",
    "the attitude": """
def read(world):
    told, given = world["scene"].start[0], world["states"][0]
    found = answer(world["scene"], told, world["t"])
    found[0:3] += given[0:3] - told[0:3] + world["t"] * (given[7:10] - told[7:10])
    return found[None] if world["t"] else world["states"]
""",
    "what it knows": """
def read(world):
    scene, given, t = world["scene"], world["states"][0], world["t"]
    return answer(scene, given, t, 400 if (given == scene.start[0]).all() else 1)[None] if t else world["states"]
""",
}
# None of these is accurate, but each flies what it is given.
HONEST = {
    "coarse": """
def read(world):
    return answer(world["scene"], world["states"][0], world["t"], 4)[None] if world["t"] else world["states"]
""",
    "never turns": """
def read(world):
    found = world["states"].copy()
    found[:, 0:3] += world["t"] * found[:, 7:10]
    return found
""",
    "half as heavy": """
def read(world):
    scene, given, t = world["scene"], world["states"][0], world["t"]
    return answer(scene, given * np.r_[np.ones(10), 0.5 * np.ones(3)], t)[None] if t else world["states"]
""",
    "single precision": """
def read(world):
    found = answer(world["scene"], world["states"][0], world["t"])[None] if world["t"] else world["states"]
    return found.astype(np.float32)
""",
    "frozen": """
def read(world): return world["states"]
""",
}
SCENE = replace(read_scene("dzhanibekov"), times=frozen_array([0.25, 0.5]), duration=0.5)


def notes(folder: Path, text: str, scene: Scene = SCENE) -> str:
    path = folder / "mine.py"
    path.write_text(HEAD + STARTS + ANSWERS + text)
    with launched([str(path)]) as (engine,):
        flight = engine.simulate(scene, "m", scene.step, probe=True)
    assert not isinstance(flight, Failure), flight
    return Run(scene, "mine", "m", scene.step, flight, true_answer(scene, with_input_error=False).truth).outcome


@pytest.mark.parametrize("known", CHEATS)
def test_who_looks_the_answer_up_is_found(tmp_path, known):
    status = notes(tmp_path, CHEATS[known])
    assert status.startswith("flagged: looked up: "), status


@pytest.mark.parametrize("honest", HONEST)
def test_who_is_only_inaccurate_is_not_accused(tmp_path, honest):
    assert "looked up" not in notes(tmp_path, HONEST[honest])


def test_a_cache_of_the_truth_is_found_by_the_command_and_an_engine_beside_it_is_not(tmp_path, tumble):
    """The answers of a trajectory that was written by `tumble run`, taken for one's own."""
    assert tumble("run", "two-hits", "-e", "tumble:exact", "-o", "true.csv").returncode == 0
    (tmp_path / "cached.py").write_text(
        HEAD.replace("import numpy as np", "import csv, pathlib\nimport numpy as np")
        + """
rows = list(csv.reader(open(pathlib.Path(__file__).with_name("true.csv"))))[1:]
table = np.array([row[:14] for row in rows], dtype=float)
def write(world, states): world.update(states=states, t=world.get("t", 0.0), begun=False)
def advance(world, n, dt): world.update(t=world["t"] + n * dt, begun=True)
def read(world):
    nearest = table[np.argmin(abs(table[:, 0] - world["t"]))]
    return nearest[None, 1:] if world["begun"] else world["states"]
"""
    )
    done = tumble("compare", "two-hits", "-e", "./cached.py", "-e", "tumble:rk4")
    assert done.returncode == 0, done.stderr
    assert "looked up" in " ".join(done.stdout.split()), done.stdout
    assert done.stdout.startswith("two-hits: tumble:rk4 is most accurate"), done.stdout


def test_the_altered_start_is_close_and_another_in_every_number():
    start = np.array([[1.0, 2, 3, 0.8, 0.0, 0.6, 0.0, 1, 2, 3, 4, 5, 6]])
    moved = altered(start, 2.0)
    assert (moved != start).all()
    assert np.abs(moved - start).max() < 1e-3
    assert np.linalg.norm(moved[:, 3:7]) == pytest.approx(1.0, abs=1e-15)
