"""Small charts for a terminal, one line a contestant on a logarithmic scale; never in a pipe."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from rich.table import Table
from rich.text import Text

from tumble.compare.comparison.findings import error_m
from tumble.compare.engines import OWN
from tumble.compare.stability.schemas import LimitRow
from tumble.compare.sweep.schemas import AccuracyCostRow
from tumble.compare.tables.shared import RunRow
from tumble.reports.lengths import length
from tumble.reports.rows import contestant
from tumble.reports.terminal import LIST_WIDTH, columns, plain

# Colour of a status or a verdict; the others have none.
COLOURS = {
    "flagged": "yellow", "clamped": "yellow", "frozen": "yellow", "reset": "yellow", "under-rotated": "yellow",
    "lost-torque": "yellow", "drifting": "yellow", "diverged": "red", "crashed": "red", "timeout": "red",
    "no-return": "red",
}  # fmt: skip
GOOD, PLAIN = "green", "cyan"
HEAD = "contestant"
MOST_LINES = 12
TARGET_SIGNS = {1e-3: "m", 1e-6: "µ", 1e-9: "n", 1e-12: "p"}
MICRO = (("s", 1e6), ("ms", 1e3), ("us", 1.0), ("ns", 1e-3))


@dataclass(frozen=True)
class Ruler:
    """A logarithmic scale from low to high over so many columns of text."""

    low: float
    high: float
    width: int

    def column(self, value: float) -> int:
        """Return the column of a value, the first or the last if it is off the scale."""
        share = math.log(value / self.low) / math.log(self.high / self.low) if value > 0 else 0.0
        return min(self.width - 1, max(0, round(share * (self.width - 1)))) if math.isfinite(share) else self.width - 1

    def line(self, end: float | None, marks: Mapping[float, str], colour: str) -> Text:
        """Return a line up to a value, and marks on it."""
        cells = [" "] * self.width
        if end is not None:
            cells[: self.column(end) + 1] = "━" * (self.column(end) + 1)
        for value, sign in marks.items():
            cells[self.column(value)] = sign
        return Text("".join(cells).rstrip(), style=colour)


def ruler(values: Sequence[float], names: Iterable[str], beside: int) -> Ruler:
    """Return a scale for these values, as wide as a line less the names and `beside` other columns."""
    width = max(16, LIST_WIDTH - max(map(len, (HEAD, *names))) - beside)
    low, high = min(values), max(values)
    return Ruler(low / 2, max(high, 10 * low) * 1.05, width)


def word_colour(word: str) -> str:
    """Return the colour of a status or a verdict."""
    return COLOURS.get(word, "")


def coloured(word: str) -> Text:
    """Return a status or a verdict in its colour."""
    return Text(word, style=word_colour(word))


def error_chart(runs: Sequence[RunRow]) -> Iterator[Table | Text]:
    """Yield the error of each engine's first and most accurate method, the most accurate first."""
    finished = sorted((run for run in runs if math.isfinite(error_m(run)) and error_m(run) > 0), key=error_m)
    first = {engine: next(run for run in runs if run.engine == engine) for engine in {run.engine for run in runs}}
    best = {engine: next((run for run in finished if run.engine == engine), None) for engine in first}
    shown = [run for run in finished if run in (first[run.engine], best[run.engine])][-MOST_LINES:]
    if len(shown) < 2:
        return
    scale = ruler([error_m(run) for run in shown], map(contestant, shown), 12)
    table = columns(HEAD, "largest error", "", right=(2,))
    for run in shown:
        exact = (run.max_error_m or 0.0) <= (run.resolution_m or 0.0)
        colour = word_colour(run.status) or (GOOD if exact else PLAIN)
        text = f"≤{length(error_m(run))}" if exact else length(error_m(run))
        table.add_row(plain(contestant(run)), scale.line(error_m(run), {}, colour), Text(text, style=colour))
    yield table
    yield Text()


def cost_chart(digits: Sequence[AccuracyCostRow]) -> Iterator[Table | Text]:
    """Yield the time in which each reaches 1 mm, 1 µm, 1 nm and 1 pm."""
    reached: dict[str, dict[float, str]] = {}
    for row in sorted(digits, key=lambda row: row.run_us or math.inf):
        if row.run_us is not None and row.target_m in TARGET_SIGNS:
            # Of errors reached in the same time the smallest is shown.
            reached.setdefault(contestant(row), {})[row.run_us] = TARGET_SIGNS[row.target_m]
    if not reached:
        return
    times = [time for marks in reached.values() for time in marks]
    scale = ruler(times, reached, 2)
    table = columns(HEAD, f"{micro(scale.low)} to {micro(scale.high)} a run")
    for name, marks in reached.items():
        table.add_row(plain(name), scale.line(None, marks, GOOD if name.startswith(f"{OWN}:") else PLAIN))
    yield table
    yield plain("m, µ, n, p: time to reach 1 mm, 1 µm, 1 nm, 1 pm; further left is faster")
    yield Text()


def limit_chart(limits: Sequence[LimitRow]) -> Iterator[Table | Text]:
    """Yield the largest stable step of each, beside theory."""
    known = [row for row in limits if row.w_dt_limit]
    finite = [row.w_dt_limit for row in known if row.w_dt_limit and math.isfinite(row.w_dt_limit)]
    if not finite:
        return
    theories = [row.theory_w_dt for row in known if row.theory_w_dt and math.isfinite(row.theory_w_dt)]
    scale = ruler([*finite, *theories], map(contestant, known), 10)
    table = columns(HEAD, "largest stable w dt, | by theory", "", right=(2,))
    for row in sorted(known, key=lambda row: -(row.w_dt_limit or 0.0)):
        assert row.w_dt_limit is not None
        endless = math.isinf(row.w_dt_limit)
        theory = {row.theory_w_dt: "|"} if row.theory_w_dt and math.isfinite(row.theory_w_dt) else {}
        colour = GOOD if endless else word_colour(row.beyond) or PLAIN
        text = "no limit" if endless else f"{row.w_dt_limit:.3g}"
        table.add_row(plain(contestant(row)), scale.line(row.w_dt_limit, theory, colour), Text(text, style=colour))
    yield table
    yield Text()


def micro(time_us: float) -> str:
    """Return a time in two digits and the unit that suits it."""
    unit, size = next(((unit, size) for unit, size in MICRO if time_us >= size), MICRO[-1])
    return f"{float(f'{time_us / size:.2g}'):g} {unit}"
