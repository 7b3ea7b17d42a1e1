"""A record: a folder of CSV tables with a format version, read whole or refused in one line."""

import logging
import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pandas as pd

from tumble.compare.check.schemas import CELLS, DRIFTS, ERRORS, EXACT, QUESTIONS, STATUSES, TIMES, CellRow, QuestionRow
from tumble.compare.contact.schemas import CONTACT
from tumble.compare.judge.trend import TRENDS
from tumble.compare.run.condition import ConditionRow
from tumble.compare.run.provenance import timed_under, versions
from tumble.compare.tables.files import place
from tumble.compare.tables.frames import csv_text, frame, read_file, rows
from tumble.compare.tables.schema import BadTable, Table
from tumble.compare.tables.shared import CONDITIONS, ENGINES
from tumble.scenarios.files import why_unread
from tumble.scenarios.format import printable, short
from tumble.scenarios.refusal import UserError

log = logging.getLogger(__name__)

FORMAT = "tumble check 3"
# Format 2 differs in one name and two words.
FORMAT_2 = "tumble check 2"
COLUMNS_OF_2 = {"limit_m": "resolution_m"}
SPIN_ENERGY_OF_2 = {"kept": "conserved", "wavers": "oscillates"}
# Figures that are infinite if a run diverged, and those that may be negative.
BOUNDLESS = (*ERRORS, *DRIFTS)
SIGNED = ("energy_drift", "attitude_order", "translation_order", "x_m", "y_m", "z_m", *CONTACT.names)
FINISHED = ("ok", "flagged", "diverged")  # of a run with figures, if its scene has a reference solution
LARGEST_COUNT = 10**18


class BadRecord(UserError):
    """A folder that is not a record, or cannot be read; the message is the one line for the user."""


@dataclass(frozen=True, eq=False)
class Record:
    """Everything one check measured.

    The tables are those of `tumble.compare.check.schemas` and `tumble.compare.tables.shared`.

    Parameters
    ----------
    scenes : scenes of the command line, so that it can be repeated; empty: all
    contestants : contestants of the command line, so that it can be repeated; empty: all
    command : command line that repeats the check
    questions : table of the scenes
    engines : table of the engines
    cells : table of errors, drifts and orders, one row for each scene and contestant
    times : table of run times; None: they were not measured
    contact : table of observables of contact; None: no scene has a plane
    """

    scenes: tuple[str, ...]
    contestants: tuple[str, ...]
    command: str
    questions: pd.DataFrame
    engines: pd.DataFrame
    cells: pd.DataFrame
    times: pd.DataFrame | None = None
    contact: pd.DataFrame | None = None


def texts(record: Record) -> dict[str, str]:
    """Return a record as files.

    Parameters
    ----------
    record : the record

    Returns
    -------
    CSV text by file name; conditions.csv, which makes the folder a record, is the last
    """
    conditions = (
        ConditionRow("format", FORMAT),
        ConditionRow("command", record.command),
        ConditionRow("scenes", shlex.join(record.scenes)),
        ConditionRow("contestants", shlex.join(record.contestants)),
        *timed_under(),
        *versions(),
    )
    tables = {QUESTIONS: record.questions, ENGINES: record.engines, CELLS: record.cells}
    tables |= {table: own for table, own in ((TIMES, record.times), (CONTACT, record.contact)) if own is not None}
    return {table.file: csv_text(own) for table, own in {**tables, CONDITIONS: frame(CONDITIONS, conditions)}.items()}


def is_record(folder: Path) -> bool:
    """Whether the folder has something that may be a record.

    Parameters
    ----------
    folder : the folder, which need not exist

    Returns
    -------
    whether it has the file of the conditions
    """
    return place(folder, CONDITIONS.file).exists()


def read_record(folder: Path) -> Record:
    """Return the record in a folder, also one in format 2.

    Parameters
    ----------
    folder : of the record

    Returns
    -------
    the record

    Raises
    ------
    BadRecord : the folder has no record, or one that cannot be read
    """
    shown = printable(str(folder))
    if not is_record(folder):
        why = "not a record of `tumble check`: it has no conditions.csv" if folder.is_dir() else "no such folder"
        raise BadRecord(f"{shown}: {why}")
    conditions = read(folder, CONDITIONS)
    stated = dict(zip(conditions.what, conditions.value, strict=True))
    old = stated.get("format") == FORMAT_2
    if not old and stated.get("format") != FORMAT:
        found = f"is in format {short(stated['format'])}" if "format" in stated else "states no format"
        raise BadRecord(
            f"{shown}: {found}; this Tumble reads {FORMAT!r} and {FORMAT_2!r}: move it away, and record again with "
            "--accept"
        )
    if old:
        log.info(f"{shown} is in format 2; --accept rewrites it in format 3")
    renamed = COLUMNS_OF_2 if old else {}
    cells = read(folder, CELLS, renamed)
    if old:
        cells["spin_energy"] = cells["spin_energy"].replace(SPIN_ENERGY_OF_2)
    record = Record(
        scenes=words(folder, stated, "scenes"),
        contestants=words(folder, stated, "contestants"),
        command=stated.get("command", ""),
        questions=read(folder, QUESTIONS, renamed),
        engines=read(folder, ENGINES),
        cells=cells,
        times=read(folder, TIMES) if place(folder, TIMES.file).exists() else None,
        contact=read(folder, CONTACT) if place(folder, CONTACT.file).exists() else None,
    )
    for column, known in (("status", STATUSES), ("spin_energy", {**TRENDS, "": 0})):
        if odd := set(record.cells[column]) - {*known}:
            words_known = ", ".join(filter(None, known))
            raise BadRecord(f"{shown}: cells.csv: {column} = {short(min(odd))}: must be one of {words_known}")
    if stray := set(record.cells.scene) - set(record.questions.scene):
        raise BadRecord(f"{shown}: cells.csv has scene {short(min(stray))}, which questions.csv does not have")
    refuse_unmeasured(shown, record)
    return record


def refuse_unmeasured(shown: str, record: Record) -> None:
    """Raise BadRecord if a figure is missing that every record has."""
    questions: list[QuestionRow] = [row for row in rows(QUESTIONS, record.questions) if row.truth == EXACT]
    exact = {row.scene for row in questions}
    cells: list[CellRow] = [row for row in rows(CELLS, record.cells) if row.status in FINISHED and row.scene in exact]
    for row in questions:
        for column in ("resolution_m", "x_m", "y_m", "z_m"):
            if getattr(row, column) is None:
                raise BadRecord(
                    f"{shown}: questions.csv: {column} of {short(row.scene)} is empty, but its truth is {EXACT}"
                )
    for row in cells:
        for column in (*ERRORS, "resolution_m", *DRIFTS):
            if getattr(row, column) is None:
                cell = short(f"{row.scene} {row.engine}:{row.method}")
                raise BadRecord(f"{shown}: cells.csv: {column} of {cell} is empty, but its status is {row.status}")


def words(folder: Path, stated: dict[str, str], what: str) -> tuple[str, ...]:
    """Return words of the command line that a record has."""
    try:
        return tuple(shlex.split(stated[what]))
    except (KeyError, ValueError) as error:
        raise BadRecord(f"{printable(str(folder))}: conditions.csv: {what} cannot be read: {error}") from None


def read(folder: Path, table: Table, renamed: Mapping[str, str] = MappingProxyType({})) -> pd.DataFrame:
    """Return a table of a record; renamed: columns of an older format.  Raises BadRecord for a bad value."""
    path = place(folder, table.file)
    shown = printable(str(path))
    try:
        found = read_file(path, table, renamed)
    except OSError as error:
        raise BadRecord(f"{shown}: {why_unread(error)}") from None
    except BadTable as error:
        raise BadRecord(str(error)) from None
    if table is not CONDITIONS:
        refuse_twice(shown, found, table)
    refuse_beyond(shown, found, table)
    return found


def refuse_twice(shown: str, found: pd.DataFrame, table: Table) -> None:
    """Raise BadRecord if a row is repeated."""
    twice = found[found.duplicated(list(table.key))]
    if len(twice):
        raise BadRecord(f"{shown}: two rows for {short(' '.join(map(str, twice.iloc[0][list(table.key)])))}")


def refuse_beyond(shown: str, found: pd.DataFrame, table: Table) -> None:
    """Raise BadRecord for a count, a sign or an infinity that the column cannot have."""
    for column in table.columns:
        if column.kind not in (int, float):
            continue
        values = found[column.name].to_numpy(dtype=float, na_value=np.nan)
        if column.kind is int:
            beyond, what = (values < 0) | (values > LARGEST_COUNT), f"must be a whole number from 0 to {LARGEST_COUNT}"
        else:
            finite, signed = column.name not in BOUNDLESS, column.name in SIGNED
            beyond = (finite & np.isinf(values)) | (values < (-np.inf if signed else 0.0))
            what = "must be " + " and ".join(["finite"] * finite + [">= 0"] * (not signed))
        for row in np.flatnonzero(beyond)[:1]:
            cell = found[column.name][row]
            raise BadRecord(f"{shown}: row {row + 1}: {column.name} = {cell}: {what}")
