"""tests/slow.txt lists tests that exist: one that is renamed keeps its place in the list."""

import ast
from functools import cache
from pathlib import Path

import pytest
from tiers import ROOT, slow_tests


@cache
def functions(file: Path) -> set[str]:
    """Return a file's functions and methods, a method as CLASS::NAME."""
    found = set()
    for node in ast.parse(file.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.ClassDef):
            found |= {f"{node.name}::{each.name}" for each in node.body if isinstance(each, ast.FunctionDef)}
        elif isinstance(node, ast.FunctionDef):
            found.add(node.name)
    return found


@pytest.mark.parametrize("place", sorted({name.partition("::")[0] for name in slow_tests()}))
def test_every_name_is_a_test(place):
    names = {name.partition("::")[2] for name in slow_tests() if name.startswith(f"{place}::")}
    assert names - functions(ROOT / place) == set()
