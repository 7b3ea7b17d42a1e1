"""The values of mistakes are found where they leave least, one by one and together, and within their bounds."""

from typing import Any, cast

import numpy as np
import pytest

from tumble.compare.grade.hypotheses.explanation import Mistake, value_of
from tumble.compare.grade.hypotheses.hypothesis import Hypothesis
from tumble.compare.grade.search.least_squares import Fit, free_values
from tumble.compare.grade.search.simulations import Simulations


def hypothesis(name, values=(), **said):
    return Hypothesis(name, name, f"{name} {{}}", lambda program, value: program, values, **said)


SIZE, TIME = hypothesis("size", (0.5, 1.0, 1.5, 2.0)), hypothesis("time", (-1.0, 0.0, 1.0))


class Squares:
    """Residuals weigh as much as their squares."""

    def weights(self, errors):
        return np.square(errors).sum(axis=(1, 2, 3))

    def weighted(self, residuals, like):
        return residuals


class Valley:
    """A residual that is least at size 1.1 and time 0.3, in a curved valley that lies across both."""

    def __init__(self):
        self.shells, self.bend, self.tick = Squares(), 0.1, 0.0

    def errors(self, programs):
        return 1e3 * np.array([[[self._one(mistakes)]] for mistakes in programs])

    def _one(self, mistakes):
        values = {mistake.hypothesis.name: mistake.value for mistake in mistakes}
        size, time = values.get("size", 1.1) - 1.1, values.get("time", 0.3) - 0.3
        size += self.bend * time**2
        return size + time, np.sqrt(3.0) * (size - 0.5 * time), 0.0

    def event_tick(self, _):
        return self.tick


def fitted(mistakes, valley=None):
    return Fit(cast(Simulations, cast(Any, valley or Valley()))).fitted(mistakes)


def test_a_single_number_is_found_between_those_tried_first():
    found = fitted((Mistake(SIZE, 1.5),))
    assert value_of(found.mistakes, SIZE) == pytest.approx(1.1, abs=1e-6)
    assert found.weight == found.score == pytest.approx(0.0, abs=1e-3)


def test_two_numbers_are_found_together():
    found = fitted((Mistake(SIZE, 1.5), Mistake(TIME, -1.0))).mistakes
    assert (value_of(found, SIZE), value_of(found, TIME)) == pytest.approx((1.1, 0.3), abs=1e-6)


def test_a_value_never_leaves_those_tried_first():
    narrow = hypothesis("size", (0.5, 0.8))
    assert value_of(fitted((Mistake(narrow, 0.5),)).mistakes, narrow) == 0.8


def test_a_time_that_takes_effect_at_ticks_is_moved_by_ticks():
    """Its derivative is zero nearly everywhere."""

    class Ticks(Valley):
        def _one(self, mistakes):
            ticks = np.ceil(mistakes[0].value / self.tick - 1e-9)
            return ticks - 17.0, 0.0, 0.0

    valley = Ticks()
    valley.tick = 0.125
    late = hypothesis("late", (0.0, 1.0, 2.0, 3.0), at_ticks=True)
    found = fitted((Mistake(late, 1.0),), valley)
    assert 16 * valley.tick < value_of(found.mistakes, late) <= 17 * valley.tick
    assert found.score == 0.0


def test_values_are_fitted_together_as_alone_and_in_parts_as_at_once():
    programs = [(), (Mistake(SIZE, 2.0),), (Mistake(SIZE, 1.5), Mistake(TIME, -1.0)), (Mistake(TIME, 1.0),)]
    fit = Fit(cast(Simulations, cast(Any, Valley())))
    alone = [fit.fitted(program) for program in programs]
    together = fit.advanced(fit.begun(programs), 1)
    assert not all(each.is_done for each in together)  # so that there are parts
    together = fit.advanced(together)
    for one, other in zip(alone, together, strict=True):
        assert (one.mistakes, one.weight, one.score) == (other.mistakes, other.weight, other.score)
        assert np.array_equal(one.errors, other.errors)


@pytest.mark.parametrize("slope", [0.0, 1e300], ids=["no effect", "as good as infinite"])
def test_a_value_stays_where_no_step_is_known(slope):
    """Such a step would make it no number, and where a mistake is late there is no such tick."""
    fit = Fit(cast(Simulations, cast(Any, Valley())))
    [*steps] = fit.solutions(np.full((1, 2, 1, 3), slope), np.full((2, 1, 3), 1e300))
    assert np.isfinite(steps).all()


def test_steps_and_choices_are_not_fitted():
    step = Hypothesis("method", "steps", "{}", lambda program, value: program, (0.1, 0.2))
    which = hypothesis("which", (0.0, 1.0), choices=("this", "that"))
    assert free_values((Mistake(step, 0.1), Mistake(which, 0.0), Mistake(SIZE, 1.0), Mistake(hypothesis("none")))) == [
        SIZE
    ]
