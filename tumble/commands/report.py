"""`tumble report`: the page."""

import shlex
from argparse import Namespace
from pathlib import Path

from compare.contest import compare, crew
from compare.flight import check_step
from compare.results import SWEEP_TABLES, sweep_tables, tables, write_tables
from compare.sweep import QUICK_BUDGET_S, REFERENCE, YARDSTICK, sweep
from compare.tables import write_whole
from reports.page import page
from scenarios.read import BadScene, catalogue, read_scene
from scenarios.truth import has_truth
from tumble.notes import note, progress


def main(options: Namespace) -> int:
    """Put every scene to every contestant, write the tables, and make the page from them."""
    file = Path(options.output)
    folder = file.with_name(f"{file.stem}-tables")
    scenes = [read_scene(name) for name in dict.fromkeys(options.scene) or catalogue()]
    for number, scene in enumerate(scenes):
        check_step(scene, options.dt)
        if any(scene.name == other.name for other in scenes[:number]):
            raise BadScene(f"two scenes are named {scene.name!r}: rename one of the files")
    # A sweep takes seconds a scene: the catalogue is judged on its yardstick, scenes asked for by name on themselves.
    swept = [scene for scene in scenes if (options.scene or scene.name == YARDSTICK) and has_truth(scene)]
    folder.mkdir(parents=True, exist_ok=True)
    with crew(options.engine, options.time_limit) as entrants:
        methods = sum(len(entrant.methods) for entrant in entrants)
        with progress((len(scenes) + len(swept)) * (1 + methods) + 1) as tick:
            command = shlex.join(options.words)
            texts = tables(compare(entrants, scenes, options.dt, tick), entrants, command)
            sweeps = [sweep(entrants, scene, tick, QUICK_BUDGET_S) for scene in swept]
            costs = sweep_tables(sweeps, entrants, REFERENCE, command)
            texts |= {f"sweep-{name}": costs[name] for name in SWEEP_TABLES}
            tick("drawing the page")
            html = page(texts)
        write_tables(folder, texts)
        write_whole(file, html)
        note(f"page written to {file}, its tables to {folder}")
    return 0
