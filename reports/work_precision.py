"""What each digit costs: for each swept scene the chart of error against run time, its table, and what they say."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from compare.comparison.results import SceneRow
from compare.run.timer import SAMPLE_NS
from compare.sweep.frontier import TARGETS_M, ClockRow, DigitRow, OrderRow, SameRow, ThrowsRow
from compare.tables.rows import RunRow
from reports import standings
from reports.charts import SHAPES, CostChart, Stroke, cost_chart, striped
from reports.families import joined
from reports.numerals import TIMES, at_most, counted, figure, fixed, given, listed, superscript
from reports.rows import Tables, contestant, error_m, setting, untuned
from reports.standings import LegendGroup
from scenarios.needs import FORCES

NANOSECONDS = ("ns", "median_ns", "p90_ns", "call_ns")
# Orders within this of 1 are first order, at every rung; translation errors per step that agree to this are one error.
FIRST_ORDER, SAME_FALL = 0.2, 0.005


@dataclass(frozen=True)
class Cost:
    """What one error costs a contestant: native time [us], that over the reference's, and the step that reaches it."""

    time: str
    ratio: str
    step: str
    least: bool


@dataclass(frozen=True)
class Line:
    """One line of the table.

    best: the least error [m], whether smaller steps would pay, and where it was; parts: the error's from attitude and
    from translation [m], and where they were read.
    """

    contestant: str
    order: str
    band: str
    steps_per_s: str
    costs: list[Cost]
    best: tuple[str, str, str]
    parts: tuple[str, str, str]


@dataclass(frozen=True)
class ClockLine:
    """What the clock said of one contestant [ns], which clock it was, compile time [s] and memory [MiB]."""

    contestant: str
    unit: str
    figures: list[str]
    clock: str
    compiling: str
    memory: str
    finding: str


@dataclass(frozen=True)
class OddRuns:
    """Runs of one contestant that flew and are no plain results, and what was wrong with the first of them."""

    contestant: str
    count: int
    first: str
    last: str
    why: str


@dataclass(frozen=True)
class CostSection:
    """Everything the page says of one swept scene; what has nothing to show is empty or None."""

    scene: str
    title: str
    throws: int
    frontier: list[str]
    findings: list[str]
    chart: CostChart | None
    legend: list[LegendGroup]
    wholes: str
    reference: str
    turns: bool
    targets: list[str]
    lines: list[Line]
    absent: list[standings.Line]
    odd: list[OddRuns]
    measured: list[str]
    clock: list[ClockLine]


@dataclass(frozen=True)
class Swept:
    """The rows of one swept scene; of many throws a run's error is their median, and its time that of one of them.

    last_s: the time of the last sample [s], where the scene was also compared; spread: how the errors of many throws
    spread, by contestant with its tolerance and step.
    """

    scene: str
    row: SceneRow | None
    last_s: float | None
    runs: list[RunRow]
    spread: dict[tuple[str, float], ThrowsRow]
    digits: list[DigitRow]
    orders: dict[str, OrderRow]
    same: list[SameRow]
    clock: list[ClockRow]

    @cached_property
    def flown(self) -> dict[str, list[RunRow]]:
        """The runs that have an error and a time, by contestant, the tolerances of an adaptive one together."""
        found: dict[str, list[RunRow]] = {}
        for run in self.runs:
            if run.max_error_m is not None and timed(run):
                found.setdefault(untuned(run), []).append(run)
        return found

    @cached_property
    def plain(self) -> dict[str, list[RunRow]]:
        """Of these the plain results, the cheapest first."""
        found = {
            name: sorted((run for run in runs if run.status == "ok"), key=lambda run: run.wall_s or 0.0)
            for name, runs in self.flown.items()
        }
        return {name: runs for name, runs in found.items() if runs}

    @cached_property
    def wholes(self) -> list[str]:
        """The contestants that take a flight in one step."""
        return [contestant(row) for row in self.clock if row.unit == "flight" and contestant(row) == untuned(row)]

    @cached_property
    def frontiers(self) -> list[list[RunRow]]:
        """The frontier of all contestants; where some take a flight in one step, also that of all others.

        One contestant alone is on no frontier.
        """
        if len(self.plain) < 2:
            return []
        stepping = {name: runs for name, runs in self.plain.items() if name not in self.wholes}
        return [lower_left(own) for own in ([self.plain] if stepping == self.plain else [self.plain, stepping]) if own]

    @cached_property
    def integrators(self) -> list[tuple[str, ...]]:
        """The groups of contestants that are one integrator."""
        return joined((row.contestant_a, row.contestant_b) for row in self.same)

    @property
    def throws(self) -> int:
        """How many throws each run is of."""
        return next((row.throws for row in self.spread.values()), 1)

    @property
    def reference(self) -> str:
        """The contestant that ratios are over, nobody where one is alone."""
        return self.digits[0].reference if len(set(map(contestant, self.digits))) > 1 else ""

    @property
    def turns(self) -> bool:
        """Whether any error has a part from attitude."""
        return any(row.attitude_m for row in self.orders.values())


def sections(tables: Tables, colours: dict[str, str]) -> list[CostSection]:
    """Return one section a swept scene."""
    return [section(swept(tables, scene), colours, machine(tables)) for scene in tables.swept_scenes]


def swept(tables: Tables, scene: str) -> Swept:
    """Return one scene's rows."""
    spread = {(contestant(row), row.dt_s): row for row in tables.sweep_throws if row.scene == scene}
    return Swept(
        scene,
        next((row for row in tables.scenes if row.scene == scene), None),
        max((row.t_s for row in tables.errors_over_time if row.scene == scene), default=None),
        [of_one_throw(row, spread) for row in tables.sweep_runs if row.scene == scene],
        spread,
        [row for row in tables.sweep_digits if row.scene == scene],
        {contestant(row): row for row in tables.sweep_orders if row.scene == scene},
        [row for row in tables.sweep_same if row.scene == scene],
        [row for row in tables.sweep_clock if row.scene == scene],
    )


def of_one_throw(run: RunRow, spread: dict[tuple[str, float], ThrowsRow]) -> RunRow:
    """Return a run of many throws as that of the median one: its error, and its share of the time."""
    throws = next((row.throws for row in spread.values()), 1)
    errors = spread.get((contestant(run), run.dt_s))
    return replace(
        run,
        max_error_m=errors.median_error_m if errors else run.max_error_m,
        wall_s=None if run.wall_s is None else run.wall_s / throws,
        wall_ns_per_step=None if run.wall_ns_per_step is None else run.wall_ns_per_step / throws,
    )


def machine(tables: Tables) -> str:
    """Return the name of the machine that the times were measured on."""
    return next((row.value for row in tables.conditions if row.what == "processor"), "an unnamed machine")


def section(sweep: Swept, colours: dict[str, str], processor: str) -> CostSection:
    """Return one scene's section."""
    legend = legend_groups(sweep, colours)
    strokes = {name: stroke for group in legend for name, stroke in group.strokes.items()}
    return CostSection(
        sweep.scene,
        sweep.row.title if sweep.row and sweep.row.title else sweep.scene,
        sweep.throws,
        frontier_said(sweep),
        [*integrators_said(sweep), *first_order_said(sweep)],
        cost_chart(sweep.flown, sweep.spread, strokes, sweep.frontiers),
        legend,
        listed(sweep.wholes) if sweep.wholes else "",
        sweep.reference,
        sweep.turns,
        [power_of_ten(target_m) for target_m in dict.fromkeys(row.target_m for row in sweep.digits)],
        lines(sweep),
        standings.lines([run for run in sweep.runs if run.steps is None], ()),
        odd_runs(sweep),
        measured(sweep, processor),
        [clock_line(row) for row in sweep.clock],
    )


def timed(run: RunRow) -> bool:
    """Whether the clock gave the run a time."""
    return run.wall_s is not None and 0 < run.wall_s < math.inf


def lower_left(runs: dict[str, list[RunRow]]) -> list[RunRow]:
    """Return the runs of all contestants that no cheaper run equals, the cheapest first."""
    kept: list[RunRow] = []
    for run in sorted((run for own in runs.values() for run in own), key=lambda run: (run.wall_s or 0.0, error_m(run))):
        if not kept or error_m(run) < error_m(kept[-1]):
            kept.append(run)
    return kept


def frontier_said(sweep: Swept) -> list[str]:
    """Return who is on the frontier, and who is when those that do not step stand aside."""
    said = []
    for place, frontier in enumerate(sweep.frontiers):
        where = f"At errors of {power_of_ten(TARGETS_M[0])} m and below" if reaches(frontier) else "At every error"
        among = f" and among those that step, without {listed(sweep.wholes)}," if place else ""
        said.append(f"{where}{among} nobody is cheaper than {listed(leaders(frontier))}.")
    return said


def reaches(frontier: Sequence[RunRow]) -> bool:
    """Whether a frontier comes down to the first of the errors to reach."""
    return error_m(frontier[-1]) <= TARGETS_M[0]


def leaders(frontier: Sequence[RunRow]) -> list[str]:
    """Return the contestants of a frontier: where it comes down to the errors to reach, those of that part."""
    coarsest = TARGETS_M[0] if reaches(frontier) else math.inf
    return list(dict.fromkeys(untuned(run) for run in frontier if error_m(run) <= coarsest))


def integrators_said(sweep: Swept) -> list[str]:
    """Return which contestants are one integrator, and how many integrators there are then."""
    said = []
    for members in sweep.integrators:
        pairs = [row for row in sweep.same if row.contestant_a in members]
        apart, steps = max(row.furthest_apart_m for row in pairs), [row.steps_compared for row in pairs]
        said.append(
            f"{listed(list(members))} are one integrator: the same vertices to {figure(apart)} m at each of the "
            f"{spanned(steps)} steps where their error stands clear of the truth's limit."
        )
    if said:
        modes = len(sweep.plain)
        curves = modes - sum(len(members) - 1 for members in sweep.integrators)
        said.append(
            f"So the {modes} engine modes on the chart are {counted(curves, 'curve')} of error against step; those of "
            f"one integrator stand side by side, apart only by what a step costs."
        )
    return said


def first_order_said(sweep: Swept) -> list[str]:
    """Return in which first-order contestants most of the corner error is translation, and in which attitude."""
    if sweep.throws > 1:
        return []  # the parts are of the worst throw, the errors of the median one
    first = {name: row for name, row in sweep.orders.items() if name in sweep.plain and is_first_order(row)}
    said = []
    for what in ("translation", "attitude"):
        shares = {name: getattr(row, f"{what}_m") / error_at(sweep, name, row.dt_s) for name, row in first.items()}
        mostly = [name for name, share in shares.items() if share > 0.5]
        if mostly:
            percent = spanned([round(100 * shares[name]) for name in mostly])
            why = fall(sweep, [first[name] for name in mostly]) if what == "translation" else ""
            said.append(
                f"Of first order, with most of the corner error from {what}, {percent} %{why}: {listed(mostly)}."
            )
    return said


def is_first_order(row: OrderRow) -> bool:
    """Whether a contestant's errors fall as the step does, all along."""
    return all(order is not None and abs(order - 1) <= FIRST_ORDER for order in (row.order_low, row.order_high))


def error_at(sweep: Swept, name: str, dt_s: float) -> float:
    """Return a contestant's largest vertex error at one step [m]."""
    return next(error_m(run) for run in sweep.plain[name] if run.dt_s == dt_s)


def fall(sweep: Swept, rows: Sequence[OrderRow]) -> str:
    """Return that the translation of these is g h T/2, where gravity alone acts and all fall by one such error."""
    if sweep.row is None or sweep.last_s is None or set(FORCES) & set(sweep.row.needs.split(", ")) != {"gravity"}:
        return ""
    implied = [2 * row.translation_m / (row.dt_s * sweep.last_s) for row in rows]
    if max(implied) > (1 + SAME_FALL) * min(implied):
        return ""
    return f", which is g h T/2 at the step h with g = {figure(max(implied))} m/s²"


def spanned(counts: Sequence[int]) -> str:
    """Return one count, or from the least to the largest."""
    return str(counts[0]) if len(set(counts)) == 1 else f"{min(counts)} to {max(counts)}"


def lines(sweep: Swept) -> list[Line]:
    """Return the lines of the table, who is cheapest at the first error first."""
    digits: dict[str, list[DigitRow]] = {}
    for row in sweep.digits:
        digits.setdefault(contestant(row), []).append(row)
    ranked = sorted(digits, key=lambda name: [row.flight_us or math.inf for row in digits[name]])
    return [line(sweep, name, digits[name]) for name in ranked]


def line(sweep: Swept, name: str, digits: Sequence[DigitRow]) -> Line:
    """Return one contestant's line."""
    order, band, parts = order_cells(sweep.orders.get(name))
    return Line(
        name,
        order,
        band,
        next((figure(1e9 / row.ns) for row in sweep.clock if contestant(row) == name and row.unit == "step"), ""),
        [cost(sweep, row) for row in digits],
        best(sweep, name),
        parts,
    )


def order_cells(row: OrderRow | None) -> tuple[str, str, tuple[str, str, str]]:
    """Return the order, its band and the parts of the error; an adaptive method has no order."""
    if row is None:
        return "", "", ("", "", "")
    parts = figure(row.attitude_m), figure(row.translation_m), f"{figure(row.dt_s)} s"
    if row.order is None or row.order_low is None or row.order_high is None:
        return "", "", parts
    return fixed(row.order, 2), f"{fixed(row.order_low, 2)} to {fixed(row.order_high, 2)}", parts


def cost(sweep: Swept, row: DigitRow) -> Cost:
    """Return the cell of one target."""
    if row.flight_us is None:
        return Cost(row.verdict, "", "", False)
    at_target = [other for other in sweep.digits if other.target_m == row.target_m]
    least = row.flight_us == min(other.flight_us for other in at_target if other.flight_us is not None)
    reached = any(contestant(other) == sweep.reference and other.flight_us is not None for other in at_target)
    unsaid = "passes disagree" if reached else ""
    ratio = unsaid if row.ratio is None or not sweep.reference else f"{TIMES} {figure(row.ratio)}"
    time = at_most(row.flight_us) if row.verdict == "at most" else figure(row.flight_us)
    return Cost(time, ratio, "" if row.dt_s is None else f"{figure(row.dt_s)} s", least)


def best(sweep: Swept, name: str) -> tuple[str, str, str]:
    """Return a contestant's least error, whether smaller steps would pay, and where that was."""
    if name not in sweep.plain:
        return "", "no plain run", ""
    run, order = min(sweep.plain[name], key=error_m), sweep.orders.get(name)
    if run.limit_m is not None and error_m(run) <= run.limit_m:
        return at_most(run.limit_m), "the truth's limit", setting(run)
    trend = "" if order is None else "bends at" if order.bends else "still falling at"
    return figure(error_m(run)), trend, setting(run)


def odd_runs(sweep: Swept) -> list[OddRuns]:
    """Return the runs that flew and are no plain results, or have no time, by contestant and kind."""
    found: dict[tuple[str, str], list[RunRow]] = {}
    for run in sweep.runs:
        if run.steps is not None and (run.status != "ok" or not timed(run)):
            found.setdefault((untuned(run), standings.kind(run)), []).append(run)
    return [
        OddRuns(name, len(runs), setting(runs[0]), setting(runs[-1]), runs[0].status if kind != "ok" else "not timed")
        for (name, kind), runs in found.items()
    ]


def legend_groups(sweep: Swept, colours: dict[str, str]) -> list[LegendGroup]:
    """Return who is drawn: those on a frontier, each group that is one integrator, all others."""
    leading = {name for frontier in sweep.frontiers for name in leaders(frontier)}
    groups = [[name for name in sweep.flown if name in members] for members in sweep.integrators]
    rest = [name for name in sweep.flown if not any(name in group for group in groups)]
    captioned = [
        ("on the frontier", [name for name in rest if name in leading]),
        *(("one integrator", group) for group in groups),
        ("", [name for name in rest if name not in leading]),
    ]
    dashes = {name: striped(place, len(group)) for group in groups for place, name in enumerate(group)}
    shapes = shapes_of(sweep.flown)
    return [
        LegendGroup(
            caption,
            {name: Stroke(colours[name], dashes.get(name, ()), kind(sweep, name), shapes[name]) for name in names},
        )
        for caption, names in captioned
        if names
    ]


def shapes_of(runs: dict[str, list[RunRow]]) -> dict[str, str]:
    """Return one shape of points a contestant, for colours are close among the methods of one engine."""
    engines: dict[str, list[str]] = {}
    for name, (run, *_) in runs.items():
        engines.setdefault(run.engine, []).append(name)
    return {name: SHAPES[place % len(SHAPES)] for names in engines.values() for place, name in enumerate(names)}


def kind(sweep: Swept, name: str) -> str:
    """Return ok where any run of a contestant is plain, else what its first run was."""
    return "ok" if name in sweep.plain else standings.kind(sweep.flown[name][0])


def measured(sweep: Swept, processor: str) -> list[str]:
    """Return how the times were measured, on what, and what is not in them."""
    if not sweep.clock:
        return []
    called = [row.call_ns / 1e3 for row in sweep.clock if row.unit == "step"]
    calls = f" A call from Python costs {figure(min(called), 2)} to {figure(max(called), 2)} µs more." if called else ""
    ratios = (
        f"A ratio ({TIMES}) is over {sweep.reference}, of the same rounds; the tables have the interval that covers it "
        f"in 95 of 100 runs. "
        if sweep.reference
        else ""
    )
    return [
        f"Errors and times come from separate runs. A time is CPU time of the engine's native loop, in samples "
        f"of {given(SAMPLE_NS / 1e6)} ms or more taken round robin over all contestants, "
        f"{spanned([row.rounds for row in sweep.clock])} rounds; building, compiling, writing and reading states are "
        f"not in it.{calls} The lower decile is quoted: other work on the machine moves it least.",
        f"{ratios}Times are those of this machine, {processor}; those of another cannot be compared with them.",
    ]


def clock_line(row: ClockRow) -> ClockLine:
    """Return what the clock said of one contestant."""
    figures = [figure(getattr(row, name)) for name in NANOSECONDS]
    memory = f"{row.peak_bytes / 2**20:.0f}"
    return ClockLine(contestant(row), row.unit, figures, row.clock, figure(row.compile_s, 2), memory, row.finding)


def power_of_ten(target_m: float) -> str:
    """Return a target, all of which are powers of ten, as such."""
    return f"10{superscript(round(math.log10(target_m)))}"
