"""Measures what more workers make of a release ledger and of very many throws, and fits a model of many machines.

.venv/bin/python -m tools.efficiency [--measure WORKLOAD ...]    makes the table of docs/many-machines.md

Each command runs with 1, 2 and 4 Dask workers, and again with its finished tasks found: what that takes is serial.
Processor time is what the model needs, because other work on the machine changes it little.  Workloads that are not
measured again stay as they are recorded in docs/figures/many-machines.csv.
"""

import csv
import os
import resource
import subprocess
import sys
import time
from argparse import ArgumentParser
from collections.abc import Sequence
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory

import numpy as np
import psutil

from tumble.scenarios.read import CATALOGUE

DOCS = Path(__file__).parents[1] / "docs"
PAGE, RECORDED = DOCS / "many-machines.md", DOCS / "figures" / "many-machines.csv"
BEGIN, END = "<!-- table of tools.efficiency -->\n", "<!-- end of table -->\n"
# Workers, one of them twice: what the machine itself does meanwhile.
WORKERS, MACHINES = (1, 2, 4, 1), (1, 2, 4, 16, 100)
# The ledger of docs/releases/mujoco, whose releases are installed before it is measured, and throws of an ensemble.
LEDGER = ["releases", "mujoco", "--from", "3.6.0"]
THROWS = {"ledger": 0, "5e6": 5_000_000, "1e8": 100_000_000}
TITLES = {"ledger": "release ledger", "5e6": "5e6 throws", "1e8": "1e8 throws"}
SMALL = {"1e8": "5e6"}
COLUMNS: tuple[str, ...] = ("workload", "workers", "wall_s", "processor_s", "serial_s", "load", "cores")
Row = dict[str, str]


def command(workload: str, folder: Path) -> list[str]:
    """Return the words of a workload."""
    if not THROWS[workload]:
        return LEDGER
    scene = folder / "throws.toml"
    text = (CATALOGUE / "many-throws.toml").read_text(encoding="utf-8")
    scene.write_text(text.replace("throws = 24", f"throws = {THROWS[workload]}"), encoding="utf-8")
    return ["compare", str(scene), "-e", "tumble:exact-lanes"]


def measured(workload: str, workers: int) -> Row:
    """Run a command on so many workers, and again with its finished tasks found; return a row."""
    load = psutil.getloadavg()[0]
    with TemporaryDirectory() as place:
        options = ["-q", "--workers", str(workers), "--cache", f"{place}/cache"]
        words = [sys.executable, "-m", "tumble", *command(workload, Path(place)), *options]
        (wall, processor), (_, serial) = took(words), took(words)
    figures = (f"{figure:.4g}" for figure in (wall, processor, serial, load))
    return dict(zip(COLUMNS, (workload, str(workers), *figures, str(os.cpu_count())), strict=True))


def took(words: list[str]) -> tuple[float, float]:
    """Return the wall and the processor time of a command with all that it starts [s]."""
    before, begun = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    subprocess.run(words, check=True, stdout=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.monotonic() - begun, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def tables(rows: Sequence[Row]) -> str:
    """Return the table of what was measured, and that of the model, both in Markdown."""
    own = {workload: [row for row in rows if row["workload"] == workload] for workload in THROWS}
    lines = [line(row, each) for each in own.values() for row in each]
    # What a worker takes for itself is the same with all numbers of throws, and less than the noise of the most.
    fitted = {workload: of_each_worker(own[SMALL.get(workload, workload)]) for workload, each in own.items() if each}
    machines = [f"{n}" for n in MACHINES]
    return "\n".join(
        (
            table(["", "workers", "wall [s]", "efficiency", "processor time [s]", "of it serial [s]", "load"], lines),
            f"Measured on {rows[0]['cores']} cores. Efficiency of 1 to 100 machines by the model:\n",
            table(
                ["", "serial [s]", "of each worker [s]", "work [s]", *machines],
                [model(each, fitted[workload]) for workload, each in own.items() if each],
            ),
        )
    )


def table(names: Sequence[str], lines: Sequence[Sequence[str]]) -> str:
    """Return a table in Markdown."""
    return "".join(f"| {' | '.join(cells)} |\n" for cells in (names, ["---"] * len(names), *lines))


def line(row: Row, own: Sequence[Row]) -> list[str]:
    """Return the cells of a measured row; own: all rows of its workload."""
    wall, workers = row["wall_s"], int(row["workers"])
    alone = [float(each["wall_s"]) for each in own if each["workers"] == "1" and each["wall_s"]]
    efficiency = f"{median(alone) / float(wall) / workers:.0%}" if wall and alone else ""
    shown = [seconds(float(row[name])) if row[name] else "" for name in ("processor_s", "serial_s")]
    shown = [seconds(float(wall)) if wall else "", efficiency, *shown]
    return [TITLES[row["workload"]], row["workers"], *shown, f"{float(row['load']):.0f}"]


def model(rows: Sequence[Row], own_s: float) -> list[str]:
    """Return the cells of the model T(n) = serial + own + work / n, of processor time (Amdahl, 1967).

    own_s: what each worker takes for itself, to start and to start engines
    """
    alone = [row for row in rows if row["workers"] == "1"]
    known = [row for row in alone if row["serial_s"]] or [row for row in rows if row["serial_s"]]
    serial = median(float(row["serial_s"]) for row in known)
    work = median(float(row["processor_s"]) for row in alone) - serial - own_s
    shares = (f"{(serial + own_s + work) / (n * (serial + own_s) + work):.0%}" for n in MACHINES)
    return [TITLES[alone[0]["workload"]], *map(seconds, (serial, own_s, work)), *shares]


def of_each_worker(rows: Sequence[Row]) -> float:
    """Return by how much the processor time rises with each worker: the slope of a line fitted to all rows [s]."""
    workers, processor = (np.array([float(row[name]) for row in rows]) for name in ("workers", "processor_s"))
    return max(0.0, float(np.polyfit(workers, processor, 1)[0]))


def seconds(value: float) -> str:
    """Return a time with three figures."""
    return f"{value:.0f}" if value >= 100 else f"{value:.3g}"


def recorded() -> list[Row]:
    """Return the rows that were measured before."""
    with RECORDED.open(newline="", encoding="utf-8") as file:
        return [*csv.DictReader(file)]


def record(rows: Sequence[Row]) -> None:
    """Write rows down, in the order of the workloads."""
    with RECORDED.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(sorted(rows, key=lambda row: [*THROWS].index(row["workload"])))


def page(text: str) -> str:
    """Return the page with the tables of what is recorded."""
    before, _, rest = text.partition(BEGIN)
    return f"{before}{BEGIN}\n{tables(recorded())}\n{END}{rest.partition(END)[2]}"


def main() -> None:
    """Measure what is asked for, and make the table."""
    parser = ArgumentParser(
        prog="tools.efficiency", description="Make the table of efficiency in docs/many-machines.md."
    )
    parser.add_argument(
        "--measure", nargs="*", choices=THROWS, default=[], metavar="WORKLOAD",
        help=f"measure these first, {', '.join(THROWS)}: ten minutes, twenty and some hours",
    )  # fmt: skip
    asked: list[str] = parser.parse_args().measure
    if "ledger" in asked:
        subprocess.run([sys.executable, "-m", "tumble", *LEDGER, "--install", "-q"], check=True)
    kept = [row for row in recorded() if row["workload"] not in asked]
    record([*kept, *(measured(workload, workers) for workload in asked for workers in WORKERS)])
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    main()
