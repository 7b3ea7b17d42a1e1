"""Finds the mistakes of a program in the order in which they show: first in the first rows, then in more and more."""

from collections.abc import Callable, Collection, Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain, combinations, product

import numpy as np

from tumble.compare.grade.hypotheses.explanation import Mistake, Mistakes
from tumble.compare.grade.hypotheses.hypothesis import NEAR, Hypothesis
from tumble.compare.grade.hypotheses.mistakes.output import OUTPUT_PARTS
from tumble.compare.grade.hypotheses.names import GRAVITY_SIZE, LOG_LAG
from tumble.compare.grade.measure.significance import ALIKE, EXPLAINED
from tumble.compare.grade.search.changes import LONG, RIGHT, Changes, best_of_each
from tumble.compare.grade.search.clock import search_clock
from tumble.compare.grade.search.evaluator import Evaluator
from tumble.compare.grade.search.least_squares import Fitting
from tumble.compare.grade.search.parts import NO_SLOPES
from tumble.compare.grade.search.proposals import DAMPED, STEPS
from tumble.compare.grade.search.simulations import SearchStopped
from tumble.scenarios.frames import Array

# Programs of many that are followed beyond the first part of the run.
FOLLOWED = 60
# Alternatives of which the first step of a fit shows which are nearest.
LIKELY = 60
# Changes that are fitted, of all that are tried; steps of their fits after which, of these and of schemes, so many are
# fitted to the end.
FITTED, FIRST_STEPS, LIKELIEST = 10, 2, 5
# Single changes that are fitted, before programs with several.
ALONE = 24
# Of these, so many are followed if what seems best leads nowhere.
SINGLE = 2
# Other first changes that are tried if the best one leads nowhere; and how often others are tried in all.
DIVES, MOST_DIVES = 3, 8
# Rows that distinguish schemes.
ENOUGH = 40
# Share of the first part of the run in which most programs that are no alternative to one are seen to be none.
GLANCE = 0.25
# Residual in floors by which a program is wrong; how far to look beyond the first row where it is, over its time and in
# row intervals.
SHOWN, BEYOND, ROWS_BEYOND = 30.0, 1.2, 6
# Parts of a program of which a mistake shows in the first row.
AT_ONCE = OUTPUT_PARTS | {"start position", "start attitude"}
# Factor by which a mistake makes a body turn faster at least, if steps hide that mistake.
FASTER = 3.0
# Mistakes that are looked for in the first row, at most; and programs with one of them that are tried with another.
AT_FIRST, PAIRED = 2, 12
# Parts of the rotation whose mistakes may hide each other; parts of what a program writes that may be as wrong as what
# it reads.
ENTANGLED = {"spin", "inertia", "inertia axes", "body size", "gyroscopic", "frame", "turning", "impulse", "lever"}
CONVENTIONS = {"quaternion order", "conjugate", "axes", "body axes"}
# Choices of a mistake that is tried with others, at most; and of one in what a program writes.
CHOICES, MOST_CHOICES = 8, 48
# Share of what is wrong in the first row that may be left by a mistake that explains it.
UNSHOWN = 0.01
# Two parts of the run that differ by a smaller factor are one.
CLOSE = 1.1
# Share of the first score that is little enough to look at more of the run.
NEARLY = 0.25
# Share of what no mistake leaves that is little enough to try a single change before others.
HALF = 0.5
# Share of a score that a change has to gain, or other schemes are tried as well.
DECISIVE = 0.5
# Programs that are kept from one part of the run to the next, and that are tried with what the first one still needs.
KEPT, SWAPPED = 3, 8
# Programs whose centre moves otherwise that are fitted; and the rate of linear damping that a fit begins at [1/s].
MOVED, USUAL_RATE = 4, 0.1
MOST_MISTAKES = 8
# Share of the time that is left in which others as good as a program are looked for, before they are fitted.
PROFILED = 0.75
# Floors that a linear estimate of values leaves, if no fit of these explains everything.
FAR = 1e3
# What one more mistake must gain before all of the run is looked at.
MUCH = 30.0
# What schemes must seem to gain before they are fitted where another change helps: little more than one costs.
HOPED = 20.0


# Share of what a mistake with a value gains that counts, since any value explains a part of almost anything; and of one
# with several values.
VALUED, VAGUE = 0.85, 0.5


# Two programs leave nearly the same if their largest squares differ by no more than this factor.
ALIKE_SQUARES = 9.0
# Parts of a program of which any value is as good as a free translation.
TRANSLATION = ("start velocity", "gravity")
# Scores of what is left that differ by less are of the same motion, if one program has the other one's mistakes, or as
# many.
SAME = 0.1


@dataclass(eq=False)
class Candidate:
    """Mistakes, and the information criterion of what they leave with the cost of assumptions.

    weight: of all; score: with a free translation; rank: the score if each mistake had gained only the share of what it
    gained that counts; by it programs are ranked.  is_enough: they explain all, or the rotation if the translation is
    free.
    """

    mistakes: Mistakes
    weight: float
    score: float
    is_whole: bool
    rank: float
    is_enough: bool = False
    is_expanded: bool = field(default=False)


class CausalSearch(Changes):
    """Searches for the mistakes of the program that wrote some rows; is_double: it is of double precision."""

    # What the first rows show by themselves; of that, what is late by whole row intervals.
    _known: Sequence[Mistakes] = ((),)
    _whole_rows_late: Sequence[Mistakes] = ()

    def __init__(self, evaluator: Evaluator, is_double: bool = False) -> None:
        super().__init__(evaluator, evaluator.double_scale if is_double else evaluator.search_scale)
        self._evaluator, self._is_double = evaluator, is_double
        self._single: dict[float, list[Candidate]] = {}
        self.is_stopped = False

    @property
    def alone(self) -> list[Mistakes]:
        """The single changes that were found first, best first."""
        return [candidate.mistakes for candidate in next(iter(self._single.values()), [])]

    def candidates(
        self, stops_at: float, on_progress: Callable[[float], object] = lambda share: None
    ) -> list[Candidate]:
        """Return the best programs, best first.

        stops_at: processor time [s]; on_progress: called with the share that is done.
        """
        self._stops_at = stops_at
        pool, alone = [Candidate((), 0.0, 0.0, False, 0.0)], list[Candidate]()
        try:
            alone = self._alone()
            # A step moves a falling body as another start velocity does, and so do several mistakes together.
            if alone and not _is_vague(alone[0]):
                return alone
            alike = self._shown_at_once()
            before = 0.0
            while before < self._context.duration:
                on_progress(before / self._context.duration)
                until = self._next_part(before, alike[0])
                self._begin(until)
                begun = self._nearest(alike, KEPT)
                # Long steps hide by how much rows are late, most often by whole row intervals.
                late = [] if before else [each for each in alike if each in self._whole_rows_late]
                # More of the run distinguishes more lengths of a step.
                steps = list(self._proposals.with_other_steps(begun[0])) if before else []
                steps = self._nearest(steps, 1, self._slopes(begun[0]))
                begun = list(dict.fromkeys((*begun[:1], *late, *steps, *begun[1:])))
                # A free translation is as good as a start velocity or an acceleration of any size.
                single = _distinct([c for c in self._single.get(until, []) if not _is_free_translation(c)])
                whole = min(self._fitted(known).weight for known in self._known)
                nearly, half = ([c.mistakes for c in single if c.score < share * whole] for share in (NEARLY, HALF))
                then = [c.mistakes for c in single[:SINGLE]]
                turning = list(filter(self._turns, half[:KEPT]))
                rest = (each for each in then if each not in turning and self._turns(each))
                # What the first row shows may have several reasons, each of which explains little alone.
                first = () if before else chain(self._own_conventions(begun[0]), begun[1:], self._spun_up())
                pairs = () if before else self._pairs(begun[0])
                others = chain(first, self._same_before(begun[0], before), turning, pairs, rest)
                pool = self._explored([*begun, *nearly[:KEPT], *self._known], others)
                pool = self._swapped(pool, alike)
                if not pool[0].is_whole or _is_free_translation(pool[0]):
                    pool = self._named(pool, then)
                if not pool[0].is_whole:
                    pool = self._changed_at_once(pool)
                alike = [c.mistakes for c in _distinct(pool)[:SWAPPED]]
                # Later, a linear law may be better than the one that the first rows are nearest to.
                alike += [self._fitted(each).mistakes for each in self._proposals.with_plain_damping(alike[0])]
                before = until
        except SearchStopped:
            self.is_stopped = True
        finally:
            self.look_at_all()
        return [*alone[:1], *pool]

    def _shown_at_once(self) -> list[Mistakes]:
        """Return programs with what the first rows show by themselves: how late they are, and where the body starts.

        Each explains the first row, if one mistake does.
        """
        late = self._evaluator.lateness
        if late:
            self._known = self._proposals.late(late)
        elif between := self._evaluator.first_motion:
            programs = self._proposals.begins_between(*between)
            self._begin(self._horizons()[0])
            lags = (each for each in programs if each[0].hypothesis.name == LOG_LAG)
            self._whole_rows_late = [each for each in lags if abs(each[0].value - between[0]) <= NEAR * between[0]]
            self._known = [*dict.fromkeys((*self._nearest(programs, KEPT), *self._whole_rows_late)), ()]
        self._look_at(float(self._sample.times[0]))
        return [each for known in self._known for each in self._explaining_first_row(known)]

    def _spun_up(self) -> list[Mistakes]:
        """Return programs with a mistake that turns the body so fast that steps hide it, if rows turn as far."""
        fastest, least = self._simulations.fastest, LONG / self._context.spacing_s
        if max(self._reached["spin"], default=0.0) < least:
            return []
        least = max(least, FASTER * fastest(())["spin"])
        named = [(Mistake(h),) for h in self._proposals.hypotheses if not (h.values or h.needs_steps)]
        return [program for program in named if fastest(program)["spin"] > least]

    def _own_conventions(self, mistakes: Mistakes) -> Iterator[Mistakes]:
        """Yield the best program that reads and writes attitudes by its own convention, if that explains most.

        The first row does not show that.  mistakes: those of the program that these are added to.
        """
        both = product(self._plainly_wrong({"start attitude"}, CHOICES), self._plainly_wrong(CONVENTIONS, MOST_CHOICES))
        if not (programs := [self._proposals.ordered((*mistakes, *each)) for each in both]):
            return
        first_row, _ = self._fine_and_coarse(float(self._sample.times[0]))
        left = np.abs(first_row.errors(programs)).max(axis=(1, 2, 3))
        likely = [program for program, wrong in zip(programs, left.tolist(), strict=True) if wrong <= RIGHT]
        most = HALF * self._profiled([mistakes])[0]
        yield from (each for each in self._nearest(likely, 1) if self._profiled([each])[0] < most)

    def _pairs(self, mistakes: Mistakes) -> Iterator[Mistakes]:
        """Yield the best program with two more mistakes of the rotation, if they help much more together than alone.

        Each may hide the other.  mistakes: those of the program that they are added to.
        """
        hopeless = self._hopeless(())
        ones = [one for one in self._plainly_wrong(ENTANGLED, CHOICES) if one.hypothesis not in hopeless]
        caps = [h for h in self._proposals.hypotheses if "spin" in h.limits and not h.needs_steps]
        ones += [Mistake(cap, value) for cap in caps for value in self._reached[cap.limits]]
        both = combinations(ones, 2)
        wanted = [each for each in both if each[0].hypothesis.part != each[1].hypothesis.part]
        programs = [self._proposals.ordered((*mistakes, *each)) for each in wanted]
        alone = [self._proposals.ordered((*mistakes, one)) for one in ones]
        scores = self._screened(mistakes, [*alone, *programs], NO_SLOPES)
        least, scores = scores[: len(alone)].min(initial=np.inf), scores[len(alone) :]
        if scores.min(initial=np.inf) < least - MUCH:
            yield programs[int(scores.argmin())]

    def _plainly_wrong(self, parts: Container[str], choices: int) -> list[Mistake]:
        """Return the mistakes of some parts of which no value is fitted, with each of at most so many choices."""
        known = (h for h in self._proposals.hypotheses if h.part in parts and not (h.fitted or h.from_data))
        few = (h for h in known if len(h.values) <= choices and not h.needs_steps)
        return [Mistake(h, value) for h in few for value in h.values or (0.0,)]

    def _explaining_first_row(self, mistakes: Mistakes) -> list[Mistakes]:
        """Return programs with one or two more mistakes that explain the first row; the same if it does, or none do."""
        wrong = np.abs(self._simulations.errors([mistakes])).max()
        if wrong <= SHOWN:
            return [mistakes]
        most, begun = max(RIGHT, UNSHOWN * wrong), [mistakes]
        for _ in range(AT_FIRST):
            programs = list(dict.fromkeys(each for one in begun for each in self._with_one_at_once(one)))
            left = np.abs(self._simulations.errors(programs)).max(axis=(1, 2, 3))
            order = np.argsort(left, kind="stable")
            if left[order[0]] <= most:
                return [programs[number] for number in order if left[number] <= most]
            begun = [programs[number] for number in order[:PAIRED]]
        return [mistakes]

    def _with_one_at_once(self, mistakes: Mistakes) -> Iterator[Mistakes]:
        """Yield programs with one more mistake that shows in the first row, of those that are not taken from that."""
        others = {h for h in self._proposals.hypotheses if h.part not in AT_ONCE or h.from_data}
        more = self._proposals.with_one_more(mistakes, self._run(mistakes), True, others)
        return (each for hypothesis, several in more if hypothesis.part in AT_ONCE for each in several)

    def _swapped(self, pool: list[Candidate], alike: Sequence[Mistakes]) -> list[Candidate]:
        """Return programs, best first, and others that were as good before, with what has been added to the first one.

        alike: the programs before, the one first that has been followed; noise may have hidden which one is right.
        """
        before = {m.hypothesis for m in alike[0]}
        added = tuple(m for m in pool[0].mistakes if m.hypothesis not in before)
        swapped = self._joined([each for each in alike[1:] if each], [added]) if added else []
        wanted = dict.fromkeys((*swapped, *self._with_twins(pool)))
        return sorted((*pool, *map(self._fitted, wanted)), key=_enough_first)

    def _with_twins(self, pool: Sequence[Candidate]) -> list[Mistakes]:
        """Return the first program with another mistake in the place of one, where both were seen to do the same."""
        best, found = pool[0].mistakes, []
        known = [(candidate.mistakes, self._misfit(candidate)) for candidate in pool]
        for (one, misfit), (other, own_misfit) in combinations(known, 2):
            if abs(misfit - own_misfit) < SAME and len(one) == len(other):
                for mine, twin in ((one, other), (other, one)):
                    gone, new = [m for m in mine if m not in twin], [m for m in twin if m not in mine]
                    kept = [m for m in best if m.hypothesis not in {m.hypothesis for m in gone}]
                    is_other = len(gone) == 1 and gone[0].hypothesis is not new[0].hypothesis
                    is_free = is_other and new[0].hypothesis.part not in {m.hypothesis.part for m in kept}
                    if is_free and len(kept) == len(best) - 1:
                        found.append(self._proposals.ordered((*kept, *new)))
        return list(dict.fromkeys(found))[:SWAPPED]

    def _next_part(self, before: float, mistakes: Mistakes) -> float:
        """Return until when to look after the part until a time [s]: not far beyond where a program begins to be wrong.

        What grows from there on is soon too large to show the reason.
        """
        horizons = self._horizons()
        following = next(until for until in horizons if until > before)
        if before in horizons:
            self._begin(following)
            seen = self._simulations.shells.first_beyond(self._simulations.errors([mistakes])[0], SHOWN)
            soon = max(BEYOND * seen, seen + ROWS_BEYOND * self._context.spacing_s)
            if before < soon < following / CLOSE and not self._fitted(mistakes).is_whole:
                return soon
        return following

    def beyond(self, mistakes: Mistakes, stops_at: float) -> list[Candidate]:
        """Return programs that are one change after the other away from one, best first, until a processor time [s]."""
        self._stops_at = stops_at
        self._look_at(self._context.duration)
        pool: dict[tuple, Candidate] = {}
        try:
            begun = self._fitted(mistakes)
            self._add(pool, begun)
            self._dived(pool, begun)
        except SearchStopped:
            self.is_stopped = True
        finally:
            self.look_at_all()
        return sorted(pool.values(), key=_by_score)

    def closest(self, programs: Sequence[Mistakes], count: int) -> list[Mistakes]:
        """Return so many programs that leave least of all of the run, best first.  Raises SearchStopped."""
        try:
            for until in dict.fromkeys((self._horizons()[0], self._context.duration)):
                self._look_at(until)
                weights = self._profiled(programs)
                order = np.argsort(weights, kind="stable")
                alike = int((weights < weights.min(initial=np.inf) + 2 * ALIKE).sum())
                programs = [programs[n] for n in order[: max(FOLLOWED, alike)]]
        finally:
            self._look_at(self._context.duration)
        return list(programs[:count])

    def is_near(self, mistakes: Mistakes, other: Mistakes) -> bool:
        """Return whether what a program leaves of the run is small enough to look at it more closely.

        It is if it is nearly within the floor, or nearly what another one leaves that has been looked at.
        """
        shells, (own, known) = self._simulations.shells, self._simulations.errors([mistakes, other])
        return shells.is_near(own) or float(shells.squares(own[None]).max()) <= ALIKE_SQUARES * float(
            shells.squares(known[None]).max()
        )

    def is_far(self, mistakes: Mistakes) -> bool:
        """Return whether mistakes leave much of all of the run, even with values as a linear estimate has them."""
        self._fit.is_free = False
        errors, slopes = self._simulations.errors([mistakes]), self._slopes(mistakes)
        left = self._left(errors, slopes) if len(slopes) else errors
        return float(self._simulations.shells.squares(left).max()) > FAR**2

    def refitted(self, mistakes: Mistakes) -> Mistakes:
        """Return mistakes with values fitted to all of the run."""
        self._fit.is_free = False
        return self._fit.fitted(mistakes).mistakes

    def alternatives(self, mistakes: Mistakes) -> list[Mistakes]:
        """Return programs that fit as well as one, best first.

        They have a change, another scheme in the place of a mistake, or one mistake in the place of two or of all.
        """
        self._fit.is_free = False
        least = self._fitted(mistakes).weight
        weights: dict[Mistakes, float] = {}
        stops_at = self._stops_at
        self.stop_at((now := search_clock()) + PROFILED * (stops_at - now))
        all_changed = False
        try:
            for programs in self._one_changed(mistakes):
                weights |= self._nearly_as_good(_new_ones(programs, weights, mistakes), mistakes)
            all_changed = True
            for programs in self._one_for_two(mistakes):
                weights |= self._nearly_as_good(_new_ones(programs, weights, mistakes), mistakes)
        except SearchStopped:
            self.is_stopped = self.is_stopped or not all_changed
        finally:
            self.look_at_all()
            self.stop_at(stops_at)
            self._fit.is_free = False
        likely = [m for m in sorted(weights, key=weights.__getitem__)[:LIKELY] if weights[m] < least + 2 * ALIKE]
        # The values of the best one have made the weights too small of programs that do not have all of them.
        nearest = self._nearest_fits(likely, 1, FITTED)
        self._fit.advanced([fit for _, fit in nearest])
        found = sorted(((self._candidate(fit), m) for m, fit in nearest), key=lambda each: each[0].weight)
        # Values that are plain already may be better than those that fit some of the rows best.
        both = [each for best, m in found if best.weight < least + ALIKE for each in (m, best.mistakes)]
        return list(dict.fromkeys(both))

    def _nearly_as_good(self, programs: Sequence[Mistakes], best: Mistakes) -> dict[Mistakes, float]:
        """Return the weights of those programs that may explain more and more of the run as well as the best one."""
        kept, weights, horizons = list(programs), np.empty(0), self._horizons()
        for until in (GLANCE * horizons[0], *horizons):
            self._look_at(until)
            weights = self._profiled(kept, self._slopes(best))
            most = self._simulations.weights([best])[0] + self._cost(best) + 2 * ALIKE
            if until < self._context.duration:
                kept = [program for program, weight in zip(kept, weights, strict=True) if weight < most]
        return dict(zip(kept, weights, strict=True))

    def _one_changed(self, mistakes: Mistakes) -> Iterator[list[Mistakes]]:
        """Yield lists of programs with a change, then with another mistake or scheme in the place of one."""
        run = self._run(mistakes)
        others = [program for _, program in self._proposals.with_others(mistakes, run)]
        without = [tuple(m for m in mistakes if m is not one) for one in _apart_from_steps(mistakes)]
        others += [program for fewer in without for program in self._proposals.with_details(fewer)]
        # What explains a part of anything may stand for another detail.
        named = [tuple(m for m in mistakes if m is not one) for one in mistakes if one.hypothesis.vague]
        others += [program for fewer in named for _, program in self._proposals.with_others(fewer, run)]
        # Where damping is in a step has an effect like that of a longer or a shorter one.
        placed = self._proposals.damped_anywhere(mistakes)
        steps = [program for each in placed for program in self._proposals.with_other_steps(each)]
        yield [*others, *self._proposals.with_same_step(mistakes), *steps]
        for fewer in without:
            yield [each for _, several in self._one_more(fewer) for each in several]
        for fewer in without:  # a scheme has an effect from the first step on
            self._look_at(next(until for until in self._horizons() if self._shows_schemes(until)))
            schemes = self._schemes(fewer)
            self._look_at(self._context.duration)
            yield schemes

    def _shows_schemes(self, until: float) -> bool:
        """Return whether a part of the run has enough rows to distinguish schemes."""
        return until >= min(ENOUGH * self._context.spacing_s, self._context.duration)

    def _one_for_two(self, mistakes: Mistakes) -> Iterator[list[Mistakes]]:
        """Yield lists of programs with one mistake in the place of two."""
        for pair in combinations(_apart_from_steps(mistakes), 2):
            fewer = tuple(m for m in mistakes if m not in pair)
            yield [each for _, several in self._one_more(fewer) for each in several]

    def _same_before(self, mistakes: Mistakes, before: float) -> Iterator[Mistakes]:
        """Yield programs with another mistake in the place of one that are best in the part that is looked at.

        The part before, until a time [s], did not distinguish them from the best one there.
        """
        until = self._until
        if not before or self._is_near(self._fitted(mistakes)):
            return
        without = [tuple(m for m in mistakes if m is not one) for one in _apart_from_steps(mistakes)]
        # What happens in the part that is looked at has no effect before.
        later = [[each for _, several in self._one_more(fewer) for each in several] for fewer in without]
        self._look_at(before)
        found: dict[Mistakes, float] = {}
        most = self._simulations.weights([mistakes])[0] + self._cost(mistakes) + 2 * ALIKE
        for fewer, now in zip(without, later, strict=True):
            before_then = [each for _, several in self._one_more(fewer) for each in several]
            programs = _new_ones([*before_then, *now], found, mistakes)
            weights = self._profiled(programs, self._slopes(mistakes))
            found |= {each: weight for each, weight in zip(programs, weights, strict=True) if weight < most}
        self._begin(until)
        yield from self._nearest(list(found), KEPT, self._slopes(mistakes))

    def _alone(self) -> list[Candidate]:
        """Return the changes each of which explains all rows alone, the best first; none if no change does.

        A change that explains the first rows is followed into more and more of them.
        """
        kept: list[Mistakes] = [()]
        whole: list[Candidate] = []
        until = 0.0
        while until < self._context.duration:
            until = self._next_part(until, kept[0])
            self._look_at(until)
            found = list(filter(self._is_near, map(self._fitted, kept)))
            if not found and kept == [()]:
                every = self._single[until] = sorted(self._expanded(self._fitted(()), ALONE), key=_by_score)
                found = list(filter(self._is_near, every))
            if not found:
                return self._noisy([each.mistakes for each in self._single.get(until, [])])
            found.sort(key=_by_score)
            whole = [candidate for candidate in found if candidate.is_whole]
            kept = [candidate.mistakes for candidate in found[:FITTED]]
        return whole

    def _noisy(self, kept: Sequence[Mistakes]) -> list[Candidate]:
        """Return those of some programs that leave nothing but noise of all rows, best first."""
        self._look_at(self._context.duration)
        return sorted(filter(lambda each: each.is_whole, map(self._fitted, kept[:FITTED])), key=_by_score)

    def _is_near(self, candidate: Candidate) -> bool:
        """Return whether what a program leaves of the rows is small enough to look at more of them."""
        return self._simulations.shells.is_near(self._simulations.errors([candidate.mistakes])[0])

    # --- programs -----------------------------------------------------------------------------------------------------

    def _fitted(self, mistakes: Mistakes) -> Candidate:
        return self._candidate(self._fit.fitted(mistakes))

    def _candidate(self, fit: Fitting) -> Candidate:
        shells, mistakes, errors = self._simulations.shells, fit.mistakes, fit.errors
        cost, is_all = self._cost(mistakes), self._until >= self._context.duration
        is_enough = shells.is_whole(errors)
        is_whole = is_enough or self._is_hidden(mistakes, errors)
        # A mistake that single precision would hide so far may show later.
        is_enough = is_enough or (is_whole and self._evaluator.is_known)
        if is_all and (is_whole or shells.is_near(errors) or shells.is_even(errors)):
            explained = self._evaluator.explain(mistakes)
            is_whole = explained.in_digits <= EXPLAINED if self._is_double else explained.is_whole
            # Rounding of a spin that is taken from attitudes may explain almost anything.
            is_whole = is_whole and (explained.in_common <= EXPLAINED or not self._proposals.recovers(mistakes))
            is_enough = is_whole
        if self._fit.is_free and not is_enough:
            rotation = shells.without_centre(errors)
            is_enough = shells.is_whole(rotation) or (self._evaluator.is_known and self._is_hidden(mistakes, rotation))
        return Candidate(mistakes, fit.weight + cost, fit.score + cost, is_whole, fit.score + cost, is_enough)

    def _is_hidden(self, mistakes: Mistakes, errors: Array) -> bool:
        """Return whether single precision, which a program may have, hides its residuals, (T, K, 3)."""
        shells = self._simulations.shells
        if self._is_double or not shells.is_near(errors) or self._proposals.recovers(mistakes):
            return False
        return self._evaluator.is_within_floor(mistakes, errors, shells.times, shells.floors_m)

    def _explored(
        self, begun: Sequence[Mistakes], then: Iterable[Mistakes] = (), most_dives: int = MOST_DIVES
    ) -> list[Candidate]:
        """Return programs, best first: the best of some, and what one change after the other makes of it.

        If that leads nowhere, others are tried, and then other first changes.
        """
        pool: dict[tuple, Candidate] = {}
        for candidate in map(self._fitted, dict.fromkeys(begun)):
            self._add(pool, candidate)
        try:
            others = self._dived(pool, min(pool.values(), key=_by_rank))[:DIVES]
            begun_at = max(c.score for c in pool.values())
            # Where the translation needs a name, the second best next step of what explains the rest is likelier than
            # what explains most alone.
            next_best = [] if self._fit.is_free else [c for c in others[:1] if not _is_vague(c)]
            waiting = chain(next_best, map(self._fitted, then), others[len(next_best) :])
            for dive in range(most_dives):
                best = min(pool.values(), key=_enough_first)
                # A vague translation explains anything: what has a name is tried before it is believed.
                is_believed = self._fit.is_free or not _is_vague(best) or dive >= DIVES
                if is_believed and (best.is_enough or best.is_whole or self._is_nearly(best, begun_at)):
                    break
                other = next(waiting, None) or _new(pool.values())
                if other is None:
                    break
                self._dived(pool, self._add(pool, other))
        except SearchStopped:
            self.is_stopped = True
        return sorted(pool.values(), key=_enough_first)

    def _is_nearly(self, best: Candidate, begun_at: float) -> bool:
        """Return whether a program explains so much of a part of the run that more of the run is looked at.

        It does if little is left of the score that it began at; or if nothing helps any more, and single precision may
        have caused the rest.
        """
        if self._until >= self._context.duration:
            return False
        return best.score < NEARLY * begun_at or (best.is_expanded and self._is_near(best))

    def _dived(self, pool: dict[tuple, Candidate], chosen: Candidate) -> list[Candidate]:
        """Add what one change after the other makes of a program, as long as that helps; return its other children."""
        others: list[Candidate] | None = None
        while not chosen.is_enough and not chosen.is_expanded and len(chosen.mistakes) < MOST_MISTAKES:
            chosen.is_expanded = True
            found = sorted(self._expanded(chosen), key=_by_rank)
            found = [self._add(pool, child) for child in found]
            if others is None:
                others = _distinct(found)[1:]
            new = next((c for c in found if not c.is_expanded), None)
            if new is None or chosen.rank - new.rank < self._much:
                break
            chosen = self._simpler(pool, new)
        return others or []

    @property
    def _much(self) -> float:
        """What one more mistake must gain."""
        return MUCH if self._until < self._context.duration else ALIKE

    def _named(self, pool: list[Candidate], single: Sequence[Mistakes]) -> list[Candidate]:
        """Return the programs and others, in which mistakes with a name have replaced a free translation.

        single: changes that explain most alone, also of the translation.
        """
        self._fit.is_free = False
        try:
            turned = [c for c in pool[:KEPT] if c.is_enough]  # only the translation is to be explained
            begun = [tuple(m for m in c.mistakes if not _frees_translation(m)) for c in turned or pool[:KEPT]]
            if turned:
                # What explained the translation of fewer rows may be wrong.
                anew = tuple(filter(self._acts_on_rotation, begun[0]))
                moved = self._moved_otherwise(begun[0])
                named = self._explored([*moved, *begun, *self._joined(begun, single)], [anew, *single])
            else:
                named = self._explored([*begun, *single, *self._known], most_dives=1)
            return sorted((*pool, *named), key=lambda c: c.weight)
        finally:
            self._fit.is_free = True

    def _moved_otherwise(self, mistakes: Mistakes) -> list[Mistakes]:
        """Return the best programs in the same steps whose centre moves otherwise, if the steps do not explain that.

        They may have linear damping as well, or gravity of another size.
        """
        found = [] if self._fitted(mistakes).is_enough else self._proposals.with_other_centres(mistakes)
        if not (found := self._turning_as_well(mistakes, list(dict.fromkeys(found)))):
            return []
        taken, errors = {m.hypothesis.part for m in mistakes}, self._simulations.errors([mistakes])[0]
        sizes = [h for h in self._proposals.hypotheses if h.name == GRAVITY_SIZE and h.part not in taken]
        sized = [(self._proposals.ordered((*mistakes, Mistake(h, 1.0))), h) for h in sizes]
        slopes = np.concatenate((self._slopes(mistakes), *self._fit.directions_of(sized, errors)))
        tried = self._nearest(found, MOVED, slopes)
        linear = self._proposals.damping("linear", mistakes)
        if linear.part not in taken:
            # How fast it is depends on the rest too much to be estimated once for all.
            damped = self._proposals.ordered((*mistakes, Mistake(linear, USUAL_RATE)))
            several = self._turning_as_well(damped, list(self._proposals.with_other_centres(damped, in_parts=False)))
            tried += [program for program, _ in self._nearest_fits(several, 1, MOVED)]
        every = [
            self._proposals.ordered((*one, *(Mistake(h, 1.0) for h in some))) for one in tried for some in ((), sizes)
        ]
        nearest = self._nearest_fits(list(dict.fromkeys(every)), FIRST_STEPS, KEPT)
        # Of what leaves more, the next change is better sought one by one.
        return [fit.mistakes for _, fit in nearest if self._candidate(fit).is_enough]

    def _joined(self, several: Sequence[Mistakes], others: Sequence[Mistakes]) -> list[Mistakes]:
        """Return each of some programs with the mistakes of each of others, where those are of other parts."""
        found = []
        for one, other in product(several, others):
            if {m.hypothesis.part for m in one}.isdisjoint(m.hypothesis.part for m in other):
                found.append(self._proposals.ordered((*one, *other)))
        return found

    def _changed_at_once(self, pool: list[Candidate]) -> list[Candidate]:
        """Return the programs and others, with another law, another scheme and another place of damping than the first.

        Each of these changes alone may help little.
        """
        self._fit.is_free = False
        try:
            found = [self._fitted(each) for each in self._damped_otherwise(pool[0].mistakes)]
            return sorted((*pool, *found), key=_enough_first)
        finally:
            self._fit.is_free = True

    def _add(self, pool: dict[tuple, Candidate], child: Candidate) -> Candidate:
        """Add a candidate to a pool, and return the one of the same mistakes that is kept."""
        key = tuple(
            (m.hypothesis.name, m.hypothesis.text, 0.0 if m.hypothesis.fitted else m.value) for m in child.mistakes
        )
        known = pool.setdefault(key, child)
        if child.score < known.score:
            child.is_expanded = known.is_expanded and child.score > known.score - ALIKE
            pool[key] = known = child
        # A mistake may have no effect, or that of another one, in the part that is looked at.
        known.is_expanded = known.is_expanded or any(
            c.is_expanded
            and (_names(c) <= _names(known) or len(c.mistakes) == len(known.mistakes))
            and abs(self._misfit(c) - self._misfit(known)) < SAME
            for c in pool.values()
        )
        return known

    def _misfit(self, candidate: Candidate) -> float:
        """Return the score of what a program leaves, without the cost of assumptions."""
        return candidate.score - self._cost(candidate.mistakes)

    def _simpler(self, pool: dict[tuple, Candidate], candidate: Candidate) -> Candidate:
        """Return a program, or a better one with fewer mistakes."""
        for one in candidate.mistakes:
            fewer = self._fitted(tuple(m for m in candidate.mistakes if m is not one))
            if fewer.weight <= candidate.weight and fewer.score <= candidate.score:
                fewer.rank = candidate.rank
                return self._simpler(pool, self._add(pool, fewer))
        return candidate

    # --- what comes next ----------------------------------------------------------------------------------------------

    def _expanded(self, candidate: Candidate, count: int = FITTED) -> list[Candidate]:
        """Return the programs that are a change, or another scheme, away from one and fit best, fitted.

        count: of changes that may be fitted; if it is larger than usual, more first values are tried.
        """
        mistakes = candidate.mistakes
        run = self._run(mistakes)
        slopes = self._slopes(mistakes)
        programs: list[Mistakes] = []
        owners: list[object] = []
        shares: list[float] = []
        for hypothesis, several in self._one_more(mistakes, count > FITTED):
            programs += several
            owners += [hypothesis] * len(several)
            shares += [_share_of(hypothesis)] * len(several)
        for hypothesis, several in self._with_other_laws(mistakes):
            programs += several
            owners += [("law", hypothesis)] * len(several)
            shares += [1.0] * len(several)
        for key, program in self._proposals.with_others(mistakes, run):
            programs.append(program)
            owners.append(key)
            shares.append(1.0)
        counted = np.array(shares)
        ranks = candidate.rank - counted * (candidate.score - self._screened(mistakes, programs, slopes))
        best = {programs[number]: shares[number] for number in best_of_each(owners, ranks)[:count]}
        children = self._children(candidate, best)
        # Most programs that have a scheme keep it where another change explains much; not where single precision would
        # explain what is left, of which most is a detail of a scheme.
        gained = max((candidate.rank - child.rank for child in children), default=0.0)
        helps = gained >= self._much
        if helps and gained >= DECISIVE * candidate.score and _has_scheme(mistakes) and not self._is_double:
            return children
        schemes = self._schemes(mistakes, HOPED if helps else 0.0)
        children += self._children(candidate, dict.fromkeys(schemes, 1.0))
        best = min(children, key=_by_rank, default=candidate)
        if _is_newly_damped(best.mistakes, mistakes):
            # Which scheme fits best was seen beside what damping does in proportion only.
            others = [each for each in self._schemes(best.mistakes, 0.0) if each not in schemes]
            children += self._children(candidate, dict.fromkeys(others, 1.0))
        return children

    def _children(self, candidate: Candidate, programs: Mapping[Mistakes, float]) -> list[Candidate]:
        """Return the best of some programs, fitted, each with the share of what it gains that counts."""
        nearest, found = self._nearest_fits(list(programs), FIRST_STEPS, LIKELIEST), list[Candidate]()
        self._fit.advanced([fit for _, fit in nearest])
        for program, fit in nearest:
            child = self._candidate(fit)
            child.rank = candidate.rank - programs[program] * (candidate.score - child.score)
            found.append(child)
        return found


def _new_ones(programs: Iterable[Mistakes], known: Container[Mistakes], best: Mistakes) -> list[Mistakes]:
    return list(dict.fromkeys(program for program in programs if program != best and program not in known))


def _apart_from_steps(mistakes: Mistakes) -> Mistakes:
    return tuple(m for m in mistakes if m.hypothesis.part != STEPS)


def _has_scheme(mistakes: Mistakes) -> bool:
    return any(m.hypothesis.part == STEPS for m in mistakes)


def _is_newly_damped(mistakes: Mistakes, before: Mistakes) -> bool:
    """Return whether a program has a scheme and damping, and another one no damping."""
    now, then = (any(m.hypothesis.part in DAMPED for m in each) for each in (mistakes, before))
    return now and not then and _has_scheme(mistakes)


def _is_vague(candidate: Candidate) -> bool:
    return any(m.hypothesis.vague for m in candidate.mistakes)


def _is_free_translation(candidate: Candidate) -> bool:
    return any(map(_frees_translation, candidate.mistakes))


def _frees_translation(mistake: Mistake) -> bool:
    return mistake.hypothesis.vague and mistake.hypothesis.part in TRANSLATION


def _by_rank(candidate: Candidate) -> float:
    return candidate.rank


def _by_score(candidate: Candidate) -> float:
    return candidate.score


def _enough_first(candidate: Candidate) -> tuple[bool, float]:
    return not candidate.is_enough, candidate.score


def _share_of(hypothesis: Hypothesis) -> float:
    """Return the share of what a mistake gains that counts."""
    if hypothesis.scale:
        return VAGUE
    return VALUED if hypothesis.fitted else 1.0


def _new(candidates: Collection[Candidate]) -> Candidate | None:
    """Return the candidate with the best rank of those whose names no expanded one has; None if there is none."""
    known = {_names(c) for c in candidates if c.is_expanded}
    return min((c for c in candidates if _names(c) not in known), key=_by_rank, default=None)


def _names(candidate: Candidate) -> frozenset[str]:
    return frozenset(m.hypothesis.name for m in candidate.mistakes)


def _distinct(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Return candidates without those that have the same names as one before."""
    found: dict[frozenset[str], Candidate] = {}
    for candidate in candidates:
        found.setdefault(_names(candidate), candidate)
    return list(found.values())
