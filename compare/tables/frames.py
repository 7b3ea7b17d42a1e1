"""Tables as DataFrames: made from rows or columns, written as CSV, and read back or refused in one line."""

import csv
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from io import StringIO
from operator import attrgetter
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import pandas as pd

from tumble.compare.tables.cells import float_cells, lines_text, text_cell, text_of_cell
from tumble.compare.tables.files import place, write_folder, write_together
from tumble.compare.tables.known import schema
from tumble.compare.tables.schema import BadTable, Column, Table
from tumble.scenarios.files import plain_bytes
from tumble.scenarios.format import short

# The dtype `str` where pyarrow is not installed.  With pyarrow it refuses names of files that are not UTF-8.
TEXT = pd.StringDtype("python", na_value=np.nan)


def frame(table: Table, rows: Iterable[Any]) -> pd.DataFrame:
    """Return rows as a DataFrame.

    Parameters
    ----------
    table : their table
    rows : of the table's class, in order

    Returns
    -------
    the rows, with the table's dtypes
    """
    return typed(table, dict(zip(table.names, zip(*map(attrgetter(*table.names), rows), strict=True), strict=False)))


def rows(table: Table, frame: pd.DataFrame) -> list[Any]:
    """Return the rows of a DataFrame.

    Parameters
    ----------
    table : their table
    frame : with its columns

    Returns
    -------
    instances of the table's class, None for an empty cell
    """
    found = frame[table.names].astype(object)
    return [
        table.row(**dict(zip(table.names, row, strict=True)))
        for row in found.where(found.notna(), None).itertuples(index=False, name=None)
    ]


def merged(*sources: Mapping[str, pd.DataFrame]) -> dict[str, pd.DataFrame]:
    """Return the tables of several studies.

    Parameters
    ----------
    sources : tables by file name, of each study

    Returns
    -------
    table by file name; one that several studies have has the rows of all
    """
    own: dict[str, list[pd.DataFrame]] = {}
    for tables in sources:
        for name, table in tables.items():
            own.setdefault(name, []).append(table)
    return {name: pd.concat(each, ignore_index=True) if len(each) > 1 else each[0] for name, each in own.items()}


def typed(table: Table, columns: Mapping[str, Any]) -> pd.DataFrame:
    """Return columns, by name, as a DataFrame with the table's dtypes; those that are not given are empty."""
    return pd.DataFrame(
        {
            each.name: pd.Series(columns.get(each.name, ()), dtype=TEXT if each.kind is str else each.dtype)  # type: ignore
            for each in table.columns
        }
    )


def csv_text(frame: pd.DataFrame) -> str:
    """Return a table as CSV, first line the header, an empty cell for what is not there."""
    return lines_text(list(frame.columns), (cells(column) for _, column in frame.items()))


def csv_texts(frames: Mapping[str, pd.DataFrame]) -> dict[str, str]:
    """Return the tables that have rows as CSV, by file name."""
    return {name: csv_text(frame) for name, frame in frames.items() if len(frame)}


def write_tables(
    folder: Path, frames: Mapping[str, pd.DataFrame], others: Mapping[str, str | bytes] = MappingProxyType({})
) -> None:
    """Write the tables that have rows into a folder, all or none, and remove files of those that have none.

    Parameters
    ----------
    folder : made where it is not there
    frames : tables by file name
    others : further files by name, text or bytes of each; those of a folder in it, FOLDER/NAME, are written first

    Raises
    ------
    OSError : the folder cannot be written to
    """
    texts, within = csv_texts(frames), {name: text for name, text in others.items() if "/" in name}
    if within:
        write_together({folder / name: text for name, text in within.items()})
    beside = {name: text for name, text in others.items() if name not in within}
    write_folder(folder, {**texts, **beside}, without=frames.keys() - texts.keys())


def cells(column: pd.Series) -> list[str]:
    """Return the cells of one column."""
    # What stands in many rows, a name or a true position, is spelled once.
    if column.dtype == np.float64:
        codes, values = pd.factorize(column.to_numpy().view(np.int64))  # -0.0 is not 0.0
        ready = float_cells(np.asarray(values).view(np.float64))
        return [ready[code] for code in codes]
    codes, values = pd.factorize(column)
    if pd.api.types.is_integer_dtype(column.dtype) or column.dtype == bool:
        ready = [str(value) for value in values]
    else:
        ready = [text_cell(str(value)) for value in values]
    ready.append("")  # code -1: nothing
    return [ready[code] for code in codes]


def read_tables(source: Path | Mapping[str, str]) -> dict[str, pd.DataFrame]:
    """Return every table of a folder; a table without rows has no file.

    Parameters
    ----------
    source : the folder, or file name -> CSV text

    Returns
    -------
    table by file name, without files that are no tables of Tumble

    Raises
    ------
    BadTable : a file is not the table that it is named after
    OSError : a file cannot be read
    """
    names = [path.name for path in sorted(source.glob("*.csv"))] if isinstance(source, Path) else list(source)
    found = {}
    for name in names:
        if table := schema(name):
            found[name] = (
                read_file(source / name, table) if isinstance(source, Path) else read_text(name, source[name], table)
            )
    return found


def kept_tables(folder: Path, tables: Iterable[Table]) -> dict[str, pd.DataFrame]:
    """Return some tables of a folder; one that is not there has no rows.

    Parameters
    ----------
    folder : where they are
    tables : the tables

    Returns
    -------
    table by file name; nothing if none of them is there

    Raises
    ------
    BadTable : a file is not the table that it is named after
    OSError : a file cannot be read
    """
    places = {table: place(folder, table.file) for table in tables}
    if not any(path.exists() for path in places.values()):
        return {}
    return {table.file: read_file(path, table) if path.exists() else typed(table, {}) for table, path in places.items()}


def read_file(path: Path, table: Table, renamed: Mapping[str, str] = MappingProxyType({})) -> pd.DataFrame:
    """Return the table in a file; renamed: columns that it may have under older names.  Raises BadTable, OSError."""
    try:
        text = plain_bytes(path).decode("utf-8")
    except UnicodeDecodeError as error:
        raise BadTable(f"{path}: not CSV: {error}") from None
    return read_text(str(path), text, table, renamed)


def read_text(name: str, text: str, table: Table, renamed: Mapping[str, str] = MappingProxyType({})) -> pd.DataFrame:
    """Return the table in a CSV text.  Raises BadTable unless it has the table's columns, each of its kind.

    renamed: columns that it may have under older names, old -> new.
    pandas.read_csv is not used: it fills up short lines, drops blank ones and cannot name the line of a bad cell.
    """
    lines = csv.reader(StringIO(text, newline=""), strict=True)
    try:
        header = [renamed.get(column, column) for column in next(lines, [])]
        if header != table.names:
            raise BadTable(f"{name}: columns {short(','.join(header))}: must be {','.join(table.names)}")
        numbers, rows = [], []
        for line in lines:
            if len(line) != len(header):
                raise BadTable(f"{name}: line {lines.line_num}: {len(line)} cells: must be {len(header)}")
            numbers.append(lines.line_num)
            rows.append(line)
    except csv.Error as error:
        raise BadTable(f"{name}: not CSV: {error}") from None
    columns = zip(*rows, strict=True) if rows else ((),) * len(header)
    return typed(
        table,
        {
            column.name: list(values(name, numbers, column, own))
            for column, own in zip(table.columns, columns, strict=True)
        },
    )


def values(name: str, numbers: Sequence[int], column: Column, cells: Sequence[str]) -> Iterator[Any]:
    """Yield the values of one column; numbers: those of the lines.  Raises BadTable."""
    if column.kind is str:
        yield from map(text_of_cell, cells)
        return
    if column.kind is bool:
        what, read = "True or False", {"True": True, "False": False}.__getitem__
    else:
        what, read = ("whole " * (column.kind is int)) + "number", column.kind
        what = f"a {what}"
    empty = None if column.kind is int else math.nan
    for number, cell in zip(numbers, cells, strict=True):
        try:
            value = empty
            if cell or not column.optional:
                value = read(cell)
                # What is not there is an empty cell, and no `nan`.
                if math.isnan(value) or (column.kind is int and abs(value) >= 2**63):
                    raise ValueError
        except (ValueError, KeyError):
            raise BadTable(f"{name}: line {number}: {column.name} = {short(cell)}: must be {what}") from None
        yield value
