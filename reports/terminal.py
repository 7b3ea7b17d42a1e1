"""What a command prints: lists and error tables as text, 80 columns wide where they can be."""

import math
import re
from collections.abc import Iterable, Iterator, Sequence

import numpy as np
from rich import box
from rich.console import Console, RenderableType
from rich.constrain import Constrain
from rich.table import Table
from rich.text import Text

from compare.comparison.against_truth import Comparison
from compare.comparison.table_4_1 import BudgetRow, budget_rows, is_table_4_1, published_rows
from compare.judge.errors import Run
from compare.sweep.frontier import (
    TARGETS_M,
    by_contestant,
    digit_rows,
    error,
    frontier,
    order_rows,
    reach,
    same_rows,
)
from compare.sweep.schemas import DigitRow
from compare.sweep.sweep import Sweep, Timed
from compare.tables.shared import EngineRow
from reports.families import joined
from scenarios.format import visible
from scenarios.frames import Array
from scenarios.published import VERTEX

SHOWN_SAMPLES = 10
# Tables need not wrap into a pipe; lists do, for they are read and not cut into columns.
PIPE_WIDTH, LIST_WIDTH = 160, 80
UNITS = (("km", 1e3), ("m", 1.0), ("mm", 1e-3), ("µm", 1e-6), ("nm", 1e-9))


def console(**settings: object) -> Console:
    """Return a console for results: as wide as the terminal, or wide enough not to wrap into a pipe."""
    found = Console(highlight=False, markup=False, emoji=False, **settings)  # type: ignore[arg-type]
    if not found.is_terminal:
        found.width = PIPE_WIDTH
    return found


def plain(text: str) -> Text:
    """Return text of a scene's or an engine's as data: control characters made visible."""
    return Text(visible(text))


def columns(*heads: str, right: Sequence[int] = ()) -> Table:
    """Return an empty table; right: the columns that hold numbers."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=0, show_edge=False)
    for number, head in enumerate(heads):
        table.add_column(head, justify="right" if number in right else "left", no_wrap=number == 0)
    return table


def reasons_text(told: Iterable[tuple[str, str]]) -> Iterator[Constrain]:
    """Yield every reason once, after all contestants that it is told of; told: contestant and reason."""
    names: dict[str, dict[str, None]] = {}
    for contestant, reason in told:
        _, _, method = contestant.partition(":")
        # What differs only in the name of its own method is one reason.
        names.setdefault(re.sub(f"(^|: ){re.escape(method)} ", r"\1", reason), {})[contestant] = None
    for reason, own in names.items():
        yield Constrain(plain(f"{', '.join(own)}: {reason}"), LIST_WIDTH)


def engine_list(rows: Sequence[EngineRow]) -> Table:
    """Return the engines: version, precision, methods, what was switched off; or why one is missing."""
    table = columns("engine", "version", "precision", "methods (default first)", "switched off to be fair")
    for row in rows:
        if row.status == "ok":
            table.add_row(*map(plain, (row.engine, row.version, row.precision, row.methods, row.switched_off)))
        else:
            table.add_row(plain(row.engine), "", "", plain(row.methods), plain(row.told))
    return table


def comparison_text(comparison: Comparison, vertex: int | None) -> Iterator[RenderableType]:
    """Yield what `tumble compare` prints: a table as Table 4.1 for every contestant, then all of them in one."""
    scene, truth = comparison.scene, comparison.truth
    yield plain(f"{scene.name}: {scene.title}")
    if truth is None:
        yield plain(f"no truth: {comparison.why_no_truth}")
    else:
        known = truth.until_horizon()
        yield plain(f"truth known to {figure(known.bound.max())} m{truth.ends}")
        # Where the truth is known no better than that, it is the truth and not the inputs that sets the limit.
        if known.floor.max() >= known.bound.max():
            yield plain(f"no double-precision program can be held to less than {figure(known.floor.max())} m")
        vertex = worst_vertex(comparison.runs) if vertex is None else vertex
        for run in comparison.runs:
            if run.has_errors:
                yield Text()
                yield plain(f"{run.name}, dt = {run.dt:g} s, vertex {vertex}")
                yield error_table(run, vertex)
    yield Text()
    yield from standings(comparison.runs)
    if is_table_4_1(scene):
        yield Text()
        yield plain("largest distance over the five rows from the columns printed in Table 4.1")
        yield budget_table(list(budget_rows(list(published_rows(comparison)))))


def error_table(run: Run, vertex: int) -> Table:
    """Return one vertex of one run over time: true position, the engine's, error vector, distance."""
    assert run.truth is not None
    times = run.scene.times
    true, flown = (vertices[-len(times) :, 0, vertex] for vertices in (run.truth.vertices, run.flight.vertices))
    errors, limits, distances = run.errors[:, 0, vertex], run.limits[:, 0], run.distances[:, 0, vertex]
    unit, metres, places = ruler(true)
    seen = distances[np.isfinite(distances) & (distances > limits)]
    power = math.floor(math.log10(seen.max())) if seen.size else 0
    heads = "t [s]", f"true [{unit}]", f"{run.engine} [{unit}]", f"error [1e{power} m]", "off [m]"
    table = columns(*heads, right=range(5))
    for row in thinned(len(times)):
        below = distances[row] <= limits[row]
        table.add_row(
            f"{times[row]:g}",
            vector(true[row] / metres, places),
            vector(flown[row] / metres, places),
            "" if below else vector(errors[row] / 10.0**power, 2),
            f"≤{figure(limits[row])}" if below else figure(distances[row]),
        )
    return table


def standings(runs: Sequence[Run]) -> Iterator[RenderableType]:
    """Yield the contestants of one scene that flew, the best first, and then why any is not plainly ok."""
    flown = sorted((run for run in runs if run.has_errors), key=lambda run: float(np.nanmax(run.distances)))
    table = columns("contestant", "max [m]", "rms [m]", "energy drift", "ns/step", "status", right=range(1, 5))
    for run in flown:
        worst, limit = float(run.distances.max()), float(run.limits.max())
        table.add_row(
            plain(run.name),
            f"≤{figure(limit)}" if worst <= limit else figure(worst),
            figure(float(np.sqrt((run.distances**2).mean()))),
            figure(run.drifts[0]),
            f"{run.flight.wall_s / run.flight.steps * 1e9:.0f}",
            run.status.partition(":")[0],
        )
    if flown:
        yield table
    for run in flown:
        if run.flight.remark:
            yield plain(f"{run.name} {run.flight.remark}")
    if any(run.status != "ok" for run in runs):
        yield Text()
        yield from reasons_text((run.name, run.status) for run in runs if run.status != "ok")


def budget_table(rows: Sequence[BudgetRow]) -> Table:
    """Return how far every contestant is from Table 4.1's two columns."""
    table = columns("contestant", "calculated [m]", "application [m]", right=(1, 2))
    for row in rows:
        name = f"{row.engine}:{row.method}" if row.method else row.engine
        table.add_row(plain(name), f"{row.max_to_calculated_m:.3f}", f"{row.max_to_application_m:.3f}")
    return table


def sweep_text(sweep: Sweep, reference: str) -> Iterator[RenderableType]:
    """Yield what `tumble sweep` prints: what each digit costs, the frontier, and who is the same integrator."""
    yield plain(f"{sweep.scene.name}: {sweep.scene.title}")
    yield plain("native time of a flight [us] to reach an error; in brackets the ratio to " + reference)
    orders = {(row.engine, row.method): row for row in order_rows(sweep)}
    costs: dict[tuple[str, str], list[DigitRow]] = {}
    for row in digit_rows(sweep, reference):
        costs.setdefault((row.engine, row.method), []).append(row)
    heads = (f"{target:.0e} m" for target in TARGETS_M)
    table = columns("contestant", "order", *heads, "best [m]", right=range(1, 3 + len(TARGETS_M)))
    for name, digits in sorted(costs.items(), key=lambda item: [row.flight_us or math.inf for row in item[1]]):
        order = orders.get(name)
        shown = "" if order is None or order.order is None else f"{order.order:.2f}"
        best = "" if order is None else figure(order.best_error_m)
        table.add_row(plain(":".join(name)), shown, *map(cost, digits), best)
    yield table
    edge = dict.fromkeys(f"{each.run.engine}:{each.run.method.partition('@')[0]}" for each in frontier(sweep.timed))
    yield plain(f"nobody is cheaper at any error than {', '.join(edge)}")
    same = list(same_rows(sweep))
    for members in joined((row.contestant_a, row.contestant_b) for row in same):
        apart = max(row.furthest_apart_m for row in same if row.contestant_a in members)
        yield plain(f"{', '.join(members)} are one integrator: at most {figure(apart)} m apart at any step")
    yield from clock_text(sweep, [row for digits in costs.values() for row in digits])
    yield from reasons_text((run.name, run.status) for run in sweep.untimed if run.status != "ok")


def clock_text(sweep: Sweep, digits: Sequence[DigitRow]) -> Iterator[RenderableType]:
    """Yield how certain the ratios are, why some are not told, and what the clock found odd."""
    widths = [math.sqrt(row.ratio_high / row.ratio_low) - 1 for row in digits if row.ratio_high and row.ratio_low]
    if widths:
        yield plain(f"ratios hold to {min(widths):.0%} to {max(widths):.0%}, in 95 of 100 runs")
    yield from reasons_text({(f"{row.engine}:{row.method}", row.no_ratio) for row in digits if row.no_ratio})
    found = {each.run.name: each.reading for each in sweep.timed if each.reading.finding}
    yield from reasons_text((name, f"{it.finding}; timed by {it.clock} time") for name, it in found.items())
    yield from reasons_text(sweep.why_untimed.items())


def cost(row: DigitRow) -> str:
    """Return what one digit costs, with its ratio where that may be quoted."""
    if row.flight_us is None:
        return row.verdict
    sign = "<=" if row.verdict == "at most" else ""
    ratio = f" ({row.ratio:.2g})" if row.ratio is not None else " (?)" if row.no_ratio else ""
    return f"{sign}{row.flight_us:.3g}{ratio}"


def advice_text(sweep: Sweep, tolerance_m: float) -> Iterator[Table | Text]:
    """Yield what `tumble advise` prints: the cheapest method and step of each engine, the cheapest engine first."""
    yield plain(f"{sweep.scene.name}: the cheapest way to stay within {tolerance_m:g} m at every vertex and sample")
    best: dict[str, tuple[float, Timed]] = {}
    for (engine, _), timed in by_contestant(sweep.timed).items():
        _, flight_ns, run = reach(timed, tolerance_m)
        if run is not None and flight_ns is not None and (engine not in best or run.flight_ns < best[engine][0]):
            best[engine] = run.flight_ns, run
    table = columns("engine", "method", "step [s]", "flight [us]", "error [m]", right=range(2, 5))
    for engine, (flight_ns, run) in sorted(best.items(), key=lambda item: item[1][0]):
        step = f"{run.run.dt:.3g}" if run.per_step else "its own"
        table.add_row(plain(engine), plain(run.run.method), step, f"{flight_ns / 1e3:.3g}", figure(error(run)))
    if best:
        yield table
    for engine in dict.fromkeys(each.run.engine for each in sweep.timed):
        if engine not in best:
            yield plain(f"{engine}: not reached by any step or tolerance that was measured")


def worst_vertex(runs: Sequence[Run]) -> int:
    """Return the vertex to print: Table 4.1's own, else the one where the contestants that are ok stray furthest."""
    if runs and is_table_4_1(runs[0].scene):
        return VERTEX
    strays = [run.distances.max(axis=(0, 1)) for run in runs if run.has_errors and run.status == "ok"]
    return int(np.argmax(np.max(strays, axis=0))) if strays else 0


def thinned(samples: int) -> list[int]:
    """Return which samples are printed: all, or some at even distances that end with the last."""
    if samples <= SHOWN_SAMPLES:
        return list(range(samples))
    return sorted({round((number + 1) * samples / SHOWN_SAMPLES) - 1 for number in range(SHOWN_SAMPLES)})


def ruler(positions: Array) -> tuple[str, float, int]:
    """Return the unit that positions [m] are printed in, its length [m], and decimals for three digits."""
    largest = float(abs(positions).max())
    unit, metres = next((unit for unit in UNITS if largest >= unit[1]), UNITS[-1])
    return unit, metres, sum(largest < bound * metres for bound in (100, 10))


def vector(values: Array, places: int) -> str:
    """Return (x, y, z)."""
    return "(" + ", ".join(f"{value:.{places}f}" for value in values) + ")"


def figure(value: float) -> str:
    """Return a figure in two digits."""
    return f"{value:.1e}"
