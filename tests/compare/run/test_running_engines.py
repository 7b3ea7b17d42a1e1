"""Who takes part, by which name: two engine files of one name are told apart in every table."""

import csv
import os
from pathlib import Path

import pytest

from tumble.__main__ import main
from tumble.compare.run.asked import titles
from tumble.compare.run.engines.registry import BadEngine
from tumble.compare.run.running_engines import launched
from tumble.scenarios.read import read_scene

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


def methods_of(*asked: str) -> dict[str, tuple[str, ...]]:
    with launched(asked) as running_engines:
        return {one.title: one.methods for one in running_engines}


def test_an_engine_asked_for_as_a_whole_and_by_a_method_takes_part_with_all_of_it_once():
    alone = methods_of("mujoco")["mujoco"]
    assert len(alone) > 2
    assert methods_of("mujoco", "mujoco:rk4") == {"mujoco": alone}
    assert methods_of("mujoco:rk4", "mujoco") == {"mujoco": ("rk4", *(one for one in alone if one != "rk4"))}
    assert methods_of("mujoco:rk4", "mujoco:rk4", "mujoco:euler") == {"mujoco": ("rk4", "euler")}
    assert methods_of("mujoco:euler+defaults", "mujoco")["mujoco"] == ("euler+defaults", *alone)


def test_a_forced_method_that_is_named_beside_its_engine_runs_in_a_free_scene_too():
    free = read_scene("two-hits")
    with launched(["mujoco", "mujoco:rk4+held"]) as (one,):
        assert "rk4+held" in one.methods_for(free)
        assert "euler+held" not in one.methods_for(free)
        assert not one.only_named
    with launched(["mujoco:rk4+held"]) as (one,):
        assert one.only_named


def test_default_is_what_an_engine_does_where_nobody_sets_anything(tmp_path):
    """MuJoCo's flags move no flight here, and its default is Euler; PyBullet damps unless told not to."""
    (tmp_path / "mine.py").write_text(ENGINE.format(version=1, speed=1.0))
    asked = ("mujoco", "mujoco:rk4", "pybullet", "pybullet:multibody+defaults", "handcalc", str(tmp_path / "mine.py"))
    with launched(asked) as running_engines:
        roles = {f"{one.title}:{method}": one.role(method) for one in running_engines for method in one.methods}
    assert {name for name, role in roles.items() if role == "default"} == {
        "mujoco:euler",
        "pybullet:multibody+defaults",
        "mine:drift",
    }
    assert {name for name, role in roles.items() if role == "as asked"} == {"mujoco:rk4"}


def test_compare_calls_nobody_the_default_who_is_not(capsys):
    assert main(["compare", "two-hits", "-e", "mujoco:rk4", "-e", "pybullet:rigidbody"]) == 0
    printed = capsys.readouterr().out
    assert "default" not in printed
    lines = [line.split() for line in printed.splitlines() if line.startswith(("mujoco:rk4 ", "pybullet:rigidbody "))]
    assert ["as", "asked"] in [line[1:3] for line in lines]
    assert main(["compare", "two-hits", "-e", "mujoco", "-e", "mujoco:rk4"]) == 0
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert [line[:2] for line in lines if line[1:2] == ["default"]] == [["mujoco:euler", "default"]]
    assert ["mujoco:rk4", "as", "asked"] in [line[:3] for line in lines]


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
