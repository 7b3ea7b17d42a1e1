"""Fits the values of mistakes: one by one in quick looks, then jointly over the fitted rows."""

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from tumble.compare.grade.hypotheses.explanation import Mistake, Mistakes, value_of, with_value
from tumble.compare.grade.hypotheses.hypothesis import Hypothesis
from tumble.compare.grade.measure.errors import SampledRows
from tumble.compare.grade.model.program_model import SEARCHING
from tumble.compare.grade.search.evaluator import Evaluator
from tumble.scenarios.frames import Array

# Rounds of fitting one value after the other, if there are two.
ROUNDS = 2
# Of a joint fit: the difference quotient's step, over a first step; trials for each value; and the relative change of
# the residual at which it ends.
DIFFERENCE, MOST_TRIALS, CONVERGED = 1e-2, 30, 1e-6
# Relative accuracy of an estimated value.
ESTIMATED = 1e-4


class Fitter:
    """Finds the values with which mistakes leave least."""

    def __init__(self, evaluator: Evaluator) -> None:
        self._evaluator, self.quick_weight = evaluator, evaluator.quick_weight

    def tuned(self, hypotheses: Sequence[Hypothesis]) -> Mistakes:
        """Return hypotheses with the best of their first values, then refined one by one."""
        return self.refined(min(self.values_of(hypotheses), key=self._evaluator.quick_weight))

    def values_of(self, hypotheses: Sequence[Hypothesis]) -> Iterator[Mistakes]:
        """Yield hypotheses with all combinations of their first values."""
        if not hypotheses:
            yield ()
            return
        first, *rest = hypotheses
        for others in self.values_of(rest):
            for value in first.values or (0.0,):
                yield (Mistake(first, value), *others)

    def best_of(self, mistakes: Mistakes, hypothesis: Hypothesis, values: Iterable[float]) -> Mistakes:
        """Return mistakes with one of them at the best of some values, in a quick look."""
        return min((with_value(mistakes, hypothesis, value) for value in values), key=self._evaluator.quick_weight)

    def refined(self, mistakes: Mistakes) -> Mistakes:
        """Return mistakes with each fitted value refined between its neighbouring first values, one after the other."""
        fitted = [mistake.hypothesis for mistake in mistakes if mistake.hypothesis.fitted]
        for _ in range(ROUNDS if len(fitted) > 1 else 1):
            for hypothesis in fitted:
                mistakes = self.refined_one(mistakes, hypothesis)
        return mistakes

    def refined_one(self, mistakes: Mistakes, hypothesis: Hypothesis) -> Mistakes:
        """Return mistakes with the value of one hypothesis refined, if it is fitted."""
        if not hypothesis.fitted:
            return mistakes
        value = value_of(mistakes, hypothesis)
        if hypothesis.estimator is not None:
            estimate = self._estimate(mistakes, hypothesis, self._evaluator.quick_rows)
            return self.best_of(mistakes, hypothesis, (value, estimate, *hypothesis.named_values))
        low, high = _neighbours(value, hypothesis)

        def weight(tried: float) -> float:
            return self._evaluator.quick_weight(with_value(mistakes, hypothesis, tried))

        from scipy.optimize import minimize_scalar  # a third of a second, which only a search pays

        options = {"xatol": 1e-2 * (high - low), "maxiter": 10}
        with np.errstate(all="ignore"):
            found = minimize_scalar(weight, bounds=(low, high), method="bounded", options=options)
        return with_value(mistakes, hypothesis, float(found.x)) if found.fun < weight(value) else mistakes

    def fit(self, mistakes: Mistakes, among: Sequence[Hypothesis] | None = None) -> Mistakes:
        """Return mistakes with all fitted values, or only those of some hypotheses, fitted jointly."""
        fitted = [h for h in ([m.hypothesis for m in mistakes] if among is None else among) if h.fitted]
        for hypothesis in fitted:
            if hypothesis.estimator is not None:
                estimate = self._estimate(mistakes, hypothesis, self._evaluator.fitted_rows)
                other = with_value(mistakes, hypothesis, estimate)
                mistakes = min(mistakes, other, key=self._evaluator.log_residual)
        return self.descended(mistakes, fitted) if fitted else mistakes

    def snapped(self, mistakes: Mistakes) -> Mistakes:
        """Return mistakes with every fitted value moved to the nearest named one, or the better of the nearest two."""
        for mistake in mistakes:
            named = mistake.hypothesis.named_values
            if not named or not mistake.hypothesis.fitted:
                continue
            nearest = sorted(named, key=lambda value: abs(value - mistake.value))
            rest = [each.hypothesis for each in mistakes if each.hypothesis is not mistake.hypothesis]
            # An estimated value is far off if the other values are a little off.
            tried = nearest[: 2 if mistake.hypothesis.estimator is not None and rest else 1]
            fits = [self.fit(with_value(mistakes, mistake.hypothesis, value), rest) for value in tried]
            mistakes = min(fits, key=self._evaluator.log_residual)
        return mistakes

    def descended(self, mistakes: Mistakes, fitted: Sequence[Hypothesis], fineness: float = SEARCHING) -> Mistakes:
        """Return mistakes with fitted values at their joint minimum, by the method of Levenberg and Marquardt."""
        at = np.array([value_of(mistakes, hypothesis) for hypothesis in fitted])
        unit = np.array([_first_step(value, hypothesis) for value, hypothesis in zip(at, fitted, strict=True)])

        def tried(steps: Array) -> Mistakes:
            changed = mistakes
            for hypothesis, value in zip(fitted, at + unit * steps, strict=True):
                changed = with_value(changed, hypothesis, float(np.clip(value, *hypothesis.bounds)))
            return changed

        def residuals(shifted: Array) -> Array:
            return self._evaluator.residuals(tried(shifted - 1.0), fineness)

        from scipy.optimize import least_squares

        with np.errstate(all="ignore"):
            # Values are shifted by 1, since the difference quotient's step is relative.
            found = least_squares(
                residuals,
                np.ones(len(at)),
                method="lm",
                diff_step=DIFFERENCE,
                ftol=CONVERGED,
                xtol=CONVERGED,
                max_nfev=MOST_TRIALS * len(fitted),
            )
        best = tried(found.x - 1.0)
        return min(mistakes, best, key=lambda each: self._evaluator.log_residual(each, fineness))

    def _estimate(self, mistakes: Mistakes, hypothesis: Hypothesis, rows: SampledRows) -> float:
        """Return the value of a hypothesis about the clock, estimated from a run with the other mistakes."""
        assert hypothesis.estimator is not None
        others = [mistake for mistake in mistakes if mistake.hypothesis is not hypothesis]
        program = self._evaluator.program_with(others)
        logged_s = program.clock.physics_times(rows.times)
        return hypothesis.estimator(logged_s, self._evaluator.nearest_times(program, rows))


def _neighbours(value: float, hypothesis: Hypothesis) -> tuple[float, float]:
    """Return the first values of a hypothesis next to a value, or the value itself at an end."""
    tried = hypothesis.values
    return max((v for v in tried if v < value), default=value), min((v for v in tried if v > value), default=value)


def _first_step(value: float, hypothesis: Hypothesis) -> float:
    """Return the first step of a descent from a value: small if the run jumps with it, since it was estimated."""
    if hypothesis.estimator is not None:
        return ESTIMATED * value
    low, high = _neighbours(value, hypothesis)
    return 0.1 * (high - low)
