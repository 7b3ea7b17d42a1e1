"""Every column says what it means, and the command, the files and the pages that quote them say the same."""

import csv
import re
from pathlib import Path

import pytest

from tumble.compare.tables.known import tables

ROOT = Path(__file__).parents[2]
COLUMNS = [(table, column) for table in tables().values() for column in table.columns]
# design of the files that others script against
FIXED = {
    "vertex-errors.csv": "scene,engine,method,dt_s,tolerance,t_s,vertex,true_x_m,true_y_m,true_z_m,x_m,y_m,z_m,"
    "error_x_m,error_y_m,error_z_m,error_m",
    "runs.csv": "scene,engine,method,dt_s,tolerance,steps,status,why,max_error_m,rms_error_m,final_error_m,"
    "resolution_m,energy_drift,momentum_drift,angular_momentum_drift,wall_s,wall_ns_per_step,wall_per_sim_s,"
    "dt_taken_s",
}


def test_every_column_has_a_meaning_in_one_line_that_stands_alone():
    wrong = [
        f"{table.file}: {column.name}: {column.meaning!r}"
        for table, column in COLUMNS
        if not re.fullmatch("(?!the same|and its|from this|to this).+", column.meaning)
    ]
    assert wrong == []
    assert [table.file for table, _ in COLUMNS if not table.meaning.endswith(".")] == []


@pytest.mark.parametrize("name", FIXED)
def test_columns_that_are_fixed_stay_what_they_are(name):
    assert ",".join(tables()[name].names) == FIXED[name]


@pytest.mark.parametrize("name", tables())
def test_the_key_of_a_table_is_of_its_columns(name):
    assert set(tables()[name].key) <= set(tables()[name].names)


def test_the_command_lists_every_table_and_describes_one(tumble):
    said = tumble("columns").stdout
    assert set(re.findall(r"^(\S+\.csv) ", said, re.MULTILINE)) == set(tables())
    for words in ("runs", "runs.csv"):
        described = tumble("columns", words).stdout
        assert set(tables()["runs.csv"].names) <= set(re.findall(r"^(\w+) ", described, re.MULTILINE))
        assert "[ns]" in described
        assert max(map(len, described.splitlines())) <= 80


def test_a_table_that_is_none_is_refused_with_the_nearest(tumble):
    done = tumble("columns", "run")
    assert (done.returncode, done.stdout) == (2, "")
    assert "did you mean 'runs.csv'?" in done.stderr


def test_what_a_command_writes_has_the_columns_that_are_described(tumble, tmp_path):
    tumble(
        "compare",
        "die-straight",
        "-e",
        "tumble:adaptive@1e-6",
        "-e",
        "tumble:rk4",
        "-e",
        "scipy",
        "-o",
        "out",
        cwd=tmp_path,
    )
    written = sorted((tmp_path / "out").glob("*.csv"))
    assert len(written) > 5
    for path in written:
        header = path.read_text(encoding="utf-8").splitlines()[0]
        assert header.split(",") == tables()[path.name].names, path.name
    lines = (tmp_path / "out" / "runs.csv").read_text(encoding="utf-8").splitlines()
    adaptive, fixed, usual = csv.DictReader(lines)
    assert (adaptive["dt_s"], adaptive["tolerance"], adaptive["steps"]) == ("", "1e-06", "")
    assert (usual["dt_s"], usual["tolerance"], usual["steps"]) == ("", "1e-09", ""), "its own default is told"
    assert (fixed["dt_s"], fixed["tolerance"]) == ("0.002", "")
    assert int(fixed["steps"]) > 0


@pytest.mark.parametrize("page", ["README.md", "docs/check.md", "docs/grade.md"])
def test_a_table_that_a_page_names_is_there(page):
    named = set(re.findall(r"`([\w-]+\.csv)`", (ROOT / page).read_text(encoding="utf-8")))
    assert {name for name in named if not name.startswith(("mine", "brick"))} <= set(tables())
