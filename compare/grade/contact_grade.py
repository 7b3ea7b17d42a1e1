"""Grades the contact in a file: which law its impacts and motions along a plane follow, and a verdict."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tumble.compare.grade.measure.contact_motion import ContactMotion, contact_motion
from tumble.compare.grade.measure.errors import Measured
from tumble.compare.grade.measure.significance import LARGEST_NOISE
from tumble.compare.grade.read.trajectory import Trajectory
from tumble.compare.grade.search.contact_search import (
    DIGITS,
    FAR_LESS,
    PARTLY,
    ContactExplanation,
    ContactMistake,
    ContactSearch,
)
from tumble.compare.grade.verdicts import (
    CORRECT_TO_DIGITS,
    CORRECT_TO_RESOLUTION,
    CORRECT_TO_STEP,
    EXPLAINED_PARTLY,
    EXPLAINED_WHOLLY,
    NOTHING_SEEN,
    TOO_COARSE,
    UNEXPLAINED,
)
from tumble.scenarios.scene import Scene

# Rows before the first contact that show whether the flight is right; what it may be off beside that, of the shift by
# a step and of the body.
FEWEST, OF_SHIFT, OF_SIZE = 3, 0.01, 1e-5
# What the scene's law may leave without a look at other laws [units].
SUSPECT = 0.2
# What mistakes may leave at most of the misses of a law that nearly fits: with fitted values, and without.
MUCH_LESS, LESS = 0.25, 0.6
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
    touches : when the body first touches the plane by the reference [s]
    """

    motion: ContactMotion
    search: ContactSearch
    measured: Measured
    ends: bool
    touches: float

    @cached_property
    def verdict(self) -> str:
        """One of the verdicts of docs/grade.md."""
        m = self.measured
        if m.excess_m <= 0 and not (self.ends and not self.follows):
            if m.worst_m <= m.resolution_m:
                return CORRECT_TO_RESOLUTION
            return TOO_COARSE if m.half_m > LARGEST_NOISE * self.motion.scene.body.reach else CORRECT_TO_DIGITS
        if self.is_wrong_before:
            return UNEXPLAINED
        if self.explanations:
            return EXPLAINED_WHOLLY if self.is_whole else EXPLAINED_PARTLY
        if self.search.is_empty:
            return NOTHING_SEEN
        if not self.follows:
            return UNEXPLAINED
        return TOO_COARSE if self.is_coarse else CORRECT_TO_STEP

    @cached_property
    def early(self) -> np.ndarray:
        """The sampled rows before the body first touches the plane, in the file and by the reference, (S,)."""
        motion = self.motion
        touches = min(
            [self.touches, *(one.time - max(0.0, one.late) for one in motion.impacts if one.late == one.late)]
        )
        if motion.lasting:
            touches = min(touches, float(motion.rows.times[motion.lasting[0].first]))
        return self.measured.sample.times < touches - motion.rows.spacing_s

    @cached_property
    def is_wrong_before(self) -> bool:
        """Whether the body is off before it first touches the plane by more than a step of the program explains.

        A first-order program is off by half a step of what its velocity has gained.
        """
        motion, sample = self.motion, self.measured.sample.some(self.early)
        if len(sample) < FEWEST:
            return False
        body, spin = motion.scene.body, float(np.linalg.norm(motion.scene.start[0, 10:13]))
        assert motion.scene.gravity is not None
        gained = sample.times[:, None] * motion.scene.gravity
        centre = (sample.vertices - sample.true).mean(axis=1)
        late = float((centre * gained).sum() / max((gained * gained).sum(), np.finfo(float).tiny))
        late = float(np.clip(late, -STEP_OFF * motion.rows.spacing_s, STEP_OFF * motion.rows.spacing_s))
        left = np.linalg.norm(sample.vertices - sample.true - late * gained[:, None], axis=-1).max(axis=1)
        turned = 0.0 if body.radius else STEP_OFF * motion.rows.spacing_s * 2 * body.reach * spin**2
        half = np.linalg.norm(sample.half, axis=1) + self.measured.resolution_m
        room = DIGITS * half + turned * sample.times + OF_SHIFT * np.linalg.norm(centre, axis=1) + OF_SIZE * body.reach
        return bool((left > room).any())

    @cached_property
    def shown(self) -> ContactMistake | None:
        """A mistake that the motion shows by itself."""
        return self.search.shown()

    @cached_property
    def follows(self) -> bool:
        """Whether everything in the file follows the scene's law, to its step and digits."""
        search = self.search
        if self.shown is not None or search.is_empty:
            return self.shown is None
        return not self.fits_better if search.null.fits else search.nearly_fits and not self.explains_better

    @cached_property
    def fits_better(self) -> bool:
        """Whether a mistake without a value leaves far less than the scene's law, which its step would still allow."""
        search = self.search
        left = max(search.null.misses)
        if left < SUSPECT:
            return False
        named = [one for one in search.hypotheses if not one.values]
        return any(max(search.fitted(one, search.right).misses) < FAR_LESS * left for one in named)

    @cached_property
    def explains_better(self) -> bool:
        """Whether the best explanation leaves much less than the scene's law does."""
        best, null = self.search.explanations[0], self.search.null
        # In units that no law changes: viscous friction hides its step, and so has wide ones.
        return self.search.is_supported(best) and max(best.apart) < (MUCH_LESS if best.rank[1] else LESS) * max(
            null.apart
        )

    @cached_property
    def by_step(self) -> ContactMistake | None:
        """Gravity before the bounce, which only the size of the step distinguishes from a right program."""
        return self.search.gravity_first() if self.follows else None

    @cached_property
    def is_coarse(self) -> bool:
        """Whether the steps and digits of a file that follows the law would hide a restitution or friction squared."""
        search = self.search
        found = (search.fitted(one, search.right) for one in search.hypotheses if one.name in DECISIVE)
        # A body that holds on an incline may hold with less friction too: that is no question of steps and digits.
        decisive = [one for one in found if not np.allclose(one.misses, search.null.misses, rtol=1e-3, atol=1e-6)]
        return bool(decisive) and all(one.fits for one in decisive)

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
        if not self.search.is_supported(best):
            return []
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
        law = self.search.right
        for one in self.search.judged:
            v, w = self.search.after(one, law)
            if one.chain:
                speeds = (float(np.linalg.norm(each)) for each in (one.v, v))
                yield ContactRow(one.time, "speed after impacts of several corners", "m/s", *speeds)
                continue
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


def grade_contact(trajectory: Trajectory, scene: Scene, measured: Measured, touches: float) -> ContactGrade:
    """Grade the contact in the throw of a file with the largest error.

    Parameters
    ----------
    trajectory : the file
    scene : with a plane and gravity
    measured : the errors of the file
    touches : when the body first touches the plane by the reference [s]

    Returns
    -------
    the grade
    """
    motion = contact_motion(trajectory, scene, measured)
    ends = float(motion.rows.times[-1]) > float(measured.sample.times[-1])
    return ContactGrade(motion, ContactSearch(motion), measured, ends, touches)
