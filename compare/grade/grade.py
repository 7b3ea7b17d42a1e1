"""Grades one file: reads it, measures it, looks for what is wrong, and says how sure that is."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from tumble.compare.grade.hypotheses.engine_schemes import ENGINES, Law
from tumble.compare.grade.hypotheses.explanation import Explanation
from tumble.compare.grade.hypotheses.hypothesis import Question
from tumble.compare.grade.hypotheses.mistakes import hypotheses
from tumble.compare.grade.measure.conserved import posed
from tumble.compare.grade.measure.errors import Kept, Measured, measure
from tumble.compare.grade.measure.observations import sightings
from tumble.compare.grade.measure.offset import constant_drift, constant_offset
from tumble.compare.grade.measure.significance import ALIKE, FLIGHT, LOUDEST, Scale, independent
from tumble.compare.grade.measure.single_precision import in_steps, single_floor
from tumble.compare.grade.measure.spin import spin_mistake
from tumble.compare.grade.model.program_model import truthful
from tumble.compare.grade.model.reference import Reference
from tumble.compare.grade.read.columns import Shown
from tumble.compare.grade.read.conventions import Reading
from tumble.compare.grade.read.trajectory import Trajectory
from tumble.compare.grade.search.diagnosis import Diagnosis, Search
from tumble.compare.grade.search.evaluator import Flights
from tumble.compare.run.progress import Progress, ProgressCallback, no_progress
from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Scene

# Of the floor: an error no larger than so many of it is of an engine that is known, or of nobody that could be named.
BARELY = 10.0
# Noise is believed to be all that is left only where it is so much less than the error.
LEFT_AS_NOISE = 0.2
# An explanation that leaves more than this share of the error has not explained it.
MOST_LEFT = 0.5
# Quaternions and edges are as long as they should be within this, or within what the digits leave open.
STRAIN = 1e-6
# Errors below this share of the body's size are of a step or a clock, too little to be told apart.
LITTLE = 1e-6

# Digits that leave more than this share of the body's size open show it neither right nor wrong.
COARSE = LOUDEST

# What takes long: the rows, the truth, the search.
PIECES = 3

CORRECT_TO_LIMIT = "correct"
CORRECT_TO_DIGITS = "correct to the printed digits"
CORRECT_TO_SINGLE = "correct to single precision"
CORRECT_TO_NOISE = "correct to its noise"
TOO_LITTLE = "too little to explain"
EXPLAINED_WHOLLY = "explained"
EXPLAINED_PARTLY = "explained in part"
UNEXPLAINED = "not explained"
TOO_FEW = "too few rows to explain"
TOO_COARSE = "too coarse to judge"


@dataclass(frozen=True, eq=False)
class Grade:
    """What `tumble grade` found of one file; diagnosis is None where there is nothing to explain; seen: sentences."""

    file: str
    scene: Scene
    measured: Measured
    diagnosis: Diagnosis | None
    spin: str
    scale: Scale
    seen: tuple[str, ...] = ()

    @cached_property
    def verdict(self) -> str:
        """One of the verdicts above."""
        measured, diagnosis = self.measured, self.diagnosis
        if measured.worst_m <= measured.resolution_m:
            return CORRECT_TO_LIMIT
        if measured.excess_m <= 0:
            return TOO_COARSE if self.is_coarse else CORRECT_TO_DIGITS
        if diagnosis is None:
            return TOO_FEW
        if self.is_coarse and diagnosis.nothing.weighed_m <= BARELY * self.scale.floor_m:
            return TOO_COARSE
        if diagnosis.nothing.nothing:
            return CORRECT_TO_SINGLE if measured.single else TOO_LITTLE
        best = diagnosis.best
        if not best.mistakes or best.weight > diagnosis.nothing.weight - ALIKE:
            if diagnosis.nothing.noise and self.scale.is_noise(
                measured.rms_m, measured.worst_m, measured.relation, measured.pairs
            ):
                return CORRECT_TO_NOISE
            return TOO_LITTLE if measured.worst_m <= LITTLE * self.scale.size_m else UNEXPLAINED
        if not diagnosis.engines and diagnosis.nothing.weighed_m <= BARELY * self.scale.floor_m:
            return TOO_LITTLE
        if best.nothing or (best.noise and best.rms_m <= LEFT_AS_NOISE * diagnosis.nothing.rms_m):
            return EXPLAINED_WHOLLY
        # Of an error as small as a method of higher order leaves, any of them takes some away.
        guessed = all(m.hypothesis.part == "steps" and m.hypothesis.only_known for m in best.mistakes)
        partly = best.weighed_m <= MOST_LEFT * diagnosis.nothing.weighed_m and not guessed
        return EXPLAINED_PARTLY if partly else UNEXPLAINED

    @property
    def is_coarse(self) -> bool:
        """Whether the printed digits leave too much open to see how the body moves."""
        return self.measured.half_m > COARSE * self.scale.size_m

    @cached_property
    def strain(self) -> float:
        """By how much a distance between two vertices is off, relative to it; 0 of a single vertex."""
        kept = self.measured.kept
        apart = [np.linalg.norm(np.diff(where, axis=1), axis=-1) for where in (kept.vertices, kept.true)]
        if not apart[0].size:
            return 0.0
        worst = np.abs(apart[0] - apart[1])
        room = 2 * np.linalg.norm(kept.half, axis=1)[:, None] + STRAIN * apart[1]
        return float(np.where(worst > room, worst / apart[1], 0.0).max())


def grade(
    path: Path,
    scene: Scene,
    mapping: Mapping[str, str],
    by: str | None = None,
    decimal: str = ".",
    tell: Callable[[Measured, Sequence[str]], None] = lambda measured, seen: None,
    reading: Reading | None = None,
    engines: Sequence[Law] = ENGINES,
    nearest: Callable[[Explanation], None] = lambda _: None,
    on_progress: ProgressCallback = no_progress,
) -> Grade:
    """Grade one file.

    tell: is told what is known before a search; reading: what is said of the whole file; engines: whose laws are tried;
    nearest: is told which of them leaves least, where none is enough and a search begins; on_progress: called with
    shares of the rows, the truth and the search, PIECES in all.
    Raises BadTrajectory, NoTruth, RayMissed.
    """
    trajectory = Trajectory(path, scene, mapping, by, decimal, reading)
    measured, searched = measure(trajectory, scene, on_progress), Progress("search", on_progress)
    kept, throw = measured.kept, measured.throw
    question = question_of(scene, throw, measured)
    scale = scale_of(kept, scene, measured.resolution_m, single_of(measured, question))
    diagnosis = None
    seen: tuple[str, ...] = ()
    if measured.excess_m > 0 and len(kept) > 1:
        points = scene.body.points[list(measured.shown.vertices)]
        offset = constant_offset(kept, points, scale.floors_m) if measured.shown.centred else None
        seen = tuple(sightings(measured, scene, scale.floors_m, points, offset))
        tell(measured, seen)
        if offset is not None and offset.body.any():
            question = replace(question, offset=offset.body)
        elif measured.shown.centred and (drift := constant_drift(kept, points, scale.floors_m)) is not None:
            question = replace(question, drift=np.stack(drift))
        diagnosis = diagnose(question, measured.shown, kept, scale, measured.single, engines, nearest, searched)
    searched.end()
    account = diagnosis.account if diagnosis else question.account
    return Grade(trajectory.name, scene, measured, diagnosis, spin_mistake(kept, account), scale, seen)


def single_of(measured: Measured, question: Question) -> Array | float:
    """Return what single precision leaves of a right flight, one step a row, (S,), where numbers are of it."""
    if not measured.single:
        return 0.0
    points = question.scene.body.points[list(measured.shown.vertices)]
    return single_floor(in_steps(question.account, measured.spacing_s), measured.kept.times, points)


def scale_of(kept: Kept, scene: Scene, resolution_m: float, single_m: Array | float = 0.0) -> Scale:
    """Return what residuals of the rows kept are held against.

    The floor is of printed digits, of the truth, of compiled flights and of single precision, root mean square.
    """
    size_m = float(np.ptp(scene.body.points, axis=0).max())
    known_m2 = resolution_m**2 + (FLIGHT * size_m) ** 2 + np.broadcast_to(np.square(single_m), len(kept))
    floors_m = np.sqrt((kept.half**2 + known_m2[:, None]) / 3)
    # Rows that are known well count for more, so the floor is that of most of them.
    floor_m = float(np.sqrt(3.0) * np.median(floors_m))
    return Scale(independent(len(kept), kept.vertices.shape[1]), floor_m, size_m, floors_m)


def question_of(scene: Scene, throw: int, measured: Measured) -> Question:
    """Return what hypotheses may know of the throw that is diagnosed."""
    kept, shown = measured.kept, measured.shown
    duration = float(kept.times[-1])
    rate = float(np.linalg.norm(Reference(scene).states(throw, kept.times)[:, 10:13], axis=1).max())
    turn_s = min(1 / rate, duration) if rate else duration
    account = truthful(scene, throw, measured.rounding_s)
    first = first_pose(kept, scene.body.points[list(shown.vertices)])
    return Question(
        scene, account, shown.kind, measured.rows, duration, turn_s, measured.spacing_s, first, shown.centred
    )


def first_pose(kept: Kept, points: Array) -> Array | None:
    """Return x [m] and q, (7,), of the row at t = 0; None where there is none, or too few vertices show it."""
    if kept.times[0] > 0 or len(points) < 4:
        return None
    return posed(kept.vertices[:1], points)[0]


def diagnose(
    question: Question,
    shown: Shown,
    kept: Kept,
    scale: Scale,
    single: bool = False,
    engines: Sequence[Law] = ENGINES,
    nearest: Callable[[Explanation], None] = lambda _: None,
    tell: Callable[[float], object] = lambda share: None,
) -> Diagnosis:
    """Look for what explains the rows kept of one throw.

    single: its numbers are of single precision; tell: is told what share of the search is done.
    """
    points = question.scene.body.points[list(shown.vertices)]
    flights = Flights(question, hypotheses(question), kept, points, scale, single, tell)
    return Search(flights, engines, nearest).diagnose()
