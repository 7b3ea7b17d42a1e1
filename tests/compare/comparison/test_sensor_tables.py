"""sensors.csv and sensor-errors.csv: real engines, their own sensors and differences, and what is left out."""

from dataclasses import replace

import numpy as np
import pytest

import tumble
from tumble.compare.run.engines import brick, registry
from tumble.compare.run.engines.sensor_checks import SENSORS
from tumble.compare.run.flight import Trajectory, simulate
from tumble.compare.run.running_engines import launched
from tumble.compare.run.timing.timer import Pace, Ready

SPIN = tumble.Scene.box(
    (0.4, 0.15, 0.1), 2.4, name="spin", duration=1.0, samples=4, step=0.01, gravity=(0.0, -9.81, 0.0),
    angular_velocity=(0.0, 0.0, 3.0),
).with_impulse((0.0, 4.8, 0.0), time=0.5, point_body=(0.0, 0.0, 0.0))  # fmt: skip
SPIN = (
    SPIN.with_sensor("imu", rate=10.0, point=(0.1, 0.0, 0.0))
    .with_sensor("mean", "accelerometer", rate=10.0, point=(0.1, 0.0, 0.0), average=True)
    .with_sensor("field", "magnetometer-direction", rate=4.0, field=(0.0, 2.0, 0.0))
)


@pytest.fixture(scope="module")
def found():
    return tumble.compare(SPIN, ["tumble:exact", "mujoco:rk4", "pybullet:multibody"], progress=False)


def test_every_engine_reads_what_the_closed_form_says(found):
    table = found.sensors[found.sensors.sensor == "imu"]
    assert table.groupby("engine", sort=False).reading.first().tolist() == ["derivatives", "sensor", "differences"]
    for engine, rows in table.groupby("engine"):
        read = rows[rows.why == ""]
        assert len(rows) == 11
        force, spin = read[["ax_m_s2", "ay_m_s2", "az_m_s2"]], read[["wx_rad_s", "wy_rad_s", "wz_rad_s"]]
        # A difference over a step of 0.01 s is late by half of it: w^3 r dt / 2 = 0.0135 m/s2.
        within = 0.0137 if engine == "pybullet" else 1e-12
        off = np.linalg.norm(force.to_numpy() - [-0.9, 0.0, 0.0], axis=1)
        assert off.max() < within
        assert engine != "pybullet" or off.max() > 0.013
        np.testing.assert_allclose(spin, np.tile([0.0, 0.0, 3.0], (len(read), 1)), atol=1e-12)


def test_what_is_left_out_has_its_reason(found):
    table = found.sensors
    left = table[(table.why != "") & (table.sensor == "imu")].groupby("engine").t_s.apply(list)
    assert left.to_dict() == {"tumble": [0.5], "mujoco": [0.5], "pybullet": [0.0, 0.5]}
    at = table[(table.sensor == "imu") & (table.t_s == 0.5) & (table.engine == "mujoco")].iloc[0]
    assert "impulse" in at.why
    assert np.isnan([at.ax_m_s2, at.true_ax_m_s2, at.error_ax_m_s2]).all()
    assert at.wz_rad_s == pytest.approx(3.0)
    counts = found.sensor_errors.set_index(["engine", "sensor", "quantity"]).sort_index()
    assert counts.loc[("mujoco", "imu", "specific force"), ["readings", "left_out"]].tolist() == [10, 1]
    assert counts.loc[("mujoco", "imu", "angular velocity"), ["readings", "left_out"]].tolist() == [11, 0]


def test_a_mean_has_the_impulse_and_its_error_is_that_of_the_steps(found):
    rows = found.sensors[(found.sensors.sensor == "mean") & (found.sensors.t_s == 0.5)].set_index("engine")
    np.testing.assert_allclose(rows.true_ax_m_s2, -0.9 + 20 * np.sin(1.5), rtol=1e-14)
    np.testing.assert_allclose(rows.loc[["tumble", "mujoco"], "ay_m_s2"], 20 * np.cos(1.5), rtol=1e-10)


def test_a_field_keeps_its_direction_in_the_world(found):
    rows = found.sensors[(found.sensors.sensor == "field") & (found.sensors.engine == "tumble")]
    np.testing.assert_allclose(rows.mx, np.sin(3 * rows.t_s), atol=1e-12)
    assert rows.ax_m_s2.isna().all()


def test_a_scene_without_sensors_has_no_rows_and_the_same_bits(found):
    plain = tumble.compare(SPIN.replace(sensor=None), ["mujoco:rk4", "tumble:exact"], progress=False)
    assert len(plain.sensors) == len(plain.sensor_errors) == 0
    ours = found.vertex_errors.set_index(["engine", "t_s", "vertex"]).error_m
    theirs = plain.vertex_errors.set_index(["engine", "t_s", "vertex"]).error_m
    assert (ours.loc[theirs.index] == theirs).all()


PAYS = """
import numpy as np
METHODS, FEATURES = ("drift",), {"gravity"}
ABOUT = {"version": "1", "precision": "double", "switched_off": []}
def build(scene, method):
    if scene.sensors:
        raise NotImplementedError("it got sensors")
    return {}
def write(world, states): world["states"] = states.copy()
def advance(world, n, dt):
    for _ in range(n):
        world["states"][:, 0:3] += dt * world["states"][:, 7:10]
def read(world): return world["states"]
"""


def test_a_run_that_is_measured_has_no_sensors(tmp_path):
    (tmp_path / "pays.py").write_text(PAYS)
    scene = replace(brick.scene(gravity=brick.GRAVITY), sensors=SENSORS)
    with launched([str(tmp_path / "pays.py")]) as (pays,):
        assert isinstance(pays.simulate(scene, "drift", 0.01), Trajectory)
        assert isinstance(pays.prepare_timer("it", scene, "drift", Pace(((10, 0.01),), True)), Ready)
        assert str(pays.read_sensors(scene, "drift", 0.01)) == "skipped: it got sensors"


@pytest.mark.parametrize("contestant", ["tumble:exact", "tumble:rkmk4", "mujoco:euler", "mujoco:rk4"])
def test_a_world_with_sensors_moves_by_the_same_bits(contestant):
    name, _, method = contestant.partition(":")
    plain = brick.scene(gravity=brick.GRAVITY)
    runs = [simulate(registry.load(name), scene, method, 0.01) for scene in (plain, replace(plain, sensors=SENSORS))]
    assert runs[0].states.tobytes() == runs[1].states.tobytes()
    assert runs[0].vertices.tobytes() == runs[1].vertices.tobytes()
