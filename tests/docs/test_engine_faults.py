"""The commands of the engines' pages show the silent faults that stand beside them, with the real engines."""

import tomllib
from pathlib import Path

import pytest

from tumble.compare.run.engines import registry
from tumble.parser import parser

ROOT = Path(__file__).parents[2]
STATED = tomllib.loads((ROOT / "tools/site/engine-faults.toml").read_text(encoding="utf-8"))
FAULTS = [(engine, fault["show"], fault["verdict"]) for engine, faults in STATED.items() for fault in faults]


def test_they_are_stated_for_engines_that_exist():
    assert set(STATED) <= set(registry.names())
    assert len(FAULTS) > 15


@pytest.mark.parametrize(("engine", "show", "verdict"), FAULTS, ids=[show for _, show, _ in FAULTS])
def test_a_command_shows_its_fault(tumble, engine, show, verdict):
    program, *words = show.split()
    assert program == "tumble"
    assert any(word.partition(":")[0] == engine for word in words)
    parser().parse_args(words)
    done = tumble(*words)
    if f"{engine} is missing" in done.stderr or "missing:" in done.stdout + done.stderr:
        pytest.skip(f"{engine} is not installed here")
    assert done.returncode in (0, 1), done.stderr  # 1: no contestant finished, which is the fault
    assert verdict in " ".join(done.stdout.split())


def test_an_engine_without_the_fault_does_not_show_it(tumble):
    assert "under-rotated" not in tumble("stability", "spin-1e3", "-e", "tumble:rk4").stdout
