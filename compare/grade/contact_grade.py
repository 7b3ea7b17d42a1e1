"""Grades the contact in a file: which law its impacts and motions along a plane follow, and a verdict."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tumble.compare.grade.hypotheses.contact_mistakes import contact_hypotheses
from tumble.compare.grade.measure.contact_motion import ContactMotion, contact_motion
from tumble.compare.grade.measure.errors import Measured
from tumble.compare.grade.measure.significance import LARGEST_NOISE
from tumble.compare.grade.model.contact_law import after_impact
from tumble.compare.grade.read.trajectory import Trajectory
from tumble.compare.grade.search.contact_search import (
    DIGITS,
    PARTLY,
    ContactExplanation,
    ContactMistake,
    ContactSearch,
)
from tumble.scenarios.scene import Scene

CORRECT_TO_RESOLUTION = "correct"
CORRECT_TO_DIGITS = "correct to the printed digits"
TOO_COARSE = "too coarse to grade"
EXPLAINED_WHOLLY = "explained"
EXPLAINED_PARTLY = "explained in part"
UNEXPLAINED = "not explained"
# Verdicts that only contact has: right but for delays of a step; and nothing that a law can be held to.
CORRECT_TO_STEP = "correct to its step"
NOTHING_SEEN = "no contact to judge"
# A first-order program is off by half a step of what it has gained; a file may be by this many.
STEP_OFF = 0.6
# Mistakes of this name must be visible in a file that is called right.
DECISIVE = ("contact-restitution-squared", "contact-friction-squared")


@dataclass(frozen=True)
class ContactRow:
    """One observable of a file: its value, the law's for what the file shows just before, and how much may differ."""

    time: float
    name: str
    unit: str
    value: float
    expected: float


@dataclass(frozen=True, eq=False)
class ContactGrade:
    """The contact in one throw of a file.

    Parameters
    ----------
    motion : what the file shows
    search : the laws that were tried
    measured : the errors of the file
    ends : whether the reference ends before the file does
    """

    motion: ContactMotion
    search: ContactSearch
    measured: Measured
    ends: bool

    @cached_property
    def verdict(self) -> str:
        """One of the verdicts of docs/grade.md."""
        m = self.measured
        if m.excess_m <= 0 and not (self.ends and not self.follows):
            if m.worst_m <= m.resolution_m:
                return CORRECT_TO_RESOLUTION
            return TOO_COARSE if m.half_m > LARGEST_NOISE * self.motion.scene.body.reach else CORRECT_TO_DIGITS
        if self.explanations:
            return EXPLAINED_WHOLLY if self.is_whole else EXPLAINED_PARTLY
        if self.search.is_empty:
            return NOTHING_SEEN
        if not self.follows or self.is_wrong_before:
            return UNEXPLAINED
        return TOO_COARSE if self.is_coarse else CORRECT_TO_STEP

    @cached_property
    def is_wrong_before(self) -> bool:
        """Whether the body is off before it first touches the plane by more than a step of the program explains."""
        motion, sample = self.motion, self.measured.sample
        touches = min((one.time for one in motion.impacts), default=np.inf)
        if motion.lasting:
            touches = min(touches, float(motion.rows.times[motion.lasting[0].first]))
        late = max((one.late for one in motion.impacts if np.isfinite(one.late)), default=0.0)
        early = sample.times < touches - late - motion.rows.spacing_s
        start, reach = motion.scene.start[0], motion.scene.body.reach
        spin = 0.0 if motion.scene.body.radius else float(np.linalg.norm(start[10:13]))
        gained = sample.times * (float(np.linalg.norm(motion.pull)) + 2 * reach * spin**2)
        room = STEP_OFF * motion.rows.spacing_s * gained + DIGITS * np.linalg.norm(sample.half, axis=1)
        off = np.linalg.norm(sample.vertices - sample.true, axis=-1).max(axis=1)
        return bool((off > room + self.measured.resolution_m)[early].any())

    @cached_property
    def shown(self) -> ContactMistake | None:
        """A mistake that the motion shows by itself."""
        return self.search.shown()

    @cached_property
    def follows(self) -> bool:
        """Whether everything in the file follows the scene's law, to its step and digits."""
        return self.shown is None and self.search.null.fits

    @cached_property
    def by_step(self) -> ContactMistake | None:
        """Gravity before the bounce, which only the size of the step distinguishes from a right program."""
        return self.search.gravity_first() if self.follows else None

    @cached_property
    def is_coarse(self) -> bool:
        """Whether the steps and digits of a file that follows the law would hide a restitution or friction squared."""
        search = self.search
        law = search.right
        hidden = [
            one
            for one in contact_hypotheses(law, self.motion.pull, ())
            if one.name in DECISIVE and search.fitted((one,), law, ()).fits
        ]
        known = [one for one in contact_hypotheses(law, self.motion.pull, ()) if one.name in DECISIVE]
        return bool(known) and len(hidden) == len(known)

    @cached_property
    def explanations(self) -> list[ContactExplanation]:
        """The best explanation and those that fit equally well; empty if none explains most of the error."""
        law = self.search.right
        single = self.shown or self.by_step
        if single is not None:
            return [ContactExplanation((single,), (), law)]
        if self.follows or self.search.is_empty:
            return []
        best, *others = self.search.explanations
        if not best.fits and max(best.misses) > PARTLY * max(self.search.null.misses):
            return []
        alike = [one for one in others if one.fits and one.rank <= best.rank] if best.fits else []
        return [best, *alike]

    @property
    def is_whole(self) -> bool:
        """Whether the best explanation leaves nothing."""
        return bool(self.explanations) and (not self.explanations[0].misses or self.explanations[0].fits)

    @property
    def mistakes(self) -> tuple[ContactMistake, ...]:
        """The mistakes of the best explanation."""
        return self.explanations[0].mistakes if self.explanations else ()

    @cached_property
    def observables(self) -> tuple[ContactRow, ...]:
        """What the file shows of each impact and each motion along the plane, beside the law's."""
        return (*self._of_impacts(), *self._of_slides())

    def _of_impacts(self) -> Iterator[ContactRow]:
        law, body = self.search.right, self.motion.scene.body
        for one in self.search.judged:
            v, w = after_impact(body, one.before, law)
            yield ContactRow(one.time, "restitution", "", max(0.0, one.rebound) / one.approach, law.restitution)
            gained, due = (after - one.before.v for after in (one.v, v))
            if gained[2] > 0 and due[2] > 0 and law.friction:
                ratio, true = (float(np.hypot(*each[:2]) / each[2]) for each in (gained, due))
                yield ContactRow(one.time, "friction over normal impulse", "", ratio, true)
                spin, due_spin = (float(np.linalg.norm(after - one.before.w)) for after in (one.w, w))
                yield ContactRow(one.time, "change of spin", "rad/s", spin, due_spin)

    def _of_slides(self) -> Iterator[ContactRow]:
        for one in self.search.slid:
            found = self.search.slide_by(one, self.search.right)
            start, middle = float(found.times[0]), len(found.times) // 2
            way, due = (float(np.linalg.norm(each[-1])) for each in (found.places, found.x))
            yield ContactRow(start, "distance along the plane", "m", way, due)
            if min(way, due) > 1e-3 * max(way, due):
                first, then = (
                    float(np.degrees(np.arctan2(each[-1, 1], each[-1, 0]))) for each in (found.places, found.x)
                )
                yield ContactRow(start, "turn of the path", "deg", (first - then + 180) % 360 - 180, 0.0)
            took = float(found.times[-1] - found.times[middle])
            late, true = (float(np.linalg.norm(each[-1] - each[middle])) / took for each in (found.places, found.x))
            yield ContactRow(start, "mean speed in its second half", "m/s", late, true)


def grade_contact(trajectory: Trajectory, scene: Scene, measured: Measured) -> ContactGrade:
    """Grade the contact in the throw of a file with the largest error.

    Parameters
    ----------
    trajectory : the file
    scene : with a plane and gravity
    measured : the errors of the file

    Returns
    -------
    the grade
    """
    motion = contact_motion(trajectory, scene, measured)
    ends = float(motion.rows.times[-1]) > float(measured.sample.times[-1])
    return ContactGrade(motion, ContactSearch(motion), measured, ends)
