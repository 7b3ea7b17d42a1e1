"""The mistakes that are tried, in the order in which a program makes them: the output comes last.

A new mistake is one more entry in the file of its part.
"""

from tumble.compare.grade.hypotheses.hypothesis import Context, Hypothesis
from tumble.compare.grade.hypotheses.mistakes.body_size import body_size
from tumble.compare.grade.hypotheses.mistakes.clocks import clocks
from tumble.compare.grade.hypotheses.mistakes.forces import forces
from tumble.compare.grade.hypotheses.mistakes.impulses import impulses
from tumble.compare.grade.hypotheses.mistakes.output import output
from tumble.compare.grade.hypotheses.mistakes.rotation import rotation
from tumble.compare.grade.hypotheses.mistakes.scene_forces import scene_forces
from tumble.compare.grade.hypotheses.mistakes.start import start
from tumble.compare.grade.hypotheses.mistakes.steps import steps

PARTS = (start, impulses, scene_forces, forces, body_size, rotation, steps, clocks, output)


def hypotheses(context: Context) -> list[Hypothesis]:
    """Return every mistake that is possible in a scene and a file."""
    return [hypothesis for part in PARTS for hypothesis in part(context)]
