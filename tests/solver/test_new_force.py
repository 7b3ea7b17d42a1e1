"""A new force is one term in the solver, one key in the scene and one term in the truth; the rest follows by itself.

A copy of the packages is given a wind, a constant force at the centre of mass, in those places and no others.
"""

import csv
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

HOME = Path(__file__).parents[2]
PACKAGES = ("solver", "scenarios", "compare", "reports", "tumble")

# File, the line that stays, and what is added after it.
SOLVER = [
    ("solver/forces.py", "    points: Array | None = None\n", "    wind: Vector | None = None\n"),
    (
        "solver/forces.py",
        "    force = add(add(_weight(forces.mass, forces.gravity), _linear_drag(v, forces.drag)), add(pull, push))\n",
        "    force = add(force, _wind(forces.wind))\n",
    ),
    (
        "solver/forces.py",
        "    return scale(-coefficient, rate)\n",
        '\n\n@inner\ndef _wind(wind: Vector | None) -> Vector:\n    """Return F = wind."""\n'
        "    if wind is None:\n        return NOTHING\n    return wind\n",
    ),
]
SCENE = [
    ("scenarios/format.py", "    floor: FloorTable | None = None\n", "    wind: Vector = ORIGIN\n"),
    ("scenarios/scene.py", "    floor: Floor | None = None\n", "    wind: Array | None = None\n"),
    (
        "scenarios/read.py",
        "        floor=floor,\n",
        "        wind=frozen_array(file.wind) if any(file.wind) else None,\n",
    ),
    (
        "scenarios/forces.py",
        "LAWS = (\n    GRAVITY,\n",
        '    Law("wind", "wind", lambda wind, scene, states: -(states[..., 0:3] @ wind), lambda wind: False, {}),\n',
    ),
]
TRUTH = [
    ("scenarios/truth/throw.py", "    ground: Ground | None\n", "    wind: Numbers\n"),
    (
        "scenarios/truth/throw.py",
        "        ground=_ground(scene, read),\n",
        "        wind=exact_numbers(np.zeros(3) if scene.wind is None else scene.wind, read),\n",
    ),
    (
        "scenarios/truth/forced/laws.py",
        "    pulls = [tether_pull(spring, motion) for spring in throw.springs]\n",
        "    pulls.append(Pull(throw.wind + 0 * motion.v, 0 * motion.L))\n",
    ),
]

WINDY = """
title    = "Brick in a steady wind"
duration = 0.5
times    = [0.1, 0.5]
step     = 0.001
gravity  = [0.0, -9.81, 0.0]
wind     = [3.0, 0.5, -1.0]

[body]
shape = "box"
size = [0.4, 0.15, 0.1]
mass = 2.4
angular_velocity = [0.2, -3.0, 1.4]
"""


@pytest.fixture(scope="module")
def copy(tmp_path_factory) -> Path:
    """The packages with a wind."""
    home = tmp_path_factory.mktemp("copy")
    for package in PACKAGES:
        shutil.copytree(HOME / package, home / package, ignore=shutil.ignore_patterns("__pycache__"))
    for name, line, addition in SOLVER + SCENE + TRUTH:
        text = (home / name).read_text()
        assert text.count(line) == 1, f"{name} has no single {line!r}"
        (home / name).write_text(text.replace(line, line + addition))
    (home / "windy.toml").write_text(WINDY)
    (home / "calm.toml").write_text(WINDY.replace("wind     = [3.0, 0.5, -1.0]", ""))
    return home


def compared(home: Path, scene: str, *engines: str) -> dict[str, dict[str, str]]:
    """The rows of `tumble compare`, by ENGINE:METHOD."""
    words = [word for engine in engines for word in ("-e", engine)]
    environment = {name: value for name, value in os.environ.items() if name != "NUMBA_CACHE_DIR"}
    subprocess.run(
        [sys.executable, "-m", "tumble", "compare", scene, *words, "-o", "tables"],
        cwd=home,
        env={**environment, "PYTHONPATH": str(home)},
        check=True,
        capture_output=True,
        timeout=300,
    )
    with (home / "tables" / "runs.csv").open(newline="") as file:
        return {f"{row['engine']}:{row['method']}": row for row in csv.DictReader(file)}


def test_the_solver_flies_it_and_others_say_they_do_not(copy):
    rows = compared(
        copy, "windy.toml", "tumble:rk4", "tumble:gauss6", "tumble:magnus6", "mujoco:rk4", "pybullet:multibody"
    )
    for name in ("tumble:rk4", "tumble:gauss6"):
        assert rows[name]["status"] == "ok"
        # Of a second's tumbling at 3 rad/s in steps of a millisecond, fourth order leaves (w dt)^4/100 of the die.
        assert float(rows[name]["max_error_m"]) < 1e-11
    assert (rows["tumble:magnus6"]["status"], rows["tumble:magnus6"]["why"]) == ("skipped", "magnus6 carries no forces")
    assert (rows["mujoco:rk4"]["status"], rows["mujoco:rk4"]["why"]) == ("skipped", "mujoco has no wind")
    assert (rows["pybullet:multibody"]["status"], rows["pybullet:multibody"]["why"]) == (
        "skipped",
        "pybullet has no wind",
    )


def test_a_calm_scene_needs_none_of_it(copy):
    rows = compared(copy, "calm.toml", "tumble:rk4", "mujoco:rk4")
    assert [row["status"] for row in rows.values()] == ["ok", "ok"]
