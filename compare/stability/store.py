"""The tables of pieces that are done: one contestant in one scene or extreme case."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import pandas as pd

from compare.run.participants import Participant
from compare.run.progress import Tick, untold
from compare.run.provenance import ConditionRow
from compare.stability.schemas import CELLS, EXTREMES, LIMITS, TABLES, ExtremeRow
from compare.stability.tasks import Done, Key, keys, stability
from compare.stability.trials import Piece
from compare.tables.frames import frame, rows
from compare.tables.shared import CONTESTANT
from compare.tables.store import Store
from scenarios.scene import Scene


def store(folder: Path | None, order: Sequence[Key], under: Sequence[ConditionRow] = ()) -> Store:
    """Return what keeps pieces; order: their keys; under: the circumstances."""
    return Store(folder, TABLES, CONTESTANT, order, under)


def tables_of(piece: Done) -> dict[str, pd.DataFrame]:
    """Return the rows of a piece, by table."""
    if isinstance(piece, ExtremeRow):
        return {EXTREMES.file: frame(EXTREMES, [piece])}
    return {CELLS.file: frame(CELLS, piece.rows), LIMITS.file: frame(LIMITS, [piece.limit])}


def pieces(tables: Mapping[str, pd.DataFrame]) -> list[Piece]:
    """Return the scenes' pieces of tables."""
    maps: dict[Key, list] = {}
    for row in rows(CELLS, tables[CELLS.file]):
        maps.setdefault((row.scene, row.engine, row.method), []).append(row)
    return [
        Piece(tuple(maps[limit.scene, limit.engine, limit.method]), limit)
        for limit in rows(LIMITS, tables[LIMITS.file])
    ]


def quick_tables(
    participants: Sequence[Participant], scenes: Sequence[Scene], tick: Tick = untold
) -> dict[str, pd.DataFrame]:
    """Return the tables of scenes at their own values only, of nobody who takes part only on request.

    They have the limits, and one row of each map.
    """
    found = store(None, keys(participants, scenes, [], few=True))

    def keep(piece: Done) -> None:
        found.keep(piece.key, tables_of(piece))

    stability(participants, scenes, [], keep, tick, factors=[1.0], few=True)
    return found.tables
