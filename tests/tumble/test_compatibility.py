"""docs/compatibility.md lists what format 3 renamed: every new name exists, and no old one does."""

import csv
import re
from pathlib import Path

import pytest

from tumble.compare.check.record import FORMAT as BASELINE_FORMAT
from tumble.compare.run.provenance import FORMAT
from tumble.compare.tables.known import tables

PAGES = Path(__file__).parents[2] / "docs"
PAGE = (PAGES / "compatibility.md").read_text(encoding="utf-8")


def rows(heading: str) -> list[tuple[str, str, str]]:
    """Old name, new name and the third cell of a section's table."""
    section = PAGE.partition(f"### {heading}\n")[2].partition("\n#")[0]
    return re.findall(r"^\| `([\w.-]+)` \| `([\w.-]+)` \| (.*) \|$", section, re.MULTILINE)


FILES = {old: new for old, new, _ in rows("Tables")}
COLUMNS = [(old, new, re.findall(r"`([\w-]+\.csv)`", where)) for old, new, where in rows("Columns")]


def test_the_page_names_the_formats_that_are_written():
    number = re.findall(r"^## Format (\d+)$", PAGE, re.MULTILINE)
    assert [FORMAT.split()[-1], BASELINE_FORMAT.split()[-1]] == 2 * [max(number)]


@pytest.mark.parametrize("old", FILES)
def test_a_table_has_its_new_name(old):
    assert FILES[old] in tables()
    assert old not in tables()


@pytest.mark.parametrize(("old", "new", "where"), COLUMNS)
def test_a_column_has_its_new_name_in_every_table_that_is_named(old, new, where):
    having = {name for name, table in tables().items() if new in table.names}
    assert having
    assert set(where) <= having
    assert [name for name, table in tables().items() if old in table.names] == []


@pytest.mark.parametrize("folder", sorted((PAGES / "releases").iterdir()), ids=lambda folder: folder.name)
def test_the_published_tables_have_the_current_format(folder):
    assert f"format,{FORMAT}\n" in (folder / "conditions.csv").read_text(encoding="utf-8")
    for path in folder.glob("*.csv"):
        with path.open(encoding="utf-8", newline="") as file:
            assert next(csv.reader(file)) == list(tables()[path.name].names), path.name
