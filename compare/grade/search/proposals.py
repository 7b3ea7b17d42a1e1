"""What a search tries next: one more mistake, another one in the place of one, or another scheme."""

import math
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from tumble.compare.grade.hypotheses.engine_schemes import DAMPING_PLACES, GYROSCOPIC, ROTATION
from tumble.compare.grade.hypotheses.explanation import Mistake, Mistakes, step_divides
from tumble.compare.grade.hypotheses.hypothesis import NEAR, Context, Hypothesis
from tumble.compare.grade.hypotheses.hypothesis import STEPS as STEPS_S
from tumble.compare.grade.hypotheses.names import (
    CLOCK_OFFSET,
    GRAVITY_DELAYED,
    GYROSCOPIC_TERM_MISSING,
    LOG_LAG,
    RARELY_NORMALISED,
    RUNGE_KUTTA_4,
    SPIN_RECOVERED,
)
from tumble.compare.grade.hypotheses.scheme_hypotheses import TURNED_ASIDE, SchemeHypotheses, Step
from tumble.compare.grade.measure.lateness import Lateness
from tumble.compare.grade.model.kernel.dynamics import AFTER_FORCES, AS_FORCE, LAST, LINEARLY
from tumble.compare.grade.model.program_model import next_tick
from tumble.scenarios.frames import Array

# Parts whose mistakes may cause one motion.
TWINS = {
    "gravity start": ("position step", "clock offset"),
    "position step": ("gravity start",),
    "clock offset": ("clock tick", "clock rate"),
    "clock tick": ("clock offset",),
    "clock rate": ("clock offset",),
}
# Orders of methods whose error is not of order 1.
ORDERS = {
    "midpoint": 2, "heun": 2, "velocity-verlet": 2, "ralston": 2, "runge-kutta-3": 3, "runge-kutta-3-shu-osher": 3,
    "runge-kutta-4": 4, "runge-kutta-4-three-eighths": 4,
}  # fmt: skip
# Parts of a program in which steps move the centre alone, and steps in which it has no gravity at first.
CENTRE_IN_STEPS, IDLE = ("position step", "velocity axes"), (1, 2)
# Substeps in which some programs move the centre.
SUBSTEPS = (1, 2, 4, 8)
# Rotations, and whether the quaternion is normalised; and gyroscopic terms of explicit steps.
ROTATIONS = (*((rotation, 1) for rotation in ROTATION), ("first order", 0))
OF_EXPLICIT = ("none", "explicit", "implicit", "rescaled", "momentum")
# Of these, the terms with which the angular velocity may as well be stored in the other axes, which matters then.
STORED_EITHER_WAY = ("none", "explicit", "implicit", "rescaled")
# Steps from one instant to the next at which events happen, and by which rows may be late.
STEPS_A_TICK = (1, 2, 4, 8)
# Steps from one normalisation of a quaternion to the next that are tried with other details.
RARE = (2, 5, 10, 20, 50, 60, 100)
# Errors by which a measured lateness may be off a usual one.
AS_NEAR = 3.0
# Parts of a row interval after which a body may begin to move, and most usual steps in which it may rest.
PARTS_AT_REST, MOST_AT_REST = (1, 2, 3, 4, 5), 10
# Row intervals by which rows may be late.
LATE = (-1, 1, 2, 3, 4, 5)
DAMPED = ("linear damping", "angular damping")
PLAIN_DAMPING = ("linear-damping", "angular-damping")
# Values of a mistake that are tried first, at most.
MOST_VALUES, MOST_IF_LINEAR = 9, 5
# Row intervals by which a clock is behind that are tried in any case: what a small change does shows no late rows, of
# which the first ones have not moved.
LATEST = 4
# Times that are tried in a run; and shares by which limits are below what the program reaches.
ROWS_LATE = (0.03, 0.1, 0.25, 0.5, 1, 2, 3, 4, 6)
TIMES, BELOW = 12, (0.003, 0.01, 0.03, 0.07, 0.15, 0.3, 0.5, 0.7)
# Row intervals before the first row at rest at which a body may have stopped.
RESTED = (0.0, 0.25, 0.5, 0.75)
# A run of more steps takes longer than it is worth.
MOST_STEPS = 6_000
# Parts of a program that are a scheme.
STEPS, GYRO = "steps", "gyroscopic"
# Steps in a row interval, and in a tick between rows.
PARTS, IN_A_TICK = (1, 2, 3, 4, 5, 8, 10, 16, 20, 32, 40, 80), (1, 2, 4, 8)
# Of these, so many next to a length are tried; and usual steps whose logarithm differs by less, or by less where a
# velocity is limited.
NEXT, CLOSE, WIDE = 2, 0.1, 0.7
# Parts of the longest step with which one is looked for that has the scene's events at its ticks.
FIRST = (1, 2, 3, 4, 5)
# Parts of a row interval that are tried even if such steps seem too long; and more, of methods of high order.
ALWAYS, OF_METHODS = (1, 2), (3, 4)
# Steps that differ from another by less than this factor are similar.
SIMILAR = 1.7
# Steps of short programs, in which a mistake may happen elsewhere.
PLAIN_GYROSCOPIC, PLAIN_ROTATIONS = ("none", "explicit", "momentum"), (("exponential", 1), ("first order", 1))


@dataclass(frozen=True)
class Run:
    """What first values depend on: until when a program runs [s], its rows [s], its largest speeds.

    reached: speeds that the rows reach; both by names in `measure.speeds.SPEEDS`; rests_from: time from which they rest
    [s].
    """

    until: float
    spacing: float
    fastest: Mapping[str, float]
    reached: Mapping[str, Sequence[float]]
    rests_from: float


@dataclass(frozen=True)
class SchemeKind:
    """A kind of scheme: a key, the mistakes that are put upon it, its hypothesis, and the order of its error."""

    key: tuple
    others: Mistakes
    hypothesis: Hypothesis
    order: int


class Proposals:
    """Lists programs that are a change away from one."""

    def __init__(self, context: Context, hypotheses: Sequence[Hypothesis]) -> None:
        self._context, self.hypotheses = context, [h for h in hypotheses if h.part != STEPS]
        self._methods = [h for h in hypotheses if h.part == STEPS]
        self._classical = [h for h in self._methods if h.name == RUNGE_KUTTA_4 and not h.details]
        self.schemes = SchemeHypotheses(context)
        self._place = {hypothesis: number for number, hypothesis in enumerate(hypotheses)}
        self._parts = {h.part: n for n, h in reversed(list(enumerate(hypotheses)))}
        self._recovered = next(h for h in hypotheses if h.name == SPIN_RECOVERED)
        self._offset = next(h for h in hypotheses if h.name == CLOCK_OFFSET)
        self._asleep = [h for h in hypotheses if h.name == LOG_LAG]
        self._rarely = next(h for h in hypotheses if h.name == RARELY_NORMALISED)
        self._equal = float(np.ptp(context.program.moments)) == 0.0
        self._event_times = np.array([impulse.time for impulse in context.program.impulses])

    def ordered(self, mistakes: Sequence[Mistake]) -> Mistakes:
        """Return mistakes in the order in which a program makes them."""
        return tuple(sorted(mistakes, key=lambda mistake: self._order(mistake.hypothesis)))

    def _order(self, hypothesis: Hypothesis) -> int:
        place = self._place.get(hypothesis)
        return self._parts.get(hypothesis.part, 0) if place is None else place

    def with_one_more(
        self, mistakes: Mistakes, run: Run, every_value: bool = False, but: Container[Hypothesis] = ()
    ) -> Iterator[tuple[Hypothesis, list[Mistakes]]]:
        """Yield each mistake that can be added, and the programs with its first values; every_value: not only some.

        If a small value has an effect in proportion, the program with the neutral value comes first.  but: mistakes
        that are not added.
        """
        taken = {m.hypothesis.part for m in mistakes}
        for hypothesis in (*self.hypotheses, *self._damping(mistakes)):
            # Where in a step a limit or friction acts is tried when there is one.
            is_other = hypothesis.needs_steps and (STEPS not in taken or hypothesis.limits or _is_placed(hypothesis))
            if hypothesis.part not in taken and not is_other and hypothesis not in but:
                values = [Mistake(hypothesis, value) for value in first_values(hypothesis, run, every_value)]
                yield hypothesis, [program for one in values for program in self._with(mistakes, one)]
        if "clock offset" not in taken:
            for late in map(self.schemes.late, LATE):
                yield late.hypothesis, [self.ordered((*mistakes, late))]

    def _with(self, mistakes: Mistakes, one: Mistake) -> Iterator[Mistakes]:
        """Yield programs with one more mistake; a tick between rows is of one step or several."""
        step = next((m for m in mistakes if m.hypothesis.part == STEPS), None)
        if one.hypothesis.part != "clock tick" or step is None:
            yield self.ordered((*mistakes, one))
            return
        others = tuple(m for m in mistakes if m is not step)
        for part in sorted(IN_A_TICK, key=lambda part: abs(math.log(one.value / part / step.value)))[:NEXT]:
            yield self.ordered((*others, Mistake(step.hypothesis, one.value / part), one))

    def _damping(self, mistakes: Mistakes) -> Iterator[Hypothesis]:
        """Yield damping anywhere in the step of a program that has steps; all of it is at one place."""
        if not any(m.hypothesis.part == STEPS for m in mistakes):
            return
        used = {dict(m.hypothesis.details).get("damping-place") for m in mistakes if m.hypothesis.part in DAMPED}
        for kind, place in product(("linear", "angular"), DAMPING_PLACES):
            if place != AS_FORCE and (not used or DAMPING_PLACES[place] in used):
                yield self.schemes.damping(kind, place, LINEARLY)

    def other_laws(self, damping: Hypothesis, mistakes: Mistakes) -> list[Hypothesis]:
        """Return the other laws of the same damping that a program may have, of which a small value does little."""
        has_steps = any(m.hypothesis.part == STEPS for m in mistakes)
        laws = (h for h in self.hypotheses if h.part == damping.part and h.neutral is not None)
        return [law for law in laws if law is not damping and (has_steps or not law.needs_steps)]

    def with_plain_damping(self, mistakes: Mistakes) -> Iterator[Mistakes]:
        """Yield a program with linear laws in the place of all others: in a short run they do nearly the same."""
        plain = {h.part: h for h in self.hypotheses if h.name in PLAIN_DAMPING}
        moved = [m.hypothesis.part in plain and m.hypothesis.name not in PLAIN_DAMPING for m in mistakes]
        if any(moved):
            yield self.ordered(
                [Mistake(plain[m.hypothesis.part]) if other else m for m, other in zip(mistakes, moved, strict=True)]
            )

    def damping(self, kind: str, mistakes: Mistakes) -> Hypothesis:
        """Return linear or angular damping, where the other one is or after the forces of a step if there are steps."""
        used = [m.hypothesis for m in mistakes if m.hypothesis.part in DAMPED and m.hypothesis.details]
        place = dict(used[0].details).get("damping-place", "") if used else DAMPING_PLACES[AFTER_FORCES]
        number = next((key for key, text in DAMPING_PLACES.items() if text == place), AFTER_FORCES)
        has_steps = any(m.hypothesis.part == STEPS for m in mistakes)
        return self.schemes.damping(kind, number if has_steps else AS_FORCE, LINEARLY)

    def may_be_of_any_scheme(self, mistakes: Mistakes, kinds: Iterable[str]) -> list[Hypothesis]:
        """Return mistakes that programs in steps often have, of parts in which one has none; kinds: of damping."""
        taken = {m.hypothesis.part for m in mistakes}
        damping = (self.damping(kind, mistakes) for kind in kinds)
        return [h for h in (*damping, self._offset) if h.part not in taken]

    def late(self, measured: Lateness) -> list[Mistakes]:
        """Return programs whose rows are as late as they have been measured to be.

        By a usual time, if one is as near as that; and by a tick, if the rows may be between two of those.
        """
        spacing, late = self._context.spacing_s, abs(measured.seconds)
        steps = (*STEPS_S, *(spacing / part for part in PARTS))
        usual = {*(spacing * rows for rows in LATE if rows > 0), *(step * n for step in steps for n in IN_A_TICK)}
        time = min(usual, key=lambda each: abs(each - late))
        if abs(time - late) > NEAR * time + AS_NEAR * measured.error:
            return [(Mistake(self._offset, -measured.seconds),)]
        ticks = [Mistake(h, time) for h in self.hypotheses if h.part == "clock tick" and _has(h, time)]
        between = [tick for tick in ticks if tick.hypothesis.change(self._context.program, time).clock.lag == 1.0]
        log = self.schemes.late(1 if measured.seconds > 0 else -1)._replace(value=time)
        return [(log,), *((tick,) for tick in between if measured.seconds > 0)]

    def begins_between(self, first: float, last: float) -> list[Mistakes]:
        """Return programs that begin to move at usual times from the first to the last one [s]."""
        spacing, found = self._context.spacing_s, dict[float, None]()
        usual = (step for step in STEPS_S if last <= MOST_AT_REST * step)
        for step in (*(spacing / part for part in PARTS_AT_REST), *usual):
            for number in range(math.ceil(first / step - NEAR), math.ceil(last / step - NEAR)):
                if all(abs(time - number * step) > NEAR * time for time in found):
                    found[number * step] = None
        hypotheses = (self.schemes.late(1).hypothesis, *self._asleep)
        return [(Mistake(hypothesis, time),) for hypothesis, time in product(hypotheses, found)]

    def with_others(self, mistakes: Mistakes, run: Run) -> Iterator[tuple[object, Mistakes]]:
        """Yield programs with another mistake of the same part, or of a twin, in the place of one; with a key."""
        taken = {m.hypothesis.part for m in mistakes}
        for number, mistake in enumerate(mistakes):
            own = mistake.hypothesis
            others = (*mistakes[:number], *mistakes[number + 1 :])
            for hypothesis in (*self.hypotheses, *self._damping(others)):
                same = hypothesis.part == own.part or (
                    hypothesis.part in TWINS.get(own.part, ()) and hypothesis.part not in taken
                )
                same = same and (STEPS in taken or not hypothesis.needs_steps)
                if same and own.part != STEPS and hypothesis is not own:
                    for value in (*_same_values(mistake, hypothesis), *first_values(hypothesis, run)):
                        for program in self._with(others, Mistake(hypothesis, value)):
                            yield (own, hypothesis), program
        yield from self._with_other_places(mistakes)
        yield from self._with_other_details(mistakes)

    def _with_other_details(self, mistakes: Mistakes) -> Iterator[tuple[object, Mistakes]]:
        """Yield programs with another method of the same step, or another detail of it.

        Methods of high order do nearly the same in short steps, so only one of them may have been tried in this one.
        """
        for step in (m for m in mistakes if m.hypothesis in self._methods):
            others = tuple(m for m in mistakes if m is not step)
            for method in (each for each in self._methods if each is not step.hypothesis):
                yield method, self.ordered((*others, step._replace(hypothesis=method)))
        for own, step in self._own_step(mistakes):
            # Rotations without a gyroscopic term are the same in explicit steps.
            moved = replace(own, explicit=False, other_axes=own.other_axes and not own.explicit)
            for substeps in SUBSTEPS:
                other, length = replace(moved, substeps=substeps), substeps * step.value
                yield ("details",), self.with_step(mistakes, step, other)
                # The same steps of the centre, and longer ones of the rotation.
                if substeps > own.substeps == 1 and length <= self._context.spacing_s * (1 + NEAR):
                    for rotation, normalise_every in ROTATIONS:  # in short steps any may have been as good
                        turned = replace(other, rotation=rotation, normalise_every=normalise_every)
                        yield ("substeps",), self.with_step(mistakes, step, turned, length)
            # Kinds of schemes have neither substeps nor ticks of several steps, and are not tried where a change helps.
            for rotation, normalise_every in ROTATIONS:
                turned = replace(own, rotation=rotation, normalise_every=normalise_every)
                yield ("rotation",), self.with_step(mistakes, step, turned)
            for gyroscopic in _other_terms(own, mistakes):
                yield ("gyroscopic",), self.with_step(mistakes, step, replace(own, gyroscopic=gyroscopic))
        for program in self.with_other_ticks(mistakes):
            yield ("ticks",), program

    def with_other_ticks(self, mistakes: Mistakes) -> Iterator[Mistakes]:
        """Yield programs with other ticks, of whole steps, if events happen at other instants then.

        If events may be seen, others have shorter steps and the same ticks.
        """
        for own, step in self._own_step(mistakes):
            tick = step.value * own.steps_a_tick
            for number in STEPS_A_TICK:
                if number != own.steps_a_tick and self._moves_events(tick, step.value * number):
                    yield self.with_step(mistakes, step, replace(own, steps_a_tick=number))
                if number > own.steps_a_tick and self._moves_events(tick, tick / number):
                    yield self.with_step(mistakes, step, replace(own, steps_a_tick=number), tick / number)

    def with_ticks_between_rows(self, mistakes: Mistakes) -> Iterator[Mistakes]:
        """Yield programs that write rows between their ticks, for one whose steps do not divide a row interval."""
        if self._has_tick(mistakes) or step_divides(mistakes, self._context.spacing_s):
            return
        clocks = [hypothesis for hypothesis in self.hypotheses if hypothesis.part == "clock tick"]
        lengths = [m.value for m in mistakes if m.hypothesis.part == STEPS]
        for length, clock, steps in product(lengths, clocks, IN_A_TICK):
            yield self.ordered((*mistakes, Mistake(clock, steps * length)))

    def _own_step(self, mistakes: Mistakes) -> Iterator[tuple[Step, Mistake]]:
        """Yield the step of a program in symplectic steps."""
        for mistake in mistakes:
            if mistake.hypothesis.part == STEPS and (own := self.schemes.of_step(mistake.hypothesis)):
                yield own, mistake

    def with_step(self, mistakes: Mistakes, step: Mistake, other: Step, length: float | None = None) -> Mistakes:
        """Return mistakes with another step, of the same length or another one [s]."""
        length = step.value if length is None else length
        return tuple(Mistake(self.schemes.step(other), length) if m is step else m for m in mistakes)

    def with_details(self, mistakes: Mistakes) -> Iterator[Mistakes]:
        """Yield programs that take w from attitudes, or write some steps late or early.

        Others normalise a quaternion of first order rarely, since that has no effect on other rotations.
        """
        is_rare = any(m.hypothesis.part == self._rarely.part for m in mistakes)
        is_on_time = not any(m.hypothesis.part == "clock offset" for m in mistakes)
        for own, step in self._own_step(mistakes):
            for sign, steps in product((1, -1), STEPS_A_TICK) if is_on_time else ():
                yield self.ordered((*mistakes, Mistake(self.schemes.late(sign).hypothesis, steps * step.value)))
            if own.normalise_every and not is_rare:
                first_order = self.with_step(mistakes, step, replace(own, rotation="first order"))
                for steps in RARE:
                    rarely = Mistake(self._rarely, float(self._rarely.choices.index(str(steps))))
                    yield self.ordered((*first_order, rarely))
            if not own.normalise_every and self._context.program.impulses:
                yield self.with_step(mistakes, step, replace(own, is_unit_used=not own.is_unit_used))
            if not any(m.hypothesis is self._recovered for m in mistakes):
                yield self.ordered((*mistakes, Mistake(self._recovered)))

    def _with_other_places(self, mistakes: Mistakes) -> Iterator[tuple[object, Mistakes]]:
        """Yield programs whose damping is elsewhere in the step; and one that does nearly what an explicit one does."""
        damping = [m for m in mistakes if m.hypothesis.name in PLAIN_DAMPING]
        if not damping or not any(m.hypothesis.part == STEPS for m in mistakes):
            return
        others = tuple(m for m in mistakes if m not in damping)
        kinds = [(m.hypothesis.name.partition("-")[0], m.value) for m in damping]
        moved = {
            place: [Mistake(self.schemes.damping(kind, place, LINEARLY), value) for kind, value in kinds]
            for place in DAMPING_PLACES
        }
        for place in DAMPING_PLACES:
            yield ("place", place), self.ordered((*others, *moved[place]))
        # That with damping as a force is nearly a symplectic step that damps after it has moved the body.
        for own, step in self._own_step(others):
            if own.explicit:
                symplectic = self.with_step(others, step, replace(own, explicit=False, other_axes=False))
                yield ("place", step.hypothesis), self.ordered((*symplectic, *moved[LAST]))

    def with_other_centres(self, mistakes: Mistakes, in_parts: bool = True) -> Iterator[Mistakes]:
        """Yield programs in the same steps whose centre moves otherwise in them.

        It does by another velocity, with gravity from a later step on or, if `in_parts`, in parts of a step or with its
        velocity in other axes; its damping may be elsewhere in the step.  One of these may hide another, and none turns
        the body.
        """
        for own, step in self._own_step(mistakes):
            kept = tuple(m for m in mistakes if m.hypothesis.part not in (*CENTRE_IN_STEPS, "gravity start"))
            position, axes = ([h for h in self.hypotheses if h.part == part] for part in CENTRE_IN_STEPS)
            delayed = [h for h in self.hypotheses if h.name == GRAVITY_DELAYED]
            updates = [(), *((Mistake(h),) for h in position)]
            starts = [(), *((Mistake(h, idle * step.value),) for h, idle in product(delayed, IDLE))]
            # Rotations without a gyroscopic term, or of a stored angular momentum, are the same in explicit steps.
            steps = [own, replace(own, explicit=False, other_axes=False)] if own.explicit else [own]
            parts = [(replace(each, substeps=count), ()) for each in steps for count in SUBSTEPS if not each.explicit]
            stores = [(replace(each, substeps=1), (Mistake(h),)) for each in steps for h in axes]
            ways = [*((each, ()) for each in steps), *((*parts, *stores) if in_parts else ())]
            for placed, (way, stored) in product(self.damped_anywhere(kept), ways):
                program = self.with_step(placed, step, way)
                for update, start in product(updates, starts):
                    yield self.ordered((*program, *stored, *update, *start))

    def _moves_events(self, tick: float, other: float) -> bool:
        """Whether impulses happen at other instants if they can at every other tick [s]."""
        near = NEAR * min(tick, other)
        return any(abs(next_tick(time, tick) - next_tick(time, other)) > near for time in self._event_times.tolist())

    def damped_anywhere(self, mistakes: Mistakes) -> list[Mistakes]:
        """Return programs with their damping at every place in the step."""
        return [program for _, program in self._with_other_places(mistakes)] or [mistakes]

    def with_other_schemes(self, mistakes: Mistakes) -> Iterator["SchemeKind"]:
        """Yield each kind of scheme upon which the other mistakes can be put, wherever in its step they happen."""
        others = tuple(m for m in mistakes if m.hypothesis.part != STEPS)
        yield from self._in_steps(others, GYROSCOPIC, ROTATIONS)
        if all(m.hypothesis is not self._recovered for m in others):  # it has an effect of the first order
            recovered = (*others, Mistake(self._recovered))
            yield from self._in_steps(recovered, PLAIN_GYROSCOPIC, PLAIN_ROTATIONS)
        for placed in self._with_other_variants(others):
            yield from self._in_steps(placed, PLAIN_GYROSCOPIC, PLAIN_ROTATIONS)
            for classical in self.classical(placed):  # of a step that cannot be seen otherwise
                yield SchemeKind((classical, placed), placed, classical, 1)
        for hypothesis in self._methods:
            order = ORDERS.get(hypothesis.name, 1)
            # Quaternions of stages that are normalised, or taken for unit ones, leave an error of order 2.
            is_staged = any(detail == "stages" for detail, _ in hypothesis.details)
            yield SchemeKind((hypothesis,), others, hypothesis, min(order, 2) if is_staged else order)

    def classical(self, mistakes: Mistakes) -> list[Hypothesis]:
        """Return the Runge-Kutta method of order 4, which has no effect of its own in steps that are short enough.

        It is one method for each of what it may store of the rotation if the mistakes have another effect in each.
        """
        return self._classical[: None if _turns_wrongly(mistakes) else 1]

    def is_plain(self, kind: SchemeKind) -> bool:
        """Return whether a kind is the plainest one of Euler's explicit or symplectic steps."""
        own = self.schemes.of_step(kind.hypothesis)
        if own is None or own.other_axes or own.gyroscopic not in ("", *PLAIN_GYROSCOPIC[:2]):
            return False
        return (own.rotation, own.normalise_every) == PLAIN_ROTATIONS[0]

    def is_method(self, kind: SchemeKind) -> bool:
        """Return whether a kind is a method that evaluates the rates of change several times."""
        return kind.hypothesis in self._methods

    def recovers(self, mistakes: Mistakes) -> bool:
        """Return whether a program takes w from attitudes."""
        return any(m.hypothesis is self._recovered for m in mistakes)

    def _with_other_variants(self, mistakes: Mistakes) -> Iterator[Mistakes]:
        """Yield programs with a mistake that happens elsewhere in a step, in the place of one."""
        for number, (own, value) in enumerate(mistakes):
            for hypothesis in self.hypotheses:
                if hypothesis.name == own.name and hypothesis is not own and hypothesis.needs_steps:
                    yield (*mistakes[:number], Mistake(hypothesis, value), *mistakes[number + 1 :])

    def _in_steps(
        self, others: Mistakes, gyroscopic: Iterable[str], rotations: Sequence[tuple[str, int]]
    ) -> Iterator["SchemeKind"]:
        """Yield kinds of steps of Euler's methods with these gyroscopic terms and rotations."""
        gyro = next((m for m in others if m.hypothesis.part == GYRO), None)
        without = tuple(m for m in others if m.hypothesis.part != GYRO)
        is_factor = gyro is not None and gyro.hypothesis.name != GYROSCOPIC_TERM_MISSING
        missing = self.schemes.gyroscopic_term_missing()
        turns_wrongly = _turns_wrongly(others)
        for kind in ("explicit",) if self._equal or is_factor else gyroscopic:
            base = others if is_factor else without if kind != "none" else (*without, missing)
            for explicit, (rotation, normalise_every) in product((False, True), rotations):
                either_way = turns_wrongly or not TURNED_ASIDE.isdisjoint((kind, rotation))
                either_way = either_way or (explicit and kind in STORED_EITHER_WAY)
                for other_axes in (False, True) if either_way else (False,):
                    if not explicit or kind in OF_EXPLICIT:
                        own = Step(
                            kind, rotation, normalise_every=normalise_every, other_axes=other_axes, explicit=explicit
                        )
                        yield SchemeKind((own, base), base, self.schemes.step(own), 2)

    def with_same_step(self, mistakes: Mistakes) -> Iterator[Mistakes]:
        """Yield programs with another scheme of the same step, with which events happen at the same instants."""
        for step in (m for m in mistakes if m.hypothesis.part == STEPS):
            own = self.schemes.of_step(step.hypothesis)
            for kind in self.with_other_schemes(mistakes):
                hypothesis, other = kind.hypothesis, self.schemes.of_step(kind.hypothesis)
                if own and other:
                    substeps = 1 if other.explicit else own.substeps
                    hypothesis = self.schemes.step(replace(other, steps_a_tick=own.steps_a_tick, substeps=substeps))
                yield self.ordered((*kind.others, Mistake(hypothesis, step.value)))

    def with_other_steps(self, mistakes: Mistakes) -> Iterator[Mistakes]:
        """Yield programs with a somewhat longer or shorter step of the same scheme."""
        for step in (m for m in mistakes if m.hypothesis.part == STEPS):
            interval = self._interval(mistakes)
            count = round(interval / step.value)
            for other in range(max(1, int(count / SIMILAR)), int(count * SIMILAR) + 2):
                moved = Mistake(step.hypothesis, interval / other)
                is_other = abs(moved.value - step.value) > NEAR * step.value  # a usual step may divide no row interval
                if is_other and (other in PARTS or abs(other - count) <= NEXT):
                    yield tuple(moved if m is step else m for m in mistakes)

    def first_step(self, mistakes: Mistakes, until: float, longest: float) -> float:
        """Return the longest step that a program may take [s], but not more than a length; 0 for none.

        It is a shorter one if the scene's events are at its ticks then: an event that is late hides what else steps do.
        """
        interval = self._interval(mistakes)
        longest_of_all = interval / max(1, np.ceil(interval / longest * (1 - NEAR)))
        times = self._events_until(until)
        steps = [longest_of_all / part for part in FIRST]
        on_time = (step for step in steps if np.allclose(next_tick(times, step), times, rtol=0.0, atol=NEAR * step))
        step = next(on_time, longest_of_all)
        return step if until <= MOST_STEPS * step else 0.0

    def steps_near(self, mistakes: Mistakes, until: float, ideal: float) -> list[float]:
        """Return steps that a program may take near a length [s]: parts of a row interval, or of a tick."""
        interval = self._interval(mistakes)
        log_ideal = math.log(ideal)
        usual = sorted(PARTS, key=lambda part: abs(math.log(interval / part) - log_ideal))[:NEXT]
        nearest = max(1, round(interval / ideal))
        # What a limit does depends on the step by leaps.
        close = WIDE if any(m.hypothesis.limits for m in mistakes) else CLOSE
        others = [h for h in STEPS_S if h < interval and abs(math.log(h) - log_ideal) < close]
        if self._has_tick(mistakes):
            others = []
        found = dict.fromkeys([*(interval / part for part in (*ALWAYS, *usual, nearest)), *others])
        return [step for step in found if until <= MOST_STEPS * step]

    def long_steps(self, mistakes: Mistakes, until: float, longer: float, parts: Sequence[int] = ALWAYS) -> list[float]:
        """Return the longest steps that a program may take [s], parts of an interval, if longer than a length."""
        steps = [self._interval(mistakes) / part for part in parts]
        return [step for step in steps if step > longer and until <= MOST_STEPS * step]

    def short_steps(self, until: float) -> list[float]:
        """Return the steps that divide a row interval [s], without those that are too short for a run until a time."""
        return [step for step in self._context.parts if until <= MOST_STEPS * step]

    def event_steps(self, mistakes: Mistakes, first: float, until: float) -> list[float]:
        """Return usual steps with which events of the scene, until a time [s], happen at other instants than before."""
        if self._has_tick(mistakes):
            return []
        times = self._events_until(until)
        found = dict[tuple, float]()
        for step in (first, *STEPS_S):
            if until <= MOST_STEPS * step:
                found.setdefault(tuple(np.round(next_tick(times, step), 9)), step)
        return [step for step in found.values() if step != first]

    def _events_until(self, until: float) -> Array:
        return self._event_times[self._event_times <= until]

    def _interval(self, mistakes: Mistakes) -> float:
        tick = next((m.value for m in mistakes if m.hypothesis.part == "clock tick"), 0.0)
        return tick or self._context.spacing_s

    def _has_tick(self, mistakes: Mistakes) -> bool:
        return any(m.hypothesis.part == "clock tick" for m in mistakes)


def _has(hypothesis: Hypothesis, value: float) -> bool:
    """Return whether a value is one of those of a hypothesis that are tried first."""
    return any(abs(each - value) <= NEAR * value for each in hypothesis.values)


def _turns_wrongly(mistakes: Mistakes) -> bool:
    """Return whether the attitude of a program turns by something else than w, so that it matters what it stores."""
    return any(m.hypothesis.part in ("frame", "turning") for m in mistakes)


def _other_terms(own: Step, mistakes: Mistakes) -> list[str]:
    """Return the other gyroscopic terms that a step of a program may have; none if the program has a mistake there."""
    if any(m.hypothesis.part == GYRO for m in mistakes):
        return []
    terms = OF_EXPLICIT if own.explicit else GYROSCOPIC
    return [term for term in terms if term not in ("none", own.gyroscopic)]


def _is_placed(hypothesis: Hypothesis) -> bool:
    return any(detail == "damping-place" for detail, _ in hypothesis.details)


def _same_values(mistake: Mistake, other: Hypothesis) -> list[float]:
    """Return the value of a mistake, of either sign, if another one of its part may have it: they may look alike."""
    own = mistake.hypothesis
    if not (own.part == other.part and own.unit == other.unit and own.dimension == other.dimension == 1):
        return []
    if own.choices or not other.fitted:
        return []
    least, most = other.bounds
    return [value for value in (mistake.value, -mistake.value) if least <= value <= most]


def first_values(hypothesis: Hypothesis, run: Run, every_value: bool = False) -> list:
    """Return the values of a mistake that are tried first in a run; every_value: not only some of many."""
    values = list(hypothesis.values) or [0.0]
    if not hypothesis.fitted or hypothesis.scale:
        return values
    least, most = hypothesis.bounds
    if hypothesis.limits:
        fastest = run.fastest[hypothesis.limits]
        below = [*((1 - share) * fastest for share in BELOW), *run.reached[hypothesis.limits]]
        return [value for value in below if least < value < fastest]
    if hypothesis.at_ticks and hypothesis.neutral is None:
        rows = (run.spacing * np.array(ROWS_LATE)).tolist()
        rest = [run.rests_from - share * run.spacing for share in RESTED]
        times = {*np.linspace(0.0, run.until, TIMES + 2)[1:-1].tolist(), *rows, *rest}
        return [value for value in sorted(times) if least <= value < min(most, run.until)]
    count = MOST_VALUES if hypothesis.neutral is None else MOST_IF_LINEAR
    if len(values) > count and not every_value:
        some = [values[number] for number in np.linspace(0, len(values) - 1, count).round().astype(int)]
        if hypothesis.name == CLOCK_OFFSET:
            some += [value for value in values if -LATEST * run.spacing <= value < 0.0]
        values = list(dict.fromkeys(some))
    return values if hypothesis.neutral is None else [hypothesis.neutral, *values]
