"""Drake and DART in their environments: the laws, their orders, and how they take the gyroscopic torque."""

from dataclasses import replace

import numpy as np
import pytest
from apart import broken_laws, engine, flight, throw

from tumble.compare.judge.errors import Run
from tumble.compare.run.engines.brick import scene
from tumble.compare.run.status import Failure
from tumble.scenarios.frames import rotation_matrix
from tumble.scenarios.truth import truth

MOMENTS = (1.0, 2.0, 3.0)
START = throw(w=(0.2, 1.0, 0.3))
QUESTION = replace(scene(START, mass=1.0, moments=MOMENTS), duration=4.0, times=np.array([4.0]), step=0.1)
TRUE = truth(QUESTION)


@pytest.mark.parametrize("name", ["drake", "dart"])
def test_it_keeps_the_laws(name):
    assert broken_laws(name) == {}


@pytest.mark.parametrize(
    ("contestant", "order"),
    [("drake:rk3", 3), ("drake:rk5", 5), ("drake:discrete", 1), ("dart:semi-implicit-euler", 1)],
)
def test_its_order(contestant, order):
    name, _, method = contestant.partition(":")
    steps = (0.1, 0.05) if order > 1 else (0.004, 0.002)
    with engine(name, method) as running_engine:
        flights = [running_engine.simulate(QUESTION, method, dt) for dt in steps]
    errors = [Run(QUESTION, name, method, 0.0, each, TRUE).distances.max() for each in flights]
    found = np.log2(errors[0] / errors[1])
    assert order - 0.25 < found < order + 1.1, "rk5 of a free body comes near to six"


def test_error_control_comes_as_near_as_it_is_asked_to():
    with engine("drake", "error-controlled@1e-4", "error-controlled@1e-10") as running_engine:
        flights = [running_engine.simulate(QUESTION, method, QUESTION.duration) for method in running_engine.methods]
    loose, tight = (float(Run(QUESTION, "drake", "", 4.0, each, TRUE).distances.max()) for each in flights)
    assert 1e-7 < loose < 1e-2
    assert tight < 1e-7, "accuracy is that of a step"


def test_what_error_control_makes_of_no_number_is_a_row_and_the_next_flight_is_one():
    with engine("drake", "error-controlled") as running_engine:
        lost = running_engine.simulate(replace(QUESTION, start=throw(w=(np.nan, 0.0, 0.0))), "error-controlled", 4.0)
        assert isinstance(lost, Failure)
        assert str(lost).startswith("crashed: its process ended: Failure at "), "Drake ends the interpreter"
        again = running_engine.simulate(QUESTION, "error-controlled", 4.0)
        assert not isinstance(again, Failure), again


@pytest.mark.parametrize("contestant", ["drake:discrete", "dart:semi-implicit-euler"])
def test_an_explicit_gyroscopic_torque_adds_energy(contestant):
    name, _, method = contestant.partition(":")
    with engine(name, method) as running_engine:
        states = flight(running_engine, START, 0.02, 20.0, mass=1.0, moments=MOMENTS).states[:, 0]
        assert running_engine.info.gyroscopic == {method: "explicit"}
    w = [rotation_matrix(state[3:7]).T @ state[10:13] for state in states[[0, -1]]]
    before, after = (np.array(MOMENTS) @ each**2 for each in w)
    assert after > 1.02 * before


def test_a_pose_that_is_lost_is_not_shown_as_the_identity():
    with engine("dart") as running_engine:
        lost = flight(running_engine, throw(w=(1e200, 2e200, 0.0)), 0.01, 1.0, mass=1.0, moments=MOMENTS)
    assert np.isnan(lost.states[-1]).all()


def test_drake_takes_moments_that_no_body_has():
    flat = (1.0, 1.0, 10.0)
    with engine("drake", "rk5") as running_engine:
        found = flight(running_engine, START, 0.01, 1.0, mass=1.0, moments=flat)
    assert np.isfinite(found.states).all()
