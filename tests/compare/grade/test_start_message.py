"""What is said of a first row that is not the scene's start: only what the file's digits show."""

import numpy as np
import pytest

from tumble.compare.grade.measure.errors import SampledRows
from tumble.compare.grade.measure.observations import _start
from tumble.scenarios.frames import rotation_matrix

POINTS = np.array([(x, y, z) for x in (-0.3, 0.3) for y in (-0.2, 0.2) for z in (-0.1, 0.1)])
VISIBLE_M = 1e-4
QUARTER = rotation_matrix(np.array((np.cos(0.1), 0.0, 0.0, np.sin(0.1))))


def said(off, turn, time=0.0):
    places = (POINTS @ turn.T + np.array(off))[None]
    sample = SampledRows(np.array([time]), places, POINTS[None], np.full((1, 3), 1e-5), None)
    return " ".join(_start(sample, VISIBLE_M, POINTS))


@pytest.mark.parametrize(
    ("off", "turn", "told", "not_told"),
    [
        ((0.0, 2e-5, 0.0), QUARTER, "rotated by 11.46 degrees", "position"),
        ((0.5, 0.0, 0.0), np.eye(3), "position is off by (0.5, ", "rotated"),
        ((0.0, 0.5, 0.0), QUARTER, "off by (", "nothing"),
    ],
)
def test_only_what_is_visible_is_said(off, turn, told, not_told):
    assert told in said(off, turn)
    assert not_told not in said(off, turn)


def test_nothing_is_said_of_rounding_or_of_a_later_row():
    small = rotation_matrix(np.array((1.0, 0.0, 0.0, 1e-5)))
    assert not said((2e-5, 0.0, 0.0), small)
    assert not said((0.5, 0.0, 0.0), np.eye(3), time=0.1)
