"""`tumble stability`: who is stable where, how long a step each bears, and what becomes of extreme cases."""

import shlex
from argparse import Namespace
from pathlib import Path

from tumble.compare.stability.findings import extreme_findings, limit_findings
from tumble.compare.stability.schemas import CELLS, EXTREMES, LIMITS
from tumble.compare.stability.store import pieces, store, tables_of
from tumble.compare.stability.tasks import STIFF, keys, stability
from tumble.compare.tables.circumstances import circumstances
from tumble.compare.tables.files import write_whole
from tumble.compare.tables.frames import csv_text, frame, rows
from tumble.compare.tables.shared import FINDINGS
from tumble.finished import exit_code
from tumble.notes import note, progress
from tumble.reports.figures import check_figures, limit_figure, save_figures
from tumble.reports.stability_text import stability_text
from tumble.reports.terminal import console
from tumble.scenarios.read import extremes, read_scenes
from tumble.taking_part import taking_part


def main(options: Namespace) -> int:
    """Map every scene and run the extreme cases, print limits and verdicts, and keep the tables where asked.

    Of scenes that are named, extreme cases are run as such and the others are mapped.
    """
    check_figures(options.svg, options.png)
    asked = options.scene or (*STIFF, *extremes())
    scenes = read_scenes(name for name in asked if name not in extremes())
    cases = read_scenes(name for name in asked if name in extremes())
    folder = Path(options.output) if options.output else None
    with taking_part(options.engine, options) as running_engines:
        limit = {"time limit [s]": f"{options.time_limit:g}"}
        under = circumstances(running_engines, [*scenes, *cases], limit, shlex.join(options.words))
        order = keys(running_engines, scenes, cases)
        kept = store(folder, order, under)
        if said := kept.resume():
            note(said)
        try:
            with progress(len(order) - len(kept.done)) as on_progress:
                stability(
                    running_engines,
                    scenes,
                    cases,
                    lambda piece: kept.keep(piece.key, tables_of(piece)),
                    on_progress,
                    kept.done,
                )
        except KeyboardInterrupt:
            left = f"what was done is in {folder}; the same command goes on from there" if folder else "what was done:"
            raise KeyboardInterrupt(f"interrupted; {left}") from None
        finally:
            kept.write()
            out = console()
            verdicts = rows(EXTREMES, kept.tables[EXTREMES.file])
            for piece in stability_text(pieces(kept.tables), verdicts, out.is_terminal):
                out.print(piece)
    save_figures(options.svg, options.png, limit_figure, kept.tables[LIMITS.file])
    if folder:
        found = [*limit_findings(rows(LIMITS, kept.tables[LIMITS.file])), *extreme_findings(verdicts)]
        write_whole(folder / FINDINGS.file, csv_text(frame(FINDINGS, found)))
        note(f"tables written to {folder}")
    return exit_code([*kept.tables[CELLS.file].status, *kept.tables[EXTREMES.file].status])
