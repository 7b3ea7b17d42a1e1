"""Whether a body that lies on the plane presses within the points it lies on, or tips over an edge of theirs."""

import math

import numpy as np
from numpy.typing import NDArray

from tumble.solver.compilation import inner
from tumble.solver.contact.ground import Ground, lever_of
from tumble.solver.quaternion import Quaternion

Pair = tuple[float, float]
# Of the body's reach: what is no length but for rounding.
ROUNDED = 2.0**-40


@inner
def places_of(q: Quaternion, touching: NDArray[np.int64], count: int, ground: Ground) -> NDArray[np.float64]:
    """Return where the touching points are along the plane, from the centre [m], (count, 2)."""
    places = np.empty((count, 2))
    for number in range(count):
        lever = lever_of(q, touching[number], ground)
        places[number, 0], places[number, 1] = lever[0], lever[1]
    return places


@inner
def _left_of(places: NDArray[np.float64], a: int, b: int, x: float, y: float) -> float:
    """Return how far a place is to the left of the line from a to b [m]."""
    along_x, along_y = places[b, 0] - places[a, 0], places[b, 1] - places[a, 1]
    size = math.hypot(along_x, along_y)
    return (along_x * (y - places[a, 1]) - along_y * (x - places[a, 0])) / size if size > 0.0 else math.inf


@inner
def is_side(places: NDArray[np.float64], count: int, a: int, b: int, near: float) -> bool:
    """Return whether no place is to the right of the line from a to b, and the two are the ends of what is on it."""
    if a == b or math.hypot(places[b, 0] - places[a, 0], places[b, 1] - places[a, 1]) <= near:
        return False
    for other in range(count):
        side = _left_of(places, a, b, places[other, 0], places[other, 1])
        if side < -near:
            return False
        if side <= near and other not in (a, b):
            # Between the ends, not beyond them.
            along = (places[other, 0] - places[a, 0]) * (places[b, 0] - places[a, 0])
            along += (places[other, 1] - places[a, 1]) * (places[b, 1] - places[a, 1])
            size = math.hypot(places[b, 0] - places[a, 0], places[b, 1] - places[a, 1])
            if along < 0.0 or along > size * size:
                return False
    return True


@inner
def spans_a_face(places: NDArray[np.float64], count: int, near: float) -> bool:
    """Return whether the places are not all on a line."""
    for a in range(1, count):
        for b in range(a + 1, count):
            if abs(_left_of(places, 0, a, places[b, 0], places[b, 1])) > near:
                return True
    return False


@inner
def margin(places: NDArray[np.float64], count: int, at: Pair, near: float) -> tuple[float, int, int]:
    """Return how far inside the places' hull a place is [m], and between which of them its nearest side is."""
    least, first, second = math.inf, 0, 0
    for a in range(count):
        for b in range(count):
            if is_side(places, count, a, b, near):
                inside = _left_of(places, a, b, at[0], at[1])
                if inside < least:
                    least, first, second = inside, a, b
    return least, first, second


@inner
def margin_of_arc(
    places: NDArray[np.float64], count: int, begins: Pair, ends: Pair, radius: float, near: float
) -> float:
    """Return how far inside the places' hull an arc about the centre stays [m]; begins, ends: unit vectors, the arc the

    shorter way between them.
    """
    least = min(
        margin(places, count, (radius * begins[0], radius * begins[1]), near)[0],
        margin(places, count, (radius * ends[0], radius * ends[1]), near)[0],
    )
    turn = begins[0] * ends[1] - begins[1] * ends[0]
    for a in range(count):
        for b in range(count):
            if is_side(places, count, a, b, near):
                size = math.hypot(places[b, 0] - places[a, 0], places[b, 1] - places[a, 1])
                out = ((places[b, 1] - places[a, 1]) / size, (places[a, 0] - places[b, 0]) / size)
                after = (begins[0] * out[1] - begins[1] * out[0]) * turn > 0.0
                before = (out[0] * ends[1] - out[1] * ends[0]) * turn > 0.0
                if after and before:
                    least = min(least, _left_of(places, a, b, radius * out[0], radius * out[1]))
    return least
