"""Rows as the page reads them from CSV text, one object a row; only until it reads DataFrames."""

import csv
import io
from collections.abc import Callable, Iterable, Iterator
from dataclasses import fields
from types import NoneType
from typing import Annotated, Any, TypeVar, get_args, get_origin, get_type_hints

from compare.tables.cells import text_of_cell
from compare.tables.frames import csv_text, frame
from compare.tables.schema import Table
from compare.tables.shared import RunRow, VertexErrorRow

__all__ = ["Cells", "Row", "RunRow", "VertexErrorRow", "cells", "table_text", "typed"]

Row = TypeVar("Row")
Cells = dict[str, str]


def table_text(row_type: type, rows: Iterable[Any]) -> str:
    """Return a table of rows of one type as CSV."""
    return csv_text(frame(Table("", row_type), rows))


def cells(text: str) -> Iterator[Cells]:
    """Yield a table's rows, column name -> cell."""
    lines = csv.reader(io.StringIO(text, newline=""))
    names = next(lines)
    return (dict(zip(names, map(text_of_cell, line), strict=True)) for line in lines)


def typed(row_type: type[Row], table: Iterable[Cells]) -> Iterator[Row]:
    """Yield rows as row_type, the reason of a status behind it.  Raises ValueError, KeyError."""
    hints = get_type_hints(row_type)
    readers = {field.name: reader(hints[field.name]) for field in fields(row_type)}  # type: ignore[arg-type]
    for row in table:
        if row.get("status") and "verdict" not in row:
            row = {**row, "status": ": ".join(filter(None, (row["status"], row["why"])))}
        if row.get("tolerance"):
            row = {**row, "dt_s": row["tolerance"], **({"steps": "1"} if row.get("wall_s") else {})}
        yield row_type(**{name: read(row[name]) for name, read in readers.items()})


def reader(hint: Any) -> Callable[[str], Any]:
    """Return what makes a column's value from its cell."""
    hint = get_args(hint)[0] if get_origin(hint) is Annotated else hint
    kinds = get_args(hint) or (hint,)
    if hint is bool:
        return lambda cell: cell == str(True)
    read = kinds[0]
    if NoneType in kinds:
        return lambda cell: read(cell) if cell else None
    return lambda cell: read(cell or "nan") if read is float else read(cell)
