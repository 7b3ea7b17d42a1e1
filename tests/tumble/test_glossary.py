"""docs/glossary.md is in order, and the tables and columns that it names exist."""

import re
from pathlib import Path

import pytest

from tumble.compare.tables.known import tables

PAGE = (Path(__file__).parents[2] / "docs/glossary.md").read_text(encoding="utf-8")
ROWS = re.findall(r"^\| \*\*(.+?)\*\* \| (.+?) \| (.*?) ?\| (.+?) \|$", PAGE, re.MULTILINE)


def test_terms_are_in_alphabetical_order():
    terms = [term for term, *_ in ROWS]
    assert len(terms) == 26
    assert terms == sorted(terms, key=str.lower)


@pytest.mark.parametrize(("term", "where"), [(term, where) for term, _, _, where in ROWS])
def test_the_columns_named_exist(term, where):
    for columns, name in re.findall(r"((?:`\w+`(?:, )?)+) in `([\w-]+\.csv)`", where):
        assert set(re.findall(r"\w+", columns)) <= set(tables()[name].names), term
    named = set(re.findall(r"`(\w+_m|status|why|engine|method)`", where))
    assert named <= {column for table in tables().values() for column in table.names}
