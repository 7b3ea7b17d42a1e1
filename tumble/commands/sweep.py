"""`tumble sweep`: error against run time."""

import shlex
from argparse import Namespace
from pathlib import Path

from compare.contest import crew
from compare.results import sweep_tables, write_tables
from compare.sweep import YARDSTICK, sweep
from reports.terminal import console, sweep_text
from scenarios.read import read_scene
from tumble.notes import note, progress


def main(options: Namespace) -> int:
    """Sweep every scene, print what each digit costs, and write the tables where asked."""
    scenes = [read_scene(name) for name in dict.fromkeys(options.scene) or [YARDSTICK]]
    folder = Path(options.output) if options.output else None
    if folder:
        folder.mkdir(parents=True, exist_ok=True)
    with crew(options.engine, options.time_limit) as entrants:
        methods = sum(len(entrant.methods) for entrant in entrants)
        with progress(len(scenes) * (methods + 1)) as tick:
            sweeps = [sweep(entrants, scene, tick) for scene in scenes]
        out = console()
        for each in sweeps:
            for piece in sweep_text(each, options.reference):
                out.print(piece)
        if folder:
            write_tables(folder, sweep_tables(sweeps, entrants, options.reference, shlex.join(options.words)))
            note(f"tables written to {folder}")
    return 0
