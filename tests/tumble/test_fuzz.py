"""No file makes a parser raise, hang or speak in two lines; `python tests/support/fuzz.py 100000` tries harder."""

import os
import resource
import subprocess
import sys
from pathlib import Path

import fuzz
import pytest
from patience import PATIENCE_S

FEW = 600


@pytest.mark.parametrize("parser", fuzz.PARSERS)
def test_any_file_is_read_or_refused_in_one_line(tmp_path, parser):
    outcome = fuzz.PARSERS[parser](tmp_path, range(FEW))
    assert outcome.lost == []
    # Damage that is nearly always fatal, or nearly never, would try little.
    assert outcome.found > FEW / 20
    assert outcome.refused > FEW / 20


def test_a_parser_that_hangs_is_noticed(monkeypatch):
    monkeypatch.setattr(fuzz, "LONGEST_S", 1)
    outcome = fuzz.outcomes(lambda rng: [None for _ in iter(int, 1)], ValueError, "loops", range(1))
    assert outcome == fuzz.Outcome(lost=["loops 0: HangsError: took more than 1 s"])


def test_a_full_disk_leaves_the_old_record_or_none(tmp_path):
    """A file may grow to 2000 bytes only: cells.csv cannot be written, and what it stands beside must not be."""

    def record(*words: str, **settings) -> int:
        command = [sys.executable, "-P", "-m", "tumble", "check", *words, "--no-times", "--accept", "-o", "base"]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE_S, **settings)
        if done.returncode == 2:
            assert len(done.stderr.splitlines()) == 1
        return done.returncode

    full = {"preexec_fn": lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (2000, 2000))}
    folder = tmp_path / "base"
    assert record("table-4-1", "-e", "handcalc", **full) == 2
    assert os.listdir(folder) == []
    assert record("table-4-1", "-e", "handcalc:as-printed") == 0
    before = contents(folder)
    assert record("table-4-1", "-e", "handcalc", **full) == 2
    assert contents(folder) == before


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}
