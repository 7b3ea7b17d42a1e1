"""Box3D in its environment: the laws, its limits, and what it puts to sleep."""

import math

import pytest
from apart import broken_laws, engine, flight, throw

EPS = 2.0**-23


def test_it_keeps_the_laws():
    assert broken_laws("box3d") == {}
    assert broken_laws("box3d", "semi-implicit-euler+defaults") == {}


def test_its_settings_lift_its_limits_and_its_defaults_say_so():
    thrown = throw(v=(1000.0, 0.0, 0.0), w=(0.0, 0.0, 400.0))
    with engine("box3d") as ours:
        free = flight(ours, thrown, 1 / 60, 1.0)
        assert free.states[-1, 0, [7, 12]] == pytest.approx([1000.0, 400.0], rel=60 * EPS)
        assert not free.findings
    with engine("box3d", "semi-implicit-euler+defaults") as shipped:
        clamped = flight(shipped, thrown, 1 / 60, 1.0)
        assert clamped.states[-1, 0, [7, 12]] == pytest.approx([400.0, 15 * math.pi], rel=300 * EPS)  # pi/4 a step
        assert [found.kind for found in clamped.findings] == ["clamped", "clamped"]
