"""The numbers of mistakes are found where they leave least, one by one and together, and by name where that fits."""

from typing import Any, cast

import numpy as np
import pytest

from tumble.compare.grade.hypotheses.explanation import Mistake, value_of
from tumble.compare.grade.hypotheses.hypothesis import Hypothesis
from tumble.compare.grade.search.evaluator import Evaluator
from tumble.compare.grade.search.fitting import Fitter


def hypothesis(name, values=(), **said):
    return Hypothesis(name, name, f"{name} {{}}", lambda program, value: program, values, **said)


SIZE, TIME = hypothesis("size", (0.5, 1.0, 1.5, 2.0)), hypothesis("time", (-1.0, 0.0, 1.0))


class Valley:
    """A residual that is least at size 1.1 and time 0.3, in a valley that lies across both."""

    def __init__(self, least=1e-9):
        self.least = least

    def residuals(self, mistakes, *_):
        values = {mistake.hypothesis.name: mistake.value for mistake in mistakes}
        size, time = values.get("size", 1.1) - 1.1, values.get("time", 0.3) - 0.3
        return np.array([self.least, size + time, np.sqrt(3.0) * (size - 0.5 * time)])

    def log_residual(self, mistakes, *_):
        return float(np.square(self.residuals(mistakes)).sum())

    quick_weight = log_residual


def fitter() -> Fitter:
    return Fitter(cast(Evaluator, cast(Any, Valley())))


def test_all_combinations_of_first_values_are_tried():
    assert len(list(fitter().values_of((SIZE, TIME)))) == 12
    assert list(fitter().values_of(())) == [()]
    (only,) = fitter().values_of((hypothesis("left out"),))
    assert only[0].value == 0.0


def test_a_single_number_is_found_between_those_tried_first():
    (found,) = fitter().tuned((SIZE,))
    assert found.value == pytest.approx(1.1, abs=0.02)


def test_two_numbers_are_found_together():
    found = fitter().fit((Mistake(SIZE, 1.5), Mistake(TIME, -1.0)))
    assert (value_of(found, SIZE), value_of(found, TIME)) == pytest.approx((1.1, 0.3), abs=1e-4)


def test_a_value_never_leaves_those_tried_first():
    narrow = hypothesis("size", (0.5, 0.8))
    assert value_of(fitter().fit((Mistake(narrow, 0.5),)), narrow) == pytest.approx(0.8, abs=1e-4)


def test_a_value_with_a_name_is_taken_and_the_rest_fitted_to_it():
    named_values = hypothesis("size", SIZE.values, named_values={1.2: "the usual", 3.0: "another"})
    found = fitter().snapped((Mistake(named_values, 1.13), Mistake(TIME, 0.0)))
    assert value_of(found, named_values) == 1.2
    # Of (s + t)^2 + 3 (s - t/2)^2 with s = 0.1 the least is at t = 2/7 s.
    assert value_of(found, TIME) == pytest.approx(0.3 + 0.1 * 2 / 7, abs=1e-3)
