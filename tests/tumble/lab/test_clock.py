"""The time shown: nothing between two instants that were flown, and no time lost or gained by a touch."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tumble.lab.clock import Clock

CLOCK = Clock([0.0, 0.1, 0.2, 0.3], speed=0.5)


def test_it_stands_until_it_is_started():
    assert CLOCK.time(1e9) == 0.0


def test_slow_motion_is_slow():
    assert CLOCK.started(10.0).time(10.4) == pytest.approx(0.2)


def test_it_stays_at_the_end_and_starts_again_from_there():
    over = CLOCK.started(0.0)
    assert over.frame(100.0) == 3
    assert over.stopped(100.0).started(200.0).frame(200.0) == 0


def test_another_speed_takes_nothing_back():
    faster = CLOCK.started(0.0).paced(0.4, 1.0)
    assert faster.time(0.4) == 0.2
    assert faster.time(0.45) == 0.25


def test_a_clock_that_waits_does_not_jump():
    waiting = CLOCK.started(0.0).limited_to(5.0, 0.1)
    assert waiting.time(5.0) == 0.1
    assert waiting.time(5.2) == pytest.approx(0.2)


@given(st.floats(0.0, 2.0))
def test_what_is_shown_is_an_instant_not_later_than_the_time(watch):
    running = CLOCK.started(0.0)
    frame = running.frame(watch)
    assert CLOCK.instants[frame] <= running.time(watch)
    assert frame == 3 or running.time(watch) < CLOCK.instants[frame + 1]
    assert running.stopped(watch).time(0.0) == CLOCK.instants[frame]
