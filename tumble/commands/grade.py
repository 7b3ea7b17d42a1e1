"""`tumble grade`: how far off a trajectory is that some other program wrote, and what is most likely wrong with it."""

import json
import os
import shlex
import sys
from argparse import Namespace
from contextlib import ExitStack
from pathlib import Path

from tumble.compare.grade.grade import PIECES, grade
from tumble.compare.grade.read.columns import BadTrajectory, Unsaid
from tumble.compare.grade.read.conventions import Reading
from tumble.compare.grade.read.formats import plain
from tumble.compare.grade.read.mapping import mapping_file, mapping_of
from tumble.compare.grade.read.reading_options import Said
from tumble.compare.grade.read.refusals import refusal
from tumble.compare.grade.results import answer
from tumble.compare.tables.files import write_folder
from tumble.notes import display, note, notes
from tumble.reports.grade import grade_text, off_by, so_far
from tumble.reports.terminal import console
from tumble.scenarios.read import read_scene
from tumble.scenarios.scene import Scene


def _like(program: str, path: Path, scene: Scene, said: Said) -> Said:
    """Return how a program's file is to be read, and tell the options that would say so."""
    from tumble.compare.grade.read.programs import as_program, remark

    whole, error = as_program(path, scene, said, program)
    note(f"--like {program} reads it with {whole.options(said) or 'no further options'}{remark(error)}")
    return whole


def _named(error: BadTrajectory, named: str) -> BadTrajectory:
    """Return a refusal, with the file that named the columns."""
    return BadTrajectory(f"{error} ({named})") if named else error


def main(options: Namespace) -> int:
    """Grade one file and print what was found; exit code 1 only where a tolerance was given and is exceeded."""
    scene = read_scene(options.scene, flown=False)
    beside = Path(f"{options.file}.toml")
    mapping: dict[str, str] = {}
    named = ""
    if options.map_file or os.path.isfile(beside):
        beside = Path(options.map_file or beside)
        mapping, named = mapping_file(beside), f"columns named as {beside} says"
    mapping |= mapping_of(options.map)
    columns = [name.strip() for name in options.columns.split(",")] if options.columns else []
    with ExitStack() as drafts:
        path, name, first_line = plain(options.file, columns, options.decimal, drafts)
        reading = Reading(options.euler, options.axes, options.start, options.spin, name, first_line)
        said = Said(mapping, options.decimal, options.by, reading)
        try:
            if options.like:
                said = _like(options.like, path, scene, said)
            reading = said.reading
            with display(options)(PIECES) as on_progress:
                found = grade(
                    path,
                    scene,
                    said.mapping,
                    said.by,
                    said.decimal,
                    lambda measured, seen: notes(off_by(name, measured, seen)),
                    reading,
                    nearest=lambda explanation: note(so_far(explanation)),
                    on_progress=on_progress,
                )
        except Unsaid as question:
            raise _named(refusal(path, scene, said, question), named) from None
        except BadTrajectory as error:
            raise _named(error, named) from None
    for line in reading.notes:
        note(line)
    if named:
        note(named)
    if options.json:
        sys.stdout.write(json.dumps(answer(found), indent=2) + "\n")
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
        note(f"{name}: off by {found.measured.worst_m:.3g} m, more than the {options.tolerance:g} m allowed")
        return 1
    return 0
