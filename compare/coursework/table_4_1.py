"""Every contestant beside the two printed columns of Table 4.1."""

from collections.abc import Iterator, Sequence
from typing import Protocol

import numpy as np

from tumble.compare.coursework.schemas import BudgetRow, PublishedRow
from tumble.compare.judge.errors import Run
from tumble.compare.tables.runs import xyz
from tumble.scenarios.frames import Array
from tumble.scenarios.published import VERTEX, table_4_1
from tumble.scenarios.scene import Scene
from tumble.scenarios.truth import Truth

EXACT = "exact"  # stands for the engine in the rows of the reference solution


class Answers(Protocol):
    """A scene, its reference solution, and the runs of all contestants."""

    @property
    def scene(self) -> Scene:
        """The scene."""
        ...

    @property
    def truth(self) -> Truth | None:
        """The reference solution; None if there is none."""
        ...

    @property
    def runs(self) -> Sequence[Run]:
        """The runs."""
        ...


def is_table_4_1(scene: Scene) -> bool:
    """Whether the scene has the instants of Table 4.1 and the printed vertex, so that its rows can be compared."""
    return np.array_equal(scene.times, table_4_1().physics_times) and len(scene.body.points) > VERTEX


def positions(answers: Answers) -> Iterator[tuple[str, str, Array]]:
    """Yield engine, method and the printed vertex at the five instants [m], (5, 3): the exact motion first."""
    if answers.truth is not None:
        yield EXACT, "", answers.truth.vertices[-5:, 0, VERTEX]
    for run in answers.runs:
        if run.has_errors and np.isfinite(run.distances).all():
            yield run.engine, run.method, run.flight.vertices[-5:, 0, VERTEX]


def published_rows(answers: Answers) -> Iterator[PublishedRow]:
    """Yield five rows a contestant; none if the scene is not that of Table 4.1."""
    if not is_table_4_1(answers.scene):
        return
    table = table_4_1()
    for engine, method, points in positions(answers):
        for row, point in enumerate(points):
            yield PublishedRow(
                answers.scene.name,
                engine,
                method,
                float(table.clock[row]),
                float(table.physics_times[row]),
                *xyz(point),
                *xyz(table.calculated[row]),
                *xyz(table.application[row]),
                float(np.linalg.norm(point - table.calculated[row])),
                float(np.linalg.norm(point - table.application[row])),
            )


def budget_rows(published: Sequence[PublishedRow]) -> Iterator[BudgetRow]:
    """Yield one row a contestant: the largest distance from each column over its five rows."""
    own: dict[tuple[str, str, str], list[PublishedRow]] = {}
    for row in published:
        own.setdefault((row.scene, row.engine, row.method), []).append(row)
    for contestant, rows in own.items():
        calculated, application = (
            max(getattr(row, column) for row in rows) for column in ("to_calculated_m", "to_application_m")
        )
        yield BudgetRow(*contestant, calculated, application)
