"""`tumble report`: the page."""

import shlex
from argparse import Namespace
from pathlib import Path

from compare.contest import compare, crew
from compare.results import tables, write_tables
from compare.tables import write_whole
from reports.page import page
from scenarios.read import catalogue, read_scene
from tumble.notes import note, progress


def main(options: Namespace) -> int:
    """Put every scene to every contestant, write the tables, and make the page from them."""
    file = Path(options.output)
    folder = file.with_name(f"{file.stem}-tables")
    scenes = [read_scene(name) for name in options.scene or catalogue()]
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
