"""Schemes with damping of any rate, anywhere in the step: fitted as a whole, since each part masks the others.

Engines damp at their own rates, listed in `engine_schemes`; a student's program has `linear damping = 0.3`.
"""

from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from itertools import product
from math import log

from tumble.compare.grade.hypotheses.engine_schemes import (
    DAMPING_FORMS,
    Damping,
    SteppedScheme,
)
from tumble.compare.grade.hypotheses.explanation import Explanation, Mistakes
from tumble.compare.grade.hypotheses.scheme_hypotheses import SchemeHypotheses
from tumble.compare.grade.model.kernel.dynamics import AFTER_FORCES, AS_FORCE, EXPONENTIALLY, LINEARLY
from tumble.compare.grade.search.evaluator import Evaluator
from tumble.compare.grade.search.fitting import Fitter
from tumble.compare.grade.search.scheme_search import LATE, Point, SchemeSearch

# Rough schemes that are improved, and of these, those that are explained.
IMPROVED, PLACED = 2, 2
# Shares of the duration over which rates are fitted before all of it.  Over a long run a slightly wrong rate leaves as
# much as a very wrong one, since the attitude at the end is then arbitrary.
GROWING = (1 / 8, 1 / 4, 1 / 2)
# Rows that a share of the duration must have to show a rate.
FEWEST = 12
# Significant digits of a rate that a person wrote.
FEW_DIGITS = (1, 2, 3)
# A run of more steps takes longer than it is worth.
MOST_STEPS = 5_000


class DampingSearch:
    """Fits the rates of linear and angular damping to the rows, in every scheme of an engine."""

    def __init__(
        self, evaluator: Evaluator, fitter: Fitter, hypotheses: SchemeHypotheses, schemes: SchemeSearch
    ) -> None:
        self._evaluator, self._fitter, self._hypotheses, self._schemes = evaluator, fitter, hypotheses, schemes

    def explanations(self, weight: float) -> list[Explanation]:
        """Return the explanations by schemes with fitted damping, best first.

        Rough schemes that do not even fit as well as something else, whose weight is given, are not improved.
        """
        begun = sorted((one for one in self._begun() if self._weight(one) < weight), key=self._weight)[:IMPROVED]
        improved = [point.stepped for one in begun if (point := self._schemes.improved(Point((), one))).stepped]
        fitted = [each for one in improved for each in self._fitted(one)]
        best = sorted(fitted, key=self._weight)[:PLACED]
        found = [self._evaluator.explain(self._mistakes(one)) for one in best]
        if found and found[0].within_floor:
            found = [self._in_few_digits(best[0], found[0])]
        found += map(self._continuous, best[:1])
        return sorted(found, key=lambda each: each.weight)

    def _continuous(self, stepped: SteppedScheme) -> Explanation:
        """Return the explanation by the same damping in a program whose steps are too fine to be seen."""
        damping = replace(stepped.scheme.damping, place=AS_FORCE, form=LINEARLY)
        mistakes = self._mistakes(replace(_with_damping(stepped, damping), late=0))
        return self._evaluator.explain(self._fitter.fit(tuple(m for m in mistakes if m.hypothesis.part != "steps")))

    def _in_few_digits(self, stepped: SteppedScheme, explanation: Explanation) -> Explanation:
        """Return a scheme with the rates, and in the form, that take fewest digits and fit as well.

        c dt, exp(-c dt) and 1 / (1 + c dt) reduce a velocity equally in a step, with different rates c.
        """
        damping = stepped.scheme.damping
        for digits, form in product(FEW_DIGITS, (LINEARLY,) if damping.place == AS_FORCE else DAMPING_FORMS):
            rates = (as_rate(rate, stepped.step, form) for rate in (damping.linear, damping.angular))
            linear, angular = (float(f"{rate:.{digits - 1}e}") for rate in rates)
            other = replace(damping, linear=linear, angular=angular, form=form)
            mistakes = self._mistakes(_with_damping(stepped, other))
            if (found := self._evaluator.explain(mistakes)).within_floor:
                return found
        return explanation

    def _begun(self) -> Iterator[SteppedScheme]:
        """Yield rough schemes with the rates that fit them."""
        context = self._evaluator.context
        damping = Damping(1 / context.duration, 1 / context.duration, place=AFTER_FORCES, form=LINEARLY)
        early = self._fitters[0]
        for stepped in self._schemes.rough:
            if context.duration <= MOST_STEPS * stepped.step:
                # The first rows show how late they are; without that no rate fits.
                shifted = (replace(stepped, late=late) for late in LATE)
                late = min(shifted, key=lambda each: early.quick_weight(self._hypotheses.mistakes(each)))
                yield self._first_fit(_with_damping(late, damping))

    @cached_property
    def _fitters(self) -> list[Fitter]:
        """The fitters for growing shares of the duration that have enough rows."""
        times, duration = self._evaluator.rows.times, self._evaluator.context.duration
        shares = [share for share in GROWING if (times <= share * duration).sum() >= FEWEST]
        return [*(Fitter(self._evaluator.truncated(share)) for share in shares), self._fitter]

    def _first_fit(self, stepped: SteppedScheme) -> SteppedScheme:
        """Return a scheme with rates fitted to the beginning of the run, then to more and more of it."""
        mistakes = self._mistakes(stepped)
        for hypothesis in [mistake.hypothesis for mistake in mistakes if mistake.hypothesis.fitted]:
            mistakes = self._fitters[0].best_of(mistakes, hypothesis, hypothesis.values)
        for fitter in self._fitters:
            mistakes = fitter.fit(mistakes)
        return _with_rates(stepped, mistakes)

    def _fitted(self, stepped: SteppedScheme) -> Iterator[SteppedScheme]:
        """Yield a scheme with jointly fitted rates, and with either damping alone."""
        linear, angular = stepped.scheme.damping.linear, stepped.scheme.damping.angular
        for one, other in ((linear, angular), (linear, 0.0), (0.0, angular)):
            if one or other:
                some = _with_damping(stepped, replace(stepped.scheme.damping, linear=one, angular=other))
                yield _with_rates(some, self._fitter.fit(self._mistakes(some)))

    def _mistakes(self, stepped: SteppedScheme) -> Mistakes:
        """Return the mistakes of a scheme whose rates are fitted."""
        return self._hypotheses.mistakes(stepped, fitted=True)

    def _weight(self, stepped: SteppedScheme) -> float:
        """Return the weight of a scheme over all rows."""
        return self._evaluator.scheme_weight(self._mistakes(stepped))


def _with_damping(stepped: SteppedScheme, damping: Damping) -> SteppedScheme:
    return replace(stepped, scheme=replace(stepped.scheme, damping=damping))


def _with_rates(stepped: SteppedScheme, mistakes: Mistakes) -> SteppedScheme:
    """Return a scheme with the rates of its fitted mistakes."""
    rates = {mistake.hypothesis.part: mistake.value for mistake in mistakes}
    linear, angular = rates.get("linear damping", 0.0), rates.get("angular damping", 0.0)
    return _with_damping(stepped, replace(stepped.scheme.damping, linear=linear, angular=angular))


def as_rate(linear: float, step: float, form: int) -> float:
    """Return the rate [1/s] with which a form of damping reduces a velocity in a step [s] as c dt does."""
    left = 1 - linear * step
    if form == LINEARLY or left <= 0:
        return linear
    return -log(left) / step if form == EXPONENTIALLY else (1 / left - 1) / step
