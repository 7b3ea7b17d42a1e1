"""The study of `tumble stability`: scenes and contestants in, stability maps and extreme cases out."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import pandas as pd

from tumble.compare.run.execution import Incomplete, resumable
from tumble.compare.run.local import Asked
from tumble.compare.run.progress import Display, no_display
from tumble.compare.run.starting import started
from tumble.compare.run.tasks import Key
from tumble.compare.run.worker import MEMORY_LIMIT
from tumble.compare.stability.findings import extreme_findings, limit_findings
from tumble.compare.stability.results import tables_of
from tumble.compare.stability.schemas import EXTREMES, LIMITS
from tumble.compare.stability.tasks import Done, keys, stability
from tumble.compare.tables.circumstances import circumstances
from tumble.compare.tables.frames import frame, rows, write_tables
from tumble.compare.tables.shared import CONDITIONS, FINDINGS
from tumble.scenarios.read import extremes
from tumble.scenarios.scene import Scene

RUN_LIMIT_S = 20.0


def map_scenes(
    scenes: Sequence[Scene],
    contestants: Sequence[Asked] = (),
    *,
    folder: Path | None = None,
    time_limit: float = RUN_LIMIT_S,
    memory_limit: int = MEMORY_LIMIT,
    command: str = "",
    display: Display = no_display,
    ended: Callable[[Mapping[str, pd.DataFrame]], object] = lambda tables: None,
) -> dict[str, pd.DataFrame]:
    """Map the stability of every contestant in every scene, and run the extreme cases.

    Parameters
    ----------
    scenes : extreme cases, by their names, are run as they are; the others are mapped over the step and over the
        number that makes each stiff
    contestants : ENGINE[@RELEASE][:METHOD] or FILE[:METHOD] of each; empty: the engines installed with Tumble
    folder : where the tables are written; if the call is interrupted, the next one continues from there
    time_limit : for each run [s]
    memory_limit : for each engine's process [B]
    command : the command line that repeats the study, for conditions.csv
    display : shows progress
    ended : called with the tables when the study ends, also with those of its part where it fails or is interrupted,
        but not of a shard, which has no tables

    Returns
    -------
    table by file name

    Raises
    ------
    BadEngine : an engine or a method is unknown
    BadScene : nothing in a scene limits the step
    NoTruth : an extreme case has no reference solution
    """
    known = extremes()
    mapped = [scene for scene in scenes if scene.name not in known]
    cases = [scene for scene in scenes if scene.name in known]
    with started(contestants, time_limit, memory_limit, display) as running_engines:
        asked = {"time limit [s]": f"{time_limit:g}"}
        conditions = circumstances(running_engines, [*mapped, *cases], asked, command)
        order = keys(running_engines, mapped, cases)
        pieces: dict[Key, Done] = {}
        with resumable(folder):
            try:
                with display(len(order)) as on_progress:
                    stability(running_engines, mapped, cases, on_progress, pieces.__setitem__)
            except Incomplete:
                raise
            except BaseException:
                ended(tables_of([pieces[key] for key in order if key in pieces]))
                raise
            tables = tables_of([pieces[key] for key in order])
            ended(tables)
            found = [
                *limit_findings(rows(LIMITS, tables[LIMITS.file])),
                *extreme_findings(rows(EXTREMES, tables[EXTREMES.file])),
            ]
            tables |= {FINDINGS.file: frame(FINDINGS, found), CONDITIONS.file: frame(CONDITIONS, conditions)}
            if folder:
                write_tables(folder, tables)
    return tables
