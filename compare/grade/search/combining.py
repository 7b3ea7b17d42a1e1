"""Finds second mistakes: those that help a first one most, and pairs of two that help only together."""

from collections.abc import Iterable, Iterator, Sequence
from itertools import combinations, groupby

import numpy as np

from tumble.compare.grade.hypotheses.explanation import Mistake, Mistakes
from tumble.compare.grade.hypotheses.hypothesis import Hypothesis
from tumble.compare.grade.hypotheses.mistakes.output import OUTPUT_PARTS
from tumble.compare.grade.model.program_model import Pose
from tumble.compare.grade.search.evaluator import Evaluator
from tumble.compare.grade.search.fitting import Fitter

# Pairs that are refined, and candidates that are then fitted finely.
REFINED = 32
FINALISTS = 6
# Shares of ENOUGH steps after which no more pairs of usual mistakes, or of any, are looked at.
OF_USUAL, OF_PAIRS = 1 / 3, 0.6
# The best single mistakes to which every other is added.
FIRST_MISTAKES = 6
# Two fitted values are tried on a grid of at most this many points, otherwise each where the other alone is best.
GRID = 40


class Combiner:
    """Combines mistakes in different parts of a program."""

    def __init__(self, evaluator: Evaluator, fitter: Fitter) -> None:
        self._evaluator, self._fitter, self._quick_weight = evaluator, fitter, evaluator.quick_weight

    def with_one_more(self, mistakes: Mistakes) -> list[Mistakes]:
        """Return the mistakes together with each of those that help them most."""
        parts = {mistake.hypothesis.part for mistake in mistakes}
        found = []
        least = self._quick_weight(mistakes)
        for hypothesis in self._evaluator.hypotheses:
            if hypothesis.part not in parts:
                values = hypothesis.values or (0.0,)
                several = (self._evaluator.ordered((*mistakes, Mistake(hypothesis, value))) for value in values)
                more = min(several, key=self._quick_weight)
                # A small second mistake may lie between two first values that only harm, so most are refined.
                if not hypothesis.rare or self._quick_weight(more) < least:
                    more = self._fitter.refined_one(more, hypothesis)
                found.append(more)
        return sorted(found, key=self._quick_weight)[:FINALISTS]

    def pairs(self, singles: Sequence[Mistakes], first: Sequence[Mistakes]) -> list[Mistakes]:
        """Return the best pairs.

        singles: every mistake alone, best first; first: pairs with the best of them.
        """
        pairs = self._all_pairs({single[0].hypothesis: single[0].value for single in singles})
        careful = [*first]
        for start in singles[1:FIRST_MISTAKES]:
            if not self._evaluator.is_spent(OF_PAIRS):
                careful += self.with_one_more(start)
        return [*pairs, *sorted(careful, key=self._quick_weight)[:FINALISTS]]

    def of_run_and_output(self) -> list[Mistakes]:
        """Return the best pairs of a mistake in the run with one in the output, refined."""
        rough = sorted(self._output_pairs(*self._run_and_output()), key=self._quick_weight)
        return [self._fitter.refined(pair) for pair in rough[:FINALISTS]]

    def _run_and_output(self) -> tuple[list[Hypothesis], list[Hypothesis]]:
        """Return the hypotheses that change the run, without variants, and those that change its output alone."""
        run = [h for h in self._evaluator.hypotheses if h.part not in OUTPUT_PARTS and not h.variant]
        return run, [h for h in self._evaluator.hypotheses if h.part in OUTPUT_PARTS]

    def _all_pairs(self, alone: dict[Hypothesis, float]) -> list[Mistakes]:
        """Return the best pairs.  alone: the fitted value of each hypothesis by itself."""
        physical, output = self._run_and_output()
        rough = list(self._physical_pairs(physical, alone))
        rough += [
            self._rough_pair(*pair, alone)
            for pair in _of_two_parts(output)
            if _is_usual(pair) or _runs_of(*pair) <= GRID
        ]
        rough += self._output_pairs(physical, output)
        rough.sort(key=self._quick_weight)
        refined = (self._fitter.refined(self._best_variants(self._fitter.refined(pair))) for pair in rough[:REFINED])
        return sorted(refined, key=self._quick_weight)[:FINALISTS]

    def _best_variants(self, mistakes: Mistakes) -> Mistakes:
        """Return mistakes with each in turn replaced by its best variant, with its value refined."""
        for place, (hypothesis, value) in enumerate(mistakes):
            same = hypothesis.name, hypothesis.values
            variants = [h for h in self._evaluator.hypotheses if (h.name, h.values) == same]
            if len(variants) > 1:
                tried = ((*mistakes[:place], Mistake(h, value), *mistakes[place + 1 :]) for h in variants)
                mistakes = min(tried, key=self._quick_weight)
                mistakes = self._fitter.refined_one(mistakes, mistakes[place].hypothesis)
        return mistakes

    def _physical_pairs(self, physical: Sequence[Hypothesis], alone: dict[Hypothesis, float]) -> Iterator[Mistakes]:
        """Yield pairs that change the run, as many as a search may: usual ones, the best alone first; then any.

        Of any, those that are best alone and take few runs come first.
        """
        rank = {hypothesis: number for number, hypothesis in enumerate(alone, 1)}
        ranks = {pair: rank[pair[0]] + rank[pair[1]] for pair in _of_two_parts(physical)}
        done = set()
        for pair in sorted(filter(_is_usual, ranks), key=lambda pair: ranks[pair]):
            if self._evaluator.is_spent(OF_USUAL):
                break
            done.add(pair)
            yield self._rough_pair(*pair, alone)
        for pair in sorted(ranks, key=lambda pair: _runs_of(*pair) * ranks[pair]):
            if self._evaluator.is_spent(OF_PAIRS):
                return
            if pair not in done:
                yield self._rough_pair(*pair, alone)

    def _rough_pair(self, one: Hypothesis, other: Hypothesis, alone: dict[Hypothesis, float]) -> Mistakes:
        if _on_a_grid(one, other):
            return min(self._fitter.values_of((one, other)), key=self._quick_weight)
        starts = []
        for first, second in ((one, other), (other, one)):
            start = self._evaluator.ordered((Mistake(first, alone[first]), Mistake(second)))
            starts.append(self._fitter.best_of(start, second, second.values))
        return min(starts, key=self._quick_weight)

    def _output_pairs(self, physical: Sequence[Hypothesis], output: Sequence[Hypothesis]) -> Iterator[Mistakes]:
        """Yield the best pair of each hypothesis about the run with each about the output.

        All runs are transformed at once: mistakes in the output do not change a run.
        """
        runs = [each for hypothesis in physical for each in self._fitter.values_of((hypothesis,))]
        poses = [self._evaluator.pose(run) for run in runs]
        stack = Pose(*(np.concatenate([pose[part] for pose in poses]) for part in range(4)))
        costs = np.array([self._evaluator.cost(run) for run in runs])
        for hypothesis in output:
            weights = np.array(
                [
                    self._evaluator.quick_weights(self._evaluator.transformed(stack, (each,)))
                    + self._evaluator.cost((each,))
                    for (each,) in self._fitter.values_of((hypothesis,))
                ]
            )
            self._evaluator.trials += weights.size
            weights += costs
            for _, group in groupby(range(len(runs)), lambda number: runs[number][0].hypothesis):
                own = list(group)
                value, number = np.unravel_index(int(np.argmin(weights[:, own])), (len(weights), len(own)))
                best = Mistake(hypothesis, (hypothesis.values or (0.0,))[value])
                yield self._evaluator.ordered((*runs[own[int(number)]], best))


def _of_two_parts(hypotheses: Iterable[Hypothesis]) -> Iterator[tuple[Hypothesis, Hypothesis]]:
    """Yield all pairs of mistakes in different parts of a program."""
    return (pair for pair in combinations(hypotheses, 2) if pair[0].part != pair[1].part)


def _is_usual(pair: tuple[Hypothesis, Hypothesis]) -> bool:
    """Whether neither of two mistakes is rare."""
    return not (pair[0].rare or pair[1].rare)


def _on_a_grid(one: Hypothesis, other: Hypothesis) -> bool:
    """Whether two mistakes are tried with all combinations of their values."""
    return not (one.fitted and other.fitted) or _combinations(one, other) <= GRID


def _runs_of(one: Hypothesis, other: Hypothesis) -> int:
    """Return how many runs a quick look at two mistakes takes."""
    return _combinations(one, other) if _on_a_grid(one, other) else len(one.values) + len(other.values)


def _combinations(one: Hypothesis, other: Hypothesis) -> int:
    """Return the number of combinations of the first values of two mistakes."""
    return max(len(one.values), 1) * max(len(other.values), 1)
