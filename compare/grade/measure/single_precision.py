"""The effect of single precision on a run: a floor that grows with the steps, and as the motion amplifies errors."""

from dataclasses import replace

import numpy as np

from tumble.compare.grade.model.kernel.dynamics import AS_FORCE, BIASED, EXPONENTIAL, RESCALED, ROUNDED, Scheme
from tumble.compare.grade.model.program_model import SEARCHING, ProgramModel
from tumble.scenarios.frames import Array

# Factor on the effect of rounding after every step, random and biased: an engine rounds each operation, not each step.
# Measured for Jolt, PhysX, Newton and ODE: rms 0.1 to 1.6 floors.
MARGIN = 3.0
# Steps of a program whose own error cannot be seen: so many in a row interval, but not shorter than so long [s].
MOST_IN_A_ROW, SHORTEST = 20, 1e-3
# Relative effect of rounding a number once; of an attitude, 2 |dq| with four components, which is normalised as well.
ROUNDING = 2.0**-24
TURNING = 4 * ROUNDING
# Rounding of a factor between a half and 1.
FACTOR = 2.0**-25


def single_floor(program: ProgramModel, times: Array, points: Array) -> Array:
    """Return the effect of single precision on the vertices of a run in steps at times [s], in m, (T,)."""
    plain = replace(program, output_transforms=())
    others = [replace(plain, scheme=plain.scheme._replace(precision=precision)) for precision in (ROUNDED, BIASED)]
    if any(program.damping) and program.damping_place != AS_FORCE:
        # A factor of nearly 1, by which a step multiplies velocities, is rounded once and always the same.
        rates = (rate + FACTOR / program.scheme.step if rate else 0.0 for rate in program.damping)
        others.append(replace(plain, damping=tuple(rates)))
    poses = [each.output(times, SEARCHING) for each in (plain, *others)]
    exact, *rounded = (pose.x[:, None] + np.einsum("tij,kj->tki", pose.axes, points) for pose in poses)
    reach = float(np.linalg.norm(points, axis=1).max())
    with np.errstate(all="ignore"):
        squares = sum(((other - exact) ** 2).sum(axis=2).mean(axis=1) for other in rounded)
        written = ROUNDING * np.linalg.norm(poses[0].x, axis=1) + TURNING * reach
        moved = np.maximum(MARGIN * np.sqrt(squares), written)
    return np.maximum.accumulate(np.nan_to_num(moved, nan=0.0, posinf=0.0))


def fine_step(spacing: float) -> float:
    """Return the step of a program whose steps are too short to be seen [s]; spacing: of its rows [s]."""
    return min(spacing, max(spacing / MOST_IN_A_ROW, SHORTEST))


def stepwise(program: ProgramModel, step: float) -> ProgramModel:
    """Return a program that is correct except that it takes steps [s]."""
    return replace(program, scheme=Scheme(step, EXPONENTIAL, RESCALED, True, 1.0))
