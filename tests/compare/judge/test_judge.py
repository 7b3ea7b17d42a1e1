"""Errors, drifts and what goes wrong silently, each shown on a planted flight."""

from dataclasses import replace

import numpy as np
import pytest

from tumble.compare.judge.agreement import agreements
from tumble.compare.judge.errors import Run
from tumble.compare.run.engines.registry import Finding
from tumble.compare.run.flight import Trajectory
from tumble.compare.run.precision import ROUNDINGS
from tumble.compare.run.status import Failure, Status
from tumble.compare.tables.runs import run_row
from tumble.scenarios.frames import vertices
from tumble.scenarios.read import read_scene
from tumble.scenarios.truth import truth

SCENE = read_scene("brick-tumble")
SINGLE = ROUNDINGS["single"]
TRUTH = truth(SCENE)


def planted(change=lambda states: states, notes=(), scene=SCENE, true=TRUTH) -> Run:
    states = change(true.states.copy())
    flight = Trajectory(scene.rows, states, vertices(states, scene.body.points), 4000, 0.004, notes)
    return Run(scene, "mine", "planted", scene.step, flight, true)


def shifted(states, by=1e-3):
    states[..., 0] += by
    return states


def test_the_truth_itself_is_ok():
    run = planted()
    assert run.status == "ok"
    assert (run.distances <= run.limits[..., None]).all(), "vertices in doubles are within what doubles can be held to"
    assert max(map(abs, run.drifts)) < 1e-14


def test_errors_are_those_of_the_vertices():
    run = planted(shifted)
    assert run.distances == pytest.approx(1e-3)
    row = run_row(run)
    assert (row.max_error_m, row.rms_error_m, row.final_error_m) == pytest.approx((1e-3, 1e-3, 1e-3))
    assert (row.wall_ns_per_step, row.wall_per_sim_s) == pytest.approx((1000.0, 0.004 / SCENE.duration))


def test_q_and_minus_q_are_one_attitude():
    def negated(states):
        states[..., 3:7] *= -1
        return states

    assert (planted(negated).distances == planted().distances).all()


def test_drifts_have_sign_and_scale():
    def spun_up(states):
        states[-1, :, 10:13] *= 1.1
        return states

    energy, momentum, angular_momentum = planted(spun_up).drifts
    assert angular_momentum == pytest.approx(0.1)
    assert momentum == 0
    assert 0 < energy <= 0.21 + 1e-12

    def slowed(states):
        states[-1, :, 10:13] *= 0.9
        return states

    assert planted(slowed).drifts[0] < 0


def test_rounding_a_step_is_no_hidden_damping_in_single_precision_and_damping_is():
    def slower(by):
        def change(states):
            states[1:, :, 7:10] *= 1.0 - by
            return states

        return planted(change)

    rounded, damped = slower(1.3e-4), slower(1e-2)
    assert "as by damping" in rounded.reason, "doubles do not round like that"
    assert replace(rounded, rounding=SINGLE).status == "ok", "4000 roundings of 6e-8"
    assert "as by damping" in replace(damped, rounding=SINGLE).reason


def frozen(states):
    return np.broadcast_to(states[0], states.shape).copy()


def without_gyroscopic_torque(states):
    states[..., 10:13] = states[0, :, 10:13]
    return states


def lost_at_the_end(states):
    states[-1] = np.nan
    return states


@pytest.mark.parametrize(
    ("change", "status"),
    [
        (frozen, "flagged: frozen: the body never moved"),
        (without_gyroscopic_torque, "flagged: lost gyroscopic torque"),
        (lost_at_the_end, f"diverged at {SCENE.times[-1]:.6g} s"),
    ],
)
def test_what_went_wrong_silently_is_said(change, status):
    assert planted(change).outcome.startswith(status)


def test_hidden_damping_is_said():
    scene = read_scene("die-straight")
    true = truth(scene)

    def slowed(states):
        states[..., 7:10] *= np.exp(-0.04 * scene.rows)[:, None, None]
        return states

    assert "velocity of the centre of mass off by" in planted(slowed, scene=scene, true=true).reason
    assert planted(scene=scene, true=true).status == "ok"


def test_the_engines_own_audit_comes_first():
    assert (
        planted(frozen, (Finding("clamped", "clamped at 100 m/s"),)).outcome
        == "flagged: clamped at 100 m/s; frozen: the body never moved"
    )


def test_no_flight_is_a_row_with_its_reason():
    run = replace(planted(), answer=Failure(Status.TIMEOUT, "no answer within 1 s"))
    row = run_row(run)
    assert (row.status, row.max_error_m, row.steps) == ("timeout", None, None)


def test_those_that_share_a_mistake_are_found():
    def almost(states):
        return shifted(states, 1e-3 + 1e-12)

    def other(states):
        return shifted(states, -1e-3)

    pairs = list(agreements([planted(shifted), planted(almost), planted(other), planted()]))
    assert len(pairs) == 1
    assert pairs[0].apart_m == pytest.approx(1e-12, rel=1e-2)
    assert pairs[0].error_a_m == pytest.approx(1e-3)
