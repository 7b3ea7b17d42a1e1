"""What engines lose by being handed doubles, what is lost by taking moments for equal, and stiff tethers."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from mpmath import MPContext
from second_truth import worst

from tumble.scenarios.read import read_scene
from tumble.scenarios.truth import truth
from tumble.scenarios.truth.resolution import settle
from tumble.scenarios.truth.rounded_inputs import input_rounding_error
from tumble.scenarios.truth.throw import read_throw

# A needle along oblique axes: its axes in doubles are a turn of 1e-16, which its least moment feels a million times.
NEEDLE = """
title = "needle along oblique axes"
duration = 1.0
samples = 4
step = 0.01
[body]
shape = "rigid"
mass = 2.0
inertia = [[0.64000036, -0.47999952, 0.0], [-0.47999952, 0.36000064, 0.0], [0.0, 0.0, 1.0]]
points = [[0.1, 0.2, 0.3], [-0.2, 0.1, 0.05]]
angular_velocity = [0.2, -0.1, 0.4]
"""
TETHER = """
title = "a corner on a tether of {stiffness} N/m"
duration = {duration}
samples = 3
step = 1e-6
[body]
shape = "box"
size = [0.4, 0.15, 0.1]
mass = 2.4
position = [0.3, -1.2, 0.7]
angular_velocity = [0.9, -1.1, 1.4]
velocity = [0.5, 3.0, -1.0]
[[tether]]
vertex = 7
anchor = [0.5, -1.125, 0.75]
stiffness = {stiffness}
"""


RIGID = """
title = "nearly symmetric"
duration = 10000.0
times = [1000.0, 10000.0]
step = 0.01
[body]
shape = "rigid"
mass = 2.0
inertia = [[2.0, 0.0, 0.0], [0.0, {second!r}, 0.0], [0.0, 0.0, 3.0]]
points = [[0.1, 0.2, 0.3], [-0.2, 0.1, 0.05]]
orientation = [0.8, 0.2, -0.4, 0.4]
angular_velocity = [0.9, -1.1, 1.4]
"""


def read(folder, text):
    (folder / "written.toml").write_text(text, encoding="utf-8")
    return read_scene(str(folder / "written.toml"))


def test_what_doubles_cost_is_how_far_the_truth_of_the_doubles_is(tmp_path):
    scene = read(tmp_path, NEEDLE)
    written, rounded_inputs = truth(scene), truth(replace(scene, written=None))
    apart = np.linalg.norm(rounded_inputs.vertices - written.vertices, axis=-1).max()
    assert input_rounding_error(scene, written) == pytest.approx(apart, rel=1e-6)
    assert apart > 1e4 * written.bound.max()
    # A scene that is its doubles costs nothing.
    assert input_rounding_error(replace(scene, written=None), rounded_inputs) == 0


@pytest.mark.parametrize("apart", [4.440892098500626e-16, 8e-15])
def test_moments_a_few_last_bits_apart_are_not_taken_for_equal(apart, tmp_path):
    flat = read(tmp_path, RIGID.format(second=2.0))
    scene = read(tmp_path, RIGID.format(second=2.0 + apart))
    true, equal = truth(scene), truth(flat)
    off = np.linalg.norm(true.vertices - equal.vertices, axis=-1).max(axis=-1)[:, 0]
    # After 1e4 s they have made a difference, which the bound would not bear.
    assert off[-1] > 10 * true.bound[-1, 0]
    # It is in proportion to what they differ by, so nothing smaller was left out.
    mp, wider = MPContext(), 2.0**20
    throw = read_throw(scene, 0)

    def turned(times_apart):
        tensor = throw.solid.tensor.copy()
        tensor[1, 1] = 2 + times_apart * Fraction(2.0 + apart - 2.0)
        pose = settle(mp, throw._replace(solid=throw.solid._replace(tensor=tensor)))[1].poses[-1]
        return pose.axes

    near, far = turned(1) - turned(0), turned(Fraction(wider)) - turned(0)
    assert np.abs((far / wider - near).astype(float)).max() <= 0.01 * np.abs(near.astype(float)).max()


@pytest.mark.parametrize(("stiffness", "duration"), [("1e8", 0.001), ("1e9", 0.0003)])
def test_stiff_tethers_are_known_to_a_millionth_of_a_millionth(stiffness, duration, tmp_path):
    # p - anchor is 1e-5 m of coordinates of a metre: in doubles it has 11 digits.
    scene = read(tmp_path, TETHER.format(stiffness=stiffness, duration=duration))
    answer = truth(scene)
    assert answer.bound.max() <= 1e-12 * np.linalg.norm(scene.body.points, axis=1).max()
    ratio, off = worst(tmp_path / "written.toml", answer)
    assert ratio <= 1
    assert off <= 1e-12 * np.linalg.norm(scene.body.points, axis=1).max()
