"""The tables of a record, beside its engines and conditions: one line a column."""

from dataclasses import dataclass
from typing import Annotated

from tumble.compare.judge.trend import TRENDS
from tumble.compare.tables.schema import Table
from tumble.compare.tables.shared import (
    CONTESTANT,
    AngularMomentumDrift,
    EnergyDrift,
    Engine,
    FinalError,
    Limit,
    MaxError,
    Method,
    MomentumDrift,
    RmsError,
    SceneName,
    Status,
    Steps,
    Why,
)

EXACT = "exact"  # of a scene that has a truth
ERRORS = ("max_error_m", "rms_error_m", "final_error_m")
DRIFTS = ("energy_drift", "momentum_drift", "angular_momentum_drift")
# From good to bad: a run that was flagged is better than one that diverged, and that than none.
STATUSES = {"ok": 0, "flagged": 1, "diverged": 2, "skipped": 3, "missing": 4, "timeout": 4, "crashed": 4}


@dataclass(frozen=True, kw_only=True)
class QuestionRow:
    """One scene as it was asked: its step and samples, and where its last vertex truly is at the last sample.

    A scene file that was changed asks another question, and its errors are not comparable: the true answer shows it.
    """

    scene: SceneName
    step_s: Annotated[float, "the scene's own step"]
    samples: Annotated[int, "number of instants at which errors are measured"]
    truth: Annotated[str, f"`{EXACT}`, or why there is none"]
    resolution_m: Limit
    size_m: Annotated[float, "how far the furthest vertex is from the centre of mass"]
    x_m: Annotated[float | None, "true x of the last vertex at the last sample that has a truth, world axes"] = None
    y_m: Annotated[float | None, "true y of the last vertex at the last sample that has a truth, world axes"] = None
    z_m: Annotated[float | None, "true z of the last vertex at the last sample that has a truth, world axes"] = None


@dataclass(frozen=True, kw_only=True)
class CellRow:
    """One contestant on one scene at the scene's own step: errors, drifts from the truth, orders, energy of the spin.

    Columns of runs.csv have the meanings that they have there.
    """

    scene: SceneName
    engine: Engine
    method: Method
    steps: Steps
    status: Status
    why: Why = ""
    max_error_m: MaxError = None
    rms_error_m: RmsError = None
    final_error_m: FinalError = None
    resolution_m: Limit = None
    rounding_m: Annotated[
        float | None, "what the roundings of all steps may come to on another processor; empty where unknown"
    ] = None
    energy_drift: EnergyDrift = None
    momentum_drift: MomentumDrift = None
    angular_momentum_drift: AngularMomentumDrift = None
    attitude_order: Annotated[float | None, "order of the attitude's error; empty where it cannot be read"] = None
    translation_order: Annotated[float | None, "order of the centre of mass's error; likewise"] = None
    spin_energy: Annotated[str, f"{', '.join(TRENDS)}: the energy of the spin; empty where nothing turns freely"] = ""


@dataclass(frozen=True, kw_only=True)
class TimeRow:
    """The run time of one contestant's flight over the reference contestant's, with its interval."""

    scene: SceneName
    engine: Engine
    method: Method
    reference: Annotated[str, "ENGINE:METHOD that the ratio is over"]
    time_ratio: Annotated[float | None, "ratio of times; empty where it would say nothing"] = None
    time_ratio_low: Annotated[float | None, "lower end of the 95 % confidence interval of time_ratio"] = None
    time_ratio_high: Annotated[float | None, "upper end of the 95 % confidence interval of time_ratio"] = None


QUESTIONS = Table("questions.csv", QuestionRow, ("scene",))
CELLS = Table("cells.csv", CellRow, CONTESTANT)
TIMES = Table("times.csv", TimeRow, (*CONTESTANT, "reference"))
TABLES = (QUESTIONS, CELLS, TIMES)
