"""Grades one file: reads it, measures its errors, searches for their cause, and decides how certain that is."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from time import process_time
from typing import TYPE_CHECKING

import numpy as np

from tumble.compare.grade.hypotheses.engine_schemes import ENGINES, EngineScheme
from tumble.compare.grade.hypotheses.explanation import NEARLY_RIGHT, WHOLE, Explanation, step_divides
from tumble.compare.grade.hypotheses.hypothesis import Context
from tumble.compare.grade.hypotheses.mistakes import hypotheses
from tumble.compare.grade.hypotheses.names import BETWEEN_TICKS
from tumble.compare.grade.measure.conserved import fitted_pose
from tumble.compare.grade.measure.errors import Measured, SampledRows, measure, size_of
from tumble.compare.grade.measure.observations import observations
from tumble.compare.grade.measure.offset import constant_offset
from tumble.compare.grade.measure.significance import (
    ALIKE,
    EXPLAINED,
    FEWEST_ROWS,
    KERNEL_ERROR,
    LARGE_FLOOR,
    LARGEST_NOISE,
    ResidualScale,
    independent,
    typical_floor,
)
from tumble.compare.grade.measure.single_precision import fine_step, single_floor, stepwise
from tumble.compare.grade.measure.spin import spin_mistake
from tumble.compare.grade.model.program_model import correct_program, output_points
from tumble.compare.grade.model.reference import Reference
from tumble.compare.grade.read.columns import BadTrajectory, Description
from tumble.compare.grade.read.conventions import Conventions
from tumble.compare.grade.read.trajectory import Trajectory
from tumble.compare.grade.search.diagnosis import Diagnosis, diagnosed
from tumble.compare.grade.search.evaluator import Evaluator
from tumble.compare.grade.verdicts import (
    CORRECT_TO_DIGITS,
    CORRECT_TO_NOISE,
    CORRECT_TO_RESOLUTION,
    CORRECT_TO_SINGLE,
    EXPLAINED_PARTLY,
    EXPLAINED_WHOLLY,
    TOO_COARSE,
    TOO_FEW,
    TOO_LITTLE,
    UNEXPLAINED,
)
from tumble.compare.run.progress import Progress, ProgressCallback, no_progress
from tumble.kernel_cache import compilation
from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Scene

if TYPE_CHECKING:
    from tumble.compare.grade.contact_grade import ContactGrade

# Errors below this many floors are attributed only to a known engine scheme that explains most of them.
BARELY = 10.0
# A residual is accepted as noise, and as single precision that nothing shows, only if it is at most this share of the
# error.
LEFT_AS_NOISE, LEFT_AS_SINGLE = 0.2, 0.05
# An explanation that leaves more than this share of the error does not explain it; one that leaves less than the other
# explains nearly all of it.
MOST_LEFT, LITTLE_LEFT = 0.5, 0.1
# A single number that leaves no more than this share has not been fitted to what something else left.
NOTHING_LEFT = 1e-3
# Relative tolerance of distances between vertices, in addition to the printed digits.
STRAIN = 1e-6
# Errors below this share of the body's size are too small to identify a step or a clock.
LITTLE = 1e-6

# A factor that differs from 1 by less, beside other fitted values, was fitted to something else; so were more values
# than this.
NEARLY_RIGHT_OF_SEVERAL, MOST_FITTED = 1e-2, 3
# Row intervals that differ by less than this share are the same but for their rounding; rounding of a time.
EVEN, ROUNDING = 0.2, 1e-9
# Printed digits that leave more than this share of the body's size open show it neither right nor wrong.
COARSE = LARGEST_NOISE

# Share of files called explained whose mistakes were named right, measured by `tools/random_programs`: of those with an
# engine's whole scheme or with one mistake, and with several.
RIGHT_IF_ONE, RIGHT_IF_SEVERAL = 0.97, 0.94
# Single precision that explains more than so many times what the digits leave open explains much, or very much; and the
# most mistakes that are called an explanation even so, or before all others were tried, or if one of them explains
# almost any error and noise is left.
MUCH_BY_SINGLE, VERY_MUCH_BY_SINGLE, MOST_IF_OPEN = 10.0, 1e4, 2

# Processor time after which a search stops [s], and that of the shortest one on a slow machine.
SEARCH_S, SHORTEST_S = 2.0, 1.0
# The tasks that take long: reading rows, the truth, the search.
TASKS = 3


@dataclass(frozen=True, eq=False)
class Grade:
    """The result of `tumble grade` for one file.

    Parameters
    ----------
    file : name of the file
    scene : the scene
    measured : the errors
    diagnosis : explanations of the errors; None: none was searched for
    spin : what is wrong with the angular velocity; empty: nothing
    scale : what residuals are compared to
    observations : sentences about the file
    contact : of a scene with a plane, the contact in the file
    hidden_by_single : whether single precision would explain the errors, but the digits do not show that it is there
    decided_s : time of the last row that is diagnosed [s]; single precision could explain any error in later ones
    """

    file: str
    scene: Scene
    measured: Measured
    diagnosis: Diagnosis | None
    spin: str
    scale: ResidualScale
    observations: tuple[str, ...] = ()
    contact: "ContactGrade | None" = None
    hidden_by_single: bool = False
    decided_s: float = np.inf

    @cached_property
    def verdict(self) -> str:
        """One of `verdicts`."""
        if self.contact is not None:
            found = self.diagnosis is not None and self.diagnosis.best.within_floor and self.diagnosis.best.mistakes
            return EXPLAINED_PARTLY if found else self.contact.verdict
        measured, diagnosis = self.measured, self.diagnosis
        if measured.worst_m <= measured.resolution_m:
            return CORRECT_TO_RESOLUTION
        if measured.excess_m <= 0:
            return TOO_COARSE if self.is_coarse else CORRECT_TO_DIGITS
        if diagnosis is None:
            return TOO_FEW
        if self.is_coarse and diagnosis.null.weighted_rms_m <= BARELY * self.scale.floor_m:
            return TOO_COARSE
        if diagnosis.best is diagnosis.null and diagnosis.null.within_floor:
            if measured.single and not diagnosis.is_open:
                return CORRECT_TO_SINGLE
            return CORRECT_TO_NOISE if self._is_all_noise else TOO_LITTLE
        best, is_hidden = diagnosis.best, self.hidden_by_single or diagnosis.is_open
        if best.drift and not best.mistakes:
            return TOO_LITTLE
        if not best.mistakes or best.weight > diagnosis.null.weight - ALIKE:
            # Single precision grows with the steps, so its effect is not white.
            if diagnosis.null.is_noise and self._is_all_noise:
                return CORRECT_TO_NOISE
            if is_hidden or (diagnosis.null.is_noise and diagnosis.null.in_common <= EXPLAINED):
                return TOO_LITTLE
            return TOO_LITTLE if measured.worst_m <= LITTLE * self.scale.size_m else UNEXPLAINED
        # Where digits alone are left, single precision is not there.
        floors = diagnosis.null.weighted_rms_m / self.scale.floor_m
        is_barely = (diagnosis.null.in_digits if best.in_digits <= EXPLAINED else floors) <= BARELY
        if is_barely and not (diagnosis.engines and _leaves(diagnosis, MOST_LEFT)):
            return TOO_LITTLE
        # A part of errors that are hardly larger than digits and noise is of anything.
        is_little = diagnosis.is_open or (diagnosis.null.in_common <= BARELY and not diagnosis.engines)
        in_part = TOO_LITTLE if is_little else EXPLAINED_PARTLY
        if self._leaves_nothing(diagnosis):
            # Where rounding has grown to the error itself, the rows before are explained.
            is_part = best.rms_m > MOST_LEFT * diagnosis.null.rms_m and not diagnosis.engines
            return in_part if is_part or self._is_contrived(diagnosis) or self.is_open else EXPLAINED_WHOLLY
        if is_hidden:
            return TOO_LITTLE
        # Any method of higher order explains a part of an error that is as small as it leaves.
        guessed = all(m.hypothesis.part == "steps" and m.hypothesis.only_named for m in best.mistakes)
        partly = not guessed and _leaves(diagnosis, MOST_LEFT)
        return in_part if partly and not self._is_contrived(diagnosis) else UNEXPLAINED

    def _leaves_nothing(self, diagnosis: Diagnosis) -> bool:
        """Whether the best explanation leaves only what digits, single precision or noise may.

        What leaves most of the error has explained nothing.  Noise, and single precision of no engine's scheme that the
        digits do not show, may be the rest of most errors: so only a small part of them is taken for that.
        """
        best, null = diagnosis.best, diagnosis.null
        # Where a motion amplifies rounding, the last rows may hold nothing else; those that it moves less decide.
        left = min(best.rms_m / null.rms_m, best.in_common / null.in_common)
        if left > MOST_LEFT:
            return False
        if not best.within_floor:
            return best.is_noise and best.rms_m <= LEFT_AS_NOISE * null.rms_m
        is_shown = self.measured.single or best.in_digits <= EXPLAINED or bool(diagnosis.engines)
        return is_shown or left <= LEFT_AS_SINGLE

    @property
    def _is_all_noise(self) -> bool:
        """Whether the errors of all rows are noise."""
        measured = self.measured
        return self.scale.is_noise(measured.rms_m, measured.worst_m, measured.autocorrelation, measured.pairs)

    def without_guesses(self) -> "Grade":
        """Return the grade with a part of a contrived explanation, or one mistake, that explains nearly all errors.

        The values of the rest were fitted to what something unknown leaves.
        """
        diagnosis = self.diagnosis
        if diagnosis is None or not self._is_contrived(diagnosis):
            return self
        steps = diagnosis.steps
        parts = [steps[: number + 1] for number in range(len(steps) - 2, 0, -1)]
        for part in (*parts, *((steps[0], one) for one in diagnosis.alone)):
            simpler = replace(diagnosis, best=part[-1], steps=part, alike=())
            graded = replace(self, diagnosis=simpler)
            guessed = any(m.is_nearly_right(NEARLY_RIGHT_OF_SEVERAL) for m in part[-1].fitted)
            if not guessed and graded.verdict == EXPLAINED_PARTLY and _leaves(simpler, LITTLE_LEFT):
                return graded
        return self

    @cached_property
    def confidence(self) -> float | None:
        """Probability that the explanation, or one as good, is right; None if the file is not explained."""
        if self.verdict != EXPLAINED_WHOLLY or self.diagnosis is None:
            return None
        if self.diagnosis.engines or len(self.diagnosis.best.mistakes) == 1:
            return RIGHT_IF_ONE
        return RIGHT_IF_SEVERAL

    @property
    def is_open(self) -> bool:
        """Whether another explanation may be as good, of three or more mistakes that are no engine's scheme.

        It is if single precision, which the digits do not show, has to explain very much of what the mistakes leave, or
        much of it and a fitted value is none that a person writes; and if not all others were tried in the time, unless
        no such value was fitted, or one, and the mistakes leave only what the digits do, or noise.  Digits of rows
        between ticks never show it: there, any explanation by values that a person writes may leave very much.
        """
        if self.diagnosis is None or self.diagnosis.engines or len(self.diagnosis.best.mistakes) <= MOST_IF_OPEN:
            return False
        best, fitted = self.diagnosis.best, self.diagnosis.best.odd_values
        most = MUCH_BY_SINGLE if fitted else VERY_MUCH_BY_SINGLE
        may_be_there = self.measured.single or (not fitted and _is_between_ticks(best, self.measured.spacing_s))
        by_single = best.within_floor and best.in_digits > most and not may_be_there
        leaves_nothing = best.is_noise or best.in_digits <= EXPLAINED
        return by_single or (self.diagnosis.stopped_s > 0 and fitted > leaves_nothing)

    def _is_contrived(self, diagnosis: Diagnosis) -> bool:
        """Whether the best explanation has values that no program has: they were fitted to what something else left.

        These are a step that is no part of a row interval or of a tick, a tick that is nearly the row
        interval, factors that are nearly 1, too many values without a name, and those of a mistake that explains a part
        of almost any error.  The last do not count where only digits are left; nor where noise is, beside at most one
        mistake; nor, beside no other fitted value, where single precision is; nor if they are vectors in few digits, of
        which some are zero.
        """
        if diagnosis.engines:
            return False
        fitted, is_alone = diagnosis.best.fitted, len(diagnosis.best.mistakes) == 1
        if (
            any(m.hypothesis.vague and not (m.hypothesis.scale and m.has_plain_value) for m in fitted)
            and diagnosis.best.in_digits > EXPLAINED
            and not (diagnosis.best.is_noise and len(diagnosis.best.mistakes) <= MOST_IF_OPEN)
            and not (self.measured.single and len(fitted) == 1)
            and not (is_alone and fitted[0].hypothesis.dimension == 1 and _leaves(diagnosis, NOTHING_LEFT))
        ):
            return True
        near = NEARLY_RIGHT_OF_SEVERAL if len(fitted) > 1 else NEARLY_RIGHT
        if len(fitted) > MOST_FITTED or any(m.is_nearly_right(near) for m in fitted):
            return True
        values = {m.hypothesis.part: m for m in diagnosis.best.mistakes}
        if "clock tick" in values and not values["clock tick"].has_named_value:
            rows = values["clock tick"].value / self.measured.spacing_s
            if _is_whole(rows):  # nearly the row interval, or a multiple
                return True
        rows = self.measured.sample.times / self.measured.spacing_s
        if np.abs(rows - rows.round()).max() > WHOLE:
            return False  # a step divides no interval of uneven rows
        return not step_divides(diagnosis.best.mistakes, self.measured.spacing_s)

    @property
    def is_coarse(self) -> bool:
        """Whether the printed digits are too coarse to show the body's motion."""
        return self.measured.half_m > COARSE * self.scale.size_m

    @cached_property
    def strain(self) -> float:
        """Largest relative error of a distance between two vertices; 0 of a single vertex."""
        sample = self.measured.sample
        apart = [np.linalg.norm(np.diff(where, axis=1), axis=-1) for where in (sample.vertices, sample.true)]
        if not apart[0].size:
            return 0.0
        worst = np.abs(apart[0] - apart[1])
        allowed = 2 * np.linalg.norm(sample.half, axis=1)[:, None] + STRAIN * apart[1]
        return float(np.where(worst > allowed, worst / apart[1], 0.0).max())


def grade(
    path: Path,
    scene: Scene,
    mapping: Mapping[str, str],
    by: str | None = None,
    decimal: str = ".",
    on_measured: Callable[[Measured, Sequence[str]], None] = lambda measured, observed: None,
    conventions: Conventions | None = None,
    engines: Sequence[EngineScheme] = ENGINES,
    on_nearest: Callable[[Explanation], None] = lambda _: None,
    on_progress: ProgressCallback = no_progress,
    search_s: float = SEARCH_S,
    answer_s: float = np.inf,
) -> Grade:
    """Grade one file.

    Parameters
    ----------
    path, scene : the file and the scene that it is graded against
    mapping : names of columns, column -> name
    by : the description to grade if the file has several: pose, matrix or vertices
    decimal : decimal sign
    on_measured : called with the errors and the observations, before a search
    conventions : axes, Euler angles and start of the file
    engines : the engine schemes that are tried
    on_nearest : called with the nearest engine scheme if none fits and a search begins
    on_progress : called with the shares of TASKS tasks
    search_s : processor time after which the search stops with the best explanation so far [s]
    answer_s : processor time of this process in which the answer should be there [s]; a search is shortened for it

    Returns
    -------
    the grade

    Raises
    ------
    BadTrajectory : the file cannot be read, or is ambiguous
    NoTruth : the scene has no reference solution over the file's duration
    RayMissed : an impulse misses the body
    """
    trajectory = Trajectory(path, scene, mapping, by, decimal, conventions)
    if not trajectory.descriptions:
        raise BadTrajectory(f"{trajectory.name}: has readings of a sensor, but no pose")
    measured, searched = measure(trajectory, scene, on_progress), Progress("search", on_progress)
    sample, throw = measured.sample, measured.throw
    if scene.plane is not None:
        from tumble.compare.grade.contact_grade import grade_contact  # with all that contact needs, 40 ms

        contact = grade_contact(trajectory, scene, measured, Reference(scene).first_contact(throw))
        diagnosis, scale = None, scale_of(sample, scene)
        if contact.is_wrong_before:
            # The flight up to the first contact is that of a scene without the plane.
            sample = sample.some(contact.early)
            flight = replace(scene, plane=None, duration=float(sample.times[-1]))
            context = context_of(flight, throw, replace(measured, sample=sample))
            scale = scale_of(sample, flight)
            single = measured.single, measured.single
            left_s = search_time(search_s, answer_s)
            diagnosis = diagnose(
                context, measured.description, sample, scale, *single, engines, on_nearest, searched, left_s
            )
        searched.end()
        return Grade(trajectory.name, scene, measured, diagnosis, "", scale, contact=contact)
    context = context_of(scene, throw, measured)
    sample, scale, single = compared(measured, context)
    diagnosis = None
    observed: tuple[str, ...] = ()
    if measured.excess_m > 0 and len(sample) > 1:
        points = output_points(scene.body)[list(measured.description.vertices)]
        has_centre = measured.description.has_centre
        offset = constant_offset(sample, points, scale.floors_m) if has_centre else None
        observed = tuple(observations(measured, sample, scene, scale.floors_m, points, offset))
        on_measured(measured, observed)
        if offset is not None and offset.body.any():
            context = replace(context, offset=offset.body)
        known = single, measured.single
        left_s = search_time(search_s, answer_s)
        diagnosis = diagnose(
            context, measured.description, sample, scale, *known, engines, on_nearest, searched, left_s
        )
    searched.end()
    program = diagnosis.program if diagnosis else context.program
    graded = Grade(
        file=trajectory.name,
        scene=scene,
        measured=measured,
        diagnosis=diagnosis,
        spin=spin_mistake(sample, program),
        scale=scale,
        observations=observed,
        hidden_by_single=measured.may_be_single and not single,
        decided_s=float(sample.times[-1]),
    )
    return graded.without_guesses()


def search_time(search_s: float, answer_s: float) -> float:
    """Return the processor time that a search may take [s]: less than asked for, if the answer would be late.

    answer_s: processor time of this process, without that of compiling kernels, in which the answer should be there
    [s].
    """
    return min(search_s, max(SHORTEST_S, answer_s - (process_time() - compilation.processor_s)))


def _leaves(diagnosis: Diagnosis, share: float) -> bool:
    """Return whether the best explanation leaves at most a share of the error, of early rows and of all alike.

    Rows are most precise at the start, when the errors are still small.
    """
    best, null = diagnosis.best, diagnosis.null
    return best.weighted_rms_m <= share * null.weighted_rms_m and best.rms_m <= share * null.rms_m


def _is_between_ticks(explanation: Explanation, spacing_s: float) -> bool:
    """Return whether most rows, spacing_s apart, are made up of two ticks: these are no numbers of single precision."""
    ticks = [m.value for m in explanation.mistakes if m.hypothesis.name in BETWEEN_TICKS]
    return any(not _is_whole(tick / spacing_s) for tick in ticks)


def _is_whole(rows: float) -> bool:
    """Return whether a number of row intervals is nearly a whole one."""
    return abs(rows - round(rows)) < WHOLE * rows


def compared(measured: Measured, context: Context) -> tuple[SampledRows, ResidualScale, bool]:
    """Return the rows that are diagnosed, their scale, and whether the program may be of single precision.

    The effect of that grows with the steps.  If it could explain all errors, only rows in which it is small can show an
    error.  If the digits do not even show that the file is of single precision, it is not taken for the reason.
    """
    sample, scene = measured.sample, context.scene
    scale = scale_of(sample, scene)
    if not measured.may_be_single:
        return sample, scale, False
    points = output_points(scene.body)[list(measured.description.vertices)]
    single_m = single_floor(stepwise(context.program, fine_step(context.spacing_s)), sample.times, points)
    single = scale.with_single(single_m)
    if single.in_floors(sample.vertices - sample.true) > EXPLAINED:
        return sample, scale, True
    if not measured.single:
        return sample, scale, False
    small = single_m <= LARGE_FLOOR * scale.size_m
    if small.all() or small.sum() < FEWEST_ROWS:
        return sample, scale, True
    return sample.some(small), scale_of(sample.some(small), scene), True


def scale_of(sample: SampledRows, scene: Scene) -> ResidualScale:
    """Return the scale that residuals are compared to.

    The floor is the root mean square of the printed digits, the resolution of the truth, and the kernel's own error.
    """
    size_m = size_of(scene)
    resolution = np.zeros(len(sample)) if sample.resolution is None else sample.resolution
    known_m2 = resolution**2 + (KERNEL_ERROR * size_m) ** 2
    floors_m = np.sqrt((sample.half**2 + known_m2[:, None]) / 3)
    return ResidualScale(independent(len(sample), sample.vertices.shape[1]), typical_floor(floors_m), size_m, floors_m)


def context_of(scene: Scene, throw: int, measured: Measured) -> Context:
    """Return what hypotheses know of the throw that is diagnosed."""
    sample, description = measured.sample, measured.description
    duration = float(sample.times[-1])
    reference = Reference(scene)
    rate = float(np.linalg.norm(reference.states(throw, sample.times)[:, 10:13], axis=1).max())
    return Context(
        scene=scene,
        program=correct_program(scene, throw, measured.rounding_s),
        kind=description.kind,
        rows=measured.rows,
        duration=duration,
        turn_s=min(1 / rate, duration) if rate else duration,
        spacing_s=row_interval(measured),
        first=first_pose(sample, scene.body.points[list(description.vertices)]),
        has_centre=description.has_centre,
        fineness=reference.fineness(throw),
    )


def row_interval(measured: Measured) -> float:
    """Return the interval of most rows [s]: one over a whole number, if the printed times allow that."""
    spacing, intervals = measured.spacing_s, measured.intervals
    even = intervals[np.abs(intervals - spacing) < EVEN * spacing]
    if len(even) == 0:
        return spacing
    mean = float(even.mean())
    rate = round(1 / mean)
    known = 2 * measured.rounding_s / len(even) if len(even) == len(intervals) else 2 * measured.rounding_s
    return 1 / rate if rate and abs(mean - 1 / rate) <= known + ROUNDING * mean else mean


def first_pose(sample: SampledRows, points: Array) -> Array | None:
    """Return x [m] and q, (7,), of the row at t = 0; None if there is no such row, or too few vertices show it."""
    if sample.times[0] > 0 or len(points) < 4:
        return None
    return fitted_pose(sample.vertices[:1], points)[0]


def diagnose(
    context: Context,
    description: Description,
    sample: SampledRows,
    scale: ResidualScale,
    single: bool = False,
    is_known: bool = False,
    engines: Sequence[EngineScheme] = ENGINES,
    on_nearest: Callable[[Explanation], None] = lambda _: None,
    on_progress: Callable[[float], object] = lambda share: None,
    search_s: float = np.inf,
) -> Diagnosis:
    """Return what explains the sampled rows of one throw.

    single: its numbers may be of single precision; is_known: they are; on_progress: called with the share of the search
    that is done; search_s: processor time after which the search stops [s].
    """
    points = output_points(context.scene.body)[list(description.vertices)]
    evaluator = Evaluator(context, hypotheses(context), sample, points, scale, single, is_known)
    return diagnosed(evaluator, engines, on_nearest, on_progress, search_s)
