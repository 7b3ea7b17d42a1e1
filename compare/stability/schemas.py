"""The tables of maps of stability and of the extreme cases: one line a column."""

from dataclasses import dataclass
from typing import Annotated

from tumble.compare.tables.schema import Table
from tumble.compare.tables.shared import CONTESTANT, Engine, Limit, Method, SceneName, Status, Why

Parameter = Annotated[str, "parameter that makes the scene stiff, with its unit"]
Word = Annotated[str, "verdict on the run, as `tumble stability` prints it"]
Ratio = Annotated[float | None, "energy at the end over its true value or physical bound; empty if there is no run"]
Worst = Annotated[float | None, "largest error over vertices and samples; inf if the run diverged"]


@dataclass(frozen=True, kw_only=True)
class StabilityRow:
    """One cell of a map: one contestant at one value of the scene's parameter and one step."""

    scene: SceneName
    engine: Engine
    method: Method
    dt_s: Annotated[float, "step"]
    parameter: Parameter
    value: Annotated[float, "value of the parameter"]
    status: Status
    why: Why
    verdict: Word
    max_error_m: Worst
    energy_ratio: Ratio
    resolution_m: Limit


@dataclass(frozen=True, kw_only=True)
class LimitRow:
    """The largest stable and accurate steps of one contestant in one scene, at the scene's own parameter value."""

    scene: SceneName
    engine: Engine
    method: Method
    parameter: Parameter
    value: Annotated[float, "value of the parameter in the scene"]
    w_rad_s: Annotated[float, "w: largest |eigenvalue| of the scene, linearised at the start"]
    w_dt_limit: Annotated[
        float | None,
        "largest w dt at which the energy stays bounded: 0 if it grows at every step, inf if at none that was tried; "
        "empty if the method chooses its own steps",
    ]
    beyond: Annotated[str, "verdict beyond w_dt_limit"]
    theory_w_dt: Annotated[
        float | None,
        "largest w dt at which the energy stays bounded by theory: 0 and inf as in w_dt_limit; empty if unknown",
    ]
    theory: Annotated[str, "source of theory_w_dt"]
    dt_stable_s: Annotated[float | None, "largest stable step; empty if none is"]
    dt_1pct_s: Annotated[
        float | None, "largest step with errors within 1 % of the largest true vertex displacement; empty if none is"
    ]
    dt_1mm_s: Annotated[float | None, "largest step with errors within 1 mm; empty if none is"]
    note: Annotated[str, "remark; empty if none"]


@dataclass(frozen=True, kw_only=True)
class ExtremeRow:
    """One contestant in one extreme case."""

    scene: SceneName
    title: Annotated[str, "title of the case"]
    engine: Engine
    method: Method
    dt_s: Annotated[float, "step"]
    steps: Annotated[int | None, "steps of the whole run; empty if there is none"] = None
    status: Status
    verdict: Word
    max_error_m: Worst = None
    resolution_m: Limit = None
    error_over_resolution: Annotated[
        float | None, "largest ratio, over the samples, of error to resolution of the reference"
    ] = None
    energy_ratio: Ratio = None
    why: Annotated[str, "reasons of status and verdict"]
    size_m: Annotated[float, "largest distance of a vertex from the centre of mass"]


CELLS = Table("stability.csv", StabilityRow, (*CONTESTANT, "value", "dt_s"))
LIMITS = Table("limits.csv", LimitRow, CONTESTANT)
EXTREMES = Table("extremes.csv", ExtremeRow, CONTESTANT)
TABLES = (CELLS, LIMITS, EXTREMES)
