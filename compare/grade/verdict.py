"""Grades one file: reads it, measures it, looks for what is wrong, and says how sure that is."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from compare.grade.account import truthful
from compare.grade.columns import Shown
from compare.grade.diagnosis import Diagnosis, Search
from compare.grade.flights import Flights
from compare.grade.foreign import Trajectory
from compare.grade.hypotheses import Question
from compare.grade.mistakes import hypotheses
from compare.grade.noise import ALIKE, FLIGHT, Scale, independent
from compare.grade.reference import Reference
from compare.grade.residual import Kept, Measured, measure
from compare.grade.spin import spin_mistake
from scenarios.scene import Scene

# Half the last bit of a single-precision number, relative to it; a flight in single precision ends within so many.
HALF_SINGLE = 2.0**-24
SINGLES = 100
# An explanation that leaves more than this share of the error has not explained it.
MOST_LEFT = 0.5
# Quaternions and edges are as long as they should be within this, or within what the digits leave open.
STRAIN = 1e-6
# Errors below this share of the body's size are of a step or a clock, too little to be told apart.
LITTLE = 1e-6

CORRECT_TO_LIMIT = "correct"
CORRECT_TO_DIGITS = "correct to the printed digits"
CORRECT_TO_SINGLE = "correct to single precision"
CORRECT_TO_NOISE = "correct to its noise"
TOO_LITTLE = "too little to explain"
EXPLAINED_WHOLLY = "explained"
EXPLAINED_PARTLY = "explained in part"
UNEXPLAINED = "not explained"
TOO_FEW = "too few rows to explain"


@dataclass(frozen=True, eq=False)
class Grade:
    """What `tumble grade` found of one file; diagnosis is None where there is nothing to explain."""

    file: str
    scene: Scene
    measured: Measured
    diagnosis: Diagnosis | None
    spin: str
    scale: Scale

    @cached_property
    def verdict(self) -> str:
        """One of the verdicts above."""
        measured, diagnosis = self.measured, self.diagnosis
        if measured.worst_m <= measured.limit_m:
            return CORRECT_TO_LIMIT
        if measured.excess_m <= 0:
            return CORRECT_TO_DIGITS
        if diagnosis is None:
            return TOO_FEW if len(measured.kept) < 2 else CORRECT_TO_SINGLE
        if diagnosis.nothing.nothing:
            return CORRECT_TO_DIGITS if measured.excess_m <= measured.half_m else TOO_LITTLE
        best = diagnosis.best
        if not best.mistakes or best.weight > diagnosis.nothing.weight - ALIKE:
            if self.scale.is_noise(measured.rms_m, measured.relation, measured.pairs):
                return CORRECT_TO_NOISE
            return TOO_LITTLE if measured.worst_m <= LITTLE * self.scale.size_m else UNEXPLAINED
        if best.is_whole:
            return EXPLAINED_WHOLLY
        return EXPLAINED_PARTLY if best.rms_m <= MOST_LEFT * diagnosis.nothing.rms_m else UNEXPLAINED

    @cached_property
    def strain(self) -> float:
        """By how much a distance between two vertices is off, relative to it; 0 of a single vertex."""
        kept = self.measured.kept
        apart = [np.linalg.norm(np.diff(where, axis=1), axis=-1) for where in (kept.vertices, kept.true)]
        if not apart[0].size:
            return 0.0
        worst = np.abs(apart[0] - apart[1])
        room = 2 * kept.half[:, None] + STRAIN * apart[1]
        return float(np.where(worst > room, worst / apart[1], 0.0).max())


def grade(path: Path, scene: Scene, mapping: Mapping[str, str], by: str | None = None, decimal: str = ".") -> Grade:
    """Grade one file.  Raises BadTrajectory, NoTruth, RayMissed."""
    trajectory = Trajectory(path, scene, mapping, by, decimal)
    measured = measure(trajectory, scene)
    kept, throw = measured.kept, measured.throw
    scale = scale_of(kept, scene, measured.limit_m)
    diagnosis = None
    # What single precision leaves at the coordinates there are is no mistake of the program's to look for.
    single_m = SINGLES * HALF_SINGLE * float(np.abs(kept.true).max())
    single = measured.single and measured.worst_m <= single_m
    if measured.excess_m > 0 and len(kept) > 1 and not single:
        diagnosis = diagnose(scene, throw, measured.shown, kept, scale)
    account = diagnosis.account if diagnosis else truthful(scene, throw)
    return Grade(trajectory.name, scene, measured, diagnosis, spin_mistake(kept, account), scale)


def scale_of(kept: Kept, scene: Scene, limit_m: float) -> Scale:
    """Return what residuals of the rows kept are held against.

    The floor is of printed digits, of the truth and of compiled flights, root mean square.
    """
    size_m = float(np.ptp(scene.body.points, axis=0).max())
    floor_m = float(np.sqrt(np.mean(kept.half**2) / 3 + limit_m**2 + (FLIGHT * size_m) ** 2))
    return Scale(independent(len(kept), kept.vertices.shape[1]), floor_m, size_m)


def diagnose(scene: Scene, throw: int, shown: Shown, kept: Kept, scale: Scale) -> Diagnosis:
    """Look for what explains the rows kept of one throw."""
    points = scene.body.points[list(shown.vertices)]
    duration = float(kept.times[-1])
    rate = float(np.linalg.norm(Reference(scene).states(throw, kept.times)[:, 10:13], axis=1).max())
    turn_s = min(1 / rate, duration) if rate else duration
    question = Question(scene, truthful(scene, throw), shown.kind, len(kept), duration, turn_s)
    return Search(Flights(question, hypotheses(question), kept, points, scale)).diagnose()
