"""Attacks Tumble in every way there is here, as often as asked, and writes docs/attacks.md: what was tried, and lost.

`make attack` is the long form; `python tests/attack/attacks.py --kills 20 --inputs 10000` a shorter one.  The tests
beside it are a few of each.
"""

import argparse
import os
import platform
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from itertools import chain
from pathlib import Path

import damaged
import engine_files
import kills
import starved

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tests" / "support"))

import fuzz  # noqa: E402

PAGE = ROOT / "docs" / "attacks.md"
TEXT = """# What was done to Tumble, and what was lost

Made by `make attack`, which runs all of it and writes this page; the tests in `tests/attack/` are a few of each.
Survived means: told in one line with its file, its status or its reason, exit code as documented, nothing half written,
nothing left running, everybody else's results unharmed. Anything else is lost, and named below the table.

| what | tried | survived | lost | how long |
| --- | ---: | ---: | ---: | ---: |
{rows}

{lost}

{when}

What each is: engine files that raise, die, hang, fork, hoard, lie or write into the line (`engine_files.py`); machines
without a home, a disk, memory, streams, signals or letters (`starved.py`); folders of tables with each of their files
damaged in {damages} ways (`damaged.py`); commands killed by a random signal at a random moment, beside an older result
or none, then run again (`kills.py`); files of every kind that Tumble reads with other numbers, and pieces cut out, put
in, doubled or taken from others (`tests/support/fuzz.py`).
"""


@dataclass
class Tally:
    """What became of one kind of attack."""

    what: str
    tried: int = 0
    lost: list[str] = field(default_factory=list)
    seconds: float = 0.0

    @property
    def row(self) -> str:
        """Its row of the table."""
        took = f"{self.seconds / 60:.0f} min" if self.seconds > 90 else f"{self.seconds:.0f} s"
        return f"| {self.what} | {self.tried} | {self.tried - len(self.lost)} | {len(self.lost)} | {took} |"


def each(what: str, attacks: Mapping[str, Callable[[Path], object]], say: Callable[[str], object]) -> Tally:
    """Try all attacks of one kind."""
    tally, begin = Tally(what), time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        for name, attack in attacks.items():
            tally.tried += 1
            try:
                attack(Path(folder))
            except Exception as error:
                tally.lost.append(f"{name}: {' '.join(str(error).split())[:200]}")
                say(f"lost: {tally.lost[-1]}")
    tally.seconds = time.monotonic() - begin
    return tally


def inputs(count: int) -> Iterator[Tally]:
    """Give each parser its share of so many damaged files."""
    for name, parser in fuzz.PARSERS.items():
        share = round(count * fuzz.SHARES[name])
        tally, begin = Tally(f"damaged files: {name}"), time.monotonic()
        with tempfile.TemporaryDirectory() as folder:
            try:
                found, refused = parser(Path(folder), share)
                tally.tried = found + refused
                tally.what += f" ({found} read, {refused} refused)"
            except BaseException as error:
                if isinstance(error, KeyboardInterrupt):
                    raise
                tally.tried = share
                tally.lost.append(f"{name}: {type(error).__name__}: {' '.join(str(error).split())[:200]}")
        tally.seconds = time.monotonic() - begin
        yield tally


def page(tallies: list[Tally], asked: str) -> str:
    """Return the page."""
    lost = [f"- {tally.what}: {line}" for tally in tallies for line in tally.lost]
    when = (
        f"{sum(tally.tried for tally in tallies)} attacks ({asked}) on {time.strftime('%Y-%m-%d')}, Python "
        f"{platform.python_version()}, {platform.system()}, {os.cpu_count()} cores, load {os.getloadavg()[2]:.1f}."
    )
    rows = "\n".join(tally.row for tally in tallies)
    return TEXT.format(
        rows=rows, lost="\n".join(lost) if lost else "Nothing was lost.", when=when, damages=len(damaged.DAMAGE)
    )


def main() -> None:
    """Attack, and write the page."""
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("--kills", type=int, default=100)
    words.add_argument("--inputs", type=int, default=1_000_000)
    words.add_argument("-o", type=Path, default=PAGE)
    options = words.parse_args()

    def say(line: str) -> None:
        print(line, flush=True)

    kinds = {
        "engine files": engine_files.all_attacks(),
        "damages to each file of a folder": damaged.all_attacks(),
        "kills": {str(seed): partial(kills.attack, seed=seed) for seed in range(options.kills)},
        "starved machines": starved.all_attacks(),
    }
    tallies: list[Tally] = []
    # Hours: what is known is kept.
    for tally in chain(inputs(options.inputs), (each(what, attacks, say) for what, attacks in kinds.items())):
        tallies.append(tally)
        say(tally.row)
        options.o.write_text(page(tallies, f"--kills {options.kills} --inputs {options.inputs}"), encoding="utf-8")
    lost = sum(len(tally.lost) for tally in tallies)
    sys.exit(f"{lost} attacks were lost" if lost else 0)


if __name__ == "__main__":
    main()
