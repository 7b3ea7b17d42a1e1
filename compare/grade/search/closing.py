"""What a search does with the best explanations: simpler ones, values that a person wrote, and others as good."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import cached_property
from itertools import product, takewhile
from math import exp, log

import numpy as np

from tumble.compare.grade.hypotheses.engine_schemes import DAMPING_FORMS, DAMPING_PLACES, GYROSCOPIC, ROTATION
from tumble.compare.grade.hypotheses.explanation import (
    PLAIN,
    TICKS,
    Explanation,
    Mistake,
    Mistakes,
    in_digits,
    with_value,
)
from tumble.compare.grade.hypotheses.hypothesis import Hypothesis
from tumble.compare.grade.hypotheses.mistakes.start import with_fixed_start, with_free_start
from tumble.compare.grade.hypotheses.names import ANGULAR_DAMPING, LINEAR_DAMPING
from tumble.compare.grade.measure.significance import EXPLAINED
from tumble.compare.grade.model.kernel.dynamics import AS_FORCE, LAST, LINEARLY
from tumble.compare.grade.model.program_model import next_tick
from tumble.compare.grade.search.causal import CausalSearch
from tumble.compare.grade.search.clock import search_clock
from tumble.compare.grade.search.evaluator import Evaluator
from tumble.compare.grade.search.proposals import STEPS
from tumble.compare.grade.search.simulations import SearchStopped

# Residuals within the floor, an upper bound of rounding: one is larger if it is this many times another, but not if it
# is below this share of the floor.
LARGER, HIDDEN = 1.5, 0.5
# Residuals over the floor of the printed digits that are nearly within it, over those within it.
NEARLY = 1.5
# A value that a person wrote is likelier than any other: it may leave more.
LARGER_IF_PLAIN = 3.0
# Significant digits of a value that a person wrote, and the largest share of values that are as near to one by chance.
FEW_DIGITS, CHANCE = range(1, PLAIN + 1), 0.03
# Of damping in single precision: roundings of a velocity in a step, of half an eps each: of its factor and product, and
# of the gyroscopic term; and the largest share then.
ROUNDINGS, CHANCE_IF_ROUNDED = 6, 0.1
# So many digits are written by most persons: more are only where they are no chance.
WRITTEN = 2
# Those that distinguish any two values.
MOST_DIGITS = 17
# A factor that differs from 1 by less is suspect.
SUSPECT = 1e-2
# Another scheme is believed beside mistakes with which single precision explains all if it leaves so many times less.
MUCH_LESS = 4.0
# Twice the logarithm of the likelihood that a plainer value may leave less of, beside noise.
NOISIER = 4.0
# Other programs that are simulated finely; those that differ in how they write rows between their ticks.
ALTERNATIVES, WRITINGS = 16, 3


class Closing:
    """Simplifies explanations, until it is stopped; is_stopped: it was."""

    def __init__(self, evaluator: Evaluator, search: CausalSearch) -> None:
        self._evaluator, self._proposals, self._search = evaluator, search.proposals, search
        self._stops_at, self.is_stopped = np.inf, False

    def stop_at(self, stops_at: float) -> None:
        """Set the processor time at which to stop [s]."""
        self._stops_at = stops_at
        self._search.stop_at(stops_at)

    def is_late(self) -> bool:
        """Return whether it is time to stop."""
        is_late = search_clock() > self._stops_at
        self.is_stopped = self.is_stopped or is_late
        return is_late

    def simplified(self, best: Explanation) -> Explanation:
        """Return an explanation of everything without what has no effect, and with plain values."""
        simple = self._without_mistakes(best)
        simple = self._named(simple)
        simple = self._plain(simple)
        simple = self._without_mistakes(simple)
        simple = self._written_between_ticks(self._without_details(simple))
        return replace(simple, plain_cost=max(0.0, simple.weight - best.weight))

    def refined(self, best: Explanation) -> Explanation:
        """Return an explanation of nearly everything with values fitted to all rows, as precisely as the digits allow.

        The search fits them only to what single precision, which the program may have, and its coarse simulations leave
        open.  What is then left may be the rounding of a program in very short steps.
        """
        tried = list[Mistakes]()
        try:
            tried.append(self._refitted(best.mistakes))
            others = [*self._limited_in_other_steps(tried[0]), *self._plainer_damping(tried[0])]
            for other in self._precise_search.closest(others, 1):
                tried += [other, *self._refitted_limits(other)]
        except SearchStopped:
            self.is_stopped = True
        best = min((best, *map(self._evaluator.explain, tried)), key=lambda each: each.weight)
        return best if best.is_whole else self._evaluator.in_short_steps(best)

    def _refitted(self, mistakes: Mistakes) -> Mistakes:
        """Return mistakes with values that are fitted to all rows together with the start."""
        program, size_m = self._evaluator.context.program, self._evaluator.scale.size_m
        return with_fixed_start(self._precise_search.refitted(with_free_start(mistakes, size_m)), program)

    def _refitted_limits(self, mistakes: Mistakes) -> list[Mistakes]:
        """Return a program with limits that are fitted to other steps, and the best one with plainer limits."""
        if not any(m.hypothesis.limits for m in mistakes):
            return []
        refitted = self._refitted(mistakes)
        return [refitted, *self._precise_search.closest(list(self._limited_in_other_steps(refitted)), 1)]

    def _limited_in_other_steps(self, mistakes: Mistakes) -> Iterator[Mistakes]:
        """Yield programs with a plainer limit and another step: by how much a speed exceeds a limit depends on both.

        Nothing else shows the steps of the classical method, so those are tried in the place of any others.
        """
        step = next((m for m in mistakes if m.hypothesis.part == STEPS), None)
        for limit in (m for m in mistakes if m.hypothesis.limits):
            for plainer in self._plainer(mistakes, limit):
                for length in self._evaluator.context.parts if step else ():
                    yield tuple(m._replace(value=length) if m is step else m for m in plainer)
                yield from self._in_classical_steps(plainer, limit.hypothesis)

    def _in_classical_steps(self, mistakes: Mistakes, limit: Hypothesis) -> Iterator[Mistakes]:
        """Yield programs in steps of the classical Runge-Kutta method, with a limit where that has it."""
        plain = (h for h in self._proposals.hypotheses if h.name == limit.name and not h.needs_steps)
        places = dict.fromkeys((limit, *plain))
        others = tuple(m for m in mistakes if m.hypothesis.part != STEPS)
        lengths = self._proposals.short_steps(self._evaluator.context.duration)
        for place, length, classical in product(places, lengths, self._proposals.classical(others)):
            placed = (m._replace(hypothesis=place) if m.hypothesis is limit else m for m in others)
            yield self._proposals.ordered((*placed, Mistake(classical, length)))

    @cached_property
    def _precise_search(self) -> CausalSearch:
        return CausalSearch(self._evaluator, is_double=True)

    def alternatives(self, best: Explanation) -> list[Explanation]:
        """Return explanations of everything that are one change away from one, or two of its mistakes made one.

        Their values are fitted ones: what plain values cost the other one is added to their weights.
        """
        try:
            likely = self._search.alternatives(best.mistakes)[:ALTERNATIVES]
        except SearchStopped:
            self.is_stopped = True
            return []
        found = sorted(self._explained(likely), key=lambda each: each.weight)
        first = {tuple(m.hypothesis for m in each.mistakes): each for each in reversed(found) if each.is_whole}
        return [replace(each, weight=each.weight + best.plain_cost) for each in first.values()]

    def _explained(self, several: Iterable[Mistakes]) -> Iterator[Explanation]:
        """Yield what mistakes leave of all rows, until time is up."""
        return (self._evaluator.explain(mistakes) for mistakes in takewhile(lambda _: not self.is_late(), several))

    def is_as_good(self, other: Explanation, best: Explanation, larger: float = LARGER) -> bool:
        """Whether another explanation is within the floor too, and not larger as far as can be seen there.

        Of one that leaves noise, whether it leaves noise too, and is no less likely.
        """
        if best.is_noise:
            return other.is_whole and other.weight <= best.weight
        return is_no_larger(other, best, larger, self._evaluator.scale.floor_m)

    def _is_as_plain(self, other: Explanation, best: Explanation) -> bool:
        """Whether another explanation, with a plainer value, is nearly as good, or hidden in noise or single precision.

        That rounds the factor of a damping always in the same way, and a fitted value makes up for it.
        """
        if best.is_noise:
            return other.is_whole and (other.weight <= best.weight + NOISIER or is_rounded(other, best))
        as_good = self.is_as_good(other, best, LARGER_IF_PLAIN) or is_hidden(other, best)
        return as_good or is_rounded(other, best)

    def _without_mistakes(self, best: Explanation) -> Explanation:
        """Return an explanation without mistakes that have no effect, alone or with what its step does at ticks."""
        for mistake in best.mistakes:
            others = tuple(other for other in best.mistakes if other.hypothesis is not mistake.hypothesis)
            wanted = dict.fromkeys((others, self._with_plain_ticks(others)))
            try:
                refitted = [self._search.refitted(some) for some in wanted if not self._search.is_far(some)]
            except SearchStopped:
                self.is_stopped = True
                return best
            others = list(self._explained(refitted))
            # A step or a factor may make up for the rounding of shorter steps.
            if mistake.hypothesis.part == STEPS or mistake.is_nearly_right(SUSPECT):
                shorter = map(self._evaluator.in_short_steps, others)
                others = [fewer for fewer in shorter if not leaves_much_less(best, fewer)]
            best = next((fewer for fewer in others if self.is_as_good(fewer, best)), best)
        return best

    def _named(self, best: Explanation) -> Explanation:
        """Return an explanation with mistakes that have no fitted value in the place of those that explain anything."""
        for vague in (m for m in best.mistakes if m.hypothesis.vague):
            part = vague.hypothesis.part
            named = [h for h in self._proposals.hypotheses if h.part == part and not h.fitted]
            values = [Mistake(hypothesis, value) for hypothesis in named for value in hypothesis.values or (0.0,)]
            others = tuple(tuple(one if m is vague else m for m in best.mistakes) for one in values)
            best = self._first_as_good(best, others)
        return best

    def _written_between_ticks(self, best: Explanation) -> Explanation:
        """Return an explanation that writes rows between its ticks, if none of its steps ends at a row.

        Single precision or noise may hide how it writes them, but it has to write them in some way.
        """
        try:
            others = self._search.closest(list(self._proposals.with_ticks_between_rows(best.mistakes)), WRITINGS)
        except SearchStopped:
            self.is_stopped = True
            return best
        return next((each for each in self._explained(others) if self.is_as_good(each, best)), best)

    def _with_plain_ticks(self, mistakes: Mistakes) -> Mistakes:
        """Return mistakes of a program in which something can happen in every step."""
        schemes = self._proposals.schemes
        step = next((m for m in mistakes if m.hypothesis.part == STEPS), None)
        own = schemes.of_step(step.hypothesis) if step else None
        return self._proposals.with_step(mistakes, step, replace(own, steps_a_tick=1)) if step and own else mistakes

    def _plain(self, best: Explanation) -> Explanation:
        """Return an explanation of everything with the plainest values that fit as well."""
        for mistake in best.mistakes:
            hypothesis = mistake.hypothesis
            is_damping = hypothesis.name in (LINEAR_DAMPING, ANGULAR_DAMPING) and hypothesis.details
            if hypothesis.scale:
                best = self._first_as_good(best, _along_axes(best.mistakes, mistake))
            elif hypothesis.fitted and hypothesis.part != STEPS and not is_damping:
                best = self._first_as_good(best, self._plainer(best.mistakes, mistake))
        return self._first_as_good(best, self._plainer_damping(best.mistakes))

    def _first_as_good(self, best: Explanation, others: Iterable[Mistakes]) -> Explanation:
        """Return the first of other explanations, with plainer values, that fits nearly as well, if one does."""
        return next((other for other in self._explained(others) if self._is_as_plain(other, best)), best)

    def _plainer(self, mistakes: Mistakes, mistake: Mistake) -> Iterator[Mistakes]:
        """Yield mistakes with plainer values of one of them, the plainest first."""
        hypothesis, value = mistake
        tick = self._evaluator.program_with(mistakes).event_tick
        if hypothesis.at_ticks and tick:
            value = float(next_tick(value, tick))
            yield with_value(mistakes, hypothesis, value)
        if hypothesis.unit == "s":
            for interval in dict.fromkeys(filter(None, (self._evaluator.context.spacing_s, tick))):
                if 0 < round(abs(value) / interval) <= TICKS:
                    yield with_value(mistakes, hypothesis, interval * round(value / interval))
        for named in sorted(hypothesis.named_values, key=lambda named: abs(named - value))[:1]:
            yield with_value(mistakes, hypothesis, named)
        for digits in FEW_DIGITS:
            if (plain := _plain_in(value, digits)) is not None:
                yield with_value(mistakes, hypothesis, plain)

    def _plainer_damping(self, mistakes: Mistakes) -> Iterator[Mistakes]:
        """Yield mistakes with damping of plainer rates, in the form that has them; all has one form and place.

        c dt, exp(-c dt) and 1/(1 + c dt) reduce a velocity equally in a step, with different rates c.  A step that
        damps after it has moved the body is an explicit one with damping as a force.
        """
        damping = [m for m in mistakes if m.hypothesis.name in (LINEAR_DAMPING, ANGULAR_DAMPING)]
        step = next((m for m in mistakes if m.hypothesis.part == STEPS), None)
        own = self._proposals.schemes.of_step(step.hypothesis) if step else None
        others = tuple(m for m in mistakes if m not in damping)
        number_of = {words: number for number, words in DAMPING_PLACES.items()}
        details = [dict(m.hypothesis.details) for m in damping]
        places = [number_of[each["damping-place"]] for each in details if each]
        place = next((number for number in places if number != AS_FORCE), AS_FORCE)
        variants = [(others, place)] if any(details) else []
        if damping and step and own and own.explicit and place == AS_FORCE:
            symplectic = replace(own, explicit=False, other_axes=False)
            variants.append((self._proposals.with_step(others, step, symplectic), LAST))
        for digits, (kept, where), form in product(FEW_DIGITS, variants, DAMPING_FORMS):
            found = []
            for one in damping:
                rate = _rate_in(one, DAMPING_FORMS[form], step.value) if step and where != AS_FORCE else one.value
                kind = one.hypothesis.name.partition("-")[0]
                hypothesis = self._proposals.schemes.damping(kind, where, form if where != AS_FORCE else LINEARLY)
                if (plain := _plain_in(rate, digits)) is not None:
                    found.append(Mistake(hypothesis, plain))
            if len(found) == len(damping):
                yield self._proposals.ordered((*kept, *found))

    def _without_details(self, best: Explanation) -> Explanation:
        """Return an explanation without the details of its step that all other steps fit as well."""
        schemes = self._proposals.schemes
        step = next((m for m in best.mistakes if m.hypothesis.part == STEPS), None)
        own = schemes.of_step(step.hypothesis) if step else None
        if step is None or own is None:
            return best
        for detail, others in (("gyroscopic", GYROSCOPIC), ("rotation", ROTATION)):
            kept = getattr(own, detail)
            tried = self._explained(
                self._proposals.with_step(best.mistakes, step, replace(own, **{detail: other}))
                for other in others
                if other not in (kept, "none")
            )
            if kept and all(self.is_as_good(each, best) for each in tried) and not self.is_late():
                own = replace(own, **{detail: ""})
        return self._evaluator.explain(self._proposals.with_step(best.mistakes, step, own))


def _along_axes(mistakes: Mistakes, mistake: Mistake) -> Iterator[Mistakes]:
    """Yield mistakes with a vector of few digits in the place of one of them, if parts of that are nearly zero."""
    value = np.array(mistake.value)
    value[np.abs(value) <= CHANCE / 2 * np.abs(value).max()] = 0.0
    for digits in FEW_DIGITS if (value == 0.0).any() and value.any() else ():
        plain = tuple(in_digits(part, digits) for part in value.tolist())
        if max(map(_chance, value.tolist(), plain, [digits] * len(plain))) <= CHANCE:
            yield with_value(mistakes, mistake.hypothesis, plain)


def is_no_larger(other: Explanation, best: Explanation, larger: float, floor_m: float) -> bool:
    """Whether another explanation is within the floor too, and not larger as far as can be seen there.

    If all digits are right without single precision, those of the other one are nearly so.  floor_m: of the digits.
    """
    most_m = max(larger * best.weighted_rms_m, HIDDEN * floor_m)
    return not needs_no_single(best, other) and other.within_floor and other.weighted_rms_m <= most_m


def is_hidden(other: Explanation, best: Explanation) -> bool:
    """Whether single precision, which the best explanation needs too, hides what another one leaves."""
    return not needs_no_single(best, other) and other.in_floors <= HIDDEN


def is_named(other: Explanation, best: Explanation) -> bool:
    """Whether single precision, which the best explanation needs too, explains what one without vague mistakes leaves.

    A vague mistake explains a part of that as well.
    """
    return best.is_vague and not other.is_vague and other.within_floor and not needs_no_single(best, other)


def is_rounded(other: Explanation, best: Explanation) -> bool:
    """Whether another explanation is the best one in plainer values, which single precision allows for.

    Its values have so few digits that others are hardly as near to such ones by chance; or they are those of damping,
    in whatever form, and a few roundings of its factor in each step make up for the difference.
    """
    is_plainer = other.names == best.names and other.odd_values < best.odd_values
    if not is_plainer or not other.is_whole or needs_no_single(best, other):
        return False
    step_s = next((m.value for m in best.mistakes if m.hypothesis.part == STEPS), 0.0)
    plainer = {m.hypothesis.name: m for m in other.mistakes}
    for one in (m for m in best.fitted if not m.hypothesis.scale):
        plain, value, most = plainer[one.hypothesis.name], one.value, CHANCE
        if step_s and one.hypothesis.name in (LINEAR_DAMPING, ANGULAR_DAMPING):
            value = _rate_in(one, _form(plain), step_s)
            if abs(value - plain.value) * step_s <= ROUNDINGS / 2 * np.finfo(np.float32).eps:
                most = CHANCE_IF_ROUNDED
        if _chance(value, plain.value, _digits_of(plain.value)) > most:
            return False
    return True


def _form(damping: Mistake) -> str:
    """Return the form of a damping; a force takes the same in an explicit step as the first one."""
    return dict(damping.hypothesis.details).get("damping-form", DAMPING_FORMS[LINEARLY])


def _rate_in(damping: Mistake, form: str, step_s: float) -> float:
    """Return the rate with which a form of damping leaves as much of a velocity in a step [s] as this one does."""
    return rate_of_a_step(left_in_a_step(damping.value * step_s, _form(damping)), form) / step_s


def leaves_much_less(explanation: Explanation, other: Explanation) -> bool:
    """Return whether an explanation leaves much less than another one, although single precision would explain that.

    Of what single precision explains in any program, less says nothing; and any value may be fitted to what it leaves.
    """
    is_less = explanation.in_common <= other.in_common / MUCH_LESS
    has_more = fitted_of(explanation.mistakes) > fitted_of(other.mistakes)
    return explanation.within_floor and is_less and other.in_common > EXPLAINED and not has_more


def fitted_of(mistakes: Mistakes) -> set[Hypothesis]:
    """Return those mistakes whose values are fitted."""
    return {mistake.hypothesis for mistake in mistakes if mistake.hypothesis.fitted}


def needs_no_single(one: Explanation, other: Explanation) -> bool:
    """Return whether all digits are right without single precision by one explanation, though not by another."""
    return one.in_digits <= EXPLAINED < EXPLAINED * NEARLY < other.in_digits


def needs_noise_alone(one: Explanation, other: Explanation) -> bool:
    """Return whether one explanation leaves only what digits and noise may, though another needs single precision."""
    return one.in_double <= EXPLAINED < EXPLAINED * NEARLY < other.in_double


def _plain_in(value: float, digits: int) -> float | None:
    """Return a value in so many significant digits; None where more than a few are as near to the value by chance."""
    plain = in_digits(value, digits)
    return plain if digits <= WRITTEN or _chance(value, plain, digits) <= CHANCE else None


def _digits_of(value: float) -> int:
    """Return the number of significant digits of a value, up to those of a float."""
    return next(digits for digits in range(1, MOST_DIGITS + 1) if in_digits(value, digits) == value)


def _chance(value: float, plain: float, digits: int) -> float:
    """Return the share of values that are as near as this one to any of so many significant digits."""
    return abs(plain - value) / abs(value) * 10.0**digits if value else 0.0


def left_in_a_step(share: float, form: str) -> float:
    """Return what a damping leaves of a velocity in a step; share: rate times step."""
    if form == DAMPING_FORMS[0]:
        return 1 - share
    return exp(-share) if form == DAMPING_FORMS[1] else 1 / (1 + share)


def rate_of_a_step(left: float, form: str) -> float:
    """Return the rate times the step of a form of damping that leaves a share of a velocity in a step."""
    if form == DAMPING_FORMS[0] or left <= 0:
        return 1 - left
    return -log(left) if form == DAMPING_FORMS[1] else 1 / left - 1
