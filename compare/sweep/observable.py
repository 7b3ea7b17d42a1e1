"""Error of one observable of contact against run time.

Above a plane the positions at samples are off by the speed times the delay of every contact.  An observable is not:
its error is measured on a ladder of steps as in the study of contact, and its run time is that of the whole scene.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import accumulate

import numpy as np

from tumble.compare.contact.asked import Asked
from tumble.compare.contact.findings import COMPONENT
from tumble.compare.contact.limit import Level
from tumble.compare.contact.study import Contact, Extent, Question, question
from tumble.compare.judge.cost import Timed
from tumble.compare.run.truths import true_answer
from tumble.compare.sweep.schemas import ObservableCostRow
from tumble.compare.sweep.work_precision import Sweep
from tumble.scenarios.format import nearest
from tumble.scenarios.refusal import UserError
from tumble.scenarios.scene import Scene

LADDER = Extent(ladder=tuple(2.0**level for level in range(3, -5, -1)))
# The main observable of a scene: the first of these that it has.
MAIN = (
    "distance until",
    "velocity after impact",
    "mean precession",
    "creep speed",
    "mean acceleration",
    "height at rest",
    "deepest",
)


class BadObservable(UserError):
    """An observable that a scene does not have; the message is the one line for the user."""


@dataclass(frozen=True, eq=False)
class Observed:
    """One observable of a scene: what is asked, a part for each component, and the question that has no other."""

    name: str
    impact: int | None
    parts: tuple[Asked, ...]
    question: Question

    @property
    def size(self) -> float:
        """What the error is divided by: the true value, or the scale of one that is zero."""
        return math.hypot(*(part.true for part in self.parts)) or self.parts[0].scale or 1.0


def observed_in(scene: Scene, name: str | None, limit_s: float) -> Observed | None:
    """Return the observable of a scene that is swept; None where it has no plane, or no observable.

    name: as in contact.csv, of a vector without its component; None: the main one; limit_s: of the truth [s].
    Raises BadObservable.
    """
    if name and scene.plane is None:
        raise BadObservable(f"--observable: {scene.name} has no plane, so that it has no observable of contact")
    asked = question(scene, true_answer(scene, limit_s=limit_s).truth, None, LADDER) if scene.plane else None
    known = list(dict.fromkeys(COMPONENT.sub("", one.observable) for one in asked.asked)) if asked else []
    if name and name not in known:
        raise BadObservable(f"--observable: {scene.name} has no observable {name!r}: {nearest(name, known)}")
    chosen = name or next((one for start in MAIN for one in known if one.startswith(start)), "")
    if asked is None or not chosen:
        return None
    own = [one for one in asked.asked if COMPONENT.sub("", one.observable) == chosen]
    impact = own[0].impact
    alone = replace(
        asked,
        whole=asked.whole if impact is None else None,
        impacts=tuple(one for one in asked.impacts if one.number == impact),
        turned=None,
        scans=(),
    )
    return Observed(chosen, impact, tuple(one for one in own if one.impact == impact), alone)


def with_observable(sweep: Sweep, observed: Observed, contacts: Sequence[Contact]) -> Sweep:
    """Return a sweep with the errors of an observable, and the run times that its timing gives them.

    contacts: of all contestants, to the observable's question (`compare.contact.study.ask`).
    """
    timed = {each.run.name: each for each in sweep.timed if not each.reading.doubt}
    found = [
        row
        for contact in contacts
        if contact.name in timed
        for row in cost_rows(contact, observed, timed[contact.name])
    ]
    best = accumulate((row.error for row in sorted(found, key=cheapest_first)), min, initial=math.inf)
    front = {
        id(row) for row, before in zip(sorted(found, key=cheapest_first), best, strict=False) if row.error < before
    }
    return replace(sweep, observed=tuple(replace(row, pareto_front=id(row) in front) for row in found))


def cheapest_first(row: ObservableCostRow) -> tuple[float, float]:
    """Return the key that sorts rows by their run time."""
    return row.run_us, row.error


def cost_rows(contact: Contact, observed: Observed, timed: Timed) -> Iterator[ObservableCostRow]:
    """Yield a contestant's error and run time at every step at which the observable could be read."""
    ladders = [contact.readings.ladders.get(part.key, []) for part in observed.parts]
    for levels in zip(*ladders, strict=True):
        error = error_of(observed, levels)
        if not math.isfinite(error):
            continue
        dt = levels[0].dt_s
        steps = math.ceil(contact.scene.duration / dt * (1 - 1e-12)) if timed.per_step else 1
        run_us = timed.reading.ns * steps / 1e3
        yield ObservableCostRow(
            scene=contact.scene.name,
            engine=contact.engine,
            method=contact.method,
            dt_s=dt if contact.tolerance is None else math.nan,
            tolerance=contact.tolerance,
            observable=observed.name,
            blow=observed.impact,
            unit=observed.parts[0].unit,
            error=error,
            error_share=error / observed.size,
            run_us=run_us,
            p90_run_us=run_us * timed.reading.spread[1] / timed.reading.ns,
            pareto_front=False,
        )


def error_of(observed: Observed, levels: Sequence[Level]) -> float:
    """Return the error at one step, of a vector its length, at the worst position in a step; nan if unknown."""
    if len({len(level.values) for level in levels}) > 1:
        return math.nan
    off = np.stack([level.values - part.true for level, part in zip(levels, observed.parts, strict=True)])
    return float(np.linalg.norm(off, axis=0).max())
