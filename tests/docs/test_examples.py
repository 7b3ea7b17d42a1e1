"""The examples in docstrings give what stands below them."""

import doctest
import importlib
import os
from pathlib import Path

import tumble

HOME = Path(tumble.__file__).parent


def failures(text: str, name: str, names: dict[str, object]) -> str:
    """Return what `doctest` reports of the examples in a text, '' where all hold."""
    report: list[str] = []
    test = doctest.DocTestParser().get_doctest(text, names, name, None, None)
    doctest.DocTestRunner(optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE).run(test, out=report.append)
    return "".join(report)


def test_the_examples_of_every_module_hold():
    """Of every file with examples each docstring, with the names of its module."""
    wrong = []
    files = (Path(folder, name) for folder, _, names in os.walk(HOME, followlinks=True) for name in names)
    for path in sorted(path for path in files if path.suffix == ".py"):
        if ">>> " not in path.read_text(encoding="utf-8") or "starters" in path.parts:
            continue
        name = ".".join(("tumble", *path.relative_to(HOME).with_suffix("").parts)).removesuffix(".__init__")
        for each in doctest.DocTestFinder(exclude_empty=True).find(importlib.import_module(name)):
            wrong.append(failures(each.docstring or "", each.name, dict(each.globs)))
    assert "".join(wrong) == ""


def test_an_example_that_is_wrong_is_found():
    assert "Expected:" in failures(">>> 1 + 1\n3\n", "wrong", {})
    assert failures(">>> 1 + 1\n2\n", "right", {}) == ""
