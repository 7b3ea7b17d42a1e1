"""What is written of the vertices of runs, from whole arrays: one row a vertex and sample, or one a sample."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from tumble.compare.judge.errors import Run
from tumble.compare.tables.frames import typed
from tumble.compare.tables.runs import step_columns
from tumble.compare.tables.shared import ERROR_OVER_TIME, MEMBERS, VERTEX_ERRORS
from tumble.scenarios.frames import Array


def vertex_error_table(runs: Sequence[Run]) -> pd.DataFrame:
    """Return vertex-errors.csv: the runs that have errors, by sample and vertex; of many throws only the first.

    Parameters
    ----------
    runs : the runs; those without errors are left out

    Returns
    -------
    the table: position, reference position and error of each vertex [m]
    """
    judged = [run for run in runs if run.has_errors and run.truth is not None]
    shapes = [run.distances[:, 0].shape for run in judged]
    counts = [samples * vertices for samples, vertices in shapes]
    true = stacked([run.truth.vertices[-samples:, 0] for run, (samples, _) in zip(judged, shapes, strict=True)])  # type: ignore[union-attr]
    flown = stacked([run.flight.vertices[-samples:, 0] for run, (samples, _) in zip(judged, shapes, strict=True)])
    errors = stacked([run.errors[:, 0] for run in judged])
    times = [np.repeat(run.scene.times, vertices) for run, (_, vertices) in zip(judged, shapes, strict=True)]
    return typed(
        VERTEX_ERRORS,
        {
            **keys(judged, counts),
            "t_s": joined(times),
            "vertex": joined([np.tile(np.arange(vertices), samples) for samples, vertices in shapes]),
            **dict(zip(("true_x_m", "true_y_m", "true_z_m"), true.T, strict=True)),
            **dict(zip(("x_m", "y_m", "z_m"), flown.T, strict=True)),
            **dict(zip(("error_x_m", "error_y_m", "error_z_m"), errors.T, strict=True)),
            "error_m": joined([run.distances[:, 0].ravel() for run in judged]),
        },
    )


def error_over_time_table(runs: Sequence[Run]) -> pd.DataFrame:
    """Return error-over-time.csv: the runs that have errors, each by sample."""
    judged = [run for run in runs if run.has_errors]
    return typed(
        ERROR_OVER_TIME,
        {
            **keys(judged, [len(run.scene.times) for run in judged]),
            "t_s": joined([run.scene.times for run in judged]),
            "error_m": joined([run.distances.max(axis=(1, 2)) for run in judged]),
            "resolution_m": joined([run.limits.max(axis=1) for run in judged]),
        },
    )


def member_table(runs: Sequence[Run]) -> pd.DataFrame:
    """Return members.csv: the runs of many throws that have errors, each by member."""
    judged = [run for run in runs if run.has_errors and len(run.scene.start) > 1]
    return typed(
        MEMBERS,
        {
            **keys(judged, [len(run.scene.start) for run in judged]),
            "member": joined([np.arange(len(run.scene.start), dtype=float) for run in judged]),
            "max_error_m": joined([run.distances.max(axis=(0, 2)) for run in judged]),
            "resolution_m": joined([run.limits.max(axis=0) for run in judged]),
        },
    )


def keys(runs: Sequence[Run], counts: Sequence[int]) -> dict[str, object]:
    """Return the columns that say which run a row is of; counts: the rows of each."""
    steps, tolerances = np.array([[*step_columns(run).values()] for run in runs], dtype=float).reshape(-1, 2).T
    return {
        "scene": np.repeat(np.array([run.scene.name for run in runs], dtype=object), counts),
        "engine": np.repeat(np.array([run.engine for run in runs], dtype=object), counts),
        "method": np.repeat(np.array([run.method for run in runs], dtype=object), counts),
        "dt_s": np.repeat(steps, counts),
        "tolerance": np.repeat(tolerances, counts),
    }


def joined(parts: Sequence[Array]) -> Array:
    """Return arrays (n,) one after the other."""
    return np.concatenate([np.empty(0), *parts]) if parts else np.empty(0)


def stacked(parts: Sequence[Array]) -> Array:
    """Return vectors (..., 3) one after the other, (n, 3)."""
    return np.concatenate([np.empty((0, 3)), *(part.reshape(-1, 3) for part in parts)])
