"""docs/mistakes.md lists the stable names of mistakes: all that there are, with their parameters and units."""

import ast
from dataclasses import replace
from pathlib import Path

from tools import mistakes_page
from tumble.compare.grade.hypotheses import mistakes

ROOT = Path(__file__).parents[3]
PAGE = (ROOT / "docs/mistakes.md").read_text(encoding="utf-8")


def test_the_page_is_what_its_maker_makes():
    assert mistakes_page.page() == PAGE, "run: python -m tools.mistakes_page"


def test_a_new_mistake_is_missed_on_the_page(monkeypatch):
    def more(context):
        yield from mistakes.output_transforms(context)
        yield replace(next(iter(mistakes.output_transforms(context))), name="tea time")

    monkeypatch.setattr(mistakes, "PARTS", (*mistakes.PARTS[:-1], more))
    assert "| `tea-time` |" in mistakes_page.page()
    assert "tea-time" not in PAGE


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
