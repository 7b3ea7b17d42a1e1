"""What `tumble compare` prints: the answer in a sentence, who is how far off, then a table as Table 4.1 for each."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from rich.console import RenderableType
from rich.constrain import Constrain
from rich.table import Table
from rich.text import Text

from tumble.compare.comparison.against_truth import Comparison
from tumble.compare.comparison.findings import scene_findings
from tumble.compare.comparison.hints import hints
from tumble.compare.engines import OWN
from tumble.compare.judge.errors import Run
from tumble.compare.tables.runs import run_row
from tumble.compare.tables.shared import FindingRow
from tumble.reports.charts import GOOD, coloured, error_chart
from tumble.reports.coursework import coursework_text, printed_vertex
from tumble.reports.numerals import counted, listed
from tumble.reports.terminal import (
    LIST_WIDTH,
    columns,
    figure,
    length,
    plain,
    reasons_text,
    ruler,
    thinned,
    unit_of,
    vector,
)
from tumble.scenarios.truth import Truth

MOST_SAID = 4  # engines that one sentence can hold


def comparison_text(
    comparison: Comparison, vertex: int | None, everything: bool = False, charts: bool = False
) -> Iterator[RenderableType]:
    """Yield the text: the answer, the ranking, and error tables of each engine's first method, or of all.

    vertex: the one to print, None for where the contestants stray most; charts: whether a chart stands before them.
    """
    scene, truth, runs = comparison.scene, comparison.truth, comparison.runs
    if truth is None:
        yield Constrain(plain(f"{scene.name} has no truth to be held against: {comparison.why_no_truth}"), LIST_WIDTH)
        for hint in hints(scene):
            yield Constrain(plain(f"Look at this: {hint}"), LIST_WIDTH)
    else:
        yield Constrain(plain(answer(comparison)), LIST_WIDTH)
    yield Text()
    if charts:
        yield from error_chart([run_row(run) for run in runs])
    yield from standings(runs, comparison.roles)
    yield from steps_text(runs)
    if truth is not None:
        yield Constrain(plain(f"{scene.title}. {known(truth, comparison.lost_m)}"), LIST_WIDTH)
        for hint in hints(scene) if truth.ends else ():
            yield Constrain(plain(f"Look at this: {hint}"), LIST_WIDTH)
        vertex = printed_vertex(scene) if vertex is None else vertex
        vertex = worst_vertex(runs) if vertex is None else vertex
        shown = [run for run in (runs if everything else first_runs(runs)) if run.has_errors]
        for run in shown:
            yield Text()
            of_throw = f", throw 0 of {len(scene.start)}" if len(scene.start) > 1 else ""
            yield plain(f"{run.name}, {step_of(run)}, vertex {vertex}{of_throw}")
            yield error_table(run, vertex)
        if left := sum(run.has_errors for run in runs) - len(shown):
            yield plain(f"{counted(left, 'more table')} with --all, every vertex with -o DIR")
        if len(scene.start) > 1:
            yield plain("The ranking is over all throws; with -o DIR, members.csv has every throw.")
    yield from coursework_text(comparison)


def known(truth: Truth, lost_m: float) -> str:
    """Return how well the truth is known, where the inputs set it the limit for every program, and what engines lose

    by being handed doubles, where that is more [m].
    """
    until = truth.until_horizon()
    said = f"Truth known to {figure(until.bound.max())} m{truth.ends}."
    # Where the truth is known no better than that, it is the truth and not the inputs that sets the limit.
    if until.floor.max() >= until.bound.max():
        said += f" No double-precision program can be held to less than {figure(until.floor.max())} m."
    if lost_m > until.limit.max():
        said += (
            " Engines are handed moments, axes and points as doubles, and none can make up for that: it alone moves a "
            f"corner by up to {figure(lost_m)} m."
        )
    return said


def first_runs(runs: Sequence[Run]) -> list[Run]:
    """Return the first method of each engine; ours last."""
    first: dict[str, Run] = {}
    for run in runs:
        first.setdefault(run.engine, run)
    return sorted(first.values(), key=lambda run: run.engine == OWN)


def answer(comparison: Comparison) -> str:
    """Return who is how far off, in a person's words: the nearest, and each engine's first method."""
    scene, runs = comparison.scene.name, comparison.runs
    found: dict[str, list[FindingRow]] = {}
    for row in scene_findings([run_row(run) for run in runs], comparison.defaults):
        found.setdefault(row.finding, []).append(row)
    if "nearest" not in found:
        return f"{scene}: nobody flew it to its end; below is why."
    best, worst = found["nearest"][0].contestant, found["furthest"][0]
    parts = [f"{scene}: {best} is nearest to the truth, {off(found['nearest'][0])}."]
    engines = [row for row in found.get("asked for", ()) if row.contestant != best]
    said = engines[:MOST_SAID]
    if engines:
        more = len(engines) - len(said)
        rest = f", {more} more further" if more else ""
        parts.append(f"The engines as asked: {listed([f'{row.contestant} {off(row)}' for row in said])}{rest}.")
    if worst.contestant not in (best, *(row.contestant for row in said)):
        parts.append(f"Worst: {worst.contestant}, {off(worst)}.")
    for finding, words in (("unfinished", "did not finish"), ("unable", "cannot fly it")):
        for row in found.get(finding, ()):
            parts.append(f"{counted(round(row.value or 0), 'contestant')} {words}.")
    return " ".join(parts)


def off(row: FindingRow) -> str:
    """Return how far off somebody is at most, in words."""
    worst, limit = row.value or 0.0, row.resolution or 0.0
    return f"at its limit of {length(limit)}" if worst <= limit else f"{length(worst)} off"


def standings(runs: Sequence[Run], roles: Mapping[str, str]) -> Iterator[RenderableType]:
    """Yield the contestants of one scene that flew, the nearest first, and then why any is not plainly ok."""
    flown = sorted((run for run in runs if run.has_errors), key=lambda run: float(np.nanmax(run.distances)))
    table = columns("contestant", "", "max [m]", "rms [m]", "energy drift", "status", right=range(2, 5))
    for run in flown:
        worst, limit = float(run.distances.max()), float(run.limits.max())
        table.add_row(
            plain(run.name),
            roles.get(run.name, ""),
            Text(f"≤{figure(limit)}", style=GOOD) if worst <= limit else figure(worst),
            figure(float(np.sqrt((run.distances**2).mean()))),
            figure(run.drifts[0]),
            coloured(run.status.partition(":")[0]),
        )
    if flown:
        yield table
    for run in flown:
        if run.flight.remark:
            yield plain(f"{run.name} {run.flight.remark}")
    if any(run.status != "ok" for run in runs):
        yield Text()
        yield from reasons_text((run.name, run.status) for run in runs if run.status != "ok")


def steps_text(runs: Sequence[Run]) -> Iterator[RenderableType]:
    """Yield how long the steps were that were taken, where that is not what was asked for."""
    for dt, taken, steps in dict.fromkeys((run.dt, run.dt_taken, run.flight.steps) for run in runs if run.dt_taken):
        if taken != dt:
            line = f"A step of {dt:g} s does not divide the time between samples and impulses: {steps} steps were taken"
            yield Constrain(plain(f"{line}, of {taken:.4g} s on average."), LIST_WIDTH)


def step_of(run: Run) -> str:
    """Return the step asked for, and the one taken where that is another."""
    cut = run.dt_taken not in (None, run.dt)
    return f"dt = {run.dt:g} s" + (f" ({run.dt_taken:.4g} s taken)" if cut else "")


def error_table(run: Run, vertex: int) -> Table:
    """Return one vertex of one run over time: true position, the engine's, error vector, distance."""
    assert run.truth is not None
    times = run.scene.times
    true, flown = (vertices[-len(times) :, 0, vertex] for vertices in (run.truth.vertices, run.flight.vertices))
    errors, limits, distances = run.errors[:, 0, vertex], run.limits[:, 0], run.distances[:, 0, vertex]
    unit, metres, places = ruler(true)
    seen = distances[np.isfinite(distances) & (distances > limits)]
    small, size = unit_of(seen.max()) if seen.size else (unit, metres)
    heads = "t [s]", f"true [{unit}]", f"{run.engine} [{unit}]", f"error [{small}]", "off [m]"
    table = columns(*heads, right=range(5))
    for row in thinned(len(times)):
        below = distances[row] <= limits[row]
        table.add_row(
            f"{times[row]:g}",
            vector(true[row] / metres, places),
            vector(flown[row] / metres, places),
            "" if below else vector(errors[row] / size, 2),
            f"≤{figure(limits[row])}" if below else figure(distances[row]),
        )
    return table


def worst_vertex(runs: Sequence[Run]) -> int:
    """Return the vertex with the largest error over the contestants that are ok."""
    strays = [run.distances.max(axis=(0, 1)) for run in runs if run.has_errors and run.status == "ok"]
    return int(np.argmax(np.max(strays, axis=0))) if strays else 0
