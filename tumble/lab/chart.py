"""Error over time as a small chart: round lengths on its axis, and the instant that is shown."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from markupsafe import Markup

from tumble.reports.lengths import length
from tumble.reports.numerals import given
from tumble.scenarios.frames import Array

WIDTH, HEIGHT = 300, 190
LEFT, RIGHT, TOP, BOTTOM = 50, 290, 10, 166
POINTS = 100  # of a curve, at most
TICKS_Y, TICKS_X = 6, 5
INK, FAINT, RULE = "#1b2127", "#56616b", "#dfe3e7"


class Curve(NamedTuple):
    """times [s] and errors there [m], (S,), NaN where not known; colour and dash as SVG has them."""

    name: str
    times: Array
    errors: Array
    colour: str
    dash: str


class Frame(NamedTuple):
    """What the chart's sides stand for: the last instant [s], and decades of metres."""

    end: float
    low: int
    high: int

    def x(self, time: float) -> float:
        """Return where a time [s] is."""
        return LEFT + (RIGHT - LEFT) * time / self.end

    def y(self, metres: Array) -> Array:
        """Return where lengths are."""
        with np.errstate(divide="ignore", invalid="ignore"):
            decades = np.clip(np.log10(metres), self.low, self.high)
        return BOTTOM - (BOTTOM - TOP) * (decades - self.low) / (self.high - self.low)


def chart(times: Array, curves: Sequence[Curve], limit: Array, shown: int) -> str:
    """Return the chart as SVG: the resolution [m] at its times [s], (S,), curves, and the row that is shown."""
    frame = framed(times, [*(curve.errors for curve in curves), limit])
    if frame is None:
        return ""
    lines = [line(frame, times, limit, FAINT, "1 3", 1.2)]
    lines += [line(frame, curve.times, curve.errors, curve.colour, curve.dash, 1.8) for curve in curves]
    now_s = float(times[shown])
    at = frame.x(now_s)
    now = Markup('<line x1="{0}" x2="{0}" y1="{1}" y2="{2}" stroke="{3}" stroke-width="1"/>').format(
        f"{at:.1f}", TOP, BOTTOM, INK
    )
    dots = Markup("").join(dot(at, frame, curve, now_s) for curve in curves)
    names = ", ".join(curve.name for curve in curves)
    whole = Markup(
        '<svg viewBox="0 0 {0} {1}" width="100%" role="img" aria-label="Largest error over time: {2}" data-lab="chart" '
        'style="display:block;font-size:10px;fill:{3}">{4}{5}{6}{7}</svg>'
    )
    return str(whole.format(WIDTH, HEIGHT, names, FAINT, ruled(frame), Markup("").join(lines), now, dots))


def framed(times: Array, curves: Sequence[Array]) -> Frame | None:
    """Return the frame that all positive errors fit in, None where there is none."""
    known = np.concatenate([curve[1:] for curve in curves])
    known = known[np.isfinite(known) & (known > 0)]
    if not len(known) or len(times) < 2:
        return None
    low, high = math.floor(math.log10(known.min())), math.ceil(math.log10(known.max()))
    return Frame(float(times[-1]), low, max(high, low + 1))


def line(frame: Frame, times: Array, errors: Array, colour: str, dash: str, width: float) -> Markup:
    """Return a curve, which has gaps where nothing is known or nothing is wrong."""
    rows = np.unique(np.linspace(1, len(times) - 1, min(len(times) - 1, POINTS)).round().astype(int))
    heights = frame.y(np.where(errors[rows] > 0, errors[rows], np.nan))
    parts, pen = [], "M"
    for row, height in zip(rows.tolist(), heights.tolist(), strict=True):
        if math.isfinite(height):
            parts.append(f"{pen}{frame.x(float(times[row])):.1f} {height:.1f}")
            pen = "L"
        else:
            pen = "M"
    curve = Markup('<path d="{}" fill="none" stroke="{}" stroke-width="{}" stroke-dasharray="{}"/>')
    return curve.format("".join(parts), colour, width, dash)


def dot(x: float, frame: Frame, curve: Curve, time: float) -> Markup:
    """Return where a curve is at a time [s], nothing where that is not known."""
    row = int(np.searchsorted(curve.times, time * (1 + 1e-12), side="right")) - 1
    error = float(curve.errors[row]) if row >= 0 else math.nan
    if not (math.isfinite(error) and error > 0):
        return Markup("")
    y = float(frame.y(np.array(error)))
    return Markup('<circle cx="{}" cy="{}" r="3.2" fill="{}"/>').format(f"{x:.1f}", f"{y:.1f}", curve.colour)


def ruled(frame: Frame) -> Markup:
    """Return the lines and the words of both axes."""
    across = Markup('<line x1="{0}" x2="{1}" y1="{2}" y2="{2}" stroke="{3}"/><text x="{4}" y="{5}" {6}>{7}</text>')
    end = Markup('text-anchor="end"')
    parts = []
    for decade in ticks_y(frame.low, frame.high):
        y = float(frame.y(np.array(10.0**decade)))
        parts.append(
            across.format(LEFT, RIGHT, f"{y:.1f}", RULE, LEFT - 6, f"{y + 3.5:.1f}", end, length(10.0**decade))
        )
    down = Markup('<text x="{0}" y="{1}" text-anchor="{2}">{3}</text>')
    times = ticks_x(frame.end)
    for time in times:
        unit = " s" if time == times[-1] else ""
        side = "end" if frame.x(time) > RIGHT - 12 else "middle"
        parts.append(down.format(f"{frame.x(time):.1f}", BOTTOM + 15, side, f"{given(time)}{unit}"))
    return Markup("").join(parts)


def ticks_y(low: int, high: int) -> list[int]:
    """Return the decades that have a line: every one, or those of units (mm, um, nm) where there are many."""
    step = next(step for step in (1, 3, 6, 12, 300) if (high - low) / step <= TICKS_Y)
    return [decade for decade in range(low, high + 1) if decade % step == 0]


def ticks_x(end: float) -> list[float]:
    """Return round times from 0 to the end [s]."""
    power = 10.0 ** math.floor(math.log10(end / TICKS_X))
    step = next(step * power for step in (1, 2, 5, 10) if end / (step * power) <= TICKS_X)
    return [round(number * step, 12) for number in range(math.floor(end / step * (1 + 1e-9)) + 1)]
