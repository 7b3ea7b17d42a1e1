"""`tumble sweep`: error against run time."""

import shlex
from argparse import Namespace
from pathlib import Path

from compare.comparison.results import sweep_tables, write_tables
from compare.run.circumstances import binding, circumstances
from compare.run.kept import Kept
from compare.run.participants import flights, launched
from compare.sweep.store import SweepStore
from compare.sweep.sweep import YARDSTICK, sweep
from reports.terminal import console, sweep_text
from scenarios.read import read_scenes
from tumble.notes import note, progress


def main(options: Namespace) -> int:
    """Sweep every scene, print what each digit costs, and keep the tables where asked, scene by scene."""
    scenes = read_scenes(options.scene or [YARDSTICK])
    folder = Path(options.output) if options.output else None
    if folder:
        folder.mkdir(parents=True, exist_ok=True)
    with launched(options.engine, options.time_limit) as participants:
        asked = {"time limit [s]": f"{options.time_limit:g}", "reference": options.reference}
        under = circumstances(participants, scenes, asked, shlex.join(options.words))
        store = SweepStore(folder, [scene.name for scene in scenes], under)
        if said := store.resume():
            note(said)
        kept = Kept(folder, binding(under)) if folder else None
        left = [scene for scene in scenes if scene.name not in store.done]
        sweeps = []
        try:
            with progress(flights(participants, left) + len(left)) as tick:
                for scene in left:
                    sweeps.append(sweep(participants, scene, tick, kept=kept))
                    made = sweep_tables(sweeps[-1:], participants, options.reference, shlex.join(options.words))
                    store.keep(made)
        except KeyboardInterrupt:
            done = f"{', '.join(store.done) or 'no scene'} is done"
            more = f", and with the ladders of the next kept in {folder}; the same command goes on from there"
            raise KeyboardInterrupt(f"interrupted; {done}{more if folder else ''}") from None
        finally:
            out = console()
            for each in sweeps:
                for piece in sweep_text(each, options.reference):
                    out.print(piece)
        if folder and kept:
            kept.forget()
            write_tables(folder, {"engines.csv": sweep_tables([], participants, options.reference, "")["engines.csv"]})
            note(f"tables written to {folder}")
    return 0
