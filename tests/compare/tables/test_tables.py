"""Tables as others script against them: exact digits, whole files."""

import csv
import io
import os

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from compare.tables.files import write_whole
from compare.tables.rows import csv_text, trajectory_header


@settings(derandomize=True, deadline=None)
@given(st.lists(st.floats(allow_nan=False), min_size=1))
def test_floats_come_back_to_the_bit(values):
    text = csv_text(["value"], ([value] for value in values))
    assert [float(row["value"]) for row in csv.DictReader(io.StringIO(text))] == values


def test_text_with_commas_quotes_and_newlines_comes_back():
    text = 'a,"b"\nc'
    assert next(csv.DictReader(io.StringIO(csv_text(["text"], [[text]]))))["text"] == text


def test_nothing_is_an_empty_cell():
    assert csv_text(["a", "b"], [[None, 0.1]]) == "a,b\n,0.10000000000000001\n"


def test_many_throws_have_a_first_column():
    assert trajectory_header(8, 1)[:2] == ["t_s", "x_m"]
    assert trajectory_header(8, 2)[:2] == ["throw", "t_s"]
    assert trajectory_header(3, 1)[-1] == "v2z_m"


def test_a_file_is_replaced_whole_or_not_at_all(tmp_path, monkeypatch):
    path = tmp_path / "table.csv"
    write_whole(path, "old")
    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", lambda _: (_ for _ in ()).throw(OSError(28, "No space left on device")))
        with pytest.raises(OSError, match="No space left"):
            write_whole(path, "new")
    assert path.read_text() == "old"
    assert os.listdir(tmp_path) == ["table.csv"]
    write_whole(path, "new")
    assert path.read_text() == "new"
    assert path.stat().st_mode & 0o777 == 0o666 & ~current_umask()


def current_umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
