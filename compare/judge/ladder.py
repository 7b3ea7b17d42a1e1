"""The order of a contestant, of its attitude and of its centre of mass apart, read off a short ladder of steps."""

import math
from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from tumble.compare.judge.errors import Run
from tumble.compare.judge.orders import ASYMPTOTIC, FLOOR, LAST, Level, local_orders, parts
from tumble.compare.run.flight import legs
from tumble.compare.run.status import Status

PAIRS = 3
MOST_STEPS, FINEST = 1 << 16, 16
# Slopes further apart than this are not yet, or no longer, those of one order.
AGREE = 0.5


def ladder(own: Run, simulate: Callable[[float], Run]) -> list[Run]:
    """Return runs at halved steps, the coarsest first, around the run at the scene's own step.

    simulate: makes a run at a step [s].  Steps are doubled while errors are small, which costs less than the run
    itself; then halved until PAIRS pairs have small errors or the floor is reached, but no further than to a FINEST
    part of the scene's step, nor to more than MOST_STEPS.
    """
    runs = [own]
    small = ASYMPTOTIC * own.scene.body.reach
    longest = min(leg.n * leg.dt for leg in legs(own.scene, own.dt)) / 2
    while readable(runs[0]) and worst(runs[0]) < small and 2 * runs[0].dt <= longest:
        runs.insert(0, simulate(2 * runs[0].dt))
    while (
        readable(runs[-1])
        and worst(runs[-1]) > FLOOR * float(runs[-1].limits.max())
        and sum(readable(run) and worst(run) < small for run in runs) <= PAIRS
        and 2 * runs[-1].flight.steps * len(own.scene.start) <= MOST_STEPS
        and FINEST * runs[-1].dt > own.dt
    ):
        runs.append(simulate(runs[-1].dt / 2))
    return [run for run in runs if readable(run)]


def readable(run: Run) -> bool:
    """Whether the run's error is a plain result."""
    return run.status is Status.OK and run.has_errors and bool(np.isfinite(run.distances).all())


def worst(run: Run) -> float:
    """Return the largest vertex error [m]."""
    return float(run.distances.max())


def orders(runs: Sequence[Run]) -> tuple[float | None, float | None]:
    """Return the orders of attitude and translation that a ladder shows, None where it shows none.

    An error of attitude ends at the body's size, one of translation does not end.
    """
    if not runs:
        return None, None
    size = runs[0].scene.body.reach
    attitude, translation = zip(*(levels(run) for run in runs), strict=True)
    return (
        one_order(local_orders(attitude, ASYMPTOTIC * size)) or one_order(local_orders(attitude, size)[-LAST:]),
        one_order(local_orders(translation, math.inf)[-LAST:]),
    )


def levels(run: Run) -> tuple[Level, Level]:
    """Return the refinement level of a run in attitude and in translation, at the step taken."""
    dt, limit = run.dt_taken or run.dt, float(run.limits.max())
    attitude, translation = parts(run)
    return Level(dt, attitude, limit), Level(dt, translation, limit)


def one_order(slopes: Sequence[float]) -> float | None:
    """Return the median of the slopes that agree with a neighbour, None where none does."""
    agreed = [sum(pair) / 2 for pair in pairwise(slopes) if abs(pair[0] - pair[1]) <= AGREE]
    return float(np.median(agreed)) if agreed else None
