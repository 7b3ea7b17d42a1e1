"""What the eye sees: projections against a pinhole worked out otherwise, and what is kept in the picture."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tumble.lab.eye import Box, Eye, axes, first_view, turned_to
from tumble.scenarios.frames import rotation_matrix
from tumble.scenarios.read import catalogue, read_scene

WIDE, HIGH, ANGLE = 612.0, 720.0, np.deg2rad(45.0)
# At (0, 0, 5), looking at the origin, y up: right is x.
EYE = Eye.of(np.array([0.0, 0.0, 5.0]), np.zeros(3), np.array([0.0, 1.0, 0.0]), ANGLE, WIDE, HIGH)
Coordinate = st.floats(-3.0, 3.0)


def test_a_place_is_seen_where_a_pinhole_sees_it():
    across, over, depth = EYE.pixels(np.array([[1.0, -0.5, 2.0]]))[0]
    tangent = np.tan(ANGLE / 2)
    assert (across, over, depth) == pytest.approx((HIGH / 2 / 3 / tangent, -HIGH / 4 / 3 / tangent, 3.0))


def test_what_is_behind_the_eye_or_beside_the_picture_is_not_seen():
    edge = 5.0 * np.tan(ANGLE / 2) * WIDE / HIGH
    assert EYE.sees(np.array([[0.99 * edge, 0.0, 0.0]]))
    assert not EYE.sees(np.array([[1.01 * edge, 0.0, 0.0]]))
    assert not EYE.sees(np.array([[0.0, 0.0, 9.0]]))
    assert EYE.sees(np.array([[0.0, 0.0, 9.0], [0.0, 0.0, 0.0]]))


@given(Coordinate, Coordinate, Coordinate)
def test_what_is_kept_inside_is_inside_with_all_that_is_written_there(x, y, z):
    box = Box(20.0, 120.0, 8.0, 60.0)
    left, right, low, high = EYE.covered(EYE.moved_inside(np.array([x, y, z]), box), box)
    assert left >= -WIDE / 2 - 1e-6
    assert right <= WIDE / 2 + 1e-6
    assert low >= -HIGH / 2 - 1e-6
    assert high <= HIGH / 2 + 1e-6


def test_what_is_inside_is_left_where_it_is():
    place = np.array([0.3, 0.2, -1.0])
    assert EYE.moved_inside(place, Box(5.0, 5.0, 5.0, 5.0)) == pytest.approx(place)


def test_in_a_narrow_window_nothing_is_written_under_the_controls():
    eye = Eye.of(np.array([0.0, 0.0, 5.0]), np.zeros(3), np.array([0.0, 1.0, 0.0]), ANGLE, 400.0, 800.0)
    box = Box(5.0, 5.0, 5.0, 5.0)
    assert eye.covered(eye.moved_inside(np.array([0.0, -1.5, 0.0]), box), box)[2] > 0


@pytest.mark.parametrize("name", catalogue())
def test_at_first_the_whole_body_is_seen(name):
    scene = read_scene(name)
    place, target = first_view(scene)
    eye = Eye.of(place, target, axes(scene).up, ANGLE, WIDE, HIGH)
    corners = scene.start[0, 0:3] + scene.body.points
    assert all(eye.sees(corner[None]) for corner in corners)


def test_axes_are_turned_to_themselves():
    for name in catalogue():
        turned = axes(read_scene(name))
        assert rotation_matrix(turned_to(turned)) @ np.eye(3) == pytest.approx(np.stack(turned, axis=1))
