"""`tumble ablate`: the time saved by switching off features that a scene does not need."""

import shlex
from argparse import Namespace
from pathlib import Path

from tumble.compare.ablation.optional_features import NOTHING, SCENES
from tumble.compare.ablation.study import ablate_scenes
from tumble.finished import FAILED, exit_code
from tumble.notes import display, note
from tumble.reports.ablation import ablation_text
from tumble.reports.terminal import console
from tumble.scenarios.read import read_scenes


def main(options: Namespace) -> int:
    """Print, and write if asked, the cost of features that a scene does not need; return 1 if one alters a motion."""
    scenes = read_scenes(options.scene or SCENES)
    folder = Path(options.output) if options.output else None
    if folder:
        folder.mkdir(parents=True, exist_ok=True)
    found = ablate_scenes(
        scenes,
        options.engine,
        time_limit=options.time_limit,
        memory_limit=options.memory_limit,
        display=display(options),
    )
    out = console()
    for ablation in found.ablations:
        for piece in ablation_text(ablation):
            out.print(piece)
    if folder:
        from tumble.compare.ablation.results import ablation_tables  # pandas is slow to load
        from tumble.compare.tables.frames import write_tables

        write_tables(folder, ablation_tables(found.ablations, found.engines, shlex.join(options.words)))
        note(f"tables written to {folder}")
    altered = [(row, ablation.resolution_m) for ablation in found.ablations for row in ablation.altered]
    for row, resolution_m in altered:
        name = f"{row.engine}:{row.method} on {row.scene}"
        note(
            f"{name}: {row.feature} moves a vertex by {row.max_difference_m:.2g} m, more than the resolution of "
            f"{resolution_m:.2g} m"
        )
    # A row that compares no motions has the status of the run that failed.
    rows = [row for ablation in found.ablations for row in ablation.rows]
    statuses = (row.why if row.max_difference_m is None and row.why != NOTHING else "ok" for row in rows)
    return FAILED if altered else exit_code(statuses)
