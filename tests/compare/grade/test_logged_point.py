"""A point of the body logged instead of its centre of mass has its name, whatever the body."""

import numpy as np
import pytest

from tumble.compare.grade.grade import EXPLAINED_WHOLLY, grade
from tumble.compare.grade.model.program_model import FINE, correct_program, output_points
from tumble.scenarios.read import read_scene

# Eight points that are no corners of a box: all of them are at x > 0.
EIGHT = [[0.3, 0, 0], [0.3, 0.1, 0], [0.2, 0, 0.1], [0.1, 0.2, 0], [0.2, -0.2, 0.1], [0.1, 0, 0.2], [0.1, 0, 0]]
EIGHT += [[0.2, 0.1, 0.1]]
SCENE = """
title = "Skewed body in the air"
duration = 1.0
samples = 25
step = 0.001
[body]
shape = "rigid"
mass = 1.7
inertia = [[0.03, 0.004, -0.002], [0.004, 0.04, 0.003], [-0.002, 0.003, 0.05]]
points = {points}
velocity = [0.4, 2.0, -0.7]
angular_velocity = [1.0, 2.0, -0.5]
"""


@pytest.mark.parametrize("count", [5, 8])
def test_a_vertex_logged_has_its_name(tmp_path, count):
    (tmp_path / "skewed.toml").write_text(SCENE.format(points=EIGHT[:count]))
    scene = read_scene(str(tmp_path / "skewed.toml"))
    pose = correct_program(scene, 0).output(np.linspace(0.0, 1.0, 26), FINE)
    x = pose.x + pose.axes @ output_points(scene.body)[3]
    rows, header = np.column_stack((pose.times, x, pose.q)), "t_s,x_m,y_m,z_m,qw,qx,qy,qz"
    np.savetxt(tmp_path / "a.csv", rows, "%.12g", ",", header=header, comments="", encoding="utf-8")
    found = grade(tmp_path / "a.csv", scene, {})
    assert found.verdict == EXPLAINED_WHOLLY
    assert [mistake.text for mistake in found.diagnosis.best.mistakes] == [
        "vertex 3 logged instead of the centre of mass"
    ]
