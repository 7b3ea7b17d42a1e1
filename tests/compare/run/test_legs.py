"""Samples and impulses cut the flight; every leg gets whole steps."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tumble.compare.run.flight import legs, mean_step, takes_same_steps
from tumble.scenarios.read import read_scene

TABLE = read_scene("table-4-1")


def at(times, duration=None):
    return replace(TABLE, times=np.array(times), duration=duration or times[-1])


def test_a_step_that_divides_is_used_exactly():
    # 0.28 - 0.06 = 0.22000000000000003 is 11 steps, and its quotient by 0.02 is above 11.
    assert [(leg.n, leg.dt) for leg in legs(TABLE, 0.02)] == [(3, 0.02), (11, 0.02), (4, 0.02), (3, 0.02), (4, 0.02)]


def test_a_step_that_does_not_divide_is_shortened():
    (leg,) = legs(at([1.0]), 0.3)
    assert (leg.n, leg.dt) == (4, 0.25)


def test_a_step_longer_than_the_leg_becomes_the_leg():
    assert [(leg.n, leg.dt) for leg in legs(at([0.25, 1.0]), 7.0)] == [(1, 0.25), (1, 0.75)]


def test_the_flight_goes_on_to_its_end():
    assert [leg.end for leg in legs(at([0.5], duration=2.0), 0.1)] == [0.5, 2.0]


def test_impulses_cut_it_too():
    scene = read_scene("two-hits")
    later = {impulse.time for impulse in scene.impulses} - {0.0}
    assert later
    assert later <= {leg.end for leg in legs(scene, 0.01)}


@settings(derandomize=True, deadline=None, max_examples=300)
@given(st.integers(1, 10**8), st.floats(1e-6, 10.0))
def test_a_whole_number_of_steps_is_found_whatever_the_rounding(n, dt):
    (leg,) = legs(at([n * dt]), dt)
    assert (leg.n, leg.dt) == (n, dt)


@settings(derandomize=True, deadline=None, max_examples=300)
@given(st.lists(st.floats(1e-3, 100.0), min_size=1, max_size=8, unique=True), st.floats(1e-5, 200.0))
def test_no_step_is_longer_than_asked_and_none_is_lost(times, dt):
    scene = at(sorted(times))
    begin = 0.0
    for leg in legs(scene, dt):
        assert leg.dt <= dt * (1 + 1e-9)
        assert leg.n * leg.dt == pytest.approx(leg.end - begin, rel=1e-9, abs=1e-12)
        begin = leg.end
    assert begin == scene.duration


@pytest.mark.parametrize(
    ("duration", "steps", "dt", "taken"),
    [
        (2.0, 1000, 0.002, 0.002),
        (0.3, 3, 0.1, 0.1),
        (2.0, 1040, 0.002, 2 / 1040),
        (1e6, 10**9 + 1, 1e-3, 1e6 / (10**9 + 1)),
    ],
)
def test_the_step_taken_is_the_one_asked_for_only_where_all_steps_are_it(duration, steps, dt, taken):
    assert mean_step(duration, steps, dt) == taken


def test_more_samples_take_the_same_steps_where_steps_end():
    scene = at([0.25, 1.0])
    assert takes_same_steps(scene, scene, 0.01)
    assert takes_same_steps(scene, at([0.1, 0.25, 0.5, 0.51, 1.0]), 0.01)
    assert not takes_same_steps(scene, at([0.1, 0.25, 0.505, 1.0]), 0.01), "a step is cut"
    assert not takes_same_steps(scene, at([0.25, 0.5]), 0.01), "it ends before"
    # Steps of 0.25 / 3: a part of the interval would have steps of 0.1, or others.
    assert not takes_same_steps(scene, at([0.25 / 3, 0.25, 1.0]), 0.1)
