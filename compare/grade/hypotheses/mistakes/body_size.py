"""A body whose size differs from the scene: the scene or the program is wrong."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import permutations

import numpy as np

from tumble.compare.grade.hypotheses.hypothesis import Context, Hypothesis, choice, grid
from tumble.compare.grade.model.program_model import ProgramModel, with_output_transform
from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Impulse

TWICE = {0.5: "half edges used as edges", 2.0: "edges used as half edges"}


def body_size(context: Context) -> Iterator[Hypothesis]:
    """Yield that a box has other edges, with the resulting inertia, vertices and points of impulses."""
    if context.scene.body.size is None:
        return
    axes = [(f"along {axis}", np.eye(3)[number]) for number, axis in enumerate("xyz")]
    # A box scaled by one factor moves as with another inertia, except for its vertices.
    if context.kind == "vertices":
        axes.append(("", np.ones(3)))
    for which, along in axes:
        yield Hypothesis(
            f"wrong-body-size-{which}".rstrip("-").replace(" ", "-"),
            "body size",
            f"edges of the body{f' {which}' if which else ''} {{}} times those in the scene",
            _resized(along, context.kind == "vertices"),
            grid(0.2, 5.0, 13),
            named_values=TWICE,
            neutral=1.0,
        )
    edges = context.scene.body.size
    orders = [order for order in permutations(range(3)) if not np.allclose(edges[list(order)], edges)]
    if orders:
        yield Hypothesis(
            "edges-permuted",
            "body size",
            "edges of the body permuted: x y z have those of {}",
            lambda program, number: _with_edges(
                program, edges[list(orders[int(number)])] / edges, context.kind == "vertices"
            ),
            choice(len(orders)),
            tuple(" ".join("xyz"[axis] for axis in order) for order in orders),
        )


def _resized(along: Array, vertices: bool) -> Callable[[ProgramModel, float], ProgramModel]:
    def change(program: ProgramModel, factor: float) -> ProgramModel:
        if factor == 1:
            return program
        return _with_edges(program, factor**along, vertices)

    return change


def _with_edges(program: ProgramModel, by: Array, vertices: bool) -> ProgramModel:
    """Return the program with the body's edges multiplied by factors, (3,)."""
    assert program.body.size is not None
    before, after = (np.square(size) for size in (program.body.size, by * program.body.size))
    moments = program.moments * (after.sum() - after) / (before.sum() - before)  # of a box, about its middle
    impulses = tuple(_moved(impulse, by, program.body.points) for impulse in program.impulses)
    changed = program.but(moments=moments, impulses=impulses)
    return with_output_transform(changed, lambda pose: pose._replace(axes=pose.axes * by)) if vertices else changed


def _moved(impulse: Impulse, by: Array, points: Array) -> Impulse:
    """Return an impulse at a vertex moved with the vertex, any other unchanged."""
    at = impulse.point_body
    return replace(impulse, point_body=by * at) if at is not None and (points == at).all(axis=1).any() else impulse
