"""What is written of the throws of a scene that ran in parts."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from tumble.compare.comparison.against_truth import Comparison
from tumble.compare.comparison.in_parts import EnsembleRun
from tumble.compare.comparison.schemas import EnsembleErrorRow
from tumble.compare.judge.spread import BIN_ERROR, Spread
from tumble.compare.run.flight import mean_step
from tumble.compare.tables.runs import boundless, run_row
from tumble.compare.tables.shared import ErrorOverTimeRow, MemberRow, RunRow

# Column, and the share of the throws with at most that error.
QUANTILES = {
    "p1_error_m": 0.01,
    "p5_error_m": 0.05,
    "p25_error_m": 0.25,
    "median_error_m": 0.5,
    "p75_error_m": 0.75,
    "p95_error_m": 0.95,
    "p99_error_m": 0.99,
    "p99_9_error_m": 0.999,
    "p99_99_error_m": 0.9999,
    "p99_9999_error_m": 0.999999,
}


@dataclass(frozen=True)
class Named:
    """A run of many throws, with the columns that name it."""

    comparison: Comparison
    run: EnsembleRun

    @property
    def spread(self) -> Spread:
        """Its errors."""
        return self.run.spread

    @property
    def columns(self) -> dict[str, Any]:
        """Scene, contestant, and step or tolerance."""
        engine, tolerance = self.run.running_engine, self.run.tolerance
        return {
            "scene": self.comparison.scene.name,
            "engine": engine.title,
            "method": self.run.method,
            "dt_s": self.run.dt if tolerance is None else math.nan,
            "tolerance": tolerance,
        }


def ensembles_of(comparison: Comparison) -> list[Named]:
    """Return the runs of many throws of a comparison, none of a scene whose throws are all held at once.

    Parameters
    ----------
    comparison : of the scene

    Returns
    -------
    a run a contestant
    """
    return [Named(comparison, one) for one in comparison.ensemble]


def run_rows(comparison: Comparison) -> list[RunRow]:
    """Return the rows of a scene in runs.csv, over all its throws.

    Parameters
    ----------
    comparison : of the scene

    Returns
    -------
    one row for each contestant
    """
    return [spread_row(one) for one in ensembles_of(comparison)] or [run_row(run) for run in comparison.runs]


def spread_row(one: Named) -> RunRow:
    """Return the row of a run of many throws in runs.csv.

    Parameters
    ----------
    one : the run

    Returns
    -------
    row
    """
    spread, scene = one.spread, one.comparison.scene
    row: dict[str, Any] = {**one.columns, "status": spread.status.value, "why": spread.why}
    if spread.steps:
        has_step = one.run.tolerance is None
        row |= {
            "steps": spread.steps if has_step else None,
            "wall_s": spread.wall_s,
            "wall_ns_per_step": spread.wall_s / spread.steps * 1e9 if has_step else None,
            "wall_per_sim_s": spread.wall_s / scene.duration,
            "dt_taken_s": mean_step(scene.duration, spread.steps, one.run.dt) if has_step and not spread.lost else None,
        }
    if spread.known:
        energy, momentum, angular = map(boundless, spread.drifts)
        row |= {
            "max_error_m": float(spread.worst_m[0]),
            "rms_error_m": boundless(np.sqrt(spread.vertex_squares / spread.vertices)),
            "final_error_m": boundless(spread.final_m),
            "resolution_m": float(spread.limits_m.max()),
            "energy_drift": energy,
            "momentum_drift": momentum,
            "angular_momentum_drift": angular,
        }
    return RunRow(**row)


def ensemble_error_row(one: Named) -> EnsembleErrorRow:
    """Return the row of a run of many throws in ensemble-errors.csv."""
    spread = one.spread
    found: dict[str, Any] = {}
    if spread.known:
        found = {name: spread.quantile(share) for name, share in QUANTILES.items()}
        found |= {"mean_error_m": spread.mean_m, "deviation_m": spread.deviation_m}
        found |= {"max_error_m": float(spread.worst_m[0]), "quantile_error": BIN_ERROR}
    return EnsembleErrorRow(
        **one.columns,
        status=spread.status.value,
        members=spread.throws,
        unknown=spread.unknown,
        lost=spread.lost,
        **found,
    )


def worst_rows(one: Named) -> Iterator[MemberRow]:
    """Yield the rows of the worst throws in members.csv."""
    spread = one.spread
    for member, error, limit in zip(spread.worst, spread.worst_m, spread.worst_resolution_m, strict=True):
        found = float(error) if math.isfinite(error) else math.nan
        yield MemberRow(**one.columns, member=int(member), max_error_m=found, resolution_m=float(limit))


def over_time_rows(one: Named) -> Iterator[ErrorOverTimeRow]:
    """Yield the rows of a run of many throws in error-over-time.csv."""
    spread = one.spread
    for time, error, limit in zip(one.comparison.scene.times, spread.over_time_m, spread.limits_m, strict=False):
        yield ErrorOverTimeRow(**one.columns, t_s=float(time), error_m=float(error), resolution_m=float(limit))
