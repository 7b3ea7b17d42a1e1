"""The study of the motion itself: scenes and contestants in, finely sampled runs out."""

from collections.abc import Sequence

import pandas as pd

from tumble.compare.motion.film import film
from tumble.compare.motion.findings import film_findings
from tumble.compare.motion.results import film_tables
from tumble.compare.run.local import Asked
from tumble.compare.run.progress import Display, no_display
from tumble.compare.run.running_engines import TIME_LIMIT_S, flights
from tumble.compare.run.starting import started
from tumble.compare.run.worker import MEMORY_LIMIT
from tumble.compare.tables.frames import frame
from tumble.compare.tables.shared import FINDINGS
from tumble.scenarios.scene import Scene


def film_scenes(
    scenes: Sequence[Scene],
    contestants: Sequence[Asked] = (),
    *,
    dt: float | None = None,
    time_limit: float = TIME_LIMIT_S,
    memory_limit: int = MEMORY_LIMIT,
    display: Display = no_display,
) -> dict[str, pd.DataFrame]:
    """Run every scene with every contestant, sampled finely enough to be watched.

    Parameters
    ----------
    scenes : the scenes
    contestants : ENGINE[@RELEASE][:METHOD] or FILE[:METHOD] of each; empty: every installed engine
    dt : step [s]; None: each scene's own
    time_limit : for each run [s]
    memory_limit : for each engine's process [B]
    display : shows progress

    Returns
    -------
    table by file name

    Raises
    ------
    BadEngine : an engine or a method is unknown
    """
    with (
        started(contestants, time_limit, memory_limit, display) as running_engines,
        display(flights(running_engines, scenes) + len(scenes), "sampling the motion") as on_progress,
    ):
        films = film(running_engines, scenes, dt, on_progress)
    return film_tables(films) | {FINDINGS.file: frame(FINDINGS, film_findings(films))}
