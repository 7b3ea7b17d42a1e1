"""The tables of a release ledger: one line a column."""

from dataclasses import dataclass
from typing import Annotated

from tumble.compare.judge.trend import TRENDS
from tumble.compare.tables.schema import Table
from tumble.compare.tables.shared import Engine, Limit, Method, SceneName, Status, Step, Why

Release = Annotated[str, "release of the engine"]


@dataclass(frozen=True, kw_only=True)
class ReleaseRow:
    """One method of one release on one scene: errors, orders, what becomes of the energy, and its speed."""

    engine: Engine
    release: Release
    scene: SceneName
    method: Method
    dt_s: Step
    status: Status
    why: Why
    max_error_m: Annotated[float | None, "largest error of any vertex and sample"]
    resolution_m: Limit
    energy_drift: Annotated[float | None, "largest drift of the energy from the truth, over its scale"]
    angular_momentum_drift: Annotated[
        float | None, "largest drift of the angular momentum from the truth, over its scale"
    ]
    attitude_order: Annotated[float | None, "order of convergence of the attitude; empty where none can be read"]
    translation_order: Annotated[
        float | None, "order of convergence of the centre of mass; empty where none can be read"
    ]
    spin_energy: Annotated[
        str, f"what becomes of the energy of the spin: {', '.join(TRENDS)}; empty where none is kept"
    ]
    step_ns: Annotated[float | None, "time of a step, on the first scene alone; empty where it was not timed"] = None
    time_ratio: Annotated[float | None, "time of a step over the newest release's, in the same rounds"] = None
    time_ratio_low: Annotated[float | None, "lower end of the 95 % confidence interval of time_ratio"] = None
    time_ratio_high: Annotated[float | None, "upper end of the 95 % confidence interval of time_ratio"] = None


@dataclass(frozen=True, kw_only=True)
class ReleaseChangeRow:
    """What one release does otherwise than the one before it, over all scenes on which it shows."""

    engine: Engine
    release: Release
    before: Annotated[str, "the release before it"]
    method: Method
    what: Annotated[str, "method, status, attitude_order, translation_order, spin_energy, max_error_m or time"]
    old: Annotated[str, "what it was, scene by scene"]
    new: Annotated[str, "what it is"]
    scenes: Annotated[str, "where it shows"]
    notes: Annotated[str, "what the release notes say of the method, where they are shipped"] = ""


RELEASES = Table("releases.csv", ReleaseRow, ("engine", "release", "scene", "method"))
CHANGES = Table("release-changes.csv", ReleaseChangeRow, ("engine", "release", "method", "what"))
TABLES = (RELEASES, CHANGES)
