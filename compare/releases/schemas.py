"""The tables of a release ledger: one line a column."""

from dataclasses import dataclass
from typing import Annotated

from tumble.compare.judge.trend import TRENDS
from tumble.compare.tables.schema import Table
from tumble.compare.tables.shared import Engine, Limit, Method, SceneName, Status, Step, Why

Release = Annotated[str, "release of the engine"]


@dataclass(frozen=True, kw_only=True)
class ReleaseRow:
    """One method of one release on one scene: errors, orders, behaviour of the spin energy, and run time."""

    engine: Engine
    release: Release
    scene: SceneName
    method: Method
    dt_s: Step
    status: Status
    why: Why
    max_error_m: Annotated[float | None, "largest error over vertices and samples"]
    resolution_m: Limit
    energy_drift: Annotated[
        float | None, "largest difference from the true energy, over the largest true kinetic energy"
    ]
    angular_momentum_drift: Annotated[
        float | None, "largest difference from the true angular momentum, over its largest true value"
    ]
    attitude_order: Annotated[float | None, "order of convergence of the attitude; empty if it cannot be determined"]
    translation_order: Annotated[
        float | None, "order of convergence of the centre of mass; empty if it cannot be determined"
    ]
    spin_energy: Annotated[str, f"behaviour of the spin energy: {', '.join(TRENDS)}; empty if nothing rotates freely"]
    step_ns: Annotated[float | None, "time per step, on the first scene only; empty if it was not timed"] = None
    time_ratio: Annotated[float | None, "time per step over the newest release's, sampled in the same rounds"] = None
    time_ratio_low: Annotated[float | None, "lower end of the 95 % confidence interval of time_ratio"] = None
    time_ratio_high: Annotated[float | None, "upper end of the 95 % confidence interval of time_ratio"] = None


@dataclass(frozen=True, kw_only=True)
class ReleaseChangeRow:
    """One change of a release from the one before it, with all scenes that show it."""

    engine: Engine
    release: Release
    before: Annotated[str, "previous release"]
    method: Method
    what: Annotated[
        str,
        "what changed: method, status, attitude_order, translation_order, spin_energy, contact, law_error, "
        "contact_error, max_error_m or time",
    ]
    old: Annotated[str, "values of the previous release, one per scene, separated by `; `"]
    new: Annotated[str, "values of this release, one per scene, separated by `; `"]
    scenes: Annotated[str, "scenes that show the change, separated by commas"]
    notes: Annotated[str, "the release notes on the method; empty if none are shipped"] = ""


RELEASES = Table("releases.csv", ReleaseRow, ("engine", "release", "scene", "method"))
CHANGES = Table("release-changes.csv", ReleaseChangeRow, ("engine", "release", "method", "what"))
TABLES = (RELEASES, CHANGES)
