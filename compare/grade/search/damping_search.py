"""Schemes with damping of any rate, anywhere in the step: fitted as a whole, as each part hides what the others do.

Engines damp at rates of their own, which `engines` has; a program of a student has `linear damping = 0.3`.
"""

from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from itertools import product
from math import log

from tumble.compare.grade.hypotheses.engine_schemes import (
    DECAYS,
    GYROSCOPIC,
    LATE,
    PLACES,
    ROTATION,
    Damping,
    Flown,
    Law,
)
from tumble.compare.grade.hypotheses.explanation import Explanation, Mistakes
from tumble.compare.grade.hypotheses.scheme_hypotheses import Laws
from tumble.compare.grade.model.kernel.dynamics import AFTER_FORCES, AS_FORCE, EXPONENTIALLY, LINEARLY
from tumble.compare.grade.search.evaluator import Flights
from tumble.compare.grade.search.fitting import Fitter

# Schemes that are fitted, of all at their first rates; and of these those whose damping is put elsewhere in the step.
FITTED, PLACED = 12, 2
# Shares of a flight over which rates are fitted before all of it: over all of a long one a rate that is a little off
# leaves as much as one that is far off, as the body is turned by any angle at its end.
GROWING = (1 / 8, 1 / 4, 1 / 2)
# Rows without which a share of a flight shows no rates.
FEWEST = 12
# Digits that a rate is written in.
FEW_DIGITS = (1, 2, 3)
# A flight of more steps than this takes longer than it is worth.
MOST_STEPS = 5_000


class Damped:
    """Fits the rates of both dampings to the rows, in every scheme that engines have."""

    def __init__(self, flights: Flights, fitter: Fitter, laws: Laws) -> None:
        self._flights, self._fitter, self._laws = flights, fitter, laws

    def explanations(self) -> list[Explanation]:
        """Return what schemes with fitted damping leave, best first; nothing where none has few enough steps."""
        begun = sorted(self._begun(), key=self._weight)[:FITTED]
        fitted = sorted((each for one in begun for each in self._fitted(one)), key=self._weight)[:PLACED]
        placed = [each for one in fitted for other in _elsewhere(one) for each in self._fitted(other)]
        best = sorted((*fitted, *placed), key=self._weight)[:PLACED]
        found = [self._flights.explain(self._said(one)) for one in best]
        if found and found[0].nothing:
            found = [self._in_few_digits(best[0], found[0])]
        found += map(self._smooth, best[:1])
        return sorted(found, key=lambda each: each.weight)

    def _smooth(self, flown: Flown) -> Explanation:
        """Return what the same damping leaves of a flight that is right but for it: steps too fine to be seen."""
        damping = replace(flown.law.damping, damps=AS_FORCE, decays=LINEARLY)
        said = self._said(replace(flown, law=replace(flown.law, damping=damping), late=0))
        return self._flights.explain(self._fitter.fit(tuple(m for m in said if m.hypothesis.part != "steps")))

    def _in_few_digits(self, flown: Flown, explanation: Explanation) -> Explanation:
        """Return a scheme with the rates, and in the form, that take fewest digits and do as well.

        A step takes as much by c dt as by exp(-c dt) or 1 / (1 + c dt) with other rates c.
        """
        damping = flown.law.damping
        for digits, decays in product(FEW_DIGITS, (LINEARLY,) if damping.damps == AS_FORCE else DECAYS):
            rates = (as_rate(rate, flown.step, decays) for rate in (damping.linear, damping.angular))
            linear, angular = (float(f"{rate:.{digits - 1}e}") for rate in rates)
            other = replace(damping, linear=linear, angular=angular, decays=decays)
            said = self._said(replace(flown, law=replace(flown.law, damping=other)))
            if (found := self._flights.explain(said)).nothing:
                return found
        return explanation

    def _begun(self) -> Iterator[Flown]:
        """Yield every scheme at the rates that suit its kind, with rows on time, late and early."""
        question = self._flights.question
        steps = [step for step in question.parts if question.duration <= MOST_STEPS * step]
        forced = (False, True) if question.account.impulses else (False,)
        damping = Damping(1 / question.duration, 1 / question.duration, damps=AFTER_FORCES, decays=LINEARLY)
        for late, kind, step in product(LATE, ("none", "explicit"), steps):
            first = self._first(Flown(Law("", kind, "exponential", damping), step, late))
            schemes = [name for name in GYROSCOPIC if (name == "none") == (kind == "none")]
            for scheme, rotation, force in product(schemes, ROTATION, forced):
                yield Flown(replace(first.law, gyroscopic=scheme, rotation=rotation), step, late, force)

    @cached_property
    def _fitters(self) -> list[Fitter]:
        """The fitters of growing shares of the flight, those that have rows enough."""
        times, duration = self._flights.all.times, self._flights.question.duration
        shares = [share for share in GROWING if (times <= share * duration).sum() >= FEWEST]
        return [*(Fitter(self._flights.until(share)) for share in shares), self._fitter]

    def _first(self, flown: Flown) -> Flown:
        """Return a scheme at the rates that suit the beginning of the flight best, then more and more of it."""
        mistakes = self._said(flown)
        for hypothesis in [mistake.hypothesis for mistake in mistakes if mistake.hypothesis.fitted]:
            mistakes = self._fitters[0].best_of(mistakes, hypothesis, hypothesis.values)
        for fitter in self._fitters:
            mistakes = fitter.fit(mistakes)
        return _with_rates(flown, mistakes)

    def _fitted(self, flown: Flown) -> Iterator[Flown]:
        """Yield a scheme with its rates at their joint best, and with either damping alone."""
        linear, angular = flown.law.damping.linear, flown.law.damping.angular
        for one, other in ((linear, angular), (linear, 0.0), (0.0, angular)):
            if one or other:
                damping = replace(flown.law.damping, linear=one, angular=other)
                some = replace(flown, law=replace(flown.law, damping=damping))
                yield _with_rates(some, self._fitter.fit(self._said(some)))

    def _said(self, flown: Flown) -> Mistakes:
        """Return what is said of a scheme whose rates are to be fitted."""
        return self._laws.mistakes(flown, fitted=True)

    def _weight(self, flown: Flown) -> float:
        """Return the weight of a scheme over all rows."""
        return self._flights.law(self._said(flown))


def _with_rates(flown: Flown, mistakes: Mistakes) -> Flown:
    """Return a scheme with the rates that its mistakes were fitted to."""
    rates = {mistake.hypothesis.part: mistake.value for mistake in mistakes}
    linear, angular = rates.get("linear damping", 0.0), rates.get("angular damping", 0.0)
    return replace(flown, law=replace(flown.law, damping=replace(flown.law.damping, linear=linear, angular=angular)))


def _elsewhere(flown: Flown) -> Iterator[Flown]:
    """Yield a scheme with its damping at every other place of the step; a wrong place hides how the body is turned."""
    law = flown.law
    for damps, rotation in product(PLACES, ROTATION):
        if damps != law.damping.damps:
            yield replace(flown, law=replace(law, rotation=rotation, damping=replace(law.damping, damps=damps)))


def as_rate(linear: float, step: float, decays: int) -> float:
    """Return the rate [1/s] of a form of damping that takes as much in a step [s] as a rate does by c dt."""
    left = 1 - linear * step
    if decays == LINEARLY or left <= 0:
        return linear
    return -log(left) / step if decays == EXPONENTIALLY else (1 / left - 1) / step
