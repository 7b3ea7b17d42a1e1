"""`tumble report`: the page, of new runs or of saved tables."""

import shlex
from argparse import Namespace
from collections.abc import Mapping, Sequence
from pathlib import Path

import pandas as pd

from tumble.compare.run.flight import check_step
from tumble.compare.tables.files import write_whole
from tumble.compare.tables.frames import write_tables
from tumble.compare.tables.schema import BadTable
from tumble.compare.tables.shared import RUNS
from tumble.finished import exit_code
from tumble.notes import display, note
from tumble.report_tables import report_tables
from tumble.reports.folders import changes, gathered
from tumble.reports.page import page
from tumble.scenarios.read import catalogue, read_scenes


def main(options: Namespace) -> int:
    """Make the page, and beside it the tables that it shows unless they were given."""
    file = Path(options.output)
    show = display(options)
    if options.sources:
        with show(doing="drawing the page"):
            write_whole(file, page(saved_tables(options)))
        note(f"page written to {file}")
        return 0
    folder = file.with_name(f"{file.stem}-tables")
    scenes = read_scenes(options.scene or catalogue())
    for scene in scenes:
        check_step(scene, options.dt)  # before a folder is made
    folder.mkdir(parents=True, exist_ok=True)
    tables = report_tables(
        scenes,
        options.engine,
        dt=options.dt,
        every_method=options.all,
        whole_catalogue=not options.scene,
        folder=folder,
        time_limit=options.time_limit,
        memory_limit=options.memory_limit,
        command=shlex.join(options.words),
        display=show,
    )
    with show(doing="drawing the page"):
        html = page(tables)
        write_tables(folder, tables)
        write_whole(file, html)
    note(f"page written to {file}, its tables to {folder}")
    return exit_code(tables[RUNS.file].status)


def saved_tables(options: Namespace) -> Mapping[str, pd.DataFrame]:
    """Return the tables of the folders given: of one as they are, of two the newer with what changed since.

    Raises BadTable.
    """
    if options.scene or options.engine or options.dt or options.all:
        raise BadTable("--from draws saved tables and runs nothing: it excludes SCENE, --engine, --dt and --all")
    if len(options.sources) > 2:
        raise BadTable("--from: give at most two folders, the older first")
    tables: Sequence[Mapping[str, pd.DataFrame]] = [gathered(Path(source)) for source in options.sources]
    return {**tables[-1], **(changes(*tables) if len(tables) > 1 else {})}
