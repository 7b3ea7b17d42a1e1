"""The true readings of sensors: their bound against the second formulation, closed forms, and what is left out."""

from dataclasses import replace

import gmpy2
import numpy as np
import pytest
from gmpy2 import mpfr
from random_scenes import drawn
from second_truth import BITS, sensor_readings

from tumble.scenarios.read import read_scene
from tumble.scenarios.truth.sensors import sensor_truth, sensor_truths

MOUNTED = """
[[sensor]]
name = "mag"
kind = "magnetometer-direction"
rate = {rate!r}
point = {point}
orientation = {orientation}
field = [0.3, -1.0, 0.4]
"""


def worst(path, told=None):
    """How far a reading is off over its bound, and how far, at the worst; and how many instants are known."""
    told = told or sensor_truths(read_scene(str(path)))[0]
    known = np.flatnonzero([not why for why in told.why])
    exact = sensor_readings(path, 0, told.times[known])
    ratios, sizes = [], []
    with gmpy2.context(precision=BITS):
        for row, vectors in zip(known, exact, strict=True):
            for column, (name, exact_vector) in enumerate(
                zip(("specific_force", "angular_velocity", "field_direction"), vectors, strict=True)
            ):
                value = getattr(told, name)[row, 0]
                off = float(
                    gmpy2.sqrt(sum((a - mpfr(float(b))) ** 2 for a, b in zip(exact_vector, value, strict=True)))
                )
                ratios.append(off / told.bound[row, 0, (0, 1, 3)[column]])
                sizes.append(off)
    return max(ratios), max(sizes), len(known)


def drawn_with_sensor(family, folder):
    random = np.random.default_rng(28)
    text = drawn(family, 1001)
    duration = float(text.partition("duration = ")[2].partition("\n")[0])
    mounted = random.normal(size=3).tolist()
    path = folder / "drawn.toml"
    sensor = MOUNTED.format(rate=4 / duration, point=mounted, orientation=random.normal(size=4).tolist())
    path.write_text(text + sensor, encoding="utf-8")
    return path


@pytest.mark.parametrize("family", ["box, impulse", "stiff tether", "drag", "floor"])
def test_the_bound_holds_for_random_scenes_and_sensors(family, tmp_path):
    ratio, off, known = worst(drawn_with_sensor(family, tmp_path))
    assert known >= 3
    assert ratio <= 1
    assert off > 0, "nothing is rounded: the check is moot"


def test_a_point_that_is_rounded_once_more_breaks_the_bound(tmp_path):
    path = drawn_with_sensor("box, impulse", tmp_path)
    scene = read_scene(str(path))
    (sensor,) = scene.sensors
    off = replace(sensor, point_body=sensor.point_body * (1 + 2.0**-46))
    ratio, _, _ = worst(path, sensor_truth(scene, off))
    assert ratio > 2


SPIN = """
title = "spin about z in free fall"
duration = 1.0
samples = 4
step = 0.01
gravity = [0.0, -9.81, 0.0]
[body]
shape = "box"
size = [0.4, 0.15, 0.1]
mass = 2.4
angular_velocity = [0.0, 0.0, 3.0]
[[impulse]]
time = 0.5
value = [0.0, 4.8, 0.0]
point_body = [0.0, 0.0, 0.0]
[[sensor]]
name = "out"
kind = "imu"
rate = 10.0
point = [0.1, 0.0, 0.0]
[[sensor]]
name = "centre"
kind = "imu"
rate = 10.0
[[sensor]]
name = "mean"
kind = "imu"
rate = 10.0
average = true
"""


def test_closed_forms_and_what_is_left_out(tmp_path):
    path = tmp_path / "spin.toml"
    path.write_text(SPIN, encoding="utf-8")
    out, centre, mean = sensor_truths(read_scene(str(path)))
    left = [k for k, why in enumerate(out.why) if why]
    assert out.times[left].tolist() == [0.5]
    assert np.isnan(out.specific_force[left]).all()
    assert (out.angular_velocity == [0.0, 0.0, 3.0]).all(), "the gyro has a reading at an impulse"
    there = np.delete(np.arange(11), left)
    # Towards the axis with w^2 r; free fall is weightless, to the last bit.
    np.testing.assert_allclose(out.specific_force[there, 0], np.tile([-0.9, 0.0, 0.0], (10, 1)), rtol=4e-16)
    assert (centre.specific_force[there] == 0).all()
    assert (centre.bound[there, :, 0] == 0).all()
    # A mean over the last 0.1 s has the impulse of 4.8 N s along y on 2.4 kg, when x has turned by 1.5 rad.
    expected = np.zeros((10, 3))
    expected[4] = 20 * np.sin(1.5), 20 * np.cos(1.5), 0.0
    np.testing.assert_allclose(mean.specific_force[1:, 0], expected, atol=1e-14)
    assert mean.why == ("no interval before the first reading", *[""] * 10)
    assert np.isnan(mean.specific_force[0]).all()


def test_a_mean_is_that_of_dense_readings(tmp_path):
    scene = read_scene(str(drawn_with_sensor("tether", tmp_path)))
    (sensor,) = scene.sensors
    mean = sensor_truth(scene, replace(sensor, average=True))
    dense = sensor_truth(scene, sensor, np.linspace(0.25, 0.5, 4001)).specific_force[:, 0]
    simpson = (dense[0:-1:2] + 4 * dense[1::2] + dense[2::2]).sum(axis=0) / 12000
    np.testing.assert_allclose(mean.specific_force[2, 0], simpson, rtol=1e-11, atol=1e-11)
    assert (mean.bound[2, 0] < 1e-11).all()
