"""The effect of single precision on a run: a floor that grows with the steps, and as the motion amplifies errors."""

import numpy as np

from tumble.compare.grade.measure.significance import EXPLAINED
from tumble.compare.grade.model.kernel.dynamics import (
    AS_FORCE,
    BIASED,
    IN_WORLD_AXES,
    ORDER_4,
    ROUNDED,
    ROUNDED_TWICE,
    RUNGE_KUTTA,
    SCALED,
    Scheme,
)
from tumble.compare.grade.model.program_model import SEARCHING, ProgramModel, outputs
from tumble.scenarios.frames import Array

# What a program of single precision may be off by, over the sum of the effects below.  Of 432 programs of 12 schemes
# with a twin in double precision, the worst was off by 0.9 of the sum, and half of them by a quarter of it or less; of
# 48 files of Jolt, PhysX, Newton, ODE and Bullet the worst was off by 0.9 of it, and of 6 of Box3D by 1.3.
MARGIN = 1.5
# A program rounds each of its operations, nearly at random.  In n steps, the largest bias has sqrt(n) times the effect
# of a random rounding; of that, so many standard deviations.
RANDOM = 8.0
# Steps of a program whose own error cannot be seen: so many in a row interval, but not shorter than so long [s].
MOST_IN_A_ROW, SHORTEST = 20, 1e-3
# Relative effect of rounding a number once; of an attitude, 2 |dq| with four components, which is normalised as well.
ROUNDING = 2.0**-24
TURNING = 4 * ROUNDING
# Rounding of a factor 1 - c dt, or of 1 + c dt and of its inverse.
FACTOR = 3 * 2.0**-25
# Of a velocity in body axes, which each step turns back: it may grow or shrink by so much in each.  Of 14 programs with
# a twin in double precision, the worst was off by half of what is allowed then; without this, by 10 times as much.
TURNED_BACK = 4 * ROUNDING


def single_floor(program: ProgramModel, times: Array, points: Array) -> Array:
    """Return the floor of single precision on the vertices of a run in steps at times [s], in m, (T,)."""
    precisions = [BIASED, ROUNDED, ROUNDED_TWICE]
    if program.scheme.attitude != RUNGE_KUTTA:
        # Some engines multiply w in each step by a factor that is nearly 1, such as |L| before over |L| after.
        precisions.append(SCALED)
    others = [program.but(scheme=program.scheme._replace(precision=precision)) for precision in precisions]
    if any(program.damping) and program.damping_place != AS_FORCE:
        # So does damping, whose factor is rounded once and always the same.
        rates = (rate + FACTOR / program.scheme.step if rate else 0.0 for rate in program.damping)
        others.append(program.but(damping=tuple(rates)))
    if program.scheme.velocity_axes != IN_WORLD_AXES:
        linear, *rest = program.damping
        others.append(program.but(damping=(linear + TURNED_BACK / program.scheme.step, *rest)))
    poses = outputs([program, *others], times, SEARCHING)
    exact, *moved = (pose.x[:, None] + np.einsum("tij,kj->tki", pose.axes, points) for pose in poses)
    reach = np.linalg.norm(exact - poses[0].x[:, None], axis=2).max(axis=1)
    with np.errstate(all="ignore"):
        biased, *effects = (np.sqrt(((other - exact) ** 2).sum(axis=2).mean(axis=1)) for other in moved)
        at_random = RANDOM * biased / np.sqrt(np.maximum(1.0, times / program.scheme.step))
        written = ROUNDING * np.linalg.norm(poses[0].x, axis=1) + TURNING * reach
        floors = MARGIN / EXPLAINED * (at_random + sum(effects) + written)
    return np.maximum.accumulate(np.nan_to_num(floors, nan=0.0, posinf=0.0))


def fine_step(spacing: float) -> float:
    """Return the step of a program whose steps are too short to be seen [s]; spacing: of its rows [s]."""
    return min(spacing, max(spacing / MOST_IN_A_ROW, SHORTEST))


def stepwise(program: ProgramModel, step: float) -> ProgramModel:
    """Return a program that is correct except that it takes steps [s]."""
    return program.but(scheme=Scheme(step, RUNGE_KUTTA, ORDER_4, False, 1.0))
