"""`tumble grade`: how far off a trajectory is that some other program wrote, and what is most likely wrong with it."""

from argparse import Namespace
from pathlib import Path

from compare.grade.columns import mapping_file, mapping_of
from compare.grade.rows import write_grade
from compare.grade.verdict import grade
from reports.grade import grade_text
from reports.terminal import console
from scenarios.read import read_scene
from tumble.notes import note


def main(options: Namespace) -> int:
    """Grade one file and print what was found; exit code 1 only where a tolerance was given and is exceeded."""
    scene, path = read_scene(options.scene), Path(options.file)
    beside = Path(f"{options.file}.toml")
    mapping: dict[str, str] = {}
    if options.map_file or beside.is_file():
        chosen = Path(options.map_file) if options.map_file else beside
        mapping = mapping_file(chosen)
        note(f"columns named as {chosen} says")
    mapping |= mapping_of(options.map)
    found = grade(path, scene, mapping, options.by, options.decimal)
    out = console()
    for piece in grade_text(found):
        out.print(piece)
    if options.output:
        write_grade(Path(options.output), found)
        note(f"tables written to {options.output}")
    if options.tolerance is not None and found.measured.worst_m > options.tolerance:
        note(f"{path}: off by {found.measured.worst_m:.3g} m, more than the {options.tolerance:g} m allowed")
        return 1
    return 0
