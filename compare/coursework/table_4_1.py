"""Every contestant beside the two printed columns of Table 4.1."""

from collections.abc import Iterator, Sequence
from typing import Protocol

import numpy as np

from tumble.compare.coursework.schemas import BudgetRow, PublishedRow
from tumble.compare.judge.errors import Run
from tumble.compare.tables.runs import vector_columns
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
    """Return whether a scene can be compared with Table 4.1.

    Parameters
    ----------
    scene : the scene

    Returns
    -------
    True if it has the instants of Table 4.1 and the printed vertex
    """
    return np.array_equal(scene.times, table_4_1().physics_times) and len(scene.body.points) > VERTEX


def positions(answers: Answers) -> Iterator[tuple[str, str, Array]]:
    """Yield engine, method and the printed vertex at the five instants [m], (5, 3): the exact motion first."""
    if answers.truth is not None:
        yield EXACT, "", answers.truth.vertices[-5:, 0, VERTEX]
    for run in answers.runs:
        if run.has_errors and np.isfinite(run.distances).all():
            yield run.engine, run.method, run.flight.vertices[-5:, 0, VERTEX]


def published_rows(answers: Answers) -> Iterator[PublishedRow]:
    """Yield the printed vertex of every contestant beside the printed positions.

    Parameters
    ----------
    answers : scene, reference solution and runs

    Returns
    -------
    five rows per contestant, the exact motion first; none if the scene is not that of Table 4.1
    """
    if not is_table_4_1(answers.scene):
        return
    table = table_4_1()
    for engine, method, points in positions(answers):
        for row, point in enumerate(points):
            calculated, application = table.calculated[row], table.application[row]
            yield PublishedRow(
                scene=answers.scene.name,
                engine=engine,
                method=method,
                t_clock_s=float(table.clock[row]),
                t_s=float(table.physics_times[row]),
                **vector_columns(point, "x_m", "y_m", "z_m"),
                **vector_columns(calculated, "calculated_x_m", "calculated_y_m", "calculated_z_m"),
                **vector_columns(application, "application_x_m", "application_y_m", "application_z_m"),
                to_calculated_m=float(np.linalg.norm(point - calculated)),
                to_application_m=float(np.linalg.norm(point - application)),
            )


def budget_rows(published: Sequence[PublishedRow]) -> Iterator[BudgetRow]:
    """Yield the largest distance of each contestant from each printed column.

    Parameters
    ----------
    published : rows of `published_rows`

    Returns
    -------
    one row per contestant
    """
    own: dict[tuple[str, str, str], list[PublishedRow]] = {}
    for row in published:
        own.setdefault((row.scene, row.engine, row.method), []).append(row)
    for (scene, engine, method), rows in own.items():
        yield BudgetRow(
            scene=scene,
            engine=engine,
            method=method,
            max_to_calculated_m=max(row.to_calculated_m for row in rows),
            max_to_application_m=max(row.to_application_m for row in rows),
        )
