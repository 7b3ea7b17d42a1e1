"""The picture that is kept: what the browser sees, and below it the numbers, as on the coursework's screen."""

import io
from collections.abc import Sequence

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from reports.numerals import fixed
from tumble.lab.readings import Reading

LINE, MARGIN, COLUMNS = 18, 12, 2
PAPER, INK = (255, 255, 255), (30, 30, 30)


def captioned(pixels: np.ndarray, readings: Sequence[Reading], decimals: int) -> bytes:
    """Return a PNG of pixels (h, w, 4) with the readings under them."""
    seen = Image.fromarray(pixels).convert("RGBA")
    lines = [in_words(one, decimals) for one in readings]
    rows = -(-len(lines) // COLUMNS)
    sheet = Image.new("RGB", (seen.width, seen.height + rows * LINE + 2 * MARGIN), PAPER)
    sheet.paste(seen, (0, 0), seen)
    draw, font = ImageDraw.Draw(sheet), ImageFont.load_default(13)
    for number, line in enumerate(lines):
        column, row = divmod(number, rows)
        place = MARGIN + column * seen.width // COLUMNS, seen.height + MARGIN + row * LINE
        draw.text(place, line, fill=INK, font=font)
    out = io.BytesIO()
    sheet.save(out, "PNG")
    return out.getvalue()


def in_words(reading: Reading, decimals: int) -> str:
    """Return a reading on one line."""
    digits = decimals if reading.unit == "m" else 3
    numbers = ", ".join(fixed(value, digits) for value in reading.values).replace("\N{MINUS SIGN}", "-")
    return f"{reading.name}: {numbers or '-'} {reading.unit}".rstrip()
