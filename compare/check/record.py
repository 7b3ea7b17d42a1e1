"""What a check keeps: a folder of CSV tables that carries a format version, read whole or refused in one line."""

import csv
import io
import math
import shlex
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, get_type_hints

from compare.check.energy import TRENDS
from compare.comparison.results import EngineRow
from compare.run.provenance import ConditionRow, versions
from compare.tables.rows import Row, reader, table_text, text_of_cell
from scenarios.files import plain_bytes, why_unread
from scenarios.format import printable, short

FORMAT = "tumble check 1"
# What a flight that diverged leaves without bound.
BOUNDLESS = ("_error_m", "_drift", "rounding_m")
LARGEST_COUNT = 10**18
WHOLE = (int, int | None)


class BadRecord(ValueError):
    """A folder that is no record, or none that can be read; the message is the one line for the user."""


@dataclass(frozen=True)
class QuestionRow:
    """One scene as it was asked: its step and samples, and where its last vertex truly is at the last sample.

    A scene file that was changed asks another question, and its errors are not comparable: the true answer shows it.
    truth says why there is none.
    """

    scene: str
    step_s: float
    samples: int
    truth: str
    limit_m: float | None
    size_m: float
    x_m: float | None
    y_m: float | None
    z_m: float | None


@dataclass(frozen=True)
class CellRow:
    """One contestant on one scene at the scene's own step: errors, drifts from the truth, orders, energy of the spin.

    The columns of runs.csv mean the same here.  rounding_m: what the roundings of all steps may come to, by which
    another processor's flight may differ.  The orders are those of the attitude and of the centre of mass apart, empty
    where they cannot be read; spin_energy is one of TRENDS, empty where nothing turns freely.
    """

    scene: str
    engine: str
    method: str
    steps: int | None
    status: str
    max_error_m: float | None = None
    rms_error_m: float | None = None
    final_error_m: float | None = None
    limit_m: float | None = None
    rounding_m: float | None = None
    energy_drift: float | None = None
    momentum_drift: float | None = None
    angular_momentum_drift: float | None = None
    attitude_order: float | None = None
    translation_order: float | None = None
    spin_energy: str = ""


@dataclass(frozen=True)
class TimeRow:
    """The run time of one contestant's flight over the reference contestant's, empty where the clock was not steady."""

    scene: str
    engine: str
    method: str
    reference: str
    time_ratio: float | None

    @property
    def key(self) -> tuple[str, str, str, str]:
        """What two rows of the same time have in common."""
        return self.scene, self.engine, self.method, self.reference


@dataclass(frozen=True)
class Record:
    """Everything one check measured.

    scenes, contestants: the words it was asked for with, so that it can be asked again; empty means all there are.
    times: None where run times were not measured.
    """

    scenes: tuple[str, ...]
    contestants: tuple[str, ...]
    command: str
    questions: tuple[QuestionRow, ...]
    engines: tuple[EngineRow, ...]
    cells: tuple[CellRow, ...]
    times: tuple[TimeRow, ...] | None = None


def texts(record: Record) -> dict[str, str]:
    """Return file name -> CSV text of a record; conditions.csv, which makes the folder a record, comes last."""
    said = (
        ConditionRow("format", FORMAT),
        ConditionRow("command", record.command),
        ConditionRow("scenes", shlex.join(record.scenes)),
        ConditionRow("contestants", shlex.join(record.contestants)),
        *versions(),
    )
    return {
        "questions.csv": table_text(QuestionRow, record.questions),
        "engines.csv": table_text(EngineRow, record.engines),
        "cells.csv": table_text(CellRow, record.cells),
        **({} if record.times is None else {"times.csv": table_text(TimeRow, record.times)}),
        "conditions.csv": table_text(ConditionRow, said),
    }


def is_record(folder: Path) -> bool:
    """Whether there is something in the folder that may be a record."""
    return (folder / "conditions.csv").exists()


def read_record(folder: Path) -> Record:
    """Return the record in a folder.  Raises BadRecord."""
    shown = printable(str(folder))
    if not is_record(folder):
        why = "is no record of `tumble check`: it has no conditions.csv" if folder.is_dir() else "no such folder"
        raise BadRecord(f"{shown}: {why}")
    said = {row.what: row.value for row in read_table(folder / "conditions.csv", ConditionRow)}
    if said.get("format") != FORMAT:
        found = f"is in format {short(said['format'])}" if "format" in said else "names no format"
        raise BadRecord(f"{shown}: {found}; this Tumble reads {FORMAT!r}: record it again with --accept")
    record = Record(
        words(folder, said, "scenes"),
        words(folder, said, "contestants"),
        said.get("command", ""),
        read_table(folder / "questions.csv", QuestionRow),
        read_table(folder / "engines.csv", EngineRow),
        read_table(folder / "cells.csv", CellRow),
        read_table(folder / "times.csv", TimeRow) if (folder / "times.csv").exists() else None,
    )
    refuse_twice(folder / "questions.csv", [(row.scene,) for row in record.questions])
    refuse_twice(folder / "cells.csv", [(row.scene, row.engine, row.method) for row in record.cells])
    if odd := {row.spin_energy for row in record.cells} - {*TRENDS, ""}:
        raise BadRecord(f"{shown}: cells.csv: spin_energy = {short(min(odd))}: must be one of {', '.join(TRENDS)}")
    if stray := {row.scene for row in record.cells} - {row.scene for row in record.questions}:
        raise BadRecord(f"{shown}: cells.csv has scene {short(min(stray))}, and questions.csv has not")
    return record


def words(folder: Path, said: dict[str, str], what: str) -> tuple[str, ...]:
    """Return the words of a command line that a record keeps."""
    try:
        return tuple(shlex.split(said[what]))
    except (KeyError, ValueError) as error:
        raise BadRecord(f"{printable(str(folder))}: conditions.csv: {what} cannot be read: {error}") from None


def refuse_twice(path: Path, keys: Sequence[tuple[str, ...]]) -> None:
    """Raise BadRecord where a row is there twice."""
    for number, key in enumerate(keys):
        if key in keys[:number]:
            raise BadRecord(f"{printable(str(path))}: two rows for {short(' '.join(key))}")


def read_table(path: Path, row_type: type[Row]) -> tuple[Row, ...]:
    """Return the rows of a CSV table.  Raises BadRecord unless it has the columns of the row type, each of its kind."""
    shown = printable(str(path))
    try:
        lines = csv.reader(io.StringIO(plain_bytes(path).decode("utf-8"), newline=""), strict=True)
        header = next(lines, [])
        columns = get_type_hints(row_type)
        if header != list(columns):
            raise BadRecord(f"{shown}: columns {short(','.join(header))}: must be {','.join(columns)}")
        return tuple(row_type(*values(shown, lines.line_num, columns, line)) for line in lines)
    except OSError as error:
        raise BadRecord(f"{shown}: {why_unread(error)}") from None
    except (UnicodeDecodeError, csv.Error) as error:
        raise BadRecord(f"{shown}: not CSV: {printable(str(error))}") from None


def values(shown: str, number: int, columns: Mapping[str, Any], line: Sequence[str]) -> Iterator[Any]:
    """Yield the values of one line; columns: their kinds by name.  Raises BadRecord."""
    if len(line) != len(columns):
        raise BadRecord(f"{shown}: line {number}: {len(line)} cells: must be {len(columns)}")
    for (name, kind), text in zip(columns.items(), line, strict=True):
        where = f"{shown}: line {number}: {name}"
        try:
            value = reader(kind)(text_of_cell(text))
        except ValueError:
            raise BadRecord(f"{where} = {short(text)}: must be a {'whole ' * (kind in WHOLE)}number") from None
        if kind in WHOLE and value is not None and not 0 <= value <= LARGEST_COUNT:
            raise BadRecord(f"{where} = {short(value)}: must be a whole number from 0 to {LARGEST_COUNT}")
        if isinstance(value, float) and not math.isfinite(value) and not name.endswith(BOUNDLESS):
            raise BadRecord(f"{where} = {value}: must be finite")
        yield value
