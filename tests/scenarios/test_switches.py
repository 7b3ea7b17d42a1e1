"""When the floor begins or ceases to push: the first fall of a polynomial below 0, however narrow its dip."""

import numpy as np
import pytest
from numba import njit
from numpy.polynomial import polynomial

from tumble.scenarios.truth.forced.switches import ABOVE, IDLE, NEVER, PRESSING, first_fall, next_switch


@njit
def fall(coefficients, nothing):
    """Return what `first_fall` does, which only compiled code can call."""
    return first_fall(coefficients, nothing)


@njit
def switch(high, gauges, contacts, s, noise):
    """Return what `next_switch` does, likewise."""
    return next_switch(high, gauges, contacts, s, noise)


@pytest.mark.parametrize("root", [1e-6, 0.1, 0.5, 0.7310585786300049, 1 - 1e-9])
def test_the_first_root_is_found(root):
    # Falls at the root, rises at 2, falls at 3: beyond 1 nobody asks.
    assert fall(polynomial.polyfromroots((root, 2.0, 3.0)) * -1.0, 0.0) == pytest.approx(root, rel=1e-9)


def test_the_earlier_of_two_dips_counts_and_a_touch_from_above_is_none():
    assert fall(polynomial.polyfromroots((0.3, 0.4, 0.8, 0.9)), 0.0) == pytest.approx(0.3, rel=1e-9)
    assert fall(polynomial.polyadd(polynomial.polyfromroots((0.3, 0.3)), [1e-6]), 0.0) == NEVER


@pytest.mark.parametrize("width", [1e-2, 1e-4, 1e-6])
def test_a_narrow_dip_is_not_overlooked(width):
    assert fall(polynomial.polyfromroots((0.37, 0.37 + width)), 0.0) == pytest.approx(0.37, abs=width)


def test_what_stays_positive_or_is_rounding_never_falls():
    assert fall(np.array([1.0, -0.5, 0.2]), 0.0) == NEVER
    assert fall(np.array([-1e-20, 3e-20, -3e-20]), 1e-18) == NEVER
    # A switch was made at 0: below by a rounding there, and rising.
    assert fall(np.array([-1e-18, 1.0, 0.0]), 0.0) == NEVER


# Heights 1 - 2 z of the first vertex and 1 - 4 z of the second, and thrusts of each.
HIGH = np.array([[1.0, -2.0], [1.0, 0.0], [1.0, -4.0], [1.0, 0.0]])
GAUGES = np.array([[0, 1], [2, 3]])
NOISE = np.zeros(2)


def test_the_vertex_that_lands_first_switches_first():
    found = switch(HIGH, GAUGES, np.array([ABOVE, ABOVE]), 1.0, NOISE)
    assert (found.at, found.vertex, found.then) == (pytest.approx(0.25), 1, PRESSING)
    assert switch(HIGH, GAUGES, np.array([ABOVE, ABOVE]), 0.2, NOISE).at < 0.0


def test_a_vertex_that_is_below_comes_up_or_is_let_go():
    high = np.array([[-1.0, 2.0], [1.0, -4.0], [1.0, 0.0], [1.0, 0.0]])
    found = switch(high, GAUGES, np.array([PRESSING, ABOVE]), 1.0, NOISE)
    assert (found.at, found.then) == (pytest.approx(0.25), IDLE)
    up = switch(np.vstack((high[0], [1.0, 0.0], high[2:])), GAUGES, np.array([PRESSING, ABOVE]), 1.0, NOISE)
    assert (up.at, up.then) == (pytest.approx(0.5), ABOVE)
    again = switch(np.vstack((high[0], [-1.0, 4.0], high[2:])), GAUGES, np.array([IDLE, ABOVE]), 1.0, NOISE)
    assert (again.at, again.then) == (pytest.approx(0.25), PRESSING)
