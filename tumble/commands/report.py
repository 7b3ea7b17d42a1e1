"""`tumble report`: the page."""

import shlex
from argparse import Namespace
from pathlib import Path

from compare.contest import compare, crew
from compare.flight import check_step
from compare.results import tables, write_tables
from compare.tables import write_whole
from reports.page import page
from scenarios.read import BadScene, catalogue, read_scene
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
    folder.mkdir(parents=True, exist_ok=True)
    with crew(options.engine, options.time_limit) as entrants:
        with progress(len(scenes) * (1 + sum(len(entrant.methods) for entrant in entrants)) + 1) as tick:
            texts = tables(compare(entrants, scenes, options.dt, tick), entrants, shlex.join(options.words))
            tick("drawing the page")
            html = page(texts)
        write_tables(folder, texts)
        write_whole(file, html)
        note(f"page written to {file}, its tables to {folder}")
    return 0
