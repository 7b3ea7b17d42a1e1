"""The effect of single precision on a run: a floor that grows with the steps, and as the motion amplifies errors."""

from dataclasses import replace

import numpy as np

from tumble.compare.grade.model.kernel.dynamics import BIASED, EXPONENTIAL, RESCALED, ROUNDED, Scheme
from tumble.compare.grade.model.program_model import SEARCHING, ProgramModel
from tumble.scenarios.frames import Array

# Factor on the effect of rounding after every step, random and biased: an engine rounds each operation, not each step.
# Measured for Jolt, PhysX, Newton and ODE: rms 0.1 to 1.6 floors.
MARGIN = 3.0
# Relative effect of rounding a number once; of an attitude, 2 |dq| with four components, which is normalised as well.
ROUNDING = 2.0**-24
TURNING = 4 * ROUNDING


def single_floor(program: ProgramModel, times: Array, points: Array) -> Array:
    """Return the effect of single precision on the vertices of a run in steps at times [s], in m, (T,)."""
    poses = [
        replace(program, scheme=program.scheme._replace(precision=precision), output_transforms=()).output(
            times, SEARCHING
        )
        for precision in (0, ROUNDED, BIASED)
    ]
    exact, *others = (pose.x[:, None] + np.einsum("tij,kj->tki", pose.axes, points) for pose in poses)
    reach = float(np.linalg.norm(points, axis=1).max())
    with np.errstate(all="ignore"):
        apart = [np.sqrt(((other - exact) ** 2).sum(axis=2).mean(axis=1)) for other in others]
        moved = MARGIN * np.sqrt(apart[0] ** 2 + apart[1] ** 2)
        written = ROUNDING * np.linalg.norm(poses[0].x, axis=1) + TURNING * reach
        moved = np.maximum(moved, written)
    return np.maximum.accumulate(np.nan_to_num(moved, nan=0.0, posinf=0.0))


def stepwise(program: ProgramModel, step: float) -> ProgramModel:
    """Return a program that is correct except that it takes steps [s]."""
    return replace(program, scheme=Scheme(step, EXPONENTIAL, RESCALED, True, 1.0))
