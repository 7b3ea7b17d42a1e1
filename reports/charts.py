"""The charts of error over time and of error against run time: a Vega-Lite specification each, written once.

Each is filled with each scene's curves.  Contestants that are the same are striped: each of a family paints its own
share of the line.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cache, reduce
from typing import Any

import altair as alt
import vl_convert
from markupsafe import Markup

from compare.comparison.results import ErrorOverTimeRow
from compare.sweep.frontier import ThrowsRow
from compare.tables.rows import RunRow
from reports.numerals import SUPERSCRIPTS, at_most, counted, figure
from reports.rows import contestant, error_m, setting

STRIPE = 7.0
MARKS = 12
HEIGHT, COST_HEIGHT = 320, 480
NOT_HIDDEN = "indexof(hidden, datum.contestant) < 0"
# How the truth's limit is drawn: what is below it, and its edge.
BAND: dict[str, Any] = {"color": "currentColor", "opacity": 0.09, "clip": True}
EDGE: dict[str, Any] = {"color": "currentColor", "opacity": 0.45, "strokeWidth": 1, "clip": True}
CROSS = "M-1,-1L1,1M-1,1L1,-1"
SHAPES = (
    "M-1,0A1,1,0,1,1,1,0A1,1,0,1,1,-1,0Z",
    "M-.9,-.9L.9,-.9L.9,.9L-.9,.9Z",
    "M0,-1.1L1.1,.9L-1.1,.9Z",
    "M0,-1.3L1,0L0,1.3L-1,0Z",
    "M0,1.1L1.1,-.9L-1.1,-.9Z",
    "M-1,-1L1,-1L-1,1L1,1Z",
)
# A curve that leaves the plain ones this far behind leaves the chart too, so that they can still be told apart.
HEADROOM = 1e3

# A tick as 10 and its exponent in superscript, only at powers of ten: Vega's expressions can replace, so each sign is
# replaced in turn.
EXPONENT = "round(log(datum.value) / LN10)"
POWER_OF_TEN = f"abs(log(datum.value) / LN10 - {EXPONENT}) > 1e-9 ? '' : '10' + " + reduce(
    lambda text, sign: f"replace({text}, regexp('{sign}', 'g'), '{SUPERSCRIPTS[sign]}')",
    SUPERSCRIPTS,
    f"toString({EXPONENT})",
)


@dataclass(frozen=True)
class Stroke:
    """How a contestant is drawn: an SVG colour, a dash pattern, the kind of its status; only ok is plain.

    shape: the SVG path of its points, two units wide about the origin, where contestants are told apart by that.
    """

    colour: str
    dash: tuple[float, ...]
    kind: str
    shape: str = ""

    @property
    def plain(self) -> bool:
        """Whether its curve is a plain result."""
        return self.kind == "ok"


@dataclass(frozen=True)
class Curve:
    """One contestant: error [m] at times [s], lifted to the limit where below it, and what to say at each point."""

    contestant: str
    colour: str
    dash: tuple[float, ...]
    plain: bool
    time: list[float]
    error: list[float]
    told: list[str]
    marked: list[bool]


@dataclass(frozen=True)
class Chart:
    """What fills the specification for one scene: the curves, the limit over time, the range shown [m]."""

    curves: list[Curve]
    limit: list[dict[str, float]]
    bottom: float
    top: float
    cut: bool

    @property
    def filling(self) -> dict:
        """What the page's script puts into the specification."""
        return {
            "datasets": {"curves": [asdict(curve) for curve in self.curves], "limit": self.limit},
            "signals": {"bottom": self.bottom, "top": self.top},
        }


@dataclass(frozen=True)
class CostCurve:
    """One contestant: native time of a flight [us], error [m] lifted to the limit, and what to say, run by run."""

    contestant: str
    colour: str
    dash: tuple[float, ...]
    shape: str
    plain: list[bool]
    time: list[float]
    error: list[float]
    told: list[str]


@dataclass(frozen=True)
class CostChart:
    """What fills the specification for one swept scene: curves, the limit [m], frontiers, and the ranges shown.

    spread: where there are many throws, between which errors [m] 90 % of them are, for each plain run.
    """

    curves: list[CostCurve]
    spread: list[dict[str, Any]]
    limit: list[dict[str, float]]
    frontier: list[dict[str, float]]
    signals: dict[str, float]
    beyond: int

    @property
    def filling(self) -> dict:
        """What the page's script puts into the specification."""
        curves = [asdict(curve) for curve in self.curves]
        datasets = {"curves": curves, "spread": self.spread, "limit": self.limit, "frontier": self.frontier}
        return {"datasets": datasets, "signals": self.signals}


def striped(place: int, size: int) -> tuple[float, ...]:
    """Return the dashes with which member number `place` of a family of `size` paints its share of one line."""
    return (0.0, STRIPE * place, STRIPE, STRIPE * (size - 1 - place)) if size > 1 else ()


def chart(rows: Sequence[ErrorOverTimeRow], strokes: Mapping[str, Stroke]) -> Chart | None:
    """Return the chart of one scene's rows, or None where no error can be put on a log scale."""
    seen: dict[str, list[ErrorOverTimeRow]] = {}
    for row in rows:
        if math.isfinite(row.error_m) and max(row.error_m, row.limit_m) > 0:
            seen.setdefault(contestant(row), []).append(row)
    if not seen:
        return None
    limits = {row.t_s: row.limit_m for name in seen for row in seen[name] if row.limit_m > 0}
    plain = [row.error_m for name in seen if strokes[name].plain for row in seen[name]]
    highest = max(max(row.error_m, row.limit_m) for name in seen for row in seen[name])
    lowest = min(limits.values()) if limits else min(row.error_m for own in seen.values() for row in own if row.error_m)
    top = min(highest, max([*plain, *limits.values()]) * HEADROOM) if plain else highest
    return Chart(
        [curve(name, own, strokes[name]) for name, own in seen.items()],
        [{"time": time, "limit": limits[time]} for time in sorted(limits)],
        lowest / 3,
        top * 2,
        highest > top,
    )


def curve(name: str, rows: Sequence[ErrorOverTimeRow], stroke: Stroke) -> Curve:
    """Return one contestant's curve."""
    every = math.ceil(len(rows) / MARKS)
    return Curve(
        name,
        stroke.colour,
        stroke.dash,
        stroke.plain,
        [row.t_s for row in rows],
        [float(f"{max(row.error_m, row.limit_m):.4g}") for row in rows],
        [
            f"{at_most(row.limit_m)} m, the limit" if row.error_m <= row.limit_m else f"{figure(row.error_m)} m"
            for row in rows
        ],
        [(len(rows) - 1 - number) % every == 0 for number in range(len(rows))],
    )


def cost_chart(
    runs: Mapping[str, Sequence[RunRow]],
    spread: Mapping[tuple[str, float], ThrowsRow],
    strokes: Mapping[str, Stroke],
    frontiers: Sequence[Sequence[RunRow]],
) -> CostChart | None:
    """Return the chart of one scene's runs, contestant -> runs that are timed, or None where none is a plain result.

    spread: how the errors of many throws spread, by contestant with its tolerance and step.
    """
    curves = [cost_curve(name, own, strokes[name]) for name, own in runs.items()]
    plain = [point for curve in curves for point in zip(curve.time, curve.error, curve.plain, strict=True) if point[2]]
    if not plain:
        return None
    limits = [run.limit_m for own in runs.values() for run in own if run.limit_m]
    left, right = min(time for time, _, _ in plain) / 2, max(time for time, _, _ in plain) * 2
    bottom, top = min([*limits, *(error for _, error, _ in plain)]) / 10, max(error for _, error, _ in plain) * 3
    return CostChart(
        curves,
        [
            spread_of(name, run, strokes[name].colour, spread[contestant(run), run.dt_s])
            for name, own in runs.items()
            for run in own
            if (contestant(run), run.dt_s) in spread
        ],
        [{"limit": max(limits)}] if limits else [],
        [corner for number, own in enumerate(frontiers) for corner in staircase(number, own, right, top)],
        {"bottom": bottom, "top": top, "left": left, "right": right},
        sum(len(own) for own in runs.values()) - sum(error <= top for curve in curves for error in curve.error),
    )


def spread_of(name: str, run: RunRow, colour: str, errors: ThrowsRow) -> dict[str, Any]:
    """Return one run's part of its contestant's band."""
    ends = {"low": float(f"{errors.p5_error_m:.4g}"), "high": float(f"{errors.p95_error_m:.4g}")}
    return {"contestant": name, "colour": colour, "time": float(f"{microseconds(run):.4g}"), **ends}


def cost_curve(name: str, runs: Sequence[RunRow], stroke: Stroke) -> CostCurve:
    """Return one contestant's curve; runs whose error is no number have no place on it."""
    shown = [run for run in runs if 0 < error_m(run) < math.inf]
    return CostCurve(
        name,
        stroke.colour,
        stroke.dash,
        stroke.shape,
        [run.status == "ok" for run in shown],
        [float(f"{microseconds(run):.4g}") for run in shown],
        [float(f"{error_m(run):.4g}") for run in shown],
        [cost_told(run) for run in shown],
    )


def microseconds(run: RunRow) -> float:
    """Return the native time of a run's flight [us]."""
    return (run.wall_s or 0.0) * 1e6


def cost_told(run: RunRow) -> str:
    """Return what is said of one run: its step or tolerance, error, time, steps, and a status that is not ok."""
    error, limit = run.max_error_m or 0.0, run.limit_m or 0.0
    said = f"{setting(run)}: {at_most(limit) if error <= limit else figure(error)} m in {figure(microseconds(run))} µs"
    if "@" not in run.method:
        said += f", {counted(run.steps or 0, 'step')} of {figure(run.wall_ns_per_step or 0.0)} ns"
    return said if run.status == "ok" else f"{said}; {run.status}"


def staircase(number: int, runs: Sequence[RunRow], right: float, top: float) -> list[dict[str, float]]:
    """Return the corners of the line that no run is below and left of, from the top to the right edge."""
    corners = [(microseconds(run), error_m(run)) for run in runs]
    ends = [(corners[0][0], top), *corners, (right, corners[-1][1])]
    return [{"number": number, "time": time, "error": error} for time, error in ends]


def error_over_time() -> dict:
    """Return the specification of error over time: a script fills in the tables `curves` and `limit`."""
    time = alt.X("time:Q", title="time [s]", scale=alt.Scale(zero=True, nice=False), axis=alt.Axis(tickCount=8))
    limit = alt.Chart(alt.NamedData("limit")).transform_calculate(floor="bottom").encode(time)
    band = limit.mark_area(**BAND).encode(alt.Y("limit:Q"), alt.Y2("floor:Q"))
    edge = limit.mark_line(**EDGE).encode(alt.Y("limit:Q"))
    shown = curves(time, "time", "error", "told", "marked")
    words = "datum.contestant + ' at ' + format(datum.time, '.6~r') + ' s: ' + datum.told"
    points = marks(shown.transform_filter("datum.marked"), alt.value("circle"), 14)
    layers = band, edge, lines(shown), points, touch(shown, words)
    return whole(layers, HEIGHT, ["bottom", "top"])


def error_against_run_time() -> dict:
    """Return the specification of error against run time: tables `curves`, `limit` and `frontier` are filled in.

    Only plain runs are joined.
    """
    time = alt.X("time:Q", title="native time of the flight [µs]", scale=log_scale("left", "right"), axis=log_axis())
    limit = alt.Chart(alt.NamedData("limit")).transform_calculate(floor="bottom")
    band = limit.mark_rect(**BAND).encode(alt.Y("limit:Q"), alt.Y2("floor:Q"))
    edge = limit.mark_rule(**EDGE).encode(alt.Y("limit:Q"))
    frontier = (
        alt.Chart(alt.NamedData("frontier"))
        .mark_line(color="currentColor", opacity=0.16, strokeWidth=7, interpolate="step-after", clip=True)
        .encode(time, alt.Y("error:Q"), alt.Detail("number:N"), alt.Order("time:Q"))
    )
    spread = (
        alt.Chart(alt.NamedData("spread"))
        .transform_filter(NOT_HIDDEN)
        .mark_area(opacity=0.18, clip=True)
        .encode(time, alt.Y("low:Q"), alt.Y2("high:Q"), alt.Color("colour:N", scale=None), alt.Detail("contestant:N"))
    )
    shown = curves(time, "time", "error", "told", "plain")
    words = "datum.contestant + ', ' + datum.told"
    joined, points = lines(shown.transform_filter("datum.plain")), marks(shown, alt.Shape("shape:N", scale=None), 26)
    layers = band, edge, frontier, spread, joined, points, touch(shown, words)
    return whole(layers, COST_HEIGHT, ["bottom", "top", "left", "right"])


SPECIFICATIONS = {"error-over-time": error_over_time, "error-against-run-time": error_against_run_time}


def log_scale(least: str, most: str) -> alt.Scale:
    """Return a log scale between two signals."""
    return alt.Scale(type="log", domain=[alt.ExprRef(least), alt.ExprRef(most)], nice=False)


def log_axis() -> alt.Axis:
    """Return an axis that says powers of ten."""
    return alt.Axis(labelExpr=POWER_OF_TEN, tickCount=8)


def curves(time: alt.X, *lists: str) -> alt.Chart:
    """Return the contestants that are not hidden, point by point; all but the one that is picked are faint."""
    error = alt.Y("error:Q", title="largest vertex error [m]", scale=log_scale("bottom", "top"), axis=log_axis())
    return (
        alt.Chart(alt.NamedData("curves"))
        .transform_filter(NOT_HIDDEN)
        .transform_flatten([*lists])
        .encode(
            time,
            error,
            alt.Color("colour:N", scale=None),
            alt.Detail("contestant:N"),
            opacity=alt.when("picked && picked != datum.contestant").then(alt.value(0.12)).otherwise(alt.value(1)),
        )
    )


def lines(shown: alt.Chart) -> alt.Chart:
    """Return the lines that join the points."""
    return shown.mark_line(strokeWidth=1.8, clip=True).encode(strokeDash=alt.StrokeDash("dash:N", scale=None))


def marks(shown: alt.Chart, shape: Any, size: float) -> alt.Chart:
    """Return the points: of that shape and size [px2], but crosses where the result is not plain."""
    return shown.mark_point(clip=True, filled=False, strokeWidth=1.4).encode(
        shape=alt.when("datum.plain").then(shape).otherwise(alt.value(CROSS)),
        size=alt.when("datum.plain").then(alt.value(size)).otherwise(alt.value(36)),
    )


def touch(shown: alt.Chart, words: str) -> alt.Chart:
    """Return what is touched to read a point, with an expression for its words."""
    return (
        shown.transform_calculate(words=words)
        .mark_circle(opacity=0, size=160, clip=True)
        .encode(tooltip="words:N", opacity=alt.value(0))
    )


def whole(layers: Sequence[alt.Chart], height: int, ranges: Sequence[str]) -> dict:
    """Return a specification of layers, with signals for what is hidden and picked and for the ranges shown."""
    hidden, picked = alt.param(name="hidden", value=[]), alt.param(name="picked", value="")
    return (
        alt.layer(*layers)
        .add_params(hidden, picked, *(alt.param(name=name, value=1) for name in ranges))
        .properties(width="container", height=height)
        .configure(background="transparent", font="system-ui, sans-serif", aria=False)
        .configure_view(stroke=None)
        .configure_axis(
            labelColor="currentColor",
            titleColor="currentColor",
            gridColor="currentColor",
            gridOpacity=0.1,
            domainColor="currentColor",
            domainOpacity=0.3,
            tickColor="currentColor",
            tickOpacity=0.3,
            labelFontSize=12,
            titleFontSize=12,
            titleFontWeight="normal",
        )
        .to_dict()
    )


@cache
def library() -> Markup:
    """Return Vega as a script that can stand inside a page; it leaves one name there, `vegaEmbed`."""
    script = vl_convert.javascript_bundle("window.vegaEmbed = vegaEmbed;")
    return Markup(script.replace("</script", "<\\/script").replace("<!--", "<\\!--"))
