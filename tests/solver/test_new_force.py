"""A new force is one term in the solver, one key and one entry in the scene and one law in the truth; the rest follows.

`tests/support/wind` registers a wind in those places, for every process of a command and its engines.
"""

import csv
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from patience import PATIENCE_S

HOME = Path(__file__).parents[2]
WIND = HOME / "tests" / "support" / "wind"

WINDY = """
title    = "Brick in a steady wind"
duration = 0.5
times    = [0.1, 0.2, 0.3, 0.4, 0.5]
step     = 0.001
gravity  = [0.0, -9.81, 0.0]
wind     = [3.0, 0.5, -1.0]

[body]
shape = "box"
size = [0.4, 0.15, 0.1]
mass = 2.4
angular_velocity = [0.2, -3.0, 1.4]
"""

# The velocities after half a second in the wind and in none, of two programs that are simulated together.
TOGETHER = """
import numpy as np
from tumble.compare.grade.model.program_model import FINE, correct_program, simulated
from tumble.compare.grade.search.simulations import V
from tumble.scenarios.read import read_scene

windy = correct_program(read_scene("windy.toml"), 0)
calm = windy.but(forces=windy.forces._replace(wind=(0.0, 0.0, 0.0)))
print(*simulated([windy, calm], [np.array([0.5])] * 2, FINE)[:, V].ravel())
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """A folder with a scene in a wind, and the same in none."""
    folder = tmp_path_factory.mktemp("wind")
    (folder / "windy.toml").write_text(WINDY)
    (folder / "calm.toml").write_text(WINDY.replace("wind     = [3.0, 0.5, -1.0]", ""))
    return folder


def tumble(folder, *words, code=0):
    """Run a command where there is a wind, and return what it prints."""
    return python(folder, "-m", "tumble", *words, code=code)


def python(folder, *words, code=0):
    """Run Python where there is a wind, and return what it prints; its kernels are its own."""
    environment = {**os.environ, "PYTHONPATH": f"{WIND}{os.pathsep}{HOME}", "NUMBA_CACHE_DIR": str(folder / "kernels")}
    said = subprocess.run(
        [sys.executable, *words],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
    )
    assert said.returncode == code, said.stderr
    return said.stdout


def runs(folder, scene, *engines) -> dict[str, dict[str, str]]:
    """The rows of `tumble compare`, by ENGINE:METHOD."""
    tumble(folder, "compare", scene, *(word for engine in engines for word in ("-e", engine)), "-o", "tables")
    with (folder / "tables" / "runs.csv").open(newline="") as file:
        return {f"{row['engine']}:{row['method']}": row for row in csv.DictReader(file)}


def test_the_solver_flies_it_as_the_truth_does_and_others_say_that_they_do_not(folder):
    rows = runs(folder, "windy.toml", "tumble:rk4", "tumble:magnus6", "mujoco:rk4", "pybullet:multibody")
    assert rows["tumble:rk4"]["status"] == "ok"
    # Of a second's tumbling at 3 rad/s in steps of a millisecond, fourth order leaves (w dt)^4/100 of the brick.
    assert float(rows["tumble:rk4"]["max_error_m"]) < 1e-11
    said = {name: (row["status"], row["why"]) for name, row in rows.items()}
    assert said["tumble:magnus6"] == ("skipped", "magnus6 carries no forces")
    assert said["mujoco:rk4"] == ("skipped", "mujoco has no wind")
    assert said["pybullet:multibody"] == ("skipped", "pybullet has no wind")


def test_grade_names_it_where_it_was_left_out(folder):
    tumble(folder, "run", "calm.toml", "-o", "calm.csv")
    said = json.loads(tumble(folder, "grade", "calm.csv", "--scene", "windy.toml", "--json"))
    assert "wind-missing" in {each["mistake"] for each in said["diagnosis"]}, said


def test_grade_simulates_programs_with_and_without_it_together(folder):
    v_windy, v_calm = np.array(python(folder, "-c", TOGETHER).split(), float).reshape(2, 3)
    # F t / m is exact in every method. So is gravity.
    assert v_windy == pytest.approx([3.0 * 0.5 / 2.4, (0.5 / 2.4 - 9.81) * 0.5, -1.0 * 0.5 / 2.4], abs=1e-12)
    assert v_calm == pytest.approx([0.0, -9.81 * 0.5, 0.0], abs=1e-12)


def test_a_calm_scene_needs_none_of_it(folder):
    rows = runs(folder, "calm.toml", "tumble:rk4", "mujoco:rk4")
    assert [row["status"] for row in rows.values()] == ["ok", "ok"]
