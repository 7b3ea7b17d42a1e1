"""Magnification that fits the view: the largest error that can be seen just does not leave it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tumble.lab.magnify import FACTORS, FITS, fitting, rounded_down, times

LIMIT = np.full(11, 1e-15)
RADIUS = 0.5


def grown(to: float) -> np.ndarray:
    """Return an error that grows evenly to so much [m]."""
    return np.linspace(0.0, to, len(LIMIT))


@given(st.floats(1e-5, 0.5))
def test_the_largest_error_is_drawn_large_and_in_the_view(largest):
    drawn = fitting([grown(largest), grown(largest / 1e6)], LIMIT, RADIUS) * largest
    assert drawn <= max(FITS * RADIUS * (1 + 1e-9), largest)
    assert drawn >= min(FITS * RADIUS / 2.51, largest)


def test_what_is_far_outside_does_not_hide_the_others():
    near = grown(1e-3)
    assert fitting([near, grown(350.0)], LIMIT, RADIUS) == fitting([near], LIMIT, RADIUS) == 200.0


def test_what_cannot_be_told_from_the_truth_is_not_magnified():
    assert fitting([grown(1e-15)], LIMIT, RADIUS) == 1.0
    assert fitting([], LIMIT, RADIUS) == 1.0


def test_it_is_not_magnified_without_end():
    assert fitting([grown(1e-13)], LIMIT, RADIUS) == max(FACTORS.values())


def test_what_is_not_known_yet_is_taken_to_grow_on():
    whole = fitting([grown(1e-3)], LIMIT, RADIUS)
    some, limit = grown(1e-3), LIMIT.copy()
    some[4:], limit[4:] = np.nan, np.nan
    assert fitting([some], limit, RADIUS) == whole


def test_a_loaded_file_is_fitted_too():
    assert fitting([grown(1e-6)], LIMIT, RADIUS, [1e-3]) == fitting([grown(1e-3)], LIMIT, RADIUS)


@pytest.mark.parametrize(("value", "down"), [(1.0, 1.0), (1.99, 1.0), (2.0, 2.0), (4.9, 2.0), (99.0, 50.0), (0.7, 0.5)])
def test_factors_are_round(value, down):
    assert rounded_down(value) == pytest.approx(down)


def test_factors_are_written_as_people_do():
    assert (times(50.0), times(1e6)) == ("50", "1\N{NO-BREAK SPACE}000\N{NO-BREAK SPACE}000")
