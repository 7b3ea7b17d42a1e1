"""Two runs give identical bytes but for the times: each in a process of its own, with another hash seed."""

import csv
import io
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from patience import PATIENCE_S

from tumble.compare.check.record import read_record, texts
from tumble.compare.tables.files import write_folder

# What a clock says, and what is named after the machine's speed.
TIMES = ("wall_s", "wall_ns_per_step", "wall_per_sim_s")
ENGINES = ("tumble:rk4", "tumble:exact", "tumble:matrix-euler", "mujoco:implicit", "pybullet")
E_WORDS = [word for engine in ENGINES for word in ("-e", engine)]
COMMANDS = {
    "scenes": ["scenes"],
    "engines": ["engines", "-e", "tumble", "-e", "pybullet"],
    "run": ["run", "many-throws", "-o", "out/flight.csv"],
    "compare": ["compare", "two-hits", *E_WORDS, "-o", "out"],
    "check": ["check", "spin.toml", *E_WORDS, "--no-times", "--accept", "-o", "out"],
    "summary": ["check", "spin.toml", *E_WORDS, "--baseline", "base", "-o", "out"],
    "grade": ["grade", "flight.csv", "--scene", "two-hits", "-o", "out"],
}
SPIN = """title = "a"
duration = 0.2
samples = 4
step = 0.005
[body]
shape = "box"
size = [0.4, 0.15, 0.1]
mass = 2.4
angular_velocity = [0.3, 9.0, 0.4]
"""


def tumble(folder: Path, *words: str) -> str:
    command = [sys.executable, "-P", "-m", "tumble", *words]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=PATIENCE_S)
    assert done.returncode in (0, 1), done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """A scene, a trajectory, and a record that most of what is flown is worse than or new to."""
    folder = tmp_path_factory.mktemp("determinism")
    (folder / "spin.toml").write_text(SPIN)
    tumble(folder, "run", "two-hits", "-e", "mujoco:euler", "-o", "flight.csv")
    tumble(folder, "check", "spin.toml", "-e", "tumble:rk4", "-e", "mujoco", "--no-times", "--accept", "-o", "base")
    record = read_record(folder / "base")
    better = record.cells.assign(max_error_m=1e-9, attitude_order=8.0, spin_energy="conserved")
    write_folder(folder / "base", texts(replace(record, cells=better)))
    return folder


def without_times(name: str, text: str) -> object:
    if not name.endswith(".csv"):
        return text
    rows = list(csv.reader(io.StringIO(text, newline="")))
    return [[cell for head, cell in zip(rows[0], row, strict=True) if head not in TIMES] for row in rows]


@pytest.mark.parametrize("command", COMMANDS)
def test_two_runs_give_identical_bytes_but_for_the_times(folder, tmp_path, command):
    found = []
    for number in "ab":
        own = Path(shutil.copytree(folder, tmp_path / number))
        shown = tumble(own, *COMMANDS[command])
        if command == "compare":
            shown = ""  # its standings name nanoseconds; the tables behind them are compared
        out = {path.name: path.read_text(encoding="utf-8") for path in sorted(own.glob("out/*"))}
        found.append((shown, {name: without_times(name, text) for name, text in out.items()}))
    assert found[0] == found[1]
    shown, files = found[0]
    assert shown or files
    assert bool(files) == ("-o" in COMMANDS[command])


def test_the_summary_compared_is_not_empty(folder, tmp_path):
    own = Path(shutil.copytree(folder, tmp_path / "own"))
    shown = tumble(own, *COMMANDS["summary"])
    assert all(f"### {heading}" in shown for heading in ("Behaviour", "Worse", "New"))
