"""docs/figures.md: every figure in a table is one that a benchmark wrote, and every benchmark has its table."""

import re
from pathlib import Path

import pytest

from tools import figures

ROOT = Path(__file__).parents[2]
TEXT = figures.PAGE.read_text(encoding="utf-8")


def test_tables_are_those_of_the_recorded_files():
    """The generator makes the page that is there."""
    assert figures.page(TEXT) == TEXT


def test_every_benchmark_has_its_table_and_nothing_else_has_one():
    """No table is written by hand."""
    benchmarks = re.search(r"^BENCH := (.*)$", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    assert benchmarks
    assert sorted(found[2] for found in figures.BLOCK.finditer(TEXT)) == sorted(benchmarks[1].split())
    assert not re.search(r"^\|", figures.BLOCK.sub("", TEXT), re.MULTILINE)


@pytest.mark.parametrize(
    ("cell", "unit", "shown"),
    [("0.23794", "us", "0.238 us"), ("22633.5", "x", "22 600"), ("1448977.1", "x", "1.45e+06"), ("", "s", "")],
)
def test_numbers_have_three_digits_and_their_unit(cell, unit, shown):
    """Three digits say what a noisy figure can."""
    assert figures.with_unit(cell, unit) == shown
