"""Whether a point touches the floor and leaves it again within a step, between the instants that the step looks at."""

# Rotation is absent as a whole, which pyright cannot know: where q is not None neither is L or w.
# pyright: reportArgumentType=false

import math

import numpy as np
from numpy.typing import NDArray

from tumble.solver.compilation import inner
from tumble.solver.forces import Plane, floor_under
from tumble.solver.motion import State, spin
from tumble.solver.vectors import Vector, dot

Array = NDArray[np.float64]


@inner
def dips(
    before: State,
    after: State,
    dt: float,
    depth: float,
    inverse_moments: Vector | None,
    floor: tuple[float, float, float, float, float, float] | None,
    points: Array | None,
) -> bool:
    """Return whether a point over the floor before a step of dt [s] and after it may have been deeper [m] in between.

    Between the two it is seen as the cubic through both, which is right but for the fourth derivative, w^4 |p|, over
    384 (Hildebrand, "Introduction to Numerical Analysis" (1974), section 8.2).
    """
    if floor is None or points is None:
        return False
    start, end = _plane(before, inverse_moments, floor), _plane(after, inverse_moments, floor)
    w_squared = dot(start.turn, start.turn)
    for number in range(len(points)):
        point = (points[number, 0], points[number, 1], points[number, 2])
        y0, y1, slope0, slope1 = _height(start, point), _height(end, point), _rise(start, point), _rise(end, point)
        if y0 > 0.0 and y1 > 0.0 and slope0 * dt < 0.0 < slope1 * dt:
            unsure = (dt * dt * w_squared) ** 2 * math.sqrt(dot(point, point)) / 384.0
            if _least(y0, y1, dt * slope0, dt * slope1) < unsure - depth:
                return True
    return False


@inner
def _least(y0: float, y1: float, slope0: float, slope1: float) -> float:
    """Return the least value in [0, 1] of the cubic with these values at 0 and 1, where it falls and where it rises."""
    a, b = slope0 + slope1 - 2.0 * (y1 - y0), 3.0 * (y1 - y0) - 2.0 * slope0 - slope1
    s = -slope0 / (b + math.sqrt(b * b - 3.0 * a * slope0))
    return y0 + s * (slope0 + s * (b + s * a))


@inner
def _plane(
    state: State, inverse_moments: Vector | None, floor: tuple[float, float, float, float, float, float]
) -> Plane:
    x, q, v, l_body = state
    return floor_under(x, q, v, spin(l_body, inverse_moments), floor[0], (floor[1], floor[2], floor[3]))


@inner
def _height(plane: Plane, point: Vector) -> float:
    """Return how high a point is over the floor [m]."""
    return plane.centre + dot(plane.normal_body, point)


@inner
def _rise(plane: Plane, point: Vector) -> float:
    """Return how fast a point leaves the floor [m/s]."""
    return plane.rise + dot(plane.turn, point)
