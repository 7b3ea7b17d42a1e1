"""What is written of a run."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from tumble.compare.judge.errors import Run, quietly
from tumble.compare.run.flight import Trajectory
from tumble.compare.tables.shared import RunRow
from tumble.scenarios.frames import Array


def contestant_columns(run: Run) -> dict[str, Any]:
    """Return the columns that name a run's scene and contestant."""
    return {"scene": run.scene.name, "engine": run.engine, "method": run.method}


def step_columns(run: Run) -> dict[str, Any]:
    """Return dt_s and tolerance of a run: it has the one or the other."""
    has_step = run.tolerance is None
    return {"dt_s": run.dt if has_step else math.nan, "tolerance": run.tolerance}


def status_columns(run: Run) -> dict[str, Any]:
    """Return the columns of a run's status and its reason."""
    return {"status": run.status.value, "why": run.reason}


def run_row(run: Run) -> RunRow:
    """Return the row of one run.

    Parameters
    ----------
    run : the run

    Returns
    -------
    its row of runs.csv
    """
    row = RunRow(**contestant_columns(run), **step_columns(run), **status_columns(run))
    if not isinstance(run.answer, Trajectory):
        return row
    wall_s = run.flight.wall_s
    steps = run.flight.steps if run.tolerance is None else None
    row = replace(
        row,
        steps=steps,
        wall_s=wall_s,
        wall_ns_per_step=None if steps is None else wall_s / steps * 1e9,
        wall_per_sim_s=wall_s / run.scene.duration,
        dt_taken_s=run.dt_taken,
    )
    if not run.has_errors:
        return row
    distances = run.distances
    with quietly():
        rms_m = np.sqrt((distances**2).mean())
    energy, momentum, angular = run.drifts
    return replace(
        row,
        max_error_m=boundless(distances.max()),
        rms_error_m=boundless(rms_m),
        final_error_m=boundless(distances[-1].max()),
        resolution_m=float(run.limits.max()),
        energy_drift=boundless(energy),
        momentum_drift=boundless(momentum),
        angular_momentum_drift=boundless(angular),
    )


def boundless(figure: float) -> float:
    """Return a figure, infinite where it is none: of a flight that was lost no error is the largest."""
    return math.inf if math.isnan(figure) else float(figure)


def vector_columns(vector: Array, *names: str) -> dict[str, Any]:
    """Return the components of a vector by the names of their columns."""
    return dict(zip(names, vector.tolist(), strict=True))
