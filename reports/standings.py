"""One scene's section: what it asks, who is how far off, and the curves; who did not fly is a row with a reason."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from compare.comparison.results import SceneRow
from compare.tables.rows import RunRow, VertexErrorRow
from reports import families
from reports.charts import Chart, Stroke, chart, striped
from reports.numerals import at_most, figure, given, listed
from reports.rows import Tables, contestant

VERTEX_COLUMNS = 8

# Title and unit of each column of figures, by the field of the run it shows.
COLUMNS = {
    "max_error_m": ("max error", "m"),
    "rms_error_m": ("rms error", "m"),
    "final_error_m": ("final error", "m"),
    "energy_drift": ("energy drift", "relative"),
    "momentum_drift": ("momentum drift", "relative"),
    "angular_momentum_drift": ("angular momentum drift", "relative"),
    "wall_ns_per_step": ("time per step (one pass, rough)", "ns"),
}
IN_METRES = {"max_error_m", "rms_error_m", "final_error_m"}


@dataclass(frozen=True)
class Line:
    """One line of the error table: a contestant, or methods of one engine that did not fly and share the reason."""

    contestant: str
    stands_for: list[str]
    kind: str
    status: str
    figures: list[str]


@dataclass(frozen=True)
class LegendGroup:
    """Contestants whose curves are one, with why, or all others."""

    caption: str
    strokes: dict[str, Stroke]


@dataclass(frozen=True)
class VertexTable:
    """Each contestant's error at each vertex shown, at the last sample."""

    time: str
    vertices: list[int]
    all_shown: bool
    lines: list[tuple[str, list[str]]]


@dataclass(frozen=True)
class SceneSection:
    """Everything one scene's section says; what has nothing to show is empty or None."""

    row: SceneRow
    facts: list[tuple[str, str]]
    verdict: str
    columns: list[tuple[str, str]]
    lines: list[Line]
    chart: Chart | None
    legend: list[LegendGroup]
    vertices: VertexTable | None


def section(tables: Tables, scene: SceneRow, colours: dict[str, str]) -> SceneSection:
    """Return one scene's section."""
    runs = sorted((run for run in tables.runs if run.scene == scene.scene), key=best_first)
    legend = legend_groups(runs, families.of_one_scene(tables.agreements, scene.scene), colours)
    strokes = {name: stroke for group in legend for name, stroke in group.strokes.items()}
    shown = [field for field in COLUMNS if any(is_said(field, getattr(run, field)) for run in runs)]
    return SceneSection(
        scene,
        facts(scene, runs),
        verdict(runs),
        [COLUMNS[field] for field in shown],
        lines(runs, shown),
        chart([row for row in tables.errors_over_time if row.scene == scene.scene], strokes),
        legend,
        vertex_table(tables, scene.scene, runs),
    )


def is_said(field: str, value: float | None) -> bool:
    """Whether a figure says anything: a drift of 0, as of a momentum that is not there, says nothing."""
    return bool(value) if field.endswith("drift") else value is not None


def best_first(run: RunRow) -> tuple[int, float, str]:
    """Return what orders the runs: errors ascending, then those that are not finite, then those that have none."""
    error = run.max_error_m
    if error is None:
        return 2, 0.0, contestant(run)
    return (0, error, contestant(run)) if math.isfinite(error) else (1, 0.0, contestant(run))


def kind(run: RunRow) -> str:
    """Return the first word of a status: ok, flagged, diverged, skipped, missing, crashed, timeout."""
    return run.status.partition(":")[0].split()[0]


def within_limit(run: RunRow) -> bool:
    """Whether the run is ok and no error of it says more than the truth's own limit."""
    return run.status == "ok" and run.max_error_m is not None and run.max_error_m <= (run.limit_m or 0.0)


def facts(scene: SceneRow, runs: Sequence[RunRow]) -> list[tuple[str, str]]:
    """Return what the scene is, as name and value."""
    steps = sorted({run.dt_s for run in runs})
    known = [
        ("source", scene.source),
        ("body", f"{scene.shape}, {scene.vertices} vertices"),
        ("needs", scene.needs or "nothing"),
        ("flight", f"{given(scene.duration_s)} s, looked at {scene.samples} times"),
        ("step", " and ".join(f"{given(step)} s" for step in steps)),
    ]
    if scene.bound_m is None or scene.floor_m is None:
        known.append(("truth", f"none: {scene.truth}"))
    else:
        known.append(("truth", f"{scene.truth}; its own error is at most {figure(scene.bound_m, 2)} m"))
        known.append(("floor", f"{figure(scene.floor_m, 2)} m: what rounding the inputs to double precision moves"))
    return [(name, value) for name, value in known if value]


def verdict(runs: Sequence[RunRow]) -> str:
    """Return who came closest, and how far the furthest is that reports nothing wrong."""
    plain = [run for run in runs if run.status == "ok" and run.max_error_m is not None]
    if not plain:
        return ""
    right = [contestant(run) for run in plain if within_limit(run)]
    best, worst = plain[0], plain[-1]
    if right:
        said = f"{listed(right)} cannot be told from the truth (limit {figure(best.limit_m or 0.0)} m)."
    else:
        how = "comes closest," if len(plain) > 1 else "is off by"
        said = f"{contestant(best)} {how} {figure(best.max_error_m or 0.0)} m at most."
    if worst is not best and not within_limit(worst):
        said += f" {contestant(worst)} reports nothing wrong and is up to {figure(worst.max_error_m or 0.0)} m off."
    return said


def lines(runs: Sequence[RunRow], shown: Sequence[str]) -> list[Line]:
    """Return the lines of the error table; methods of one engine that did not fly for one reason share a line."""
    folded: dict[tuple[str, ...], list[RunRow]] = {}
    for run in runs:
        key = (run.engine, run.status) if run.steps is None else (run.engine, run.status, run.method)
        folded.setdefault(key, []).append(run)
    return [line(own, shown) for own in folded.values()]


def line(runs: Sequence[RunRow], shown: Sequence[str]) -> Line:
    """Return one line for runs that have all to say in common."""
    first = runs[0]
    return Line(
        contestant(first) if len(runs) == 1 else f"{first.engine}: {len(runs)} methods",
        [run.method for run in runs] if len(runs) > 1 else [],
        kind(first),
        first.status,
        [] if first.steps is None else [cell(first, field) for field in shown],
    )


def cell(run: RunRow, field: str) -> str:
    """Return a figure of a run as people read it; an error below the limit is shown as that limit."""
    value = getattr(run, field)
    if value is None:
        return ""
    if field in IN_METRES:
        return at_most(run.limit_m) if run.limit_m and value <= run.limit_m else figure(value)
    return (
        f"{value:,.0f}".replace(",", "\N{NARROW NO-BREAK SPACE}") if field == "wall_ns_per_step" else figure(value, 2)
    )


def legend_groups(
    runs: Sequence[RunRow], groups: Sequence[tuple[str, ...]], colours: dict[str, str]
) -> list[LegendGroup]:
    """Return who is drawn: those within the limit, each family that paints one line, all others."""
    drawn = {contestant(run): run for run in runs if run.max_error_m is not None}
    right = [name for name, run in drawn.items() if within_limit(run)]
    families_drawn = [[name for name in drawn if name in group] for group in groups]
    alone = [name for name in drawn if not any(name in group for group in (right, *families_drawn))]

    def group(caption: str, names: list[str], one_line: bool) -> LegendGroup:
        size = len(names) if one_line else 1
        return LegendGroup(
            caption,
            {
                name: Stroke(colours[name], striped(place if one_line else 0, size), kind(drawn[name]))
                for place, name in enumerate(names)
            },
        )

    made = [group("within the truth's limit", right, one_line=True)]
    made += [group("one curve, striped", names, one_line=True) for names in families_drawn]
    made.append(group("", alone, one_line=False))
    return [each for each in made if each.strokes]


def vertex_table(tables: Tables, scene: str, runs: Sequence[RunRow]) -> VertexTable | None:
    """Return the errors at the last sample by vertex, the furthest vertices where there are too many to show."""
    times = [row.t_s for row in tables.errors_over_time if row.scene == scene]
    if not times:
        return None
    last = max(times)
    worst: dict[str, dict[int, VertexErrorRow]] = {}
    for row in tables.vertex_errors(scene, lambda cells: float(cells["t_s"]) == last):
        own = worst.setdefault(contestant(row), {})
        if row.vertex not in own or not row.error_m <= own[row.vertex].error_m:
            own[row.vertex] = row
    finite = np.nan_to_num([[own[vertex].error_m for vertex in sorted(own)] for own in worst.values()], posinf=0.0)
    furthest = np.argsort(-finite.max(axis=0), kind="stable")[:VERTEX_COLUMNS]
    limit = {contestant(run): run.limit_m or 0.0 for run in runs}
    shown = sorted(int(vertex) for vertex in furthest)
    names = [contestant(run) for run in runs if contestant(run) in worst]
    return VertexTable(
        given(last),
        shown,
        len(shown) == finite.shape[1],
        [
            (
                name,
                [
                    at_most(limit[name], 2) if error <= limit[name] else figure(error, 2)
                    for error in (worst[name][vertex].error_m for vertex in shown)
                ],
            )
            for name in names
        ],
    )
