"""PhysX by SAPIEN in its environment: the laws, its defaults, single precision, and what tgs does to energy."""

import numpy as np
import pytest
from apart import broken_laws, engine, flight, throw

from tumble.scenarios.frames import rotation_matrix

MOMENTS = np.array((1.0, 2.0, 3.0))
SPIN = (0.2, 1.0, 0.3)
EPS = float(np.finfo(np.float32).eps)


def energy(state):
    w = rotation_matrix(state[3:7]).T @ state[10:13]
    return MOMENTS @ w**2 / 2


def test_it_keeps_the_laws_and_as_it_ships_all_that_damping_leaves():
    assert broken_laws("physx") == {}
    assert {*broken_laws("physx", "tgs+defaults")} == {"turns", "converges"}


def test_its_settings_lift_its_limit_and_its_damping_and_its_defaults_say_so():
    start = throw(w=(0.0, 0.0, 400.0))
    with engine("physx", "pgs") as ours:
        free = flight(ours, start, 1e-3, 0.1)
        assert free.states[-1, 0, 12] == pytest.approx(400.0, rel=100 * EPS)
        assert not free.findings
    with engine("physx", "tgs+defaults") as shipped:
        clamped = flight(shipped, start, 1e-3, 0.1)
        assert clamped.states[-1, 0, 12] <= 100.0
        assert [found.kind for found in clamped.findings] == ["damped", "clamped"]
        slow = flight(shipped, throw(w=(0.0, 0.0, 1.0)), 1e-2, 1.0)
        assert slow.states[-1, 0, 12] == pytest.approx(np.exp(-0.05), rel=1e-3)
        assert [found.kind for found in slow.findings] == ["damped"]


def test_tgs_gains_energy_and_pgs_hardly():
    gained = {}
    for method in ("pgs", "tgs"):
        with engine("physx", method) as ours:
            states = flight(ours, throw(w=SPIN), 1e-3, 4.0, mass=1.0, moments=MOMENTS).states[:, 0]
        gained[method] = energy(states[-1]) / energy(states[0]) - 1.0
    assert gained["tgs"] > 1e-3
    assert abs(gained["pgs"]) < gained["tgs"] / 10


def test_a_small_step_far_away_is_told_as_frozen():
    with engine("physx", "pgs") as ours:
        still = flight(ours, throw(v=(0.5, 0.0, 0.0), x=(1e5, 0.0, 0.0)), 1e-3, 0.1)  # 5e-4 m is below an ulp of 1e5
        assert [found.kind for found in still.findings] == ["frozen"]
