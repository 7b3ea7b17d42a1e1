"""`tumble report`: the page, of what is flown now or of tables that are there."""

import shlex
from argparse import Namespace
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path

import pandas as pd

from tumble.compare.ablation.findings import ablation_findings
from tumble.compare.ablation.optional_features import QUICK, ablate
from tumble.compare.ablation.schemas import ABLATION
from tumble.compare.comparison.against_truth import compare
from tumble.compare.comparison.results import comparison_tables
from tumble.compare.judge.cost import REFERENCE
from tumble.compare.judge.errors import Run
from tumble.compare.motion.film import film, filmed
from tumble.compare.motion.findings import film_findings
from tumble.compare.motion.results import film_tables
from tumble.compare.releases.schemas import TABLES as RELEASES
from tumble.compare.run.flight import check_step
from tumble.compare.run.progress import ProgressCallback
from tumble.compare.run.running_engines import RunningEngine, flights
from tumble.compare.run.truths import Truths
from tumble.compare.stability.extremes import OF_A_PAGE
from tumble.compare.stability.findings import extreme_findings, limit_findings
from tumble.compare.stability.schemas import EXTREMES, LIMITS
from tumble.compare.stability.schemas import TABLES as STABILITY
from tumble.compare.stability.store import quick_tables
from tumble.compare.stability.tasks import STIFF
from tumble.compare.sweep.results import measured
from tumble.compare.sweep.work_precision import BRIEF, YARDSTICK, against_the_clock, ladders
from tumble.compare.tables.files import write_folder, write_whole
from tumble.compare.tables.frames import csv_texts, frame, kept_tables, rows
from tumble.compare.tables.known import SWEEP
from tumble.compare.tables.schema import BadTable
from tumble.compare.tables.shared import FINDINGS, RUNS
from tumble.finished import exit_code
from tumble.notes import note, progress
from tumble.reports.folders import changes, gathered
from tumble.reports.page import page
from tumble.scenarios.needs import needs
from tumble.scenarios.read import catalogue, read_scene, read_scenes
from tumble.scenarios.scene import Scene
from tumble.scenarios.truth import NoTruth
from tumble.taking_part import taking_part


def main(options: Namespace) -> int:
    """Make the page, and beside it the tables that it is made from unless they were there."""
    file = Path(options.output)
    if options.sources:
        with progress(doing="drawing the page"):
            write_whole(file, page(found(options)))
        note(f"page written to {file}")
        return 0
    folder = file.with_name(f"{file.stem}-tables")
    scenes = read_scenes(options.scene or catalogue())
    for scene in scenes:
        check_step(scene, options.dt)
    folder.mkdir(parents=True, exist_ok=True)
    frames = flown(options, scenes, folder)
    with progress(doing="drawing the page"):
        html = page(frames)
        write_folder(folder, csv_texts(frames))
        write_whole(file, html)
    note(f"page written to {file}, its tables to {folder}")
    return exit_code(frames[RUNS.file].status)


def found(options: Namespace) -> Mapping[str, pd.DataFrame]:
    """Return the tables of the folders asked for: of one as they are, of two the later with what changed since.

    Raises BadTable.
    """
    if options.scene or options.engine or options.dt or options.all:
        raise BadTable("--from draws what is there: SCENE, --engine, --dt and --all cannot be asked for with it")
    if len(options.sources) > 2:
        raise BadTable("--from: at most two folders, the earlier first")
    tables = [gathered(Path(source)) for source in options.sources]
    return tables[-1] | (changes(*tables) if len(tables) > 1 else {})


def flown(options: Namespace, scenes: list[Scene], folder: Path) -> dict[str, pd.DataFrame]:
    """Put every scene to every contestant and return the tables; folder: where maps of stability may lie."""
    # A sweep takes seconds a scene: the catalogue is judged on its yardstick, scenes asked for by name on themselves.
    swept = [scene for scene in scenes if options.scene or scene.name == YARDSTICK]
    # All maps take a minute or two: those that `tumble stability -o` left there are drawn, else one row of one.
    maps = kept_tables(folder / "stability", STABILITY)
    stiff = [] if maps else [scene for scene in scenes if scene.name in STIFF or not scene.is_free]
    cases = [] if maps or options.scene else [read_scene(name) for name in OF_A_PAGE]
    asked = (*scenes, *scenes, *swept, *stiff, *cases)
    with (
        taking_part(options.engine, options, few=not options.all) as running_engines,
        progress(
            flights(running_engines, asked) + 2 * len(scenes) + len(swept) + len(stiff) + len(cases)
        ) as on_progress,
    ):
        # What no clock reads is flown side by side, so that no core waits for another's longest task.
        with ThreadPoolExecutor(2) as beside:
            try:
                # A film's instants hold the scene's own, so that a truth of them is that of both; it has one throw.
                watched = [filmed(scene, options.dt or scene.step) for scene in scenes]
                several = [scene for scene in scenes if len(scene.start) > 1]
                with Truths([*watched, *several], on_progress, limit_s=options.time_limit) as truths:
                    mapping = beside.submit(quick_tables, running_engines, stiff, cases, on_progress, truths)
                    climbing = beside.submit(climbed, running_engines, swept, on_progress, truths)
                    comparisons = compare(running_engines, scenes, options.dt, on_progress, truths)
                    films = film(running_engines, scenes, options.dt, on_progress, truths)
                    frames = comparison_tables(comparisons, running_engines, shlex.join(options.words))
                    frames |= film_tables(films)
                    ladders_of, frames = climbing.result(), frames | (maps or mapping.result())
            except BaseException:
                for running_engine in running_engines:
                    running_engine.halt(for_good=True)  # a study that begins only now, too
                raise
        sweeps = [against_the_clock(running_engines, scene, runs, on_progress, BRIEF) for scene, runs in ladders_of]
        plainest = min(scenes, key=lambda scene: len(needs(scene)))
        ablation = ablate(running_engines, plainest, on_progress, QUICK, most_methods=1)
    frames |= kept_tables(folder / "releases", RELEASES)  # as `tumble releases -o` left them there
    swept_tables = measured(sweeps, REFERENCE)
    frames["ablation.csv"] = frame(ABLATION, ablation.rows)
    frames |= {f"{SWEEP}{name}": table for name, table in swept_tables.items() if name != FINDINGS.file}
    found = [
        *film_findings(films),
        *ablation_findings(ablation.rows),
        *limit_findings(rows(LIMITS, frames[LIMITS.file])),
        *extreme_findings(rows(EXTREMES, frames[EXTREMES.file])),
    ]
    frames[FINDINGS.file] = pd.concat(
        [frames[FINDINGS.file], swept_tables[FINDINGS.file], frame(FINDINGS, found)], ignore_index=True
    )
    return frames


def climbed(
    running_engines: Sequence[RunningEngine], scenes: Sequence[Scene], on_progress: ProgressCallback, truths: Truths
) -> list[tuple[Scene, list[Run]]]:
    """Return the ladders of the scenes that have a truth to be held against."""
    found = []
    for scene in scenes:
        with suppress(NoTruth):
            found.append((scene, ladders(running_engines, scene, on_progress, BRIEF, truths=truths)))
    return found
