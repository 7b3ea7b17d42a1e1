"""Simulates the schemes of engines as whole hypotheses, without a search, and finds the engines that fit a file."""

from collections.abc import Iterable, Sequence
from itertools import product

from tumble.compare.grade.hypotheses.engine_schemes import ENGINES, ROW_SHIFTS, EngineScheme, SteppedScheme, engine_runs
from tumble.compare.grade.hypotheses.explanation import Explanation, Mistakes
from tumble.compare.grade.hypotheses.hypothesis import NEAR
from tumble.compare.grade.search.causal import CausalSearch
from tumble.compare.grade.search.closing import Closing
from tumble.compare.grade.search.evaluator import Evaluator
from tumble.compare.grade.search.proposals import STEPS
from tumble.compare.grade.search.simulations import SearchStopped

# Steps in a row interval that are tried.
MOST_OF_A_ROW = 4
# Schemes that are explained in full, of those with the least weights.
FINALISTS = 3


class EngineSearch:
    """Evaluates the schemes of engines against the rows of a search that looks at all of the run."""

    def __init__(self, evaluator: Evaluator, search: CausalSearch, engines: Sequence[EngineScheme] = ENGINES) -> None:
        self._evaluator, self._search, self._engines = evaluator, search, engines
        self._mistakes = search.proposals.schemes.mistakes

    def defaults(self) -> list[Explanation]:
        """Return the best explanations by an engine's defaults, best first.

        It is empty if rows are so dense that no engine's step between them can be simulated.
        """
        own = self._runs(short=False)
        found = self._closest(one for one in own if not one.late and not one.impulse_as_force)
        if not (found and found[0].within_floor):  # what is late, early or a force comes after what is none of these
            found += self._closest(one for one in own if one.late or one.impulse_as_force)
        return sorted(found, key=lambda one: one.weight)[:FINALISTS]

    def short_defaults(self, stops_at: float) -> list[Explanation]:
        """Return the best explanations by an engine's defaults in shorter steps, until a processor time [s]."""
        plain = [one for one in self._runs(short=True) if not one.late and not one.impulse_as_force]
        self._search.stop_at(stops_at)
        try:
            return self._closest(plain)
        except SearchStopped:
            return []
        finally:
            self._search.look_at_all()

    def fitting(self, best: Explanation, closing: Closing) -> tuple[str, ...]:
        """Return the engines that fit as well as the best explanation, at its step; with shifted rows last."""
        step = next((m.value for m in best.mistakes if m.hypothesis.part == STEPS), 0.0)
        if not step or not best.within_floor:
            return ()
        for shifts, force in product(((0,), ROW_SHIFTS[1:]), (False, True)):
            named = []
            for scheme, shift in product(self._engines, shifts):
                mistakes = self._mistakes(SteppedScheme(scheme, scheme.step or step, shift, force))
                if self._search.is_near(mistakes, best.mistakes) and closing.is_as_good(
                    self._evaluator.explain(mistakes), best
                ):
                    named.append(scheme.engine)
            if named or (force and not self._evaluator.context.program.impulses):
                return tuple(dict.fromkeys(named))
        return ()

    def _runs(self, short: bool) -> list[SteppedScheme]:
        """Return the engines' schemes in steps of which at most a few are in a row interval, or in shorter ones."""
        context = self._evaluator.context
        shortest = context.spacing_s / MOST_OF_A_ROW * (1 - NEAR)
        every = engine_runs(context, self._engines)
        return [one for one in every if (one.step * one.scheme.substeps < shortest) == short]

    def _closest(self, runs: Iterable[SteppedScheme]) -> list[Explanation]:
        every: list[Mistakes] = list(map(self._mistakes, runs))
        return list(map(self._evaluator.explain, self._search.closest(every, FINALISTS)))
