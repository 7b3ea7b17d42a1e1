"""`tumble releases`: what changed between an engine's releases."""

import shlex
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from tumble.compare.releases.changes import changes
from tumble.compare.releases.ledger import SCENES, ledger
from tumble.compare.releases.notes import shipped_notes
from tumble.compare.run.engines import environments, installing, registry
from tumble.compare.run.engines.registry import BadEngine
from tumble.compare.run.process.kept import Kept
from tumble.compare.run.running_engines import flights, split
from tumble.compare.tables.files import write_folder
from tumble.finished import exit_code
from tumble.notes import note, progress
from tumble.reports.releases import ledger_markdown, ledger_text
from tumble.reports.terminal import console
from tumble.scenarios.read import read_scenes
from tumble.taking_part import taking_part


def main(options: Namespace) -> int:
    """Put the same scenes to every release that is here, and say what changed at which."""
    engine = with_releases(options.engine, options.scene)
    scenes = read_scenes(options.scene or SCENES)
    asked = [f"{engine}@{release}" for release in chosen(engine, options)]
    folder = Path(options.output) if options.output else None
    if folder:
        folder.mkdir(parents=True, exist_ok=True)
    with taking_part(asked, options) as running_engines:
        kept = None
        if folder:
            from tumble.compare.tables.circumstances import binding, circumstances

            limit = {"time limit [s]": f"{options.time_limit:g}"}
            kept = Kept(folder, binding(circumstances(running_engines, scenes, limit, "")))
        try:
            with progress(flights(running_engines, scenes) + len(scenes) + 1) as on_progress:
                found = ledger(running_engines, scenes, on_progress, kept)
        except KeyboardInterrupt:
            where = f"the flights that are done are kept in {folder}; the same command goes on from there"
            raise KeyboardInterrupt(f"interrupted; {where if kept else 'nothing was written'}") from None
        told = list(changes(found, shipped_notes(engine)))
        for piece in ledger_text(found, told):
            console().print(piece)
        if folder and kept:
            from tumble.compare.releases.results import ledger_tables  # pandas is slow to load
            from tumble.compare.tables.frames import csv_texts

            command = shlex.join(options.words)
            texts = csv_texts(ledger_tables(found, told, running_engines, command))
            write_folder(folder, {**texts, "releases.md": ledger_markdown(found, told, command)})
            kept.forget()
            note(f"tables and releases.md written to {folder}")
    return exit_code(row.status for row in found.rows)


def with_releases(engine: str, beside: Sequence[str]) -> str:
    """Return the engine.  Raises BadEngine for one that has none, and with what to type for ENGINE@RELEASE ...

    beside: the words after it.
    """
    name, method = split(engine)
    if registry.is_file(name):
        raise BadEngine(f"{engine}: a file has no releases")
    name, _, first = name.partition("@")
    last = [word.removeprefix(f"{name}@") for word in beside if word.startswith(f"{name}@")][-1:]
    if method or first or last:
        asked = [word for word in beside if "@" not in word]
        asked += [*(["--from", first] if first else ()), *(["--to", *last] if last else ())]
        raise BadEngine(
            f"{' '.join([engine, *beside])}: the engine stands without a method or a release: "
            f"type `tumble {shlex.join(['releases', name, *asked])}`"
        )
    if not registry.package(name).pins:
        raise BadEngine(f"{name}: has no releases of its own")
    return name


def chosen(engine: str, options: Namespace) -> list[str]:
    """Return the releases asked for, the oldest first, installed where that is asked for too.  Raises BadEngine."""
    there = environments.releases_on_index(engine) if options.install else environments.releases_here(engine)
    for release in (options.first, options.last):
        if release and release not in there and (options.install or not environments.in_order([release])):
            raise BadEngine(f"{engine} has no release {release}; there are {', '.join(there)}")
    first, last = (environments.numbers_of(end) if end else None for end in (options.first, options.last))
    found = [
        release
        for release in there
        if (first is None or environments.numbers_of(release) >= first)
        and (last is None or environments.numbers_of(release) <= last)
    ]
    if len(found) < 2:
        here = ", ".join(environments.releases_here(engine)) or "none"
        raise BadEngine(f"{engine}: two releases at least are needed; here: {here}; --install gets what the index has")
    if options.install:
        for release in found:
            if environments.located(f"{engine}@{release}")[1] is None:
                note(f"making an environment for {engine}@{release}")
                with progress(doing=f"installing {engine}@{release}") as on_progress:
                    installing.install(f"{engine}@{release}", on_progress)
    return found
