"""Table 4.1 explained: how far every contestant is from the two printed columns, and what each mended mistake buys."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from typing import Annotated

import numpy as np

from tumble.compare.comparison.against_truth import Comparison
from tumble.compare.tables.runs import vector_columns
from tumble.compare.tables.shared import CONTESTANT, Engine, Method, SceneName
from tumble.scenarios.frames import Array
from tumble.scenarios.published import VERTEX, table_4_1
from tumble.scenarios.scene import Scene


@dataclass(frozen=True, kw_only=True)
class PublishedRow:
    """One contestant at one row of Table 4.1: its vertex, the printed positions, and its distance from them."""

    scene: SceneName
    engine: Engine
    method: Method
    t_clock_s: Annotated[float, "time on the clock of the printed table"]
    t_s: Annotated[float, "time since the impulse"]
    x_m: Annotated[float, "x of the printed vertex in the run, world axes"]
    y_m: Annotated[float, "y of the printed vertex in the run, world axes"]
    z_m: Annotated[float, "z of the printed vertex in the run, world axes"]
    calculated_x_m: Annotated[float, "x printed as calculated"]
    calculated_y_m: Annotated[float, "y printed as calculated"]
    calculated_z_m: Annotated[float, "z printed as calculated"]
    application_x_m: Annotated[float, "x printed as of the application"]
    application_y_m: Annotated[float, "y printed as of the application"]
    application_z_m: Annotated[float, "z printed as of the application"]
    to_calculated_m: Annotated[float, "distance from the position printed as calculated"]
    to_application_m: Annotated[float, "distance from the position printed as of the application"]


@dataclass(frozen=True, kw_only=True)
class BudgetRow:
    """The largest distances of one contestant from the two printed columns over the five rows."""

    scene: SceneName
    engine: Engine
    method: Method
    max_to_calculated_m: Annotated[float, "largest distance from the column printed as calculated"]
    max_to_application_m: Annotated[float, "largest distance from the column printed as of the application"]


def is_table_4_1(scene: Scene) -> bool:
    """Whether the scene is looked at where Table 4.1 is, so that its rows can be held against the printed ones."""
    return np.array_equal(scene.times, table_4_1().physics_times) and len(scene.body.points) > VERTEX


def flown(comparison: Comparison) -> Iterator[tuple[str, str, Array]]:
    """Yield engine, method and the printed vertex at the five instants [m], (5, 3): the exact motion first."""
    if comparison.truth is not None:
        yield "exact", "", comparison.truth.vertices[-5:, 0, VERTEX]
    for run in comparison.runs:
        if run.has_errors and np.isfinite(run.distances).all():
            yield run.engine, run.method, run.flight.vertices[-5:, 0, VERTEX]


def published_rows(comparison: Comparison) -> Iterator[PublishedRow]:
    """Yield five rows a contestant."""
    table = table_4_1()
    for engine, method, positions in flown(comparison):
        for row, position in enumerate(positions):
            calculated, application = table.calculated[row], table.application[row]
            yield PublishedRow(
                scene=comparison.scene.name,
                engine=engine,
                method=method,
                t_clock_s=float(table.clock[row]),
                t_s=float(table.physics_times[row]),
                **vector_columns(position, "x_m", "y_m", "z_m"),
                **vector_columns(calculated, "calculated_x_m", "calculated_y_m", "calculated_z_m"),
                **vector_columns(application, "application_x_m", "application_y_m", "application_z_m"),
                to_calculated_m=float(np.linalg.norm(position - calculated)),
                to_application_m=float(np.linalg.norm(position - application)),
            )


def budget_rows(published: Sequence[PublishedRow]) -> Iterator[BudgetRow]:
    """Yield one row a contestant: the pivot of its five, at their largest."""
    if not published:
        return
    import pandas as pd  # what has no Table 4.1 has no use for it

    table = pd.DataFrame(published, columns=[field.name for field in fields(PublishedRow)])
    distances = ["to_calculated_m", "to_application_m"]
    largest = table.pivot_table(distances, list(CONTESTANT), aggfunc="max", sort=False)[distances]
    for scene, engine, method, calculated, application in largest.reset_index().itertuples(index=False, name=None):
        yield BudgetRow(
            scene=scene,
            engine=engine,
            method=method,
            max_to_calculated_m=calculated,
            max_to_application_m=application,
        )
