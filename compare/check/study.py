"""The study of `tumble check`: measure a record, compare it with a baseline, accept it."""

import logging
import shlex
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from tumble.compare.check.changes import Outcome, compare_records, failures, time_changes, within
from tumble.compare.check.measure import measure
from tumble.compare.check.record import BadRecord, Record, texts
from tumble.compare.check.schemas import TIMES
from tumble.compare.check.times import nearer
from tumble.compare.check.tolerances import Tolerances
from tumble.compare.contact.schemas import CONTACT
from tumble.compare.run.asked import known_contestant, wanted
from tumble.compare.run.engines.registry import is_file
from tumble.compare.run.local import Asked, LocalEngine
from tumble.compare.run.progress import Display, no_display
from tumble.compare.run.running_engines import TIME_LIMIT_S, flights
from tumble.compare.run.starting import started
from tumble.compare.run.worker import MEMORY_LIMIT
from tumble.compare.tables.files import write_folder
from tumble.scenarios.read import catalogue, read_scenes
from tumble.scenarios.scene import Scene

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Measuring:
    """How a record is measured.

    Of scenes and engines of the calling program, the record has the names.

    Parameters
    ----------
    scenes : words as on the command line, or scenes; empty: those of the baseline, or all
    contestants : words as on the command line, or engines; empty: those of the baseline, or all
    trust : run the engine files that the baseline names
    timed : measure run times
    time_limit : for each run [s]
    memory_limit : for each engine's process [B]
    command : command line that repeats the study
    """

    scenes: Sequence[str | Scene] = ()
    contestants: Sequence[Asked] = ()
    trust: bool = False
    timed: bool = True
    time_limit: float = TIME_LIMIT_S
    memory_limit: int = MEMORY_LIMIT
    command: str = ""


def measure_record(how: Measuring, baseline: Record | None = None, display: Display = no_display) -> Record:
    """Run every scene with every contestant, and return the record.

    Parameters
    ----------
    how : what is measured
    baseline : gives the scenes and contestants that `how` leaves empty
    display : shows progress

    Returns
    -------
    the record, without run times if the baseline has none

    Raises
    ------
    BadRecord : the baseline names engine files, and `how` does not trust them
    BadScene : a scene cannot be read
    BadEngine : an engine or a method is unknown
    """
    asked_scenes = how.scenes or (baseline.scenes if baseline else ())
    contestants = how.contestants or (baseline.contestants if baseline else ())
    files = [word for word in contestants if isinstance(word, str) and is_file(known_contestant(word).engine)]
    if not how.contestants and not how.trust and files:
        named = shlex.join(part for word in files for part in ("-e", word))
        raise BadRecord(
            f"the baseline names the engine files {', '.join(files)}, which are not run without your consent: "
            f"give them again ({named}), or --trust"
        )
    scenes = given_scenes(asked_scenes)
    landing = [scene for scene in scenes if scene.plane]
    timed = how.timed and (baseline is None or baseline.times is not None)
    beside = baseline.contestants if baseline else ()
    with (
        started(contestants, how.time_limit, how.memory_limit, display, beside=beside) as running_engines,
        display(flights(running_engines, [*scenes, *landing]) + len(scenes) + timed) as on_progress,
    ):
        words = names(asked_scenes), names(contestants)
        return measure(running_engines, scenes, words, how.command, timed, on_progress)


def check_scenes(
    baseline: Record,
    tolerances: Tolerances,
    how: Measuring,
    candidate: Record | None = None,
    display: Display = no_display,
) -> tuple[Record, Outcome]:
    """Measure what a baseline has, and find what changed beyond the tolerances.

    Parameters
    ----------
    baseline : the record to compare with
    tolerances : how much each column may change
    how : what is measured; its scenes and contestants limit the comparison, too
    candidate : a record to compare instead of measuring one
    display : shows progress

    Returns
    -------
    the record that was measured, or the candidate
    what changed

    Raises
    ------
    as `measure_record`
    """
    measured = candidate or measured_twice(baseline, tolerances, how, display)
    files_and_names = [one for one in how.contestants if isinstance(one, str)]
    engines = {**wanted(files_and_names)} if files_and_names else {}
    engines |= {one.name: [""] for one in how.contestants if isinstance(one, LocalEngine)}
    scenes = names(how.scenes)
    old, new = (within(record, scenes, engines, baseline.contestants) for record in (baseline, measured))
    return new, compare_records(old, new, tolerances)


def measured_twice(baseline: Record, tolerances: Tolerances, how: Measuring, display: Display) -> Record:
    """Return a record whose changed run times were measured again, in new processes.

    The time of a loop depends on where its process lies in memory, and so does the reference's: a change that is not
    found twice is not reported.
    """
    new = measure_record(how, baseline, display)
    changed = {change.scene for change in time_changes(baseline, new, tolerances)}
    if not changed or baseline.times is None or new.times is None:
        return new
    log.info(f"run times changed on {', '.join(sorted(changed))}: measuring them again")
    asked = how.scenes or baseline.scenes or sorted(changed)
    again = measure_record(
        replace(how, scenes=[one for one in asked if Path(name_of(one)).stem in changed]), baseline, display
    )
    assert again.times is not None  # the baseline has them
    return replace(new, times=nearer(baseline.times, new.times, again.times))


def given_scenes(asked: Sequence[str | Scene]) -> list[Scene]:
    """Return scenes that were given by name, by path or as they are; all of the catalogue where none was."""
    given = [one for one in asked if isinstance(one, Scene)]
    return given if given else read_scenes([one for one in asked if isinstance(one, str)] or catalogue())


def names(given: Sequence[str | Scene | LocalEngine]) -> list[str]:
    """Return the words by which a record keeps scenes and contestants."""
    return [name_of(one) for one in given]


def name_of(one: str | Scene | LocalEngine) -> str:
    """Return a word of the command line, or the name of what was given as it is."""
    return one if isinstance(one, str) else one.name


def accept_record(folder: Path, record: Record, with_failures: bool = False) -> dict[str, str]:
    """Write a record, unless it has failures.

    Parameters
    ----------
    folder : where it is written
    record : the record
    with_failures : write it even if contestants crashed, hung or are missing

    Returns
    -------
    the status of each failed contestant that kept the record from being written; empty if it was written

    Raises
    ------
    OSError : the folder cannot be written to
    """
    if (failed := failures(record)) and not with_failures:
        return failed
    found = texts(record)
    write_folder(folder, found, without=[file for file in (TIMES.file, CONTACT.file) if file not in found])
    return {}
