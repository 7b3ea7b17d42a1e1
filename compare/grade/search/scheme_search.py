"""Finds one mistake upon any scheme: the scheme is a point of a product, of which engines are some.

A mistake is first tried upon a few rough schemes.  Then the scheme is improved one axis after the other: its method and
step, the gyroscopic term and the rotation, the place of its damping, how late its rows are, and its first steps.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import chain, product

from tumble.compare.grade.hypotheses.engine_schemes import (
    DAMPING_PLACES,
    GYROSCOPIC,
    ROTATION,
    ROW_SHIFTS,
    Damping,
    EngineScheme,
    SteppedScheme,
)
from tumble.compare.grade.hypotheses.explanation import Mistake, Mistakes
from tumble.compare.grade.hypotheses.hypothesis import NEAR, Hypothesis
from tumble.compare.grade.hypotheses.names import CLOCK_OFFSET, SYMPLECTIC_EULER
from tumble.compare.grade.hypotheses.scheme_hypotheses import SchemeHypotheses
from tumble.compare.grade.search.evaluator import Evaluator
from tumble.compare.grade.search.fitting import Fitter

# Parts of a program that a scheme is made of.
SCHEME_PARTS = frozenset({"steps", "normalisation", "position step", "gravity start", "clock offset", "gyroscopic"})
# Steps in a row interval of rough schemes, and of the candidates those that are refined and those that are improved.
ROUGH_STEPS, REFINED, IMPROVED = (1, 2, 4), 24, 6
# Ticks of programs whose rows lie between them [s], and steps in a tick.
TICKS, PARTS = (1 / 50, 1 / 60, 1 / 100, 1 / 120), (1, 2, 4, 8)
# Ticks by which rows are late: a program may wait before it begins.  Most steps in a row interval that are fitted.
LATE, MOST_PARTS = (*ROW_SHIFTS, 2, 3, 4, 5), 80
# Rounds of improving each axis, kinds of methods that are fitted in each, and steps of a run that are worth their time.
ROUNDS, FITTED, MOST_STEPS = 3, 4, 10_000
# The round in which values are fitted upon every gyroscopic term and rotation: a value that was fitted upon a wrong one
# makes up for it, so the right one fits worse with that value.
WITH_EACH = 1
# Programs between ticks that are improved; and parts that rule them out.
BETWEEN, CLOCK_PARTS = 2, ("clock offset", "clock rate", "clock stop")
UNUSUAL = re.compile("half a step|nearest")
DAMPINGS = {"linear damping": "linear", "angular damping": "angular"}


@dataclass(frozen=True)
class Point:
    """Mistakes upon a scheme; stepped: the scheme, or None for a method in `others` or a continuous run."""

    others: Mistakes
    stepped: SteppedScheme | None


class SchemeSearch:
    """Finds the best scheme below a mistake."""

    def __init__(self, evaluator: Evaluator, fitter: Fitter, hypotheses: SchemeHypotheses) -> None:
        self._evaluator, self._fitter, self._hypotheses = evaluator, fitter, hypotheses
        context = evaluator.context
        self._steps = [step for step in context.parts if context.duration <= MOST_STEPS * step]
        self._moves = [Mistake(h) for h in evaluator.hypotheses if h.part == "position step"]
        rough = [step for step in self._steps if round(context.spacing_s / step) in ROUGH_STEPS]
        self.rough = [
            SteppedScheme(EngineScheme("", kind, "exponential"), step)
            for kind, step in product(("explicit", "none"), rough)
        ]
        # Rows half a tick late, or at the nearest tick, are not usual.
        readings = [h for h in evaluator.hypotheses if h.part == "clock tick" and not UNUSUAL.search(h.text)]
        self._readings = [
            Mistake(hypothesis, tick)
            for hypothesis in readings
            for tick in TICKS
            if abs(context.spacing_s / tick - round(context.spacing_s / tick)) > NEAR and tick < context.duration / 4
        ]
        self._methods = [
            Mistake(hypothesis, step)
            for hypothesis in evaluator.hypotheses
            if hypothesis.part == "steps" and hypothesis.name != SYMPLECTIC_EULER
            for step in self._steps
            if step in hypothesis.named_values
        ]

    def in_rows(self, mistakes: Mistakes) -> Mistakes:
        """Return mistakes in which a clock that is off by whole row intervals is rows that are late or early."""
        spacing, found = self._evaluator.context.spacing_s, []
        for mistake in mistakes:
            rows = -mistake.value / spacing
            whole = round(rows)
            is_late = mistake.hypothesis.name == CLOCK_OFFSET and whole in LATE and abs(rows - whole) < NEAR
            found.append(self._hypotheses.late(whole) if is_late and whole else mistake)
        return tuple(found)

    def upon_schemes(self) -> list[Mistakes]:
        """Return the best mistakes upon rough schemes, each upon its best one, improved; best first."""
        weight = self._weight
        found = []
        for hypothesis in self._evaluator.hypotheses:
            if hypothesis.part not in SCHEME_PARTS and not hypothesis.variant:
                points = (
                    Point((Mistake(hypothesis, value),), stepped)
                    for stepped in self.rough
                    for value in hypothesis.values or (0.0,)
                )
                if best := min(points, key=weight, default=None):
                    found.append(best)
        refined = map(self._refined, sorted(found, key=weight)[:REFINED])
        improved = map(self.improved, sorted(refined, key=weight)[:IMPROVED])
        return [self._mistakes(point) for point in sorted(improved, key=weight)]

    def between_ticks(self) -> list[Mistakes]:
        """Return the best scheme whose rows lie between ticks, improved; empty if rows can be at ticks only."""
        points = [other for stepped in self.rough[:1] for other in self._with_other_readings(Point((), stepped))]
        best = sorted(points, key=self._weight)[:BETWEEN]
        return [self._mistakes(self.improved(point)) for point in best]

    def below(self, mistakes: Mistakes) -> Mistakes:
        """Return mistakes that were found without a scheme upon the best one."""
        others = tuple(m for m in mistakes if m.hypothesis.part not in SCHEME_PARTS)
        starts = [Point(others, None), *(Point(others, stepped) for stepped in self.rough)]
        return self._mistakes(self.improved(min(starts, key=self._weight)))

    def improved(self, point: Point) -> Point:
        """Return a point with a better scheme, fitted."""
        point = self._with_own_damping(point)
        weight = self._weight(point)
        for number in range(ROUNDS):
            point = min((point, *self._with_other_times(point)), key=self._weight)
            places = list(self._with_other_places(point))
            others = [point, *self._best_steps(point, number), *places]
            if number == 0:
                others += self._damped(point, others)
            else:  # the place of the damping and the length of the step make up for each other
                placed = (point, *(places[:: len(ROTATION)] if number == WITH_EACH else ()))
                others += chain.from_iterable(map(self._with_fitted_length, placed))
            point = min(map(self._fitted, dict.fromkeys(others)), key=self._weight)
            for axis in (self._with_other_details, self._with_other_times, self._with_other_readings):
                point = min((point, *axis(point)), key=self._weight)
            before, weight = weight, self._weight(point)
            if not weight < before:
                break
        return point

    def _best_steps(self, point: Point, number: int) -> list[Point]:
        """Return the best points with other steps, one of each method and rotation; their values are to be fitted.

        number: of the round; after the first one the step stays as long as it is.
        """
        best: dict[tuple[str, ...], Point] = {}
        others = self._with_other_steps(point)
        if number and point.stepped:
            step = point.stepped.step
            others = (other for other in others if other.stepped and other.stepped.step == step)
        each = number == WITH_EACH and bool(self._free(point))
        for other in sorted(others, key=self._weight):
            name = next((m.hypothesis.name for m in self._mistakes(other) if m.hypothesis.part == "steps"), "")
            scheme = other.stepped.scheme if other.stepped else None
            best.setdefault(
                (name, scheme.rotation if scheme else "", scheme.gyroscopic if scheme and each else ""), other
            )
        return list(best.values())[: None if each else FITTED]

    # --- the axes of the product --------------------------------------------------------------------------------------

    def _with_other_steps(self, point: Point) -> Iterator[Point]:
        """Yield other steps, gyroscopic terms and rotations together; and methods of other kinds."""
        scheme = point.stepped.scheme if point.stepped else EngineScheme("", "explicit", "exponential")
        late, force = (point.stepped.late, point.stepped.impulse_as_force) if point.stepped else (0, False)
        tick = next((m.value for m in point.others if m.hypothesis.part == "clock tick"), 0.0)
        steps = [tick / parts for parts in PARTS] if tick else self._steps
        for step, gyroscopic, rotation in product(steps, GYROSCOPIC, ROTATION):
            other = replace(scheme, gyroscopic=gyroscopic, rotation=rotation)
            yield Point(_without(point.others, "steps"), SteppedScheme(other, step, late, force))
        if not tick:
            others = (*_without(point.others, "steps"), *self._as_forces(scheme.damping))
            for method in self._methods:
                yield Point((*others, method), None)
            yield Point(others, None)

    def _with_fitted_length(self, point: Point) -> Iterator[Point]:
        """Yield the same scheme with the parts of a row interval next to the step that fits best."""
        mistakes, spacing = self._mistakes(point), self._evaluator.context.spacing_s
        place = next((n for n, m in enumerate(mistakes) if m.hypothesis.part == "steps"), None)
        if place is None or any(m.hypothesis.part == "clock tick" for m in point.others):
            return
        if point.stepped is None and not mistakes[place].hypothesis.fitted:
            return
        free = replace(mistakes[place].hypothesis, values=(spacing / MOST_PARTS, spacing))
        step = Mistake(free, mistakes[place].value)
        fitted = self._fitter.fit((*mistakes[:place], step, *mistakes[place + 1 :]), [*self._free(point), free])
        nearest = round(spacing / fitted[place].value)
        for number in range(max(1, nearest - 1), nearest + 2):
            if self._evaluator.context.duration <= MOST_STEPS * spacing / number:
                yield self._with_values(_with_step(point, spacing / number), fitted)

    def _with_other_details(self, point: Point) -> Iterator[Point]:
        """Yield other updates of the centre, and other numbers of first steps without gravity."""
        if point.stepped is None or not self._evaluator.context.program.gravity.any():
            return
        scheme = point.stepped.scheme
        others = [replace(scheme, idle_steps=idle) for idle in (0, 1, 2)]
        for other in (*others, *(replace(scheme, position_substeps=number) for number in (1, 4))):
            yield replace(point, stepped=replace(point.stepped, scheme=other))
        moves = _without(point.others, "position step")
        for others in (moves, *((*moves, move) for move in self._moves)):
            yield replace(point, others=others)

    def _with_other_places(self, point: Point) -> Iterator[Point]:
        """Yield other places of the damping in a step; the rotation that fits then is another one, too."""
        if point.stepped is None:
            return
        scheme = point.stepped.scheme
        for place, rotation in (
            product(DAMPING_PLACES, ROTATION) if scheme.damping.linear or scheme.damping.angular else ()
        ):
            if place != scheme.damping.place:
                other = replace(scheme, rotation=rotation, damping=replace(scheme.damping, place=place))
                yield replace(point, stepped=replace(point.stepped, scheme=other))

    def _with_other_readings(self, point: Point) -> Iterator[Point]:
        """Yield rows that lie between ticks: of the last one, the one before, or interpolated."""
        if point.stepped is None or any(m.hypothesis.part in CLOCK_PARTS for m in point.others):
            return
        others = _without(point.others, "clock tick")
        for reading in self._readings:
            for parts in PARTS[:2]:
                yield Point((*others, reading), replace(point.stepped, step=reading.value / parts, late=0))

    def _with_other_times(self, point: Point) -> Iterator[Point]:
        """Yield rows that are late or early, and impulses over a step."""
        if any(m.hypothesis.part.startswith("clock") for m in point.others):
            return
        if point.stepped is None:
            yield from (Point((*point.others, self._hypotheses.late(ticks)), None) for ticks in LATE if ticks)
            return
        forces = (False, True) if self._evaluator.context.program.impulses and self._may_last(point) else (False,)
        for late, force in product(LATE, forces):
            yield replace(point, stepped=replace(point.stepped, late=late, impulse_as_force=force))

    def _may_last(self, point: Point) -> bool:
        return all(mistake.hypothesis.part != "impulse" for mistake in point.others)

    def _as_forces(self, damping: Damping) -> Mistakes:
        """Return the damping of a scheme as in a method that evaluates it as a force."""
        rates = {"linear-damping": damping.linear, "angular-damping": damping.angular}
        return tuple(Mistake(h, rate) for h in self._evaluator.hypotheses if (rate := rates.get(h.name)))

    def _damped(self, point: Point, others: list[Point]) -> list[Point]:
        """Return points with damping; among them the best rough scheme, since others may be methods without any."""
        rough = (Point(_without(point.others, "steps"), stepped) for stepped in self.rough)
        if best := min(rough, key=self._weight, default=None):
            others = [*others, min((best, *self._with_other_times(best)), key=self._weight)]
        return [self._with_damping(other) for other in others]

    def _with_damping(self, point: Point) -> Point:
        """Return a point with damping of both velocities, if it has none."""
        taken = {mistake.hypothesis.part for mistake in point.others}
        if point.stepped is None or not taken.isdisjoint(DAMPINGS):
            return point
        damping, rate = point.stepped.scheme.damping, 1 / self._evaluator.context.duration
        if damping.linear or damping.angular:
            return point
        scheme = replace(point.stepped.scheme, damping=replace(damping, linear=rate, angular=rate))
        return replace(point, stepped=replace(point.stepped, scheme=scheme))

    def _with_own_damping(self, point: Point) -> Point:
        """Return a point whose damping is a part of its scheme."""
        rates = {
            DAMPINGS[m.hypothesis.part]: m.value
            for m in point.others
            if m.hypothesis.name in ("linear-damping", "angular-damping")
        }
        if not rates or point.stepped is None:
            return point
        others = tuple(m for m in point.others if m.hypothesis.part not in DAMPINGS)
        scheme = replace(point.stepped.scheme, damping=Damping(rates.get("linear", 0.0), rates.get("angular", 0.0)))
        return Point(others, replace(point.stepped, scheme=scheme))

    # --- values -------------------------------------------------------------------------------------------------------

    def _refined(self, point: Point) -> Point:
        """Return a point whose mistake has a refined value."""
        (mistake,) = point.others
        refined = self._fitter.refined_one(self._mistakes(point), mistake.hypothesis)
        return self._with_values(point, refined)

    def _fitted(self, point: Point) -> Point:
        """Return a point with fitted values."""
        return self._with_values(point, self._fitter.fit(self._mistakes(point), self._free(point)))

    def _free(self, point: Point) -> list[Hypothesis]:
        """Return what is fitted: all but the step."""
        return [m.hypothesis for m in self._mistakes(point) if m.hypothesis.part not in ("steps", "clock offset")]

    def _with_values(self, point: Point, mistakes: Mistakes) -> Point:
        values = {mistake.hypothesis: mistake.value for mistake in mistakes}
        others = tuple(Mistake(m.hypothesis, values.get(m.hypothesis, m.value)) for m in point.others)
        if point.stepped is None:
            return Point(others, None)
        own = {m.hypothesis for m in point.others}
        rates = {
            DAMPINGS[h.part]: value for h, value in values.items() if h.part in DAMPINGS and h.fitted and h not in own
        }
        damping = replace(point.stepped.scheme.damping, **rates)
        return Point(others, replace(point.stepped, scheme=replace(point.stepped.scheme, damping=damping)))

    def _mistakes(self, point: Point) -> Mistakes:
        if point.stepped is None:
            return self._evaluator.ordered(point.others)
        scheme = self._hypotheses.mistakes(point.stepped, fitted=True)
        taken = {mistake.hypothesis.part for mistake in point.others}
        own = tuple(mistake for mistake in scheme if mistake.hypothesis.part not in taken)
        return self._evaluator.ordered((*point.others, *own))

    def _weight(self, point: Point) -> float:
        return self._evaluator.quick_weight(self._mistakes(point))


def _without(mistakes: Mistakes, part: str) -> Mistakes:
    return tuple(mistake for mistake in mistakes if mistake.hypothesis.part != part)


def _with_step(point: Point, step: float) -> Point:
    """Return a point with a step of another length."""
    if point.stepped:
        return replace(point, stepped=replace(point.stepped, step=step))
    steps = (Mistake(m.hypothesis, step) if m.hypothesis.part == "steps" else m for m in point.others)
    return Point(tuple(steps), None)
