"""Orders of convergence, read off the errors of a ladder of steps."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from tumble.compare.judge.errors import Run
from tumble.scenarios.frames import rotation_matrix

# An order is read off errors below a share of the body's size, where no higher order is seen, and above the truth's
# limit; a ladder that ends before is read at its last pairs.
ASYMPTOTIC, FLOOR, LAST = 1e-3, 30.0, 3


@dataclass(frozen=True)
class Level:
    """One refinement level: step [s], error [m] and resolution of the reference [m]."""

    dt_s: float
    error_m: float
    resolution_m: float


def local_orders(ladder: Sequence[Level], largest_m: float) -> list[float]:
    """Return the slope of each pair of neighbours, the coarsest first, from errors below largest_m down to the floor.

    The floor is where an error comes near the truth's limit or stops falling; the pair before that has felt it already.
    """
    slopes: list[float] = []
    for coarse, fine in pairwise(ladder):
        if coarse.error_m >= largest_m or fine.dt_s >= coarse.dt_s:  # cut as short by samples, both are one run
            continue
        if fine.error_m >= coarse.error_m:
            return slopes[:-1]
        if fine.error_m <= FLOOR * fine.resolution_m:
            return slopes
        slopes.append(order_between(coarse, fine))
    return slopes


def order_between(coarse: Level, fine: Level) -> float:
    """Return the power of the step by which the error falls from one level to another."""
    return math.log(coarse.error_m / fine.error_m) / math.log(coarse.dt_s / fine.dt_s)


def parts(run: Run) -> tuple[float, float]:
    """Return the largest vertex error from the attitude alone and from the centre of mass alone [m]."""
    assert run.truth is not None
    states, true = run.flight.states, run.truth.states
    turned = rotation_matrix(states[..., 3:7]) - rotation_matrix(true[..., 3:7])
    attitude = np.linalg.norm(np.einsum("...ij,nj->...ni", turned, run.scene.body.points), axis=-1)
    return float(attitude.max()), float(np.linalg.norm(states[..., 0:3] - true[..., 0:3], axis=-1).max())
