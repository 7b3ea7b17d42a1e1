"""Folders of tables that something has damaged: read as they are, or refused in one line; never half of them."""

import os
import random
import shutil
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout
from functools import partial
from io import StringIO
from pathlib import Path

import kills

from tumble.__main__ import main as tumble

RECORD, TABLES = kills.COMMANDS[1], kills.COMMANDS[0]


def in_place_of(make: Callable[[Path], object]) -> Callable[[Path], object]:
    """Return what puts something else in a file's place."""

    def put(path: Path) -> None:
        path.unlink()
        make(path)

    return put


def lines(change: Callable[[list[str]], list[str]]) -> Callable[[Path], object]:
    """Return what changes a file's lines."""
    return lambda path: path.write_text("".join(change(path.read_text().splitlines(keepends=True))))


def bytes_of(change: Callable[[bytes], bytes]) -> Callable[[Path], object]:
    """Return what changes a file's bytes."""
    return lambda path: path.write_bytes(change(path.read_bytes()))


DAMAGE: dict[str, Callable[[Path], object]] = {
    "not there": lambda path: path.unlink(),
    "empty": bytes_of(lambda data: b""),
    "a header only": lines(lambda all_lines: all_lines[:1]),
    "no header": lines(lambda all_lines: all_lines[1:]),
    "half of it": bytes_of(lambda data: data[: len(data) // 2]),
    "a byte less": bytes_of(lambda data: data[:-2]),
    "twice": bytes_of(lambda data: data * 2),
    "its last row twice": lines(lambda all_lines: [*all_lines, all_lines[-1]]),
    "its columns the other way round": lines(
        lambda all_lines: [",".join(line.rstrip("\n").split(",")[::-1]) + "\n" for line in all_lines]
    ),
    "a column less": lines(lambda all_lines: [line.partition(",")[2] for line in all_lines]),
    "semicolons": bytes_of(lambda data: data.replace(b",", b";")),
    "zeros": bytes_of(lambda data: bytes(len(data))),
    "noise": bytes_of(lambda data: random.Random(1).randbytes(len(data))),
    "UTF-16": bytes_of(lambda data: data.decode().encode("utf-16")),
    "every number NaN": lines(
        lambda all_lines: [
            all_lines[0],
            *("".join(c if not c.isdigit() else "" for c in line) for line in all_lines[1:]),
        ]
    ),
    "a cell of a megabyte": bytes_of(lambda data: data + b"x" * (1 << 20)),
    "a quote that never ends": bytes_of(lambda data: data.replace(b"\n", b'\n"', 1)),
    "a folder": in_place_of(lambda path: path.mkdir()),
    "a pipe": in_place_of(lambda path: os.mkfifo(path)),
    "a link to itself": in_place_of(lambda path: path.symlink_to(path.name)),
    "a link to nothing": in_place_of(lambda path: path.symlink_to("/nonexistent")),
    "a device": in_place_of(lambda path: path.symlink_to("/dev/zero")),
}


def attack(folder: Path, name: str, share: int = 1) -> None:
    """Damage files of a record, and of a folder of tables, one at a time, and read it.  Raises AssertionError.

    share: of so many files one, another with each damage.
    """
    first = [*DAMAGE].index(name)
    for words, reading in (
        (RECORD, ("check", "die-straight", "--baseline", "{}", "--no-times", "-e", "tumble:rk4", "-e", kills.MINE)),
        (TABLES, ("report", "--from", "{}", "-o", "{}.html")),
    ):
        whole, _ = kills.whole(words)
        for file in sorted(whole.glob("*.csv"))[first % share :: share]:
            own = folder / f"{name} {words[0]} {file.stem}".replace(" ", "-")
            shutil.copytree(whole, own)
            DAMAGE[name](own / file.name)
            told = StringIO()
            with (folder / "said").open("w") as said, redirect_stdout(said), redirect_stderr(told):
                code = tumble([word.format(own) for word in reading])
            what = f"{file.name} {name}: code {code}: {told.getvalue()[-300:]}"
            assert code in (0, 1, 2), what
            assert "Traceback" not in told.getvalue(), what
            if code == 2:
                assert len(told.getvalue().splitlines()) == 1, what
                assert not Path(f"{own}.html").exists(), what


def all_attacks() -> dict[str, Callable[[Path], None]]:
    """Return every attack by its name."""
    return {name: partial(attack, name=name) for name in DAMAGE}
