"""What rows show by themselves: the largest speeds, and when a body comes to rest."""

import numpy as np
import pytest

from tumble.compare.grade.measure.speeds import SPEEDS, largest_speeds, rests_from, speeds_reached
from tumble.scenarios.frames import rotation_matrix

POINTS = np.array(((0.3, 0.0, 0.0), (0.0, 0.2, 0.0), (0.0, 0.0, 0.1), (-0.3, -0.2, -0.1)))
TIMES = np.linspace(0.0, 1.0, 101)
PRECISE = np.full((101, 3), 1e-12)


def moved(place: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Return the vertices of a body that moves along x and rotates about z."""
    q = np.column_stack((np.cos(angle / 2), 0 * angle, 0 * angle, np.sin(angle / 2)))
    return place[:, None, None] * (1.0, 0.0, 0.0) + np.einsum("tij,kj->tki", rotation_matrix(q), POINTS)


def tilt(angle: float) -> np.ndarray:
    """Return a rotation about z."""
    return rotation_matrix(np.array((np.cos(angle / 2), 0.0, 0.0, np.sin(angle / 2))))


def test_the_largest_speeds_are_found():
    speed, spin = np.minimum(10 * TIMES, 4.0), np.minimum(20 * TIMES, 7.0)
    place, angle = (np.append(0.0, np.cumsum((s[1:] + s[:-1]) / 200)) for s in (speed, spin))
    found = speeds_reached(TIMES, moved(place, angle), POINTS, PRECISE)
    assert found["velocity"] == pytest.approx([4.0, 4.0])
    assert found["spin"] == pytest.approx([7.0, 7.0])


def test_the_largest_components_are_those_in_world_axes():
    """It moves along x and rotates about z, so that nothing else is as large."""
    found = speeds_reached(TIMES, moved(3.0 * TIMES, 2.0 * TIMES) @ tilt(0.7).T, POINTS, PRECISE)
    assert found["velocity"] == pytest.approx([3.0, 3.0])
    assert found["velocity component"] == pytest.approx(2 * [3.0 * np.cos(0.7)])
    assert found["spin component"] == pytest.approx(2 * [2.0])
    v, w = np.array(((1.0, -3.0, 2.0), (np.inf, 0.0, 0.0))), np.array(((0.0, 4.0, -3.0), (1.0, 0.0, 0.0)))
    largest = largest_speeds(v, w)
    assert (largest["spin"], largest["spin component"]) == (5.0, 4.0)
    assert largest["velocity component"] == 0.0, "nothing is known of a run that diverged"
    assert largest_speeds(v[:1], w[:1])["velocity component"] == 3.0


def test_speeds_are_taken_over_more_rows_where_these_have_noise():
    """From row to row, noise of 1 mm is 0.1 m/s and 0.3 rad/s or more."""
    noisy = moved(3.0 * TIMES, 2.0 * TIMES) + 1e-3 * np.random.default_rng(1).standard_normal((101, len(POINTS), 3))
    found = speeds_reached(TIMES, noisy, POINTS, np.full((101, 3), 1e-3))
    _, usual = found["velocity"]
    _, usual_spin = found["spin"]
    assert usual == pytest.approx(3.0, rel=0.02)
    assert usual_spin == pytest.approx(2.0, rel=0.05)
    fast = speeds_reached(TIMES, noisy, POINTS, PRECISE)
    assert fast["spin"][1] > 2.2, "noise makes rows faster than they are"


def test_a_body_that_turns_far_between_rows_is_no_slower_for_noise():
    """Over more rows than one, half a turn or more would be lost."""
    found = speeds_reached(TIMES, moved(0.0 * TIMES, 60.0 * TIMES), POINTS, np.full((101, 3), 5e-2))
    assert found["spin"] == pytest.approx([60.0, 60.0])


def test_points_in_a_line_show_no_spin():
    line = POINTS[:1] * np.array(((1.0,), (2.0,), (3.0,)))
    found = speeds_reached(TIMES, np.repeat(line[None], 101, axis=0), line, PRECISE)
    assert found == {name: [] for name in SPEEDS}


def test_a_body_at_rest_is_seen():
    stopped = np.minimum(TIMES, 0.6)
    floors_m = np.full((101, 3), 1e-6)
    assert rests_from(TIMES, moved(stopped, stopped), floors_m) == pytest.approx(0.6)
    assert rests_from(TIMES, moved(TIMES, TIMES), floors_m) == TIMES[-1]
