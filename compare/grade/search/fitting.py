"""Fits the numbers of mistakes: one after the other at a glance, then all of them over all rows."""

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from tumble.compare.grade.hypotheses.explanation import Mistake, Mistakes, value_of, with_value
from tumble.compare.grade.hypotheses.hypothesis import Hypothesis
from tumble.compare.grade.measure.errors import Kept
from tumble.compare.grade.model.program_model import SEARCHING
from tumble.compare.grade.search.evaluator import Flights
from tumble.scenarios.frames import Array

# Rounds of one number after the other, where two are fitted.
ROUNDS = 2
# A descent is begun anew where it left less than half of what it began with, and no more often than this.
MOST_DESCENTS, ENOUGH_GAINED = 4, 0.7
# To so much of itself a value that was sought is right.
SOUGHT = 1e-4


class Fitter:
    """Finds values with which mistakes leave least."""

    def __init__(self, flights: Flights) -> None:
        self._flights = flights

    def tuned(self, hypotheses: Sequence[Hypothesis]) -> Mistakes:
        """Return hypotheses with the best of the values tried first, then fitted one by one."""
        return self.polished(min(self.values_of(hypotheses), key=self._flights.glanced))

    def values_of(self, hypotheses: Sequence[Hypothesis]) -> Iterator[Mistakes]:
        """Yield hypotheses with all combinations of the values tried first."""
        if not hypotheses:
            yield ()
            return
        first, *rest = hypotheses
        for others in self.values_of(rest):
            for value in first.values or (0.0,):
                yield (Mistake(first, value), *others)

    def best_of(self, mistakes: Mistakes, hypothesis: Hypothesis, values: Iterable[float]) -> Mistakes:
        """Return mistakes with one of them at the best of some values, at a glance."""
        return min((with_value(mistakes, hypothesis, value) for value in values), key=self._flights.glanced)

    def polished(self, mistakes: Mistakes) -> Mistakes:
        """Return mistakes with each fitted number in turn at its best between the values tried beside it."""
        fitted = [mistake.hypothesis for mistake in mistakes if mistake.hypothesis.fitted]
        for _ in range(ROUNDS if len(fitted) > 1 else 1):
            for hypothesis in fitted:
                mistakes = self.polished_one(mistakes, hypothesis)
        return mistakes

    def polished_one(self, mistakes: Mistakes, hypothesis: Hypothesis) -> Mistakes:
        """Return mistakes with one of them, if its number is fitted, at its best beside the value that it has."""
        if not hypothesis.fitted:
            return mistakes
        if hypothesis.sought is not None:
            sought = self._sought(mistakes, hypothesis, self._flights.glance)
            return self.best_of(mistakes, hypothesis, (value_of(mistakes, hypothesis), sought, *hypothesis.known))
        value = value_of(mistakes, hypothesis)
        low, high = _beside(value, hypothesis)

        def left(tried: float) -> float:
            return self._flights.glanced(with_value(mistakes, hypothesis, tried))

        from scipy.optimize import minimize_scalar  # a third of a second that only a search pays

        options = {"xatol": 1e-2 * (high - low), "maxiter": 10}
        with np.errstate(all="ignore"):
            found = minimize_scalar(left, bounds=(low, high), method="bounded", options=options)
        return with_value(mistakes, hypothesis, float(found.x)) if found.fun < left(value) else mistakes

    def fit(self, mistakes: Mistakes, among: Sequence[Hypothesis] | None = None) -> Mistakes:
        """Return mistakes with all fitted numbers, or those among some hypotheses, at their best over all rows."""
        fitted = [h for h in ([m.hypothesis for m in mistakes] if among is None else among) if h.fitted]
        for hypothesis in fitted:
            if hypothesis.sought is not None:
                sought = self._sought(mistakes, hypothesis, self._flights.kept)
                mistakes = min(mistakes, with_value(mistakes, hypothesis, sought), key=self._flights.left)
        return self.descended(mistakes, fitted) if fitted else mistakes

    def named(self, mistakes: Mistakes) -> Mistakes:
        """Return mistakes with every fitted value at the nearest that has a name, or the better of the nearest two."""
        for mistake in mistakes:
            names = mistake.hypothesis.known
            if not names or not mistake.hypothesis.fitted:
                continue
            nearest = sorted(names, key=lambda value: abs(value - mistake.value))
            rest = [each.hypothesis for each in mistakes if each.hypothesis is not mistake.hypothesis]
            # A value that was sought is off by much where the rest is off by little.
            tried = nearest[: 2 if mistake.hypothesis.sought is not None and rest else 1]
            fits = [self.fit(with_value(mistakes, mistake.hypothesis, value), rest) for value in tried]
            mistakes = min(fits, key=self._flights.left)
        return mistakes

    def descended(self, mistakes: Mistakes, fitted: Sequence[Hypothesis], fineness: float = SEARCHING) -> Mistakes:
        """Return mistakes with numbers at their joint best."""
        at = np.array([value_of(mistakes, hypothesis) for hypothesis in fitted])
        unit = np.array([_unit(value, hypothesis) for value, hypothesis in zip(at, fitted, strict=True)])

        def tried(steps: Array) -> Mistakes:
            changed = mistakes
            for hypothesis, value in zip(fitted, at + unit * steps, strict=True):
                changed = with_value(changed, hypothesis, float(np.clip(value, *hypothesis.bounds)))
            return changed

        def left(steps: Array) -> float:
            return self._flights.left(tried(steps), fineness)

        from scipy.optimize import minimize

        options = {"xatol": 1e-7, "fatol": 1e-9, "maxfev": 60 * len(fitted)}
        least, steps = self._flights.left(mistakes, fineness), np.zeros(len(at))
        for _ in range(MOST_DESCENTS):
            with np.errstate(all="ignore"):
                found = minimize(left, steps, method="Nelder-Mead", options=options)
            if not found.fun < least:
                break
            gained, least, steps = least - found.fun, found.fun, found.x
            if gained <= ENOUGH_GAINED:
                break
        return tried(steps) if steps.any() else mistakes

    def _sought(self, mistakes: Mistakes, hypothesis: Hypothesis, rows: Kept) -> float:
        """Return the value of a hypothesis about the clock that rows speak for, as the other mistakes fly them."""
        assert hypothesis.sought is not None
        others = self._flights.changed([mistake for mistake in mistakes if mistake.hypothesis is not hypothesis])
        return hypothesis.sought(others.clock.reached(rows.times), self._flights.reached(others, rows))


def _beside(value: float, hypothesis: Hypothesis) -> tuple[float, float]:
    """Return the values beside one that a hypothesis tries first, or the value itself at an end."""
    tried = hypothesis.values
    return max((v for v in tried if v < value), default=value), min((v for v in tried if v > value), default=value)


def _unit(value: float, hypothesis: Hypothesis) -> float:
    """Return how far from a value others are tried first: hardly, where the flight jumps and the value was sought."""
    if hypothesis.sought is not None:
        return SOUGHT * value
    low, high = _beside(value, hypothesis)
    return 0.1 * (high - low)
