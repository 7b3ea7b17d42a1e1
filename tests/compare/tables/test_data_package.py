"""datapackage.json and the Parquet copies of what a command wrote, as programs that do not know Tumble read them."""

import json
import shutil

import pandas as pd
import pyarrow.parquet
import pytest
from frictionless import Package

from tumble.compare.tables import parquet
from tumble.compare.tables.data_package import FILE, data_package
from tumble.compare.tables.files import write_folder
from tumble.compare.tables.frames import read_file, read_tables
from tumble.compare.tables.known import tables
from tumble.compare.tables.schema import BadTable

ENGINES = ("-e", "tumble:rk4", "-e", "scipy", "-e", "handcalc:as-printed", "-e", "pybullet:multibody")


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """A folder of real tables, with engines that fail among them, and their Parquet copies."""
    from tumble.__main__ import main

    folder = tmp_path_factory.mktemp("written") / "out"
    words = ("-q", "compare", "die-straight", "tether-critical", *ENGINES, "--parquet", "-o", str(folder))
    assert main([words[1], words[0], *words[2:]]) == 0
    return folder


@pytest.fixture
def folder(written, tmp_path):
    return shutil.copytree(written, tmp_path / "out")


def problems(folder) -> set[str]:
    report = Package(str(folder / FILE)).validate()
    return {error.type for task in report.tasks for error in task.errors} | {error.type for error in report.errors}


def test_a_package_is_valid_and_has_every_table(folder):
    assert problems(folder) == set()
    package = json.loads((folder / FILE).read_text())
    assert {each["path"] for each in package["resources"]} == {path.name for path in folder.glob("*.csv")}
    assert len(package["resources"]) > 5


@pytest.mark.parametrize(
    ("damage", "problem"),
    [
        (lambda lines: [*lines, lines[-1]], "primary-key"),
        (lambda lines: [lines[0], *(line.replace(",ok,", ",ok,extra,") for line in lines[1:])], "extra-cell"),
        (lambda lines: [lines[0].replace("dt_s", "step_s"), *lines[1:]], "incorrect-label"),
    ],
)
def test_damage_is_found_by_it(folder, damage, problem):
    file = folder / "runs.csv"
    file.write_text("\n".join(damage(file.read_text().splitlines())) + "\n")
    assert problem in problems(folder)


def test_every_column_of_every_table_is_described():
    for resource in data_package(tables())["resources"]:
        stated = tables()[resource["path"]]
        assert resource["description"] == stated.meaning
        for field, column in zip(resource["schema"]["fields"], stated.columns, strict=True):
            assert (field["name"], field["description"]) == (column.name, column.meaning)
            assert field.get("unit", "") == column.unit
        assert set(resource["schema"].get("primaryKey", ())) <= set(stated.names)
    assert len(tables()) > 25


def test_tables_of_another_command_are_described_and_those_of_another_format_are_not(folder):
    (folder / "limits.csv").write_text(",".join(tables()["limits.csv"].names) + "\n")
    (folder / "orders.csv").write_text("scene,engine,method,slope\n")
    (folder / "mine.csv").write_text("a,b\n")
    write_folder(folder, {"findings.csv": (folder / "findings.csv").read_text()}, without=("members.csv",))
    paths = {each["path"] for each in json.loads((folder / FILE).read_text())["resources"]}
    assert {"limits.csv", "findings.csv", "runs.csv"} <= paths
    assert not {"orders.csv", "mine.csv", "members.csv"} & paths


def test_a_folder_without_tables_gets_none(tmp_path):
    write_folder(tmp_path, {"summary.md": "fine\n"})
    assert [path.name for path in tmp_path.iterdir()] == ["summary.md"]


def test_a_folder_is_read_back_as_without_it(folder):
    before = read_tables(folder)
    for path in (folder / FILE, *folder.glob("*.parquet")):
        path.unlink()
    assert read_tables(folder).keys() == before.keys()


def test_parquet_has_the_rows_the_types_and_the_units_of_the_csv(folder):
    files = sorted(folder.glob("*.parquet"))
    assert {path.stem for path in files} == {path.stem for path in folder.glob("*.csv")}
    for path in files:
        stated = tables()[f"{path.stem}.csv"]
        expected = read_file(path.with_suffix(".csv"), stated)
        found = pd.read_parquet(path)
        assert found.dtypes.map(str).equals(expected.dtypes.map(str)), path.name
        pd.testing.assert_frame_equal(found, expected, check_dtype=False)
        for column in stated.columns:
            metadata = pyarrow.parquet.read_schema(path).field(column.name).metadata
            assert metadata[b"description"].decode() == column.meaning
            assert metadata.get(b"unit", b"").decode() == column.unit


def test_without_pyarrow_or_a_folder_it_is_refused_in_a_line(tumble, monkeypatch):
    done = tumble("compare", "die-straight", "-e", "tumble:rk4", "--parquet")
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    monkeypatch.setattr(parquet, "find_spec", lambda name: None)
    with pytest.raises(BadTable, match="pip install"):
        parquet.check_parquet("out")
