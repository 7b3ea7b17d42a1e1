"""The saved picture: the browser's view, and below it the numbers, as on the coursework's screen."""

import io
from collections.abc import Mapping, Sequence
from itertools import accumulate
from typing import NamedTuple

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from tumble.lab.pool import Contestant
from tumble.lab.readings import ErrorRow, Reading
from tumble.reports.numerals import fixed
from tumble.scenarios.format import visible

LINE, MARGIN, SQUARE = 18, 14, 11
PAPER, INK = (255, 255, 255), (30, 30, 30)
Colour = tuple[int, int, int]


class Line(NamedTuple):
    """A line of the caption, and the colour of the square before it, if it has one."""

    text: str
    colour: Colour | None = None


def captioned(
    pixels: np.ndarray, background: Colour, readings: Sequence[Reading], rows: Sequence[ErrorRow],
    colours: Mapping[Contestant, Colour], decimals: int,
) -> bytes:  # fmt: skip
    """Return a PNG of pixels (h, w, 4) on a background, under them the readings and each contestant's error, as wide as
    these need."""
    drawn = Image.fromarray(pixels).convert("RGBA")
    seen = Image.new("RGBA", drawn.size, background)
    seen.alpha_composite(drawn)
    font = ImageFont.load_default(13)
    lines = [Line(in_words(one, decimals)) for one in readings]
    half = -(-len(lines) // 2)
    off = [Line("largest error of a vertex")] * bool(rows)
    off += [Line(error_text(row), colours[row.contestant]) for row in rows]
    columns = [column for column in (lines[:half], lines[half:], off) if column]
    widths = [max(font.getlength(line.text) for line in column) + SQUARE + 3 * MARGIN for column in columns]
    stretch = max(seen.width / sum(widths), 1.0)
    height = seen.height + max(map(len, columns)) * LINE + 2 * MARGIN
    sheet = Image.new("RGB", (round(sum(widths) * stretch), height), PAPER)
    sheet.paste(background, (0, 0, sheet.width, seen.height))
    sheet.paste(seen, ((sheet.width - seen.width) // 2, 0))
    draw = ImageDraw.Draw(sheet)
    for column, left in zip(columns, accumulate([0.0, *widths]), strict=False):
        for number, line in enumerate(column):
            x, y = MARGIN + left * stretch, seen.height + MARGIN + number * LINE
            if line.colour:
                draw.rectangle((x, y + 3, x + SQUARE, y + 3 + SQUARE), fill=line.colour)
                x += SQUARE + 6
            draw.text((x, y), line.text, fill=INK, font=font)
    out = io.BytesIO()
    sheet.save(out, "PNG")
    return out.getvalue()


def in_words(reading: Reading, decimals: int) -> str:
    """Return a reading on one line."""
    digits = decimals if reading.unit == "m" else 3
    numbers = ", ".join(fixed(value, digits) for value in reading.values).replace("\N{MINUS SIGN}", "-")
    return f"{reading.name}: {numbers or '-'} {reading.unit}".rstrip()


def error_text(row: ErrorRow) -> str:
    """Return a contestant's error, or why it is not known, on one line."""
    if np.isnan(row.off_m):
        return visible(f"{row.contestant.name}: {row.status or 'no truth here'}")
    how_far = f"at most {row.resolution_m:.2g}" if row.off_m <= row.resolution_m else f"{row.off_m:.3g}"
    return visible(f"{row.contestant.name}: {how_far} m, vertex {row.vertex}")
