"""Measures what more workers make of a release ledger and of very many throws, and fits a model of many machines.

.venv/bin/python -m tools.efficiency [--measure]    makes the table of docs/many-machines.md, of new measurements or old

Each command runs with 1, 2 and 4 Dask workers, and again with its finished tasks found: what that takes is serial.
Processor time is what a model needs, because other work on the machine changes it little.
"""

import csv
import os
import resource
import subprocess
import sys
import time
from argparse import ArgumentParser
from contextlib import suppress
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory

import psutil

from tumble.compare.judge.spread import Spread, added
from tumble.compare.run.process.message import Malformed, unpacked
from tumble.compare.run.task_cache import parts
from tumble.scenarios.read import CATALOGUE

DOCS = Path(__file__).parents[1] / "docs"
PAGE, RECORDED = DOCS / "many-machines.md", DOCS / "figures" / "many-machines.csv"
BEGIN, END = "<!-- table of tools.efficiency -->\n", "<!-- end of table -->\n"
# Workers, one of them twice: what the machine itself does meanwhile.
WORKERS = 1, 2, 4, 1
MACHINES = 1, 2, 4, 16, 100
THROWS, WANTED = 5_000_000, 100_000_000
LEDGER, ENSEMBLE = "release ledger", f"{THROWS} throws"
# The model is of that many times the work.
SCALE = {LEDGER: 1, ENSEMBLE: WANTED // THROWS}
COLUMNS: tuple[str, ...] = (
    "workload",
    "workers",
    "wall_s",
    "processor_s",
    "serial_s",
    "parts",
    "adding_s",
    "load",
    "cores",
)


def command(workload: str, folder: Path) -> list[str]:
    """Return the words of a workload."""
    if workload == LEDGER:
        return ["releases", "mujoco", "two-hits"]
    scene = folder / "throws.toml"
    scene.write_text((CATALOGUE / "many-throws.toml").read_text().replace("throws = 24", f"throws = {THROWS}"))
    return ["compare", str(scene), "-e", "tumble:exact-lanes"]


def measured(workload: str, workers: int) -> dict[str, object]:
    """Run a command on so many workers, and again with its finished tasks found; return a row."""
    load = psutil.getloadavg()[0]
    with TemporaryDirectory() as place:
        options = ["-q", "--workers", str(workers), "--cache", f"{place}/cache"]
        words = [sys.executable, "-m", "tumble", *command(workload, Path(place)), *options]
        (wall, processor), (_, serial) = took(words), took(words)
        parts, adding = added_up(Path(place) / "cache")
    figures = workload, workers, wall, processor, serial, parts, adding, load, os.cpu_count()
    return dict(zip(COLUMNS, (f"{one:.4g}" if isinstance(one, float) else one for one in figures), strict=True))


def took(words: list[str]) -> tuple[float, float]:
    """Return the wall and the processor time of a command with all that it starts [s]."""
    before, begun = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    subprocess.run(words, check=True, stdout=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.monotonic() - begun, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def added_up(cache: Path) -> tuple[int, float]:
    """Return the number of saved parts of an ensemble, and the processor time to read and add all of them up [s]."""
    begun, count, total = time.process_time(), 0, Spread(0)
    for file in cache.iterdir():
        _, head, body = parts(file)
        with suppress(Malformed):
            total, count = added(total, unpacked(Spread, head, body)), count + 1
    return count, time.process_time() - begun if count else 0.0


def table(rows: list[dict[str, str]]) -> str:
    """Return the tables of what was measured, and of the model."""
    names = "", "workers", "wall [s]", "efficiency", "processor time [s]", "of it serial [s]", "load"
    head = f"| {' | '.join(names)} |\n{'|---' * len(names)}|\n"
    lines, models = [], []
    for workload in dict.fromkeys(row["workload"] for row in rows):
        own = [row for row in rows if row["workload"] == workload]
        alone = median(float(row["wall_s"]) for row in own if row["workers"] == "1")
        for row in own:
            wall, workers = float(row["wall_s"]), int(row["workers"])
            lines.append(
                f"| {workload} | {workers} | {wall:.3g} | {alone / wall / workers:.0%} | "
                f"{float(row['processor_s']):.3g} | {float(row['serial_s']):.3g} | {float(row['load']):.0f} |\n"
            )
        models.append(model(workload, own))
    machines = "".join(f" {n} |" for n in MACHINES)
    header = f"| | serial [s] | work [s] |{machines}\n|---|---|---|{'---|' * len(MACHINES)}\n"
    between = (
        f"\nMeasured on {rows[0]['cores']} cores. Efficiency of 1 to 100 machines by the model serial + work / n:\n\n"
    )
    return f"{head}{''.join(lines)}{between}{header}{''.join(models)}"


def model(workload: str, rows: list[dict[str, str]]) -> str:
    """Return the line of the model T(n) = serial + work / n, of processor time with one worker (Amdahl, 1967)."""
    alone = [row for row in rows if row["workers"] == "1"]
    scale = SCALE[workload]
    start = median(float(row["serial_s"]) for row in alone)
    work = scale * (median(float(row["processor_s"]) for row in alone) - start)
    serial = start + (scale - 1) * median(float(row["adding_s"]) for row in rows)
    shown = "".join(f" {(serial + work) / (n * serial + work):.0%} |" for n in MACHINES)
    return f"| {workload}{f', {scale} times' * (scale > 1)} | {serial:.3g} | {work:.3g} |{shown}\n"


def page(text: str) -> str:
    """Return the page with the tables of what is recorded."""
    with RECORDED.open(newline="", encoding="utf-8") as file:
        rows = [*csv.DictReader(file)]
    before, _, rest = text.partition(BEGIN)
    return f"{before}{BEGIN}\n{table(rows)}\n{END}{rest.partition(END)[2]}"


def main() -> None:
    """Measure where asked, and make the table."""
    parser = ArgumentParser(
        prog="tools.efficiency", description="Make the table of efficiency in docs/many-machines.md."
    )
    parser.add_argument("--measure", action="store_true", help="measure first, which takes minutes")
    if parser.parse_args().measure:
        rows = [measured(workload, workers) for workload in SCALE for workers in WORKERS]
        with RECORDED.open("w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    main()
