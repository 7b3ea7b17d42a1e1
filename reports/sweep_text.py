"""What `tumble sweep` and `tumble advise` print: what each digit costs, and the cheapest way to an error."""

import math
from collections.abc import Collection, Iterator, Sequence

from rich.console import RenderableType
from rich.constrain import Constrain

from compare.sweep.frontier import (
    TARGETS_M,
    by_contestant,
    digit_rows,
    order_rows,
    reach,
    same_rows,
    usable,
    work_precision_rows,
)
from compare.sweep.schemas import DigitRow, OrderRow
from compare.sweep.work_precision import Sweep, Timed
from reports.charts import cost_chart
from reports.families import joined
from reports.terminal import LIST_WIDTH, columns, figure, length, plain, reasons_text

# An interval wider than this, from end to end, is quoted itself, and not its middle.
WIDE = 2.0


def sweep_text(sweep: Sweep, reference: str, charts: bool = False) -> Iterator[RenderableType]:
    """Yield what `tumble sweep` prints: what each digit costs, the frontier, and who is the same integrator.

    charts: whether a chart stands before them.
    """
    yield plain(f"{sweep.scene.name}: {sweep.scene.title}")
    if charts:
        yield from cost_chart(list(digit_rows(sweep, reference)))
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
    measured = sorted(work_precision_rows(sweep), key=lambda row: row.flight_us)
    edge = dict.fromkeys(f"{row.engine}:{row.method.partition('@')[0]}" for row in measured if row.frontier)
    if edge:
        yield plain(f"nobody is cheaper at any error than {', '.join(edge)}")
    same = list(same_rows(sweep))
    for members in joined((row.contestant_a, row.contestant_b) for row in same):
        apart = max(row.furthest_apart_m for row in same if row.contestant_a in members)
        yield plain(f"{', '.join(members)} are one integrator: at most {figure(apart)} m apart at any step")
    yield from precision_text(orders.values())
    yield from clock_text(sweep, [row for digits in costs.values() for row in digits])
    yield from reasons_text((run.name, run.status) for run in sweep.untimed if run.status != "ok")


def precision_text(orders: Collection[OrderRow]) -> Iterator[RenderableType]:
    """Yield who gets worse below a step, and by how much, and the least that single precision can hold here."""
    for row in orders:
        if row.worsens:
            worse = f"{figure(row.finest_error_m)} m at {row.finest_dt_s:.2g} s"
            yield plain(
                f"{row.engine}:{row.method} gets worse below a step of {row.best_dt_s:.2g} s: "
                f"{figure(row.best_error_m)} m there, {worse}"
            )
    single = {row.engine: row.rounding_m for row in orders if row.precision == "single"}
    if single:
        least = figure(max(single.values()))
        yield plain(f"single precision ({', '.join(single)}) can hold no corner here to less than {least} m")


def clock_text(sweep: Sweep, digits: Sequence[DigitRow]) -> Iterator[RenderableType]:
    """Yield how certain the ratios are, why there are none, and what the clock found odd."""
    widths = [math.sqrt(row.ratio_high / row.ratio_low) - 1 for row in digits if row.ratio_high and row.ratio_low]
    if widths:
        yield plain(f"ratios hold to {min(widths):.0%} to {max(widths):.0%}, in 95 of 100 runs")
    yield from reasons_text(
        {(f"{row.engine}:{row.method}", row.no_ratio) for row in digits if row.no_ratio and row.flight_us}
    )
    found = {each.run.name: each.reading for each in sweep.timed if each.reading.finding}
    yield from reasons_text((name, f"{it.finding}; timed by {it.clock} time") for name, it in found.items())
    yield from reasons_text(sweep.why_untimed.items())


def cost(row: DigitRow) -> str:
    """Return what one digit costs, with its ratio where there is one."""
    if row.flight_us is None:
        return row.verdict
    sign = "<=" if row.verdict == "at most" else ""
    return f"{sign}{row.flight_us:.3g}{quoted(row)}"


def quoted(row: DigitRow) -> str:
    """Return the ratio in brackets; one that is hardly known is quoted as the interval it lies in."""
    if row.ratio is None or row.ratio_low is None or row.ratio_high is None:
        return " (?)" if row.no_ratio else ""
    if row.ratio_high > WIDE * row.ratio_low:
        return f" ({few(row.ratio_low)} to {few(row.ratio_high)})"
    return f" ({few(row.ratio)})"


def few(number: float) -> str:
    """Return a number as a ratio is quoted."""
    return f"{number:.{2 if number < 100 else 3}g}"


def advice_text(sweep: Sweep, tolerance_m: float) -> Iterator[RenderableType]:
    """Yield what `tumble advise` prints: what to use; the cheapest of each engine, or how close it came."""
    best: dict[str, tuple[float, Timed]] = {}
    nearest: dict[str, Timed] = {}
    for (engine, _), timed in by_contestant(sweep.timed).items():
        _, flight_ns, run = reach(timed, tolerance_m)
        if run is not None and flight_ns is not None and (engine not in best or run.flight_ns < best[engine][0]):
            best[engine] = run.flight_ns, run
        for each in usable(timed):
            if engine not in nearest or each.error_m < nearest[engine].error_m:
                nearest[engine] = each
    ordered = sorted(best.items(), key=lambda item: item[1][0])
    yield Constrain(plain(advice(sweep, tolerance_m, ordered[0][1] if ordered else None)), LIST_WIDTH)
    table = columns("engine", "method", "step [s]", "flight [us]", "error [m]", "", right=range(2, 5))
    for engine, (flight_ns, run) in ordered:
        table.add_row(plain(engine), plain(run.run.method), step(run), f"{flight_ns / 1e3:.3g}", figure(run.error_m))
    for engine, run in nearest.items():
        if engine not in best:
            cost_us = f"{run.flight_ns / 1e3:.3g}"
            table.add_row(plain(engine), plain(run.run.method), step(run), cost_us, figure(run.error_m), "not reached")
    if table.row_count:
        yield plain("")
        yield table
    for engine in dict.fromkeys(each.run.engine for each in sweep.timed):
        if engine not in nearest:
            yield plain(f"{engine}: no step or tolerance that was measured gave a plain result")
    yield from reasons_text(sweep.why_untimed.items())
    yield from reasons_text((run.name, run.status) for run in sweep.untimed if run.status != "ok")


def advice(sweep: Sweep, tolerance_m: float, cheapest: tuple[float, Timed] | None) -> str:
    """Return what to use, in a person's words."""
    name = sweep.scene.name
    if cheapest is None:
        return f"{name}: nothing that was measured stays within {length(tolerance_m)}; below is how close each came."
    flight_ns, run = cheapest
    at = f"at {step(run)} s" if run.per_step else "with steps of its own"
    margin = f"a margin of {tolerance_m / run.error_m:.2g}" if run.error_m > 0.0 else "no error that can be seen"
    cost_us = f"{flight_ns / 1e3:.2g} us a flight"
    return f"{name}: use {run.run.name} {at}: {length(run.error_m)} off, {margin}; {cost_us}."


def step(run: Timed) -> str:
    """Return the step of a run, three digits [s]."""
    return f"{run.run.dt:.3g}" if run.per_step else "its own"
