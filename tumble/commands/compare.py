"""`tumble compare`: the error of every contestant on a scene, with an error table for each."""

import shlex
from argparse import Namespace
from pathlib import Path

from tumble.api.limits import Limits
from tumble.api.session import kept_ready
from tumble.compare.comparison.ensemble_rows import run_rows
from tumble.compare.comparison.study import compare_scenes
from tumble.compare.contact.rows import contact_rows
from tumble.compare.contact.study import contact_scenes
from tumble.compare.run.execution import Parts, resumable
from tumble.compare.run.flight import check_step
from tumble.compare.run.truths import answered
from tumble.finished import exit_code
from tumble.notes import display, note
from tumble.reports.comparison_text import comparison_text
from tumble.reports.contact_text import contact_text
from tumble.reports.terminal import console
from tumble.scenarios.read import BadScene, read_document, read_scenes, scene_path


def main(options: Namespace) -> int:
    """Compare every contestant with the reference, and print answer, ranking and error tables; write them if asked."""
    if options.svg or options.png:
        from tumble.reports.figures import check_figures  # slow to load

        check_figures(options.svg, options.png)
    scenes = read_scenes(options.scene, in_parts=True)
    for scene in scenes:
        check_step(scene, options.dt)  # before a folder is made
        vertices = len(scene.body.points)
        if options.vertex is not None and not 0 <= options.vertex < vertices:
            raise BadScene(f"--vertex = {options.vertex}: {scene.name} has vertices 0 to {vertices - 1}")
    folder = Path(options.output) if options.output else None
    if folder:
        folder.mkdir(parents=True, exist_ok=True)
    limits: Limits = {
        "time_limit": options.time_limit,
        "memory_limit": options.memory_limit,
        "display": display(options),
    }
    # Parts of an ensemble take long, and are worth being found again.
    saved = resumable(folder if any(scene.ensemble for scene in scenes) else None)
    with kept_ready(), saved, Parts() as part:
        found = part(lambda: compare_scenes(scenes, options.engine, dt=options.dt, **limits))
        # A shard has no comparison, and yet its share of the contact runs.
        answers = found.comparisons if found else answered([one for one in scenes if one.plane], options.time_limit)
        contacts = part(lambda: contact_scenes(answers, options.engine, dt=options.dt, **limits))
    out = console()
    for number, comparison in enumerate(found.comparisons):
        if number:
            out.print()
        rows = [row for one in contacts if one.scene is comparison.scene for row in contact_rows(one)]
        for piece in contact_text(rows, options.all):
            out.print(piece)
        for piece in comparison_text(comparison, options.vertex, options.all, out.is_terminal):
            out.print(piece)
    if folder or options.svg or options.png:
        from tumble.compare.comparison.results import comparison_tables  # pandas is slow to load
        from tumble.compare.comparison.worst import FOLDER as WORST
        from tumble.compare.comparison.worst import worst_scenes
        from tumble.compare.contact.results import contact_tables
        from tumble.compare.contact.schemas import TABLES as CONTACT
        from tumble.compare.coursework.results import coursework_tables
        from tumble.compare.tables.frames import frame, merged, write_tables
        from tumble.reports.figures import error_figure, save_figures

        command = shlex.join(options.words)
        tables = merged(
            comparison_tables(found.comparisons, found.engines, command),
            coursework_tables(found.comparisons),
            contact_tables(contacts) or {table.file: frame(table, []) for table in CONTACT},
        )
        save_figures(options.svg, options.png, error_figure, tables["runs.csv"])
        if folder:
            documents = {
                name: text
                for path, one in zip(map(scene_path, dict.fromkeys(options.scene)), found.comparisons, strict=True)
                if one.ensemble
                for name, text in worst_scenes(one, read_document(path, str(path)), path.parent).items()
            }
            write_tables(folder, tables, documents)
            note(f"tables written to {folder}" + (f", the worst throws to {folder / WORST}" if documents else ""))
    return exit_code(row.status for comparison in found.comparisons for row in run_rows(comparison))
