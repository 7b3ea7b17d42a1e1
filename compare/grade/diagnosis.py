"""Tries every mistake against a trajectory, alone, in pairs and one by one on top, and ranks what it finds."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, groupby
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize, minimize_scalar

from compare.grade.account import FINE, SEARCHING, Account, Pose
from compare.grade.hypotheses import Hypothesis, Question
from compare.grade.mistakes.writings import WRITTEN
from compare.grade.noise import ALIKE, EXPLAINED, Scale, chosen, is_noise, relation, root_mean_square
from compare.grade.residual import Kept
from scenarios.frames import Array

# Rows that a first look takes, of those kept; pairs that are looked at again, and explanations that are fitted finely.
GLANCE = 24
AGAIN = 24
FINALISTS = 6
# Single mistakes upon which all others are tried with care.
STARTS = 3
MOST_MISTAKES = 4
# An error below this share of the body's size is of one mistake, if of any.
SMALL = 1e-6
# Rounds of one number after the other, where two are fitted.
ROUNDS = 2
# Two numbers are tried on a grid of no more points than this, otherwise each where the other alone is best.
GRID = 100
# A mistake must take away this share of what is left: a systematic rest is no noise, and any number takes away some.
LEAST_HELP = 0.1
# Values tried beside the best of a number in which the flight jumps, of a pair that is looked at again and of one that
# is fitted finely, and how much nearer to one another in the end.
MOST_TRIED, MOST_FITTED, OFF = 100, 1000, 2.2
CLOSER = (1.0, 0.05, 0.0025)


class Mistake(NamedTuple):
    """A hypothesis with its value."""

    hypothesis: Hypothesis
    value: float = 0.0

    @property
    def said(self) -> str:
        """What it says."""
        return self.hypothesis.said(self.value)

    @property
    def is_known(self) -> bool:
        """Whether its value is one with a name."""
        return self.value in self.hypothesis.known


Mistakes = tuple[Mistake, ...]


@dataclass(frozen=True, eq=False)
class Explanation:
    """Mistakes that together make a trajectory, and what they leave of it.

    rms_m, max_m: of the vertices at the rows kept [m]; weight: less is better; errors [m], (S, K, 3).
    """

    mistakes: Mistakes
    rms_m: float
    max_m: float
    weight: float
    errors: Array

    @property
    def names(self) -> frozenset[str]:
        """The names of its mistakes."""
        return frozenset(mistake.hypothesis.name for mistake in self.mistakes)

    def leaves_noise(self) -> bool:
        """Whether neighbouring rows of what it leaves have nothing to do with one another."""
        return is_noise(relation(self.errors), len(self.errors) - 1)


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """What was found: the explanation by nothing, the best, those that fit alike, and how the best comes about.

    steps: explanations from nothing to the best, each with one mistake more, the most telling first.
    """

    nothing: Explanation
    best: Explanation
    alike: tuple[Explanation, ...]
    steps: tuple[Explanation, ...]
    tried: int
    account: Account


class Search:
    """Explanations of one throw.

    kept: its rows; points: the vertices that they show [m], (K, 3); hypotheses: in the order in which a program makes
    them.
    """

    def __init__(
        self, question: Question, hypotheses: Sequence[Hypothesis], kept: Kept, points: Array, scale: Scale
    ) -> None:
        self._account, self._hypotheses, self._kept, self._points = question.account, list(hypotheses), kept, points
        self._scale = scale
        self._place = {hypothesis: number for number, hypothesis in enumerate(hypotheses)}
        rows = np.unique(np.linspace(0, len(kept) - 1, GLANCE).round().astype(int))
        self._glance = kept.some(rows)
        self._size = float(np.abs(question.scene.body.points).max())
        self._flown: dict[tuple, Pose] = {}
        self.tried = 0

    def diagnose(self) -> Diagnosis:
        """Return what explains the rows best."""
        nothing = self.explain(())
        found = [nothing]
        if nothing.rms_m > EXPLAINED * self._scale.floor_m:
            found += self._explained(self._candidates())
            found += self._deeper(found)
        ranked = [each for each in sorted(found, key=_by_weight) if not _padded(each, found)]
        best = ranked[0]
        alike = [
            each
            for each in ranked[1:]
            if each.weight < best.weight + ALIKE and not each.names > best.names and each.names != best.names
        ]
        account = self._changed(best.mistakes)
        return Diagnosis(nothing, best, tuple(_distinct(alike)), tuple(self._steps(nothing, best)), self.tried, account)

    def explain(self, mistakes: Mistakes) -> Explanation:
        """Return what mistakes leave of all rows, flown finely."""
        errors = self._errors(self._changed(mistakes).written(self._kept.times, FINE), self._kept)
        rms_m = root_mean_square(errors)
        largest = float(np.linalg.norm(errors, axis=-1).max())
        return Explanation(mistakes, rms_m, largest, self._scale.weight(rms_m, self._cost(mistakes)), errors)

    def _candidates(self) -> list[Mistakes]:
        """Return what is worth a fine fit: the best mistakes alone, and in pairs unless one alone leaves nothing."""
        singles = sorted((self._tuned((h,)) for h in self._hypotheses), key=self._glanced)
        best = self.explain(singles[0])
        finalists = singles[:FINALISTS]
        if best.rms_m <= EXPLAINED * self._scale.floor_m:
            return finalists
        on_top = self._on_top(singles[0])
        helps = on_top and self._glanced(on_top[0]) < self._glanced(singles[0]) - ALIKE
        if (best.leaves_noise() and not helps) or self.explain(()).rms_m < SMALL * self._size:
            return finalists
        pairs = self._pairs({single[0].hypothesis: single[0].value for single in singles})
        second = [pair for single in singles[1:STARTS] for pair in self._on_top(single)]
        return [*finalists, *pairs, *sorted((*on_top, *second), key=self._glanced)[:FINALISTS]]

    def _pairs(self, alone: dict[Hypothesis, float]) -> list[Mistakes]:
        """Return the best pairs.  alone: what each hypothesis was fitted to by itself."""
        flown = [h for h in self._hypotheses if h.part not in WRITTEN]
        written = [h for h in self._hypotheses if h.part in WRITTEN]
        rough = [self._rough_pair(*pair, alone) for pair in combinations(flown, 2) if pair[0].part != pair[1].part]
        rough += [self._rough_pair(*pair, alone) for pair in combinations(written, 2) if pair[0].part != pair[1].part]
        rough += self._written_pairs(flown, written)
        rough.sort(key=self._glanced)
        again = sorted((self._polished(pair) for pair in rough[:AGAIN]), key=self._glanced)
        return again[:FINALISTS]

    def _written_pairs(self, flown: Sequence[Hypothesis], written: Sequence[Hypothesis]) -> Iterator[Mistakes]:
        """Yield, of each hypothesis of flying and each of writing, the pair with the best values.

        All flights are written down at once: a flight is the same however it is written.
        """
        flights = [each for hypothesis in flown for each in self._values_of((hypothesis,))]
        poses = [self._pose(flight) for flight in flights]
        stack = Pose(*(np.concatenate([pose[part] for pose in poses]) for part in range(4)))
        costs = np.array([self._cost(flight) for flight in flights])
        for hypothesis in written:
            weights = np.array(
                [
                    self._weights(self._written(stack, (each,))) + self._cost((each,))
                    for (each,) in self._values_of((hypothesis,))
                ]
            )
            self.tried += weights.size
            weights += costs
            for _, group in groupby(range(len(flights)), lambda number: flights[number][0].hypothesis):
                own = list(group)
                value, number = np.unravel_index(int(np.argmin(weights[:, own])), (len(weights), len(own)))
                best = Mistake(hypothesis, (hypothesis.values or (0.0,))[value])
                yield self._ordered((*flights[own[int(number)]], best))

    def _weights(self, stack: Pose) -> Array:
        """Return the weights, without what is assumed, of flights one after the other, (n,)."""
        rows = len(self._glance)
        with np.errstate(all="ignore"):
            places = (stack.axes @ self._points.T + stack.x[:, :, None]).reshape(-1, rows, 3, len(self._points))
            apart = places - np.swapaxes(self._glance.vertices, 1, 2)
            rms_m = np.sqrt(np.einsum("nrik,nrik->n", apart, apart) / (rows * len(self._points)))
        return np.where(np.isfinite(rms_m), self._scale.weights(rms_m), np.inf)

    def _rough_pair(self, one: Hypothesis, other: Hypothesis, alone: dict[Hypothesis, float]) -> Mistakes:
        few = max(len(one.values), 1) * max(len(other.values), 1) <= GRID
        if few or not (one.fitted and other.fitted):
            return min(self._values_of((one, other)), key=self._glanced)
        starts = []
        for first, second in ((one, other), (other, one)):
            start = self._ordered((Mistake(first, alone[first]), Mistake(second)))
            starts.append(self._best_of(start, second, second.values))
        return min(starts, key=self._glanced)

    def _values_of(self, hypotheses: Sequence[Hypothesis]) -> Iterator[Mistakes]:
        """Yield hypotheses with all combinations of the values tried first."""
        if not hypotheses:
            yield ()
            return
        first, *rest = hypotheses
        for others in self._values_of(rest):
            for value in first.values or (0.0,):
                yield (Mistake(first, value), *others)

    def _on_top(self, mistakes: Mistakes) -> list[Mistakes]:
        """Return the mistakes with each of those that help them most."""
        parts = {mistake.hypothesis.part for mistake in mistakes}
        more = (h for h in self._hypotheses if h.part not in parts)
        found = [
            min((self._ordered((*mistakes, Mistake(h, v))) for v in h.values or (0.0,)), key=self._glanced)
            for h in more
        ]
        # Polished, all of them: a small second mistake may lie between two values tried first that only harm.
        return sorted((self._polished_one(each, _added(each, mistakes)) for each in found), key=self._glanced)[
            :FINALISTS
        ]

    def _deeper(self, found: Sequence[Explanation]) -> list[Explanation]:
        """Return explanations with more mistakes than those found, as long as one more is well worth it."""
        deeper: list[Explanation] = []
        starts = sorted(found, key=_by_weight)[:STARTS]
        while not self._is_enough(starts[0]):
            candidates = [more for start in starts if start.mistakes for more in self._on_top(start.mistakes)]
            more = self._explained(sorted(candidates, key=self._glanced)[:FINALISTS])
            deeper += more
            if not more or min(map(_by_weight, more)) > starts[0].weight - ALIKE:
                break
            starts = sorted(more, key=_by_weight)[:STARTS]
        return deeper

    def _is_enough(self, best: Explanation) -> bool:
        """Whether nothing is left to explain, or too much has been assumed already."""
        nothing_left = best.rms_m <= EXPLAINED * self._scale.floor_m or best.leaves_noise()
        return nothing_left or not best.mistakes or len(best.mistakes) >= MOST_MISTAKES

    def _explained(self, candidates: Iterable[Mistakes]) -> list[Explanation]:
        """Return candidates fitted finely, each as well with values that have a name."""
        fitted = list(map(self._fit, candidates))
        return [self.explain(each) for each in dict.fromkeys((*fitted, *map(self._named, fitted)))]

    # --- fitting ------------------------------------------------------------------------------------------------------

    def _tuned(self, hypotheses: Sequence[Hypothesis]) -> Mistakes:
        """Return hypotheses with the best of the values tried first, then fitted one by one."""
        return self._polished(min(self._values_of(hypotheses), key=self._glanced))

    def _polished(self, mistakes: Mistakes) -> Mistakes:
        """Return mistakes with each fitted number in turn at its best between the values tried beside it."""
        fitted = [mistake.hypothesis for mistake in mistakes if mistake.hypothesis.fitted]
        for _ in range(ROUNDS if len(fitted) > 1 else 1):
            for hypothesis in fitted:
                mistakes = self._polished_one(mistakes, hypothesis)
        return mistakes

    def _polished_one(self, mistakes: Mistakes, hypothesis: Hypothesis) -> Mistakes:
        if not hypothesis.fitted:
            return mistakes
        mistakes = self._best_of(mistakes, hypothesis, (_value(mistakes, hypothesis), *hypothesis.known))
        value = _value(mistakes, hypothesis)
        low, high = _beside(value, sorted({*hypothesis.values, *hypothesis.known}))

        def left(tried: float) -> float:
            return self._glanced(_with(mistakes, hypothesis, tried))

        if hypothesis.spacing is not None:
            count = int(np.clip((high - low) / hypothesis.spacing(value), 8, MOST_TRIED))
            return self._best_of(mistakes, hypothesis, (value, *np.linspace(low, high, count).tolist()))
        options = {"xatol": 1e-3 * (high - low), "maxiter": 16}
        with np.errstate(all="ignore"):
            found = minimize_scalar(left, bounds=(low, high), method="bounded", options=options)
        return _with(mistakes, hypothesis, float(found.x)) if found.fun < left(value) else mistakes

    def _fit(self, mistakes: Mistakes, among: Sequence[Hypothesis] | None = None) -> Mistakes:
        """Return mistakes with all fitted numbers, or those among some hypotheses, at their best over all rows."""
        chosen_ones = [m.hypothesis for m in mistakes] if among is None else among
        fitted = [hypothesis for hypothesis in chosen_ones if hypothesis.fitted]
        jumping = [hypothesis for hypothesis in fitted if hypothesis.spacing is not None]
        smooth = [hypothesis for hypothesis in fitted if hypothesis.spacing is None]
        for _ in range(ROUNDS if jumping and smooth else 1):
            for hypothesis in jumping:
                mistakes = self._closed_in(mistakes, hypothesis)
            if smooth:
                mistakes = self._descended(mistakes, smooth)
        return mistakes

    def _closed_in(self, mistakes: Mistakes, hypothesis: Hypothesis) -> Mistakes:
        """Return mistakes with a number in which the flight jumps at its best, tried ever nearer to one another."""
        assert hypothesis.spacing is not None
        value = _value(mistakes, hypothesis)
        # Far from the right value all are alike but for their mean, so that the first look may have been well off; near
        # it most rows fit and some are a whole jump off, which a median sees from further away than a mean square.
        low, high = value / OFF, value * OFF
        count = int(np.clip((high - low) / hypothesis.spacing(value), 8, MOST_FITTED))
        tried = (_with(mistakes, hypothesis, v) for v in (value, *np.linspace(low, high, count).tolist()))
        mistakes = min(tried, key=self._median)
        for closer in CLOSER:
            value = _value(mistakes, hypothesis)
            reach = 2 * closer * hypothesis.spacing(value)
            tried = (_with(mistakes, hypothesis, v) for v in (value, *np.linspace(value - reach, value + reach, 41)))
            mistakes = min(tried, key=self._left)
        return mistakes

    def _descended(self, mistakes: Mistakes, smooth: Sequence[Hypothesis]) -> Mistakes:
        """Return mistakes with numbers at their joint best."""
        at = np.array([_value(mistakes, hypothesis) for hypothesis in smooth])
        besides = [_beside(value, sorted(h.values)) for value, h in zip(at, smooth, strict=True)]
        unit = np.array([0.1 * (high - low) for low, high in besides])

        def tried(steps: Array) -> Mistakes:
            changed = mistakes
            for hypothesis, value in zip(smooth, at + unit * steps, strict=True):
                changed = _with(changed, hypothesis, float(value))
            return changed

        options = {"xatol": 1e-7, "fatol": 1e-9, "maxfev": 60 * len(smooth)}
        with np.errstate(all="ignore"):
            found = minimize(
                lambda steps: self._left(tried(steps)), np.zeros(len(at)), method="Nelder-Mead", options=options
            )
        return tried(found.x) if found.fun < self._left(mistakes) else mistakes

    def _left(self, mistakes: Mistakes) -> float:
        """Return the logarithm of what mistakes leave of all rows, roughly flown."""
        with np.errstate(all="ignore"):
            left = float(np.log(root_mean_square(self._roughly(mistakes)) + 1e-3 * self._scale.floor_m))
        return left if np.isfinite(left) else np.inf

    def _median(self, mistakes: Mistakes) -> float:
        """Return what mistakes leave of the middle one of all rows [m^2], roughly flown."""
        with np.errstate(all="ignore"):
            left = float(np.median((self._roughly(mistakes) ** 2).sum(axis=(1, 2))))
        return left if np.isfinite(left) else np.inf

    def _roughly(self, mistakes: Mistakes) -> Array:
        self.tried += 1
        return self._errors(self._changed(mistakes).written(self._kept.times, SEARCHING), self._kept)

    def _named(self, mistakes: Mistakes) -> Mistakes:
        """Return mistakes with every fitted value at the nearest one that has a name."""
        for mistake in mistakes:
            names = mistake.hypothesis.known
            if not names or not mistake.hypothesis.fitted:
                continue
            nearest = min(names, key=lambda value: abs(value - mistake.value))
            named = _with(mistakes, mistake.hypothesis, nearest)
            rest = [each.hypothesis for each in mistakes if each.hypothesis is not mistake.hypothesis]
            mistakes = self._fit(named, rest)
        return mistakes

    def _best_of(self, mistakes: Mistakes, hypothesis: Hypothesis, values: Iterable[float]) -> Mistakes:
        return min((_with(mistakes, hypothesis, value) for value in values), key=self._glanced)

    # --- what mistakes leave ------------------------------------------------------------------------------------------

    def _glanced(self, mistakes: Mistakes) -> float:
        """Return the weight of mistakes by a first look."""
        self.tried += 1
        flight = tuple(m for m in mistakes if m.hypothesis.part not in WRITTEN)
        pose = self._written(self._pose(flight), [m for m in mistakes if m.hypothesis.part in WRITTEN])
        return float(self._weights(pose)[0]) + self._cost(mistakes)

    def _pose(self, flight: Mistakes) -> Pose:
        """Return what a program with these mistakes writes down, flown once."""
        pose = self._flown.get(flight)
        if pose is None:
            pose = self._flown[flight] = self._changed(flight).written(self._glance.times, SEARCHING)
        return pose

    def _written(self, pose: Pose, mistakes: Sequence[Mistake]) -> Pose:
        """Return a pose as mistakes in writing leave it."""
        if not mistakes:
            return pose
        with np.errstate(all="ignore"):
            for writing in self._changed(mistakes).writings:
                pose = writing(pose)
        return pose

    def _errors(self, pose: Pose, kept: Kept) -> Array:
        with np.errstate(all="ignore"):
            return kept.vertices - np.swapaxes(pose.axes @ self._points.T + pose.x[:, :, None], 1, 2)

    def _changed(self, mistakes: Sequence[Mistake]) -> Account:
        account = self._account
        for mistake in mistakes:
            account = mistake.hypothesis.change(account, mistake.value)
        return account

    def _cost(self, mistakes: Sequence[Mistake]) -> float:
        cost = 0.0
        for mistake in mistakes:
            hypothesis = mistake.hypothesis
            cost += chosen(len(self._hypotheses))
            if hypothesis.choices:
                cost += chosen(len(hypothesis.choices))
            elif mistake.is_known:
                cost += chosen(len(hypothesis.known))
            elif hypothesis.fitted:
                cost += self._scale.fitted()
        return cost

    def _ordered(self, mistakes: Mistakes) -> Mistakes:
        return tuple(sorted(mistakes, key=lambda mistake: self._place[mistake.hypothesis]))

    def _steps(self, nothing: Explanation, best: Explanation) -> Iterator[Explanation]:
        """Yield explanations by ever more of the best one's mistakes, each time the one that leaves least."""
        yield nothing
        said: Mistakes = ()
        while len(said) < len(best.mistakes):
            more = (self._ordered((*said, m)) for m in best.mistakes if m not in said)
            step = min(map(self.explain, more), key=lambda each: each.rms_m)
            said = step.mistakes
            yield best if len(said) == len(best.mistakes) else step


def _with(mistakes: Mistakes, hypothesis: Hypothesis, value: float) -> Mistakes:
    return tuple(Mistake(m.hypothesis, value) if m.hypothesis is hypothesis else m for m in mistakes)


def _added(mistakes: Mistakes, to: Mistakes) -> Hypothesis:
    return next(mistake.hypothesis for mistake in mistakes if mistake not in to)


def _value(mistakes: Mistakes, hypothesis: Hypothesis) -> float:
    return next(mistake.value for mistake in mistakes if mistake.hypothesis is hypothesis)


def _beside(value: float, values: Sequence[float]) -> tuple[float, float]:
    """Return the values beside one, or as far beyond the last as the one before it."""
    below = [each for each in values if each < value]
    above = [each for each in values if each > value]
    low = below[-1] if below else value - (above[0] - value if above else abs(value))
    high = above[0] if above else value + (value - low)
    return (max(low, value / 3) if value > 0 else low), high


def _by_weight(explanation: Explanation) -> float:
    return explanation.weight


def _padded(explanation: Explanation, others: Iterable[Explanation]) -> bool:
    """Whether some of an explanation's mistakes do nearly as well without the rest."""
    enough = explanation.rms_m * (1 + LEAST_HELP)
    return any(other.names < explanation.names and other.rms_m <= enough for other in others)


def _distinct(explanations: Iterable[Explanation]) -> Iterator[Explanation]:
    """Yield the first of those that have the same names."""
    seen: set[frozenset[str]] = set()
    for each in explanations:
        if each.names not in seen:
            seen.add(each.names)
            yield each
