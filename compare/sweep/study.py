"""The studies of `tumble sweep` and `tumble advise`: scenes and contestants in, errors and run times out."""

import logging
from collections.abc import Callable, Sequence

import pandas as pd

from tumble.compare.contact.study import ask
from tumble.compare.judge.cost import REFERENCE
from tumble.compare.run.execution import Parts
from tumble.compare.run.local import Asked
from tumble.compare.run.progress import Display, no_display
from tumble.compare.run.running_engines import TIME_LIMIT_S, flights
from tumble.compare.run.starting import started
from tumble.compare.run.worker import MEMORY_LIMIT
from tumble.compare.sweep.observable import observed_in, with_observable
from tumble.compare.sweep.results import measured
from tumble.compare.sweep.work_precision import Effort, Sweep, sweep
from tumble.compare.tables.circumstances import circumstances
from tumble.compare.tables.engines import engine_row
from tumble.compare.tables.frames import frame
from tumble.compare.tables.shared import CONDITIONS, ENGINES
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
    observable: str | None = None,
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
    observable : observable whose error is measured in the scenes with a plane; None: each scene's main one
    time_limit : for each run [s]
    memory_limit : for each engine's process [B]
    command : the command line that repeats the study, for conditions.csv
    display : shows progress
    finished : called with each scene's sweep

    Returns
    -------
    table by file name, with engines and conditions

    Raises
    ------
    BadEngine : an engine or a method is unknown
    NoTruth : a scene has no reference solution
    BadObservable : a scene does not have the observable
    """
    observed = {scene.name: one for scene in scenes if (one := observed_in(scene, observable, time_limit))}
    with started(contestants, time_limit, memory_limit, display) as running_engines:
        asked = {"time limit [s]": f"{time_limit:g}", "reference": reference}
        sweeps = []
        landing = [scene for scene in scenes if scene.name in observed]
        with display(flights(running_engines, [*scenes, *landing]) + len(scenes)) as on_progress, Parts() as part:
            for scene in scenes:
                swept = part(lambda scene=scene: sweep(running_engines, scene, on_progress, reference=reference))
                own = observed.get(scene.name)
                questions = [own.question] if own else []
                seen = part(lambda questions=questions: ask(running_engines, questions, on_progress))
                if swept and seen is not None:
                    sweeps.append(with_observable(swept, own, seen) if own else swept)
                    finished(sweeps[-1])
        return measured(sweeps, reference) | {
            ENGINES.file: frame(ENGINES, map(engine_row, running_engines)),
            # At the end: with what the machine did while times were taken.
            CONDITIONS.file: frame(CONDITIONS, circumstances(running_engines, scenes, asked, command)),
        }


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
