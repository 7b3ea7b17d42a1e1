"""The reference motion of a grade: how far it is from the truth, row by row."""

from dataclasses import replace

import numpy as np
import pytest

from tumble.compare.grade.model.reference import Reference
from tumble.scenarios.read import read_scene
from tumble.scenarios.truth import truth

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


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    path = tmp_path_factory.mktemp("sensitive") / "sensitive.toml"
    path.write_text(SENSITIVE)
    return read_scene(str(path))


def test_the_reference_is_within_its_resolution_at_every_row_and_early_ones_are_precise(scene):
    times = np.linspace(0.0, 0.6, 61)
    reference = Reference(scene)
    allowed = reference.resolution(0, times)
    assert (np.diff(allowed) >= 0.0).all()
    assert allowed[-1] > 30 * allowed[10]
    some = np.array([3, 14, 25, 38, 52])  # none of them is looked at
    true = truth(replace(scene, times=times[some]), with_input_error=False).vertices[-len(some) :, 0]
    off = np.linalg.norm(reference.vertices(0, times[some]) - true, axis=-1).max(axis=-1)
    assert (off <= allowed[some]).all()
