"""Runs every kind of attack on Tumble, as often as the options say, and writes the results to docs/attacks.md.

The work is split into pieces for several processes (default: one per core); each attack has its own folder.

`make attack` runs all; `python tests/attack/attacks.py --kills 20 --inputs 10000` is shorter.  The tests in this folder
are a sample of each kind.
"""

import argparse
import json
import os
import platform
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Collection, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, field
from functools import cache
from itertools import islice
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import damaged
import engine_files
import kills
import starved

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tests" / "support"))

import fuzz  # noqa: E402

PAGE = ROOT / "docs" / "attacks.md"
# What the page is made of: a row of each kind, as it was tried last.
TALLIES = ROOT / "docs" / "attacks.json"
FILES = "damaged files"
# So many damaged files are one piece of work.
PART = 5000
KINDS: dict[str, Callable[[], Mapping[str, Callable[[Path], object]]]] = {
    "kills": kills.all_attacks,
    "engine files": engine_files.all_attacks,
    "damages to each file of a folder": damaged.all_attacks,
    "starved machines": starved.all_attacks,
}
TEXT = """# Attacks on Tumble, and their results

`make attack` runs all attacks and writes this page; the tests in `tests/attack/` are a sample of each kind. Tumble
survives an attack if it reports the problem in one line with the file, status or reason, exits with the documented
code, leaves no half-written file and no process behind, and does not affect other results. Any other outcome is a
loss, listed below the table.

| attack | tried | survived | lost | time | conditions |
| --- | ---: | ---: | ---: | ---: | --- |
{rows}

{lost}

{total} attacks. Time: of all processes together, waiting for a core included. Repeating one kind (`python
tests/attack/attacks.py --only kills`) replaces its own row.

The kinds: engine files that raise, exit, hang, fork, hoard memory, return false results or write into the protocol
(`engine_files.py`); machines without a home folder, disk space, memory, streams, signals or a UTF-8 locale
(`starved.py`); folders of tables with each file damaged in {damages} ways (`damaged.py`); commands killed by a random
signal at a random time, with and without an older result, and then repeated (`kills.py`); files of every kind that
Tumble reads, with numbers changed and with pieces deleted, inserted, repeated or copied from other files
(`tests/support/fuzz.py`).
"""


@dataclass
class Tally:
    """What became of one kind of attack."""

    what: str
    tried: int = 0
    lost: list[str] = field(default_factory=list)
    seconds: float = 0.0
    read: int = 0
    on: str = ""

    @property
    def row(self) -> str:
        """Its row of the table."""
        what = self.what
        if what.startswith(FILES):
            what += f" ({self.read} read, {self.tried - self.read - len(self.lost)} refused)"
        took = f"{self.seconds / 60:.0f} min" if self.seconds > 90 else f"{self.seconds:.0f} s"
        return f"| {what} | {self.tried} | {self.tried - len(self.lost)} | {len(self.lost)} | {took} | {self.on} |"

    def add(self, other: "Tally") -> None:
        """Count what became of more of the kind."""
        self.tried += other.tried
        self.lost += other.lost
        self.seconds += other.seconds
        self.read += other.read


def attempt(kind: str, name: str) -> Tally:
    """Try one attack of a kind."""
    tally, begin = Tally(kind, 1), time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        try:
            attacks(kind)[name](Path(folder))
        except Exception as error:
            tally.lost.append(f"{name}: {' '.join(str(error).split())[:200]}")
    tally.seconds = time.monotonic() - begin
    return tally


@cache
def attacks(kind: str) -> Mapping[str, Callable[[Path], object]]:
    """Return the attacks of a kind by their names; kills by their seeds."""
    return KINDS[kind]()


def inputs(parser: str, numbers: range) -> Tally:
    """Give a parser its damaged files with these numbers."""
    begin = time.monotonic()
    outcome = fuzz.fuzz(parser, numbers)
    tried = outcome.found + outcome.refused + len(outcome.lost)
    return Tally(f"{FILES}: {parser}", tried, outcome.lost, time.monotonic() - begin, outcome.found)


def jobs(only: Collection[str], kills_asked: int, inputs_asked: int) -> Iterator[tuple[Callable[..., Tally], Any, Any]]:
    """Yield what is to be done, in pieces of a minute or so at most, those that take longest first."""
    for parser, share in fuzz.SHARES.items():
        many = round(inputs_asked * share) if parser in only else 0
        yield from ((inputs, parser, range(first, min(first + PART, many))) for first in range(0, many, PART))
    for kind in (kind for kind in KINDS if kind in only):
        names = attacks(kind)
        yield from ((attempt, kind, name) for name in islice(names, kills_asked if kind == "kills" else None))


def state_of_the_tree() -> str:
    """Return the commit that is attacked, and whether anything was changed since."""
    said = subprocess.run(
        ["git", "describe", "--always", "--abbrev=12", "--dirty=, with changes"],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )
    return said.stdout.strip() or "unknown"


def page(rows: Mapping[str, Tally]) -> str:
    """Return the page."""
    order = sorted(rows.values(), key=lambda tally: tally.what)
    lost = [f"- {tally.what}: {line}" for tally in order for line in tally.lost]
    return TEXT.format(
        rows="\n".join(tally.row for tally in order),
        total=sum(tally.tried for tally in order),
        lost="\n".join(lost) if lost else "Nothing was lost.",
        damages=len(damaged.DAMAGE),
    )


def kept() -> dict[str, Tally]:
    """Return what earlier runs have tried, by kind."""
    return {row["what"]: Tally(**row) for row in json.loads(TALLIES.read_text())} if TALLIES.exists() else {}


def main() -> None:
    """Attack, and write the page."""
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("--kills", type=int, default=100)
    words.add_argument("--inputs", type=int, default=1_000_000)
    words.add_argument("--processes", type=int, default=os.cpu_count())
    words.add_argument("--only", nargs="+", choices=(*fuzz.PARSERS, *KINDS), default=(*fuzz.PARSERS, *KINDS))
    options = words.parse_args()

    def say(line: str) -> None:
        print(line, flush=True)

    tallies, begin = kept(), time.monotonic()
    new: dict[str, Tally] = {}
    commit, day = state_of_the_tree(), time.strftime("%Y-%m-%d")
    with ProcessPoolExecutor(options.processes, get_context("spawn")) as pool:
        done = [pool.submit(*job) for job in jobs(options.only, options.kills, options.inputs)]
        for number, each in enumerate(as_completed(done), start=1):
            found = each.result()
            own = new.setdefault(found.what, Tally(found.what))
            own.add(found)
            machine = f"Python {platform.python_version()}, {platform.system()}, {os.cpu_count()} cores"
            own.on = f"{commit}, {day}, {machine}, {options.processes} at once, load {os.getloadavg()[2]:.0f}"
            for line in found.lost:
                say(f"lost: {found.what}: {line}")
            if number % 20 == 0 or number == len(done):
                say(f"{number} of {len(done)} pieces, {(time.monotonic() - begin) / 60:.0f} min")
                # Hours: what is known is kept.
                TALLIES.write_text(json.dumps([vars(tally) for tally in (tallies | new).values()], indent=1) + "\n")
                PAGE.write_text(page(tallies | new), encoding="utf-8")
    lost = sum(len(tally.lost) for tally in new.values())
    sys.exit(f"{lost} attacks were lost" if lost else 0)


if __name__ == "__main__":
    main()
