"""Steps of a collocation method, taken in parts where one is not found.

A step is taken in halves, and those again, where Newton's method does not find it; where it turns the body too far for
a parabola; and where the instants at which forces are looked at do not show clearly what work they do, as at the touch
of a floor.  At that kink Newton's method can also jump between the two sides for ever: until the part of the step is so
short that either side is as good, to rounding.  Where no part is short enough, or too many are needed, the state
becomes nan.
"""

import math

import numpy as np
from numpy.typing import NDArray

from tumble.solver.collocation.equations import moves, weighted
from tumble.solver.collocation.newton import Room, found, room
from tumble.solver.collocation.scheme import Scheme
from tumble.solver.compilation import borrowing, kernel
from tumble.solver.forces import Forces
from tumble.solver.quaternion import normalise
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
    rows: Array,
    n: int,
    dt: float,
    method: Scheme,
    reach: float,
    inverse_moments: Vector | None,
    gyroscopic: Vector | None,
    forces: Forces,
) -> None:
    """Take n steps of rows; reach [m]: the body's size, as its radius of gyration has it."""
    state, slopes, here = np.empty(13), np.zeros((3, 13)), room(inverse_moments)
    for row in rows:
        for a in range(13):
            state[a] = row[a]
        for step in range(n):
            if not _advance(state, slopes, here, dt, method, reach, inverse_moments, gyroscopic, forces):
                row[13] += n - step
                break
        for a in range(13):
            row[a] = state[a]


@borrowing
def _advance(
    state: Array,
    slopes: Array,
    here: Room,
    dt: float,
    method: Scheme,
    reach: float,
    inverse_moments: Vector | None,
    gyroscopic: Vector | None,
    forces: Forces,
) -> bool:
    """Take one step, in halves where it must be, and return whether all of it was found; if not the state is nan."""
    done, part = 0.0, 1.0
    for _ in range(MOST_PARTS):
        is_found = found(state, slopes, here, part * dt, method, reach, inverse_moments, gyroscopic, forces)
        if is_found:
            for a in range(13):
                state[a] += part * dt * weighted(method.weights, slopes, a)
            _put_normalised(state, inverse_moments)
        done, part = next_part(done, part, is_found)
        if done == 1.0:
            return True
        if part == 0.0:
            break
    for a in range(13):
        if moves(a, inverse_moments):
            state[a] = math.nan
    return False


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


@borrowing
def _put_normalised(state: Array, inverse_moments: Vector | None) -> None:
    """Give q its length again, of a body that turns."""
    if inverse_moments is None:
        return
    state[3], state[4], state[5], state[6] = normalise((state[3], state[4], state[5], state[6]))
