"""Simulates the schemes of engines as whole hypotheses, without a search, and finds the engines that fit a file."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

from tumble.compare.grade.hypotheses.engine_schemes import (
    ENGINES,
    GYROSCOPIC,
    ROTATION,
    ROW_SHIFTS,
    EngineScheme,
    SteppedScheme,
    engine_runs,
    scheme_combinations,
)
from tumble.compare.grade.hypotheses.explanation import Explanation, Mistake, Mistakes
from tumble.compare.grade.hypotheses.hypothesis import NEAR
from tumble.compare.grade.hypotheses.scheme_hypotheses import SchemeHypotheses
from tumble.compare.grade.search.damping_search import DampingSearch
from tumble.compare.grade.search.evaluator import Evaluator
from tumble.compare.grade.search.fitting import Fitter
from tumble.compare.grade.search.scheme_search import SchemeSearch

# Steps in a row interval that are tried first.
MOST_OF_A_ROW = 4
# Schemes that are explained in full, of those with the least weights.
FINALISTS = 3
# Residuals within the floor, an upper bound of rounding: one is larger if it is this many times another, but not if it
# is below this share of the floor.
LARGER, HIDDEN = 3.0, 0.5


class EngineSearch:
    """Evaluates the schemes of engines against the rows."""

    def __init__(self, evaluator: Evaluator, fitter: Fitter, engines: Sequence[EngineScheme] = ENGINES) -> None:
        self._evaluator, self._hypotheses, self._engines = evaluator, SchemeHypotheses(evaluator.context), engines
        self.schemes = SchemeSearch(evaluator, fitter, self._hypotheses)
        self._damping_search = DampingSearch(evaluator, fitter, self._hypotheses, self.schemes)

    def defaults(self, short: bool) -> tuple[list[Explanation], tuple[str, ...]]:
        """Return the best explanations by an engine's defaults, best first, and the engines that fit if one is whole.

        Both are empty if rows are so dense that no engine's step between them can be simulated.  short: with steps of
        which more than a few are in a row interval, which takes long; otherwise with longer ones.
        """
        context = self._evaluator.context
        shortest = context.spacing_s / MOST_OF_A_ROW * (1 - NEAR)
        runs = engine_runs(context, self._engines)
        own = [one for one in runs if (one.step * one.scheme.substeps < shortest) == short]
        found = self._closest(one for one in own if not one.late and not one.impulse_as_force)
        if not (found and found[0][1].within_floor):  # what is late, early or a force comes after what is none of these
            found += self._closest(one for one in own if one.late or one.impulse_as_force)
            found = sorted(found, key=lambda one: one[1].weight)[:FINALISTS]
        if found and found[0][1].within_floor:
            stepped, best = found[0]
            return [self._simplified(best)], tuple(self._fitting_engines(stepped, best))
        return [explanation for _, explanation in found], ()

    def combined(self) -> list[Explanation]:
        """Return the best explanations by parts of several engines, best first."""
        runs = scheme_combinations(self._evaluator.context, self._engines)
        return self.simplified_if_whole([explanation for _, explanation in self._closest(runs)])

    def damped(self, weight: float) -> list[Explanation]:
        """Return the best explanations by schemes with fitted damping, best first; weight: of another explanation."""
        return self.simplified_if_whole(self._damping_search.explanations(weight))

    def simplified_if_whole(self, found: list[Explanation]) -> list[Explanation]:
        """Return explanations, best first; if the best is whole, only that, without what has no effect."""
        return [self._simplified(found[0])] if found and found[0].within_floor else found

    def _closest(self, runs: Iterable[SteppedScheme]) -> list[tuple[SteppedScheme, Explanation]]:
        of = self._hypotheses.mistakes
        weights = sorted((self._evaluator.scheme_weight(of(stepped)), n, stepped) for n, stepped in enumerate(runs))
        finalists = [stepped for _, _, stepped in weights[:FINALISTS]]
        explained = [(stepped, self._evaluator.explain(of(stepped))) for stepped in finalists]
        return sorted(explained, key=lambda one: one[1].weight)

    def _simplified(self, best: Explanation) -> Explanation:
        """Return an explanation without what has no effect in this scene: mistakes, and details of the step."""
        for mistake in best.mistakes:
            fewer = self._evaluator.explain(tuple(other for other in best.mistakes if other is not mistake))
            if self._is_as_good(fewer, best):
                best = fewer
        return self._without_details(best)

    def _is_as_good(self, other: Explanation, best: Explanation) -> bool:
        """Whether another explanation is within the floor too, and not larger as far as can be seen there."""
        most_m = max(LARGER * best.weighted_rms_m, HIDDEN * self._evaluator.scale.floor_m)
        return other.within_floor and other.weighted_rms_m <= most_m

    def _without_details(self, best: Explanation) -> Explanation:
        """Return an explanation without the details of its step that all other steps fit as well."""
        of_step = (n for n, m in enumerate(best.mistakes) if m.hypothesis.part == "steps" and m.hypothesis.details)
        place = next(of_step, None)
        if place is None:
            return best
        details = dict(best.mistakes[place].hypothesis.details)
        for detail, others in (("gyroscopic", GYROSCOPIC), ("rotation", ROTATION)):
            tried = [
                self._evaluator.explain(self._with_step(best.mistakes, place, details | {detail: other}))
                for other in others
                if details[detail] and other not in (details[detail], "none")
            ]
            if tried and all(self._is_as_good(each, best) for each in tried):
                details[detail] = ""
        return self._evaluator.explain(self._with_step(best.mistakes, place, details))

    def _with_step(self, mistakes: Mistakes, place: int, details: dict[str, str]) -> Mistakes:
        substeps, normalise_every = int(details["substeps"] or 1), 0 if details["normalised"] else 1
        hypothesis = self._hypotheses.step(details["gyroscopic"], details["rotation"], substeps, normalise_every)
        step = Mistake(hypothesis, mistakes[place].value)
        return (*mistakes[:place], step, *mistakes[place + 1 :])

    def _fitting_engines(self, stepped: SteppedScheme, best: Explanation) -> list[str]:
        """Return the engines that fit as well at the same step; with shifted rows only if none fits without."""
        ticks = stepped.scheme.late + stepped.late
        for shifts in ((0,), ROW_SHIFTS[1:]):
            engines = [
                scheme.engine
                for scheme in self._engines
                if ticks - scheme.late in shifts and self._fits(stepped, best, scheme, ticks)
            ]
            if engines:
                return list(dict.fromkeys(engines))
        return []

    def _fits(self, stepped: SteppedScheme, best: Explanation, scheme: EngineScheme, ticks: int) -> bool:
        """Whether an engine fits as well as the best explanation."""
        same = replace(stepped, scheme=scheme, step=scheme.step or stepped.step, late=ticks - scheme.late)
        return self._is_as_good(self._evaluator.explain(self._hypotheses.mistakes(same)), best)
