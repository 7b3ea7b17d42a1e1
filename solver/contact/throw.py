"""The row in which a throw waits between two calls, and the motions that a contact can lead to.

A row has the state asked for, the state at the last event and when that was, which motion follows, and when that ends
by itself.  The events do not depend on the instants asked for.
"""

import math

import numpy as np
from numpy.typing import NDArray

from tumble.solver.compilation import inner
from tumble.solver.contact.ground import Ground, lever_of, momentum_of, point_count, spin_of, velocity_at
from tumble.solver.quaternion import Quaternion, rotate
from tumble.solver.vectors import Vector, dot

Array = NDArray[np.float64]
State = tuple[Vector, Quaternion, Vector, Vector]

# What a row holds: the state (13), that of the last event (13), and these.
ANCHOR, SINCE, KIND, UNTIL, THEN, SEARCHED, FASTEST, POINT, OTHER = 13, 26, 27, 28, 29, 30, 31, 32, 33
PULL, SPIN_RATE, WHY, IMPACTS, GAINED, LENGTH, DONE, AT_ONCE, TAKEN, WIDTH = 34, 37, 40, 41, 42, 43, 44, 45, 46, 47

# Motions.  Those from LASTING on, and what there is to say of a state on the plane, are of `lasting`.
UNKNOWN, FREE, STEADY, ENDED, LASTING, SLIPPING, PINNED = 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0
# What happens where one ends.
GOES_ON, ARRIVES, STRIKES, STOPS, LANDS, ENDS = 0.0, 1.0, 2.0, 3.0, 4.0, 5.0

# Why no event method goes on with the motion: TAKEN time steps do.
REASONS = (
    "",
    "a corner stays on the plane, or an edge in a motion that is not in a plane",
    "a face spins on the plane, and the law leaves open how its pressure is spread",
    "the body tips over its face while it slides or spins",
    "an edge or a tip that turned about where it was begins to slip",
    "a point grazes the plane, or impacts follow one another without end",
    "there were too many impacts",
    "a disc slips on its rim, turns on both, or falls flat",
)
CORNER, FACE_SPINS, FACE_TIPS, SLIPS, GRAZES, TOO_MANY, RIM = 1, 2, 3, 4, 5, 6, 7
MOST_IMPACTS = 1_000_000

# Of body and distance, and of the greatest speed so far: what a gap and a speed are none below.
TOUCHING, STILL = 2.0**-45, 2.0**-45
# Of body and distance: what a bounce must rise by to be one.
FLAT = 2.0**-48
# Of the acceleration that presses the body on: what is no slope but for rounding.
LEVEL = 2.0**-46


@inner
def load(row: Array, at: int) -> State:
    """Return the state that begins there in a row."""
    return (
        (row[at], row[at + 1], row[at + 2]),
        (row[at + 3], row[at + 4], row[at + 5], row[at + 6]),
        (row[at + 7], row[at + 8], row[at + 9]),
        (row[at + 10], row[at + 11], row[at + 12]),
    )


@inner
def store(row: Array, at: int, state: State) -> None:
    """Write a state to there in a row."""
    x, q, v, l_body = state
    row[at], row[at + 1], row[at + 2] = x
    row[at + 3], row[at + 4], row[at + 5], row[at + 6] = q
    row[at + 7], row[at + 8], row[at + 9] = v
    row[at + 10], row[at + 11], row[at + 12] = l_body


@inner
def spread_of(ground: Ground) -> float:
    """Return how much more a touching point gains per force along the plane than the centre: 1 + m r^2 / I."""
    return 1.0 + ground.mass * ground.radius * ground.radius * ground.inverse_moments[0]


@inner
def touching_points(row: Array, touching: NDArray[np.int64], ground: Ground) -> tuple[int, int, float]:
    """Return how many points on the plane approach it, how many stay on it, and the speed that counts as none.

    touching: gets the numbers of those that stay, from its beginning, and of those that approach, from its end.
    """
    x, q, v, l_body = load(row, ANCHOR)
    w = spin_of(q, l_body, ground)
    speed = math.sqrt(dot(v, v)) + math.sqrt(dot(w, w)) * ground.reach
    pull = math.sqrt(dot(ground.gravity, ground.gravity))
    row[FASTEST] = max(row[FASTEST], speed, math.sqrt(pull * ground.reach))
    still = STILL * row[FASTEST]
    size = ground.reach + math.sqrt(dot(x, x)) + ground.far
    near = TOUCHING * size
    if ground.radius == 0.0:
        # A corner that rises by no more than its height is known to does not rise.
        still = max(still, math.sqrt(2.0 * abs(ground.gravity[2]) * FLAT * size))
    meets, stays = 0, 0
    count = point_count(ground)
    for number in range(count):
        lever = lever_of(q, number, ground)
        if x[2] + lever[2] <= near:
            rate = velocity_at(v, w, lever)[2]
            if rate < -still:
                meets += 1
                touching[count - meets] = number
            elif rate <= still:
                touching[stays] = number
                stays += 1
    return meets, stays, still


@inner
def end(row: Array, why: int) -> None:
    """Let time steps go on with the motion from here on."""
    row[KIND], row[UNTIL], row[WHY] = ENDED, math.inf, why


@inner
def go_steadily(row: Array, pull: Vector, spin_rate: Vector, until: float, then: float) -> None:
    """Let the centre accelerate, and the spin change, at constant rates."""
    row[KIND], row[UNTIL], row[THEN] = STEADY, until, then
    row[PULL], row[PULL + 1], row[PULL + 2] = pull
    row[SPIN_RATE], row[SPIN_RATE + 1], row[SPIN_RATE + 2] = spin_rate


@inner
def rolling(v: Vector, w: Vector, ground: Ground) -> Vector:
    """Return the spin of a sphere whose lowest point has no slip."""
    return (-v[1] / ground.radius, v[0] / ground.radius, w[2])


@inner
def count_impact(
    row: Array, v: Vector, w: Vector, v_then: Vector, w_then: Vector, q: Quaternion, ground: Ground
) -> None:
    """Count an impact, and the energy that it lost or gained [J]."""
    before = ground.mass * dot(v, v) + dot(w, rotate(q, momentum_of(q, w, ground)))
    after = ground.mass * dot(v_then, v_then) + dot(w_then, rotate(q, momentum_of(q, w_then, ground)))
    row[IMPACTS] += 1.0
    if after > before * (1.0 + 1e-12):
        row[GAINED] += 0.5 * (after - before)
