"""The reference motion of a grade: how far it is from the truth, row by row, and where it ends."""

from dataclasses import replace
from pathlib import Path
from typing import cast

import numpy as np
import pytest
from pose_files import write_poses

from tumble.compare.grade.file_grade import FileGrade
from tumble.compare.grade.grade import TASKS, grade
from tumble.compare.grade.model.program_model import FINE
from tumble.compare.grade.model.reference import Reference
from tumble.compare.grade.results import json_document
from tumble.compare.grade.verdicts import CORRECT_TO_RESOLUTION, RIGHT, TOO_LITTLE, UNEXPLAINED
from tumble.reports.grade import headline
from tumble.scenarios.read import read_scene, scene_of
from tumble.scenarios.truth import NoTruth, truth

# A light body, struck and pulled by a tether: what it is off by grows fast.
SENSITIVE = """
title = "Light body on a tether"
duration = 0.6
samples = 12
step = 0.001
gravity = [0.0, 0.0, -10.0]
[body]
shape = "box"
size = [0.017, 0.009, 0.022]
mass = 15.0
position = [-1.1, 1.1, -0.6]
orientation = [0.7, 0.1, 0.7, -0.1]
velocity = [-0.3, -0.1, -1.6]
angular_velocity = [0.0, 0.0, 0.0]
[[impulse]]
time = 0.3
value = [-0.02, 0.2, 0.15]
vertex = 3
[[tether]]
vertex = 0
anchor = [-0.1, 1.3, -0.3]
stiffness = 400.0
damping = 0.0
rest_length = 0.67
"""


def scene_named(name, text):
    return scene_of(text, Path(f"{name}.toml"), name)


def test_the_reference_is_within_its_resolution_at_every_row_and_early_ones_are_precise():
    scene = scene_named("sensitive", SENSITIVE)
    times = np.linspace(0.0, 0.6, 61)
    reference = Reference(scene)
    allowed = reference.resolution(0, times)
    assert (np.diff(allowed) >= 0.0).all()
    assert allowed[-1] > 30 * allowed[10]
    some = np.array([3, 14, 25, 38, 52])  # none of them is looked at
    true = truth(replace(scene, times=times[some]), with_input_error=False).vertices[-len(some) :, 0]
    off = np.linalg.norm(reference.vertices(0, times[some]) - true, axis=-1).max(axis=-1)
    assert (off <= allowed[some]).all()


def test_the_kernel_takes_shorter_steps_where_a_motion_amplifies_its_errors():
    times = np.linspace(0.0, 0.6, 13)
    sensitive, calm = Reference(scene_named("sensitive", SENSITIVE)), Reference(read_scene("drag-stiff"))
    assert sensitive.fineness(0) < FINE == calm.fineness(0)
    allowed = sensitive.resolution(0, times)[-1]
    sensitive._fineness[0] = FINE
    assert sensitive.resolution(0, times)[-1] > 30 * allowed


# Too sensitive for a truth up to its end: after 0.8 s the last bit of its numbers decides.
CHAOTIC = """
title = "Struck on a tether"
duration = 2.0
samples = 20
step = 0.001
gravity = [0.0, -3.71, 0.0]

[body]
shape = "box"
size = [0.0234, 0.00649, 0.0144]
mass = 5.32
position = [-0.957, -1.77, -0.505]
orientation = [-0.94, 0.23, -0.03, -0.26]
velocity = [-0.6, 0.536, 3.23]
angular_velocity = [1.12, -0.0111, 0.00283]

[[impulse]]
time = 0.3
value = [-0.0772, 0.0397, 0.0346]
vertex = 7

[[tether]]
vertex = 0
anchor = [-1.35, -0.835, -0.333]
stiffness = 400.0
damping = 0.0
rest_length = 0.0
"""


@pytest.mark.parametrize(("off_m", "verdicts"), [(0.0, RIGHT), (0.3, (UNEXPLAINED,))])
def test_rows_after_the_end_of_the_reference_are_not_graded(tmp_path, off_m, verdicts):
    """Up to there the file is right or wrong; what is after it may be anything."""
    chaotic = scene_named("chaotic", CHAOTIC)
    times = np.linspace(0.0, 2.0, 101)
    poses = Reference(chaotic).states(0, times)[:, 0:7]
    poses[times > 1.9, 0] = 100.0
    poses[1:, 0] += off_m * np.sign(np.random.default_rng(1).standard_normal(100))
    file, done = write_poses(tmp_path / "struck.csv", times, poses), []
    found = grade(file, chaotic, {}, search_s=0.02, on_progress=lambda what, share=1.0: done.append(share))
    ends = found.measured.sample.times[-1]
    assert 0.3 < ends < 1.3
    assert found.measured.rows == np.searchsorted(times, ends) + 1
    assert found.verdict in verdicts
    assert found.measured.worst_m == pytest.approx(off_m, abs=1e-6)
    assert f". Rows after t = {ends:.6g} s are not graded" in headline(found)
    seen = cast(list[str], json_document(FileGrade(found, None))["seen"])[0]
    why = "the last bit of a number of the scene" if off_m else "it is accurate only to"
    assert why in seen
    assert headline(found).endswith(seen)
    assert sum(done) == pytest.approx(TASKS), "no task is told twice"


def test_a_reference_that_ends_at_the_first_row_grades_nothing(tmp_path):
    chaotic = scene_named("chaotic", CHAOTIC)
    times = np.array([0.0, 1.95, 2.0])
    poses = Reference(chaotic).states(0, times)[:, 0:7]
    with pytest.raises(NoTruth, match=r"there is no truth at the first sample|known until 0 s"):
        grade(write_poses(tmp_path / "late.csv", times, poses), chaotic, {})


# The truth is known to the end, but at last only to more than the body's size, as the line goes slack and taut.
KNOWN_BADLY = """
title = "Small box on a line"
duration = 5.0
samples = 20
step = 0.001
gravity = [0.0, 0.0, -10.0]

[body]
shape = "box"
size = [0.051, 0.0352, 0.0149]
mass = 1.32
position = [-0.295, -1.25, -1.25]
velocity = [-0.143, 3.13, -0.308]
angular_velocity = [0.959, 0.0758, -0.0308]

[[tether]]
vertex = 2
anchor = [-0.383, -2.31, -1.26]
stiffness = 6.14
damping = 0.0
rest_length = 0.64
"""


@pytest.mark.parametrize(("off_from_s", "is_right"), [(3.2, True), (0.85, False)])
def test_rows_in_which_the_resolution_hides_any_error_are_not_graded(tmp_path, off_from_s, is_right):
    """Rows before are graded: within the resolution at the end everything would be right."""
    scene = scene_named("badly", KNOWN_BADLY)
    times = np.linspace(0.0, 5.0, 51)
    poses = Reference(scene).states(0, times)[:, 0:7]
    poses[times > off_from_s, 0] += 0.03
    found = grade(write_poses(tmp_path / "line.csv", times, poses), scene, {}, search_s=0.02)
    assert (found.verdict in RIGHT) is is_right
    assert found.verdict != CORRECT_TO_RESOLUTION or found.measured.resolution_m < 1e-3 * 0.051
    assert "it is accurate only to 0.0" in headline(found)
    assert 1.0 < found.measured.sample.times[-1] < 3.2


def test_an_error_about_as_large_as_the_resolution_is_not_compared_with_the_digits(tmp_path):
    """A chaotic scene: the file has nanometres, and its last row is off by a little more than the reference may be."""
    scene = scene_named("badly", KNOWN_BADLY)
    times, reference = np.linspace(0.0, 5.0, 51), Reference(scene)
    poses = reference.states(0, times)[:, 0:7]
    poses[-1, 0] += 1.3 * reference.resolution(0, times)[-1]
    found = grade(write_poses(tmp_path / "line.csv", times, poses), scene, {}, search_s=0.02)
    assert found.verdict == TOO_LITTLE
    assert "the resolution of the reference allows about as much" in headline(found)
