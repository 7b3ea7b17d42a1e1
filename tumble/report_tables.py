"""All tables of the report: several studies of the same scenes and engines, side by side where no clock is read."""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from contextvars import copy_context
from functools import partial
from pathlib import Path
from typing import TypeVar

import pandas as pd

from tumble.compare.ablation.findings import ablation_findings
from tumble.compare.ablation.optional_features import QUICK, timed, untimed
from tumble.compare.ablation.schemas import ABLATION
from tumble.compare.comparison.against_truth import Comparison, compare
from tumble.compare.comparison.results import comparison_tables
from tumble.compare.contact.results import contact_tables
from tumble.compare.contact.schemas import TABLES as CONTACT
from tumble.compare.contact.study import BRIEF as BRIEF_CONTACT
from tumble.compare.contact.study import WHOLE, Contact, Extent, contacts
from tumble.compare.coursework.results import coursework_tables
from tumble.compare.judge.cost import REFERENCE
from tumble.compare.judge.errors import Run
from tumble.compare.motion.film import Film, filmed, films
from tumble.compare.motion.findings import film_findings
from tumble.compare.motion.results import film_tables
from tumble.compare.releases.schemas import TABLES as RELEASES
from tumble.compare.run.execution import Parts
from tumble.compare.run.flight import check_step
from tumble.compare.run.local import Asked
from tumble.compare.run.progress import Display, ProgressCallback, no_display
from tumble.compare.run.provenance import conditions
from tumble.compare.run.running_engines import TIME_LIMIT_S, RunningEngine, flights
from tumble.compare.run.starting import started
from tumble.compare.run.truths import Answered, Truths
from tumble.compare.run.worker import MEMORY_LIMIT
from tumble.compare.stability.extremes import OF_A_PAGE
from tumble.compare.stability.findings import extreme_findings, limit_findings
from tumble.compare.stability.results import quick_tables
from tumble.compare.stability.schemas import EXTREMES, LIMITS
from tumble.compare.stability.schemas import TABLES as STABILITY
from tumble.compare.stability.tasks import STIFF
from tumble.compare.sweep.results import measured
from tumble.compare.sweep.work_precision import BRIEF, YARDSTICK, against_the_clock, ladders
from tumble.compare.tables.engines import engine_row
from tumble.compare.tables.frames import frame, kept_tables, merged, rows
from tumble.compare.tables.known import SWEEP
from tumble.compare.tables.shared import CONDITIONS, FINDINGS
from tumble.scenarios.needs import needs
from tumble.scenarios.read import read_scene
from tumble.scenarios.scene import Scene
from tumble.scenarios.truth import NoTruth

Tables = dict[str, pd.DataFrame]
Result = TypeVar("Result")
# What a page of the whole catalogue runs above a plane: friction by direction, what holds, rebound by drop height.
LANDING = ("box-slide-22", "box-incline-holds", "ball-drop-half")


def report_tables(
    scenes: Sequence[Scene],
    contestants: Sequence[Asked] = (),
    *,
    dt: float | None = None,
    every_method: bool = False,
    whole_catalogue: bool = False,
    folder: Path | None = None,
    time_limit: float = TIME_LIMIT_S,
    memory_limit: int = MEMORY_LIMIT,
    command: str = "",
    display: Display = no_display,
) -> Tables:
    """Run all studies that the report shows.

    Parameters
    ----------
    scenes : the scenes
    contestants : ENGINE[@RELEASE][:METHOD] or FILE[:METHOD] of each; empty: the engines installed with Tumble
    dt : step [s]; None: each scene's own
    every_method : every method of every engine, not only each engine's defaults and best
    whole_catalogue : the scenes are the catalogue: sweep its benchmark scene only, and add extreme cases
    folder : may have tables of `stability -o` and `releases -o` in folders of these names, which are used
    time_limit : for each run [s]
    memory_limit : for each engine's process [B]
    command : the command line that repeats the report, for conditions.csv
    display : shows progress

    Returns
    -------
    table by file name

    Raises
    ------
    BadEngine : an engine or a method is unknown
    BadStep : the step does not suit a scene
    BadTable : a table in the folder cannot be read
    """
    for scene in scenes:
        check_step(scene, dt)
    # A sweep takes seconds a scene.
    swept = [scene for scene in scenes if not whole_catalogue or scene.name == YARDSTICK]
    # All maps take a minute or two: without saved ones, the page has one row of each.
    maps = kept_tables(folder / "stability", STABILITY) if folder else {}
    stiff = [] if maps else [scene for scene in scenes if scene.name in STIFF or not scene.is_free]
    cases = [read_scene(name) for name in OF_A_PAGE] if whole_catalogue and not maps else []
    added = [read_scene(name) for name in LANDING] if whole_catalogue else []
    landing = [scene for scene in (*scenes, *added) if scene.plane]
    extent = BRIEF_CONTACT if whole_catalogue and not every_method else WHOLE
    sensing = [scene for scene in scenes if scene.sensors]
    runs = (*scenes, *swept, *stiff, *cases, *sensing)
    others = 2 * len(scenes) + len(swept) + len(stiff) + len(cases) + len(added)
    with (
        started(contestants, time_limit, memory_limit, display, few=not every_method) as running_engines,
        display(flights(running_engines, runs) + extent.runs(running_engines, landing) + others) as on_progress,
    ):
        # Studies that read no clock run side by side, so that no core waits for another's longest task.
        with ThreadPoolExecutor(4) as beside:
            try:
                # A film's instants include the scene's own, so one reference serves both; a film has one throw.
                watched = [filmed(scene, dt or scene.step) for scene in scenes]
                several = [scene for scene in scenes if len(scene.start) > 1]
                with Truths([*watched, *several, *added], on_progress, limit_s=time_limit) as truths:

                    def begin(study: Callable[..., Result], *given: object) -> Future[Result]:
                        """Start a study in a thread, which is given the execution of this one."""
                        return beside.submit(copy_context().run, study, running_engines, *given)

                    mapping = begin(quick_tables, stiff, cases, on_progress, truths)
                    climbing = begin(all_ladders, swept, on_progress, truths)
                    landing_runs = begin(all_contacts, landing, dt, on_progress, truths, extent)
                    plainest = min(scenes, key=lambda scene: len(needs(scene)))
                    ablating = begin(untimed, plainest, on_progress, 1)
                    with Parts() as part:
                        comparisons = part(lambda: compare(running_engines, scenes, dt, on_progress, truths, watched))
                        # A shard has no comparison, and makes no tables.
                        shots = films_of(comparisons, watched, dt, truths) if comparisons else []
                        compared = compared_tables(comparisons, shots, running_engines, command) if comparisons else {}
                        sequences, mapped = part(climbing.result), part(mapping.result)
                        landed, untimed_runs = part(landing_runs.result), part(ablating.result)
                    maps = maps or mapped
            except BaseException:
                for running_engine in running_engines:
                    running_engine.halt(for_good=True)  # also a study that begins only now
                raise
        sweeps = [
            against_the_clock(running_engines, scene, runs, on_progress, BRIEF, REFERENCE) for scene, runs in sequences
        ]
        ablation = timed(untimed_runs, on_progress, QUICK)
    swept_tables = measured(sweeps, REFERENCE)
    tables = merged(
        compared,
        maps,
        # Without rows where there is none: a table of an earlier run is removed.
        (kept_tables(folder / "releases", RELEASES) if folder else {})
        or {table.file: frame(table, []) for table in RELEASES},
        contact_tables(landed) or {table.file: frame(table, []) for table in CONTACT},
        {ABLATION.file: frame(ABLATION, ablation.rows)},
        {(SWEEP if name != FINDINGS.file else "") + name: table for name, table in swept_tables.items()},
        findings([*film_findings(shots), *ablation_findings(ablation.rows), *map_findings(maps)]),
    )
    # Now that times have been taken, they say under what load.
    return tables | {CONDITIONS.file: frame(CONDITIONS, conditions(command))}


def compared_tables(
    comparisons: Sequence[Comparison], films: Sequence[Film], running_engines: Sequence[RunningEngine], command: str
) -> Tables:
    """Return the tables of what is run at the scenes' own steps."""
    engines = list(map(engine_row, running_engines))
    return merged(comparison_tables(comparisons, engines, command), coursework_tables(comparisons), film_tables(films))


def films_of(
    comparisons: Sequence[Comparison], watched: Sequence[Scene], dt: float | None, truths: Truths
) -> list[Film]:
    """Return the films of scenes that were compared."""
    true = [truths.answer(scene).truth for scene in watched]
    return films(watched, true, [each.watched for each in comparisons], dt)


def map_findings(maps: Mapping[str, pd.DataFrame]) -> list:
    """Return what stability maps and extreme cases found."""
    return [
        *limit_findings(rows(LIMITS, maps[LIMITS.file])),
        *extreme_findings(rows(EXTREMES, maps[EXTREMES.file])),
    ]


def findings(found: Sequence) -> Tables:
    """Return findings as a table."""
    return {FINDINGS.file: frame(FINDINGS, found)}


def all_contacts(
    running_engines: Sequence[RunningEngine],
    scenes: Sequence[Scene],
    dt: float | None,
    on_progress: ProgressCallback,
    truths: Truths,
    extent: Extent,
) -> list[Contact]:
    """Return what every contestant makes of contact in the scenes that have a reference solution."""
    known = [Answered(scene, truths.answer(scene).truth) for scene in scenes]
    return contacts(running_engines, known, dt, on_progress, extent)


def all_ladders(
    running_engines: Sequence[RunningEngine], scenes: Sequence[Scene], on_progress: ProgressCallback, truths: Truths
) -> list[tuple[Scene, list[Run]]]:
    """Return the step-size sequences of the scenes that have a reference solution."""
    found = []
    with Parts() as part:
        for scene in scenes:
            climb = partial(ladders, running_engines, scene, on_progress, BRIEF, truths=truths)
            with suppress(NoTruth):
                found.append((scene, part(climb)))
    return found
