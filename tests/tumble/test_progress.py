"""No command is silent for long: a bar in a terminal, else lines to standard error, and neither with --quiet."""

import os
import pty
import re
import subprocess
import sys
import time

import pytest

from tumble import notes
from tumble.__main__ import main
from tumble.notes import progress

SCENE = """
title = "Short"
duration = 0.02
times = [0.02]
step = 0.01
[body]
shape = "box"
size = [0.4, 0.15, 0.1]
mass = 2.4
angular_velocity = [0.5, -0.3, 0.4]
[[tether]]
vertex = 0
anchor = [0.0, 1.0, 0.0]
stiffness = 80.0
"""
COMMANDS = {
    "run": (),
    "compare": (),
    "sweep": (),
    "advise": ("--tolerance", "0.1"),
    "ablate": (),
    "check": ("--no-times", "--accept", "-o", "base"),
    "stability": (),
    "report": ("-o", "page.html"),
}


@pytest.fixture
def said(monkeypatch, tmp_path) -> list[str]:
    """The lines of progress, one every 10 ms: everything here takes longer, the more so on a busy machine."""
    lines: list[str] = []
    written = notes.note

    def note(line: str) -> None:
        if re.match(r"\d+ s: ", line):
            lines.append(line)
        written(line)

    monkeypatch.setattr(notes, "note", note)
    monkeypatch.setattr(notes, "PERIOD_S", 0.01)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "short.toml").write_text(SCENE)
    return lines


@pytest.mark.parametrize("command", COMMANDS)
def test_a_pipe_gets_lines_while_a_command_works(command, said):
    assert main([command, "short.toml", "-e", "tumble:rk4", *COMMANDS[command]]) == 0
    assert any(": starting engines" in line for line in said)
    assert any(": running" in line for line in said)


def test_quiet_stops_the_lines(said, tmp_path):
    words = ("short.toml", "-e", "tumble:rk4", "-e", "mujoco")
    assert main(["compare", "--quiet", *words]) == 0
    assert said == []
    assert main(["compare", *words]) == 0
    assert said


def test_a_line_says_how_far_and_what_was_last(said):
    with progress(3, "measuring") as on_progress:
        on_progress("one")
        on_progress("two", 0.5)
        on_progress("two", 0.5)
        wait_for(lambda: any("2 of 3 done; last: two" in line for line in said))
    assert all(re.fullmatch(r"0 s: measuring, \d of 3 done(; last: (one|two))?|[1-9]\d* s: .*", line) for line in said)
    count = len(said)
    time.sleep(0.1)
    assert len(said) == count, "nothing is written after the end"


def wait_for(holds) -> None:
    end = time.monotonic() + 60.0
    while not holds():
        assert time.monotonic() < end, "it never came"
        time.sleep(0.01)


def seen_in_a_terminal(tmp_path, *words: str) -> str:
    """Return what a command writes to standard error where that is a terminal."""
    ours, theirs = pty.openpty()
    command = [sys.executable, "-P", "-m", "tumble", *words]
    with subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=theirs) as started:
        os.close(theirs)
        seen = b""
        while chunk := read(ours):
            seen += chunk
    os.close(ours)
    assert started.returncode == 0, seen
    return seen.decode()


def read(terminal: int) -> bytes:
    try:
        return os.read(terminal, 4096)
    except OSError:  # nobody holds its other end any more
        return b""


def test_a_terminal_gets_a_bar_that_is_gone_at_the_end(tmp_path):
    words = ("compare", "two-hits", "-e", "tumble:rk4", "-e", "mujoco")
    seen = seen_in_a_terminal(tmp_path, *words)
    assert "━" in seen
    assert "starting engines" in seen
    assert "/7" in seen, "six contestants and the truth"
    assert seen_in_a_terminal(tmp_path, *words, "--quiet") == ""


def test_the_time_that_is_left_is_that_of_the_pieces_that_are_left(monkeypatch):
    now = 0.0
    monkeypatch.setattr(notes, "monotonic", lambda: now)
    meter = notes.Meter("running", 40)
    for piece in range(10):
        meter(f"piece {piece}")
        now += 2.0
        assert (" left" in meter.line) == (piece + 1 >= notes.FEW)
    assert meter.line == "20 s: running, 10 of 40 done, about 60 s left; last: piece 9"
    assert "left" not in notes.Meter("running", 0).line
