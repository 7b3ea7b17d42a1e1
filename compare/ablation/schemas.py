"""The table of an ablation: one line a column."""

from dataclasses import dataclass
from typing import Annotated

from tumble.compare.tables.schema import Table
from tumble.compare.tables.shared import CONTESTANT, Engine, Method, SceneName

EVERYTHING = "everything"
# A rigid plane so far below that the body never comes near it: no option of an engine, but a part of the scene.
PLANE = "plane"


@dataclass(frozen=True, kw_only=True)
class AblationRow:
    """The cost of a feature for a contestant, in a scene that does not need it."""

    scene: SceneName
    engine: Engine
    method: Method
    feature: Annotated[
        str,
        f"feature that was left on, `{EVERYTHING}`, or `{PLANE}`: one far below, which the body never touches; empty "
        "if the engine has none",
    ]
    why: Annotated[str, "why figures are missing; empty if they are there"] = ""
    cpu_ns_per_step_with: Annotated[float | None, "CPU time per step with the feature on"] = None
    cpu_ns_per_step_without: Annotated[float | None, "CPU time per step with every unneeded feature off"] = None
    ratio: Annotated[float | None, "time with over time without, sampled in the same rounds"] = None
    ratio_low: Annotated[float | None, "lower end of the 95 % confidence interval of the ratio"] = None
    ratio_high: Annotated[float | None, "upper end of the 95 % confidence interval of the ratio"] = None
    max_difference_m: Annotated[
        float | None, "largest distance between the vertices of both runs; 0 if they are identical"
    ] = None


ABLATION = Table("ablation.csv", AblationRow, (*CONTESTANT, "feature"))
TABLES = (ABLATION,)
