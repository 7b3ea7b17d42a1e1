"""The tables of the coursework study: one line a column."""

from dataclasses import dataclass
from typing import Annotated

from tumble.compare.tables.schema import Table
from tumble.compare.tables.shared import CONTESTANT, Engine, Method, SceneName


@dataclass(frozen=True, kw_only=True)
class PublishedRow:
    """One contestant at one row of Table 4.1: its vertex, the printed positions, and the distances to them."""

    scene: SceneName
    engine: Engine
    method: Method
    t_clock_s: Annotated[float, "time on the clock of the printed table"]
    t_s: Annotated[float, "time since the impulse"]
    x_m: Annotated[float, "x of the printed vertex in the run, world axes"]
    y_m: Annotated[float, "y of the printed vertex in the run, world axes"]
    z_m: Annotated[float, "z of the printed vertex in the run, world axes"]
    calculated_x_m: Annotated[float, "x of the vertex in the printed column `calculated`"]
    calculated_y_m: Annotated[float, "y of the vertex in the printed column `calculated`"]
    calculated_z_m: Annotated[float, "z of the vertex in the printed column `calculated`"]
    application_x_m: Annotated[float, "x of the vertex in the printed column `application`"]
    application_y_m: Annotated[float, "y of the vertex in the printed column `application`"]
    application_z_m: Annotated[float, "z of the vertex in the printed column `application`"]
    to_calculated_m: Annotated[float, "distance of the vertex from the printed column `calculated`"]
    to_application_m: Annotated[float, "distance of the vertex from the printed column `application`"]


@dataclass(frozen=True, kw_only=True)
class BudgetRow:
    """The largest distance of one contestant from each printed column, over the five rows of Table 4.1."""

    scene: SceneName
    engine: Engine
    method: Method
    max_to_calculated_m: Annotated[float, "largest distance of the vertex from the printed column `calculated`"]
    max_to_application_m: Annotated[float, "largest distance of the vertex from the printed column `application`"]


PUBLISHED = Table("table-4-1.csv", PublishedRow, (*CONTESTANT, "t_s"))
BUDGET = Table("table-4-1-budget.csv", BudgetRow, CONTESTANT)
TABLES = (PUBLISHED, BUDGET)
