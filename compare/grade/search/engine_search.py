"""Flies the laws of engines as whole hypotheses, without a search, and says which engines do what a file shows."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

from tumble.compare.grade.hypotheses.engine_schemes import (
    ENGINES,
    GYROSCOPIC,
    LATE,
    ROTATION,
    Flown,
    Law,
    combinations,
    table,
)
from tumble.compare.grade.hypotheses.explanation import Explanation, Mistake, Mistakes
from tumble.compare.grade.hypotheses.scheme_hypotheses import Laws
from tumble.compare.grade.search.damping_search import Damped
from tumble.compare.grade.search.evaluator import Flights
from tumble.compare.grade.search.fitting import Fitter

# Laws that are looked at closely, of those that leave least.
FINALISTS = 3
# Beneath the floor, which is what rounding could do at most: so many times more is seen, below this share of it not.
SEEN, HIDDEN = 3.0, 0.5


class Lawful:
    """Holds laws against the rows."""

    def __init__(self, flights: Flights, fitter: Fitter, engines: Sequence[Law] = ENGINES) -> None:
        self._flights, self._laws, self._table = flights, Laws(flights.question), engines
        self._damped = Damped(flights, fitter, self._laws)

    def engines(self) -> tuple[list[Explanation], tuple[str, ...]]:
        """Return the explanations by engines that leave least, best first, and those that do so if it is whole.

        None where rows are so dense that no engine's step between them can be flown.
        """
        found = self._closest(table(self._flights.question, self._table))
        if found and found[0][1].nothing:
            flown, best = found[0]
            return [self._plain(best)], tuple(self._engines(flown, best))
        return [explanation for _, explanation in found], ()

    def combined(self) -> list[Explanation]:
        """Return the explanations by what no engine does, but parts of several, best first."""
        found = [explanation for _, explanation in self._closest(combinations(self._flights.question, self._table))]
        return [self._plain(found[0])] if found and found[0].nothing else found

    def damped(self) -> list[Explanation]:
        """Return the explanations by schemes of engines with damping of any rate, best first."""
        found = self._damped.explanations()
        return [self._plain(found[0])] if found and found[0].nothing else found

    def _closest(self, laws: Iterable[Flown]) -> list[tuple[Flown, Explanation]]:
        weighed = sorted(((self._flights.law(self._laws.mistakes(flown)), n, flown) for n, flown in enumerate(laws)))
        some = [flown for _, _, flown in weighed[:FINALISTS]]
        explained = [(flown, self._flights.explain(self._laws.mistakes(flown))) for flown in some]
        return sorted(explained, key=lambda one: one[1].weight)

    def _plain(self, best: Explanation) -> Explanation:
        """Return an explanation without what cannot be seen in this scene: mistakes, and parts of the step."""
        for mistake in best.mistakes:
            fewer = self._flights.explain(tuple(other for other in best.mistakes if other is not mistake))
            if self._as_good(fewer, best):
                best = fewer
        return self._without_details(best)

    def _as_good(self, other: Explanation, best: Explanation) -> bool:
        """Whether another leaves nothing either, and what it leaves beneath the floor is not seen to be more."""
        room_m = max(SEEN * best.weighed_m, HIDDEN * self._flights.scale.floor_m)
        return other.nothing and other.weighed_m <= room_m

    def _without_details(self, best: Explanation) -> Explanation:
        """Return an explanation with only as much said of its step as other steps would not do as well."""
        place = next((n for n, mistake in enumerate(best.mistakes) if mistake.hypothesis.part == "steps"), None)
        if place is None:
            return best
        details = dict(best.mistakes[place].hypothesis.details)
        for detail, others in (("gyroscopic", GYROSCOPIC), ("rotation", ROTATION)):
            tried = [
                self._flights.explain(self._stepped(best.mistakes, place, details | {detail: other}))
                for other in others
                if details[detail] and other not in (details[detail], "none")
            ]
            if tried and all(self._as_good(each, best) for each in tried):
                details[detail] = ""
        return self._flights.explain(self._stepped(best.mistakes, place, details))

    def _stepped(self, mistakes: Mistakes, place: int, details: dict[str, str]) -> Mistakes:
        falls, normalises = int(details["substeps"] or 1), 0 if details["normalised"] else 1
        hypothesis = self._laws.step(details["gyroscopic"], details["rotation"], falls, normalises)
        step = Mistake(hypothesis, mistakes[place].value)
        return (*mistakes[:place], step, *mistakes[place + 1 :])

    def _engines(self, flown: Flown, best: Explanation) -> list[str]:
        """Return the engines that do as well at the same step, those first whose rows need not be shifted as well."""
        ticks = flown.law.late + flown.late
        for shifts in ((0,), LATE[1:]):
            engines = [
                law.engine for law in self._table if ticks - law.late in shifts and self._does(flown, best, law, ticks)
            ]
            if engines:
                return list(dict.fromkeys(engines))
        return []

    def _does(self, flown: Flown, best: Explanation, law: Law, ticks: int) -> bool:
        """Whether an engine does as well."""
        same = replace(flown, law=law, step=law.step or flown.step, late=ticks - law.late)
        return self._as_good(self._flights.explain(self._laws.mistakes(same)), best)
