"""The angular velocity that a file writes down, against that of the motion which explains its poses."""

import numpy as np

from tumble.compare.grade.measure.errors import Kept
from tumble.compare.grade.model.kernel.stepping import WIDTH
from tumble.compare.grade.model.program_model import FINE, Account
from tumble.scenarios.frames import Array

# Written otherwise, the angular velocity must fit so much better, and miss by so much as it is, to be called mistaken.
BETTER = 0.2
WRONG = 0.01


def spin_mistake(kept: Kept, account: Account) -> str:
    """Return what is wrong with how the angular velocity is written down, nothing where it is right or not there."""
    if kept.spins is None:
        return ""
    rows = account.flown(account.clock.reached(kept.times), FINE)
    assert rows.shape[1] == WIDTH
    w_world = rows[:, 15:18]
    w_body = np.einsum("tji,tj->ti", rows[:, 3:12].reshape(-1, 3, 3), w_world)
    readings = {
        "": w_world,
        "is in body axes, not in world axes": w_body,
        "is in degrees": np.degrees(w_world),
        "is in degrees and in body axes": np.degrees(w_body),
        "has the wrong sign": -w_world,
        "is in revolutions": w_world / (2 * np.pi),
    }
    left = {what: _off(kept.spins, reading) for what, reading in readings.items()}
    best = min(left, key=lambda what: left[what])
    size = float(np.linalg.norm(kept.spins))
    return best if left[""] > WRONG * size and left[best] < BETTER * left[""] else ""


def _off(spins: Array, reading: Array) -> float:
    return float(np.linalg.norm(spins - reading))
