"""A program that does not move the body at first, though its clock runs and impulses act at their times, is named."""

from dataclasses import replace

import numpy as np
import pytest
from pose_files import write_poses

from tumble.compare.grade.grade import grade
from tumble.compare.grade.model.reference import Reference
from tumble.compare.grade.verdicts import EXPLAINED_WHOLLY
from tumble.scenarios.read import read_scene

LATE = 0.05


def test_a_body_that_is_asleep_at_first_is_named(tmp_path):
    scene = read_scene("two-hits")
    times = np.linspace(0.0, scene.duration, 201)
    impulses = tuple(replace(each, time=max(each.time - LATE, 0.0)) for each in scene.impulses)
    awake = Reference(replace(scene, impulses=impulses)).states(0, np.maximum(times - LATE, 0.0))
    found = grade(write_poses(tmp_path / "a.csv", times, awake[:, 0:7], form="%.9g"), scene, {})
    assert found.verdict == EXPLAINED_WHOLLY
    assert found.diagnosis is not None
    ((only),) = found.diagnosis.best.mistakes
    assert only.hypothesis.name == "log-lag"
    assert "impulses act at their times" in only.text
    assert only.value == pytest.approx(LATE, rel=1e-6)
