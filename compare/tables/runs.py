"""What is written of a run."""

import math

import numpy as np

from tumble.compare.judge.errors import Run, quietly
from tumble.compare.run.flight import Trajectory
from tumble.compare.tables.shared import RunRow, worded
from tumble.scenarios.frames import Array


def step_of(run: Run) -> tuple[float, float | None]:
    """Return dt_s and tolerance of a run: it has the one or the other."""
    return (run.dt, None) if run.tolerance is None else (math.nan, run.tolerance)


def run_row(run: Run) -> RunRow:
    """Return the row of one run."""
    step = step_of(run)
    key = run.scene.name, run.engine, run.method, *step
    status = worded(run.status)
    if not isinstance(run.answer, Trajectory):
        return RunRow(*key, None, *status)
    wall_s = run.flight.wall_s
    steps = run.flight.steps if run.tolerance is None else None
    wall = wall_s, None if steps is None else wall_s / steps * 1e9, wall_s / run.scene.duration
    if not run.has_errors:
        return RunRow(*key, steps, *status, None, None, None, None, None, None, None, *wall, run.dt_taken)
    distances = run.distances
    with quietly():
        rms_m = np.sqrt((distances**2).mean())
    energy, momentum, angular = run.drifts
    return RunRow(
        *key,
        steps,
        *status,
        boundless(distances.max()),
        boundless(rms_m),
        boundless(distances[-1].max()),
        float(run.limits.max()),
        boundless(energy),
        boundless(momentum),
        boundless(angular),
        *wall,
        run.dt_taken,
    )


def boundless(figure: float) -> float:
    """Return a figure, infinite where it is none: of a flight that was lost no error is the largest."""
    return math.inf if math.isnan(figure) else float(figure)


def xyz(vector: Array) -> tuple[float, float, float]:
    """Return a vector, (3,), as three cells."""
    x, y, z = vector.tolist()
    return x, y, z
