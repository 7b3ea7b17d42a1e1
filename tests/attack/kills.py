"""Kills at random moments: nothing is left running, what was there is old or new as a whole, and it runs again."""

import csv
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import uuid
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path

from left_running import carrying, gone
from patience import PATIENCE_S

from tumble.compare.tables.files import settle

MINE = str(Path(__file__).parents[1] / "plugins" / "mine.py")
ENGINES = ("-e", "tumble:rk4", "-e", "mujoco:euler", "-e", MINE)
COMMANDS = (
    ("compare", "die-straight", "table-4-1", *ENGINES, "-o", "out"),
    ("check", "die-straight", *ENGINES, "--no-times", "--accept", "-o", "out"),
    ("run", "two-hits", "-e", "mujoco:rk4", "-o", "out/flight.csv"),
    ("compare", "two-hits", *ENGINES, "-o", "out"),
)
SIGNALS = (signal.SIGKILL, signal.SIGKILL, signal.SIGTERM, signal.SIGHUP, signal.SIGINT)
STARTED = str(Path(__file__).parents[2] / "tumble" / "")
# What a command takes on a quiet machine at most; a kill comes earlier, or finds it done [s].
LONGEST_S = 5.0


def start(words: tuple[str, ...], folder: Path, mark: str = "") -> subprocess.Popen[str]:
    """Start a command in a folder."""
    folder.mkdir(exist_ok=True)
    (folder / "out").mkdir(exist_ok=True)
    return subprocess.Popen(
        [sys.executable, "-P", "-m", "tumble", *words],
        cwd=folder,
        env=os.environ | dict([mark.split("=")] if mark else []),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )


def tables(folder: Path) -> dict[str, int]:
    """Return the tables in a folder, each with the number of its rows.  Raises AssertionError for one cut short."""
    settle(folder)
    found = {}
    for path in sorted(folder.glob("*.csv")):
        text = path.read_text(encoding="utf-8")
        assert text.endswith("\n"), f"{path.name} is cut short"
        rows = list(csv.reader(text.splitlines()))
        assert len({len(row) for row in rows}) == 1, f"{path.name} has a row of another length"
        found[path.name] = len(rows)
    return found


@cache
def whole(words: tuple[str, ...]) -> tuple[Path, dict[str, int]]:
    """Return a folder as the command leaves it, and its tables."""
    folder = Path(tempfile.mkdtemp(prefix="tumble-whole-"))
    done = start(words, folder)
    _, said = done.communicate(timeout=PATIENCE_S)
    assert done.returncode == 0, said
    return folder / "out", tables(folder / "out")


def attack(folder: Path, seed: int) -> str:
    """Kill one command at one moment and run it again; return in words what was killed, and how.

    Raises AssertionError where something is left running, half a result is taken for one, or it cannot be run again.
    """
    rng = random.Random(seed)
    words, how, moment = rng.choice(COMMANDS), rng.choice(SIGNALS), rng.uniform(0, LONGEST_S)
    before, expected = whole(words)
    own, mark, had_one = folder / f"kill-{seed}", f"TUMBLE_TEST={uuid.uuid4()}", rng.random() < 0.5
    own.mkdir(parents=True)
    if had_one:
        shutil.copytree(before, own / "out")
    command = start(words, own, mark)
    try:
        _, said = command.communicate(timeout=moment)
        ended = "it was done"
    except subprocess.TimeoutExpired:
        command.send_signal(how)
        _, said = command.communicate(timeout=PATIENCE_S)
        ended = f"{how.name} after {moment:.2f} s"
        # An interrupt amid a text that is compiled has Python end itself by SIGINT, which shells call 130 as well.
        # Python's own start, before the first line of ours, tells of an interrupt as it will, and ends with 1 or 0.
        if STARTED in said or "KeyboardInterrupt" not in said:
            assert command.returncode in (0, -how, 130, -signal.SIGINT), f"{ended}: code {command.returncode}: {said}"
            assert "Traceback" not in said, f"{ended}: {said}"
    gone(partial(carrying, mark))
    found = tables(own / "out")
    assert found in (({}, expected), (expected,))[had_one], f"{ended}: {found}, not {expected}"
    again = start(words, own)
    _, said = again.communicate(timeout=PATIENCE_S)
    assert again.returncode == 0, f"again after {ended}: {said}"
    assert tables(own / "out") == expected, f"again after {ended}"
    drafts = [path.name for path in (own / "out").iterdir() if path.name not in expected and path.name.startswith(".")]
    assert not drafts, f"left over after {ended}: {drafts}"
    return f"{words[0]}: {ended}"


def all_attacks() -> dict[str, Callable[[Path], str]]:
    """Return more attacks than anybody asks for, by their seeds."""
    return {str(seed): partial(attack, seed=seed) for seed in range(1000)}
