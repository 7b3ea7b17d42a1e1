"""The tables read back as the rows they were written from: all that a page knows."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from compare.ablation.ablation import AblationRow
from compare.comparison.results import EngineRow, ErrorOverTimeRow, SceneRow
from compare.comparison.table_4_1 import BudgetRow, PublishedRow
from compare.judge.agreement import AgreementRow
from compare.run.provenance import ConditionRow
from compare.stability.extremes import ExtremeRow
from compare.stability.schemas import LimitRow, StabilityRow
from compare.sweep.frontier import ClockRow, DigitRow, OrderRow, SameRow, ThrowsRow
from compare.tables.rows import Cells, Row, RunRow, VertexErrorRow, cells, typed
from reports.numerals import figure
from scenarios.frames import Array


@dataclass(frozen=True)
class Tables:
    """The tables of one comparison, file name -> CSV text, as compare.comparison.results.tables gives them.

    Those of a sweep, as sweep_tables there gives them, have sweep- before their names, and may be absent.
    """

    texts: Mapping[str, str]

    def table(self, row_type: type[Row], name: str) -> list[Row]:
        """Return one table whole."""
        return list(typed(row_type, cells(self.texts[name])))

    def sweep_table(self, row_type: type[Row], name: str) -> list[Row]:
        """Return one table of the sweep whole, nothing where there was none."""
        return self.table(row_type, f"sweep-{name}") if f"sweep-{name}" in self.texts else []

    @cached_property
    def scenes(self) -> list[SceneRow]:
        """One row a scene."""
        return self.table(SceneRow, "scenes.csv")

    @cached_property
    def engines(self) -> list[EngineRow]:
        """One row an engine."""
        return self.table(EngineRow, "engines.csv")

    @cached_property
    def runs(self) -> list[RunRow]:
        """One row a run."""
        return self.table(RunRow, "runs.csv")

    @cached_property
    def errors_over_time(self) -> list[ErrorOverTimeRow]:
        """One row a run and sample."""
        return self.table(ErrorOverTimeRow, "error-over-time.csv")

    @cached_property
    def agreements(self) -> list[AgreementRow]:
        """One row a pair that agrees better than it is right."""
        return self.table(AgreementRow, "agreement.csv")

    @cached_property
    def published(self) -> list[PublishedRow]:
        """Five rows a contestant, beside Table 4.1."""
        return self.table(PublishedRow, "table-4-1.csv")

    @cached_property
    def budget(self) -> list[BudgetRow]:
        """One row a contestant: its largest distances from Table 4.1."""
        return self.table(BudgetRow, "table-4-1-budget.csv")

    @cached_property
    def conditions(self) -> list[ConditionRow]:
        """What it was measured on."""
        return self.table(ConditionRow, "conditions.csv")

    @cached_property
    def ablation(self) -> list[AblationRow]:
        """One row a contestant and feature that it leaves out; nothing where that was not measured."""
        return self.table(AblationRow, "ablation.csv") if "ablation.csv" in self.texts else []

    @cached_property
    def stability_cells(self) -> list[StabilityRow]:
        """One row a cell of a map of stability; nothing where there was none."""
        return self.table(StabilityRow, "stability.csv") if "stability.csv" in self.texts else []

    @cached_property
    def stability_limits(self) -> list[LimitRow]:
        """One row a contestant and scene that was mapped."""
        return self.table(LimitRow, "limits.csv") if "limits.csv" in self.texts else []

    @cached_property
    def extremes(self) -> list[ExtremeRow]:
        """One row a contestant and extreme case."""
        return self.table(ExtremeRow, "extremes.csv") if "extremes.csv" in self.texts else []

    @cached_property
    def sweep_runs(self) -> list[RunRow]:
        """One row a contestant and rung of its ladder; times are the clock's."""
        return self.sweep_table(RunRow, "runs.csv")

    @cached_property
    def sweep_digits(self) -> list[DigitRow]:
        """One row a contestant and error to reach."""
        return self.sweep_table(DigitRow, "digits.csv")

    @cached_property
    def sweep_orders(self) -> list[OrderRow]:
        """One row a contestant with fixed steps."""
        return self.sweep_table(OrderRow, "orders.csv")

    @cached_property
    def sweep_throws(self) -> list[ThrowsRow]:
        """One row a plain run of many throws: how its errors spread over them."""
        return self.sweep_table(ThrowsRow, "throws.csv")

    @cached_property
    def sweep_same(self) -> list[SameRow]:
        """One row a pair that is one integrator."""
        return self.sweep_table(SameRow, "same.csv")

    @cached_property
    def sweep_clock(self) -> list[ClockRow]:
        """One row a contestant and tolerance that was timed."""
        return self.sweep_table(ClockRow, "clock.csv")

    @property
    def swept_scenes(self) -> list[str]:
        """The scenes that were swept."""
        return list(dict.fromkeys(run.scene for run in self.sweep_runs))

    @cached_property
    def vertex_cells(self) -> dict[str, list[Cells]]:
        """The rows of vertex-errors.csv by scene, as text: the table is long, and most of it is never drawn."""
        found: dict[str, list[Cells]] = {}
        for row in cells(self.texts["vertex-errors.csv"]):
            found.setdefault(row["scene"], []).append(row)
        return found

    def true_boxes(self, scene: str) -> dict[float, Array]:
        """Return where the vertices of a scene's box truly are at each time [m], (8, 3); nothing for another shape.

        Every run's rows hold the same true positions, so the first run's will do.
        """
        if not any(row.scene == scene and row.shape == "box" for row in self.scenes):
            return {}
        first = self.vertex_cells.get(scene, [{}])[0]
        return poses(self.flown(scene, first.get("engine", ""), first.get("method", "")), true=True)

    def flown(self, scene: str, engine: str, method: str) -> list[VertexErrorRow]:
        """Return the rows of one run."""
        return self.vertex_errors(scene, lambda row: (row["engine"], row["method"]) == (engine, method))

    def vertex_errors(self, scene: str, wanted: Callable[[Cells], bool]) -> list[VertexErrorRow]:
        """Return the wanted rows of one scene, vertex by vertex."""
        return list(typed(VertexErrorRow, filter(wanted, self.vertex_cells.get(scene, []))))


def poses(rows: Sequence[VertexErrorRow], true: bool) -> dict[float, Array]:
    """Return where the vertices of one run are at each time [m], (n, 3): the true ones, or the run's own.

    Of many throws it is the last.
    """
    found: dict[float, dict[int, tuple[float, float, float]]] = {}
    for row in rows:
        place = (row.true_x_m, row.true_y_m, row.true_z_m) if true else (row.x_m, row.y_m, row.z_m)
        found.setdefault(row.t_s, {})[row.vertex] = place
    return {time: np.array([places[vertex] for vertex in sorted(places)]) for time, places in found.items()}


def contestant(row: Any) -> str:
    """Return ENGINE:METHOD of any row that has both."""
    return named(row.engine, row.method)


def untuned(row: Any) -> str:
    """Return ENGINE:METHOD without the tolerance of an adaptive method."""
    return named(row.engine, row.method.partition("@")[0])


def named(engine: str, method: str) -> str:
    """Return ENGINE:METHOD, or ENGINE where the method is not known."""
    return f"{engine}:{method}" if method else engine


def error_m(run: RunRow) -> float:
    """Return a run's largest vertex error, not below what the truth can tell [m]."""
    return max(run.max_error_m or 0.0, run.limit_m or 0.0)


def setting(run: RunRow) -> str:
    """Return the step of a run, or the tolerance of an adaptive method's."""
    _, at, tolerance = run.method.partition("@")
    return f"tolerance {tolerance}" if at else f"step {figure(run.dt_s)} s"
