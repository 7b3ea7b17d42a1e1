"""A truth takes no longer than it may, wherever it is at work, and says so."""

from dataclasses import replace

import numpy as np
import pytest

from tumble.scenarios.read import read_scene
from tumble.scenarios.scene import frozen_array
from tumble.scenarios.truth import NoTruth, truth
from tumble.scenarios.truth.deadline import Deadline, Late, current, within


def long(name, duration, samples):
    """Return a scene of the catalogue that goes on for longer [s]."""
    times = frozen_array(np.linspace(0, duration, samples + 1)[1:])
    return replace(read_scene(name), duration=duration, times=times)


def test_a_free_flight_of_many_samples_ends():
    with pytest.raises(NoTruth, match=r"not computed within 0\.03 s \(--time-limit\)"):
        truth(long("yardstick", 300.0, 20_000), limit_s=0.01)


def test_many_throws_end():
    with pytest.raises(NoTruth, match=r"not computed within 0 s \(--time-limit\)"):
        truth(long("many-throws", 100.0, 2_000), limit_s=0.0)


def test_a_stiff_flight_ends_and_is_known_until_then():
    with pytest.raises(NoTruth, match=r"the 0\.05 s of --time-limit were up"):
        truth(long("rod-stiff", 4000.0, 4), limit_s=0.05)


def test_what_is_quick_enough_is_the_same_with_a_limit():
    scene = read_scene("two-hits")
    assert (truth(scene, limit_s=600.0).vertices == truth(scene).vertices).all()


def test_a_deadline_is_of_the_truth_within_it_only():
    with within(0.0):
        with pytest.raises(Late):
            current().check()
        with within(1e9):
            current().check()
    current().check()
    assert Deadline(float("inf")).left_s() == float("inf")
