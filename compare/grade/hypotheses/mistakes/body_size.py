"""A body of another size than the scene says: the scene, or the program, is what is wrong."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import permutations

import numpy as np

from tumble.compare.grade.hypotheses.hypothesis import Hypothesis, Question, choice, grid
from tumble.compare.grade.model.program_model import Account, with_writing
from tumble.scenarios.frames import Array
from tumble.scenarios.mass import box
from tumble.scenarios.scene import Impulse

# Nobody has an edge wrong by so little, and any small error would be taken for it.
LEAST = 0.02
TWICE = {0.5: "half edges taken for edges", 2.0: "edges taken for half edges"}


def size(question: Question) -> Iterator[Hypothesis]:
    """Yield that a box has other edges, with the inertia, the vertices and the points struck that follow from them."""
    if question.scene.body.size is None:
        return
    axes = [(f"along {axis}", np.eye(3)[number]) for number, axis in enumerate("xyz")]
    # A box that is larger by one factor flies as with another inertia, but for where its vertices are.
    if question.kind == "vertices":
        axes.append(("", np.ones(3)))
    for which, along in axes:
        yield Hypothesis(
            f"another size {which}".rstrip(),
            "body size",
            f"the body's {f'edge {which} is' if which else 'edges are'} {{}} times what the scene says",
            _resized(along, question.kind == "vertices"),
            grid(0.2, 5.0, 13),
            known=TWICE,
            rare=True,
            of_scene=True,
        )
    edges = question.scene.body.size
    orders = [order for order in permutations(range(3)) if not np.allclose(edges[list(order)], edges)]
    if orders:
        yield Hypothesis(
            "edges in another order",
            "body size",
            "the body's edges are in another order than the scene says: x y z have those of {}",
            lambda account, number: _with_edges(
                account, edges[list(orders[int(number)])] / edges, question.kind == "vertices"
            ),
            choice(len(orders)),
            tuple(" ".join("xyz"[axis] for axis in order) for order in orders),
            rare=True,
            of_scene=True,
        )


def _resized(along: Array, vertices: bool) -> Callable[[Account, float], Account]:
    def change(account: Account, factor: float) -> Account:
        if abs(factor - 1) < LEAST:
            return account
        return _with_edges(account, factor**along, vertices)

    return change


def _with_edges(account: Account, by: Array, vertices: bool) -> Account:
    """Return the account of a body whose edges are so many times as long, (3,)."""
    assert account.body.size is not None
    moments = account.moments * np.diag(box(1.0, by * account.body.size).tensor)
    moments = moments / np.diag(box(1.0, account.body.size).tensor)
    impulses = tuple(_moved(impulse, by, account.body.points) for impulse in account.impulses)
    changed = replace(account, moments=moments, impulses=impulses)
    return with_writing(changed, lambda pose: pose._replace(axes=pose.axes * by)) if vertices else changed


def _moved(impulse: Impulse, by: Array, points: Array) -> Impulse:
    """Return an impulse that strikes a vertex where the vertex is now, any other as it was."""
    at = impulse.point_body
    return replace(impulse, point_body=by * at) if at is not None and (points == at).all(axis=1).any() else impulse
