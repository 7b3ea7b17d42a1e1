"""`tumble sweep`: error against run time."""

import shlex
from argparse import Namespace
from pathlib import Path

from tumble.compare.run.process.kept import Kept
from tumble.compare.run.running_engines import flights
from tumble.compare.sweep.results import MEASURED, measured
from tumble.compare.sweep.schemas import WORK_PRECISION
from tumble.compare.sweep.work_precision import YARDSTICK, sweep
from tumble.compare.tables.circumstances import binding, circumstances
from tumble.compare.tables.engines import engine_row
from tumble.compare.tables.files import write_whole
from tumble.compare.tables.frames import csv_text, frame
from tumble.compare.tables.shared import ENGINES, RUNS
from tumble.compare.tables.store import Store
from tumble.finished import exit_code
from tumble.notes import note, progress
from tumble.reports.figures import check_figures, cost_figure, save_figures
from tumble.reports.sweep_text import sweep_text
from tumble.reports.terminal import console
from tumble.scenarios.read import read_scenes
from tumble.taking_part import taking_part


def main(options: Namespace) -> int:
    """Sweep every scene, print what each digit costs, and keep the tables where asked, scene by scene."""
    check_figures(options.svg, options.png)
    scenes = read_scenes(options.scene or [YARDSTICK])
    folder = Path(options.output) if options.output else None
    if folder:
        folder.mkdir(parents=True, exist_ok=True)
    with taking_part(options.engine, options) as running_engines:
        asked = {"time limit [s]": f"{options.time_limit:g}", "reference": options.reference}
        # A task of the store is a scene: its times are worth something only beside each other, of the same rounds.
        order = [(scene.name,) for scene in scenes]
        under = circumstances(running_engines, scenes, asked, shlex.join(options.words))
        store = Store(folder, MEASURED, ["scene"], order, under)
        if said := store.resume():
            note(said)
        kept = Kept(folder, binding(under)) if folder else None
        left = [scene for scene in scenes if (scene.name,) not in store.done]
        sweeps = []
        try:
            with progress(flights(running_engines, left) + len(left)) as on_progress:
                for scene in left:
                    sweeps.append(sweep(running_engines, scene, on_progress, kept=kept))
                    store.keep((scene.name,), measured(sweeps[-1:], options.reference))
        except KeyboardInterrupt:
            names = [name for (name,) in order if (name,) in store.done]
            done = f"{', '.join(names)} {'is' if len(names) == 1 else 'are'} done" if names else "no scene is done yet"
            more = f"; the ladders that are done are kept in {folder}, and the same command goes on from there"
            raise KeyboardInterrupt(f"interrupted; {done}{more if folder else ''}") from None
        finally:
            store.write()
            out = console()
            for each in sweeps:
                for piece in sweep_text(each, options.reference, out.is_terminal):
                    out.print(piece)
        save_figures(options.svg, options.png, cost_figure, store.tables[WORK_PRECISION.file])
        if folder and kept:
            kept.forget()
            write_whole(folder / "engines.csv", csv_text(frame(ENGINES, map(engine_row, running_engines))))
            note(f"tables written to {folder}")
    return exit_code(store.tables[RUNS.file].status)
