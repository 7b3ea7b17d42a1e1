"""The rows of sensor-errors.csv, without the libraries of tables: what a terminal prints needs no more."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from tumble.compare.comparison.schemas import SensorErrorRow
from tumble.compare.judge.sensors import QUANTITIES, SensorErrors, SensorRun
from tumble.compare.run.status import Failure, Status


def sensor_error_rows(run: SensorRun) -> Iterator[SensorErrorRow]:
    """Yield the rows of one run: a sensor's quantities, or why there are none.

    Parameters
    ----------
    run : the readings of one contestant in one scene

    Returns
    -------
    rows of sensor-errors.csv
    """
    for number, sensor in enumerate(run.scene.sensors):
        errors = run.sensors[number] if run.sensors else None
        reads = (sensor.reads_force, sensor.reads_spin, sensor.field is not None)
        for read, (quantity, unit, columns, place) in zip(reads, QUANTITIES, strict=True):
            if read:
                yield SensorErrorRow(
                    scene=run.scene.name,
                    engine=run.engine,
                    method=run.method,
                    dt_s=run.dt if run.tolerance is None else math.nan,
                    tolerance=run.tolerance,
                    sensor=sensor.name,
                    quantity=quantity,
                    unit=unit,
                    reading=how(run),
                    status=run.status.value,
                    why=run.reason,
                    **({} if errors is None else figures(errors, columns, place, run.status)),
                )


def figures(errors: SensorErrors, columns: slice, place: int, status: Status) -> dict[str, Any]:
    """Return the numbers of one quantity: largest and mean error, and what they are compared with."""
    distances = errors.distances(columns)
    known = np.isfinite(distances)
    true = np.linalg.norm(errors.true[:, columns], axis=1)
    found: dict[str, Any] = {"readings": int(known.sum()), "left_out": int((~known).sum())}
    if known.any():
        found |= {
            "max_error": math.inf if status == Status.DIVERGED else float(distances[known].max()),
            "rms_error": math.inf if status == Status.DIVERGED else float(np.sqrt((distances[known] ** 2).mean())),
            "resolution": float(errors.truth.resolution[known, 0, place].max()),
            "true_max": float(true[known].max()),
        }
    return found


def how(run: SensorRun) -> str:
    """Return how the run's specific force is read, empty where there are no readings."""
    return "" if isinstance(run.answer, Failure) else run.answer.how
