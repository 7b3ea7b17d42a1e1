"""`tumble report`: the page."""

import shlex
from argparse import Namespace
from pathlib import Path

from compare.ablation.ablation import QUICK_SPAN_S, ablate
from compare.ablation.results import ablation_tables
from compare.comparison.against_truth import compare
from compare.comparison.results import comparison_tables
from compare.judge.cost import REFERENCE
from compare.run.flight import check_step
from compare.run.participants import flights, launched
from compare.stability.store import kept_tables, quick_tables
from compare.stability.tasks import STIFF
from compare.sweep.results import measured
from compare.sweep.sweep import QUICK_BUDGET_S, YARDSTICK, sweep
from compare.tables.files import write_folder, write_whole
from compare.tables.frames import csv_texts
from reports.page import page
from scenarios.needs import needs
from scenarios.read import catalogue, read_scenes
from tumble.notes import note, progress


def main(options: Namespace) -> int:
    """Put every scene to every contestant, write the tables, and make the page from them."""
    file = Path(options.output)
    folder = file.with_name(f"{file.stem}-tables")
    scenes = read_scenes(options.scene or catalogue())
    for scene in scenes:
        check_step(scene, options.dt)
    # A sweep takes seconds a scene: the catalogue is judged on its yardstick, scenes asked for by name on themselves.
    swept = [scene for scene in scenes if options.scene or scene.name == YARDSTICK]
    folder.mkdir(parents=True, exist_ok=True)
    with launched(options.engine, options.time_limit) as participants:
        with progress(flights(participants, (*scenes, *swept)) + len(scenes) + len(swept) + 1) as tick:
            command = shlex.join(options.words)
            comparisons = compare(participants, scenes, options.dt, tick)
            frames = comparison_tables(comparisons, participants, command)
            judged = [each.scene for each in comparisons if each.truth]
            sweeps = [sweep(participants, scene, tick, QUICK_BUDGET_S) for scene in swept if scene in judged]
            plainest = min(scenes, key=lambda scene: len(needs(scene)))
            ablation = ablate(participants, plainest, tick, QUICK_SPAN_S, most_methods=1)
            frames["ablation.csv"] = ablation_tables([ablation], participants, command)["ablation.csv"]
            frames |= {f"sweep-{name}": table for name, table in measured(sweeps, REFERENCE).items()}
            # All maps take a minute or two: those that `tumble stability -o` left there are drawn, else one row of one.
            frames |= kept_tables(folder / "stability")
            if "limits.csv" not in frames:
                frames |= quick_tables(participants, [scene for scene in scenes if scene.name == STIFF[0]], tick)
            tick("drawing the page")
            texts = csv_texts(frames)
            html = page(texts)
        write_folder(folder, texts)
        write_whole(file, html)
        note(f"page written to {file}, its tables to {folder}")
    return 0
