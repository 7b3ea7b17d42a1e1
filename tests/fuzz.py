"""Parsers against damaged files: whatever is in one, an object comes back or one line, and soon.

The tests give each parser a few; `python tests/fuzz.py 100000` gives each that many.
"""

import random
import re
import signal
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

from compare.check.changes import hold_against
from compare.check.junit import junit
from compare.check.markdown import summary
from compare.check.record import BadRecord, CellRow, QuestionRow, Record, TimeRow, read_record, texts
from compare.check.tolerances import BadTolerance, Tolerances, read_tolerances
from compare.results import EngineRow, write_tables
from scenarios.read import BadScene, read_scene

ROOT = Path(__file__).parent.parent
# A file that takes longer hangs, as far as its reader is concerned.
LONGEST_S = 20
TOKENS = (
    b"nan", b"-inf", b"1e400", b"-0.0", b"0", b"-1", b"5e-324", b"9" * 400, b"0x" + b"f" * 60, b"true", b"[", b"]]",
    b"{", b"}", b'"', b"'''", b"=", b",", b"\n", b"\r", b"\t", b"\x00", b"\x1b[31m", b"\xff", b"\xef\xbb\xbf",
    "\u202e".encode(), b"#", b".", b"a.b.c", b"[[impulse]]", b"[floor]", b"kept", b"ok", b"flagged: x",
    b"skipped: ", b"=1+1", b"-",
)  # fmt: skip


def damaged(rng: random.Random, seeds: list[bytes], others: list[bytes]) -> bytes:
    """Return one of the seeds with other numbers in it, or pieces cut out, put in, doubled, or taken from others."""
    text = rng.choice(seeds)
    for _ in range(rng.randint(1, 3)):
        numbers = [match.span() for match in re.finditer(rb"\d[\d.]*", text)]
        if numbers and rng.random() < 0.5:
            begin, end = rng.choice(numbers)
            piece = rng.choice((number(rng), rng.choice(TOKENS[:8])))
        else:
            begin = rng.randint(0, len(text))
            end = min(len(text), begin + rng.choice((0, 1, 2, 5, 40)))
            other = rng.choice(others)
            cut = rng.randint(0, len(other))
            own = text[begin:end] * 2
            piece = rng.choice((b"", rng.choice(TOKENS), bytes([rng.randrange(256)]), own, other[cut : cut + 40]))
        text = text[:begin] + piece + text[end:]
    return text


def number(rng: random.Random) -> bytes:
    """Return a number of any size, more often of a person's."""
    size = rng.choice((rng.uniform(-3, 3), rng.uniform(-320, 300)))
    return f"{rng.choice((1, 1, -1)) * 10.0**size:.{rng.randint(1, 17)}g}".encode()


@contextmanager
def in_time() -> Iterator[None]:
    """Raise TimeoutError where what is done inside does not end."""

    def too_long(*_: object) -> None:
        raise TimeoutError(f"took more than {LONGEST_S} s")

    before = signal.signal(signal.SIGALRM, too_long)
    signal.alarm(LONGEST_S)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def outcomes(read: Callable[[], object], refusal: type[Exception], count: int) -> tuple[int, int]:
    """Return how many of so many files were read and how many refused.  Raises whatever else happens."""
    found, refused = 0, 0
    for _ in range(count):
        with in_time():
            try:
                read()
                found += 1
            except refusal as error:
                refused += 1
                if not str(error).isprintable():
                    raise AssertionError(f"not one line: {error!r}") from error
    return found, refused


def scenes(folder: Path, count: int) -> tuple[int, int]:
    """Fuzz scene files."""
    rng, file = random.Random(1), folder / "scene.toml"
    seeds, bad = (
        [path.read_bytes() for path in sorted((ROOT / where).glob("*.toml"))]
        for where in ("scenarios/catalogue", "tests/bad")
    )

    def read() -> None:
        file.write_bytes(damaged(rng, seeds, bad))
        read_scene(str(file))

    return outcomes(read, BadScene, count)


def tolerances(folder: Path, count: int) -> tuple[int, int]:
    """Fuzz tolerance files."""
    rng, file = random.Random(2), folder / "tolerances.toml"
    seeds = [b"max_error_m = 0.1\ntime_ratio = 2\n", b"energy_drift = 1e-3 # a word\nattitude_order = 0.5\n"]

    def read() -> None:
        file.write_bytes(damaged(rng, seeds, seeds))
        read_tolerances(str(file))

    return outcomes(read, BadTolerance, count)


BASE = Record(
    ("s", "./t.toml"),
    ("e", "./mine.py:m"),
    "tumble check",
    (
        QuestionRow("s", 0.5, 5, "exact", 1e-15, 0.3, 1.0, 2.0, 3.0),
        QuestionRow("t", 0.5, 5, "none", None, 1.0, None, None, None),
    ),
    (EngineRow("e", "ok", "1", "double", "m", "", "nothing"), EngineRow("mine", "ok", "1", "double", "m", "", "")),
    (
        CellRow("s", "e", "m", 99, "ok", 1e-3, 5e-4, 9e-4, 1e-15, 1e-13, -1e-3, 1e-14, 2e-3, 2.0, 1.0, "decays"),
        CellRow("s", "mine", "m", 99, "flagged: off by 3 m", 1e-3, 5e-4, 9e-4, 1e-15, 1e-13, 0.0, 0.0, 0.0),
        CellRow("t", "e", "m", None, "skipped: has no floor"),
    ),
    (TimeRow("s", "e", "m", "tumble:rk4", 1.5), TimeRow("s", "mine", "m", "tumble:rk4", None)),
)  # fmt: skip


def records(folder: Path, count: int) -> tuple[int, int]:
    """Fuzz baselines; what is read is held against the undamaged one both ways, and all that is said of it is made."""
    rng = random.Random(3)
    whole = {name: text.encode() for name, text in texts(BASE).items()}
    write_tables(folder, texts(BASE))

    def read() -> None:
        name = rng.choice(list(whole))
        (folder / name).write_bytes(damaged(rng, [whole[name]], list(whole.values())))
        try:
            record = read_record(folder)
        finally:
            (folder / name).write_bytes(whole[name])
        for old, new in ((BASE, record), (record, BASE)):
            outcome = hold_against(old, new, Tolerances())
            assert summary(outcome, ("--baseline", "b")).startswith("## tumble check: ")
            ElementTree.fromstring(junit(outcome, ("--baseline", "b")))
        # What was read is what is written: no cell is taken for something else.
        assert texts(replace(record, command=BASE.command)).keys() == whole.keys()

    return outcomes(read, BadRecord, count)


PARSERS = {"scenes": scenes, "tolerances": tolerances, "records": records}


def main(count: int) -> None:
    """Give each parser so many damaged files and say what became of them."""
    for name, fuzz in PARSERS.items():
        begin = time.monotonic()
        with tempfile.TemporaryDirectory() as folder:
            found, refused = fuzz(Path(folder), count)
        print(f"{name}: {found} read, {refused} refused in one line, {time.monotonic() - begin:.0f} s")


if __name__ == "__main__":
    main(int(sys.argv[1]))
