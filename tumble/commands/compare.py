"""`tumble compare`: who is wrong on a throw, and by how much; an error table for each, as Table 4.1."""

import shlex
from argparse import Namespace
from pathlib import Path

from tumble.compare.comparison.against_truth import compare
from tumble.compare.run.flight import check_step
from tumble.compare.run.running_engines import flights
from tumble.compare.tables.files import write_folder
from tumble.finished import exit_code
from tumble.notes import note, progress
from tumble.reports.comparison_text import comparison_text
from tumble.reports.terminal import console
from tumble.scenarios.read import BadScene, read_scenes
from tumble.taking_part import taking_part


def main(options: Namespace) -> int:
    """Put each scene to every contestant, print answer, ranking and error tables, and write all of them where asked."""
    if options.svg or options.png:
        from tumble.reports.figures import check_figures  # slow to load

        check_figures(options.svg, options.png)
    scenes = read_scenes(options.scene)
    for scene in scenes:
        check_step(scene, options.dt)
        vertices = len(scene.body.points)
        if options.vertex is not None and not 0 <= options.vertex < vertices:
            raise BadScene(f"--vertex = {options.vertex}: {scene.name} has vertices 0 to {vertices - 1}")
    folder = Path(options.output) if options.output else None
    if folder:
        folder.mkdir(parents=True, exist_ok=True)
    with taking_part(options.engine, options) as running_engines:
        with progress(flights(running_engines, scenes) + len(scenes)) as on_progress:
            comparisons = compare(running_engines, scenes, options.dt, on_progress)
        out = console()
        for number, comparison in enumerate(comparisons):
            if number:
                out.print()
            for piece in comparison_text(comparison, options.vertex, options.all, out.is_terminal):
                out.print(piece)
        if folder or options.svg or options.png:
            from tumble.compare.comparison.results import comparison_tables  # pandas is slow to load
            from tumble.compare.tables.frames import csv_texts
            from tumble.reports.figures import error_figure, save_figures

            frames = comparison_tables(comparisons, running_engines, shlex.join(options.words))
            save_figures(options.svg, options.png, error_figure, frames["runs.csv"])
            if folder:
                write_folder(folder, csv_texts(frames))
                note(f"tables written to {folder}")
    return exit_code(run.status for comparison in comparisons for run in comparison.runs)
