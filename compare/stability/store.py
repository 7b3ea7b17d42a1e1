"""The tables of finished pieces: one contestant in one scene or extreme case."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import pandas as pd

from tumble.compare.run.progress import ProgressCallback, no_progress
from tumble.compare.run.provenance import ConditionRow
from tumble.compare.run.running_engines import RunningEngine
from tumble.compare.run.truths import Truths
from tumble.compare.stability.columns import limits_steps
from tumble.compare.stability.extremes import PAGE_BUDGET_S
from tumble.compare.stability.schemas import CELLS, EXTREMES, LIMITS, TABLES, ExtremeRow
from tumble.compare.stability.tasks import Done, Key, keys, stability
from tumble.compare.stability.trials import BRIEF, Piece
from tumble.compare.tables.frames import frame, rows
from tumble.compare.tables.shared import CONTESTANT
from tumble.compare.tables.store import Store
from tumble.scenarios.scene import Scene


def store(folder: Path | None, order: Sequence[Key], under: Sequence[ConditionRow] = ()) -> Store:
    """Return the store of pieces; order: their keys; under: the conditions."""
    return Store(folder, TABLES, CONTESTANT, order, under)


def tables_of(piece: Done) -> dict[str, pd.DataFrame]:
    """Return the rows of a piece, by table."""
    if isinstance(piece, ExtremeRow):
        return {EXTREMES.file: frame(EXTREMES, [piece])}
    return {CELLS.file: frame(CELLS, piece.rows), LIMITS.file: frame(LIMITS, [piece.limit])}


def pieces(tables: Mapping[str, pd.DataFrame]) -> list[Piece]:
    """Return the maps and limits of contestants, from tables.

    Parameters
    ----------
    tables : of `tumble stability`, by file name

    Returns
    -------
    one piece per contestant and mapped scene
    """
    maps: dict[Key, list] = {}
    for row in rows(CELLS, tables[CELLS.file]):
        maps.setdefault((row.scene, row.engine, row.method), []).append(row)
    return [
        Piece(tuple(maps[limit.scene, limit.engine, limit.method]), limit)
        for limit in rows(LIMITS, tables[LIMITS.file])
    ]


def quick_tables(
    running_engines: Sequence[RunningEngine],
    scenes: Sequence[Scene],
    cases: Sequence[Scene] = (),
    on_progress: ProgressCallback = no_progress,
    truths: Truths | None = None,
) -> dict[str, pd.DataFrame]:
    """Return the tables for a page: scenes at their own parameter values, with usual contestants only.

    Parameters
    ----------
    running_engines : with their methods
    scenes : mapped, those whose step is limited
    cases : extreme cases
    on_progress : called for every piece
    truths : computes the reference solutions; None: new ones

    Returns
    -------
    table by file name
    """
    scenes = [scene for scene in scenes if limits_steps(scene)]
    found = store(None, keys(running_engines, scenes, cases, few=True))

    def keep(piece: Done) -> None:
        found.keep(piece.key, tables_of(piece))

    quickly = {"factors": [1.0], "few": True, "effort": BRIEF, "budget_s": PAGE_BUDGET_S}
    stability(running_engines, scenes, cases, keep, on_progress, truths=truths, **quickly)
    return found.tables
