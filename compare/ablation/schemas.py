"""The table of an ablation: one line a column."""

from dataclasses import dataclass
from typing import Annotated

from tumble.compare.tables.schema import Table
from tumble.compare.tables.shared import CONTESTANT, Engine, Method, SceneName

EVERYTHING = "everything"


@dataclass(frozen=True, kw_only=True)
class AblationRow:
    """What a feature costs a contestant in a scene that has no use for it."""

    scene: SceneName
    engine: Engine
    method: Method
    feature: Annotated[str, "one that was kept, or `everything` at once; empty where there is none"]
    why: Annotated[str, "why figures are missing"] = ""
    cpu_ns_per_step_with: Annotated[float | None, "time of a step with it"] = None
    cpu_ns_per_step_without: Annotated[float | None, "and of one without"] = None
    ratio: Annotated[float | None, "with over without, of the same rounds"] = None
    ratio_low: Annotated[float | None, "lower end of the 95 % confidence interval of the ratio"] = None
    ratio_high: Annotated[float | None, "upper end of the 95 % confidence interval of the ratio"] = None
    max_difference_m: Annotated[float | None, "between the vertices of both flights, 0 where no bit differs"] = None


ABLATION = Table("ablation.csv", AblationRow, (*CONTESTANT, "feature"))
TABLES = (ABLATION,)
