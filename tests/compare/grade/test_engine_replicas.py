"""Replicas of engines, in their own precision, on a scene of their own: `tumble grade` names the engine."""

from pathlib import Path

import numpy as np
import pytest
from apart import engine
from programs import read, write
from replicas import Replica, midpoint, none, rescaled

from tumble.__main__ import main
from tumble.compare.grade.grade import grade
from tumble.compare.grade.verdicts import EXPLAINED_WHOLLY
from tumble.scenarios.read import read_scene

SCENE = """
title = "replica"
duration = {duration}
samples = 60
step = 0.001
gravity = [0.0, -9.81, 0.0]
[body]
shape = "box"
size = [0.45, 0.25, 0.1]
mass = 1.3
position = [0.3, 1.0, -0.2]
orientation = [0.6, -0.3, 0.5, 0.2]
velocity = [1.0, 4.0, -2.0]
angular_velocity = {spin}
"""
SLOW, FAST = [3.0, -6.0, 2.0], [20.0, 60.0, 110.0]
C = float(np.float32(0.04))


def bullet(v, w):
    """Damp as Bullet's multibody does, whose constants are of single precision: a = -0.04 (1 + |v|) v."""
    return -C * (1 + np.sqrt(v @ v)) * v, -C * (1 + np.sqrt(w @ w)) * w


def jolt(v, w, dt):
    """Damp as Jolt does."""
    by = np.float32(1) - np.float32(0.05) * dt
    return v * by, w * by


def flown(folder: Path, replica: Replica, spin=SLOW, duration=1.0, every=1):
    """Return the grade of a replica's file, a row every so many steps."""
    scene = folder / "replica.toml"
    scene.write_text(SCENE.format(duration=duration, spin=spin))
    throw = read(scene)
    rows = list(replica.rows(throw, every))
    file = folder / "replica.csv"
    write(file, rows, throw.vertices, form=lambda number: repr(float(number)))
    return grade(file, read_scene(str(scene)), {})


SINGLE = np.float32
CASES = {
    "MuJoCo 3.7 to 3.10 (implicitfast)": (Replica(1 / 60, midpoint, mean=True), {}),
    "Rapier": (Replica(1 / 240, rescaled, "first order", substeps=4, number=SINGLE), {"every": 4}),
    "Jolt": (Replica(1 / 60, none, damps=jolt, cap=15 * np.pi, number=SINGLE), {"spin": FAST, "duration": 0.5}),
    "a loop with Pinocchio's integrate": (Replica(1 / 60, screw=True), {}),
}


@pytest.mark.parametrize("engine", CASES)
def test_an_engine_is_named_by_what_its_replica_writes(tmp_path, engine):
    replica, how = CASES[engine]
    found = flown(tmp_path, replica, **how)
    assert found.verdict == EXPLAINED_WHOLLY
    assert engine in found.diagnosis.engines


def test_bullets_constant_is_one_of_single_precision(tmp_path):
    found = flown(tmp_path, Replica(1 / 60, drags=bullet))
    assert found.verdict == EXPLAINED_WHOLLY
    assert "PyBullet (multibody)" in found.diagnosis.engines


def test_a_start_that_single_precision_rounds_is_no_mistake(tmp_path):
    """The first row is off by its own rounding, where a flight has none yet."""
    found = flown(tmp_path, Replica(1 / 60, none, number=SINGLE))
    assert found.verdict == EXPLAINED_WHOLLY
    assert found.diagnosis.engines


def test_an_engine_that_took_a_hundred_steps_from_row_to_row_is_named(tmp_path):
    file = tmp_path / "rapier.csv"
    with engine("rapier"):
        assert main(["run", "nesc-brick", "-e", "rapier", "-o", str(file)]) == 0
    found = grade(file, read_scene("nesc-brick"), {})
    assert found.verdict == EXPLAINED_WHOLLY
    (mistake,) = found.diagnosis.best.mistakes
    assert mistake.value == pytest.approx(0.01)
    assert dict(mistake.hypothesis.details)["gyroscopic"] == "rescaled"
    assert found.diagnosis.engines
