"""What a benchmark found: figures beside what was asked of them, printed and written as CSV.

A figure is found once in each pass, from the lower deciles of that pass's interleaved rounds; the table has the mean,
the least and the greatest of them.
"""

import os
import resource
import subprocess
import time
from argparse import ArgumentParser
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from subprocess import DEVNULL

import numpy as np
from numpy.typing import ArrayLike

from tumble.compare.run.condition import ConditionRow
from tumble.compare.run.provenance import conditions
from tumble.compare.tables.files import write_whole
from tumble.compare.tables.frames import csv_text, frame
from tumble.compare.tables.schema import Table

Clock = Callable[[], float]
CONDITIONS = ".conditions.csv"


@dataclass(frozen=True)
class FigureRow:
    """One figure: what, against whom, at which error [m] where it is at one, what was asked, and what was reached."""

    what: str
    peer: str
    error_m: float | None
    unit: str
    asked: float | None
    reached: float | None
    low: float | None
    high: float | None


def figure(what: str, peer: str, unit: str, asked: float | None, passes: ArrayLike) -> FigureRow:
    """Return the row of a figure found once in each pass."""
    return FigureRow(what, peer, None, unit, asked, *(float(f(passes)) for f in (np.mean, np.min, np.max)))  # pyright: ignore[reportCallIssue]


def lower_deciles(tasks: Mapping[str, tuple[Callable[[], object], Clock]], rounds: int) -> dict[str, float]:
    """Return what each task takes by its clock [s], all of them once a round."""
    samples: dict[str, list[float]] = {name: [] for name in tasks}
    for _ in range(rounds):
        for name, (task, clock) in tasks.items():
            begin = clock()
            task()
            samples[name].append(clock() - begin)
    return {name: float(np.percentile(times, 10)) for name, times in samples.items()}


def processor_s(call: Callable[[], object]) -> float:
    """Return the processor time of a call by this process and its threads [s]."""
    begin = time.process_time()
    call()
    return time.process_time() - begin


def of_process(command: Sequence[str], **environment: str) -> tuple[float, float]:
    """Run a command, silent; return its wall time and the processor time of all its processes [s].

    Raises CalledProcessError unless it succeeds or finds what it checks to have failed (exit code 1).
    """
    before, begin = of_children(), time.perf_counter()
    done = subprocess.run(command, check=False, env={**os.environ, **environment}, stdout=DEVNULL, stderr=DEVNULL)
    if done.returncode > 1:
        done.check_returncode()
    return time.perf_counter() - begin, of_children() - before


def of_children() -> float:
    """Return the processor time of all processes that were started here and have ended [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def rows_of(what: str, asked: float | None, passes: Sequence[tuple[float, float]]) -> list[FigureRow]:
    """Return a row of wall time and one of processor time."""
    wall, processor = zip(*passes, strict=True)
    return [figure(f"{what}, wall", "", "s", asked, wall), figure(f"{what}, processor", "", "s", None, processor)]


def thread_clock() -> float:
    """Read the clock of a task of one thread [s]."""
    return time.thread_time()


def wall_clock() -> float:
    """Read the clock of a task of several threads, or processes [s]."""
    return time.perf_counter()


def output_option(description: str) -> Path | None:
    """Return the CSV file asked for on the command line, or None."""
    parser = ArgumentParser(description=description)
    parser.add_argument("-o", "--output", type=Path, metavar="FILE.csv", help="also write the figures as CSV")
    return parser.parse_args().output


def show(rows: Sequence[FigureRow], output: Path | None) -> None:
    """Print the figures under the conditions they were found in, and write both as CSV where asked."""
    found = [ConditionRow("date", time.strftime("%Y-%m-%d")), *(row for row in conditions("") if row.value)]
    print("; ".join(f"{row.what} {row.value}" for row in found))
    print(f"{'what':>30} {'against':30}{'error':>6} {'unit':>6}{'asked':>9}{'reached':>10}{'low':>10}{'high':>10}")
    for row in rows:
        at = "" if row.error_m is None else f"{row.error_m:.0e}"
        numbers = (f"{'' if x is None else f'{x:.4g}':>{w}}" for x, w in ((row.asked, 9), (row.reached, 10)))
        spread = (f"{'' if x is None else f'{x:.4g}':>10}" for x in (row.low, row.high))
        print(f"{row.what:>30} {row.peer:30}{at:>6} {row.unit:>6}", *numbers, *spread, sep="")
    if output:
        write_whole(output, csv_text(frame(Table("", FigureRow), rows)))
        write_whole(output.with_suffix(CONDITIONS), csv_text(frame(Table("", ConditionRow), found)))
