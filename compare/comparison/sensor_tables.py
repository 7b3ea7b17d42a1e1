"""sensors.csv and sensor-errors.csv, from whole arrays."""

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np
import pandas as pd

from tumble.compare.comparison.schemas import SENSOR_ERRORS, SENSORS, SensorErrorRow
from tumble.compare.judge.sensors import QUANTITIES, SensorErrors, SensorRun
from tumble.compare.run.status import Failure, Status
from tumble.compare.tables.frames import frame, typed
from tumble.scenarios.frames import Array

COLUMNS = (*(f"a{axis}_m_s2" for axis in "xyz"), *(f"w{axis}_rad_s" for axis in "xyz"), *(f"m{axis}" for axis in "xyz"))


def sensor_tables(runs: Sequence[SensorRun]) -> dict[str, pd.DataFrame]:
    """Return the tables of sensors.

    Parameters
    ----------
    runs : the readings of every contestant in every scene

    Returns
    -------
    table by file name
    """
    rows = [row for run in runs for row in sensor_error_rows(run)]
    return {SENSORS.file: reading_table(runs), SENSOR_ERRORS.file: frame(SENSOR_ERRORS, rows)}


def reading_table(runs: Sequence[SensorRun]) -> pd.DataFrame:
    """Return sensors.csv: every reading of every run that has any, with its true value and error."""
    pairs = [(run, errors) for run in runs for errors in run.sensors]
    counts = [len(errors.values) for _, errors in pairs]

    def named(names: Iterable[object]) -> np.ndarray:
        return np.repeat(np.array([*names], dtype=object), counts)

    def stacked(parts: list[Array]) -> Array:
        return np.concatenate([np.empty((0, 9)), *parts]).T

    columns = {
        "scene": named(run.scene.name for run, _ in pairs),
        "engine": named(run.engine for run, _ in pairs),
        "method": named(run.method for run, _ in pairs),
        "dt_s": np.repeat([run.dt if run.tolerance is None else math.nan for run, _ in pairs], counts),
        "sensor": named(errors.sensor.name for _, errors in pairs),
        "t_s": np.concatenate([np.empty(0), *(errors.truth.times for _, errors in pairs)]),
        "tolerance": np.repeat(np.array([run.tolerance for run, _ in pairs], dtype=float), counts),
        "reading": named(how(run) for run, _ in pairs),
        "why": [why for _, errors in pairs for why in errors.why],
    }
    for prefix, values in (
        ("", stacked([errors.values for _, errors in pairs])),
        ("true_", stacked([errors.true for _, errors in pairs])),
        ("error_", stacked([errors.errors for _, errors in pairs])),
    ):
        columns |= dict(zip((f"{prefix}{name}" for name in COLUMNS), values, strict=True))
    return typed(SENSORS, columns)


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
