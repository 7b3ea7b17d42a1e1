"""`tumble grade`: the error of a trajectory that some other program wrote, and its most likely cause."""

import json
import math
import shlex
import sys
from argparse import Namespace
from pathlib import Path

from tumble.compare.grade.grade import SEARCH_S
from tumble.compare.grade.read.columns import BadTrajectory
from tumble.compare.grade.read.conventions import Conventions
from tumble.compare.grade.read.mapping import mapping_of
from tumble.compare.grade.read.reading_options import ReadingOptions
from tumble.compare.grade.study import grade_file
from tumble.notes import display, note, notes
from tumble.reports.grade_progress import first_lines, first_reading_lines, nearest_line
from tumble.scenarios.read import read_scene

# Processor time of this process in which an answer should be there if no other time is asked for [s].
ANSWER_S = 2.6


def main(options: Namespace) -> int:
    """Grade one file and print the result; exit code 1 only if a tolerance is given and exceeded."""
    show = (lambda lines: None) if options.quiet else notes
    conventions = Conventions(options.euler, options.axes, options.start, options.spin)
    found = grade_file(
        options.file,
        read_scene(options.scene, to_run=False),
        ReadingOptions(mapping_of(options.map), options.decimal, options.by, conventions),
        like=options.like,
        map_file=options.map_file,
        names=[name.strip() for name in options.columns.split(",")] if options.columns else (),
        sensor=options.sensor,
        search_s=options.search or SEARCH_S,
        answer_s=math.inf if options.search else ANSWER_S,
        on_measured=lambda name, measured, observed: show(first_lines(name, measured, observed)),
        on_nearest=lambda explanation: show([nearest_line(explanation)]),
        on_readings=lambda name, measured: show(first_reading_lines(name, measured)),
        display=display(options),
    )
    if options.json:
        from tumble.compare.grade.results import json_document  # 40 ms, with what the tables need

        sys.stdout.write(json.dumps(json_document(found), indent=2) + "\n")
    else:
        from tumble.reports.file_grade import file_text  # rich, which no script needs: 25 ms
        from tumble.reports.terminal import console

        out = console()
        for piece in file_text(found):
            out.print(piece)
    if options.output:
        from tumble.compare.grade.tables import grade_tables  # pandas is slow to load
        from tumble.compare.tables.frames import write_tables

        write_tables(Path(options.output), grade_tables(found, shlex.join(options.words)))
        note(f"tables written to {options.output}")
    if options.tolerance is not None and found.pose is None:
        raise BadTrajectory(f"{found.file}: --tolerance is of vertex errors, but the file has only readings")
    worst_m = found.pose.measured.worst_m if found.pose else 0.0
    if options.tolerance is not None and worst_m > options.tolerance:
        note(f"{found.file}: error of {worst_m:.3g} m exceeds the tolerance of {options.tolerance:g} m")
        return 1
    return 0
