"""The chart of error over time: one Vega-Lite specification, written once and filled with each scene's curves.

Curves that are the same are striped: each contestant of a family paints its own share of the line.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cache, reduce

import altair as alt
import vl_convert
from markupsafe import Markup

from compare.results import ErrorOverTimeRow
from reports.numerals import SUPERSCRIPTS, at_most, figure
from reports.rows import contestant

STRIPE = 7.0
MARKS = 12
HEIGHT = 320
# A curve that leaves the plain ones this far behind leaves the chart too, so that they can still be told apart.
HEADROOM = 1e3

# A tick as 10 and its exponent in superscript: Vega's expressions can replace, so each sign is replaced in turn.
POWER_OF_TEN = "'10' + " + reduce(
    lambda text, sign: f"replace({text}, regexp('{sign}', 'g'), '{SUPERSCRIPTS[sign]}')",
    SUPERSCRIPTS,
    "toString(round(log(datum.value) / LN10))",
)


@dataclass(frozen=True)
class Stroke:
    """How a contestant is drawn: an SVG colour, a dash pattern, the kind of its status; only ok is plain."""

    colour: str
    dash: tuple[float, ...]
    kind: str

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
            "curves": [asdict(curve) for curve in self.curves],
            "limit": self.limit,
            "bottom": self.bottom,
            "top": self.top,
        }


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


def specification() -> dict:
    """Return the chart's Vega-Lite specification without data: a script fills in the tables `curves` and `limit`."""
    hidden, picked = alt.param(name="hidden", value=[]), alt.param(name="picked", value="")
    bottom, top = alt.param(name="bottom", value=1e-16), alt.param(name="top", value=1)
    time = alt.X("time:Q", title="time [s]", scale=alt.Scale(zero=True, nice=False), axis=alt.Axis(tickCount=8))
    error = alt.Y(
        "error:Q",
        title="largest vertex error [m]",
        scale=alt.Scale(type="log", domainMin=alt.ExprRef("bottom"), domainMax=alt.ExprRef("top"), nice=False),
        axis=alt.Axis(labelExpr=POWER_OF_TEN, tickCount=8),
    )
    limit = alt.Chart(alt.NamedData("limit")).transform_calculate(floor="bottom").encode(time)
    band = limit.mark_area(color="currentColor", opacity=0.09, clip=True).encode(alt.Y("limit:Q"), alt.Y2("floor:Q"))
    edge = limit.mark_line(color="currentColor", opacity=0.45, strokeWidth=1, clip=True).encode(alt.Y("limit:Q"))
    curves = (
        alt.Chart(alt.NamedData("curves"))
        .transform_filter("indexof(hidden, datum.contestant) < 0")
        .transform_flatten(["time", "error", "told", "marked"])
        .encode(
            time,
            error,
            alt.Color("colour:N", scale=None),
            alt.Detail("contestant:N"),
            opacity=alt.when("picked && picked != datum.contestant").then(alt.value(0.12)).otherwise(alt.value(1)),
        )
    )
    lines = curves.mark_line(strokeWidth=1.8, clip=True).encode(strokeDash=alt.StrokeDash("dash:N", scale=None))
    marks = (
        curves.transform_filter("datum.marked")
        .mark_point(clip=True, filled=False, strokeWidth=1.6)
        .encode(
            shape=alt.when("datum.plain").then(alt.value("circle")).otherwise(alt.value("M-1,-1L1,1M-1,1L1,-1")),
            size=alt.when("datum.plain").then(alt.value(14)).otherwise(alt.value(36)),
        )
    )
    touch = (
        curves.transform_calculate(words="datum.contestant + ' at ' + format(datum.time, '.6~r') + ' s: ' + datum.told")
        .mark_circle(opacity=0, size=160, clip=True)
        .encode(tooltip="words:N", opacity=alt.value(0))
    )
    whole = (
        alt.layer(band, edge, lines, marks, touch)
        .add_params(hidden, picked, bottom, top)
        .properties(width="container", height=HEIGHT)
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
    )
    return whole.to_dict()


@cache
def library() -> Markup:
    """Return Vega as a script that can stand inside a page; it leaves one name there, `vegaEmbed`."""
    script = vl_convert.javascript_bundle("window.vegaEmbed = vegaEmbed;")
    return Markup(script.replace("</script", "<\\/script").replace("<!--", "<\\!--"))
