"""What stands in the cells of a CSV file: no digit of a float lost, and no text that a spreadsheet would run."""

import re
from collections.abc import Iterable, Sequence

import msgspec
import numpy as np

from tumble.scenarios.frames import Array

# Text that a spreadsheet takes for a formula, or what is written here in its place.
FORMULA = re.compile(r"['\s]*[=+\-@]")
QUOTED = re.compile(r'[,"\r\n]')
# What a terminal obeys, or shows other text for, when somebody looks at the file there; ends of lines and tabs it may.
CONTROL = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")
ONE_DIGIT = re.compile(r"e-(\d)$")


def lines_text(header: Sequence[str], columns: Iterable[Sequence[str]]) -> str:
    """Return CSV text, first line the header, from columns of cells that are ready to be written."""
    return "\n".join([",".join(map(text_cell, header)), *map(",".join, zip(*columns, strict=True)), ""])


def float_cells(values: Array, absent: str = "") -> list[str]:
    """Return the shortest digits that round-trip, spelled as repr does, of floats (n,); absent: what NaN is."""
    # msgspec finds the digits of repr in an eighth of its time, and spells some exponents otherwise.
    found = msgspec.json.encode(values.tolist()).decode()[1:-1].split(",") if len(values) else []
    size = np.abs(values)
    for place in np.flatnonzero(~np.isfinite(values)):
        found[place] = absent if np.isnan(values[place]) else repr(float(values[place]))
    for place in np.flatnonzero((size < 1e-5) & (size >= 1e-9)):
        found[place] = ONE_DIGIT.sub(r"e-0\1", found[place])
    for place in np.flatnonzero(((size < 1e-4) & (size >= 1e-5)) | (size >= 1e16)):
        found[place] = repr(float(values[place]))
    return found


def text_cell(text: str) -> str:
    """Return the cell of a text: a ' before one that a spreadsheet would run, control characters made visible."""
    text = CONTROL.sub(lambda found: repr(found[0])[1:-1], text)
    if FORMULA.match(text):
        text = f"'{text}"
    if not QUOTED.search(text):
        return text
    doubled = text.replace('"', '""')
    return f'"{doubled}"'


def text_of_cell(cell: str) -> str:
    """Return the text that `cell`, without its quotes, was made of."""
    return cell[1:] if cell.startswith("'") and FORMULA.match(cell) else cell
