"""An account flies and writes as the program it stands for: clocks, steps, damping, impulses that last."""

from dataclasses import replace

import numpy as np
import pytest

from tumble.compare.grade.model.kernel.dynamics import (
    EXPLICIT,
    EXPONENTIALLY,
    IMPLICITLY,
    LAST,
    LINEARLY,
    MOMENTUM,
    QUATERNION,
    Scheme,
)
from tumble.compare.grade.model.program_model import ALONG_ARCS, FINE, STRAIGHT, Clock, Stroke, truthful, with_writing
from tumble.scenarios.read import read_scene
from tumble.scenarios.truth import truth

TIMES = np.array([0.1, 0.25, 0.5])
STRAIGHT_FALL, TUMBLE = read_scene("die-straight"), read_scene("die-vertex")
STEP = 0.01


def stepped(scene, fall=0.5, **changes):
    """Return the account of a program that takes steps of STEP."""
    return replace(truthful(scene, 0), scheme=Scheme(STEP, QUATERNION, EXPLICIT, False, fall), **changes)


def test_a_clock_has_reached_its_last_whole_tick():
    np.testing.assert_allclose(Clock(tick=0.1).reached(np.array([0.05, 0.1, 0.19, 0.3])), [0.0, 0.1, 0.1, 0.3])
    np.testing.assert_allclose(Clock(tick=0.1, lag=1.0).reached(np.array([0.05, 0.1, 0.3])), [0.0, 0.0, 0.2])
    np.testing.assert_allclose(Clock(rate=2.0, offset=-0.1).reached(np.array([0.0, 0.3])), [0.0, 0.5])
    assert Clock(stop=0.2).reached(np.array([0.9]))[0] == 0.2
    np.testing.assert_allclose(Clock(tick=0.1).share(np.array([0.1, 0.125, 0.19]), 0.0), [0.0, 0.25, 0.9], atol=1e-12)


def test_the_truthful_account_is_the_truth():
    scene = replace(TUMBLE, times=TIMES)
    true = truth(scene)
    rows = truthful(scene, 0).flown(TIMES, FINE)
    # FINE leaves 1e-9 of a radian turned; the die turns by a few.
    np.testing.assert_allclose(rows[:, 0:3], true.states[1:, 0, 0:3], atol=1e-9)
    np.testing.assert_allclose(rows[:, 15:18], true.states[1:, 0, 10:13], rtol=1e-8)
    points = rows[:, 3:12].reshape(-1, 3, 3) @ scene.body.points.T
    np.testing.assert_allclose(rows[:, 0:3, None] + points, np.swapaxes(true.vertices[1:, 0], 1, 2), atol=1e-9)


@pytest.mark.parametrize(
    ("fall", "steps"), [(0.0, lambda n: n * (n - 1)), (1.0, lambda n: n * (n + 1)), (0.5, np.square)]
)
def test_steps_fall_as_the_old_velocity_the_new_or_their_mean_has_it(fall, steps):
    account = stepped(STRAIGHT_FALL, fall)
    start = account.flown(np.array([0.0]))[0]
    n = np.round(TIMES / STEP)
    # x = x0 + v0 t + g dt^2 n (n -+ 1)/2: the sum of the velocities, v0 + k g dt, that n steps have moved by.
    right = start[0:3] + TIMES[:, None] * start[12:15] + account.gravity * (STEP**2 * steps(n) / 2)[:, None]
    np.testing.assert_allclose(account.flown(TIMES)[:, 0:3], right, atol=1e-12)


@pytest.mark.parametrize(
    ("decays", "share"),
    [(LINEARLY, lambda c: 1 - c), (EXPONENTIALLY, lambda c: np.exp(-c)), (IMPLICITLY, lambda c: 1 / (1 + c))],
)
def test_a_step_damps_by_a_share_of_the_velocity(decays, share):
    free = replace(STRAIGHT_FALL, gravity=None)
    account = stepped(free, damping=(3.0, 0.0, 0.0, 0.0, 0.0), damps=LAST, decays=decays)
    start = account.flown(np.array([0.0]))[0]
    left = share(3.0 * STEP) ** np.round(TIMES / STEP)
    np.testing.assert_allclose(account.flown(TIMES)[:, 12:15], left[:, None] * start[12:15], rtol=1e-12)


def test_momentum_that_is_kept_is_kept_and_an_explicit_step_gains_energy():
    brick = read_scene("brick-tumble")
    moments = brick.body.moments
    rows = {
        spin: replace(truthful(brick, 0), scheme=Scheme(STEP, QUATERNION, spin, False, 0.5)).flown(TIMES)
        for spin in (EXPLICIT, MOMENTUM)
    }
    w_body = {
        spin: np.einsum("tji,tj->ti", each[:, 3:12].reshape(-1, 3, 3), each[:, 15:18]) for spin, each in rows.items()
    }
    size = {spin: np.linalg.norm(moments * w, axis=1) for spin, w in w_body.items()}
    np.testing.assert_allclose(size[MOMENTUM], size[MOMENTUM][0], rtol=1e-12)
    energy = (moments * w_body[EXPLICIT] ** 2).sum(axis=1)
    assert (np.diff(energy) > 1e-6 * energy[0]).all()


def test_an_impulse_that_lasts_has_moved_the_body_by_half_of_its_time_less():
    account = truthful(replace(STRAIGHT_FALL, gravity=None), 0)
    lasting = replace(account, stroke=Stroke(lasts=0.1))
    at_once, late = (each.flown(TIMES, FINE) for each in (account, lasting))
    np.testing.assert_allclose(late[:, 12:15], at_once[:, 12:15], rtol=1e-9)
    gained = account.flown(np.array([0.0]))[0, 12:15] - STRAIGHT_FALL.start[0, 7:10]
    np.testing.assert_allclose(at_once[:, 0:3] - late[:, 0:3], np.tile(0.05 * gained, (3, 1)), atol=1e-9)


def test_rows_between_ticks_lie_on_the_line_and_the_arc():
    scene = replace(TUMBLE, gravity=None)
    for between in (STRAIGHT, ALONG_ARCS):
        account = replace(truthful(scene, 0), clock=Clock(tick=0.02, between=between))
        pose, ends = account.written(np.array([0.105])), account.flown(np.array([0.1, 0.12]))
        np.testing.assert_allclose(pose.x[0], 0.75 * ends[0, 0:3] + 0.25 * ends[1, 0:3], atol=1e-12)
        np.testing.assert_allclose(pose.axes[0].T @ pose.axes[0], np.eye(3), atol=1e-12)


def test_writings_are_done_in_their_order():
    account = truthful(STRAIGHT_FALL, 0)
    doubled = with_writing(account, lambda pose: pose._replace(x=2.0 * pose.x))
    moved = with_writing(doubled, lambda pose: pose._replace(x=pose.x + 1.0))
    np.testing.assert_allclose(moved.written(TIMES).x, 2.0 * account.written(TIMES).x + 1.0)
