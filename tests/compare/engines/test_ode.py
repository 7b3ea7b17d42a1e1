"""ODE in its environment: the laws, one step by hand, its orders of rotation, and Debian's package found or refused."""

from dataclasses import replace

import numpy as np
import pytest
from apart import broken_laws, engine, flight, throw

from tumble.compare.judge.errors import Run
from tumble.compare.run.engines import installing
from tumble.compare.run.engines.brick import scene
from tumble.compare.run.engines.installing import install
from tumble.compare.run.engines.registry import BadEngine
from tumble.compare.run.status import Failure
from tumble.scenarios.frames import rotation_matrix
from tumble.scenarios.truth import truth

MOMENTS = np.array([1.0, 2.0, 3.0])
START = throw(v=(0.5, 0.0, 0.0), w=(0.2, 1.0, 0.3))
STEP = 0.05


def test_it_keeps_the_laws():
    assert broken_laws("ode") == {}
    assert broken_laws("ode", "step+defaults") == {}


def across(vector):
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


@pytest.mark.parametrize("method", ["step", "quickstep", "step+defaults"])
def test_one_step_is_its_own_formula(method):
    """(I - h [L]) w' = L, L that of the start, and the attitude turned by w' h: exactly, or to first order."""
    with engine("ode", method) as ours:
        state = flight(ours, START, STEP, STEP, mass=1.0, moments=MOMENTS).states[-1, 0]
    momentum = MOMENTS * START[0, 10:13]
    w = np.linalg.solve(np.diag(MOMENTS) - STEP * across(momentum), momentum)
    np.testing.assert_allclose(state[10:13], w, rtol=0, atol=4e-15)
    half = STEP / 2 * np.linalg.norm(w)
    q = np.array([np.cos(half), *(np.sin(half) * w / np.linalg.norm(w))])
    if method == "step+defaults":
        q = np.array([1.0, *(STEP / 2 * w)]) / np.hypot(1.0, half)
    np.testing.assert_allclose(state[3:7], q, rtol=0, atol=4e-15)


def test_its_order_is_one_and_it_takes_energy():
    question = replace(scene(START, mass=1.0, moments=MOMENTS), duration=4.0, times=np.array([4.0]))
    true = truth(question)
    with engine("ode", "step") as ours:
        flights = [ours.simulate(question, "step", dt) for dt in (0.004, 0.002)]
    coarse, fine = (float(Run(question, "ode", "step", 0.0, each, true).distances.max()) for each in flights)
    assert np.log2(coarse / fine) == pytest.approx(1.0, abs=0.1)
    w = rotation_matrix(flights[0].states[-1, 0, 3:7]).T @ flights[0].states[-1, 0, 10:13]
    assert MOMENTS @ w**2 < MOMENTS @ START[0, 10:13] ** 2


def test_a_number_that_is_none_costs_a_flight_and_the_next_one_is_flown():
    with engine("ode", "step") as ours:
        question = scene(START, mass=1.0, moments=MOMENTS)
        lost = ours.simulate(replace(question, start=throw(w=(np.nan, 0.0, 0.0))), "step", 0.01)
        assert str(lost) == "crashed: its process was killed by SIGABRT", "ODE's own assertion"
        assert not isinstance(ours.simulate(question, "step", 0.01), Failure)


def test_another_release_than_debians_is_refused_and_leaves_nothing(monkeypatch, tmp_path):
    with engine("ode"):
        pass
    monkeypatch.setenv("TUMBLE_ENVIRONMENTS", str(tmp_path))
    with pytest.raises(BadEngine, match=r"ode@9\.9: Debian here has 1\.2\.0\.dev15-\S+ of it; nothing was kept"):
        install("ode@9.9")
    monkeypatch.setattr(installing.shutil, "which", lambda name: None)
    with pytest.raises(BadEngine, match="needs apt-get and dpkg-deb, which are not here"):
        install("ode")
    assert list(tmp_path.iterdir()) == []
