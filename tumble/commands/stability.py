"""`tumble stability`: who is stable where, how long a step each bears, and what becomes of extreme cases."""

import shlex
from argparse import Namespace
from pathlib import Path

from compare.stability.extremes import cases
from compare.stability.findings import stability_findings
from compare.stability.schemas import CELLS, EXTREMES, LIMITS
from compare.stability.store import pieces, store, tables_of
from compare.stability.tasks import STIFF, keys, stability
from compare.tables.circumstances import circumstances, digest
from compare.tables.files import write_whole
from compare.tables.frames import csv_text, frame, rows
from compare.tables.shared import FINDINGS
from reports.figures import check_figures, limit_figure, save_figures
from reports.stability_text import stability_text
from reports.terminal import console
from scenarios.read import read_scenes
from tumble.finished import exit_code
from tumble.notes import note, progress
from tumble.taking_part import taking_part


def main(options: Namespace) -> int:
    """Map every scene and fly the extreme cases, print limits and verdicts, and keep the tables where asked.

    Scenes that are named are mapped alone, without the extreme cases.
    """
    check_figures(options.svg, options.png)
    scenes = read_scenes(options.scene or STIFF)
    extreme_cases = [] if options.scene else cases()
    folder = Path(options.output) if options.output else None
    with taking_part(options.engine, options) as participants:
        asked = {
            "time limit [s]": f"{options.time_limit:g}",
            "extreme cases": digest([case.text for case in extreme_cases]),
        }
        under = circumstances(participants, scenes, asked, shlex.join(options.words))
        order = keys(participants, scenes, extreme_cases)
        kept = store(folder, order, under)
        if said := kept.resume():
            note(said)
        try:
            with progress(len(order) - len(kept.done)) as tick:
                stability(
                    participants,
                    scenes,
                    extreme_cases,
                    lambda piece: kept.keep(piece.key, tables_of(piece)),
                    tick,
                    kept.done,
                )
        except KeyboardInterrupt:
            left = f"what was done is in {folder}; the same command goes on from there" if folder else "what was done:"
            raise KeyboardInterrupt(f"interrupted; {left}") from None
        finally:
            kept.write()
            out = console()
            extremes = rows(EXTREMES, kept.tables[EXTREMES.file])
            for piece in stability_text(pieces(kept.tables), extremes, out.is_terminal):
                out.print(piece)
    save_figures(options.svg, options.png, limit_figure, kept.tables[LIMITS.file])
    if folder:
        findings = frame(FINDINGS, stability_findings(rows(LIMITS, kept.tables[LIMITS.file])))
        write_whole(folder / FINDINGS.file, csv_text(findings))
        for case in extreme_cases:
            write_whole(folder / "extremes" / f"{case.scene.name}.toml", case.text)
        note(f"tables written to {folder}")
    return exit_code([*kept.tables[CELLS.file].status, *kept.tables[EXTREMES.file].status])
