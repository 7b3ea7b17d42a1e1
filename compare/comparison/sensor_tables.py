"""sensors.csv and sensor-errors.csv, as DataFrames."""

import math
from collections.abc import Iterable, Sequence

import numpy as np
import pandas as pd

from tumble.compare.comparison.schemas import SENSOR_ERRORS, SENSORS
from tumble.compare.comparison.sensor_errors import how, sensor_error_rows
from tumble.compare.judge.sensors import SensorRun
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
