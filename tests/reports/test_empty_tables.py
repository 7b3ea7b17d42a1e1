"""A table without rows has no file, neither after this run nor left by an earlier one."""

import json

import pandas as pd
import pytest
from conftest import data_in

from tumble.compare.releases.schemas import CHANGES, RELEASES
from tumble.compare.stability.schemas import EXTREMES, LIMITS
from tumble.compare.stability.schemas import TABLES as STABILITY
from tumble.compare.tables.data_package import FILE
from tumble.compare.tables.frames import frame, kept_tables, read_tables, write_tables
from tumble.compare.tables.known import tables
from tumble.reports.folders import gathered
from tumble.reports.page import page


def files(folder) -> set[str]:
    return {path.name for path in folder.iterdir()}


def with_a_row(name: str) -> pd.DataFrame:
    table = tables()[name]
    words = {str: "x", int: 1, float: 1.0, bool: True}
    return pd.DataFrame({column.name: [words[column.kind]] for column in table.columns})


def test_one_contestant_has_no_agreement_and_removes_that_of_two(tmp_path, tumble):
    words = ("compare", "die-vertex", "-e", "mujoco:euler", "-o", "out", "--parquet")
    assert tumble(*words, "-e", "pybullet:multibody").returncode == 0
    two = files(tmp_path / "out")
    assert {"agreement.csv", "agreement.parquet"} <= two
    assert "members.csv" not in two
    assert tumble(*words).returncode == 0
    one = files(tmp_path / "out")
    assert two - one == {"agreement.csv", "agreement.parquet"}
    described = {each["path"] for each in json.loads((tmp_path / "out" / FILE).read_text())["resources"]}
    assert described == {name for name in one if name.endswith(".csv")}
    assert all(len(table) for table in read_tables(tmp_path / "out").values())
    drawn = tumble("report", "--from", "out", "-o", "page.html")
    assert drawn.returncode == 0, drawn.stderr
    shown = data_in((tmp_path / "page.html").read_text(encoding="utf-8"))["tables"]
    assert "runs.csv" in shown
    assert "agreement.csv" not in shown


def test_the_tables_of_another_scene_are_removed(tmp_path, tumble):
    """Table 4.1 is of one scene; a run of another has no distance from it."""
    words = ("-e", "tumble:rk4", "-o", "out")
    assert tumble("compare", "table-4-1", *words).returncode == 0
    assert "table-4-1.csv" in files(tmp_path / "out")
    assert tumble("compare", "die-straight", *words).returncode == 0
    assert "table-4-1.csv" not in files(tmp_path / "out")


def test_files_that_are_no_tables_of_the_run_stay(tmp_path):
    write_tables(tmp_path, {"runs.csv": with_a_row("runs.csv"), "members.csv": with_a_row("members.csv")})
    (tmp_path / "mine.csv").write_text("a\n")
    write_tables(tmp_path, {"members.csv": with_a_row("members.csv").iloc[:0]}, {"notes.md": "fine\n"})
    assert files(tmp_path) == {"runs.csv", "mine.csv", "notes.md", FILE}


@pytest.mark.parametrize("left", [LIMITS.file, EXTREMES.file])
def test_a_table_that_is_not_there_is_empty_beside_one_that_is(tmp_path, left):
    write_tables(tmp_path, {left: with_a_row(left)})
    found = kept_tables(tmp_path, STABILITY)
    assert {name: len(table) for name, table in found.items()} == {
        table.file: int(table.file == left) for table in STABILITY
    }


def test_releases_that_all_behave_alike_are_drawn(tmp_path):
    write_tables(tmp_path, {RELEASES.file: with_a_row(RELEASES.file), CHANGES.file: frame(CHANGES, [])})
    assert CHANGES.file not in files(tmp_path)
    assert "release-changes.csv" not in data_in(page(gathered(tmp_path)))["tables"]


def test_a_folder_of_extreme_cases_alone_is_drawn(tmp_path, real):
    write_tables(tmp_path, {EXTREMES.file: real[EXTREMES.file], LIMITS.file: frame(LIMITS, [])})
    assert EXTREMES.file in data_in(page(gathered(tmp_path)))["tables"]


def test_a_sweep_in_which_no_tolerance_was_reached_is_one_all_the_same(tmp_path, real):
    swept = {name.removeprefix("sweep-"): table for name, table in real.items() if name.startswith("sweep-")}
    write_tables(tmp_path, swept | {"accuracy-cost.csv": swept["accuracy-cost.csv"].iloc[:0]})
    found = gathered(tmp_path)
    assert "sweep-runs.csv" in found
    assert "runs.csv" not in found
    assert "sweep-runs.csv" in data_in(page(found))["tables"]
