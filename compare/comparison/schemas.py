"""The tables of a comparison alone."""

from dataclasses import dataclass
from typing import Annotated

from tumble.compare.judge.agreement import AgreementRow
from tumble.compare.tables.schema import EMPTY, Table
from tumble.compare.tables.shared import Engine, Method, SceneName, Status, Step, Tolerance, Why

SensorName = Annotated[str, "name of the sensor"]
How = Annotated[
    str,
    "how the specific force is read: sensor: by the engine's own; derivatives: from the solver's own equations in the "
    "state; differences: of the point's velocity over the last step, as scripts do; empty if there is no run",
]
FORCE = "of the specific force, sensor axes; empty if it is not read or not defined"
SPIN = "of the angular velocity, sensor axes; empty if it is not read"
FIELD = "of the direction of the magnetic field, sensor axes; empty if it is not read"
READ, TRUE, ERROR = "reading, {} component ", "true {} component ", "reading less true value, {} component "


@dataclass(frozen=True, kw_only=True)
class SensorRow:
    """One reading of one sensor in one run, with its true value; of many throws the first, which is the scene's own."""

    scene: SceneName
    engine: Engine
    method: Method
    dt_s: Step
    sensor: SensorName
    t_s: Annotated[float, "time of the reading"]
    ax_m_s2: Annotated[float, READ.format("x") + FORCE, EMPTY]
    ay_m_s2: Annotated[float, READ.format("y") + FORCE, EMPTY]
    az_m_s2: Annotated[float, READ.format("z") + FORCE, EMPTY]
    wx_rad_s: Annotated[float, READ.format("x") + SPIN, EMPTY]
    wy_rad_s: Annotated[float, READ.format("y") + SPIN, EMPTY]
    wz_rad_s: Annotated[float, READ.format("z") + SPIN, EMPTY]
    true_ax_m_s2: Annotated[float, TRUE.format("x") + FORCE, EMPTY]
    true_ay_m_s2: Annotated[float, TRUE.format("y") + FORCE, EMPTY]
    true_az_m_s2: Annotated[float, TRUE.format("z") + FORCE, EMPTY]
    true_wx_rad_s: Annotated[float, TRUE.format("x") + SPIN, EMPTY]
    true_wy_rad_s: Annotated[float, TRUE.format("y") + SPIN, EMPTY]
    true_wz_rad_s: Annotated[float, TRUE.format("z") + SPIN, EMPTY]
    error_ax_m_s2: Annotated[float, ERROR.format("x") + FORCE, EMPTY]
    error_ay_m_s2: Annotated[float, ERROR.format("y") + FORCE, EMPTY]
    error_az_m_s2: Annotated[float, ERROR.format("z") + FORCE, EMPTY]
    error_wx_rad_s: Annotated[float, ERROR.format("x") + SPIN, EMPTY]
    error_wy_rad_s: Annotated[float, ERROR.format("y") + SPIN, EMPTY]
    error_wz_rad_s: Annotated[float, ERROR.format("z") + SPIN, EMPTY]
    mx: Annotated[float, READ.format("x") + FIELD, EMPTY]
    my: Annotated[float, READ.format("y") + FIELD, EMPTY]
    mz: Annotated[float, READ.format("z") + FIELD, EMPTY]
    true_mx: Annotated[float, TRUE.format("x") + FIELD, EMPTY]
    true_my: Annotated[float, TRUE.format("y") + FIELD, EMPTY]
    true_mz: Annotated[float, TRUE.format("z") + FIELD, EMPTY]
    error_mx: Annotated[float, ERROR.format("x") + FIELD, EMPTY]
    error_my: Annotated[float, ERROR.format("y") + FIELD, EMPTY]
    error_mz: Annotated[float, ERROR.format("z") + FIELD, EMPTY]
    tolerance: Tolerance
    reading: How
    why: Annotated[str, "why the row lacks a reading or its true value; empty if it has all"]


@dataclass(frozen=True, kw_only=True)
class SensorErrorRow:
    """The error of one quantity of one sensor in one run, over all readings that have a true value."""

    scene: SceneName
    engine: Engine
    method: Method
    dt_s: Step
    tolerance: Tolerance
    sensor: SensorName
    quantity: Annotated[str, "specific force, angular velocity or field direction"]
    unit: Annotated[str, "unit of the errors: m/s2, rad/s or 1"]
    reading: How
    status: Status
    why: Why = ""
    readings: Annotated[int | None, "number of readings that have a true value"] = None
    left_out: Annotated[int | None, "number of instants without a reading or without a true value"] = None
    max_error: Annotated[float | None, "largest distance of a reading from the true one; inf of one that diverged"] = (
        None
    )
    rms_error: Annotated[float | None, "root mean square of these distances"] = None
    resolution: Annotated[
        float | None, "resolution of the reference, largest: smaller errors are indistinguishable from zero"
    ] = None
    true_max: Annotated[float | None, "largest magnitude of the true reading"] = None


@dataclass(frozen=True, kw_only=True)
class EnsembleErrorRow:
    """One run of throws that ran in parts: moments and quantiles of each throw's largest vertex error.

    An error below the resolution of the reference counts as that.
    """

    scene: SceneName
    engine: Engine
    method: Method
    dt_s: Step
    tolerance: Tolerance
    status: Status
    members: Annotated[int, "number of throws that were run"]
    unknown: Annotated[int, "of these, how many have no reference solution; they count nowhere else"]
    lost: Annotated[int, "of these, how many diverged; their error is inf, and mean and deviation leave them out"]
    mean_error_m: Annotated[float | None, "mean of the throws' errors"] = None
    deviation_m: Annotated[float | None, "standard deviation of the throws' errors"] = None
    p1_error_m: Annotated[float | None, "1 % of the throws have at most this error"] = None
    p5_error_m: Annotated[float | None, "5 % of the throws have at most this error"] = None
    p25_error_m: Annotated[float | None, "25 % of the throws have at most this error"] = None
    median_error_m: Annotated[float | None, "half of the throws have at most this error"] = None
    p75_error_m: Annotated[float | None, "75 % of the throws have at most this error"] = None
    p95_error_m: Annotated[float | None, "95 % of the throws have at most this error"] = None
    p99_error_m: Annotated[float | None, "99 % of the throws have at most this error"] = None
    p99_9_error_m: Annotated[float | None, "99.9 % of the throws have at most this error"] = None
    p99_99_error_m: Annotated[float | None, "99.99 % of the throws have at most this error"] = None
    p99_9999_error_m: Annotated[float | None, "99.9999 % of the throws have at most this error"] = None
    max_error_m: Annotated[float | None, "largest error; exact, as in runs.csv"] = None
    quantile_error: Annotated[float | None, "most that a quantile differs from the exact one, as a share of it"] = None


AGREEMENT = Table("agreement.csv", AgreementRow, ("scene", "engine_a", "method_a", "engine_b", "method_b"))
SENSORS = Table("sensors.csv", SensorRow, ("scene", "engine", "method", "dt_s", "sensor", "t_s"))
SENSOR_ERRORS = Table("sensor-errors.csv", SensorErrorRow, ("scene", "engine", "method", "dt_s", "sensor", "quantity"))
ENSEMBLE_ERRORS = Table("ensemble-errors.csv", EnsembleErrorRow, ("scene", "engine", "method", "dt_s"))
TABLES = (AGREEMENT, ENSEMBLE_ERRORS, SENSORS, SENSOR_ERRORS)
