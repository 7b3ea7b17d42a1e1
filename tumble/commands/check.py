"""`tumble check`: what was accepted once, held against what is measured now."""

import shlex
import sys
from argparse import Namespace
from dataclasses import replace
from pathlib import Path

from tumble.compare.check.changes import Outcome, failures, hold_against, time_changes, within
from tumble.compare.check.junit import junit
from tumble.compare.check.markdown import summary
from tumble.compare.check.measure import measure
from tumble.compare.check.record import BadRecord, Record, is_record, read_record, texts
from tumble.compare.check.schemas import TIMES
from tumble.compare.check.times import nearer
from tumble.compare.check.tolerances import Tolerances, read_tolerances
from tumble.compare.run.engines.registry import is_file
from tumble.compare.run.process.kept import Kept
from tumble.compare.run.running_engines import flights, split, wanted
from tumble.compare.tables.circumstances import binding, circumstances
from tumble.compare.tables.files import write_folder
from tumble.notes import note, progress
from tumble.reports.numerals import counted
from tumble.scenarios.read import catalogue, read_scenes
from tumble.taking_part import taking_part


def main(options: Namespace) -> int:
    """Record, or compare with a record; print what changed; return 1 where anything is worse, or a record changed."""
    refuse_odd(options)
    tolerances = read_tolerances(options.tolerances)
    known = options.baseline or options.output
    old = read_record(Path(known)) if is_record(Path(known)) or not options.accept else None
    new = read_record(Path(options.candidate)) if options.candidate else fly(options, old)
    if old is not None and not options.accept and not options.candidate:
        new = timed_again(options, old, new, tolerances)
    outcome = None
    if old is not None:
        if not options.accept:
            engines = wanted(options.engine) if options.engine else {}
            old, new = (within(record, options.scene, engines, old.contestants) for record in (old, new))
        outcome = hold_against(old, new, tolerances)
        sys.stdout.write(summary(outcome, against(options)))
    if options.accept:
        return accept(Path(known), new, outcome, options.accept_failures)
    assert outcome is not None
    if options.output:
        folder = Path(options.output)
        reports = {"summary.md": summary(outcome, against(options)), "junit.xml": junit(outcome, against(options))}
        write_folder(folder, reports | ({} if options.candidate else texts(new)))
        note(f"{'reports' if options.candidate else 'record and reports'} written to {folder}")
    return int(outcome.failed)


def refuse_odd(options: Namespace) -> None:
    """Raise BadRecord for words that do not go together."""
    if options.accept and options.candidate:
        raise BadRecord("--accept records what is flown; with --candidate nothing is")
    if options.accept and options.baseline and options.output not in (None, options.baseline):
        raise BadRecord("--accept writes one record: give -o DIR or --baseline DIR")
    if options.accept_failures and not options.accept:
        raise BadRecord("--accept-failures goes with --accept")
    if not options.accept and not options.baseline:
        raise BadRecord("give --baseline DIR to compare with a record, or --accept -o DIR to make one")
    if options.accept and not (options.baseline or options.output):
        raise BadRecord("--accept: give -o DIR to record into")
    if (
        not options.accept
        and options.output
        and Path(options.output).resolve()
        in {Path(folder).resolve() for folder in (options.baseline, options.candidate) if folder}
    ):
        raise BadRecord(f"-o {options.output} is a record that is compared: to replace it, --accept")


def fly(options: Namespace, old: Record | None) -> Record:
    """Return the record of what is asked for; where nothing is, of what the old record was asked for."""
    asked_scenes = options.scene or (old.scenes if old else ())
    asked_engines = options.engine or (old.contestants if old else ())
    if (
        not options.engine
        and not options.trust
        and (files := [word for word in asked_engines if is_file(split(word)[0])])
    ):
        named = shlex.join(part for word in files for part in ("-e", word))
        raise BadRecord(
            f"the record asks for {', '.join(files)}, and what a record names is not run by itself: name the engines "
            f"again ({named}), or --trust"
        )
    scenes = read_scenes(asked_scenes or catalogue())
    timed = not options.no_times and (old is None or old.times is not None)
    if options.output:
        Path(options.output).mkdir(parents=True, exist_ok=True)
    with taking_part(asked_engines, options, beside=old.contestants if old else ()) as running_engines:
        command, kept = shlex.join(options.words), None
        if options.output:
            asked = {"time limit [s]": f"{options.time_limit:g}"}
            kept = Kept(Path(options.output), binding(circumstances(running_engines, scenes, asked, command)))
        try:
            with progress(flights(running_engines, scenes) + len(scenes) * (1 + timed)) as on_progress:
                record = measure(
                    running_engines, scenes, (asked_scenes, asked_engines), command, timed, on_progress, kept
                )
        except KeyboardInterrupt:
            where = f"the flights that are done are kept in {options.output}; the same command goes on from there"
            raise KeyboardInterrupt(f"interrupted; {where if kept else 'nothing was written'}") from None
        if kept:
            kept.forget()
        return record


def timed_again(options: Namespace, old: Record, new: Record, tolerances: Tolerances) -> Record:
    """Return the new record with its times measured again, in new processes, on every scene where one has changed.

    A loop is faster or slower as its process happens to lie in memory, the reference's too: what is not found twice is
    not told.
    """
    changed = {change.scene for change in time_changes(old, new, tolerances)}
    if not changed or old.times is None or new.times is None:
        return new
    note(f"run times have changed on {', '.join(sorted(changed))}: measured again, to be sure")
    words = [word for word in options.scene or old.scenes or sorted(changed) if Path(word).stem in changed]
    again = fly(Namespace(**{**vars(options), "scene": words}), old)
    assert again.times is not None  # the old record has them
    return replace(new, times=nearer(old.times, new.times, again.times))


def accept(folder: Path, new: Record, outcome: Outcome | None, with_failures: bool) -> int:
    """Write a record; return 1 where it changes the one that was there, or where failures keep it from being one."""
    if (failed := failures(new)) and not with_failures:
        for contestant, status in failed.items():
            note(f"{contestant}: {status}")
        note("nothing is recorded: a record of these would call them unchanged; to record them, --accept-failures")
        return 1
    write_folder(folder, texts(new), without=(TIMES.file,) if new.times is None else ())
    note(f"{counted(len(new.cells), 'cell')} recorded in {folder}")
    if outcome is None or not outcome.changes:
        return 0
    note("this run fails because it changed the record: look at what it says above, and keep it if you mean it")
    return 1


def against(options: Namespace) -> list[str]:
    """Return the words that name baseline and tolerances in the command that reruns one cell."""
    tolerances = ["--tolerances", options.tolerances] if options.tolerances else []
    return ["--baseline", options.baseline or options.output, *tolerances]
