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

EXACT = "exact"  # of a scene with a reference solution
ERRORS = ("max_error_m", "rms_error_m", "final_error_m")
DRIFTS = ("energy_drift", "momentum_drift", "angular_momentum_drift")
# From good to bad.
STATUSES = {"ok": 0, "flagged": 1, "diverged": 2, "skipped": 3, "missing": 4, "timeout": 4, "crashed": 4}


@dataclass(frozen=True, kw_only=True)
class QuestionRow:
    """One scene as it was run: step, samples, and the true position of its last vertex at the last sample.

    The true position shows whether a scene file was changed, so that its errors cannot be compared.
    """

    scene: SceneName
    step_s: Annotated[float, "step of the scene"]
    samples: Annotated[int, "number of samples at which errors are measured"]
    truth: Annotated[str, f"`{EXACT}`, or why there is no reference solution"]
    resolution_m: Limit
    size_m: Annotated[float, "largest distance of a vertex from the centre of mass"]
    x_m: Annotated[
        float | None, "true x of the last vertex at the last sample with a reference solution, world axes"
    ] = None
    y_m: Annotated[
        float | None, "true y of the last vertex at the last sample with a reference solution, world axes"
    ] = None
    z_m: Annotated[
        float | None, "true z of the last vertex at the last sample with a reference solution, world axes"
    ] = None


@dataclass(frozen=True, kw_only=True)
class CellRow:
    """One contestant on one scene at the scene's own step: errors, drifts, orders, behaviour of the spin energy.

    Columns of runs.csv have the same meaning there.
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
        float | None, "vertex error that rounding in all steps may cause on another processor; empty if unknown"
    ] = None
    energy_drift: EnergyDrift = None
    momentum_drift: MomentumDrift = None
    angular_momentum_drift: AngularMomentumDrift = None
    attitude_order: Annotated[
        float | None, "order of convergence of the attitude; empty if it cannot be determined"
    ] = None
    translation_order: Annotated[
        float | None, "order of convergence of the centre of mass; empty if it cannot be determined"
    ] = None
    spin_energy: Annotated[
        str, f"behaviour of the spin energy: {', '.join(TRENDS)}; empty if nothing rotates freely"
    ] = ""


@dataclass(frozen=True, kw_only=True)
class TimeRow:
    """The run time of one contestant over the reference contestant's, with its confidence interval."""

    scene: SceneName
    engine: Engine
    method: Method
    reference: Annotated[str, "ENGINE:METHOD that run times are divided by"]
    time_ratio: Annotated[float | None, "run time over the reference's; empty if it is not significant"] = None
    time_ratio_low: Annotated[float | None, "lower end of the 95 % confidence interval of time_ratio"] = None
    time_ratio_high: Annotated[float | None, "upper end of the 95 % confidence interval of time_ratio"] = None


QUESTIONS = Table("questions.csv", QuestionRow, ("scene",))
CELLS = Table("cells.csv", CellRow, CONTESTANT)
TIMES = Table("times.csv", TimeRow, (*CONTESTANT, "reference"))
TABLES = (QUESTIONS, CELLS, TIMES)
