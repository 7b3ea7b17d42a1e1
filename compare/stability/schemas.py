"""The tables of maps of stability and of the extreme cases: one line a column."""

from dataclasses import dataclass
from typing import Annotated

from tumble.compare.tables.schema import Table
from tumble.compare.tables.shared import CONTESTANT, Engine, Limit, Method, SceneName, Status, Why

Parameter = Annotated[str, "the number that makes the scene stiff, with its unit"]
Word = Annotated[str, "what became of the flight, as `tumble stability` says it"]
Ratio = Annotated[float | None, "energy at the end over what physics leaves there; empty where there is no flight"]
Worst = Annotated[float | None, "largest vertex error; inf of a flight that diverged"]


@dataclass(frozen=True, kw_only=True)
class StabilityRow:
    """One cell of a map: one contestant at one value of the scene's number and one step."""

    scene: SceneName
    engine: Engine
    method: Method
    dt_s: Annotated[float, "step"]
    parameter: Parameter
    value: Annotated[float, "value of that number"]
    status: Status
    why: Why
    verdict: Word
    max_error_m: Worst
    energy_ratio: Ratio
    resolution_m: Limit


@dataclass(frozen=True, kw_only=True)
class LimitRow:
    """How long a step one contestant bears in one scene, at the scene's own value."""

    scene: SceneName
    engine: Engine
    method: Method
    parameter: Parameter
    value: Annotated[float, "value of that number in the scene"]
    w_rad_s: Annotated[float, "largest |eigenvalue| at the start"]
    w_dt_limit: Annotated[
        float | None,
        "w dt up to which no energy grows without end: 0 where it does at every step, inf where at none that was "
        "tried, empty where the step is not ours",
    ]
    beyond: Annotated[str, "what comes beyond it"]
    theory_w_dt: Annotated[
        float | None,
        "w dt up to which theory has no energy grow: 0 and inf as in w_dt_limit; empty where no theory is known",
    ]
    theory: Annotated[str, "where that is from"]
    dt_stable_s: Annotated[float | None, "largest step that is stable; empty where none is"]
    dt_1pct_s: Annotated[float | None, "largest step within 1 % of how far a vertex truly gets; empty where none is"]
    dt_1mm_s: Annotated[float | None, "largest step within 1 mm; empty where none is"]
    note: Annotated[str, "what no number says"]


@dataclass(frozen=True, kw_only=True)
class ExtremeRow:
    """One contestant in one extreme case."""

    scene: SceneName
    title: Annotated[str, "title of the case"]
    engine: Engine
    method: Method
    dt_s: Annotated[float, "step"]
    steps: Annotated[int | None, "steps of the whole flight; empty where there is none"] = None
    status: Status
    verdict: Word
    max_error_m: Worst = None
    resolution_m: Limit = None
    error_over_resolution: Annotated[
        float | None, "largest error over samples, in units of what the truth can tell there"
    ] = None
    energy_ratio: Ratio = None
    why: Annotated[str, "the reasons of status and verdict"]
    size_m: Annotated[float, "distance from the centre of mass of the body's furthest vertex"]

    @property
    def key(self) -> tuple[str, str, str]:
        """Scene, engine, method."""
        return self.scene, self.engine, self.method


CELLS = Table("stability.csv", StabilityRow, (*CONTESTANT, "value", "dt_s"))
LIMITS = Table("limits.csv", LimitRow, CONTESTANT)
EXTREMES = Table("extremes.csv", ExtremeRow, CONTESTANT)
TABLES = (CELLS, LIMITS, EXTREMES)
