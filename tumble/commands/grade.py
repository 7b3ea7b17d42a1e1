"""`tumble grade`: the error of a trajectory that some other program wrote, and its most likely cause."""

import json
import os
import shlex
import sys
from argparse import Namespace
from contextlib import ExitStack
from pathlib import Path

from tumble.compare.grade.grade import TASKS, grade
from tumble.compare.grade.read.columns import AmbiguousFile, BadTrajectory
from tumble.compare.grade.read.conventions import Conventions
from tumble.compare.grade.read.formats import as_csv
from tumble.compare.grade.read.mapping import mapping_file, mapping_of
from tumble.compare.grade.read.reading_options import ReadingOptions
from tumble.compare.grade.read.refusals import refusal
from tumble.compare.grade.results import json_document
from tumble.compare.tables.files import write_folder
from tumble.notes import display, note, notes
from tumble.reports.grade import first_lines, grade_text, nearest_line
from tumble.reports.terminal import console
from tumble.scenarios.read import read_scene
from tumble.scenarios.scene import Scene


def _like(program: str, path: Path, scene: Scene, given: ReadingOptions) -> ReadingOptions:
    """Return the options that read a file as a program writes it, and print them."""
    from tumble.compare.grade.read.programs import misfit_remark, read_as_program

    reading, error = read_as_program(path, scene, given, program)
    options = reading.command_line(given) or "no further options"
    note(f"--like {program} reads the file with {options}{misfit_remark(error)}")
    return reading


def _with_source(error: BadTrajectory, source: str) -> BadTrajectory:
    """Return an error with the file that named the columns, if there is one."""
    return BadTrajectory(f"{error} ({source})") if source else error


def main(options: Namespace) -> int:
    """Grade one file and print the result; exit code 1 only if a tolerance is given and exceeded."""
    scene = read_scene(options.scene, to_run=False)
    map_file = Path(options.map_file or f"{options.file}.toml")
    mapping: dict[str, str] = {}
    source = ""
    if options.map_file or os.path.isfile(map_file):
        mapping, source = mapping_file(map_file), f"columns are named by {map_file}"
    mapping |= mapping_of(options.map)
    columns = [name.strip() for name in options.columns.split(",")] if options.columns else []
    with ExitStack() as drafts:
        path, name, first_line = as_csv(options.file, columns, options.decimal, drafts)
        conventions = Conventions(options.euler, options.axes, options.start, options.spin, name, first_line)
        reading = ReadingOptions(mapping, options.decimal, options.by, conventions)
        try:
            if options.like:
                reading = _like(options.like, path, scene, reading)
            conventions = reading.conventions
            with display(options)(TASKS) as on_progress:
                found = grade(
                    path,
                    scene,
                    reading.mapping,
                    reading.by,
                    reading.decimal,
                    lambda measured, observed: notes(first_lines(name, measured, observed)),
                    conventions,
                    on_nearest=lambda explanation: note(nearest_line(explanation)),
                    on_progress=on_progress,
                )
        except AmbiguousFile as question:
            raise _with_source(refusal(path, scene, reading, question), source) from None
        except BadTrajectory as error:
            raise _with_source(error, source) from None
    for line in conventions.notes:
        note(line)
    if source:
        note(source)
    if options.json:
        sys.stdout.write(json.dumps(json_document(found), indent=2) + "\n")
    else:
        out = console()
        for piece in grade_text(found):
            out.print(piece)
    if options.output:
        from tumble.compare.grade.tables import grade_tables  # pandas is slow to load
        from tumble.compare.tables.frames import csv_texts

        write_folder(Path(options.output), csv_texts(grade_tables(found, shlex.join(options.words))))
        note(f"tables written to {options.output}")
    if options.tolerance is not None and found.measured.worst_m > options.tolerance:
        note(f"{name}: error of {found.measured.worst_m:.3g} m exceeds the tolerance of {options.tolerance:g} m")
        return 1
    return 0
