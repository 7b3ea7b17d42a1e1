"""The angular velocity in a file, compared with that of the motion that explains its poses."""

import numpy as np

from tumble.compare.grade.measure.errors import SampledRows
from tumble.compare.grade.model.kernel.stepping import WIDTH
from tumble.compare.grade.model.program_model import FINE, ProgramModel
from tumble.scenarios.frames import Array

# The angular velocity is wrong if it is off by more than WRONG of its size, and another reading reduces that to BETTER.
BETTER = 0.2
WRONG = 0.01


def spin_mistake(sample: SampledRows, program: ProgramModel) -> str:
    """Return what is wrong with the angular velocity in a file, empty if it is right or missing."""
    if sample.spins is None:
        return ""
    rows = program.simulate(program.clock.physics_times(sample.times), FINE)
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
    left = {what: _off(sample.spins, reading) for what, reading in readings.items()}
    best = min(left, key=lambda what: left[what])
    size = float(np.linalg.norm(sample.spins))
    return best if left[""] > WRONG * size and left[best] < BETTER * left[""] else ""


def _off(spins: Array, reading: Array) -> float:
    return float(np.linalg.norm(spins - reading))
