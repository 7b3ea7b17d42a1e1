"""A program model simulates and writes as its program does: clocks, steps, damping, impulses that last."""

from dataclasses import replace

import numpy as np
import pytest

from tumble.compare.grade.model.kernel.dynamics import (
    EXPLICIT,
    EXPONENTIALLY,
    IMPLICITLY,
    IN_BODY,
    LAST,
    LINEARLY,
    MOMENTUM,
    QUATERNION,
    RUNGE_KUTTA,
    VERLET,
    Scheme,
)
from tumble.compare.grade.model.kernel.reading import EXTRAPOLATED, LINEAR, SLERP
from tumble.compare.grade.model.program_model import (
    FINE,
    Clock,
    ImpulseApplication,
    correct_program,
    with_output_transform,
)
from tumble.scenarios.read import read_scene
from tumble.scenarios.truth import truth

TIMES = np.array([0.1, 0.25, 0.5])
STRAIGHT_FALL, TUMBLE = read_scene("die-straight"), read_scene("die-vertex")
STEP = 0.01


def stepped(scene, fall=0.5, **changes):
    """Return the model of a program that takes steps of STEP."""
    return replace(correct_program(scene, 0), scheme=Scheme(STEP, QUATERNION, EXPLICIT, False, fall), **changes)


def test_a_clock_has_reached_its_last_whole_tick():
    np.testing.assert_allclose(Clock(tick=0.1).physics_times(np.array([0.05, 0.1, 0.19, 0.3])), [0.0, 0.1, 0.1, 0.3])
    np.testing.assert_allclose(Clock(tick=0.1, lag=1.0).physics_times(np.array([0.05, 0.1, 0.3])), [0.0, 0.0, 0.2])
    np.testing.assert_allclose(Clock(rate=2.0, offset=-0.1).physics_times(np.array([0.0, 0.3])), [0.0, 0.5])
    assert Clock(stop=0.2).physics_times(np.array([0.9]))[0] == 0.2
    np.testing.assert_allclose(
        Clock(tick=0.1).fraction(np.array([0.1, 0.125, 0.19]), 0.0), [0.0, 0.25, 0.9], atol=1e-12
    )


def test_the_model_of_a_correct_program_is_the_truth():
    scene = replace(TUMBLE, times=TIMES)
    true = truth(scene)
    rows = correct_program(scene, 0).simulate(TIMES, FINE)
    # FINE leaves 1e-9 of a radian turned; the die turns by a few.
    np.testing.assert_allclose(rows[:, 0:3], true.states[1:, 0, 0:3], atol=1e-9)
    np.testing.assert_allclose(rows[:, 15:18], true.states[1:, 0, 10:13], rtol=1e-8)
    points = rows[:, 3:12].reshape(-1, 3, 3) @ scene.body.points.T
    np.testing.assert_allclose(rows[:, 0:3, None] + points, np.swapaxes(true.vertices[1:, 0], 1, 2), atol=1e-9)


@pytest.mark.parametrize(
    ("fall", "steps"), [(0.0, lambda n: n * (n - 1)), (1.0, lambda n: n * (n + 1)), (0.5, np.square)]
)
def test_steps_fall_as_the_old_velocity_the_new_or_their_mean_has_it(fall, steps):
    program = stepped(STRAIGHT_FALL, fall)
    start = program.simulate(np.array([0.0]))[0]
    n = np.round(TIMES / STEP)
    # x = x0 + v0 t + g dt^2 n (n -+ 1)/2: the sum of the velocities, v0 + k g dt, that n steps have moved by.
    right = start[0:3] + TIMES[:, None] * start[12:15] + program.gravity * (STEP**2 * steps(n) / 2)[:, None]
    np.testing.assert_allclose(program.simulate(TIMES)[:, 0:3], right, atol=1e-12)


@pytest.mark.parametrize(
    ("damping_form", "share"),
    [(LINEARLY, lambda c: 1 - c), (EXPONENTIALLY, lambda c: np.exp(-c)), (IMPLICITLY, lambda c: 1 / (1 + c))],
)
def test_a_step_damps_by_a_share_of_the_velocity(damping_form, share):
    free = replace(STRAIGHT_FALL, gravity=None)
    program = stepped(free, damping=(3.0, 0.0, 0.0, 0.0, 0.0), damping_place=LAST, damping_form=damping_form)
    start = program.simulate(np.array([0.0]))[0]
    left = share(3.0 * STEP) ** np.round(TIMES / STEP)
    np.testing.assert_allclose(program.simulate(TIMES)[:, 12:15], left[:, None] * start[12:15], rtol=1e-12)


def test_stored_momentum_is_conserved_and_an_explicit_step_gains_energy():
    brick = read_scene("brick-tumble")
    moments = brick.body.moments
    rows = {}
    for stored in (IN_BODY, MOMENTUM):
        scheme = Scheme(STEP, QUATERNION, EXPLICIT, False, 0.5, stored=stored)
        rows[stored] = replace(correct_program(brick, 0), scheme=scheme).simulate(TIMES)
    w_body = {
        stored: np.einsum("tji,tj->ti", each[:, 3:12].reshape(-1, 3, 3), each[:, 15:18])
        for stored, each in rows.items()
    }
    size = {stored: np.linalg.norm(moments * w, axis=1) for stored, w in w_body.items()}
    np.testing.assert_allclose(size[MOMENTUM], size[MOMENTUM][0], rtol=1e-12)
    energy = (moments * w_body[IN_BODY] ** 2).sum(axis=1)
    assert (np.diff(energy) > 1e-6 * energy[0]).all()


def test_an_impulse_that_lasts_has_moved_the_body_by_half_of_its_time_less():
    program = correct_program(replace(STRAIGHT_FALL, gravity=None), 0)
    lasting = replace(program, application=ImpulseApplication(lasts=0.1))
    at_once, late = (each.simulate(TIMES, FINE) for each in (program, lasting))
    np.testing.assert_allclose(late[:, 12:15], at_once[:, 12:15], rtol=1e-9)
    gained = program.simulate(np.array([0.0]))[0, 12:15] - STRAIGHT_FALL.start[0, 7:10]
    np.testing.assert_allclose(at_once[:, 0:3] - late[:, 0:3], np.tile(0.05 * gained, (3, 1)), atol=1e-9)


def test_rows_between_ticks_lie_on_the_line_and_the_arc():
    scene = replace(TUMBLE, gravity=None)
    for interpolation in (LINEAR, SLERP):
        program = replace(correct_program(scene, 0), clock=Clock(tick=0.02, interpolation=interpolation))
        pose, ends = program.output(np.array([0.105])), program.simulate(np.array([0.1, 0.12]))
        np.testing.assert_allclose(pose.x[0], 0.75 * ends[0, 0:3] + 0.25 * ends[1, 0:3], atol=1e-12)
        np.testing.assert_allclose(pose.axes[0].T @ pose.axes[0], np.eye(3), atol=1e-12)


def test_output_transforms_are_applied_in_order():
    program = correct_program(STRAIGHT_FALL, 0)
    doubled = with_output_transform(program, lambda pose: pose._replace(x=2.0 * pose.x))
    moved = with_output_transform(doubled, lambda pose: pose._replace(x=pose.x + 1.0))
    np.testing.assert_allclose(moved.output(TIMES).x, 2.0 * program.output(TIMES).x + 1.0)


def test_a_coarse_run_is_precise_while_a_short_force_spins_the_body_up():
    program = correct_program(read_scene("die-vertex"), 0).but(application=ImpulseApplication(lasts=0.0025))
    rows, right = (program.simulate(TIMES, fineness) for fineness in (0.15, 0.001))
    assert np.abs(rows[:, 3:12] - right[:, 3:12]).max() < 1e-5  # of one step in the force: 6e-4


def test_a_run_that_diverged_ends_though_a_body_is_put_to_rest_below_a_speed():
    program = correct_program(STRAIGHT_FALL, 0)
    start = program.start + np.where(np.arange(13) == 7, np.nan, 0.0)
    assert np.isnan(program.but(start=start, thresholds=(0.3, 0.0)).simulate(TIMES)[:, 12]).all()


def test_a_leapfrog_that_stores_the_angular_momentum_has_no_gyroscopic_term_to_miss():
    scheme = Scheme(STEP, RUNGE_KUTTA, VERLET, False, 0.0, stored=MOMENTUM)
    program = correct_program(read_scene("dzhanibekov"), 0).but(scheme=scheme)
    rows = program.but(gyroscopic=0.0).simulate(TIMES)
    np.testing.assert_array_equal(rows, program.simulate(TIMES))
    assert np.abs(np.diff(rows[:, 15:18], axis=0)).max() > 1e-3


def test_a_row_that_is_off_an_impulse_by_rounding_makes_no_step_of_its_own():
    """Rows that are a step late come at 34/60 - 1/60 s, just before 33/60: a step from there would be one too many."""
    scene = replace(read_scene("two-hits"), impulses=(replace(read_scene("two-hits").impulses[1], time=33 / 60),))
    scheme = Scheme(1 / 60, QUATERNION, EXPLICIT, True, 1.0, normalise_every=20)
    program = correct_program(scene, 0).but(scheme=scheme)
    on_time = np.arange(60) / 60
    late = np.array([(row + 1) / 60 - 1 / 60 for row in range(60)])
    assert -1e-15 < late[33] - on_time[33] < 0.0
    np.testing.assert_allclose(program.output(late).axes, program.output(on_time).axes, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize(
    ("form", "share"),
    [(LINEARLY, 1 - 0.5 * STEP), (EXPONENTIALLY, np.exp(-0.5 * STEP)), (IMPLICITLY, 1 / (1 + 0.5 * STEP))],
)
def test_dry_friction_acts_beside_damping_of_every_form(form, share):
    """Dry friction takes as much of a speed in each step, damping a share of it."""
    friction, speed = 2.0, 5.0
    program = stepped(TUMBLE, damping=(0.5, 0.0, 0.0, 0.0, 0.0), drag=(friction, 0.0, 0.0, 0.0))
    program = program.but(damping_form=form, damping_place=LAST, gravity=np.zeros(3), impulses=())
    start = program.start.copy()
    start[7:10] = (speed, 0.0, 0.0)
    rows = program.but(start=start).simulate(np.arange(4) * STEP)
    expected = speed
    for row in rows[1:]:
        # The linear form takes both of the same speed; the others take the share first.
        expected = expected * share - friction * STEP
        assert row[12] == pytest.approx(expected, rel=1e-12)


def test_a_row_that_is_moved_on_keeps_the_length_of_its_quaternion():
    scheme = Scheme(STEP, QUATERNION, EXPLICIT, True, 1.0, normalise_every=20)
    clock = Clock(tick=STEP, interpolation=EXTRAPOLATED)
    program = correct_program(TUMBLE, 0).but(scheme=scheme, clock=clock)
    on_tick, later = (
        np.linalg.det(program.output(times).axes)
        for times in (np.arange(1, 12) * STEP, np.arange(1, 12) * STEP + 0.4 * STEP)
    )
    assert on_tick[-1] > 1.01, "it grows until it is normalised"
    np.testing.assert_allclose(later, on_tick, rtol=1e-9)
