"""What single precision leaves of a flight: a floor that grows with its steps, and as the motion spreads errors."""

from dataclasses import replace

import numpy as np

from tumble.compare.grade.model.kernel.dynamics import BIASED, EXPONENTIAL, RESCALED, ROUNDED, Scheme
from tumble.compare.grade.model.program_model import SEARCHING, Account
from tumble.scenarios.frames import Array

# What rounding after every step moves the vertices by, and what it could if all of it went one way, times so much: an
# engine rounds each operation, not each step.  Held against Jolt, PhysX, Newton and ODE: rms 0.1 to 1.6 of the floor.
MARGIN = 3.0
# Of a number, what rounding it once moves it by; of an attitude 2 |dq| with four parts, and it is normalised as well.
ROUNDING = 2.0**-24
TURNING = 4 * ROUNDING


def single_floor(account: Account, times: Array, points: Array) -> Array:
    """Return how far single precision moves the vertices of a flight in steps by each instant [m], (T,)."""
    flights = [
        replace(account, scheme=account.scheme._replace(keeps=keeps), writings=()).written(times, SEARCHING)
        for keeps in (0, ROUNDED, BIASED)
    ]
    right, *others = (pose.x[:, None] + np.einsum("tij,kj->tki", pose.axes, points) for pose in flights)
    reach = float(np.linalg.norm(points, axis=1).max())
    with np.errstate(all="ignore"):
        apart = [np.sqrt(((other - right) ** 2).sum(axis=2).mean(axis=1)) for other in others]
        moved = MARGIN * np.sqrt(apart[0] ** 2 + apart[1] ** 2)
        written = ROUNDING * np.linalg.norm(flights[0].x, axis=1) + TURNING * reach
        moved = np.maximum(moved, written)
    return np.maximum.accumulate(np.nan_to_num(moved, nan=0.0, posinf=0.0))


def in_steps(account: Account, step: float) -> Account:
    """Return the account of a program that flies right but for its steps [s]."""
    return replace(account, scheme=Scheme(step, EXPONENTIAL, RESCALED, True, 1.0))
