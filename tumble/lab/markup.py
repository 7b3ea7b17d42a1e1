"""The screen's numbers as HTML.  All text that comes from a file is text: it is escaped by the template."""

import math
from collections.abc import Mapping, Sequence

import numpy as np
from markupsafe import Markup

from tumble.lab.foreign import Foreign
from tumble.lab.looks import Look
from tumble.lab.pool import Contestant
from tumble.lab.readings import ErrorRow, Reading
from tumble.reports.lengths import unit_of
from tumble.reports.numerals import fixed, given
from tumble.scenarios.format import visible

STYLE = Markup("font-size:12px;line-height:1.45;font-variant-numeric:tabular-nums;padding:2px 10px 6px")
FAINT = Markup("color:#56616b")
GOOD, BAD = Markup("color:#0f6b3f"), Markup("color:#b3261e")
# Two lines are always there: a longer message must not move the buttons below it from under the pointer.
TWO_LINES = Markup("font-size:13px;min-height:calc(2.9em + 8px)")
FITTING = 8  # characters of a number of which three stand beside a name


def status_line(line: str, *, is_refusal: bool = False) -> str:
    """Return the line above the controls; what it quotes stays text."""
    colour = BAD if is_refusal else Markup("color:inherit")
    return str(
        Markup('<div style="{};{};{}" data-lab="message" role="status">{}</div>').format(
            STYLE, TWO_LINES, colour, visible(line)
        )
    )


def readings_table(readings: Sequence[Reading], size: float) -> str:
    """Return the coursework's screen; size of the body [m] says how many decimals of a place are worth showing."""
    decimals = places(size)
    lines = [(one, texts(one, decimals)) for one in readings]
    is_long = max((len(text) for _, each in lines for text in each), default=0) > FITTING
    rows = Markup("").join(
        Markup('<tr><td style="{}">{}</td>{}<td style="{};padding-left:4px">{}</td></tr>').format(
            FAINT, one.name, cells(each, is_long=is_long), FAINT, one.unit
        )
        for one, each in lines
    )
    table = Markup(
        '<div style="{}" data-lab="readings"><table style="border-collapse:collapse;width:100%">{}</table></div>'
    )
    return str(table.format(STYLE, rows))


def chart_box(chart: str) -> str:
    """Return a chart, SVG, under its title; nothing where there is no chart yet."""
    title = Markup('<div style="{};{}">largest vertex error over time</div>').format(STYLE, FAINT)
    return f"{title}{chart}" if chart else ""


def grade_box(foreign: Foreign) -> str:
    """Return the verdict of `tumble grade` on a loaded trajectory, and its evidence."""
    rest = Markup("").join(Markup("<div>{}</div>").format(visible(line)) for line in foreign.details)
    box = Markup(
        '<div style="{};margin:0 10px 6px;padding:6px 8px;border-left:3px solid;{}" data-lab="grade">'
        "<b>{}</b>"
        '<details style="{}"><summary style="cursor:pointer">evidence</summary>{}</details></div>'
    )
    return str(box.format(STYLE, GOOD if foreign.is_right else BAD, visible(foreign.verdict), FAINT, rest))


def folder_line(folder: str) -> str:
    """Return a line that names the folder of saved files."""
    line = Markup('<div style="{};{}" data-lab="folder">Your browser downloads each file; a copy is saved in {}</div>')
    return str(line.format(STYLE, FAINT, visible(folder)))


def texts(reading: Reading, decimals: int) -> list[str]:
    """Return a reading's numbers as they are shown."""
    if len(reading.values) == 1 and reading.name in ("mass", "time", "impulse"):
        return [given(float(f"{reading.values[0]:.6g}"))]
    digits = decimals if reading.unit == "m" or len(reading.values) == 1 else 3
    return [fixed(value, digits) for value in reading.values]


def cells(numbers: Sequence[str], *, is_long: bool) -> Markup:
    """Return a reading's numbers in three columns; where they are long, in as many lines as they need."""
    right = Markup("text-align:right;white-space:nowrap;padding-left:4px")
    if len(numbers) == 3 and not is_long:
        return Markup("").join(Markup('<td style="{}">{}</td>').format(right, text) for text in numbers)
    words = Markup(" ").join(
        Markup('<span style="display:inline-block;padding-left:4px">{}</span>').format(text) for text in numbers
    )
    return Markup('<td colspan="3" style="text-align:right;padding-left:4px">{}</td>').format(words or "\N{EN DASH}")


def places(size: float) -> int:
    """Return how many decimals show some hundredths of that size [m]: two for the coursework's cube, as printed."""
    return min(max(2 - math.floor(math.log10(size)), 0), 12)


def error_table(
    rows: Sequence[ErrorRow], looks: Mapping[Contestant, Look], size: float, vertex: int | None, time: float
) -> str:
    """Return the table of Table 4.1's kind at the time shown [s]: position, error and distance of each contestant."""
    decimals = places(size)
    which = "vertex with the largest error" if vertex is None else f"vertex {vertex}"
    body = Markup("").join(error_row(row, looks[row.contestant], decimals) for row in rows)
    table = Markup(
        '<div style="{}" data-lab="errors"><div style="{}">error at t = <span data-lab="time">{}</span> s, {}</div>'
        '<table style="border-collapse:collapse;width:100%">{}</table></div>'
    )
    return str(table.format(STYLE, FAINT, given(float(f"{time:.9g}")), which, body))


def error_row(row: ErrorRow, look: Look, decimals: int) -> Markup:
    """Return one contestant: its error, its vertex's position and error vector; or why there is none."""
    name = Markup('<span style="color:{}">{}</span> {}').format(look.css, look.mark, visible(row.contestant.name))
    if row.position is None or row.error is None:
        return Markup(
            '<tr data-contestant="{}"><td>{}</td></tr><tr><td colspan="2" style="{}" data-lab="status">{}</td></tr>'
        ).format(row.contestant.name, name, FAINT, visible(row.status))
    note = Markup('<div style="{}" data-lab="status">{}</div>').format(BAD, visible(row.status)) if row.status else ""
    outside = "" if row.is_in_view else Markup('<div data-lab="outside">outside the view</div>')
    return Markup(
        '<tr data-contestant="{}"><td>{}</td>'
        '<td style="text-align:right;white-space:nowrap">'
        '<span style="{};font-size:11px">vertex {}</span> <b data-lab="off">{}</b></td></tr>'
        '<tr><td colspan="2" style="{};font-size:11px"><span>({}) m</span>'
        '<span style="float:right">{}</span>{}{}</td></tr>'
    ).format(
        row.contestant.name,
        name,
        FAINT,
        row.vertex,
        distance(row),
        FAINT,
        numbers(row.position, decimals),
        errors(row),
        outside,
        note,
    )


def distance(row: ErrorRow) -> str:
    """Return the error, or the resolution where that is larger."""
    if np.isnan(row.off_m):
        return "\N{EN DASH}"
    at_most = row.off_m <= row.resolution_m
    return f"\N{LESS-THAN OR EQUAL TO} {metres(row.resolution_m)}" if at_most else metres(row.off_m)


def metres(value: float) -> str:
    """Return a length in three digits and the unit that suits it."""
    if value == 0.0 or not math.isfinite(value):
        return f"{value:g} m"
    unit, size = unit_of(value)
    return f"{float(f'{value / size:.3g}'):g} {unit}"


def numbers(vector: Sequence[float] | np.ndarray, decimals: int) -> str:
    """Return x, y, z."""
    # Without the sign of a zero.
    return ", ".join(fixed(round(float(value), decimals) + 0.0, decimals) for value in vector)


def errors(row: ErrorRow) -> str:
    """Return the error vector in a common unit, nothing where it is not known or indistinguishable from zero."""
    if not row.off_m > row.resolution_m or row.error is None or not np.isfinite(row.error).all():
        return ""
    unit, size = unit_of(row.off_m)
    return f"\N{GREEK CAPITAL LETTER DELTA} ({numbers(row.error / size, 2)}) {unit}"
