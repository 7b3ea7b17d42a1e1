"""Everything that results depend on, as rows of conditions.csv."""

import hashlib
from collections.abc import Sequence
from dataclasses import fields, is_dataclass

import numpy as np

from tumble.compare.run.engines.registry import files, is_file
from tumble.compare.run.provenance import ConditionRow, conditions
from tumble.compare.run.running_engines import RunningEngine
from tumble.compare.tables.engines import engine_row
from tumble.scenarios.scene import Scene

# Another command may ask for the same; the number of cores, and other processes on them, change no result.
IRRELEVANT = ("command", "cores", "other work")


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


def binding(rows: Sequence[ConditionRow]) -> list[tuple[str, str]]:
    """Return the circumstances that must be the same for a cached result to be used."""
    return [(row.what, row.value) for row in rows if row.what not in IRRELEVANT]


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
