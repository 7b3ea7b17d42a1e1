"""The tables of stability maps and extreme cases, by file name."""

from collections.abc import Mapping, Sequence

import pandas as pd

from tumble.compare.run.progress import ProgressCallback, no_progress
from tumble.compare.run.running_engines import RunningEngine
from tumble.compare.run.tasks import Key
from tumble.compare.run.truths import Truths
from tumble.compare.stability.columns import limits_steps
from tumble.compare.stability.contact import ContactPiece
from tumble.compare.stability.extremes import PAGE_BUDGET_S
from tumble.compare.stability.schemas import CELLS, CONTACT_MAP, CONTACT_STEPS, EXTREMES, LIMITS, ExtremeRow
from tumble.compare.stability.tasks import Done, stability
from tumble.compare.stability.trials import BRIEF, Piece
from tumble.compare.tables.frames import frame, rows
from tumble.scenarios.scene import Scene


def tables_of(done: Sequence[Done]) -> dict[str, pd.DataFrame]:
    """Return the tables of pieces.

    Parameters
    ----------
    done : maps with limits, and extreme cases

    Returns
    -------
    table by file name
    """
    mapped = [piece for piece in done if isinstance(piece, Piece)]
    landed = [piece for piece in done if isinstance(piece, ContactPiece)]
    return {
        CELLS.file: frame(CELLS, (row for piece in mapped for row in piece.rows)),
        LIMITS.file: frame(LIMITS, (piece.limit for piece in mapped)),
        EXTREMES.file: frame(EXTREMES, (row for row in done if isinstance(row, ExtremeRow))),
        CONTACT_MAP.file: frame(CONTACT_MAP, (row for piece in landed for row in piece.rows)),
        CONTACT_STEPS.file: frame(CONTACT_STEPS, (piece.step for piece in landed)),
    }


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
    scenes = [scene for scene in scenes if not scene.plane and limits_steps(scene)]
    quickly = {"factors": [1.0], "few": True, "effort": BRIEF, "budget_s": PAGE_BUDGET_S}
    return tables_of(stability(running_engines, scenes, cases, on_progress, truths=truths, **quickly))
