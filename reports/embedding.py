"""The data of the page: each table column by column, films as numbers in single precision."""

import base64
import json
import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pandas as pd

from tumble.compare.comparison.schemas import SENSORS
from tumble.compare.coursework.schemas import PUBLISHED
from tumble.compare.engines import BY_HAND, OWN
from tumble.reports.coursework import page_rows
from tumble.reports.hues import places
from tumble.scenarios.frames import quaternion_product

TRUTH = "truth"
# These become films, or are too long to carry whole.
PACKED = ("motion.csv", "deformed.csv", "vertex-errors.csv", "error-over-time.csv")
X, V, W = ([f"{name}{axis}{unit}" for axis in "xyz"] for name, unit in (("", "_m"), ("v", "_m_s"), ("w", "_rad_s")))
Q = ["qw", "qx", "qy", "qz"]
MOMENTUM = [f"l{axis}_kg_m2_s" for axis in (1, 2, 3)]
FELT = [*(f"a{axis}_m_s2" for axis in "xyz"), *W]
FIGURES = ["error_m", "energy_drift", "angular_momentum_drift"]
OF_RUNS = ("runs.csv", "sweep-runs.csv", "limits.csv", "extremes.csv", "contact.csv")
# A number that is repeated this often is shorter as a reference.
OFTEN = 3
TRUE = [*X, *Q, *V, *W, *MOMENTUM]
CONTESTANT = ["engine", "method"]


def data_of(tables: Mapping[str, pd.DataFrame]) -> str:
    """Return the data of the page.

    Parameters
    ----------
    tables
        File name -> table.

    Returns
    -------
    str
        JSON that can stand in a script element.
    """
    read = dict(tables)
    films = dict(films_of(read))
    read["vertex-errors.csv"] = at_the_end(read.get("vertex-errors.csv", pd.DataFrame()))
    read[PUBLISHED.file] = page_rows(read.get(PUBLISHED.file, pd.DataFrame()))
    read[SENSORS.file] = sensor_readings(read.get(SENSORS.file, pd.DataFrame()))
    read["error-over-time.csv"] = unfilmed(read.get("error-over-time.csv", pd.DataFrame()), films)
    whole_tables = {name: table for name, table in read.items() if len(table) and name not in PACKED[:2]}
    whole = {
        "ours": OWN,
        "byHand": BY_HAND,
        "places": places(taking_part(read)),
        "files": [name for name, table in read.items() if len(table)],
        "tables": {name: embedded(table) for name, table in whole_tables.items()},
        "films": films,
    }
    # In a script element nothing may look like its end.
    return json.dumps(whole, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


def taking_part(read: Mapping[str, pd.DataFrame]) -> list[str]:
    """Return the engines of all tables of runs, in their order there."""
    columns = [read[name]["engine"] for name in OF_RUNS if len(read.get(name, ()))]
    return list(dict.fromkeys(str(engine) for column in columns for engine in column))


def embedded(table: pd.DataFrame) -> dict:
    """Return a table column by column."""
    return {
        "columns": list(table.columns),
        "length": len(table),
        "values": {name: values(table[name]) for name in table.columns},
    }


def values(column: Any) -> list | dict:
    """Return a column's values; words, and numbers that are repeated often, once each with their positions."""
    if isinstance(column.dtype, pd.StringDtype):
        codes, words = pd.factorize(column)
        return {"words": list(words), "at": codes.tolist()}
    cells = [number(value) for value in column.tolist()]
    once = {str(value): value for value in cells}  # -0.0 is not 0.0
    if len(once) > len(cells) / OFTEN:
        return cells
    places = {name: place for place, name in enumerate(once)}
    return {"numbers": list(once.values()), "at": [places[str(value)] for value in cells]}


def number(value: object) -> object:
    """Return a value for JSON, which has no infinity; an empty cell is null."""
    if value is pd.NA or (isinstance(value, float) and math.isnan(value)):
        return None
    if isinstance(value, float) and math.isinf(value):
        return "Infinity" if value > 0 else "-Infinity"
    return value


def at_the_end(errors: pd.DataFrame) -> pd.DataFrame:
    """Return the vertex errors at each scene's last sample."""
    if errors.empty:
        return errors
    last = where(errors, errors["t_s"] == errors.groupby("scene")["t_s"].transform("max"))
    return last.filter(["scene", *CONTESTANT, "vertex", "true_x_m", "true_y_m", "true_z_m", *X, "error_m"])


def sensor_readings(readings: pd.DataFrame) -> pd.DataFrame:
    """Return the readings of sensors and the true ones, with as many digits as a chart shows; not their differences."""
    if readings.empty:
        return readings
    found = readings.filter(["scene", *CONTESTANT, "sensor", "t_s", *FELT, *(f"true_{name}" for name in FELT)]).copy()
    for name in found.columns[5:]:
        found[name] = [value if math.isnan(value) else float(f"{value:.6g}") for value in found[name].tolist()]
    return found


def unfilmed(errors: pd.DataFrame, films: Mapping[str, object]) -> pd.DataFrame:
    """Return the errors over time of the scenes that have no film."""
    return where(errors, ~errors["scene"].isin(list(films))) if len(errors) else errors


def films_of(read: Mapping[str, pd.DataFrame]) -> Iterator[tuple[str, dict]]:
    """Yield scene and film: the truth, and the contestants' deviations from it."""
    motion, deformed = (read.get(f"{name}.csv", pd.DataFrame()) for name in ("motion", "deformed"))
    if motion.empty:
        return
    scenes = read["scenes.csv"]
    needs = dict(zip(scenes["scene"], scenes["needs"], strict=True))
    deformed_runs = parts(deformed, ["scene", *CONTESTANT])
    for (scene,), rows in parts(motion, ["scene"]).items():
        runs = parts(rows, CONTESTANT)
        true = runs.pop((TRUTH, ""))
        yield (
            scene,
            {
                "t": true["t_s"].tolist(),
                "truth": packed(numbers(true, TRUE)),
                "limit": limits(read, scene, numbers(true, ["t_s"])[:, 0]),
                "runs": {
                    ":".join(filter(None, key)): run_frames(
                        own, true, "gyroscopic" in needs[scene], deformed_runs.get((scene, *key))
                    )
                    for key, own in runs.items()
                },
            },
        )


def parts(table: pd.DataFrame, keys: list[str]) -> dict[tuple[str, ...], pd.DataFrame]:
    """Return a table's rows by some of its columns, in order."""
    if table.empty:
        return {}
    return {tuple(map(str, key)): own for key, own in table.groupby(keys, sort=False)}  # type: ignore[call-overload]


def where(table: pd.DataFrame, wanted: Any) -> pd.DataFrame:
    """Return the rows of a table for which it is true."""
    return table.loc[wanted.to_numpy(dtype=bool)]


def numbers(table: pd.DataFrame, columns: list[str]) -> np.ndarray:
    """Return columns as an array, (rows, columns)."""
    return np.column_stack([table[name].to_numpy(dtype=float) for name in columns])


def limits(read: Mapping[str, pd.DataFrame], scene: str, times: np.ndarray) -> list[float]:
    """Return the resolution of the truth at each time [m]: that of the next sample at which errors were measured."""
    errors = read.get("error-over-time.csv", pd.DataFrame(columns=["scene", "t_s", "resolution_m"]))
    known = numbers(
        where(errors, errors["scene"] == scene).drop_duplicates("t_s").sort_values("t_s"), ["t_s", "resolution_m"]
    )
    if not len(known):
        return [0.0] * len(times)
    at = np.minimum(np.searchsorted(known[:, 0], times), len(known) - 1)
    return [float(f"{limit:.3g}") for limit in known[at, 1]]


def run_frames(own: pd.DataFrame, true: pd.DataFrame, turns: bool, deformed: pd.DataFrame | None) -> dict[str, str]:
    """Return one contestant's frames: x - x_true, q q_true^-1, error and drifts."""
    beside = true.head(len(own))
    away = numbers(own, X) - numbers(beside, X)
    turned = quaternion_product(numbers(own, Q), numbers(beside, Q) * (1.0, -1.0, -1.0, -1.0))
    found = {"frames": packed(np.concatenate([away, turned, numbers(own, FIGURES)], axis=1))}
    if turns:
        found["momentum"] = packed(numbers(own, MOMENTUM))
    if deformed is not None:
        found["vertices"] = packed(numbers(deformed, X))
    return found


def packed(values: np.ndarray) -> str:
    """Return numbers in single precision, as text."""
    with np.errstate(over="ignore"):
        return base64.b64encode(values.astype("<f4").tobytes()).decode()
