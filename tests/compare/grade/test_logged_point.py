"""A point of the body logged instead of its centre of mass has its name, whatever the body."""

from dataclasses import replace

import numpy as np
import pytest
from pose_files import POINTS, SKEWED, write_poses

from tumble.compare.grade.grade import context_of, grade
from tumble.compare.grade.hypotheses.explanation import Explanation, Mistake
from tumble.compare.grade.hypotheses.mistakes import hypotheses
from tumble.compare.grade.measure.errors import measure
from tumble.compare.grade.model.program_model import FINE, correct_program, output_points
from tumble.compare.grade.read.trajectory import Trajectory
from tumble.compare.grade.verdicts import EXPLAINED_WHOLLY
from tumble.scenarios.read import read_scene

# Eight points that are no corners of a box: all of them are at x > 0.
EIGHT = [[0.3, 0, 0], [0.3, 0.1, 0], [0.2, 0, 0.1], [0.1, 0.2, 0], [0.2, -0.2, 0.1], [0.1, 0, 0.2], [0.1, 0, 0]]
EIGHT += [[0.2, 0.1, 0.1]]


@pytest.mark.parametrize("count", [5, 8])
def test_a_vertex_logged_has_its_name(tmp_path, count):
    (tmp_path / "skewed.toml").write_text(SKEWED.replace(POINTS, str(EIGHT[:count])))
    scene = read_scene(str(tmp_path / "skewed.toml"))
    pose = correct_program(scene, 0).output(np.linspace(0.0, 1.0, 26), FINE)
    x = pose.x + pose.axes @ output_points(scene.body)[3]
    found = grade(write_poses(tmp_path / "a.csv", pose.times, x, pose.q), scene, {})
    assert found.verdict == EXPLAINED_WHOLLY
    assert [mistake.text for mistake in found.diagnosis.best.mistakes] == [
        "vertex 3 logged instead of the centre of mass"
    ]


@pytest.mark.parametrize("offset", [None, (0.0, 0.0, 0.18)])
def test_an_offset_that_was_measured_is_tried_as_it_is(tmp_path, offset):
    """Of any size it explains a part of anything, and a start elsewhere with other mistakes was named instead."""
    scene = read_scene("die-vertex")
    pose = correct_program(scene, 0).output(np.linspace(0.0, 1.0, 26), FINE)
    measured = measure(Trajectory(write_poses(tmp_path / "a.csv", pose.times, pose.x, pose.q), scene, {}), scene)
    context = replace(context_of(scene, 0, measured), offset=None if offset is None else np.array(offset))
    [point] = [each for each in hypotheses(context) if each.name == "constant-offset-in-body-axes"]
    assert point.values == ((0.0, 0.0, 0.0),) + ((offset,) if offset else ())
    assert point.vague == (offset is None)
    moved = Explanation((Mistake(point, (0.0, 0.0, 0.17999)),), 0.0, 0.0, True, False, 0.0, 0.0)
    assert moved.odd_values == (offset is None), "what rows show by themselves needs no plain value"
