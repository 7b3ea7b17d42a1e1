"""heyoka as an engine: the bits of propagate_until at every instant asked for, and errors below what was tolerated."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from triaxial import GRAVITY, MOMENTS, SIZE, THROWS, scene

from tumble.scenarios.frames import vertices
from tumble.scenarios.scene import frozen_array
from tumble.scenarios.truth import truth

engine = pytest.importorskip("tumble.compare.engines.heyoka")
heyoka = engine.heyoka

FLIGHT_S = 3.0


def thrown(method, states, *steps: tuple[int, float], **body):
    """Return a world after the steps (n, dt)."""
    world = engine.build(scene(states, **body), method)
    engine.write(world, states)
    for n, dt in steps:
        engine.advance(world, n, dt)
    return world


@given(
    steps=st.lists(st.tuples(st.integers(0, 5), st.floats(1e-3, 0.5)), min_size=1, max_size=6),
    tolerance=st.sampled_from([1e-3, 1e-9, 1e-14]),
)
@settings(derandomize=True, deadline=None, max_examples=15)
def test_every_bit_is_that_of_one_propagate_until(steps, tolerance):
    """At every stop, however many there were before it, and of two throws by turns."""
    world = thrown(f"taylor@{tolerance!r}", THROWS[:2], gravity=GRAVITY)
    starts = world.spins.copy()
    for n, dt in steps:
        engine.advance(world, n, dt)
        for spin, start, anchor in zip(world.spins, starts, world.anchors, strict=True):
            bare = heyoka.taylor_adaptive(engine.equations(*MOMENTS.tolist()), start.tolist(), tol=tolerance)
            bare.propagate_until(anchor.speed * world.elapsed)
            np.testing.assert_array_equal(spin, bare.state)


def test_the_error_is_below_what_was_tolerated_and_falls_with_it():
    question = replace(scene(THROWS, GRAVITY), duration=FLIGHT_S, times=frozen_array([FLIGHT_S]))
    true = truth(question).vertices[-1]
    # A step is less than a radian: the quaternion's errors add up over the radians turned and move the farthest vertex.
    radians = FLIGHT_S * np.linalg.norm(THROWS[:, 10:13], axis=1).max()
    arm_m = np.linalg.norm(SIZE) / 2
    before = np.inf
    for tolerance in (1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12):
        world = thrown(f"taylor@{tolerance:g}", THROWS, (1, FLIGHT_S), gravity=GRAVITY)
        error = np.linalg.norm(vertices(engine.read(world), question.body.points) - true, axis=-1).max()
        # The order goes up by two or three each time: an error may be a lucky one, but not by as much as that.
        assert error < min(tolerance * radians * arm_m, before / 3)
        before = error


def test_the_plain_name_is_its_default():
    np.testing.assert_array_equal(
        engine.read(thrown("taylor", THROWS, (1, 1.0))), engine.read(thrown("taylor@1e-9", THROWS, (1, 1.0)))
    )


@pytest.mark.parametrize(
    "method", ["taylor@", "taylor@tight", "taylor@0", "taylor@1e-300", "taylor@1", "taylor@nan", ""]
)
def test_a_bad_name_is_refused(method):
    with pytest.raises(ValueError, match=r"taylor|convert"):
        engine.build(scene(), method)


def test_what_the_scene_has_not_got_is_not_compiled():
    def terms(**body):
        return len(thrown("taylor", THROWS, **body).taylor.decomposition)

    assert terms(moments=(0.01, 0.01, 0.01)) < terms(moments=(0.01, 0.01, 0.02)) < terms()


def test_what_lies_still_stays():
    still = np.zeros((1, 13))
    still[0, 3] = 1.0
    np.testing.assert_array_equal(engine.read(thrown("taylor", still, (3, 1000.0))), still)


@pytest.mark.parametrize("wrong", [(0, np.inf), (8, np.nan), (10, np.nan), (11, 1e200)])
def test_divergence_comes_out_and_stays_with_its_throw(wrong):
    wild = THROWS.copy()
    wild[(1, wrong[0])] = wrong[1]
    states = engine.read(thrown("taylor", wild, (2, 0.5), (1, 0.25)))
    assert not np.isfinite(states[1]).all()
    np.testing.assert_array_equal(states[[0, 2]], engine.read(thrown("taylor", THROWS[[0, 2]], (2, 0.5), (1, 0.25))))
    assert np.isfinite(states[[0, 2]]).all()


def test_a_long_fall_does_not_loosen_the_tolerance():
    """Where a body is does not matter to how it turns, whatever heyoka's one norm for all numbers says."""
    fall = thrown("taylor@1e-6", THROWS, (1, 100.0), gravity=GRAVITY)
    drift = thrown("taylor@1e-6", THROWS, (1, 100.0))
    np.testing.assert_array_equal(engine.read(fall)[:, 3:7], engine.read(drift)[:, 3:7])


def test_the_tolerance_is_relative_to_the_spin():
    """A millionth of the spin for a million times as long is the same flight, and to the last bit by powers of two."""
    million = 2.0**20
    slow = THROWS.copy()
    slow[:, 10:13] /= million
    np.testing.assert_array_equal(
        engine.read(thrown("taylor@1e-6", slow, (1, 3.0 * million)))[:, 3:7],
        engine.read(thrown("taylor@1e-6", THROWS, (1, 3.0)))[:, 3:7],
    )
