"""Tables as DataFrames: what is written comes back, to the bit, and what is no such table is refused in one line."""

import csv
import io
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tumble.compare.tables.cells import float_cells, text_cell, text_of_cell
from tumble.compare.tables.frames import csv_text, frame, read_tables, read_text, typed
from tumble.compare.tables.known import tables
from tumble.compare.tables.schema import BadTable
from tumble.compare.tables.shared import RUNS, RunRow

RUN = RunRow(
    scene="s",
    engine="e",
    method="m",
    dt_s=0.1,
    tolerance=None,
    steps=10,
    status="ok",
    why="",
    max_error_m=1e-5,
    resolution_m=-0.0,
)
ABSENT = RunRow(
    scene="s", engine="gone", method="", dt_s=math.nan, tolerance=1e-9, steps=None, status="missing", why="no wheel"
)


@settings(derandomize=True, deadline=None)
@given(st.lists(st.floats(allow_nan=False) | st.floats(1e-10, 1e-3) | st.floats(1e14, 1e18), min_size=1))
def test_floats_are_the_shortest_digits_that_come_back(values):
    assert float_cells(np.array(values)) == list(map(repr, values))


def test_a_float_that_is_not_there_is_an_empty_cell():
    assert float_cells(np.array([math.nan, math.inf, 1e16])) == ["", "inf", "1e+16"]
    assert float_cells(np.array([])) == []


@settings(derandomize=True, deadline=None)
@given(st.text(st.characters(exclude_categories=("Cs",), exclude_characters="\x00"), min_size=1))
def test_a_text_comes_back_but_for_what_a_terminal_obeys(text):
    (written,) = next(csv.reader(io.StringIO(text_cell(text), newline="")))
    assert text_of_cell(written) == "".join(repr(c)[1:-1] if c in CONTROLS else c for c in text)


CONTROLS = {chr(code) for code in (*range(32), *range(127, 160), *range(0x202A, 0x202F), *range(0x2066, 0x206A))} - set(
    "\t\n\r"
)


def test_no_escape_sequence_reaches_a_terminal():
    assert text_cell("\x1b[31mred\x9b0m\x07") == "\\x1b[31mred\\x9b0m\\x07"


def test_rows_come_back_with_their_dtypes():
    made = frame(RUNS, [RUN, ABSENT])
    text = csv_text(made)
    assert text.splitlines()[1:] == [
        "s,e,m,0.1,,10,ok,,1e-05,,,-0.0,,,,,,,",
        "s,gone,,,1e-09,,missing,no wheel,,,,,,,,,,,",
    ]
    read = read_tables({"runs.csv": text, "sweep-runs.csv": text, "notes.txt": "none of ours"})
    assert list(read) == ["runs.csv", "sweep-runs.csv"]
    for again in read.values():
        assert again.equals(made)
        assert again.dtypes.equals(made.dtypes)
        assert math.copysign(1, again.resolution_m[0]) == -1


@pytest.mark.parametrize("table", tables().values(), ids=lambda table: table.file)
def test_an_empty_table_keeps_its_columns_and_dtypes(table):
    empty = typed(table, {})
    read = read_text(table.file, csv_text(empty), table)
    assert read.dtypes.equals(empty.dtypes)
    assert list(read.columns) == table.names


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("scene,engine", "scene,machine", "columns"),
        (",10,", ",10.5,", "line 2: steps = '10.5': must be a whole number"),
        (",0.1,", ",one,", "line 2: dt_s = 'one': must be a number"),
        (",1e-05,", ",small,", "line 2: max_error_m = 'small': must be a number"),
        ("\ns,gone", "\n\ns,gone", "line 3: 0 cells: must be 19"),
        ("s,e,m", "s,e", "line 2: 18 cells: must be 19"),
        ("s,e,m", '"s,e,m', "not CSV"),
    ],
)
def test_what_is_no_such_table_is_refused_in_one_line(old, new, said):
    text = csv_text(frame(RUNS, [RUN, ABSENT]))
    assert text.count(old)
    with pytest.raises(BadTable, match=said) as refused:
        read_text("runs.csv", text.replace(old, new, 1), RUNS)
    assert "\n" not in str(refused.value)
