"""Rapier in its environment: the laws, its limits, the floor of single precision, and Table 4.1."""

import math

import numpy as np
import pytest
from apart import broken_laws, engine, flight, throw

from tumble.compare.stability.modes import stiffest_mode
from tumble.compare.stability.theory import theory
from tumble.scenarios.frames import rotation_matrix
from tumble.scenarios.read import read_scene

MOMENTS = (1.0, 2.0, 3.0)
SPIN = (0.2, 1.0, 0.3)
EPS = float(np.finfo(np.float32).eps)


def test_it_keeps_the_laws():
    assert broken_laws("rapier") == {}
    assert broken_laws("rapier", "tgs+defaults") == {}


def test_its_settings_lift_its_limits_and_its_defaults_say_so():
    fast, spinning = throw(v=(1000.0, 0.0, 0.0)), throw(w=(0.0, 0.0, 400.0))
    with engine("rapier") as ours:
        assert flight(ours, fast, 1 / 60, 1.0).states[-1, 0, 7] == 1000.0
        assert flight(ours, spinning, 1 / 60, 1.0).states[-1, 0, 12] == pytest.approx(400.0, rel=60 * EPS)
        assert not flight(ours, fast, 1 / 60, 1.0).findings
    with engine("rapier", "tgs+defaults") as shipped:
        clamped = flight(shipped, fast, 1 / 60, 1.0)
        assert clamped.states[-1, 0, 7] == pytest.approx(400.0)
        assert "clamped" in [found.kind for found in clamped.findings]
        assert flight(shipped, spinning, 1 / 60, 1.0).states[-1, 0, 12] == pytest.approx(
            15 * math.pi, rel=300 * EPS
        )  # five a step
        assert "clamped" in [found.kind for found in flight(shipped, spinning, 1 / 60, 1.0).findings]


def test_a_small_body_that_should_move_and_does_not_is_frozen():
    with engine("rapier") as ours:
        still = flight(ours, throw(v=(0.5, 0.0, 0.0), x=(1e5, 0.0, 0.0)), 1e-3, 0.1)  # 5e-4 m is below an ulp of 1e5
        assert [found.kind for found in still.findings] == ["frozen"]


def test_the_angular_momentum_keeps_its_length_to_rounding():
    with engine("rapier") as ours:
        states = flight(ours, throw(w=SPIN), 1e-2, 10.0, moments=MOMENTS, mass=1.0).states[:, 0]
    before, after = (np.linalg.norm(momentum(state)) for state in (states[0], states[-1]))
    assert after == pytest.approx(before, rel=1000 * 2 * EPS)  # L is turned and rescaled: two roundings a step
    assert after != before, "it would be of double precision"


def momentum(state):
    axes = rotation_matrix(state[3:7])
    return axes @ (MOMENTS * (axes.T @ state[10:13]))


def test_a_force_held_over_its_four_substeps_is_unstable_at_every_step():
    """Its own scheme, stated as a function, evaluated in its environment: det = 1 + 3/8 h^2 s > 1."""
    scene = read_scene("tether-undamped")
    mode = stiffest_mode(scene)
    with engine("rapier", "tgs+defaults") as shipped:
        found = theory(shipped, "tgs+defaults", scene, mode)
        assert found.w_dt == 0.0
        assert found.source.startswith("its own scheme")
        assert theory(shipped, "tgs+held", scene, mode).w_dt == pytest.approx(2.0, rel=1e-5)
