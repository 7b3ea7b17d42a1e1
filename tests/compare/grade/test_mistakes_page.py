"""docs/mistakes.md lists the names of all mistakes, with their parameters and units, and the names in format 2."""

import ast
import re
from dataclasses import replace
from pathlib import Path

from tools import mistakes_page
from tumble.compare.grade.hypotheses import mistakes
from tumble.compare.grade.hypotheses.names import RENAMED_MISTAKES, RENAMED_PARAMETERS

ROOT = Path(__file__).parents[3]
PAGE = (ROOT / "docs/mistakes.md").read_text(encoding="utf-8")


def test_the_page_is_what_its_maker_makes():
    assert mistakes_page.page() == PAGE, "run: python -m tools.mistakes_page"


def test_a_new_mistake_is_missed_on_the_page(monkeypatch):
    def more(context):
        yield from mistakes.output(context)
        yield replace(next(iter(mistakes.output(context))), name="tea-time")

    monkeypatch.setattr(mistakes, "PARTS", (*mistakes.PARTS[:-1], more))
    assert "| `tea-time` |" in mistakes_page.page()
    assert "tea-time" not in PAGE


def test_names_of_format_2_are_gone_and_their_new_names_are_there():
    current, _, old = PAGE.partition("\n## Names in format 2")
    for before, after in (RENAMED_MISTAKES | RENAMED_PARAMETERS).items():
        assert f"| `{before}` | `{after}` |" in old
        assert f"`{after}`" in current
        assert f"`{before}`" not in current


def test_names_are_lower_case_words_joined_by_hyphens():
    names = re.findall(r"^\| `(.*?)`", PAGE.partition("\n## ")[0], re.MULTILINE)
    assert len(names) > 100
    assert [name for name in names if not re.fullmatch(r"[a-z0-9]+(-[a-z0-9]+)*", name)] == []


def test_the_maker_asks_for_every_name_in_the_code():
    """A name that no scene of the maker leaves room for would be listed nowhere: names are read from the source too."""
    literal = set()
    for file in (ROOT / "compare/grade").rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            named = isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "Hypothesis"
            if named and node.args and isinstance(node.args[0], ast.Constant):
                literal.add(node.args[0].value)
    assert len(literal) > 30
    assert literal <= {hypothesis.name for hypothesis in mistakes_page.tried()}
