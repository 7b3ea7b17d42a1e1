"""DOP853 as an engine: the bits of solve_ivp at every instant asked for, and errors that are what was tolerated."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from triaxial import GRAVITY, SIZE, THROWS, scene

from tumble.compare.engines import scipy as engine
from tumble.scenarios.frames import Array, vertices
from tumble.scenarios.scene import Scene, frozen_array
from tumble.scenarios.truth import truth

FLIGHT_S = 3.0
RADIUS_M = np.linalg.norm(SIZE) / 2


def flight(start: Array = THROWS, duration: float = FLIGHT_S) -> Scene:
    """Return the scene under gravity, looked at once, at its end."""
    return replace(scene(start, GRAVITY), duration=duration, times=frozen_array([duration]))


def thrown(method: str, states: Array, *steps: tuple[int, float], gravity=None) -> engine.World:
    """Return a world after the steps (n, dt)."""
    world = engine.build(scene(states, gravity), method)
    engine.write(world, states)
    for n, dt in steps:
        engine.advance(world, n, dt)
    return world


@given(
    steps=st.lists(st.tuples(st.integers(0, 5), st.floats(1e-3, 0.5)), min_size=1, max_size=5),
    exponent=st.floats(2.0, 13.0),
)
@settings(derandomize=True, deadline=None, max_examples=15)
def test_every_bit_is_that_of_solve_ivp(steps, exponent):
    """At every stop, however many there were before it."""
    tolerance = 10.0**-exponent
    world = thrown(f"dop853@{tolerance!r}", THROWS[:1], gravity=GRAVITY)
    y0 = world.motions[0].copy()
    scale = np.repeat([1.0, np.linalg.norm(y0[4:7])], [4, 3])  # pyright: ignore[reportCallIssue]
    for n, dt in steps:
        engine.advance(world, n, dt)
        bare = solve_ivp(world.slope, (0.0, world.elapsed), y0, "DOP853", rtol=tolerance, atol=tolerance * scale)
        np.testing.assert_array_equal(world.motions[0], bare.y[:, -1])


@pytest.mark.parametrize("tolerance", [1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12])
def test_the_error_is_what_was_tolerated(tolerance):
    question = flight()
    true = truth(question)
    world = thrown(f"dop853@{tolerance:g}", THROWS, (1, FLIGHT_S), gravity=GRAVITY)
    errors = np.linalg.norm(vertices(engine.read(world), question.body.points) - true.vertices[-1], axis=-1)
    # A step is about a radian: the quaternion's errors add up over the radians turned, and move the farthest vertex.
    radians = FLIGHT_S * np.linalg.norm(THROWS[:, 10:13], axis=1).max()
    tolerated = tolerance * radians * RADIUS_M
    assert tolerated / 50 < errors.max() < tolerated


def test_the_tolerance_is_relative_to_the_spin():
    """A millionth of the spin for a million times as long is the same flight."""
    slow = THROWS[:1].copy()
    slow[:, 7:10] = 0.0
    slow[:, 10:13] *= 1e-6
    question = replace(scene(slow), duration=1e6 * FLIGHT_S, times=frozen_array([1e6 * FLIGHT_S]))
    world = thrown("dop853@1e-6", slow, (1, 1e6 * FLIGHT_S))
    error = np.linalg.norm(vertices(engine.read(world), question.body.points) - truth(question).vertices[-1], axis=-1)
    assert error.max() < 1e-6 * FLIGHT_S * np.linalg.norm(THROWS[0, 10:13]) * RADIUS_M


def test_the_plain_name_is_its_default():
    np.testing.assert_array_equal(
        engine.read(thrown("dop853", THROWS, (1, 1.0))), engine.read(thrown("dop853@1e-9", THROWS, (1, 1.0)))
    )


@pytest.mark.parametrize("method", ["dop853@", "dop853@tight", "dop853@0", "dop853@1", "dop853@nan", "rk45@1e-6", ""])
def test_a_bad_name_is_refused(method):
    with pytest.raises(ValueError, match=r"dop853|convert"):
        engine.build(scene(), method)


def test_a_tolerance_that_scipy_has_not_is_flagged():
    least = f"dop853@{engine.LEAST_TOLERANCE!r}"
    assert engine.audit(thrown(least, THROWS)) == []
    below = thrown("dop853@1e-15", THROWS, (1, 1.0))
    ((kind, note),) = engine.audit(below)
    assert kind == "tolerance"
    assert "1e-15 raised to 2.3e-14" in note
    np.testing.assert_array_equal(engine.read(below), engine.read(thrown(least, THROWS, (1, 1.0))))


def test_what_lies_still_stays():
    still = np.zeros((1, 13))
    still[0, 3] = 1.0
    np.testing.assert_array_equal(engine.read(thrown("dop853", still, (3, 1000.0))), still)


@pytest.mark.parametrize("wrong", [(0, np.inf), (8, np.nan), (10, np.nan), (11, 1e200)])
def test_divergence_ends_and_stays_with_its_throw(wrong):
    """SciPy refuses a state that is not finite, and never returns from a slope that is not."""
    wild = THROWS.copy()
    wild[(1, wrong[0])] = wrong[1]
    states = engine.read(thrown("dop853", wild, (2, 0.5)))
    assert not np.isfinite(states[1]).all()
    others = [0, 2]
    np.testing.assert_array_equal(states[others], engine.read(thrown("dop853", THROWS[others], (2, 0.5))))
    assert np.isfinite(states[others]).all()


def test_without_gravity_nothing_falls():
    states = engine.read(thrown("dop853@1e-4", THROWS, (10, 0.1)))
    np.testing.assert_array_equal(states[:, 7:10], THROWS[:, 7:10])
