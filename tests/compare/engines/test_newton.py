"""Newton in its environment, where that is there: the laws, a step by hand, what its defaults damp, and MuJoCo Warp."""

from dataclasses import replace

import numpy as np
import pytest
from apart import broken_laws, engine, flight, throw

from tumble.compare.run.engines.brick import scene
from tumble.compare.run.running_engines import launched
from tumble.scenarios.scene import Sensor, frozen_array

EPS = float(np.finfo(np.float32).eps)
MOMENTS = np.array([1.0, 2.0, 3.0])
START = throw(v=(0.5, 0.0, 0.0), w=(0.2, 1.0, 0.3))
STEP = 1 / 32
ARM = Sensor("arm", "imu", 10.0, frozen_array((0.1, 0.0, 0.0)), frozen_array((1.0, 0.0, 0.0, 0.0)))
EXPLICIT = ("semi-implicit", "featherstone", "xpbd")


def test_it_keeps_the_laws():
    assert broken_laws("newton", *EXPLICIT) == {}


@pytest.mark.parametrize("method", EXPLICIT)
@pytest.mark.parametrize("size", [1.0, 1e-12])
def test_one_step_is_explicit_euler_and_the_attitude_is_turned_to_first_order(method, size):
    """However small the body: w' = w + h I^-1 (L x w), and q' is q + h/2 w' q, normalised."""
    with engine("newton", method) as ours:
        state = flight(ours, START, STEP, STEP, mass=size, moments=size * MOMENTS).states[-1, 0]
    spin = START[0, 10:13]
    w = spin + STEP / MOMENTS * np.cross(MOMENTS * spin, spin)
    np.testing.assert_allclose(state[10:13], w, rtol=0, atol=4 * EPS)
    q = np.array([1.0, *(STEP / 2 * w)])
    np.testing.assert_allclose(state[3:7], q / np.linalg.norm(q), rtol=0, atol=4 * EPS)


def test_what_its_defaults_damp_is_told():
    with engine("newton", "semi-implicit+defaults") as shipped:
        flown = flight(shipped, throw(w=(0.0, 0.0, 1.0)), STEP, 1.0, mass=1.0, moments=MOMENTS)
    (found,) = flown.findings
    assert found.kind == "damped"
    assert flown.states[-1, 0, 12] == pytest.approx((1 - 0.05 * STEP) ** 32, abs=100 * EPS)


def test_mujoco_warp_steps_as_mujocos_implicitfast_does():
    question = replace(scene(START, mass=1.0, moments=MOMENTS), duration=0.5, times=np.array([0.5]))
    with engine("newton", "mujoco") as ours, launched(["mujoco:implicitfast"]) as (reference,):
        ours.worker.time_limit = 300.0  # forty milliseconds a step on a busy machine
        found, expected = ours.simulate(question, "mujoco", STEP), reference.simulate(question, "implicitfast", STEP)
    np.testing.assert_allclose(found.states[-1], expected.states[-1], rtol=0, atol=16 * 10 * EPS)


def test_mujoco_warps_imu_reads_what_a_body_feels_and_the_others_are_read_by_differences():
    with engine("newton", "mujoco", "mujoco+held", "xpbd") as ours:
        said = [
            ours.ensure_running() or ours.worker.check_failure("sensors", method)
            for method in ("mujoco", "mujoco+held", "xpbd")
        ]
        spin = replace(scene(throw(w=(0.0, 0.0, 3.0))), duration=0.1, sensors=(ARM,))
        read = {method: ours.read_sensors(spin, method, 0.01) for method in ("mujoco", "xpbd")}
    assert said[:2] == ["", ""]
    assert str(said[2]) == "skipped: it has no sensors: their readings are differences of its velocities"
    assert {method: found.how for method, found in read.items()} == {"mujoco": "sensor", "xpbd": "differences"}
    np.testing.assert_allclose(read["mujoco"].values[0][:, :6], [[-0.9, 0, 0, 0, 0, 3.0]] * 2, atol=40 * EPS)


def test_moments_that_no_body_has_are_taken_as_they_are_and_mujoco_refuses_them():
    flat = scene(START, mass=1.0, moments=(1.0, 1.0, 10.0))
    with engine("newton", "xpbd", "mujoco") as ours:
        flown = ours.simulate(replace(flat, duration=STEP, times=np.array([STEP])), "xpbd", STEP)
        assert str(ours.simulate(flat, "mujoco", STEP)).startswith("skipped: MuJoCo refuses the body")
    spin = START[0, 10:13]
    w = spin + STEP / np.array([1.0, 1.0, 10.0]) * np.cross([0.2, 1.0, 3.0], spin)
    np.testing.assert_allclose(flown.states[-1, 0, 10:13], w, rtol=0, atol=4 * EPS)
