"""`tumble compare`: an error table for every contestant, as in Table 4.1."""

import shlex
from argparse import Namespace
from pathlib import Path

from compare.comparison.against_truth import compare
from compare.run.flight import check_step
from compare.run.participants import flights, launched
from compare.tables.files import write_folder
from reports.terminal import comparison_text, console
from scenarios.read import BadScene, read_scene
from tumble.notes import note, progress


def main(options: Namespace) -> int:
    """Put one scene to every contestant, print the error tables, and write all of them where asked."""
    scene = read_scene(options.scene)
    check_step(scene, options.dt)
    vertices = len(scene.body.points)
    if options.vertex is not None and not 0 <= options.vertex < vertices:
        raise BadScene(f"--vertex = {options.vertex}: {scene.name} has vertices 0 to {vertices - 1}")
    folder = Path(options.output) if options.output else None
    if folder:
        folder.mkdir(parents=True, exist_ok=True)
    with launched(options.engine, options.time_limit) as participants:
        with progress(flights(participants, [scene]) + 1) as tick:
            comparisons = compare(participants, [scene], options.dt, tick)
        out = console()
        for piece in comparison_text(comparisons[0], options.vertex):
            out.print(piece)
        if folder:
            from compare.comparison.results import comparison_tables  # pandas is slow to load
            from compare.tables.frames import csv_texts

            write_folder(folder, csv_texts(comparison_tables(comparisons, participants, shlex.join(options.words))))
            note(f"tables written to {folder}")
    return 0
