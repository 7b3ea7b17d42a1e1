"""What `tumble compare` prints: the answer in a sentence, a ranking, and an error table for each contestant."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from rich.console import RenderableType
from rich.constrain import Constrain
from rich.table import Table
from rich.text import Text

from tumble.compare.comparison.against_truth import Comparison
from tumble.compare.comparison.ensemble_rows import QUANTILES, ensembles_of, run_rows, spread_row
from tumble.compare.comparison.findings import scene_findings
from tumble.compare.comparison.hints import hints
from tumble.compare.engines import OWN
from tumble.compare.judge.errors import Run
from tumble.compare.judge.spread import BIN_ERROR, WORST
from tumble.compare.run.status import described
from tumble.compare.tables.shared import FindingRow
from tumble.reports.charts import GOOD, coloured, error_chart
from tumble.reports.coursework import coursework_text, printed_vertex
from tumble.reports.lengths import length, ruler, unit_of
from tumble.reports.numerals import counted, listed
from tumble.reports.sensor_text import sensor_text
from tumble.reports.terminal import LIST_WIDTH, columns, figure, plain, reasons_text, thinned, vector
from tumble.scenarios.truth import Truth

MOST_NAMED = 4  # engines in one sentence


def comparison_text(
    comparison: Comparison, vertex: int | None, everything: bool = False, charts: bool = False
) -> Iterator[RenderableType]:
    """Yield what `tumble compare` prints of one scene: the answer, the ranking and error tables.

    Parameters
    ----------
    comparison : the runs of the scene and their errors
    vertex : index of the vertex in the error tables; None: the one with the largest error
    everything : print an error table of every run, not only of each engine's first method
    charts : draw a chart

    Yields
    ------
    the parts of the text, from top to bottom
    """
    scene, truth, runs = comparison.scene, comparison.truth, comparison.runs
    throws = comparison.ensemble[0].spread.throws if comparison.ensemble else len(scene.start)
    if truth is None:
        yield Constrain(plain(f"{scene.name} has no reference solution: {comparison.why_no_truth}"), LIST_WIDTH)
        for hint in hints(scene):
            yield Constrain(plain(f"Check the scene: {hint}"), LIST_WIDTH)
    else:
        yield Constrain(plain(answer(comparison)), LIST_WIDTH)
    yield Text()
    if charts:
        yield from error_chart(run_rows(comparison))
    yield from ensemble_text(comparison) if comparison.ensemble else standings(runs, comparison.roles)
    yield from steps_text(runs)
    if truth is not None:
        yield Constrain(plain(f"{scene.title}. {accuracy(truth, comparison.lost_m)}"), LIST_WIDTH)
        for hint in hints(scene) if truth.ends else ():
            yield Constrain(plain(f"Check the scene: {hint}"), LIST_WIDTH)
        vertex = printed_vertex(scene) if vertex is None else vertex
        vertex = worst_vertex(runs) if vertex is None else vertex
        shown = [run for run in (runs if everything else first_runs(runs)) if run.has_errors]
        for run in shown:
            yield Text()
            of_throw = f", throw 0 of {throws}" if throws > 1 else ""
            yield plain(f"{run.name}, {step_of(run)}, vertex {vertex}{of_throw}")
            yield error_table(run, vertex)
        if left := sum(run.has_errors for run in runs) - len(shown):
            yield plain(f"{counted(left, 'more table')} with --all; every vertex with -o DIR")
        if comparison.ensemble:
            yield Constrain(
                plain(
                    f"The ranking covers all throws; -o DIR writes the worst {WORST} to members.csv and to scene files."
                ),
                LIST_WIDTH,
            )
        elif throws > 1:
            yield plain("The ranking covers all throws; -o DIR writes each throw to members.csv.")
    yield from sensor_text(comparison.sensors, everything)
    yield from coursework_text(comparison)


def accuracy(truth: Truth, lost_m: float) -> str:
    """Return the accuracy of the reference solution, and what rounding the inputs costs where that is more.

    lost_m: how far a vertex moves if the inputs are rounded to double precision [m].
    """
    until = truth.until_horizon()
    text = f"Reference solution accurate to {figure(until.bound.max())} m{truth.ends}."
    # If the reference is no more accurate than that, it limits the comparison, and not the inputs.
    if until.input_error.max() >= until.bound.max():
        text += f" Differences below {figure(until.input_error.max())} m are not meaningful in double precision."
    if lost_m > until.resolution.max():
        text += (
            f" Rounding the inputs to double precision alone moves a vertex by up to {figure(lost_m)} m; no engine can "
            "do better."
        )
    return text


def first_runs(runs: Sequence[Run]) -> list[Run]:
    """Return the first method of each engine; ours last."""
    first: dict[str, Run] = {}
    for run in runs:
        first.setdefault(run.engine, run)
    return sorted(first.values(), key=lambda run: run.engine == OWN)


def answer(comparison: Comparison) -> str:
    """Return the answer in words: the most accurate contestant, and the error of each engine's first method."""
    scene = comparison.scene.name
    found: dict[str, list[FindingRow]] = {}
    for row in scene_findings(run_rows(comparison), comparison.defaults):
        found.setdefault(row.finding, []).append(row)
    if "most accurate" not in found:
        return f"{scene}: no contestant finished this scene; reasons below."
    best, worst = found["most accurate"][0], found["least accurate"][0]
    parts = [f"{scene}: {best.contestant} is most accurate, with an error of {error(best)}."]
    engines = [row for row in found.get("first method", ()) if row.contestant != best.contestant]
    named = engines[:MOST_NAMED]
    if engines:
        more = len(engines) - len(named)
        rest = f"; {more} more {'is' if more == 1 else 'are'} worse" if more else ""
        errors = listed([f"{row.contestant} {error(row)}" for row in named])
        parts.append(f"First method of each engine: {errors}{rest}.")
    if worst.contestant not in (best.contestant, *(row.contestant for row in named)):
        parts.append(f"Least accurate: {worst.contestant}, {error(worst)}.")
    for row in found.get("unfinished", ()):
        parts.append(f"{counted(round(row.value or 0), 'contestant')} did not finish.")
    for row in found.get("unsupported", ()):
        count = round(row.value or 0)
        parts.append(f"{counted(count, 'contestant')} {'does' if count == 1 else 'do'} not support this scene.")
    return " ".join(parts)


def error(row: FindingRow) -> str:
    """Return an error in words."""
    worst, limit = row.value or 0.0, row.resolution or 0.0
    return f"at most {length(limit)}" if worst <= limit else length(worst)


def standings(runs: Sequence[Run], roles: Mapping[str, str]) -> Iterator[RenderableType]:
    """Yield the contestants of one scene that finished, the most accurate first, and why any is not ok."""
    finished = sorted((run for run in runs if run.has_errors), key=lambda run: float(np.nanmax(run.distances)))
    table = columns("contestant", "", "max [m]", "rms [m]", "energy drift", "status", right=range(2, 5))
    for run in finished:
        worst, limit = float(run.distances.max()), float(run.limits.max())
        table.add_row(
            plain(run.name),
            roles.get(run.name, ""),
            Text(f"≤{figure(limit)}", style=GOOD) if worst <= limit else figure(worst),
            figure(float(np.sqrt((run.distances**2).mean()))),
            figure(run.drifts[0]),
            coloured(run.status),
        )
    if finished:
        yield table
    for run in finished:
        if run.flight.remark:
            yield plain(f"{run.name} {run.flight.remark}")
    if any(run.status != "ok" for run in runs):
        yield Text()
        yield from reasons_text((run.name, run.outcome) for run in runs if run.status != "ok")


def ensemble_text(comparison: Comparison) -> Iterator[RenderableType]:
    """Yield the contestants of a scene that ran in parts, the most accurate first: quantiles over the throws."""
    shown = {"median": "median_error_m", "95 %": "p95_error_m", "99.99 %": "p99_99_error_m"}
    table = columns("contestant", "", *(f"{name} [m]" for name in shown), "max [m]", "status", right=range(2, 6))
    finished = sorted(
        (one for one in ensembles_of(comparison) if one.spread.known), key=lambda one: one.spread.worst_m[0]
    )
    for one in finished:
        spread = one.spread
        quantiles = (figure(spread.quantile(QUANTILES[column])) for column in shown.values())
        worst, limit = float(spread.worst_m[0]), float(spread.limits_m.max())
        most = Text(f"≤{figure(limit)}", style=GOOD) if worst <= limit else figure(worst)
        name = one.run.name
        table.add_row(plain(name), comparison.roles.get(name, ""), *quantiles, most, coloured(spread.status))
    if finished:
        yield table
    rows = [(one.run.name, spread_row(one)) for one in ensembles_of(comparison)]
    if any(row.status != "ok" for _, row in rows):
        yield Text()
        yield from reasons_text((name, described(row.status, row.why)) for name, row in rows if row.status != "ok")
    throws, unknown = (max(getattr(one.spread, name) for one in comparison.ensemble) for name in ("throws", "unknown"))
    without = f"; {counted(unknown, 'throw')} without a reference solution" if unknown else ""
    share = f"Quantiles over {throws} throws, each within {100 * BIN_ERROR:.1g} % of its value{without}."
    yield Constrain(plain(share), LIST_WIDTH)


def steps_text(runs: Sequence[Run]) -> Iterator[RenderableType]:
    """Yield the mean step of runs in which samples and impulses cut the steps."""
    for dt, taken, steps in dict.fromkeys((run.dt, run.dt_taken, run.flight.steps) for run in runs if run.dt_taken):
        if taken != dt:
            line = f"A step of {dt:g} s does not divide the intervals between samples and impulses: {steps} steps"
            yield Constrain(plain(f"{line} of {taken:.4g} s on average were taken."), LIST_WIDTH)


def step_of(run: Run) -> str:
    """Return the step asked for, and the mean step taken if that differs."""
    cut = run.dt_taken not in (None, run.dt)
    return f"dt = {run.dt:g} s" + (f" ({run.dt_taken:.4g} s taken)" if cut else "")


def error_table(run: Run, vertex: int) -> Table:
    """Return one vertex of one run over time: true position, the engine's, error vector, distance."""
    assert run.truth is not None
    times = run.scene.times
    true, seen = (vertices[-len(times) :, 0, vertex] for vertices in (run.truth.vertices, run.flight.vertices))
    errors, limits, distances = run.errors[:, 0, vertex], run.limits[:, 0], run.distances[:, 0, vertex]
    unit, metres, places = ruler(true)
    above = distances[np.isfinite(distances) & (distances > limits)]
    small, size = unit_of(above.max()) if above.size else (unit, metres)
    heads = "t [s]", f"true [{unit}]", f"{run.engine} [{unit}]", f"error [{small}]", "norm [m]"
    table = columns(*heads, right=range(5))
    for row in thinned(len(times)):
        below = distances[row] <= limits[row]
        table.add_row(
            f"{times[row]:g}",
            vector(true[row] / metres, places),
            vector(seen[row] / metres, places),
            "" if below else vector(errors[row] / size, 2),
            f"≤{figure(limits[row])}" if below else figure(distances[row]),
        )
    return table


def worst_vertex(runs: Sequence[Run]) -> int:
    """Return the vertex with the largest error over the contestants that are ok."""
    worst = [run.distances.max(axis=(0, 1)) for run in runs if run.has_errors and run.status == "ok"]
    return int(np.argmax(np.max(worst, axis=0))) if worst else 0
