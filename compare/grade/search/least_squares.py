"""Fits the values of mistakes together, by the method of Levenberg and Marquardt, to the rows of a search."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from tumble.compare.grade.hypotheses.explanation import Mistake, Mistakes, value_of, with_value
from tumble.compare.grade.hypotheses.hypothesis import Hypothesis, Value
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


@dataclass(eq=False)
class Fitting:
    """Mistakes whose values are being fitted, and what they leave.

    errors: their residuals, (T, K, 3); weight, score: of these; is_done: no step gains anything any more.
    """

    mistakes: Mistakes
    errors: Array
    weight: float
    score: float
    free: list[Hypothesis] = field(init=False)
    is_done: bool = field(init=False)

    def __post_init__(self) -> None:
        self.free = free_values(self.mistakes)
        self.is_done = not self.free


class Fit:
    """Fits values of mistakes to the rows of `simulations`; is_free: with a free translation."""

    def __init__(self, simulations: Simulations) -> None:
        self._simulations = simulations
        self.is_free = False

    def fitted(self, mistakes: Mistakes) -> Fitting:
        """Return mistakes with their fitted values at the minimum."""
        return self.advanced(self.begun([mistakes]))[0]

    def begun(self, programs: Sequence[Mistakes]) -> list[Fitting]:
        """Return fits of the values of mistakes before their first step."""
        if not programs:
            return []
        errors = self._simulations.errors(programs)
        weights, scores = (each.tolist() for each in self.scored(errors))
        return [Fitting(*each) for each in zip(programs, errors, weights, scores, strict=True)]

    def advanced(self, fits: Sequence[Fitting], steps: int = STEPS) -> Sequence[Fitting]:
        """Return fits after so many steps, or as many as they need; all are simulated together, which is faster."""
        for _ in range(steps):
            if not (going := [fit for fit in fits if not fit.is_done]):
                break
            every = self._tried(going)
            errors = self._simulations.errors([mistakes for tried in every for mistakes in tried])
            weights, scores = self.scored(errors)
            begin = 0
            for fit, tried in zip(going, every, strict=True):
                best = begin + int(np.argmin(scores[begin : begin + len(tried)]))
                gained = fit.score - float(scores[best])
                if gained > 0:
                    fit.mistakes, fit.errors = tried[best - begin], errors[best]
                    fit.weight, fit.score = float(weights[best]), float(scores[best])
                fit.is_done = not gained > GAIN
                begin += len(tried)
        return fits

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

    def directions(self, mistakes: Mistakes, errors: Array) -> Array:
        """Return the derivatives of residuals, (T, K, 3), by the first steps of fitted values, (P, T, K, 3)."""
        return self._directions([Fitting(mistakes, errors, 0.0, 0.0)])[0]

    def _directions(self, fits: Sequence[Fitting]) -> list[Array]:
        """Return the derivatives of the residuals of each fit by the first steps of its values, (P, T, K, 3)."""
        moved, counts = list[Mistakes](), list[int]()
        for fit in fits:
            at, units = _packed(fit.mistakes, fit.free), DIFFERENCE * _units(fit.mistakes, fit.free)
            counts.append(len(at))
            moved += [_with_values(fit.mistakes, fit.free, at + units * one) for one in np.eye(len(at))]
        errors = self._simulations.errors(moved) if moved else np.empty((0, *fits[0].errors.shape))
        every = np.split(errors, np.cumsum(counts)[:-1])
        with np.errstate(all="ignore"):
            return [finite((own - fit.errors) / DIFFERENCE) for own, fit in zip(every, fits, strict=True)]

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

    def _tried(self, fits: Sequence[Fitting]) -> list[list[Mistakes]]:
        """Return the mistakes of each fit with better values, if the residuals depend on them linearly."""
        every = list[list[Mistakes]]()
        for fit, slopes in zip(fits, self._directions(fits), strict=True):
            at, units = _packed(fit.mistakes, fit.free), _units(fit.mistakes, fit.free)
            tried = [
                _with_values(fit.mistakes, fit.free, at + units * step) for step in self.solutions(slopes, fit.errors)
            ]
            every.append(tried + _other_ticks(fit.mistakes, self._simulations))
        return every

    def solutions(self, slopes: Array, errors: Array) -> list[Array]:
        """Return the steps that make residuals least, with more and more damping; (P, T, K, 3), (T, K, 3).

        No step, if none is known: derivatives may be as good as infinite.
        """
        with np.errstate(all="ignore"):
            every = self._weighted(finite(np.concatenate((slopes, errors[None]))))
            normal, gradient = every[:-1] @ every[:-1].T, every[:-1] @ every[-1]
        size = np.diag(normal).copy()
        size[size == 0] = 1.0
        damped = normal + DAMPED[:, None, None] * np.diag(size)
        try:
            steps = -np.linalg.solve(damped, gradient[:, None])[:, :, 0]
        except np.linalg.LinAlgError:
            steps = np.empty((0, len(slopes)))
        return [step for step in steps if np.isfinite(step).all()] or [np.zeros(len(slopes))]

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
    values = (value_of(mistakes, hypothesis) for hypothesis in free)
    return np.array([number for value in values for number in (value if isinstance(value, tuple) else (value,))])


def _units(mistakes: Mistakes, free: Sequence[Hypothesis]) -> Array:
    steps = ((first_step(value_of(mistakes, each), each), each.dimension) for each in free)
    return np.array([step for step, count in steps for _ in range(count)])


def _with_values(mistakes: Mistakes, free: Sequence[Hypothesis], values: Array) -> Mistakes:
    numbers, place, moved = values.tolist(), 0, dict[Hypothesis, Value]()
    for hypothesis in free:
        if hypothesis.scale:
            moved[hypothesis] = tuple(numbers[place : place + hypothesis.dimension])
        else:
            least, most = hypothesis.bounds
            moved[hypothesis] = min(max(numbers[place], least), most)
        place += hypothesis.dimension
    return tuple(Mistake(m.hypothesis, moved[m.hypothesis]) if m.hypothesis in moved else m for m in mistakes)


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
