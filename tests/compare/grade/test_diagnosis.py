"""Which of many explanations is told: not one that is padded, and one of each kind."""

from dataclasses import replace
from types import SimpleNamespace

import pytest
from explanations import explanation

from tumble.compare.grade.hypotheses.explanation import Explanation, Mistake
from tumble.compare.grade.hypotheses.hypothesis import Hypothesis
from tumble.compare.grade.search.diagnosis import (
    DRIFT,
    LEAST_HELP,
    MUCH_HELP,
    _as_good,
    _best,
    _distinct,
    _is_padded,
    _with_drift,
)


def with_detail(name, part, word, rms_m):
    method = Hypothesis(name, "steps", name, lambda program, _: program, details=((part, word),))
    return Explanation((Mistake(method),), rms_m, rms_m, False, False, 0.0, rms_m)


ALONE, PAIR = explanation("a", 1.0), explanation("ab", 1.0)


def is_padded(one, others):
    """Return whether an explanation is padded, of rows every second."""
    return _is_padded(one, others, 1.0)


def test_a_second_mistake_that_helps_little_is_padding():
    assert is_padded(explanation("ab", 1.01 / MUCH_HELP), [ALONE])
    assert not is_padded(explanation("ab", 0.99 / MUCH_HELP), [ALONE])


def test_what_only_a_larger_floor_of_its_own_explains_is_padding():
    assert is_padded(explanation("ab", 0.5 / MUCH_HELP, in_common=1.01 / MUCH_HELP), [ALONE])
    assert not is_padded(explanation("ab", 0.5 / MUCH_HELP, in_common=0.99 / MUCH_HELP), [ALONE])


def test_one_that_leaves_nothing_needs_to_help_less():
    assert not is_padded(explanation("ab", 0.99 / LEAST_HELP, nothing=True), [ALONE])
    assert is_padded(explanation("ab", 1.01 / LEAST_HELP, nothing=True), [ALONE])
    assert is_padded(explanation("ab", 1e-9, nothing=True), [explanation("a", 1e-6, nothing=True)])


@pytest.mark.parametrize(("left", "without", "padded"), [(0.5, 7.5, False), (3.0, 7.5, True), (0.1, 1.9, True)])
def test_a_scheme_is_no_padding_where_much_is_left_without_it(left, without, padded):
    """Single precision would explain that too; but of what it explains in any program, less says nothing."""
    pair, alone = explanation("ab", left, nothing=True), explanation("a", without, nothing=True)
    assert is_padded(pair, [alone]) is padded
    rate = Mistake(Hypothesis("rate", "rate", "{}", lambda program, _: program, (0.1, 1.0)), 0.5)
    fitted = replace(pair, mistakes=(*alone.mistakes, rate))
    assert is_padded(fitted, [alone]), "any value may be fitted to what single precision leaves"


@pytest.mark.parametrize(("left", "without", "padded"), [(1.5, 9.0, False), (2.1, 9.0, True), (1.5, 2.9, True)])
def test_a_scheme_is_no_padding_where_only_noise_is_left_with_it(left, without, padded):
    """Single precision would explain what is left without it; more digits are left by both, since there is noise."""
    pair, alone = (
        replace(explanation(names, rms, nothing=True), in_digits=10 * rms, in_double=rms, in_common=0.1)
        for names, rms in (("ab", left), ("a", without))
    )
    assert is_padded(pair, [alone]) is padded
    factor = Mistake(Hypothesis("factor", "factor", "{}", lambda program, _: program, (0.5, 2.0)), 1.0001)
    assert is_padded(replace(pair, mistakes=(*alone.mistakes, factor)), [alone]), "fitted to what was left"


def test_only_some_of_its_own_mistakes_make_it_padding():
    assert not is_padded(PAIR, [explanation("c", 0.1), explanation("abc", 0.1), PAIR])
    assert is_padded(ALONE, [explanation("", 1.0)])


def test_of_explanations_with_the_same_names_the_first_is_told():
    first, same, other = explanation("ab", 1.0), explanation("ba", 2.0), explanation("a", 3.0)
    assert list(_distinct([first, same, other])) == [first, other]


def test_of_explanations_with_the_same_motion_the_first_is_told():
    """A body that does not turn has the same motion with every update of the rotation."""
    exponential, first_order, other = (
        with_detail("euler", "rotation", word, rms) for word, rms in (("a", 1.0), ("b", 1.0 + 1e-9), ("c", 1.01))
    )
    assert list(_distinct([exponential, first_order, other])) == [exponential, other]


def test_a_clock_that_is_ahead_is_told_once_and_not_as_an_early_log_as_well():
    early, ahead, more = (
        with_detail(name, "", "", rms)
        for name, rms in (("log-lag", 1.0), ("clock-offset", 1.0 + 1e-9), ("clock-offset", 1.1))
    )
    assert list(_distinct([early, ahead])) == [early]
    assert list(_distinct([early, more])) == [early, more]


def test_of_explanations_that_single_precision_hides_one_with_plain_values_is_told():
    evaluator = SimpleNamespace(scale=SimpleNamespace(floor_m=0.01), cost=lambda mistakes: 1.0)
    rate = Hypothesis("rate", "rate", "{}", lambda program, _: program, (0.1, 1.0))
    first, plain, larger = (
        replace(
            explanation("a", left, nothing=True), mistakes=(Mistake(rate, value),), in_floors=floors, in_digits=50.0
        )
        for left, value, floors in ((1.0, 0.250312, 0.1), (3.0, 0.25, 0.4), (9.0, 0.3, 1.2))
    )
    ranked = [first, larger, plain]
    assert _as_good(evaluator, ranked) == [first, plain]
    assert _best(evaluator, first, [first, plain]) is plain
    assert _best(evaluator, plain, [plain, first]) is plain
    assert _as_good(evaluator, [replace(first, in_digits=1.0), plain]) == [], "all of its digits are right"


def test_of_explanations_that_leave_noise_one_with_plain_values_is_told():
    """Its residual is hardly larger: the odds are below e^2."""
    evaluator = SimpleNamespace(cost=lambda mistakes: 1.0)
    rate = Hypothesis("rate", "rate", "{}", lambda program, _: program, (0.1, 1.0))
    first, plain, unlikely = (
        replace(explanation("a", 1.0), mistakes=(Mistake(rate, value),), is_noise=True, weight=weight)
        for value, weight in ((0.250312, 100.0), (0.25, 103.9), (0.3, 104.1))
    )
    other = replace(explanation("b", 1.0), is_noise=True, weight=100.1)
    ranked = [first, other, plain, unlikely]
    assert _as_good(evaluator, ranked) == [first, plain]
    assert _best(evaluator, first, [first, plain]) is plain
    assert _as_good(evaluator, [replace(first, is_noise=False), plain]) == [], "what is left of it is something else"


GROWTH = Hypothesis(
    "angular-damping-reversed", "angular damping", "{}", lambda p, _: p, (0.1, 1.0), unit="1/s", neutral=0.0
)


@pytest.mark.parametrize(
    ("refined_rate", "changes", "is_found"),
    [
        (0.9 * DRIFT, {}, True),
        (1.1 * DRIFT, {}, False),
        (0.9 * DRIFT, {"within_floor": True}, False),
        (0.9 * DRIFT, {"in_common": 2.1}, False),
        (0.9 * DRIFT, {"mistakes": (Mistake(replace(GROWTH, name="other")),)}, False),
    ],
)
def test_a_slow_growth_of_the_spin_is_sought_where_nothing_else_is_left(refined_rate, changes, is_found):
    """The search took the rest for single precision, as of any program, but that of its own is less."""
    best = replace(explanation("a", 1.0, in_common=1.9), **changes)
    whole = replace(explanation("a", 0.1, nothing=True), mistakes=(*best.mistakes, Mistake(GROWTH, refined_rate)))
    evaluator = SimpleNamespace(
        single=True, hypotheses=[GROWTH], context=SimpleNamespace(duration=1.0), explain=lambda mistakes: mistakes
    )
    tried = []
    closing = SimpleNamespace(refined=lambda mistakes: tried.append(mistakes) or whole)
    search = SimpleNamespace(proposals=SimpleNamespace(ordered=tuple))
    assert _with_drift(evaluator, best, closing, search) == [whole] * is_found
    assert all(mistakes[: len(best.mistakes)] == best.mistakes for mistakes in tried)
    evaluator.single = False
    assert _with_drift(evaluator, best, closing, search) == []
