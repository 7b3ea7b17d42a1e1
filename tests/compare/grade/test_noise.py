"""Noise that rows show by themselves: how large it is, and that motion, rounding in steps and impulses are none."""

from dataclasses import replace

import numpy as np
import pytest

from tumble.compare.grade.measure.errors import golden_subsample
from tumble.compare.grade.measure.noise import most_noise_m, white_noise_m
from tumble.scenarios.frames import rotation_matrix
from tumble.scenarios.read import read_scene
from tumble.scenarios.truth import truth

SCENE = read_scene("two-hits")
POINTS = 0.3 * np.vstack((np.eye(3), -np.eye(3)))
EVENTS = np.array([impulse.time for impulse in SCENE.impulses])


def flown(rows: int) -> tuple[np.ndarray, np.ndarray]:
    """Return times and the true vertices of a body struck in flight."""
    times = np.linspace(0.0, SCENE.duration, rows)
    return times, truth(replace(SCENE, times=times[1:]), with_input_error=False).vertices[:, 0]


@pytest.mark.parametrize("rows", [120, 400])
def test_noise_is_measured_whatever_the_motion(rows):
    times, vertices = flown(rows)
    noise = 1e-4 * np.random.default_rng(3).standard_normal(vertices.shape)
    # Of N differences, each of 5 rows, the median is known to some 2/sqrt(N coordinates).
    assert white_noise_m(times, vertices + noise, SCENE.body.points, EVENTS, are_independent=True) == pytest.approx(
        1e-4, rel=0.35
    )


def test_noise_is_measured_by_the_centre_of_a_body_that_rotates_fast():
    times = np.linspace(0.0, 1.0, 40)
    turn = rotation_matrix(np.column_stack((np.cos(40 * times), 0 * times, 0 * times, np.sin(40 * times))))
    places = times[:, None] * (1.0, 2.0, -3.0) + times[:, None] ** 2 * (0.0, -4.905, 0.0)
    noise = 1e-4 * np.random.default_rng(4).standard_normal(places.shape)
    corners = np.einsum("tij,kj->tki", turn, POINTS)
    vertices = (places + noise)[:, None] + corners
    assert white_noise_m(times, vertices, POINTS, np.empty(0)) == pytest.approx(1e-4, rel=0.35)
    assert white_noise_m(times, places[:, None] + corners, POINTS, np.empty(0)) < 1e-12


@pytest.mark.parametrize(("noise_m", "found_m"), [(1e-4, 1e-4), (0.0, 0.0)])
def test_noise_is_measured_where_rounding_is_smaller(noise_m, found_m):
    """A body that has fallen far is written in fewer decimals."""
    times, vertices = flown(200)
    units = np.full((200, 3), 1e-6)
    units[40:, 1] = 1e-2
    written = vertices + noise_m * np.random.default_rng(6).standard_normal((200, 1, 3))
    written = units[:, None] * np.round(written / units[:, None])
    floors_m = units / np.sqrt(12.0)
    found = white_noise_m(times, written, SCENE.body.points, EVENTS, floors_m=floors_m)
    assert found == pytest.approx(found_m, rel=0.35)
    assert noise_m or white_noise_m(times, written, SCENE.body.points, EVENTS) > 1e-7, "rounding is noise as well"


def test_a_subsample_shows_the_noise_of_all_rows():
    times, vertices = flown(800)
    noise = 1e-4 * np.random.default_rng(8).standard_normal(vertices.shape)
    some = golden_subsample(len(times), 400)
    assert len(np.unique(np.diff(some))) > 1
    found = white_noise_m(times[some], (vertices + noise)[some], SCENE.body.points, EVENTS, are_independent=True)
    assert found == pytest.approx(1e-4, rel=0.35)


@pytest.mark.parametrize(("rows", "tick"), [(181, 0.02), (289, 1 / 60), (241, 0.0023), (800, 1 / 144)])
def test_rows_between_ticks_have_no_noise(rows, tick):
    times, _ = flown(rows)
    reached = np.unique(tick * np.floor(times / tick + 1e-9))
    ticks = truth(replace(SCENE, times=reached[1:]), with_input_error=False).vertices[:, 0]
    held = ticks[np.searchsorted(reached, times + 1e-9, side="right") - 1]
    some = golden_subsample(rows, 400)
    assert white_noise_m(times[some], held[some], SCENE.body.points, EVENTS) == 0.0


def test_rows_between_ticks_of_a_body_that_rotates_fast_have_no_noise():
    """Held rows are wrong along the motion, which turns from row to row; rows on straight lines across it."""
    tick, times = 0.01, np.arange(60) / 24
    for reached in (tick * np.floor(times / tick + 1e-9), times):
        is_held = reached is not times
        x = reached[:, None] * (1.0, 2.0, -3.0) + np.sin(reached)[:, None] * (0.1, 0.0, 0.3)
        turn = rotation_matrix(np.column_stack((np.cos(9 * reached), 0 * times, 0 * times, np.sin(9 * reached))))
        if not is_held:  # every second row is half-way between its neighbours
            x[1:-1:2] = (x[:-2:2] + x[2::2]) / 2
            turn[1:-1:2] = (turn[:-2:2] + turn[2::2]) / 2
        vertices = x[:, None] + np.einsum("tij,kj->tki", turn, POINTS)
        assert white_noise_m(times, vertices, POINTS, np.empty(0)) == 0.0, is_held


def test_noise_of_attitudes_alone_is_measured():
    """Of a body at rest: nothing else moves the vertices."""
    times, angles = np.arange(60) / 24, 1e-3 * np.random.default_rng(12).standard_normal((60, 3))
    turn = rotation_matrix(np.column_stack((np.ones(60), angles / 2)))
    points = np.random.default_rng(13).standard_normal((8, 3))
    moved_m = 1e-3 * np.sqrt(2 / 3 * np.square(points).sum(axis=1).mean() / 3)
    found = white_noise_m(times, np.einsum("tij,kj->tki", turn, points), points, np.empty(0))
    assert found == pytest.approx(moved_m, rel=0.35)


def test_rounded_times_are_even():
    times, vertices = flown(240)
    noise = 1e-4 * np.random.default_rng(7).standard_normal((len(times), 1, 3))
    rounded = times.round(3)
    assert white_noise_m(rounded, vertices + noise, SCENE.body.points, EVENTS) == 0.0
    assert white_noise_m(rounded, vertices + noise, SCENE.body.points, EVENTS, rounding_s=5e-4) == pytest.approx(
        1e-4, rel=0.35
    )


def test_motion_alone_is_no_noise():
    assert white_noise_m(*flown(60), SCENE.body.points, EVENTS) == 0.0


def test_rows_half_a_turn_apart_are_no_noise():
    times = np.linspace(0.0, 1.0, 60)
    angle = 3.1 / times[1] * times
    places = np.column_stack((np.cos(angle), np.sin(angle), 0 * angle))
    assert white_noise_m(times, places[:, None], np.zeros((1, 3)), np.empty(0)) == 0.0


def test_an_impulse_is_no_noise_and_hides_none():
    times, vertices = flown(200)
    noise = 1e-5 * np.random.default_rng(5).standard_normal(vertices.shape)
    found = white_noise_m(times, vertices + noise, SCENE.body.points, np.empty(0), are_independent=True)
    assert found == pytest.approx(1e-5, rel=0.35)


def test_too_few_or_uneven_rows_show_none():
    times, vertices = flown(200)
    random = np.random.default_rng(9)
    noisy = vertices + 1e-3 * random.standard_normal(vertices.shape)
    assert white_noise_m(times[:15], noisy[:15], SCENE.body.points, EVENTS) == 0.0
    uneven = np.sort(random.uniform(0.0, SCENE.duration, len(times)))
    assert white_noise_m(uneven, noisy, SCENE.body.points, EVENTS) == 0.0


@pytest.mark.parametrize("points", [[(1.0, 0.0, 0.0), (-1.0, 0.0, 0.0)], [(1.0, 0.0, 0.0), (0.6, 0.2, 0.1)]])
def test_a_body_that_turns_far_from_row_to_row_has_no_noise(points):
    """Where its vertices are is as good as random, and so is their mean, unless it is the centre of mass."""
    turns = np.random.default_rng(6).uniform(0.0, np.pi, 41)
    attitude = rotation_matrix(np.column_stack((np.cos(turns), 0.6 * np.sin(turns), 0 * turns, 0.8 * np.sin(turns))))
    vertices = np.einsum("tij,kj->tki", attitude, points)
    assert white_noise_m(0.02 * np.arange(41.0), vertices, np.array(points), np.empty(0)) == 0.0


def test_the_centre_of_mass_shows_the_noise_wherever_the_vertices_are():
    random, times = np.random.default_rng(11), 0.02 * np.arange(101.0)
    points = np.array([(0.3, 0.1, 0.0), (0.2, -0.3, 0.1), (0.4, 0.1, 0.3), (-0.1, 0.2, 0.2), (0.5, 0.5, 0.5)])
    attitude = rotation_matrix(np.column_stack((np.cos(40 * times), 0 * times, 0 * times, np.sin(40 * times))))
    places = times[:, None] * (1.0, 2.0, -3.0) + 1e-4 * random.standard_normal((101, 3))
    vertices = places[:, None] + np.einsum("tij,kj->tki", attitude, points)
    assert white_noise_m(times, vertices, points, np.empty(0)) == pytest.approx(1e-4, rel=0.35)


def test_noise_is_at_most_what_rows_show_whatever_their_motion():
    times, vertices = flown(200)
    noise = 1e-4 * np.random.default_rng(7).standard_normal((200, 1, 3))
    assert most_noise_m(times, vertices, SCENE.body.points, EVENTS) < 1e-7
    assert most_noise_m(times, vertices + noise, SCENE.body.points, EVENTS) == pytest.approx(1e-4, rel=0.35)
    reached = np.unique(0.02 * np.floor(times / 0.02 + 1e-9))
    ticks = truth(replace(SCENE, times=reached[1:]), with_input_error=False).vertices[:, 0]
    held = ticks[np.searchsorted(reached, times + 1e-9, side="right") - 1]
    assert most_noise_m(times, held, SCENE.body.points, EVENTS) > 1e-3, "between ticks, rows do not exclude any"


def test_too_few_rows_exclude_no_noise():
    times, vertices = flown(60)
    assert most_noise_m(times[:12], vertices[:12], SCENE.body.points, EVENTS) == np.inf
    assert most_noise_m(times[:3], vertices[:3], SCENE.body.points, np.empty(0)) == np.inf
    assert most_noise_m(times, vertices[:, :1], SCENE.body.points[:1], EVENTS) == np.inf, "one corner is no centre"
