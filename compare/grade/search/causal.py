"""Finds the mistakes of a program in the order in which they show: first in the first rows, then in more and more."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import combinations

import numpy as np

from tumble.compare.grade.hypotheses.explanation import Mistake, Mistakes
from tumble.compare.grade.hypotheses.hypothesis import Hypothesis
from tumble.compare.grade.measure.significance import ALIKE, EXPLAINED
from tumble.compare.grade.search.evaluator import Evaluator
from tumble.compare.grade.search.least_squares import Fit, free_values
from tumble.compare.grade.search.proposals import STEPS, Proposals, Run, SchemeKind
from tumble.compare.grade.search.shells import Shells
from tumble.compare.grade.search.simulations import SearchStopped, Simulations
from tumble.scenarios.frames import Array

# The first part of the run that is looked at: radians, rows; and how much longer each part is than the one before.
RADIANS, SHARE_OF_ALL, FEWEST, LONGER = 4.0, 0.3, 12, 4.0
# Mistakes and schemes that are fitted, of all that are tried.
FITTED, SCHEMES = 10, 6
# Schemes of which damping is tried at each place in the step, and those of which other details are tried.
PLACED, DETAILED = 32, 10
# Single changes that are fitted, before programs with several.
ALONE = 24
# Of these, so many are followed if what seems best leads nowhere.
SINGLE = 2
# Other first changes that are tried if the best one leads nowhere.
DIVES = 3
# Share of the first score that is little enough to look at more of the run.
NEARLY = 0.25
# Programs that are kept from one part of the run to the next.
KEPT = 3
MOST_MISTAKES = 8
# Radians in a step of a continuous run: its error, over the body's size, is ERROR at UNIT, and grows with the fourth
# power; it is to be below a share of the floor.
UNIT, ERROR, OF_FLOOR, FINEST, COARSEST = 0.2, 1e-5, 0.3, 0.02, 0.15
# Share of the time that is left in which others as good as a program are looked for, before they are fitted.
PROFILED = 0.6
# Coarse simulations show what to try next if their errors are below this share of what is off.
SCREENED = 1e-3
# Radians in a step from which the length of the right one is estimated.
SHORT = 0.3
# What one more mistake must gain before all of the run is looked at.
MUCH = 30.0


# Share of what a mistake with a value gains that counts, since any value explains a part of almost anything; and of a
# vague mistake.
VALUED, VAGUE = 0.85, 0.7


# Two programs leave nearly the same if their largest squares differ by no more than this factor.
ALIKE_SQUARES = 9.0
# Residual in floors that is as good as infinite.
HUGE = 1e12


@dataclass(eq=False)
class Candidate:
    """Mistakes, and the information criterion of what they leave with the cost of assumptions.

    weight: of all; score: with a free translation; rank: the score if each mistake had gained only the share of what it
    gained that counts; by it programs are ranked.
    """

    mistakes: Mistakes
    weight: float
    score: float
    is_whole: bool
    rank: float = 0.0
    is_expanded: bool = field(default=False)


class CausalSearch:
    """Searches for the mistakes of the program that wrote some rows; is_double: it is of double precision."""

    def __init__(self, evaluator: Evaluator, is_double: bool = False) -> None:
        self._evaluator, self._is_double = evaluator, is_double
        self._context, self._sample, self._points = evaluator.context, evaluator.rows, evaluator.points
        self._scale, self._cost = evaluator.scale if is_double else evaluator.search_scale, evaluator.cost
        self.proposals = self._proposals = Proposals(evaluator.context, evaluator.hypotheses)
        self._events = np.array([impulse.time for impulse in self._context.program.impulses])
        self._made: dict[float, Simulations] = {}
        self._coarse: dict[float, Simulations] = {}
        self._single: dict[float, list[Candidate]] = {}
        self.is_stopped = False
        self.look_at_all()

    @property
    def trials(self) -> int:
        """The number of simulated programs."""
        every = {*self._made.values(), *self._coarse.values()}
        return sum(simulations.trials for simulations in every)

    def candidates(
        self, stops_at: float, on_progress: Callable[[float], object] = lambda share: None
    ) -> list[Candidate]:
        """Return the best programs, best first.

        stops_at: processor time [s]; on_progress: called with the share that is done.
        """
        self._stops_at = stops_at
        pool, horizons = [Candidate((), 0.0, 0.0, False)], self._horizons()
        try:
            if alone := self._alone(horizons):
                return alone
            for number, until in enumerate(horizons):
                on_progress(number / len(horizons))
                self._begin(until)
                begun = [c.mistakes for c in pool[:KEPT]]
                single = self._single.get(until, [])
                hopeful = [c.mistakes for c in single if c.score < NEARLY * self._fitted(()).score]
                pool = self._explored([*begun, *hopeful[:KEPT]], [c.mistakes for c in single[:SINGLE]])
                if not pool[0].is_whole or any(m.hypothesis.vague for m in pool[0].mistakes):
                    pool = self._named(pool)
        except SearchStopped:
            self.is_stopped = True
        finally:
            self.look_at_all()
        return pool

    def beyond(self, mistakes: Mistakes, stops_at: float) -> list[Candidate]:
        """Return programs that are one change after the other away from one, best first, until a processor time [s]."""
        self._stops_at = stops_at
        self._begin(self._context.duration)
        self._fit.is_free = False
        pool: dict[tuple, Candidate] = {}
        try:
            begun = self._fitted(mistakes)
            begun.rank = begun.score
            self._add(pool, begun)
            self._dived(pool, begun)
        except SearchStopped:
            self.is_stopped = True
        finally:
            self.look_at_all()
        return sorted(pool.values(), key=_by_score)

    def stop_at(self, stops_at: float) -> None:
        """Raise SearchStopped from a processor time on [s]."""
        self._stops_at = self._simulations.stops_at = stops_at

    def look_at_all(self) -> None:
        """Look at all of the run, whatever time that takes."""
        self._stops_at = np.inf
        self._begin(self._context.duration)

    def closest(self, programs: Sequence[Mistakes], count: int) -> list[Mistakes]:
        """Return so many programs that leave least of all of the run, best first."""
        self._fit.is_free = False
        weights = self._profiled(programs, np.empty(0))
        return [programs[n] for n in np.argsort(weights, kind="stable")[:count]]

    def is_near(self, mistakes: Mistakes, other: Mistakes) -> bool:
        """Return whether what a program leaves of the run is small enough to look at it more closely.

        It is if it is nearly within the floor, or nearly what another one leaves that has been looked at.
        """
        shells, (own, known) = self._simulations.shells, self._simulations.errors([mistakes, other])
        return shells.is_near(own) or float(shells.squares(own[None]).max()) <= ALIKE_SQUARES * float(
            shells.squares(known[None]).max()
        )

    def refitted(self, mistakes: Mistakes) -> Mistakes:
        """Return mistakes with values fitted to all of the run."""
        self._fit.is_free = False
        return self._fit.fitted(mistakes)[0]

    def alternatives(self, mistakes: Mistakes) -> list[Mistakes]:
        """Return programs that fit as well as one, best first.

        They have a change, another scheme in the place of a mistake, or one mistake in the place of two or of all.
        """
        self._fit.is_free = False
        slopes, least = self._slopes(mistakes), self._fitted(mistakes).weight
        weights: dict[Mistakes, float] = {}
        stops_at = self._simulations.stops_at
        self._simulations.stop_earlier(PROFILED)
        try:
            for programs in self._one_change_away(mistakes):
                new = list(dict.fromkeys(m for m in programs if m != mistakes and m not in weights))
                weights |= zip(new, self._profiled(new, slopes), strict=True)
        except SearchStopped:
            self.is_stopped = True
        finally:
            self._simulations.stops_at = stops_at
        likely = [m for m in sorted(weights, key=weights.__getitem__)[:FITTED] if weights[m] < least + 2 * ALIKE]
        fits = sorted(((self._fitted(m), m) for m in likely), key=lambda fit: fit[0].weight)
        # Values that are plain already may be better than those that fit some of the rows best.
        both = [each for fit, m in fits if fit.weight < least + ALIKE for each in (m, fit.mistakes)]
        return list(dict.fromkeys(both))

    def _one_change_away(self, mistakes: Mistakes) -> Iterator[list[Mistakes]]:
        """Yield lists of programs: with a change, with one mistake in the place of two, of one, or of all."""
        run = self._run(mistakes)
        others = [program for _, program in self._proposals.with_others(mistakes, run)]
        yield [*others, *self._proposals.with_same_step(mistakes), *self._proposals.with_other_steps(mistakes)]
        kept = [m for m in mistakes if m.hypothesis.part != STEPS]
        pairs = [tuple(m for m in mistakes if m is not one and m is not other) for one, other in combinations(kept, 2)]
        for fewer in dict.fromkeys([*pairs, ()]):
            yield [each for _, several in self._one_more(fewer) for each in several]
        for one in kept:
            fewer = tuple(m for m in mistakes if m is not one)
            yield self._schemes(fewer)
            yield [each for _, several in self._one_more(fewer) for each in several]

    def _horizons(self) -> list[float]:
        duration, spacing = self._context.duration, self._context.spacing_s
        until = max(min(RADIANS * self._context.turn_s, SHARE_OF_ALL * duration), FEWEST * spacing)
        found = []
        while until * 1.5 < duration:
            found.append(until)
            until *= LONGER
        return [*found, duration]

    def _alone(self, horizons: Sequence[float]) -> list[Candidate]:
        """Return the changes each of which explains all rows alone, the best first; none if no change does.

        A change that explains the first rows is followed into more and more of them.
        """
        kept: list[Mistakes] = [()]
        whole: list[Candidate] = []
        for until in horizons:
            self._begin(until)
            self._fit.is_free = False
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
        self._begin(self._context.duration)
        self._fit.is_free = False
        return sorted(filter(lambda each: each.is_whole, map(self._fitted, kept[:FITTED])), key=_by_score)

    def _is_near(self, candidate: Candidate) -> bool:
        """Return whether what a program leaves of the rows is small enough to look at more of them."""
        return self._simulations.shells.is_near(self._simulations.errors([candidate.mistakes])[0])

    def _begin(self, until: float) -> None:
        self._until = until
        if until not in self._made:
            self._made[until], self._coarse[until] = self._simulations_until(until)
        self._simulations = self._made[until]
        self._simulations.stops_at = self._stops_at
        self._fit = Fit(self._simulations)
        self._fit.is_free = True

    def _simulations_until(self, until: float) -> tuple[Simulations, Simulations]:
        """Return fine and coarse simulations until a time [s]."""
        shells = Shells(self._sample, self._scale, self._points, until, self._events)
        floor_m = np.sqrt(3.0) * float(np.median(self._scale.floors_m.min(axis=1)))  # of the axis with most digits
        small = OF_FLOOR * floor_m / (ERROR * self._scale.size_m)
        fineness = float(np.clip(UNIT * small**0.25, FINEST, COARSEST))
        fine = Simulations(self._context, shells, self._stops_at, fineness)
        return fine, Simulations(self._context, shells, self._stops_at, COARSEST) if fineness < COARSEST else fine

    # --- programs -----------------------------------------------------------------------------------------------------

    def _fitted(self, mistakes: Mistakes) -> Candidate:
        mistakes, weight, score = self._fit.fitted(mistakes)
        shells, errors = self._simulations.shells, self._simulations.errors([mistakes])[0]
        cost, is_whole = self._cost(mistakes), shells.is_whole(errors)
        if not is_whole and not self._is_double and shells.is_near(errors):
            is_whole = self._evaluator.is_within_floor(mistakes, errors, shells.times, shells.floors_m)
        is_all = self._until >= self._context.duration
        if is_all and (is_whole or shells.is_near(errors) or shells.is_even(errors)):
            explained = self._evaluator.explain(mistakes)
            is_whole = explained.in_digits <= EXPLAINED if self._is_double else explained.is_whole
        return Candidate(mistakes, weight + cost, score + cost, is_whole)

    def _explored(self, begun: Sequence[Mistakes], then: Sequence[Mistakes] = ()) -> list[Candidate]:
        """Return programs, best first: the best of some, and what one change after the other makes of it.

        If that leads nowhere, others are tried, and then other first changes.
        """
        pool: dict[tuple, Candidate] = {}
        for candidate in map(self._fitted, dict.fromkeys((*begun, ()))):
            candidate.rank = candidate.score
            self._add(pool, candidate)
        try:
            first = self._dived(pool, min(pool.values(), key=_by_rank))
            begun_at = max(c.score for c in pool.values())
            for other in (*map(self._fitted, then), *first[:DIVES]):
                best = min(pool.values(), key=_by_score)
                if best.is_whole or (self._until < self._context.duration and best.score < NEARLY * begun_at):
                    break
                if not other.is_expanded:
                    self._dived(pool, other)
        except SearchStopped:
            self.is_stopped = True
        return sorted(pool.values(), key=_by_score)

    def _dived(self, pool: dict[tuple, Candidate], chosen: Candidate) -> list[Candidate]:
        """Add what one change after the other makes of a program, as long as that helps; return its other children."""
        others: list[Candidate] | None = None
        while not chosen.is_whole and not chosen.is_expanded and len(chosen.mistakes) < MOST_MISTAKES:
            chosen.is_expanded = True
            found = sorted(self._expanded(chosen), key=_by_rank)
            for child in found:
                self._add(pool, child)
            if others is None:
                others = _different(found)
            if not found or chosen.rank - found[0].rank < self._much:
                break
            chosen = self._simpler(pool, found[0])
        return others or []

    @property
    def _much(self) -> float:
        """What one more mistake must gain."""
        return MUCH if self._until < self._context.duration else ALIKE

    def _named(self, pool: list[Candidate]) -> list[Candidate]:
        """Return the programs and others, in which mistakes with a name have replaced a free translation."""
        self._fit.is_free = False
        try:
            begun = [tuple(m for m in c.mistakes if not m.hypothesis.vague) for c in pool[:KEPT]]
            named = self._explored(begun)
            return sorted((*pool, *named), key=lambda c: c.weight)
        finally:
            self._fit.is_free = True

    def _add(self, pool: dict[tuple, Candidate], child: Candidate) -> None:
        key = tuple(
            (m.hypothesis.name, m.hypothesis.text, 0.0 if m.hypothesis.fitted else m.value) for m in child.mistakes
        )
        if child.score < pool.setdefault(key, child).score:
            pool[key] = child

    def _simpler(self, pool: dict[tuple, Candidate], candidate: Candidate) -> Candidate:
        """Return a program, or a better one with fewer mistakes."""
        mistakes = candidate.mistakes
        for number in range(len(mistakes) - 1):
            fewer = self._fitted((*mistakes[:number], *mistakes[number + 1 :]))
            if fewer.weight <= candidate.weight and fewer.score <= candidate.score:
                fewer.rank = candidate.rank
                self._add(pool, fewer)
                return self._simpler(pool, fewer)
        return candidate

    # --- what comes next ----------------------------------------------------------------------------------------------

    def _expanded(self, candidate: Candidate, count: int = FITTED) -> list[Candidate]:
        """Return the programs that are a change away from one and fit best, fitted.

        count: of those that are fitted, apart from schemes; if it is larger than usual, more first values are tried.
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
        for key, program in self._proposals.with_others(mistakes, run):
            programs.append(program)
            owners.append(key)
            shares.append(1.0)
        counted = np.array(shares)
        ranks = candidate.rank - counted * (candidate.score - self._screened(candidate, programs, slopes))
        best = {programs[number]: shares[number] for number in _best(owners, ranks)[:count]}
        best |= dict.fromkeys(self._schemes(mistakes), 1.0)
        if len(best) > 2 * FITTED:
            hopeful = {program: self._fit.fitted(program, 2)[2] + self._cost(program) for program in best}
            best = {program: best[program] for program in sorted(best, key=hopeful.__getitem__)[:FITTED]}
        found = []
        for program, share in best.items():
            child = self._fitted(program)
            child.rank = candidate.rank - share * (candidate.score - child.score)
            found.append(child)
        return found

    def _one_more(self, mistakes: Mistakes, every_value: bool = False) -> list[tuple[Hypothesis, list[Mistakes]]]:
        """Return each mistake that can be added, and programs with its first values, and better ones."""
        more = list(self._proposals.with_one_more(mistakes, self._run(mistakes), every_value))
        linear = [(several[0], hypothesis) for hypothesis, several in more if _is_linear(hypothesis)]
        return more + self._solved(linear, self._slopes(mistakes), self._simulations.errors([mistakes])[0])

    def _run(self, mistakes: Mistakes) -> Run:
        return Run(self._until, self._context.spacing_s, self._simulations.fastest(mistakes))

    def _slopes(self, mistakes: Mistakes) -> Array:
        """Return the derivatives of residuals by the values that are fitted, (P, T, K, 3)."""
        errors = self._simulations.errors([mistakes])[0]
        free = free_values(mistakes)
        return self._fit.directions(mistakes, free, errors) if free else np.empty((0, *errors.shape))

    def _schemes(self, mistakes: Mistakes) -> list[Mistakes]:
        """Return the best schemes for mistakes.

        Errors of steps grow with a power of their length, so one length shows which would fit best.
        """
        spin = self._simulations.fastest(mistakes)["spin"]
        turn_s = min(self._context.turn_s, 1 / spin if spin else np.inf)
        first = self._proposals.first_step(mistakes, self._until, SHORT * turn_s)
        if not first:
            return []
        kinds = list(self._proposals.with_other_schemes(mistakes))
        programs = [self._upon(kind, first) for kind in kinds]
        found = self._simulations.errors(programs)
        wanted = [(kind, program) for kind, program in zip(kinds, programs, strict=True)]
        for others in dict.fromkeys(kind.others for kind in kinds):
            same = [number for number, kind in enumerate(kinds) if kind.others == others]
            for number, share in zip(same, self._shares(found[same], self._proposals.ordered(others)), strict=True):
                if share <= 0:
                    continue
                # Parts of a scheme have errors of other orders, and a limit has one of order 1 in any method.
                ideals = [first * share ** (1 / order) for order in {1, kinds[number].order}]
                nearest = {s for ideal in ideals for s in self._proposals.steps_near(mistakes, self._until, ideal)}
                wanted += [(kinds[number], self._upon(kinds[number], s)) for s in sorted(nearest) if s != first]
        tried = [program for _, program in wanted]
        slopes = self._all_slopes(mistakes)
        scores = self._profiled(tried, slopes)
        likely = [tried[number] for number in _best([kind.key for kind, _ in wanted], scores)]
        detailed = [each for one in likely[:DETAILED] for each in self._proposals.with_details(one)]
        likely = [*likely[:PLACED], *detailed, *self._damped(likely[:PLACED])]
        scores = self._profiled(likely, slopes)
        found = [likely[number] for number in np.argsort(scores, kind="stable")[:SCHEMES]]
        without = [tuple(m for m in one if not m.hypothesis.vague) for one in found]
        return [*found, *without]

    def _damped(self, several: Sequence[Mistakes]) -> list[Mistakes]:
        """Return schemes with the rotation damped at each place in the step; if it is, by what helps the first one."""
        rates = {m.value for m in several[0] if m.hypothesis.part == "angular damping"}
        if not rates:
            hypothesis = self._proposals.angular_damping(several[0])
            slopes, errors = self._slopes(several[0]), self._simulations.errors([several[0]])[0]
            damped = self._proposals.ordered((*several[0], Mistake(hypothesis, 0.0)))
            solved = self._solved([(damped, hypothesis)], slopes, errors)
            tried = [several[0], *(each for _, ones in solved for each in ones)]
            weights = self._profiled(tried, slopes)
            best = int(np.argmin(weights))
            if weights[0] - weights[best] < ALIKE:
                return []
            rates = {m.value for m in tried[best] if m.hypothesis is hypothesis}
        return [each for one in several for each in self._proposals.damped_anywhere(one, max(rates))]

    def _all_slopes(self, mistakes: Mistakes) -> Array:
        """Return the derivatives by the values that are fitted, and by those of what programs in steps often have."""
        errors = self._simulations.errors([mistakes])[0]
        usual = self._proposals.may_be_of_any_scheme(mistakes)
        wanted = [(self._proposals.ordered((*mistakes, Mistake(one, 0.0))), one) for one in usual]
        return np.concatenate((self._slopes(mistakes), *self._fit.directions_of(wanted, errors)))

    def _shares(self, found: Array, mistakes: Mistakes) -> list[float]:
        """Return the factors on the effects of schemes that make errors least, with what values explain left out.

        found: residuals with each scheme, (V, T, K, 3); mistakes: that it is put upon.
        """
        shells = self._simulations.shells
        errors, slopes = self._simulations.errors([mistakes]), self._all_slopes(mistakes)
        root = np.sqrt(shells.precisions(errors))[..., None]
        with np.errstate(all="ignore"):
            every = np.nan_to_num(np.concatenate((errors, found - errors, slopes)), posinf=0.0, neginf=0.0)
            every = np.clip(every, -HUGE, HUGE)
            if self._fit.is_free:
                every = shells.without_translation(every, errors[0])
            every = (root * every).reshape(len(every), -1)
        own = every[len(every) - len(slopes) :]
        if len(own):
            basis = np.linalg.qr(own.T)[0]
            every = every - (every @ basis) @ basis.T
        effects = every[1 : len(found) + 1]
        sizes = np.einsum("vn,vn->v", effects, effects)
        return (-(effects @ every[0]) / np.where(sizes > 0, sizes, np.inf)).tolist()

    def _upon(self, kind: SchemeKind, step: float) -> Mistakes:
        return self._proposals.ordered((*kind.others, Mistake(kind.hypothesis, step)))

    def _solved(
        self, wanted: Sequence[tuple[Mistakes, Hypothesis]], slopes: Array, errors: Array
    ) -> list[tuple[Hypothesis, list[Mistakes]]]:
        """Return mistakes with better values of one of them, solved for together with the other values.

        wanted: mistakes that leave the same errors, (T, K, 3), and for each the hypothesis of the value.
        """
        owns = self._fit.directions_of(wanted, errors)
        found = []
        for (mistakes, hypothesis), own in zip(wanted, owns, strict=True):
            if own.any():
                steps = self._fit.solutions(np.concatenate((own, slopes)), errors)
                tried = [self._fit.moved(mistakes, [hypothesis], step[: hypothesis.dimension]) for step in steps]
                found.append((hypothesis, list(dict.fromkeys(tried))))
        return found

    def _screened(self, candidate: Candidate, programs: Sequence[Mistakes], slopes: Array) -> Array:
        """Return the scores of programs that are a change away from one; coarsely simulated, if that is far off."""
        fine, coarse = self._simulations, self._coarse[self._until]
        coarse.stops_at = self._stops_at
        errors, others = (each.errors([candidate.mistakes]) for each in (fine, coarse))
        with np.errstate(all="ignore"):  # a run that diverged, or is right
            share = float(np.sqrt(np.square(others - errors).mean() / np.square(errors).mean()))
        return self._profiled(programs, slopes, coarse if share < SCREENED else fine)

    def _profiled(self, programs: Sequence[Mistakes], slopes: Array, simulations: Simulations | None = None) -> Array:
        """Return the scores of programs, with what derivatives, (P, T, K, 3), can explain of each left out."""
        found, simulations = np.empty(len(programs)), simulations or self._simulations
        for begin in range(0, len(programs), 400):
            part = programs[begin : begin + 400]
            errors = simulations.errors(part)
            found[begin : begin + 400] = self._fit.scored(errors)[1]
            if len(slopes):
                left = self._fit.scored(self._left(errors, slopes))[1]
                found[begin : begin + 400] = np.minimum(found[begin : begin + 400], left)
        return found + np.array([self._cost(program) for program in programs])

    def _left(self, errors: Array, slopes: Array) -> Array:
        """Return what derivatives, (P, T, K, 3), leave of residuals, (V, T, K, 3)."""
        shells = self._simulations.shells
        with np.errstate(all="ignore"):
            known, count = np.nan_to_num(errors, posinf=0.0, neginf=0.0), len(slopes)
            if self._fit.is_free:
                median = known[int(np.argsort(shells.weights(known))[len(known) // 8])]
                known, slopes = shells.without_translation(known, median), shells.without_translation(slopes, median)
            rows = shells.precisions(errors).reshape(len(errors), -1)
            products = np.einsum("ptki,qtki->pqtk", slopes, slopes).reshape(count * count, -1)
            normal = (rows @ products.T).reshape(-1, count, count)
            weighted = (known * rows.reshape(*errors.shape[:3])[..., None]).reshape(len(errors), -1)
            right = weighted @ slopes.reshape(count, -1).T
            size = np.einsum("vpp->vp", normal)
            normal = normal + 1e-9 * np.eye(count) * np.where(size > 0, size, 1.0)[:, :, None]
            step = np.linalg.solve(normal, right[:, :, None])[:, :, 0]
            return known - (step @ slopes.reshape(count, -1)).reshape(errors.shape)


def _is_linear(hypothesis: Hypothesis) -> bool:
    """Return whether a small value of a mistake has an effect in proportion."""
    return bool(hypothesis.scale) or hypothesis.neutral is not None


def _by_rank(candidate: Candidate) -> float:
    return candidate.rank


def _by_score(candidate: Candidate) -> float:
    return candidate.score


def _share_of(hypothesis: Hypothesis) -> float:
    """Return the share of what a mistake gains that counts."""
    return VAGUE if hypothesis.vague else VALUED if hypothesis.fitted else 1.0


def _different(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Return candidates without the first and without those that have the same names as one before."""
    seen, found = set[frozenset[str]](), []
    for candidate in candidates:
        names = frozenset(m.hypothesis.name for m in candidate.mistakes)
        if names not in seen:
            found.append(candidate)
        seen.add(names)
    return found[1:]


def _best(owners: Sequence[object], weights: Array) -> list[int]:
    """Return the number of the best program of each owner, best first."""
    found: dict[object, int] = {}
    for number, owner in enumerate(owners):
        best = found.setdefault(owner, number)
        if weights[number] < weights[best]:
            found[owner] = number
    return sorted(found.values(), key=lambda number: weights[number])
