"""Programs that are a change away from one: their values and the length of their steps are near the best ones."""

from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from tumble.compare.grade.hypotheses.explanation import Mistake, Mistakes
from tumble.compare.grade.hypotheses.hypothesis import Hypothesis
from tumble.compare.grade.measure.significance import ALIKE, ResidualScale
from tumble.compare.grade.search.evaluator import Evaluator
from tumble.compare.grade.search.kernels import first_alike
from tumble.compare.grade.search.least_squares import Fitting
from tumble.compare.grade.search.parts import Parts
from tumble.compare.grade.search.proposals import (
    DAMPED,
    MOST_STEPS,
    OF_METHODS,
    STEPS,
    Proposals,
    Run,
    SchemeKind,
)
from tumble.compare.grade.search.shells import finite
from tumble.scenarios.frames import Array

# Schemes that are fitted, of all that are tried, and those that may be among them.
SCHEMES, HOPEFUL = 6, 24
# Schemes of which damping is tried at each place in the step, and those of which other details are tried.
PLACED, DETAILED = 32, 10
# Schemes, the best ones, of which one shows which damping helps.
MAY_BE_DAMPED = 3
# Schemes and places of a law of damping that are fitted.
EACH_LAW = 8
# Radians in a step from which the length of the right one is estimated.
SHORT = 0.3
# Share of the effect of a step from which the length of the right one is estimated, below which that is far off.
FAR_OFF = 0.1
# Radians in a step from which errors grow in no order.
LONG = 1.0
# Residuals in floors of rows that are right; effects that cannot be seen, and that can; and one as good as infinite.
RIGHT, UNSEEN, SEEN = 3.0, 1e-3, 10.0
HUGE = 1e12
# Schemes whose effects differ by a smaller share of what is left are one, until less is left.
SAME_EFFECT = 0.01


class Effects(NamedTuple):
    """What values of a mistake do to the centre and to the rotation of a right program.

    acts: whether one of them does anything; shows_at_once: whether each of them can be seen in the first row; (2,).
    """

    acts: np.ndarray
    shows_at_once: np.ndarray


class Changes(Parts):
    """Finds programs that are a change away from one, in the part of the run that is looked at."""

    def __init__(self, evaluator: Evaluator, scale: ResidualScale) -> None:
        super().__init__(evaluator, scale)
        self.proposals = self._proposals = Proposals(evaluator.context, evaluator.hypotheses)

    def _run(self, mistakes: Mistakes) -> Run:
        return Run(
            self._until, self._context.spacing_s, self._simulations.fastest(mistakes), self._reached, self._rests_from
        )

    def _one_more(self, mistakes: Mistakes, every_value: bool = False) -> list[tuple[Hypothesis, list[Mistakes]]]:
        """Return each mistake that can be added, and programs with its first values, and better ones."""
        run, hopeless = self._run(mistakes), self._hopeless(mistakes)
        more = list(self._proposals.with_one_more(mistakes, run, every_value, hopeless))
        linear = [(several[0], hypothesis) for hypothesis, several in more if _is_linear(hypothesis)]
        return more + self._solved(linear, self._slopes(mistakes), self._simulations.errors([mistakes])[0])

    def _hopeless(self, mistakes: Mistakes) -> set[Hypothesis]:
        """Return mistakes that cannot improve a program.

        They are those of the centre alone while its translation is free, those of the rotation alone if that is right,
        and those that would show in the first row if that is right.
        """
        shells, errors = self._simulations.shells, self._simulations.errors([mistakes])
        starts_right = np.array([np.abs(part[:, 0]).max() <= RIGHT for part in shells.parts(errors)])
        looked_at = wanted = np.array((not self._fit.is_free, True))
        if self._turns_right([mistakes])[0]:
            wanted = looked_at & (True, False)
        return {
            hypothesis
            for hypothesis, (acts, shows_at_once) in self._effects.items()
            if acts.any() and (not (acts & wanted).any() or (shows_at_once & starts_right & looked_at).any())
        }

    def _turns_right(self, programs: Sequence[Mistakes]) -> list[bool]:
        """Return whether the rotation of programs is right."""
        shells = self._simulations.shells
        return [shells.is_whole(shells.without_centre(errors)) for errors in self._simulations.errors(programs)]

    def _turning_as_well(self, mistakes: Mistakes, programs: Sequence[Mistakes]) -> list[Mistakes]:
        """Return programs whose rotation is right if that of a program is; all of them if it is not."""
        if not programs or not self._turns_right([mistakes])[0]:
            return list(programs)
        turn_right = self._turns_right(programs)
        return [program for program, is_right in zip(programs, turn_right, strict=True) if is_right]

    def _turns(self, mistakes: Mistakes) -> bool:
        """Return whether some of the mistakes act on the rotation, as far as that is known."""
        return any(map(self._acts_on_rotation, mistakes))

    def _acts_on_rotation(self, mistake: Mistake) -> bool:
        return mistake.hypothesis not in self._effects or bool(self._effects[mistake.hypothesis].acts[1])

    @cached_property
    def _effects(self) -> dict[Hypothesis, Effects]:
        """What mistakes do to a right program in the first part of the run."""
        _, simulations = self._fine_and_coarse(self._horizons()[0])
        shells, right = simulations.shells, simulations.errors([()])
        more = list(self._proposals.with_one_more((), self._run(()))) if shells.is_pose else []
        tried = {hypothesis: several for hypothesis, several in more if several}
        if not tried:
            return {}
        every = simulations.errors([program for several in tried.values() for program in several])
        with np.errstate(all="ignore"):  # a run that diverged
            moved = np.abs(every - right)
        largest = np.array([(part.max(axis=(1, 2, 3)), part[:, 0].max(axis=(1, 2))) for part in shells.parts(moved)])
        anywhere, at_once = np.nan_to_num(largest, nan=np.inf).swapaxes(0, 1)
        begins = np.cumsum([0, *map(len, tried.values())])[:-1]
        most, least_at_once = np.maximum.reduceat(anywhere, begins, 1), np.minimum.reduceat(at_once, begins, 1)
        return dict(zip(tried, map(Effects, (most > UNSEEN).T, (least_at_once > SEEN).T), strict=True))

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

    def _with_other_laws(self, mistakes: Mistakes) -> list[tuple[Hypothesis, list[Mistakes]]]:
        """Return each other law by which a program may be damped, and programs with it and its best values."""
        found = []
        for damping in (m for m in mistakes if m.hypothesis.part in DAMPED):
            fewer = tuple(m for m in mistakes if m is not damping)
            laws = self._proposals.other_laws(damping.hypothesis, mistakes)
            wanted = [(self._proposals.ordered((*fewer, Mistake(law, law.neutral))), law) for law in laws]
            found += self._solved(wanted, self._slopes(fewer), self._simulations.errors([fewer])[0])
        return found

    def _damped_otherwise(self, mistakes: Mistakes) -> list[Mistakes]:
        """Return the best programs with another law of damping, at any place in the same step of any scheme."""
        parts = {m.hypothesis.part for m in mistakes}
        if STEPS not in parts or parts.isdisjoint(DAMPED):
            return []
        programs, likely = [mistakes], list[Mistakes]()
        for _, several in self._with_other_laws(mistakes):
            programs += [fit.mistakes for _, fit in self._nearest_fits(several, 1, 1)]
        for program in programs:
            schemes = self._proposals.with_same_step(program)
            every = list(dict.fromkeys(each for one in schemes for each in self._proposals.damped_anywhere(one)))
            order = np.argsort(self._profiled(every, self._slopes(program)), kind="stable")
            likely += [every[number] for number in order[:EACH_LAW]]
        return self._best_fitted(likely)

    def _schemes(self, mistakes: Mistakes, hoped: float = 0.0) -> list[Mistakes]:
        """Return the best schemes for mistakes; none if they seem to gain less than is hoped."""
        tried = self._upon_steps(mistakes, hoped)
        turning = set(self._turning_as_well(mistakes, [program for _, program in tried]))
        tried = [(kind, program) for kind, program in tried if program in turning]
        if not tried:  # no step is short enough, or leaves a right rotation right
            return []
        slopes = self._all_slopes(mistakes, self._damping_kinds)
        scores = self._profiled([program for _, program in tried], slopes)
        likely = [tried[number][1] for number in best_of_each([kind.key for kind, _ in tried], scores)]
        detailed = [each for one in likely[:DETAILED] for each in self._proposals.with_details(one)]
        ticks = [each for one in likely[:PLACED] for each in self._proposals.with_other_ticks(one)]
        every = self._turning_as_well(mistakes, list(dict.fromkeys((*likely[:PLACED], *detailed, *ticks))))
        damped = self._turning_as_well(mistakes, self._damped(likely[:PLACED]))
        # What linear damping would explain counts for those that have it.
        some = slopes if self._fit.is_free else self._all_slopes(mistakes, ("angular",))
        scores = np.concatenate((self._profiled(every, some), self._profiled(damped, slopes)))
        every += damped
        found = self._best_fitted([every[number] for number in np.argsort(scores, kind="stable")[:HOPEFUL]])
        without = [tuple(m for m in one if not m.hypothesis.vague) for one in found]
        return [*found, *without]

    def _best_fitted(self, programs: Sequence[Mistakes]) -> list[Mistakes]:
        """Return the best of some programs after a step of a fit: their values were fitted to another scheme."""
        return [fit.mistakes for _, fit in self._nearest_fits(programs, 1, SCHEMES)]

    def _nearest_fits(self, programs: Sequence[Mistakes], steps: int, count: int) -> list[tuple[Mistakes, Fitting]]:
        """Return so many programs and their fits, those with the best scores after some steps, best first."""
        fits = self._fit.advanced(self._fit.begun(programs), steps)
        every = zip(programs, fits, strict=True)
        return sorted(every, key=lambda each: each[1].score + self._cost(each[0]))[:count]

    def _upon_steps(self, mistakes: Mistakes, hoped: float = 0.0) -> list[tuple[SchemeKind, Mistakes]]:
        """Return each kind of scheme with steps that may be right, and the program that it makes.

        Errors of steps grow with a power of their length, so one length shows which would fit best, and what it would
        gain: none are returned if that is less than is hoped.
        """
        kinds = list(self._proposals.with_other_schemes(mistakes))
        spin = self._simulations.fastest(mistakes)["spin"]
        turn_s = min(self._context.turn_s, 1 / spin if spin else np.inf)
        first = self._proposals.first_step(mistakes, self._until, SHORT * turn_s)
        if not first:
            return []
        programs = [self._upon(kind, first) for kind in kinds]
        found = self._simulations.errors(programs)
        distinct = self._distinct(programs, found, self._simulations.errors([mistakes]))
        wanted = [(kinds[number], programs[number]) for number in distinct]
        ideals: dict[int, set[float]] = {}
        gained = 0.0
        for others in dict.fromkeys(kinds[number].others for number in distinct):
            same = [number for number in distinct if kinds[number].others == others]
            upon = self._proposals.ordered(others)
            errors, slopes = self._simulations.errors([upon]), self._all_slopes(upon, self._damping_kinds)
            own = self._shares(found[same], errors, slopes)
            those = [kinds[number] for number in same]
            ideals.update(zip(same, self._ideals(those, first, own, errors, slopes), strict=True))
            if hoped:
                gained = max(gained, self._gain(found[same], errors, slopes, own))
        # Errors of steps in which the body turns far grow in no order; there, w from attitudes looks like damping.
        long = self._proposals.long_steps(mistakes, self._until, LONG * turn_s)
        tried = [
            (kind, self._upon(kind, s)) for kind in kinds if not self._proposals.recovers(kind.others) for s in long
        ]
        # Methods that agree in short steps differ most in these.
        fewer = self._proposals.long_steps(mistakes, self._until, LONG * turn_s, OF_METHODS)
        tried += [(kind, self._upon(kind, s)) for kind in filter(self._proposals.is_method, kinds) for s in fewer]
        if gained < hoped:
            return tried
        wanted += tried
        for number, own in ideals.items():
            nearest = {s for ideal in own for s in self._proposals.steps_near(mistakes, self._until, ideal)}
            wanted += [
                (kinds[number], self._upon(kinds[number], s)) for s in sorted(nearest) if s != first and s not in long
            ]
        # What happens at a tick does so by leaps: no length of a step follows from another one.
        at_ticks = any(m.hypothesis.at_ticks for m in mistakes)
        steps = [step for step in self._context.parts if at_ticks and step != first]
        steps += [step for step in self._proposals.event_steps(mistakes, first, self._until) if step not in steps]
        classical = [kind for kind in kinds if kind.hypothesis in self._proposals.classical(mistakes)]
        plain = [*filter(self._proposals.is_plain, kinds), *classical]
        wanted += [(kind, self._upon(kind, s)) for kind in plain for s in steps]
        # In the classical method nothing else may be seen of a step: of a limit, which depends on it by leaps, and of
        # what acts elsewhere in a step, where forces are so stiff that a longer step shows nothing of a shorter one.
        if not any(m.hypothesis.limits for m in mistakes):
            classical = [kind for kind in classical if any(m.hypothesis.needs_steps for m in kind.others)]
        short = self._proposals.short_steps(self._until)
        wanted += [(kind, self._upon(kind, s)) for kind in classical for s in short if s != first]
        return wanted

    def _ideals(
        self, kinds: Sequence[SchemeKind], first: float, shares: Sequence[float], errors: Array, slopes: Array
    ) -> list[set[float]]:
        """Return for each kind of scheme lengths of a step [s] that may be right; none if it makes errors larger.

        shares: of its effect in steps of a first length that make errors least; errors, slopes: as in `_shares`.
        """
        # Parts of a scheme have errors of other orders, and a limit has one of order 1 in any method.
        found = [
            {first * share ** (1 / order) for order in {1, kind.order}} if share > 0 else set()
            for kind, share in zip(kinds, shares, strict=True)
        ]
        # A method of high order has no effect of that order where a motion amplifies it to more than can be seen.
        again = [n for n, share in enumerate(shares) if 0 < share < FAR_OFF and self._proposals.is_method(kinds[n])]
        if again:
            steps = [max(min(found[n], key=lambda ideal: abs(ideal - first)), self._until / MOST_STEPS) for n in again]
            left = self._simulations.errors([self._upon(kinds[n], step) for n, step in zip(again, steps, strict=True)])
            for n, step, share in zip(again, steps, self._shares(left, errors, slopes), strict=True):
                found[n] |= {step * share ** (1 / kinds[n].order)} if share > 0 else set()
        return found

    def _distinct(self, programs: Sequence[Mistakes], found: Array, errors: Array) -> list[int]:
        """Return the numbers of programs without those that leave nearly the same as a more likely one.

        found: residuals, (V, T, K, 3); errors: those of the program that they are a change of, (1, T, K, 3): beside
        what these are, a small difference says nothing yet.
        """
        order = np.argsort([self._cost(program) for program in programs], kind="stable")
        with np.errstate(all="ignore"):
            rows = finite(self._simulations.shells.weighted(found[order], errors)).reshape(len(order), -1)
            rows = np.clip(rows, -HUGE, HUGE)
        alike = np.empty(len(order), dtype=int)
        first_alike(rows, SAME_EFFECT**2 * self._simulations.shells.numbers, alike)
        return sorted(order[np.unique(alike)].tolist())

    def _upon(self, kind: SchemeKind, step: float) -> Mistakes:
        others = (_at_a_tick(mistake, step) for mistake in kind.others)
        return self._proposals.ordered((*others, Mistake(kind.hypothesis, step)))

    def _damped(self, several: Sequence[Mistakes]) -> list[Mistakes]:
        """Return schemes with damping at each place in the step, which they have or which helps one of the first.

        What steps do to the translation, and what damping does, may each explain little alone.
        """
        _, added = min((self._helpful_damping(each) for each in several[:MAY_BE_DAMPED]), key=lambda each: each[0])
        if not added and all(m.hypothesis.part != "angular damping" for m in several[0]):
            return []
        programs = [self._proposals.ordered((*one, *added)) for one in several]
        return [each for one in programs for each in self._proposals.damped_anywhere(one)]

    def _helpful_damping(self, program: Mistakes) -> tuple[float, Mistakes]:
        """Return the damping that helps a program, and the weight that it has then."""
        added, weight = list[Mistake](), np.inf
        for kind in self._damping_kinds:
            hypothesis, slopes = self._proposals.damping(kind, program), self._slopes(program)
            damped = self._proposals.ordered((*program, Mistake(hypothesis, 0.0)))
            is_new = all(m.hypothesis.part != hypothesis.part for m in program)
            solved = (
                self._solved([(damped, hypothesis)], slopes, self._simulations.errors([program])[0]) if is_new else []
            )
            tried = [program, *(each for _, ones in solved for each in ones)]
            weights = self._profiled(tried, slopes)
            best = int(np.argmin(weights))
            weight = float(weights[best])
            if weights[0] - weight >= ALIKE:
                program = tried[best]
                added += [m for m in program if m.hypothesis is hypothesis]
        return weight, tuple(added)

    @property
    def _damping_kinds(self) -> tuple[str, ...]:
        """The kinds of damping that have an effect on what is looked at."""
        return ("angular",) if self._fit.is_free else ("linear", "angular")

    def _all_slopes(self, mistakes: Mistakes, kinds: Sequence[str]) -> Array:
        """Return the derivatives by the values that are fitted, and by those of what programs in steps often have.

        kinds: of damping.
        """
        errors = self._simulations.errors([mistakes])[0]
        usual = self._proposals.may_be_of_any_scheme(mistakes, kinds)
        wanted = [(self._proposals.ordered((*mistakes, Mistake(one, 0.0))), one) for one in usual]
        return np.concatenate((self._slopes(mistakes), *self._fit.directions_of(wanted, errors)))

    def _shares(self, found: Array, errors: Array, slopes: Array) -> list[float]:
        """Return the factors on the effects of schemes that make errors least, with what values explain left out.

        found: residuals with each scheme, (V, T, K, 3); errors: those without one, (1, T, K, 3); slopes: derivatives of
        these by values, (P, T, K, 3).
        """
        shells = self._simulations.shells
        with np.errstate(all="ignore"):
            every = finite(np.concatenate((errors, found - errors, slopes)))
            every = np.clip(every, -HUGE, HUGE)
            if self._fit.is_free:
                every = shells.without_translation(every, errors[0])
            every = shells.weighted(every, errors).reshape(len(every), -1)
        own = every[len(every) - len(slopes) :]
        if len(own):
            basis = np.linalg.qr(own.T)[0]
            every = every - (every @ basis) @ basis.T
        effects = every[1 : len(found) + 1]
        sizes = np.einsum("vn,vn->v", effects, effects)
        return (-(effects @ every[0]) / np.where(sizes > 0, sizes, np.inf)).tolist()

    def _gain(self, found: Array, errors: Array, slopes: Array, shares: Sequence[float]) -> float:
        """Return what the best of some schemes gains with its share of its effect, with what values explain left out.

        found, errors, slopes: as in `_shares`.
        """
        factors = np.maximum((0.0, *shares), 0.0)[:, None, None, None]
        with np.errstate(all="ignore"):
            left = errors + factors * finite(np.concatenate((errors, found)) - errors)
        left = self._left(left, slopes) if len(slopes) else left
        scores = self._fit.scored(left)[1]
        return float(scores[0] - scores.min())


def _at_a_tick(mistake: Mistake, step: float) -> Mistake:
    """Return a mistake that takes effect at the nearest tick of a step [s]: no fit passes from one tick to the next."""
    ticks = round(mistake.value / step) if mistake.hypothesis.at_ticks else 0
    return mistake._replace(value=ticks * step) if ticks else mistake


def _is_linear(hypothesis: Hypothesis) -> bool:
    """Return whether a small value of a mistake has an effect in proportion."""
    return bool(hypothesis.scale) or hypothesis.neutral is not None


def best_of_each(owners: Sequence[object], weights: Array) -> list[int]:
    """Return the number of the best program of each owner, best first."""
    found: dict[object, int] = {}
    for number, owner in enumerate(owners):
        best = found.setdefault(owner, number)
        if weights[number] < weights[best]:
            found[owner] = number
    return sorted(found.values(), key=lambda number: weights[number])
