"""Attitude of a body whose angular velocity is known: q' = w q / 2, w in the plane's frame."""

import math

from tumble.solver.compilation import inner
from tumble.solver.integrators.magnus6 import EARLY, LATE, turn_of
from tumble.solver.quaternion import Quaternion, conjugate, exponential, product
from tumble.solver.vectors import Vector, add, cross, dot, scale

# Radians of a step, so that what a step of order six leaves out is rounding.
TURN, MOST_STEPS = 0.06, 100_000


@inner
def turned_by(q: Quaternion, early: Vector, middle: Vector, late: Vector, length: float) -> Quaternion:
    """Return q a step on; the angular velocity at the three nodes of the step, and its length.

    Seen the other way about, q* turns by -w on its right: the step of `magnus6`.
    """
    turn = turn_of(scale(-length, early), scale(-length, middle), scale(-length, late))
    return conjugate(product(conjugate(q), turn))


@inner
def turned_steadily(q: Quaternion, w: Vector, w_rate: Vector, t: float) -> Quaternion:
    """Return q after t [s] for an angular velocity w + w_rate t."""
    across = cross(w, w_rate)
    if dot(across, across) <= 1e-32 * dot(w, w) * dot(w_rate, w_rate):
        return product(exponential(scale(0.5, add(scale(t, w), scale(0.5 * t * t, w_rate)))), q)
    size = math.sqrt(dot(w, w)) + math.sqrt(dot(w_rate, w_rate)) * t
    steps = min(max(math.ceil(size * t / TURN), 4), MOST_STEPS)
    length = t / steps
    for step in range(steps):
        begun = step * length
        q = turned_by(
            q,
            add(w, scale(begun + EARLY * length, w_rate)),
            add(w, scale(begun + 0.5 * length, w_rate)),
            add(w, scale(begun + LATE * length, w_rate)),
            length,
        )
    return q
