"""The mistakes of a file that `tumble grade` explains, and the evaluator with which it does."""

from pathlib import Path

from tumble.compare.grade.grade import SEARCH_S, context_of, grade, scale_of
from tumble.compare.grade.hypotheses.mistakes import hypotheses
from tumble.compare.grade.measure.errors import measure
from tumble.compare.grade.model.program_model import output_points
from tumble.compare.grade.read.trajectory import Trajectory
from tumble.compare.grade.search.evaluator import Evaluator
from tumble.compare.grade.verdicts import EXPLAINED_WHOLLY


def explained(file, scene, search_s=SEARCH_S):
    """Return the mistakes of a file that is explained, by name: their values; search_s: of processor time [s]."""
    found = grade(Path(file), scene, {}, search_s=search_s)
    assert found.verdict == EXPLAINED_WHOLLY, found.diagnosis.best.names
    return {mistake.hypothesis.name: mistake.value for mistake in found.diagnosis.best.mistakes}


def evaluator_of(file, scene, single=False):
    """Return what evaluates mistakes against the rows of a file, and every mistake that there is.

    single: the program may be of single precision.
    """
    measured = measure(Trajectory(Path(file), scene, {}), scene)
    context = context_of(scene, 0, measured)
    every = hypotheses(context)
    scale = scale_of(measured.sample, scene)
    return Evaluator(context, every, measured.sample, output_points(scene.body), scale, single), every
