"""Tables as others script against them: exact digits, whole files."""

import os

import pytest

from tumble.compare.tables.files import write_whole
from tumble.compare.tables.trajectory import trajectory_header


def test_many_throws_have_a_first_column():
    assert trajectory_header(8, 1)[:2] == ["t_s", "x_m"]
    assert trajectory_header(8, 2)[:2] == ["member", "t_s"]
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
