"""Fits the values of mistakes together, by the method of Levenberg and Marquardt, to the rows of a search."""

from collections.abc import Sequence

import numpy as np

from tumble.compare.grade.hypotheses.explanation import Mistakes, value_of, with_value
from tumble.compare.grade.hypotheses.hypothesis import Hypothesis
from tumble.compare.grade.search.shells import finite
from tumble.compare.grade.search.simulations import Simulations
from tumble.scenarios.frames import Array

# Steps of a fit, and what the last one must gain for another.
STEPS, GAIN = 8, 0.5
# Step of a difference quotient, over the first step of a value.
DIFFERENCE = 1e-3
# First step from a value outside of those that are tried first, over their range.
OUTSIDE = 0.02
# How much of the diagonal is added to the normal equations: all are tried at once.
DAMPED = np.array((1e-9, 1e-2, 1.0))
# A translation whose start, acceleration and impulses are still free costs as much, and in addition a share of what it
# would cost with the right ones.
FREE, SHARE = 60.0, 0.02
# Steps of ticks by which a time that takes effect at ticks is tried.
TICKS = (-4, -2, -1, 1, 2, 4)


class Fit:
    """Fits values of mistakes to the rows of `simulations`; is_free: with a free translation."""

    def __init__(self, simulations: Simulations) -> None:
        self._simulations = simulations
        self.is_free = False

    def fitted(self, mistakes: Mistakes, steps: int = STEPS) -> tuple[Mistakes, float, float]:
        """Return mistakes with their fitted values at the minimum, and their weight and score there."""
        free = free_values(mistakes)
        weights, scores = self.scored(self._simulations.errors([mistakes]))
        weight, score = float(weights[0]), float(scores[0])
        for _ in range(steps if free else 0):
            tried = self._tried(mistakes, free)
            weights, scores = self.scored(self._simulations.errors(tried))
            best = int(np.argmin(scores))
            gained = score - float(scores[best])
            if gained > 0:
                mistakes, weight, score = tried[best], float(weights[best]), float(scores[best])
            if not gained > GAIN:
                break
        return mistakes, weight, score

    def scored(self, errors: Array) -> tuple[Array, Array]:
        """Return the weights of residuals, (V, T, K, 3), and their scores, which are the weights unless `is_free`.

        With a free translation, the score is the weight with that, and a little of what the right one would leave.
        """
        shells = self._simulations.shells
        if not self.is_free:
            weights = shells.weights(errors)
            return weights, weights
        weights, free = shells.weights_and_free(errors)
        return weights, free + np.minimum(weights - free, FREE + SHARE * (weights - free))

    def directions(self, mistakes: Mistakes, free: Sequence[Hypothesis], errors: Array) -> Array:
        """Return the derivatives of residuals by the first steps of values, (P, T, K, 3); errors: (T, K, 3)."""
        units = _units(mistakes, free)
        at = _packed(mistakes, free)
        moved = [_with_values(mistakes, free, at + DIFFERENCE * units * one) for one in np.eye(len(at))]
        with np.errstate(all="ignore"):
            return finite((self._simulations.errors(moved) - errors) / DIFFERENCE)

    def directions_of(self, wanted: Sequence[tuple[Mistakes, Hypothesis]], errors: Array) -> list[Array]:
        """Return the derivatives of residuals by the value of a hypothesis in each of some mistakes.

        All of these leave the same residuals, (T, K, 3).
        """
        moved = [
            _with_values(mistakes, [hypothesis], _packed(mistakes, [hypothesis]) + DIFFERENCE * step)
            for mistakes, hypothesis in wanted
            for step in np.diag(_units(mistakes, [hypothesis]))
        ]
        if not moved:
            return []
        with np.errstate(all="ignore"):
            every = finite((self._simulations.errors(moved) - errors) / DIFFERENCE)
        return np.split(every, np.cumsum([hypothesis.dimension for _, hypothesis in wanted])[:-1])

    def moved(self, mistakes: Mistakes, free: Sequence[Hypothesis], steps: Array) -> Mistakes:
        """Return mistakes with some values moved by multiples of their first steps."""
        return _with_values(mistakes, free, _packed(mistakes, free) + _units(mistakes, free) * steps)

    def _tried(self, mistakes: Mistakes, free: list[Hypothesis]) -> list[Mistakes]:
        """Return mistakes with better values, if the residuals depend on them linearly."""
        errors = self._simulations.errors([mistakes])[0]
        steps = self.solutions(self.directions(mistakes, free, errors), errors)
        at, units = _packed(mistakes, free), _units(mistakes, free)
        tried = [_with_values(mistakes, free, at + units * step) for step in steps]
        return tried + _other_ticks(mistakes, self._simulations)

    def solutions(self, slopes: Array, errors: Array) -> list[Array]:
        """Return the steps that make residuals least, with more and more damping; (P, T, K, 3), (T, K, 3)."""
        with np.errstate(all="ignore"):
            every = self._weighted(finite(np.concatenate((slopes, errors[None]))))
            normal, gradient = every[:-1] @ every[:-1].T, every[:-1] @ every[-1]
        size = np.diag(normal).copy()
        size[size == 0] = 1.0
        damped = normal + DAMPED[:, None, None] * np.diag(size)
        try:
            return list(-np.linalg.solve(damped, gradient[:, None])[:, :, 0])
        except np.linalg.LinAlgError:
            return []

    def _weighted(self, every: Array) -> Array:
        """Return derivatives and at last residuals, (P + 1, T, K, 3), as precise as rows are, as `scored` does.

        A free translation leaves nothing of some derivatives, but of those with the right one.
        """
        shells, parts = self._simulations.shells, [(1.0, every)]
        if self.is_free:
            parts = [(1.0, shells.without_translation(every, every[-1])), (SHARE, every)]
        found = [np.sqrt(share) * shells.weighted(part, part[-1:]) for share, part in parts]
        return np.concatenate(found, axis=1).reshape(len(every), -1)


def free_values(mistakes: Mistakes) -> list[Hypothesis]:
    """Return the hypotheses whose values are fitted: not those of steps, which divide a row interval."""
    return [m.hypothesis for m in mistakes if m.hypothesis.fitted and m.hypothesis.part != "steps"]


def _other_ticks(mistakes: Mistakes, simulations: Simulations) -> list[Mistakes]:
    """Return mistakes with times some ticks earlier and later, of a program in steps."""
    timed = [m for m in mistakes if m.hypothesis.at_ticks]
    if not timed or not (tick := simulations.event_tick(mistakes)):
        return []
    found = []
    for mistake in timed:
        least, most = mistake.hypothesis.bounds
        for ticks in TICKS:
            value = tick * round(mistake.value / tick + ticks)
            if least <= value <= most:
                found.append(with_value(mistakes, mistake.hypothesis, value))
    return found


def _packed(mistakes: Mistakes, free: Sequence[Hypothesis]) -> Array:
    return np.concatenate([np.atleast_1d(value_of(mistakes, hypothesis)) for hypothesis in free])


def _units(mistakes: Mistakes, free: Sequence[Hypothesis]) -> Array:
    return np.concatenate([np.full(h.dimension, first_step(value_of(mistakes, h), h)) for h in free])


def _with_values(mistakes: Mistakes, free: Sequence[Hypothesis], values: Array) -> Mistakes:
    place = 0
    for hypothesis in free:
        if hypothesis.scale:
            mistakes = with_value(mistakes, hypothesis, tuple(values[place : place + hypothesis.dimension].tolist()))
        else:
            mistakes = with_value(mistakes, hypothesis, float(np.clip(values[place], *hypothesis.bounds)))
        place += hypothesis.dimension
    return mistakes


def first_step(value: float, hypothesis: Hypothesis) -> float:
    """Return the first step of a fit from a value: a tenth of the distance of its neighbours."""
    if hypothesis.scale:
        return 0.1 * hypothesis.scale
    tried = hypothesis.values
    if not min(tried) <= value <= max(tried):
        return OUTSIDE * (max(tried) - min(tried))
    low = max((v for v in tried if v < value), default=value)
    high = min((v for v in tried if v > value), default=value)
    return 0.1 * (high - low)
