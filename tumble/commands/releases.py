"""`tumble releases`: what changed between an engine's releases."""

import shlex
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from tumble.compare.releases.ledger import SCENES
from tumble.compare.releases.study import Releases, compare_releases
from tumble.compare.run.asked import known_contestant
from tumble.compare.run.engines import registry
from tumble.compare.run.engines.registry import BadEngine
from tumble.finished import exit_code
from tumble.notes import display, note
from tumble.reports.releases import ledger_markdown, ledger_text
from tumble.reports.terminal import console
from tumble.scenarios.read import read_scenes


def main(options: Namespace) -> int:
    """Run the same scenes with every installed release, and print what changed at each; write it if asked."""
    engine = with_releases(options.engine, options.scene)
    folder = Path(options.output) if options.output else None

    def show(found: Releases) -> None:
        for piece in ledger_text(found.ledger, found.changes):
            console().print(piece)
        if folder:
            from tumble.compare.releases.results import ledger_tables  # pandas is slow to load
            from tumble.compare.tables.frames import write_tables

            command = shlex.join(options.words)
            tables = ledger_tables(found.ledger, found.changes, found.engines, command)
            markdown = ledger_markdown(found.ledger, found.changes, command)
            write_tables(folder, tables, {"releases.md": markdown})
            note(f"tables and releases.md written to {folder}")

    found = compare_releases(
        engine,
        read_scenes(options.scene or SCENES),
        first=options.first,
        last=options.last,
        install=options.install,
        folder=folder,
        time_limit=options.time_limit,
        memory_limit=options.memory_limit,
        display=display(options),
        finished=show,
    )
    return exit_code(row.status for row in found.ledger.rows)


def with_releases(engine: str, beside: Sequence[str]) -> str:
    """Return the engine.  Raises BadEngine if it has no releases, and with what to type for ENGINE@RELEASE ...

    beside: the words after it.
    """
    asked_for = known_contestant(engine)
    if registry.is_file(asked_for.engine):
        raise BadEngine(f"{engine}: an engine file has no releases")
    name, first = asked_for.engine, asked_for.release
    last = [word.removeprefix(f"{name}@") for word in beside if word.startswith(f"{name}@")][-1:]
    if str(asked_for.method) or first or last:
        words = [word for word in beside if "@" not in word]
        words += [*(["--from", first] if first else ()), *(["--to", *last] if last else ())]
        raise BadEngine(
            f"{' '.join([engine, *beside])}: give the engine without a method or a release: "
            f"type `tumble {shlex.join(['releases', name, *words])}`"
        )
    return name
