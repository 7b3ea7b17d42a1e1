"""`tumble stability`: stability maps, the largest stable step of each method, and extreme cases."""

import shlex
from argparse import Namespace
from collections.abc import Mapping
from pathlib import Path

import pandas as pd

from tumble.compare.stability.results import pieces
from tumble.compare.stability.schemas import CELLS, CONTACT_MAP, CONTACT_STEPS, EXTREMES, LIMITS
from tumble.compare.stability.study import map_scenes
from tumble.compare.stability.tasks import default_scenes
from tumble.compare.tables.frames import rows
from tumble.finished import exit_code
from tumble.notes import display, note
from tumble.reports.figures import check_figures, limit_figure, save_figures
from tumble.reports.stability_text import stability_text
from tumble.reports.terminal import console
from tumble.scenarios.read import read_scenes


def main(options: Namespace) -> int:
    """Map every scene and run the extreme cases, and print limits and verdicts; write the tables if asked.

    Extreme cases, by their names, are run as they are; the others are mapped.
    """
    check_figures(options.svg, options.png)
    folder = Path(options.output) if options.output else None
    tables = map_scenes(
        read_scenes(options.scene or default_scenes()),
        options.engine,
        folder=folder,
        time_limit=options.time_limit,
        memory_limit=options.memory_limit,
        command=shlex.join(options.words),
        display=display(options),
        ended=show,
    )
    save_figures(options.svg, options.png, limit_figure, tables[LIMITS.file])
    if folder:
        note(f"tables written to {folder}")
    return exit_code([row for table in (CELLS, EXTREMES, CONTACT_STEPS) for row in tables[table.file].status])


def show(tables: Mapping[str, pd.DataFrame]) -> None:
    """Print limits and verdicts."""
    out = console()
    others = (rows(table, tables[table.file]) for table in (EXTREMES, CONTACT_MAP, CONTACT_STEPS))
    for piece in stability_text(pieces(tables), *others, charts=out.is_terminal):
        out.print(piece)
