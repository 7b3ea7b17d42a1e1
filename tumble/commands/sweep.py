"""`tumble sweep`: error against run time."""

import shlex
from argparse import Namespace
from pathlib import Path

from tumble.compare.sweep.schemas import WORK_PRECISION
from tumble.compare.sweep.study import sweep_scenes
from tumble.compare.sweep.work_precision import YARDSTICK, Sweep
from tumble.compare.tables.frames import write_tables
from tumble.compare.tables.shared import RUNS
from tumble.finished import exit_code
from tumble.notes import display, note
from tumble.reports.figures import check_figures, cost_figure, save_figures
from tumble.reports.sweep_text import sweep_text
from tumble.reports.terminal import console
from tumble.scenarios.read import read_scenes


def main(options: Namespace) -> int:
    """Sweep every scene and print the cost of accuracy; write the tables if asked."""
    check_figures(options.svg, options.png)
    scenes = read_scenes(options.scene or [YARDSTICK])
    folder = Path(options.output) if options.output else None
    if folder:
        folder.mkdir(parents=True, exist_ok=True)
    sweeps: list[Sweep] = []
    try:
        tables = sweep_scenes(
            scenes,
            options.engine,
            reference=options.reference,
            observable=options.observable,
            time_limit=options.time_limit,
            memory_limit=options.memory_limit,
            command=shlex.join(options.words),
            display=display(options),
            finished=sweeps.append,
        )
    finally:
        out = console()
        for each in sweeps:
            for piece in sweep_text(each, options.reference, out.is_terminal):
                out.print(piece)
    save_figures(options.svg, options.png, cost_figure, tables[WORK_PRECISION.file])
    if folder:
        write_tables(folder, tables)
        note(f"tables written to {folder}")
    return exit_code(tables[RUNS.file].status)
