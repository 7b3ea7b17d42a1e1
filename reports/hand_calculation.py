"""Table 4.1 of the CE1051A report, explained: what was printed, what is true, what each mistake costs."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup

from compare.comparison.table_4_1 import BudgetRow, PublishedRow
from compare.engines.handcalc import MENDED
from reports import die
from reports.numerals import counted, fixed, given, listed
from reports.rows import Tables, contestant
from scenarios.frames import Array
from scenarios.published import VERTEX

HAND, AS_PRINTED, ALL_MENDED, EXACT = "handcalc", "as-printed", "all-mended", "exact"
# One column is called right where the exact motion is so many times nearer to it than to the other.
NEARER = 10.0

MISTAKES = {
    "impulse": "the impulse of 5 N s was treated as a constant force of 5 N: A t²/2 stands where J t/m belongs",
    "vertex": "the vertex was not taken from the centre of mass, so the cube turns about the world's origin",
    "clock": "the time was read off the screen, and physics moves in steps of 0.02 s, behind that clock",
}


@dataclass(frozen=True)
class PrintedLine:
    """One row of Table 4.1 as printed, and beside it what eq. 4.1 and the exact motion give."""

    clock: str
    calculated: str
    application: str
    error: str
    error_length: str
    reproduced: str
    physics_time: str
    exact: str
    exact_to_application: str


@dataclass(frozen=True)
class Bar:
    """One method of the hand calculation: what is mended in it, and how far it is from the application [m]."""

    mended: str
    distance: str
    share: float


@dataclass(frozen=True)
class HandCalculation:
    """The section; what has nothing to show is empty."""

    scene: str
    verdict: str
    sentences: list[str]
    lines: list[PrintedLine]
    bars: list[Bar]
    mistakes: dict[str, str]
    pictures: list[die.Picture]
    by_hand: bool
    exact: bool


def section(tables: Tables) -> HandCalculation | None:
    """Return the section, or None where Table 4.1's throw is not among the scenes."""
    if not tables.published:
        return None
    scene = tables.published[0].scene
    published = [row for row in tables.published if row.scene == scene]
    budget = {(row.engine, row.method): row for row in tables.budget if row.scene == scene}
    bars = error_budget(budget)
    return HandCalculation(
        scene,
        verdict(exact(tables)),
        sentences(budget),
        printed_lines(published),
        bars,
        MISTAKES if bars else {},
        cubes(tables, scene, published),
        by_hand=(HAND, AS_PRINTED) in budget,
        exact=(EXACT, "") in budget,
    )


def exact(tables: Tables) -> BudgetRow | None:
    """Return the exact motion's distances from the two columns, or None where there are none."""
    return next((row for row in tables.budget if row.engine == EXACT), None)


def verdict(exact: BudgetRow | None) -> str:
    """Return which printed column the exact motion bears out."""
    if exact is None:
        return ""
    to_application, to_calculated = exact.max_to_application_m, exact.max_to_calculated_m
    if to_application * NEARER < to_calculated:
        who = "The report's Unity application was right and its hand calculation was not"
    elif to_calculated * NEARER < to_application:
        who = "The report's hand calculation was right and its Unity application was not"
    else:
        who = "The exact motion bears out neither column of the report's table"
    return (
        f"{who}: exact rigid-body motion stays within {fixed(to_application, 3)} m of the application's positions "
        f"and comes as far as {fixed(to_calculated, 3)} m from the calculated ones."
    )


def sentences(budget: dict[tuple[str, str], BudgetRow]) -> list[str]:
    """Return what else the distances say."""
    said = []
    printed = budget.get((HAND, AS_PRINTED))
    if printed:
        said.append(
            "Eq. 4.1 with the report's mistakes in it gives its calculated column to "
            f"{fixed(printed.max_to_calculated_m, 3)} m; two decimals are printed."
        )
    engines = sorted(
        (row for (engine, _), row in budget.items() if engine not in (HAND, EXACT)),
        key=lambda row: row.max_to_application_m,
    )
    if engines:
        nearest, furthest = engines[0], engines[-1]
        said.append(
            f"{counted(len(engines), 'contestant')} of engines come within "
            f"{fixed(nearest.max_to_application_m, 3)} m ({contestant(nearest)}) "
            f"to {fixed(furthest.max_to_application_m, 3)} m ({contestant(furthest)}) of the application's column."
        )
    mended = budget.get((HAND, ALL_MENDED))
    single = [budget[HAND, method] for method, some in MENDED.items() if len(some) == 1 and (HAND, method) in budget]
    if printed and mended and single:
        said.append(
            f"As printed it is up to {fixed(printed.max_to_application_m, 3)} m from the application's column; "
            f"no single correction brings it under {fixed(min(row.max_to_application_m for row in single), 3)} m, "
            f"all three together leave {fixed(mended.max_to_application_m, 3)} m."
        )
    return said


def printed_lines(published: Sequence[PublishedRow]) -> list[PrintedLine]:
    """Return the rows of the table."""
    by_hand = {row.t_clock_s: row for row in published if (row.engine, row.method) == (HAND, AS_PRINTED)}
    exact = {row.t_clock_s: row for row in published if row.engine == EXACT}
    lines = []
    for clock, row in {row.t_clock_s: row for row in published}.items():
        hand, true = by_hand.get(clock), exact.get(clock)
        error = application(row) - calculated(row)
        lines.append(
            PrintedLine(
                given(clock),
                vector(calculated(row)),
                vector(application(row)),
                vector(error),
                fixed(float(np.linalg.norm(error)), 3),
                fixed(hand.to_calculated_m, 3) if hand else "",
                fixed(row.t_s, 2),
                vector(position(true)) if true else "",
                fixed(true.to_application_m, 3) if true else "",
            )
        )
    return lines


def error_budget(budget: dict[tuple[str, str], BudgetRow]) -> list[Bar]:
    """Return one bar a method of the hand calculation."""
    own = {method: budget[HAND, method].max_to_application_m for method in MENDED if (HAND, method) in budget}
    return [
        Bar(
            f"{listed([mistake for mistake in MISTAKES if mistake in MENDED[method]])} mended"
            if MENDED[method]
            else "as printed",
            fixed(distance, 3),
            distance / max(own.values()),
        )
        for method, distance in own.items()
    ]


def cubes(tables: Tables, scene: str, published: Sequence[PublishedRow]) -> list[die.Picture]:
    """Return the cube at the five times (Figure 4.2), with the vertex where it is, and where the two columns put it."""
    drawn = tables.true_boxes(scene)
    if not drawn:
        return []
    by_hand = {row.t_s: position(row) for row in published if (row.engine, row.method) == (HAND, AS_PRINTED)}
    shown = {row.t_s: application(row) for row in published}
    clock = {row.t_s: row.t_clock_s for row in published}
    size = float(die.edge_lengths(drawn[min(drawn)]).max())
    frame = die.view_box(np.concatenate([*drawn.values(), np.reshape([*by_hand.values()], (-1, 3))]), 0.1 * size)
    pictures = []
    for time, vertices in drawn.items():
        marks = [die.box(vertices)]
        if time in by_hand:
            marks.append(die.line(np.array([vertices[VERTEX], by_hand[time]]), "apart"))
            marks.append(die.dot(by_hand[time], "by-hand", 0.04 * size))
        marks.append(die.dot(vertices[VERTEX], "true", 0.04 * size))
        marks.append(die.dot(shown[time], "application", 0.08 * size))
        pictures.append(die.Picture(f"t = {given(clock[time])} s", frame, Markup("").join(marks)))
    return pictures


def calculated(row: PublishedRow) -> Array:
    """Return the printed calculated position [m], (3,)."""
    return np.array((row.calculated_x_m, row.calculated_y_m, row.calculated_z_m))


def application(row: PublishedRow) -> Array:
    """Return the printed application position [m], (3,)."""
    return np.array((row.application_x_m, row.application_y_m, row.application_z_m))


def position(row: PublishedRow) -> Array:
    """Return the contestant's position [m], (3,)."""
    return np.array((row.x_m, row.y_m, row.z_m))


def vector(values: Array) -> str:
    """Return a position as the report prints it, two decimals."""
    return "(" + ", ".join(fixed(value, 2) for value in values) + ")"
