"""Tries every mistake against a trajectory, alone, in pairs and one by one on top, and ranks what it finds."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, groupby

import numpy as np

from tumble.compare.grade.hypotheses.engine_schemes import ENGINES, Law
from tumble.compare.grade.hypotheses.explanation import Explanation, Mistake, Mistakes
from tumble.compare.grade.hypotheses.hypothesis import Hypothesis
from tumble.compare.grade.hypotheses.mistakes.clocks import NEVER_MOVES
from tumble.compare.grade.hypotheses.mistakes.output import WRITTEN
from tumble.compare.grade.measure.significance import ALIKE
from tumble.compare.grade.model.program_model import FINE, Account, Pose
from tumble.compare.grade.search.engine_search import Lawful
from tumble.compare.grade.search.evaluator import ENOUGH, Flights
from tumble.compare.grade.search.fitting import Fitter

# Parts of a program whose mistakes may make one motion: gravity from the second step on, and x by the old velocity.
TWINS = {"gravity start": "position step", "position step": "gravity start"}
# Pairs that are looked at again, and explanations that are fitted finely.
AGAIN = 32
FINALISTS = 6
# Single mistakes that are fitted finely: one that is right may look no better at first than others.
SINGLES = 12
# Shares of the steps that a search may take after which no more pairs of usual mistakes are looked at, and of any.
OF_USUAL, OF_PAIRS = 1 / 3, 0.6
# Single mistakes upon which all others are tried with care, and explanations upon which more are.
TOGETHER, STARTS = 6, 3
MOST_MISTAKES = 5
# Parts of a program whose mistakes may make one motion: gravity from the second step on, x moved by the old velocity.
SURELY = 0.05
# An error below this share of the body's size is of one mistake, if of any.
SMALL = 1e-6
# Two numbers are tried on a grid of no more points than this, otherwise each where the other alone is best.
GRID = 40
# What is left without a mistake must be so much more than with it; and more still where what is left with it is no
# noise, for any number takes away some of a systematic rest.
LEAST_HELP, MUCH_HELP = 1.1, 1.5


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """What was found: the explanation by nothing, the best, those that fit alike, and how the best comes about.

    steps: explanations from nothing to the best, each with one mistake more, the one that can be spared least first;
    engines: those that do the same at their defaults.
    """

    nothing: Explanation
    best: Explanation
    alike: tuple[Explanation, ...]
    steps: tuple[Explanation, ...]
    tried: int
    account: Account
    engines: tuple[str, ...] = ()


class Search:
    """Looks for explanations of the rows that flights are held against."""

    def __init__(
        self,
        flights: Flights,
        engines: Sequence[Law] = ENGINES,
        nearest: Callable[[Explanation], None] = lambda _: None,
    ) -> None:
        self._flights, self._fitter, self._glanced = flights, Fitter(flights), flights.glanced
        self._lawful, self._nearest = Lawful(flights, self._fitter, engines), nearest

    def diagnose(self) -> Diagnosis:
        """Return what explains the rows best."""
        nothing = self._flights.explain(())
        found, engines = [nothing], ()
        if not nothing.nothing:
            found += self._still()
        if not found[-1].nothing:
            law, engines = self._lawful.engines()
            found += law
            if not any(each.nothing for each in law):
                found += self._searched(nothing, law)
        helpful = [nothing, *(each for each in found if each.max_m < nothing.max_m)]
        ranked = [each for each in sorted(helpful, key=_by_weight) if not _is_padded(each, helpful)]
        best = ranked[0]
        alike = [
            each
            for each in ranked[1:]
            if each.weight < best.weight + ALIKE and not each.names > best.names and each.names != best.names
        ]
        account = self._flights.changed(best.mistakes)
        # Rows that are late are anybody's.
        told = best is found[-1] and any(mistake.hypothesis.part != "clock offset" for mistake in best.mistakes)
        engines = engines if engines and told else ()
        return Diagnosis(
            nothing,
            best,
            () if engines else tuple(_distinct(alike)),
            tuple(self._steps(nothing, best)),
            self._flights.tried,
            account,
            engines,
        )

    def _still(self) -> list[Explanation]:
        """Return the explanation that the body never moves, if that is all: other laws would do as well."""
        never = [self._flights.explain((Mistake(h),)) for h in self._flights.hypotheses if h.name == NEVER_MOVES]
        return [each for each in never if each.nothing]

    def _searched(self, nothing: Explanation, laws: Sequence[Explanation]) -> list[Explanation]:
        """Return what a search finds, where whole laws have not been enough."""
        singles = sorted((self._fitter.tuned((h,)) for h in self._flights.hypotheses), key=self._glanced)
        explained = sorted(self._explained(singles[:SINGLES]), key=_by_weight)
        # Of what one mistake explains there is nothing left to fit, and those fits take seconds.
        damped = [] if any(each.nothing for each in explained) else self._damped()
        found = [*laws, *explained]
        if damped and damped[0].nothing:
            return [*damped, *explained]
        self._tell_nearest((*laws, *damped))
        found += self._finer(min(found, key=_by_weight))
        if not min(found, key=_by_weight).nothing:
            found += self._lawful.combined()
        alone = min(found, key=_by_weight)
        self._flights.look_for(alone.rms_m)
        # Its mistake with each of those that help it most.
        on_top = [] if alone.nothing or self._is_small(nothing) else self._on_top(alone.mistakes)
        if on_top and (not alone.noise or self._glanced(on_top[0]) < self._glanced(alone.mistakes) - ALIKE):
            if alone.weighed_m <= SURELY * nothing.weighed_m:
                found += self._explained(on_top)
                found += self._deeper(found)
            if not min(found, key=_by_weight).is_whole:
                found += self._explained(self._together(on_top, singles))
                found += self._deeper(found)
        found += self._finer(min(found, key=_by_weight))
        found += self._with_one_fewer(found)
        found += self._swapped(min(found, key=_by_weight))
        # What damped schemes leave is not built upon: the search has its own damping.
        return [*damped, *found[len(laws) :]]

    def _damped(self) -> list[Explanation]:
        """Return what schemes with damping of any rate leave; what they take is not of what the search may take."""
        spent = self._flights.steps
        found = self._lawful.damped()
        self._flights.steps = spent
        return found

    def _tell_nearest(self, laws: Sequence[Explanation]) -> None:
        """Tell whose law comes nearest, where there is any."""
        if laws:
            self._nearest(min(laws, key=_by_weight))

    def _is_small(self, nothing: Explanation) -> bool:
        """Whether so little is wrong that more than one mistake cannot be told."""
        return nothing.rms_m < SMALL * self._flights.scale.size_m

    def _together(self, on_top: Sequence[Mistakes], singles: Sequence[Mistakes]) -> list[Mistakes]:
        """Return the best pairs: of all, and of the best alone with any other tried with care, as on_top has them."""
        pairs = self._pairs({single[0].hypothesis: single[0].value for single in singles})
        careful = [*on_top]
        for start in singles[1:TOGETHER]:
            if not self._is_spent(OF_PAIRS):
                careful += self._on_top(start)
        return [*pairs, *sorted(careful, key=self._glanced)[:FINALISTS]]

    def _pairs(self, alone: dict[Hypothesis, float]) -> list[Mistakes]:
        """Return the best pairs.  alone: what each hypothesis was fitted to by itself."""
        flown = [h for h in self._flights.hypotheses if h.part not in WRITTEN and not h.variant]
        written = [h for h in self._flights.hypotheses if h.part in WRITTEN]
        rough = list(self._rough_pairs(flown, alone))
        rough += [
            self._rough_pair(*pair, alone)
            for pair in _of_two_parts(written)
            if _is_usual(pair) or _flights_of(*pair) <= GRID
        ]
        rough += self._written_pairs(flown, written)
        rough.sort(key=self._glanced)
        again = (self._fitter.polished(self._varied(self._fitter.polished(pair))) for pair in rough[:AGAIN])
        return sorted(again, key=self._glanced)[:FINALISTS]

    def _varied(self, mistakes: Mistakes) -> Mistakes:
        """Return mistakes with each in turn as that variant of it that leaves least, and its number fitted again."""
        for place, (hypothesis, value) in enumerate(mistakes):
            same = hypothesis.name, hypothesis.values
            variants = [h for h in self._flights.hypotheses if (h.name, h.values) == same]
            if len(variants) > 1:
                tried = ((*mistakes[:place], Mistake(h, value), *mistakes[place + 1 :]) for h in variants)
                mistakes = min(tried, key=self._glanced)
                mistakes = self._fitter.polished_one(mistakes, mistakes[place].hypothesis)
        return mistakes

    def _rough_pairs(self, flown: Sequence[Hypothesis], alone: dict[Hypothesis, float]) -> Iterator[Mistakes]:
        """Yield pairs of what is flown, as many as a search may: usual ones, of what helps most alone first; then any.

        Of any, first those of what helps most and takes few flights.
        """
        rank = {hypothesis: number for number, hypothesis in enumerate(alone, 1)}
        ranks = {pair: rank[pair[0]] + rank[pair[1]] for pair in _of_two_parts(flown)}
        looked_at = set()
        for pair in sorted(filter(_is_usual, ranks), key=lambda pair: ranks[pair]):
            if self._is_spent(OF_USUAL):
                break
            looked_at.add(pair)
            yield self._rough_pair(*pair, alone)
        for pair in sorted(ranks, key=lambda pair: _flights_of(*pair) * ranks[pair]):
            if self._is_spent(OF_PAIRS):
                return
            if pair not in looked_at:
                yield self._rough_pair(*pair, alone)

    def _rough_pair(self, one: Hypothesis, other: Hypothesis, alone: dict[Hypothesis, float]) -> Mistakes:
        if _on_a_grid(one, other):
            return min(self._fitter.values_of((one, other)), key=self._glanced)
        starts = []
        for first, second in ((one, other), (other, one)):
            start = self._flights.ordered((Mistake(first, alone[first]), Mistake(second)))
            starts.append(self._fitter.best_of(start, second, second.values))
        return min(starts, key=self._glanced)

    def _written_pairs(self, flown: Sequence[Hypothesis], written: Sequence[Hypothesis]) -> Iterator[Mistakes]:
        """Yield, of each hypothesis of flying and each of writing, the pair with the best values.

        All flights are written down at once: a flight is the same however it is written.
        """
        flights = [each for hypothesis in flown for each in self._fitter.values_of((hypothesis,))]
        poses = [self._flights.pose(flight) for flight in flights]
        stack = Pose(*(np.concatenate([pose[part] for pose in poses]) for part in range(4)))
        costs = np.array([self._flights.cost(flight) for flight in flights])
        for hypothesis in written:
            weights = np.array(
                [
                    self._flights.weights(self._flights.written(stack, (each,))) + self._flights.cost((each,))
                    for (each,) in self._fitter.values_of((hypothesis,))
                ]
            )
            self._flights.tried += weights.size
            weights += costs
            for _, group in groupby(range(len(flights)), lambda number: flights[number][0].hypothesis):
                own = list(group)
                value, number = np.unravel_index(int(np.argmin(weights[:, own])), (len(weights), len(own)))
                best = Mistake(hypothesis, (hypothesis.values or (0.0,))[value])
                yield self._flights.ordered((*flights[own[int(number)]], best))

    def _on_top(self, mistakes: Mistakes) -> list[Mistakes]:
        """Return the mistakes with each of those that help them most."""
        parts = {mistake.hypothesis.part for mistake in mistakes}
        found = []
        least = self._glanced(mistakes)
        for hypothesis in self._flights.hypotheses:
            if hypothesis.part not in parts:
                values = hypothesis.values or (0.0,)
                more = (self._flights.ordered((*mistakes, Mistake(hypothesis, value))) for value in values)
                more = min(more, key=self._glanced)
                # Polished, most of them: a small second mistake may lie between two values tried first that only harm.
                if not hypothesis.rare or self._glanced(more) < least:
                    more = self._fitter.polished_one(more, hypothesis)
                found.append(more)
        return sorted(found, key=self._glanced)[:FINALISTS]

    def _deeper(self, found: Sequence[Explanation]) -> list[Explanation]:
        """Return explanations with more mistakes than those found, as long as one more is well worth it."""
        deeper: list[Explanation] = []
        starts = sorted(found, key=_by_weight)[:STARTS]
        while not self._is_enough(starts[0]):
            self._flights.look_for(starts[0].rms_m)
            candidates = [more for start in starts if start.mistakes for more in self._on_top(start.mistakes)]
            more = self._explained(sorted(candidates, key=self._glanced)[:FINALISTS])
            deeper += more
            if not more or min(map(_by_weight, more)) > starts[0].weight - ALIKE:
                break
            starts = sorted(more, key=_by_weight)[:STARTS]
        return deeper

    def _is_enough(self, best: Explanation) -> bool:
        """Whether nothing is left to explain, or too much has been assumed already."""
        return best.is_whole or not best.mistakes or len(best.mistakes) >= MOST_MISTAKES or self._is_spent()

    def _is_spent(self, share: float = 1.0) -> bool:
        """Whether a share of what a search may take has been flown."""
        return self._flights.steps > share * ENOUGH

    def _finer(self, best: Explanation) -> Iterator[Explanation]:
        """Yield the best explanation fitted to fine flights, where rough ones may have been what it leaves."""
        smooth = [m.hypothesis for m in best.mistakes if m.hypothesis.fitted and not m.is_known]
        if smooth and not best.is_whole:
            yield self._flights.explain(self._fitter.descended(best.mistakes, smooth, FINE))

    def _with_one_fewer(self, found: Sequence[Explanation]) -> list[Explanation]:
        """Return the best explanations without each of their mistakes, as they were fitted together."""
        best = sorted(found, key=_by_weight)[:FINALISTS]
        more = (each.mistakes for each in best if len(each.mistakes) > 1)
        fewer = (some for mistakes in more for some in combinations(mistakes, len(mistakes) - 1))
        return [self._flights.explain(some) for some in dict.fromkeys(fewer)]

    def _swapped(self, best: Explanation) -> list[Explanation]:
        """Return the best explanation with each mistake in turn as those of its part that have no number, or a twin's.

        A twin's number, where it takes one, is the step.
        """
        step = next((mistake.value for mistake in best.mistakes if mistake.hypothesis.part == "steps"), 0.0)
        several = best.mistakes if len(best.mistakes) > 1 else ()
        swaps = [
            (*best.mistakes[:place], Mistake(h, step if h.values else 0.0), *best.mistakes[place + 1 :])
            for place, mistake in enumerate(several)
            for h in self._flights.hypotheses
            if h is not mistake.hypothesis
            and ((h.part == mistake.hypothesis.part and not h.values) or h.part == TWINS.get(mistake.hypothesis.part))
        ]
        return [self._flights.explain(self._flights.ordered(some)) for some in swaps]

    def _explained(self, candidates: Iterable[Mistakes]) -> list[Explanation]:
        """Return candidates fitted finely, each as well with values that have a name."""
        fitted = list(map(self._fitter.fit, candidates))
        return [self._flights.explain(each) for each in dict.fromkeys((*fitted, *map(self._fitter.named, fitted)))]

    def _steps(self, nothing: Explanation, best: Explanation) -> list[Explanation]:
        """Return explanations from nothing to the best, with more and more of its mistakes, each with a smaller error.

        One by one it loses the mistake that it can best spare.  Where mistakes help only together, the error of some of
        them is larger than without: a step is then of several.
        """
        steps = [best]
        for fewer in range(len(best.mistakes) - 1, 0, -1):
            candidates = [self._flights.explain(some) for some in combinations(steps[0].mistakes, fewer)]
            smaller = [each for each in candidates if steps[0].max_m < each.max_m < nothing.max_m]
            if smaller:
                steps.insert(0, min(smaller, key=lambda each: each.weighed_m))
        return [nothing, *steps] if best.mistakes else steps


def _of_two_parts(hypotheses: Iterable[Hypothesis]) -> Iterator[tuple[Hypothesis, Hypothesis]]:
    """Yield all pairs of mistakes in different parts of a program."""
    return (pair for pair in combinations(hypotheses, 2) if pair[0].part != pair[1].part)


def _is_usual(pair: tuple[Hypothesis, Hypothesis]) -> bool:
    """Whether neither of two mistakes is rare."""
    return not (pair[0].rare or pair[1].rare)


def _on_a_grid(one: Hypothesis, other: Hypothesis) -> bool:
    """Whether two mistakes are tried with all combinations of their values."""
    return not (one.fitted and other.fitted) or _combinations(one, other) <= GRID


def _flights_of(one: Hypothesis, other: Hypothesis) -> int:
    """Return how many flights a first look at two mistakes takes."""
    return _combinations(one, other) if _on_a_grid(one, other) else len(one.values) + len(other.values)


def _combinations(one: Hypothesis, other: Hypothesis) -> int:
    """Return how many combinations there are of the values that two mistakes are tried with first."""
    return max(len(one.values), 1) * max(len(other.values), 1)


def _by_weight(explanation: Explanation) -> float:
    return explanation.weight


def _is_padded(explanation: Explanation, others: Iterable[Explanation]) -> bool:
    """Whether some of an explanation's mistakes do nearly as well without the rest."""
    enough = explanation.weighed_m * (LEAST_HELP if explanation.is_whole else MUCH_HELP)
    return any(
        other.names < explanation.names and (other.weighed_m <= enough or (other.nothing and explanation.nothing))
        for other in others
    )


def _distinct(explanations: Iterable[Explanation]) -> Iterator[Explanation]:
    """Yield the first of those that have the same names."""
    seen: set[frozenset[str]] = set()
    for each in explanations:
        if each.names not in seen:
            seen.add(each.names)
            yield each
