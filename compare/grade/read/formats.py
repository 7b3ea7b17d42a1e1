"""Other file formats of a trajectory, converted to CSV for `tumble.compare.grade.read.trajectory` line by line.

Numbers keep their text, so that their printed digits are still known.
"""

import json
import os
import re
import shutil
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from itertools import chain, islice
from pathlib import Path
from typing import NamedTuple, TextIO

from tumble.compare.grade.read.columns import BadTrajectory
from tumble.scenarios.files import why_unread
from tumble.scenarios.format import printable, short

STANDARD_INPUT = "-"
PARQUET = b"PAR1"
# Lines that show the format of a file; a line of more bytes than this is not a row of a trajectory.
LOOKED_AT = 50
LONGEST_LINE = 1_000_000
SEPARATED = re.compile(r"[,;\t]")
DEEPEST = 8


class CsvFile(NamedTuple):
    """A CSV file: its path, its name in messages, and the line of its first row in the user's file."""

    path: Path
    name: str
    first_line: int = 2


def as_csv(file: str, columns: Sequence[str], decimal: str, stack: ExitStack) -> CsvFile:
    """Return a file as CSV, converted if it is in another format.

    columns: names for a file without a header; stack: removes temporary files.  Raises BadTrajectory.
    """
    path, name = Path(file), "standard input" if file == STANDARD_INPUT else printable(file)
    if file == STANDARD_INPUT:
        path = draft_file(stack)
        with path.open("wb") as whole:
            shutil.copyfileobj(sys.stdin.buffer, whole)
    if not os.path.isfile(path):
        return CsvFile(path, name)  # the reader reports what is wrong
    try:
        with path.open("rb") as start:
            magic = start.read(len(PARQUET))
        if magic == PARQUET:
            return CsvFile(_from_parquet(path, name, stack), name)
        with path.open(encoding="utf-8-sig", errors="surrogateescape", newline="\n") as text:
            head = [line for line in islice(_lines(text), LOOKED_AT) if len(line) <= LONGEST_LINE]
        return _from_text(path, name, head, columns, decimal, stack)
    except OSError as error:
        raise BadTrajectory(f"{name}: {why_unread(error)}") from None


def _from_text(
    path: Path, name: str, head: list[str], columns: Sequence[str], decimal: str, stack: ExitStack
) -> CsvFile:
    rows = [(number, line) for number, line in enumerate(head, 1) if line.strip() and not line.lstrip().startswith("#")]
    if not rows:
        return CsvFile(path, name)
    number, first = rows[0]
    if first.lstrip().startswith("{"):
        return CsvFile(_from_json(path, name, stack), name, 1)
    bare = first.strip()
    by_spaces = not SEPARATED.search(re.sub(r'"[^"]*"', "", bare)) and len(bare.split()) > 1
    is_data = all(_is_number(cell, decimal) for cell in _cells(bare, by_spaces, decimal))
    comment = next((line.strip().lstrip("#").strip() for line in head[: number - 1][::-1] if line.strip()), "")
    if is_data and not columns and len(_cells(comment, by_spaces, decimal)) == len(_cells(bare, by_spaces, decimal)):
        header, first_line = comment, number
    elif is_data and not columns:
        count = len(_cells(bare, by_spaces, decimal))
        raise BadTrajectory(
            f"{name}: line {number} has numbers, and there is no header: name all {count} columns, e.g. "
            f"--columns {','.join(_example(count))}"
        )
    elif columns and is_data:
        count = len(_cells(bare, by_spaces, decimal))
        if len(columns) != count:
            raise BadTrajectory(f"{name}: line {number}: {count} cells, but --columns names {len(columns)}")
        header, first_line = (" " if by_spaces else _separator(bare, decimal)).join(columns), number
    elif columns:
        raise BadTrajectory(f"{name}: line {number} is a header: use --map to name columns instead of --columns")
    elif by_spaces or number > 1:
        header, first_line = bare, number + 1
    else:
        return CsvFile(path, name)
    draft = draft_file(stack)
    with (
        path.open(encoding="utf-8-sig", errors="surrogateescape", newline="\n") as text,
        draft.open("w", encoding="utf-8", errors="surrogateescape", newline="\n") as out,
    ):
        # Cells that spaces separate are written with semicolons.
        out.write((_joined(header) if by_spaces else header) + "\n")
        for line in islice(_lines(text), first_line - 1, None):
            if line.lstrip().startswith("#"):
                out.write("\n")  # lines keep their numbers
            else:
                out.write(_joined(line) + "\n" if by_spaces else line)
    return CsvFile(draft, name, first_line)


def _lines(text: TextIO) -> Iterator[str]:
    """Yield lines; a line that is too long comes in pieces."""
    while line := text.readline(LONGEST_LINE + 2):
        yield line


def _joined(line: str) -> str:
    """Return cells that spaces separate, with semicolons between them."""
    return ";".join(line.split())


def _cells(line: str, by_spaces: bool, decimal: str) -> list[str]:
    return line.split() if by_spaces else line.rstrip(",;\t").split(_separator(line, decimal))


def _separator(line: str, decimal: str) -> str:
    found = [each for each in ("\t", ";", ",") if each in line and each != decimal]
    return found[0] if found else ","


def _is_number(cell: str, decimal: str) -> bool:
    try:
        float(cell.replace(decimal, "."))
    except ValueError:
        return False
    return True


def _example(count: int) -> list[str]:
    """Return the usual names of this many columns: time, position, attitude, velocities."""
    usual = ["t_s", "x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"]
    if count in (4, 7):
        usual = ["t_s", "v0x_m", "v0y_m", "v0z_m"] if count == 4 else [*usual[:4], "rx_deg", "ry_deg", "rz_deg"]
    if count == 13:
        usual = [*usual[:4], *(f"r{row}{column}" for row in "123" for column in "123")]
    usual += ["vx_m_s", "vy_m_s", "vz_m_s", "wx_rad_s", "wy_rad_s", "wz_rad_s"] if count == 14 else []
    return [*usual, *(f"other{number}" for number in range(1, count))][:count]


def _from_json(path: Path, name: str, stack: ExitStack) -> Path:
    """Return JSON lines as CSV: objects are flattened; a list of three gets the suffixes x, y, z."""
    draft = draft_file(stack)
    keys: list[str] = []
    with (
        path.open(encoding="utf-8-sig", errors="surrogateescape", newline="\n") as text,
        draft.open("w", encoding="utf-8", errors="surrogateescape", newline="\n") as out,
    ):
        for number, line in enumerate(_lines(text), 1):
            if not line.strip() or line.lstrip().startswith("#"):
                if keys:
                    out.write("\n")
                continue
            try:
                # Numbers stay text: their last digit shows how they were rounded.
                row = json.loads(line, parse_float=str, parse_int=str, parse_constant=str)
            except (ValueError, RecursionError):
                raise BadTrajectory(f"{name}: line {number}: not JSON; each line must be one object") from None
            if not isinstance(row, dict):
                raise BadTrajectory(f'{name}: line {number}: must be an object, e.g. {{"t_s": 0.0, ...}}')
            cells = dict(_flat(row, "", 0))
            if not keys:
                keys = list(cells)
                out.write(",".join(map(_quoted, keys)) + "\n" + "\n" * (number - 1))
            if missing := next((key for key in chain(keys, cells) if key not in cells or key not in keys), None):
                there = "missing" if missing not in cells else "not in the first row"
                raise BadTrajectory(
                    f"{name}: line {number}: {short(missing)}: {there}; all rows must have the same keys"
                )
            out.write(",".join(_quoted(cells[key]) for key in keys) + "\n")
    return draft


def _flat(value: object, key: str, depth: int) -> Iterator[tuple[str, str]]:
    """Yield names and cells of a nested object; nested names are joined by _."""
    if isinstance(value, dict | list) and depth < DEEPEST:
        names = "xyz" if isinstance(value, list) and len(value) == 3 else map(str, range(len(value)))
        for name, item in value.items() if isinstance(value, dict) else zip(names, value, strict=False):
            yield from _flat(item, f"{key}_{name}" if key else str(name), depth + 1)
    else:
        yield key, value if isinstance(value, str) else json.dumps(value)


def _quoted(cell: str) -> str:
    """Return a cell quoted for CSV."""
    cell = " ".join(cell.split())
    return '"' + cell.replace('"', '""') + '"' if re.search(r'[",;]', cell) else cell


def _from_parquet(path: Path, name: str, stack: ExitStack) -> Path:
    """Return a Parquet file as CSV; single precision is written in its own shortest digits."""
    import pandas as pd

    try:
        table = pd.read_parquet(path)
    except ImportError:
        raise BadTrajectory(
            f"{name}: reading Parquet needs pyarrow, which is not installed; save the file as CSV"
        ) from None
    except Exception as error:  # pyarrow raises many kinds of errors for a damaged file
        raise BadTrajectory(f"{name}: pandas cannot read it as Parquet: {printable(str(error))[:200]}") from None
    draft = draft_file(stack)
    table.to_csv(draft, index=False)
    return draft


def draft_file(stack: ExitStack) -> Path:
    """Return the path of a temporary file, which the stack removes."""
    folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="tumble-grade-")))
    return folder / "trajectory.csv"
