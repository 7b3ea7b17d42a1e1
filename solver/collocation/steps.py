"""Steps of a collocation method, taken in parts where one is not found.

A step is taken in halves, and those again, where Newton's method does not find it; where it turns the body too far for
a parabola; and where the instants at which forces are looked at do not show clearly what work they do, as at the touch
of a floor.  At that kink Newton's method can also jump between the two sides for ever: until the part of the step is so
short that either side is as good, to rounding.  Where no part is short enough, or too many are needed, the state
becomes nan.
"""

# A row is loaded whole, also of a body that never turns, which pyright cannot know.
# pyright: reportArgumentType=false

import math

import numpy as np
from numpy.typing import NDArray

from tumble.solver.collocation.equations import Slopes, Whole, moved, rows
from tumble.solver.collocation.newton import found
from tumble.solver.collocation.scheme import Scheme
from tumble.solver.collocation.work import balanced
from tumble.solver.compilation import borrowing, inlined, kernel
from tumble.solver.eight import Eight, lane
from tumble.solver.forces import Forces
from tumble.solver.motion import load, store
from tumble.solver.quaternion import Quaternion, normalise
from tumble.solver.vectors import Vector

Array = NDArray[np.float64]

# The least part of a step, and how many may be tried.
LEAST_PART, MOST_PARTS = 2.0**-40, 2**14


def integrate(
    rows: Array,
    n: int,
    dt: float,
    method: Scheme,
    moments: Vector,
    inverse_moments: Vector | None,
    gyroscopic: Vector | None,
    forces: Forces,
) -> None:
    """Take n steps of dt [s] of whole states, or of position and velocity where inverse_moments is None.

    rows: x, q, v, L in body axes and the count of steps that were not found, (N, 14), altered in place.
    """
    reach = math.sqrt(max(moments) / forces.mass)
    _collocate(rows, n, dt, method, reach, inverse_moments, gyroscopic, forces)


@kernel
def _collocate(
    bodies: Array,
    n: int,
    dt: float,
    method: Scheme,
    reach: float,
    inverse_moments: Vector | None,
    gyroscopic: Vector | None,
    forces: Forces,
) -> None:
    """Take n steps of bodies, rows as in `integrate`; reach [m]: the body's size, as its radius of gyration has it."""
    for row in bodies:
        state = load(row, (0.0, 0.0, 0.0))
        for step in range(n):
            state, is_found = _advance(state, dt, method, reach, inverse_moments, gyroscopic, forces)
            if not is_found:
                row[13] += n - step
                break
        store(row, state)


@borrowing
def _advance(
    state: Whole,
    dt: float,
    method: Scheme,
    reach: float,
    inverse_moments: Vector | None,
    gyroscopic: Vector | None,
    forces: Forces,
) -> tuple[Whole, bool]:
    """Return the state after one step, taken in halves where it must be, and whether all of it was found; else nan."""
    done, part = 0.0, 1.0
    for _ in range(MOST_PARTS):
        slopes, work, is_found = found(state, part * dt, method, reach, inverse_moments, gyroscopic, forces)
        if is_found:
            after = _after(state, slopes, part * dt, method, inverse_moments)
            if work.is_counted:
                after, is_found = balanced(state, after, work, forces.mass, inverse_moments)
            if is_found:
                state = after
        done, part = next_part(done, part, is_found)
        if done == 1.0:
            return state, True
        if part == 0.0:
            break
    return _lost(state, inverse_moments), False


@inlined
def _after(state: Whole, slopes: Slopes, dt: float, method: Scheme, inverse_moments: Vector | None) -> Whole:
    """Return the state after a step."""
    x, q, v, l_body = state
    weights = method.weights
    velocities = moved(v, rows(dt, method.to_stages), slopes.accelerations)
    return (
        _summed(x, dt, weights, velocities),
        _turned(q, dt, weights, slopes.turns, inverse_moments),
        _summed(v, dt, weights, slopes.accelerations),
        _summed(l_body, dt, weights, slopes.twists),
    )


@inlined
def _sum(start: float, dt: float, weights: Array, slopes: Eight) -> float:
    """Return a number after a step, from its slopes at the stages."""
    return start + dt * (weights[0] * lane(slopes, 0) + weights[1] * lane(slopes, 1) + weights[2] * lane(slopes, 2))


@inlined
def _summed(start: Vector, dt: float, weights: Array, slopes: Vector) -> Vector:
    return (
        _sum(start[0], dt, weights, slopes[0]),
        _sum(start[1], dt, weights, slopes[1]),
        _sum(start[2], dt, weights, slopes[2]),
    )


@inlined
def _turned(q: Quaternion, dt: float, weights: Array, turns: Quaternion, inverse_moments: Vector | None) -> Quaternion:
    """Return q after a step, of length 1."""
    if inverse_moments is None:
        return q
    x, y, z = _summed((q[1], q[2], q[3]), dt, weights, (turns[1], turns[2], turns[3]))
    return normalise((_sum(q[0], dt, weights, turns[0]), x, y, z))


@inlined
def _lost(state: Whole, inverse_moments: Vector | None) -> Whole:
    """Return nan for what is stepped: of a body that never turns, only x and v."""
    _, q, _, l_body = state
    nan = math.nan
    if inverse_moments is None:
        return (nan, nan, nan), q, (nan, nan, nan), l_body
    return (nan, nan, nan), (nan, nan, nan, nan), (nan, nan, nan), (nan, nan, nan)


@borrowing
def next_part(done: float, part: float, found: bool) -> tuple[float, float]:
    """Return how much of a step is done, and the part to try next: half of one that was not found, 0 after the least.

    After one that was found it is the longest that begins there.
    """
    if not found:
        return done, part / 2.0 if part > LEAST_PART else 0.0
    done += part
    while part < 1.0 and done % (2.0 * part) == 0.0:
        part *= 2.0
    return done, part
