"""Who takes part, by which name: two engine files of one name are told apart in every table."""

import csv
import os
from pathlib import Path

import pytest

from compare.run.participants import launched, titles
from compare.run.registry import BadEngine
from scenarios.read import read_scene
from tumble.__main__ import main

ENGINE = """
METHODS = ("drift",)
FEATURES = {{"gravity"}}
ABOUT = {{"version": "{version}", "precision": "double", "switched_off": []}}
def build(scene, method): return {{}}
def write(world, states): world["states"] = states.copy()
def advance(world, n, dt): world["states"][:, 0:3] += {speed} * n * dt * world["states"][:, 7:10]
def read(world): return world["states"]
"""


@pytest.mark.parametrize(
    ("files", "expected"),
    [
        (("a/mine.py", "b/mine.py"), ("a/mine", "b/mine")),
        (("a/mine.py", "b/other.py"), ("mine", "other")),
        (("x/a/mine.py", "y/a/mine.py", "y/b/mine.py"), ("x/a/mine", "y/a/mine", "y/b/mine")),
        (("/w/mine.py", "/w/old/mine.py"), ("w/mine", "old/mine")),
        (("a/mujoco.py", "mujoco", "b/mujoco.py"), ("a/mujoco.py", "mujoco", "b/mujoco.py")),
    ],
)
def test_files_of_one_name_get_as_much_of_their_path_as_tells_them_apart(files, expected):
    assert tuple(titles(files).values()) == expected


def test_one_file_by_two_paths_is_refused(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("mine.py").write_text(ENGINE.format(version=1, speed=1.0))
    with (
        pytest.raises(BadEngine, match=r"mine.py and .*/mine.py are one file: name it once"),
        launched(["mine.py", os.path.abspath("mine.py")]),
    ):
        pass
    with launched(["mine.py"], beside=["./mine.py"]) as (one,):
        assert one.title == "mine"


def test_both_are_in_the_tables_each_with_its_own_flight(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for folder, version, speed in (("old", 1, 1.0), ("new", 2, 3.0)):
        Path(folder).mkdir()
        Path(folder, "mine.py").write_text(ENGINE.format(version=version, speed=speed))
    asked = ("-e", "old/mine.py", "-e", "new/mine.py")
    assert main(["compare", "table-4-1", *asked, "-o", "out"]) == 0
    printed = capsys.readouterr().out
    with open("out/runs.csv", newline="") as file:
        errors = {row["engine"]: float(row["max_error_m"]) for row in csv.DictReader(file)}
    assert set(errors) == {"old/mine", "new/mine"}
    assert errors["old/mine"] != errors["new/mine"]
    with open("out/engines.csv", newline="") as file:
        assert {row["engine"]: row["version"] for row in csv.DictReader(file)} == {"old/mine": "1", "new/mine": "2"}
    assert "old/mine:drift" in printed
    assert "new/mine:drift" in printed


def test_a_record_of_both_can_be_asked_about_one(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for folder, speed in (("old", 1.0), ("new", 3.0)):
        Path(folder).mkdir()
        Path(folder, "mine.py").write_text(ENGINE.format(version=1, speed=speed))
    asked = ("-e", "old/mine.py", "-e", "new/mine.py")
    assert main(["check", "table-4-1", *asked, "--no-times", "--accept", "-o", "base"]) == 0
    assert main(["check", "table-4-1", "-e", "new/mine.py", "--no-times", "--baseline", "base"]) == 0
    assert "gone" not in capsys.readouterr().out


def test_the_hand_calculation_takes_part_where_its_instants_are_or_where_it_is_asked_for():
    """Eight rows of it in every other scene would say nothing but that it has no answer there."""
    its_own, other = read_scene("table-4-1"), read_scene("die-vertex")
    with launched([]) as usual, launched(["handcalc"]) as asked, launched(["handcalc:all-mended"]) as named:
        (by_hand,) = (one for one in usual if one.engine == "handcalc")
        assert len(by_hand.methods_for(its_own)) == 8
        assert by_hand.methods_for(other) == ()
        assert len(asked[0].methods_for(other)) == 8
        assert named[0].methods_for(other) == ("all-mended",)
        assert all(one.methods_for(other) for one in usual if one is not by_hand)


def test_an_engine_that_says_nothing_readable_of_its_instants_is_refused(tmp_path):
    (tmp_path / "mine.py").write_text(ENGINE.format(version=1, speed=1.0) + "INSTANTS = 3\n")
    with pytest.raises(BadEngine, match="what it says of itself cannot be read"), launched([str(tmp_path / "mine.py")]):
        pass
