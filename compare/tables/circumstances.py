"""All that numbers depend on, as rows to be kept beside them: whether a folder is of the run that would go on in it."""

import hashlib
import os
from collections.abc import Sequence
from dataclasses import fields, is_dataclass
from pathlib import Path

import numpy as np

from tumble.compare.run.engines.registry import files, is_file
from tumble.compare.run.provenance import ConditionRow, conditions
from tumble.compare.run.running_engines import RunningEngine
from tumble.compare.tables.engines import engine_row
from tumble.compare.tables.files import place
from tumble.compare.tables.frames import read_file, rows
from tumble.compare.tables.shared import CONDITIONS
from tumble.scenarios.scene import Scene

# Another command may ask for the same; on how many cores, and beside what, moves no number.
OF_NO_ACCOUNT = ("command", "cores", "other work")
TABLE = "table "  # before the name of a table that a digest is of


def circumstances(
    running_engines: Sequence[RunningEngine], scenes: Sequence[Scene], asked: dict[str, str], command: str
) -> list[ConditionRow]:
    """Return format, machine, versions, what else was asked for, engines with their files, and the scenes."""
    found = [*conditions(command), *(ConditionRow(what, value) for what, value in asked.items())]
    for running_engine in running_engines:
        methods = ", ".join(
            running_engine.methods if running_engine.only_named else ("all methods", *sorted(running_engine.named))
        )
        own = files(running_engine.engine) if is_file(running_engine.engine) else []
        file = f", file {digest([path.read_bytes() for path in own])}" if own else ""
        found.append(
            ConditionRow(f"engine {running_engine.title}", f"{engine_row(running_engine).version}, {methods}{file}")
        )
    return [*found, *(ConditionRow(f"scene {scene.name}", digest(scene)) for scene in scenes)]


def changed_since(folder: Path, now: Sequence[ConditionRow]) -> str | None:
    """Return the first circumstance that the folder's conditions.csv has otherwise, in words, '' where there is none.

    None: there is no such file.  Raises BadTable, OSError.
    """
    path = place(folder, CONDITIONS.file)
    if not os.path.lexists(path):
        return None
    before = rows(CONDITIONS, read_file(path, CONDITIONS))
    was, here = ({row.what: row.value for row in own if is_of_account(row.what)} for own in (before, now))
    for what in (*here, *was):
        if was.get(what) != here.get(what):
            return f"{what} was {was.get(what, 'not there')}, is {here.get(what, 'not there')}"
    return ""


def binding(rows: Sequence[ConditionRow]) -> list[tuple[str, str]]:
    """Return what must be the same for an answer to be taken up again."""
    return [(row.what, row.value) for row in rows if is_of_account(row.what)]


def is_of_account(what: str) -> bool:
    """Whether numbers may depend on it."""
    return what not in OF_NO_ACCOUNT and not what.startswith(TABLE)


def digest(value: object) -> str:
    """Return sixteen digits that are others for another value, of plain values, arrays and dataclasses of those."""
    return hashlib.sha256(repr(spelled(value)).encode()).hexdigest()[:16]


def spelled(value: object) -> object:
    """Return a value as plain ones, with every digit of its floats."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if is_dataclass(value):
        return [(field.name, spelled(getattr(value, field.name))) for field in fields(value)]
    return [spelled(item) for item in value] if isinstance(value, list | tuple) else value
