"""`tumble check`: compare what is measured now with an accepted baseline."""

import shlex
import sys
from argparse import Namespace
from pathlib import Path

from tumble.compare.check.changes import Outcome, compare_records
from tumble.compare.check.junit import junit
from tumble.compare.check.markdown import summary
from tumble.compare.check.record import BadRecord, Record, is_record, read_record, texts
from tumble.compare.check.study import Measuring, accept_record, check_scenes, measure_record
from tumble.compare.check.tolerances import read_tolerances
from tumble.compare.tables.files import write_folder
from tumble.notes import display, note
from tumble.reports.numerals import counted


def main(options: Namespace) -> int:
    """Compare with a baseline and print what changed, or accept one; return 1 if anything is worse, or it changed."""
    refuse_odd(options)
    tolerances = read_tolerances(options.tolerances)
    folder = Path(options.output) if options.output else None
    baseline = Path(options.baseline or options.output)
    old = read_record(baseline) if is_record(baseline) or not options.accept else None
    if folder:
        folder.mkdir(parents=True, exist_ok=True)
    how = Measuring(
        options.scene,
        options.engine,
        options.trust,
        not options.no_times,
        options.time_limit,
        options.memory_limit,
        shlex.join(options.words),
    )
    if options.accept:
        new = measure_record(how, old, display(options))
        outcome = None if old is None else compare_records(old, new, tolerances)
        if outcome is not None:
            sys.stdout.write(summary(outcome, against(options)))
        return accept(baseline, new, outcome, options.accept_failures)
    assert old is not None
    candidate = read_record(Path(options.candidate)) if options.candidate else None
    new, outcome = check_scenes(old, tolerances, how, candidate, display(options))
    sys.stdout.write(summary(outcome, against(options)))
    if folder:
        reports = {"summary.md": summary(outcome, against(options)), "junit.xml": junit(outcome, against(options))}
        write_folder(folder, reports | ({} if candidate else texts(new)))
        note(f"{'reports' if candidate else 'record and reports'} written to {folder}")
    return int(outcome.failed)


def refuse_odd(options: Namespace) -> None:
    """Raise BadRecord for options that exclude each other."""
    if options.accept and options.candidate:
        raise BadRecord("--accept records what it runs, and --candidate runs nothing: give one of them")
    if options.accept and options.baseline and options.output not in (None, options.baseline):
        raise BadRecord("--accept writes one record: give -o DIR or --baseline DIR")
    if options.accept_failures and not options.accept:
        raise BadRecord("--accept-failures needs --accept")
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
        raise BadRecord(f"-o {options.output} is one of the records compared: to replace it, give --accept")


def accept(folder: Path, new: Record, outcome: Outcome | None, with_failures: bool) -> int:
    """Write a record; return 1 if it changes the one that was there, or if failures keep it from being written."""
    if failed := accept_record(folder, new, with_failures):
        for contestant, status in failed.items():
            note(f"{contestant}: {status}")
        note("nothing was recorded, because these contestants failed; to record failures, give --accept-failures")
        return 1
    note(f"{counted(len(new.cells), 'cell')} recorded in {folder}")
    if outcome is None or not outcome.changes:
        return 0
    note("exit code 1: the baseline was updated; review the changes above and commit it if they are intended")
    return 1


def against(options: Namespace) -> list[str]:
    """Return the words that name baseline and tolerances in the command that reruns one cell."""
    tolerances = ["--tolerances", options.tolerances] if options.tolerances else []
    return ["--baseline", options.baseline or options.output, *tolerances]
