"""What `tumble sweep` and `tumble advise` print: the cost of accuracy, and the fastest way to an error."""

import math
from collections.abc import Collection, Iterator, Sequence

from rich.console import RenderableType
from rich.constrain import Constrain

from tumble.compare.engines import BY_HAND, OWN
from tumble.compare.run.contestant import Contestant
from tumble.compare.sweep.longer_steps import longer_steps
from tumble.compare.sweep.pareto_front import (
    accuracy_cost_rows,
    by_contestant,
    equivalent_rows,
    order_rows,
    reach,
    usable,
)
from tumble.compare.sweep.schemas import AccuracyCostRow, ObservableCostRow, OrderRow
from tumble.compare.sweep.work_precision import TARGETS_M, Sweep, Timed
from tumble.reports.charts import cost_chart
from tumble.reports.contact_text import POSITIONS
from tumble.reports.families import joined
from tumble.reports.lengths import length
from tumble.reports.numerals import listed
from tumble.reports.terminal import LIST_WIDTH, columns, figure, plain, reasons_text

SHARES = (10.0, 1.0, 0.1, 0.01)  # errors of an observable [%]
MOST_ALIKE = 3  # contestants named as fastest to one error
# A confidence interval whose ends differ by more than this factor is printed instead of the ratio.
WIDE = 2.0


def sweep_text(sweep: Sweep, reference: str, charts: bool = False) -> Iterator[RenderableType]:
    """Yield what `tumble sweep` prints: the cost of each error, the fastest contestants, and equal integrators.

    Parameters
    ----------
    sweep : the runs of one scene
    reference : ENGINE:METHOD that run times are divided by
    charts : draw a chart

    Yields
    ------
    the parts of the text, from top to bottom
    """
    yield plain(f"{sweep.scene.name}: {sweep.scene.title}")
    yield from observable_text(sweep.observed)
    if charts:
        yield from cost_chart(list(accuracy_cost_rows(sweep, reference)))
    yield plain("run time [us] to reach an error; in brackets the ratio to " + reference)
    orders = {(row.engine, row.method): row for row in order_rows(sweep)}
    costs: dict[tuple[str, str], list[AccuracyCostRow]] = {}
    for row in accuracy_cost_rows(sweep, reference):
        costs.setdefault((row.engine, row.method), []).append(row)
    heads = (f"{target:.0e} m" for target in TARGETS_M)
    table = columns("contestant", "order", *heads, "best [m]", right=range(1, 3 + len(TARGETS_M)))
    for name, digits in sorted(costs.items(), key=lambda item: [row.run_us or math.inf for row in item[1]]):
        order = orders.get(name)
        shown = "" if order is None or order.order is None else f"{order.order:.2f}"
        best = "" if order is None else figure(order.best_error_m)
        table.add_row(plain(":".join(name)), shown, *map(cost, digits), best)
    yield table
    yield from cheapest_text([row for digits in costs.values() for row in digits])
    same = list(equivalent_rows(sweep))
    for members in joined((row.contestant_a, row.contestant_b) for row in same):
        apart = max(row.max_distance_m for row in same if row.contestant_a in members)
        yield plain(f"{', '.join(members)} are the same integrator: at most {figure(apart)} m apart at any step")
    yield from precision_text(orders.values())
    yield from clock_text(sweep, [row for digits in costs.values() for row in digits])
    yield from reasons_text((run.name, run.outcome) for run in sweep.untimed if run.status != "ok")


def observable_text(rows: Sequence[ObservableCostRow]) -> Iterator[RenderableType]:
    """Yield the run time that each contestant needs to reach an error of an observable of contact."""
    if not rows:
        return
    impact = f" {rows[0].blow}" if rows[0].blow else ""
    yield plain(f"{rows[0].observable}{impact}: run time [us] of the scene to reach an error, as a share of its size")
    table = columns(
        "contestant", *(f"{share:.4g} %" for share in SHARES), "best", "unit", right=range(1, 2 + len(SHARES))
    )
    own: dict[str, list[ObservableCostRow]] = {}
    for row in rows:
        own.setdefault(f"{row.engine}:{row.method}", []).append(row)
    reached = {name: [within(each, share / 100) for share in SHARES] for name, each in own.items()}
    for name in sorted(own, key=lambda name: [time or math.inf for time in reversed(reached[name])]):
        best = figure(min(row.error for row in own[name]))
        times = ["never" if time is None else f"{time:.3g}" for time in reached[name]]
        table.add_row(plain(name), *times, best, own[name][0].unit)
    yield table
    yield Constrain(plain(POSITIONS), LIST_WIDTH)


def within(rows: Sequence[ObservableCostRow], share: float) -> float | None:
    """Return the shortest run time of those within an error [us]; None if there is none."""
    return min((row.run_us for row in rows if row.error_share <= share), default=None)


def precision_text(orders: Collection[OrderRow]) -> Iterator[RenderableType]:
    """Yield who loses accuracy below a step, and the accuracy that single precision limits vertices to."""
    for row in orders:
        if row.worsens:
            worse = f"{figure(row.finest_error_m)} m at {row.finest_dt_s:.2g} s"
            yield plain(
                f"{row.engine}:{row.method} loses accuracy below a step of {row.best_dt_s:.2g} s: "
                f"{figure(row.best_error_m)} m there, {worse}"
            )
    single = {row.engine: row.rounding_m for row in orders if row.precision == "single"}
    if single:
        least = figure(max(single.values()))
        yield plain(f"single precision ({', '.join(single)}) cannot represent a vertex here to better than {least} m")


def clock_text(sweep: Sweep, digits: Sequence[AccuracyCostRow]) -> Iterator[RenderableType]:
    """Yield the confidence intervals of the ratios, why there are none, and what disturbed the timing."""
    widths = [math.sqrt(row.ratio_high / row.ratio_low) - 1 for row in digits if row.ratio_high and row.ratio_low]
    if widths:
        yield plain(f"95 % confidence intervals of the ratios: within {min(widths):.0%} to {max(widths):.0%}")
    yield from reasons_text(
        {(f"{row.engine}:{row.method}", row.no_ratio) for row in digits if row.no_ratio and row.run_us}
    )
    found = {each.run.name: each.reading for each in sweep.timed if each.reading.finding}
    yield from reasons_text((name, f"{it.finding}; timed by {it.clock} time") for name, it in found.items())
    yield from reasons_text(sweep.why_untimed.items())


def cost(row: AccuracyCostRow) -> str:
    """Return the cost of one error, with its ratio if there is one."""
    if row.run_us is None:
        return row.verdict
    sign = "<=" if row.verdict == "at most" else ""
    return f"{sign}{row.run_us:.3g}{quoted(row)}"


def quoted(row: AccuracyCostRow) -> str:
    """Return the ratio in brackets, or its confidence interval if that is wide."""
    if row.ratio is None or row.ratio_low is None or row.ratio_high is None:
        return " (?)" if row.no_ratio else ""
    if row.ratio_high > WIDE * row.ratio_low:
        return f" ({few(row.ratio_low)} to {few(row.ratio_high)})"
    return f" ({few(row.ratio)})"


def few(number: float) -> str:
    """Return a ratio in two or three digits."""
    return f"{number:.{2 if number < 100 else 3}g}"


def cheapest_text(digits: Sequence[AccuracyCostRow]) -> Iterator[RenderableType]:
    """Yield who reaches each error of the table fastest, of all and of the engines other than our solver."""
    others = [row for row in digits if row.engine not in (OWN, BY_HAND)]
    groups = [("fastest", digits), ("fastest other than Tumble's own solver", others)]
    for head, rows in groups[: 1 + (len(others) < len(digits))]:
        errors: dict[str, list[str]] = {}
        for target in TARGETS_M:
            if names := cheapest([row for row in rows if row.target_m == target]):
                errors.setdefault(" or ".join(names), []).append(f"{target:.0e} m")
        if errors:
            yield plain(f"{head}: {'; '.join(f'{names} to {listed(reached)}' for names, reached in errors.items())}")


def cheapest(rows: Sequence[AccuracyCostRow]) -> list[str]:
    """Return who reaches an error fastest, and those whose confidence intervals overlap with that."""
    reached = sorted((row for row in rows if row.run_us is not None), key=lambda row: row.run_us or 0.0)
    if not reached:
        return []
    first, *more = reached
    alike = [row for row in more if row.ratio_low and first.ratio_high and row.ratio_low <= first.ratio_high]
    return [f"{row.engine}:{row.method}" for row in (first, *alike[: MOST_ALIKE - 1])]


def advice_text(sweep: Sweep, tolerance_m: float, named: Collection[str] = ()) -> Iterator[RenderableType]:
    """Yield what `tumble advise` prints: what to use, and of each engine its fastest run or its smallest error.

    Parameters
    ----------
    sweep : the runs of one scene
    tolerance_m : largest acceptable vertex error [m]
    named : ENGINE:METHOD of contestants given with a method, each of which has a line

    Yields
    ------
    the parts of the text, from top to bottom
    """
    reached, missed = answers(sweep, tolerance_m)
    yield Constrain(plain(advice(sweep, tolerance_m, reached, missed)), LIST_WIDTH)
    shown = [(run, "") for run in first_of_engines(reached, named, ())]
    shown += [(run, "not reached") for run in first_of_engines(missed, named, {run.run.engine for run in reached})]
    cut = any(run.run.dt_taken not in (None, run.run.dt) for run, _ in shown if run.per_step)
    heads = ["engine", "method", "step [s]", *["taken [s]"] * cut, "run [us]", "error [m]", ""]
    table = columns(*heads, right=range(2, len(heads) - 1))
    for run, reason in shown:
        taken = [f"{run.run.dt_taken:.3g}" if run.per_step and run.run.dt_taken else ""] * cut
        cells = step(run), *taken, f"{run.run_ns / 1e3:.3g}", figure(run.error_m), reason
        table.add_row(plain(run.run.engine), plain(run.run.method), *cells)
    if table.row_count:
        yield plain("")
        yield table
    found = {run.run.engine for run in (*reached, *missed)}
    for engine in dict.fromkeys(each.run.engine for each in sweep.timed):
        if engine not in found:
            yield plain(f"{engine}: no step or tolerance that was tried gave a run with status ok")
    yield from reasons_text((run.name, run.outcome) for run in sweep.untimed if run.status != "ok")
    yield from reasons_text(sweep.why_untimed.items())


def answers(sweep: Sweep, tolerance_m: float) -> tuple[list[Timed], list[Timed]]:
    """Return each contestant's fastest run within the error, or else its most accurate one; both in order."""
    reached, missed = [], []
    for timed in by_contestant(sweep.timed).values():
        _, _, run = reach(timed, tolerance_m)
        if run is not None:
            reached.append(run)
        elif plainly := usable(timed):
            missed.append(min(plainly, key=lambda each: each.error_m))
    return sorted(reached, key=lambda run: run.run_ns), sorted(missed, key=lambda run: run.error_m)


def first_of_engines(runs: Sequence[Timed], named: Collection[str], done: Collection[str]) -> list[Timed]:
    """Return the first run of each engine that is not done, and all runs of named contestants."""
    seen, found = set(done), []
    for run in runs:
        if run.run.engine not in seen or Contestant.of(run.run.engine, run.run.method).is_among(named):
            found.append(run)
        seen.add(run.run.engine)
    return found


def advice(sweep: Sweep, tolerance_m: float, reached: Sequence[Timed], missed: Sequence[Timed]) -> str:
    """Return what to use, and the best engine other than our solver."""
    choices = [run for run in reached if run.run.engine != BY_HAND] or reached
    others = [run for run in choices if is_other(run)]
    nothing = f"no contestant stays within {length(tolerance_m)}; the table shows the smallest error of each."
    parts = [f"{sweep.scene.name}: {nothing}"]
    if choices:
        parts = [f"{sweep.scene.name}: use {in_words(choices[0], tolerance_m)}."]
        if not is_other(choices[0]) and others:
            parts.append(f"Best other engine: {in_words(others[0], tolerance_m)}.")
    if not others:
        near = [
            f"{run.run.name} comes closest, with an error of {length(run.error_m)}" for run in missed if is_other(run)
        ][:1]
        parts.append(f"No other engine stays within it: {''.join(near) or 'none was measured'}.")
    if choices and (bound := bounded_by_samples(sweep, choices[0])):
        parts.append(bound)
    return " ".join(parts)


def is_other(run: Timed) -> bool:
    """Whether this is an engine other than our solver."""
    return run.run.engine not in (OWN, BY_HAND)


def in_words(run: Timed, tolerance_m: float) -> str:
    """Return a run with its step, its error and its cost."""
    at = f"with a step of {step(run)} s" if run.per_step else "with its own steps"
    margin = f"margin {tolerance_m / run.error_m:.2g}" if run.error_m > 0.0 else "no visible error"
    return f"{run.run.name} {at} (error {length(run.error_m)}, {margin}; {run.run_ns / 1e3:.3g} us a run)"


def bounded_by_samples(sweep: Sweep, run: Timed) -> str:
    """Return a sentence if the samples of the scene, and not its error, kept longer steps from being tried."""
    longer = longer_steps(sweep.scene)
    if not run.per_step or not longer or run.run.dt in longer:
        return ""
    if run.run.dt < max(each.run.dt for each in sweep.timed if each.run.name == run.run.name):
        return ""
    return "The scene's samples, not accuracy, limit this step: --beyond-samples also tries longer ones."


def step(run: Timed) -> str:
    """Return the step of a run, three digits [s]."""
    return f"{run.run.dt:.3g}" if run.per_step else "own"
