"""`tumble ablate`: what leaving out pays."""

import shlex
from argparse import Namespace
from pathlib import Path

from tumble.compare.ablation.optional_features import NOTHING, SCENES, ablate
from tumble.compare.run.running_engines import flights
from tumble.compare.tables.files import write_folder
from tumble.finished import FAILED, exit_code
from tumble.notes import note, progress
from tumble.reports.ablation import ablation_text
from tumble.reports.terminal import console
from tumble.scenarios.read import read_scenes
from tumble.taking_part import taking_part


def main(options: Namespace) -> int:
    """Build every contestant with and without what each scene has no use for; 1 if that alters a motion."""
    scenes = read_scenes(options.scene or SCENES)
    folder = Path(options.output) if options.output else None
    if folder:
        folder.mkdir(parents=True, exist_ok=True)
    with taking_part(options.engine, options) as running_engines:
        with progress(flights(running_engines, scenes) + len(scenes)) as on_progress:
            ablations = [ablate(running_engines, scene, on_progress) for scene in scenes]
        out = console()
        for ablation in ablations:
            for piece in ablation_text(ablation):
                out.print(piece)
        if folder:
            from tumble.compare.ablation.results import ablation_tables  # pandas is slow to load
            from tumble.compare.tables.frames import csv_texts

            write_folder(folder, csv_texts(ablation_tables(ablations, running_engines, shlex.join(options.words))))
            note(f"tables written to {folder}")
    altered = [(row, ablation.resolution_m) for ablation in ablations for row in ablation.altered]
    for row, resolution_m in altered:
        name = f"{row.engine}:{row.method} on {row.scene}"
        note(
            f"{name}: {row.feature} moves it by {row.max_difference_m:.2g} m, beyond the limit of {resolution_m:.2g} m"
        )
    # A row that compares no motions has the status of the flight that was not made.
    rows = [row for ablation in ablations for row in ablation.rows]
    asked = (row.why if row.max_difference_m is None and row.why != NOTHING else "ok" for row in rows)
    return FAILED if altered else exit_code(asked)
