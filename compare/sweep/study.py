"""The studies of `tumble sweep` and `tumble advise`: scenes and contestants in, errors and run times out."""

import logging
from collections.abc import Callable, Sequence
from pathlib import Path

import pandas as pd

from tumble.compare.judge.cost import REFERENCE
from tumble.compare.run.local import Asked
from tumble.compare.run.process.kept import Kept
from tumble.compare.run.progress import Display, no_display
from tumble.compare.run.running_engines import TIME_LIMIT_S, flights
from tumble.compare.run.starting import started
from tumble.compare.run.worker import MEMORY_LIMIT
from tumble.compare.sweep.results import MEASURED, measured
from tumble.compare.sweep.work_precision import Effort, Sweep, sweep
from tumble.compare.tables.circumstances import binding, circumstances
from tumble.compare.tables.engines import engine_row
from tumble.compare.tables.files import write_folder
from tumble.compare.tables.frames import csv_text, frame
from tumble.compare.tables.shared import CONDITIONS, ENGINES
from tumble.compare.tables.store import Store
from tumble.scenarios.scene import Scene

log = logging.getLogger(__name__)

# Advice stops at its tolerance, so its step-size sequences are short.
ADVICE = Effort(budget_s=0.15)
# Run time of a sequence in budgets of one run, whose last levels take 1, 2/3, 1/2, 1/3 ... of one; and of timing.
SEQUENCE, TIMING_S = 5.0, 5.0


def sweep_scenes(
    scenes: Sequence[Scene],
    contestants: Sequence[Asked] = (),
    *,
    reference: str = REFERENCE,
    folder: Path | None = None,
    time_limit: float = TIME_LIMIT_S,
    memory_limit: int = MEMORY_LIMIT,
    command: str = "",
    display: Display = no_display,
    finished: Callable[[Sweep], object] = lambda swept: None,
) -> dict[str, pd.DataFrame]:
    """Measure error and run time of every contestant over a sequence of steps or tolerances.

    Parameters
    ----------
    scenes : the scenes
    contestants : ENGINE[@RELEASE][:METHOD] or FILE[:METHOD] of each; empty: the engines installed with Tumble
    reference : ENGINE:METHOD that run times are divided by
    folder : where the tables are written, scene by scene; a later call continues from there
    time_limit : for each run [s]
    memory_limit : for each engine's process [B]
    command : the command line that repeats the study, for conditions.csv
    display : shows progress
    finished : called with each scene's sweep

    Returns
    -------
    table by file name, including the scenes that the folder already had

    Raises
    ------
    BadEngine : an engine or a method is unknown
    NoTruth : a scene has no reference solution
    """
    if folder:
        folder.mkdir(parents=True, exist_ok=True)
    with started(contestants, time_limit, memory_limit, display) as running_engines:
        asked = {"time limit [s]": f"{time_limit:g}", "reference": reference}
        # A task of the store is a scene: its times can be compared only within the same rounds.
        order = [(scene.name,) for scene in scenes]
        under = circumstances(running_engines, scenes, asked, command)
        store = Store(folder, MEASURED, ["scene"], order, under)
        if resumed := store.resume():
            log.info(resumed)
        cache = Kept(folder, binding(under)) if folder else None
        left = [scene for scene in scenes if (scene.name,) not in store.done]
        try:
            with display(flights(running_engines, left) + len(left)) as on_progress:
                for scene in left:
                    swept = sweep(running_engines, scene, on_progress, kept=cache)
                    finished(swept)
                    store.keep((scene.name,), measured([swept], reference))
        except KeyboardInterrupt:
            names = [name for (name,) in order if (name,) in store.done]
            done = f"{', '.join(names)} {'is' if len(names) == 1 else 'are'} done" if names else "no scene is done yet"
            more = f"; finished sequences are saved in {folder}; run the same command again to continue"
            raise KeyboardInterrupt(f"interrupted; {done}{more if folder else ''}") from None
        finally:
            store.write()
        engines = frame(ENGINES, map(engine_row, running_engines))
        if folder and cache:
            cache.forget()
            write_folder(folder, {ENGINES.file: csv_text(engines)})
        return store.tables | {ENGINES.file: engines, CONDITIONS.file: store.conditions}


def advise_scenes(
    scenes: Sequence[Scene],
    tolerance_m: float,
    contestants: Sequence[Asked] = (),
    *,
    beyond_samples: bool = False,
    time_limit: float = TIME_LIMIT_S,
    memory_limit: int = MEMORY_LIMIT,
    display: Display = no_display,
) -> tuple[list[Sweep], frozenset[str]]:
    """Sweep every scene as far as a tolerance needs.

    Parameters
    ----------
    scenes : the scenes
    tolerance_m : largest acceptable vertex error [m]
    contestants : ENGINE[@RELEASE][:METHOD] or FILE[:METHOD] of each; empty: the engines installed with Tumble
    beyond_samples : also try fixed steps longer than the sampling interval, with errors measured where they end
    time_limit : for each run [s]
    memory_limit : for each engine's process [B]
    display : shows progress

    Returns
    -------
    the sweeps, in the order of the scenes
    ENGINE:METHOD of the contestants that were given with a method

    Raises
    ------
    BadEngine : an engine or a method is unknown
    NoTruth : a scene has no reference solution
    """
    with started(contestants, time_limit, memory_limit, display) as running_engines:
        count = flights(running_engines, scenes)
        seconds = count * SEQUENCE * ADVICE.budget_s + len(scenes) * TIMING_S
        log.info(f"{count} step-size sequences: at most about {seconds:.0f} s")
        with display(count + len(scenes)) as on_progress:
            found = [
                sweep(
                    running_engines,
                    scene,
                    on_progress,
                    ADVICE,
                    enough_m=tolerance_m,
                    beyond_samples=beyond_samples,
                )
                for scene in scenes
            ]
        return found, frozenset(f"{one.title}:{method}" for one in running_engines for method in one.named)
