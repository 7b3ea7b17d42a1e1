"""The mistakes that are tried, in the order in which a program makes them: what is written down comes last.

A new one is one more entry in the file of its part.
"""

from tumble.compare.grade.hypotheses.hypothesis import Hypothesis, Question
from tumble.compare.grade.hypotheses.mistakes.body_size import size
from tumble.compare.grade.hypotheses.mistakes.clocks import clocks
from tumble.compare.grade.hypotheses.mistakes.forces import forces
from tumble.compare.grade.hypotheses.mistakes.impulses import impulses
from tumble.compare.grade.hypotheses.mistakes.output import writings
from tumble.compare.grade.hypotheses.mistakes.rotation import rotation
from tumble.compare.grade.hypotheses.mistakes.start import start
from tumble.compare.grade.hypotheses.mistakes.steps import steps

PARTS = (start, impulses, forces, size, rotation, steps, clocks, writings)


def hypotheses(question: Question) -> list[Hypothesis]:
    """Return every mistake that the scene and the file leave room for."""
    return [hypothesis for part in PARTS for hypothesis in part(question)]
