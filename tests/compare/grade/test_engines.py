"""`tumble grade` on files of other people's engines: the laws are named, and nothing that is not there."""

import csv
import importlib.util
import json
import sys
from pathlib import Path

import pytest

from tumble.__main__ import main

HERE = Path(__file__).parent
FOLDER = HERE / "foreign"
with (FOLDER / "truth.csv").open(newline="") as truth_file:
    TRUTHS = {truth["file"]: truth for truth in csv.DictReader(truth_file)}
ENGINES = {
    "cannon-es.brick.60.csv": "cannon-es",
    "jolt+gyro.brick.60.csv": "Jolt with its gyroscopic flag, without damping",
    "jolt.brick.60.csv": "Jolt",
    "havok.brick.60.csv": "Havok",
    "rapierjs.brick.60.csv": "Rapier",
    "sapien.brick.60.csv": "PhysX",
    "newton+semi.corner.60.csv": "Newton (semi-implicit)",
    "panda_ode.brick.60.csv": "ODE",
    "pybullet.corner.60.csv": "PyBullet (multibody)",
    "ammo+typed.brick.60.csv": "ammo.js, read through a motion state",
    "oimo.brick.60.csv": "oimo",
}


@pytest.fixture(scope="module")
def judge():
    spec = importlib.util.spec_from_file_location("foreign_judge", HERE.parents[2] / "tools" / "foreign.py")
    script = importlib.util.module_from_spec(spec)
    sys.modules["foreign_judge"] = script  # dataclasses look there for their module
    spec.loader.exec_module(script)
    return script


@pytest.mark.parametrize("name", TRUTHS)
def test_a_file_of_another_program_is_judged_right(judge, name):
    truth = TRUTHS[name]
    scene = FOLDER / "scenes" / f"{truth['scene']}.toml"
    found = judge.row((FOLDER / "csv" / name, scene, truth))
    assert found.outcome == "right", found
    if name in ENGINES:
        assert ENGINES[name] in found.engines.split(" | "), found


def test_the_judge_can_be_displeased(judge):
    """A truth that is not the file's is not found in it."""
    truth = TRUTHS["cannon-es.brick.60.csv"] | {"angular_damping_per_s": "0.2", "gyroscopic": "implicit"}
    file, scene = FOLDER / "csv" / "cannon-es.brick.60.csv", FOLDER / "scenes" / "brick.toml"
    assert judge.row((file, scene, truth)).outcome == "in part"
    correct = TRUTHS["plant-right.struck.0.csv"] | {"also": "the body never moves"}
    file, scene = FOLDER / "csv" / "plant-right.struck.0.csv", FOLDER / "scenes" / "struck.toml"
    assert judge.row((file, scene, correct)).outcome == "false correct"


def graded(capsys, *words):
    file, scene = FOLDER / "csv" / "cannon-es.brick.60.csv", FOLDER / "scenes" / "brick.toml"
    assert main(["grade", str(file), "--scene", str(scene), *words]) == 0
    return capsys.readouterr()


def test_an_engine_is_named_and_the_first_word_comes_before_the_search(capsys):
    out, err = graded(capsys)
    assert "This is the default of cannon-es:" in out
    assert "largest error 370 mm" in err


def test_the_answer_for_machines(capsys, tmp_path):
    out, _ = graded(capsys, "--json", "-o", str(tmp_path))
    answer = json.loads(out)
    assert answer["verdict"] == "explained"
    assert answer["engines"] == ["cannon-es"]
    named = {(row["mistake"], row["parameter"]): row["value"] for row in answer["diagnosis"]}
    assert float(named["angular-damping", "rate"]) == pytest.approx(0.01005, rel=1e-3)
    assert float(named["symplectic-euler", "step"]) == pytest.approx(1 / 60)
    assert named["symplectic-euler", "rotation"] == "first order"
    with (tmp_path / "diagnosis.csv").open(newline="") as file:
        assert [row["mistake"] for row in csv.DictReader(file)] == [row["mistake"] for row in answer["diagnosis"]]


def test_of_several_throws_the_worst_is_diagnosed(capsys, tmp_path):
    scene = tmp_path / "throws.toml"
    scene.write_text((FOLDER / "scenes" / "corner.toml").read_text() + "[ensemble]\nthrows = 3\nseed = 1\ncone = 0.1\n")
    flown = tmp_path / "flown.csv"
    assert main(["run", str(scene), "-e", "tumble:exact", "-o", str(flown)]) == 0
    with flown.open(newline="") as file:
        header, *rows = csv.reader(file)
    column = header.index("x_m")
    for row in rows:
        if row[header.index("member")] == "2":
            row[column] = repr(float(row[column]) + 0.25)
    path = tmp_path / "shifted.csv"
    with path.open("w", newline="") as file:
        csv.writer(file).writerows([header, *rows])
    capsys.readouterr()
    assert main(["grade", str(path), "--scene", str(scene), "--by", "pose"]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "throw 2" in out
    assert "The first row is not the scene's start: its position is off by (0.25, " in out
    assert "start position x = " in out


def test_a_file_of_attitudes_only_is_graded(capsys, tmp_path):
    with (FOLDER / "csv" / "cannon-es.brick.60.csv").open(newline="") as file:
        rows = [[row[0], *row[4:]] for row in csv.reader(file)]
    path = tmp_path / "attitudes.csv"
    with path.open("w", newline="") as file:
        csv.writer(file).writerows(rows)
    assert main(["grade", str(path), "--scene", str(FOLDER / "scenes" / "brick.toml")]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "read as quaternion, attitude only" in out
    assert "gyroscopic term missing" in out
    assert "angular damping" in out
    assert "linear damping" not in out
