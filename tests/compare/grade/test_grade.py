"""Files that other programs wrote, through the command: what they are held against, and which mistake is named."""

import csv
from pathlib import Path

import in_process
import numpy as np
import pytest

from tools import confusion
from tumble.__main__ import main
from tumble.compare.grade import contact_grade, sensor_grade
from tumble.compare.grade import grade as verdict
from tumble.compare.grade.read.columns import UNITS
from tumble.scenarios.published import VERTEX, table_4_1


def fly(contestant, path):
    """Let an engine write its trajectory of brick-tumble, and return it as rows of a dict."""
    in_process.tumble(path.parent, "run", "brick-tumble", "-e", contestant, "-o", str(path)).check_returncode()
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


@pytest.fixture(scope="module")
def right(tmp_path_factory):
    return fly("tumble:exact", tmp_path_factory.mktemp("right") / "right.csv")


def write(path, rows, names=None):
    names = names or list(rows[0])
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, names, extrasaction="ignore")
        writer.writeheader()
        writer.writerows(rows)
    return str(path)


def grade(capsys, *words):
    code = main(["grade", *words])
    out, err = capsys.readouterr()
    return code, out, err


def named(out):
    return out.partition("The most likely cause")[2]


def test_what_is_right_is_called_correct(capsys, tmp_path, right):
    code, out, _ = grade(capsys, write(tmp_path / "a.csv", right), "--scene", "brick-tumble")
    assert code == 0
    assert "Correct" in out
    assert not named(out)


def test_an_engine_of_first_order_is_recognised_with_its_step(capsys, tmp_path):
    fly("mujoco:euler", tmp_path / "euler.csv")
    _, out, _ = grade(capsys, str(tmp_path / "euler.csv"), "--scene", "brick-tumble")
    first = " ".join(out.split())[: len(out) // 3]
    assert "Most likely cause: symplectic Euler with a step of 0.002 s" in first, "also for whoever knows no engine"
    assert "That is the default of MuJoCo (Euler), DART and" in first
    assert "This is the default of MuJoCo (Euler), DART and" in out
    assert "symplectic Euler with a step of 0.002 s, explicit gyroscopic term" in out


def test_quaternions_written_the_other_way_round(capsys, tmp_path, right):
    pose = ["t_s", "x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"]
    rows = [{**row, "qw": row["qx"], "qx": row["qy"], "qy": row["qz"], "qz": row["qw"]} for row in right]
    _, out, _ = grade(capsys, write(tmp_path / "swapped.csv", rows, pose), "--scene", "brick-tumble")
    assert "quaternion written as x y z w" in named(out)


def test_rows_between_which_matrices_were_interpolated_are_no_noise(capsys):
    """Rows far apart are as little correlated as noise; that some of them are right shows that it is none."""
    file, scene = (str(Path(__file__).with_name(f"matrices-between.{end}")) for end in ("csv", "toml"))
    _, out, _ = grade(capsys, file, "--scene", scene, "--search", "0.05")
    assert "Not explained" in out
    assert "One row in 4 is right, and none of those between: they may be interpolated." in " ".join(out.split())


def test_gravity_left_out(capsys, tmp_path, right):
    rows = [dict(row) for row in right]
    for row in rows:
        lift = 9.8 * float(row["t_s"]) ** 2 / 2
        vertical = [name for name in row if name == "z_m" or (name[0] == "v" and name.endswith("z_m"))]
        for name in vertical:
            row[name] = repr(float(row[name]) + lift)
    points = [name for name in rows[0] if name == "t_s" or (name[0] == "v" and name[1].isdigit())]
    _, out, _ = grade(capsys, write(tmp_path / "afloat.csv", rows, points), "--scene", "brick-tumble")
    assert "1. gravity missing" in named(out)
    assert "2. " not in named(out)


def test_what_explains_nearly_all_is_told_without_what_is_fitted_to_an_unknown_rest(capsys, tmp_path, right):
    """It drifts aside as well, by 32 mm in the end; a start velocity and damping, fitted together, leave 11 mm."""
    rows = [dict(row) for row in right]
    for row in rows:
        t = float(row["t_s"])
        for axis, off in (("z", 9.8 * t**2 / 2), ("x", 1e-3 * t**1.5)):
            for name in row:
                if name == f"{axis}_m" or (name[0] == "v" and name[1].isdigit() and name.endswith(f"{axis}_m")):
                    row[name] = repr(float(row[name]) + float(off))
    points = [name for name in rows[0] if name == "t_s" or (name[0] == "v" and name[1].isdigit())]
    file = write(tmp_path / "drifting.csv", rows, points)
    _, out, err = grade(capsys, file, "--scene", "brick-tumble", "--quiet", "--search", "0.1")
    assert "Best partial explanation: gravity missing." in " ".join(out.split())
    assert "1. gravity missing" in out
    assert "2. " not in out.partition("The best partial explanation")[2]
    assert "The remaining 32 mm" in out
    assert err == "", "a quiet command shows only what went wrong"


def test_table_4_1_names_its_three_mistakes(capsys, tmp_path):
    table = table_4_1()
    rows = [
        {"t_s": repr(float(t)), **{f"v{VERTEX}{axis}_m": repr(float(c)) for axis, c in zip("xyz", place, strict=True)}}
        for t, place in zip(table.clock, table.calculated, strict=True)
    ]
    _, out, _ = grade(capsys, write(tmp_path / "calculated.csv", rows), "--scene", "table-4-1", "--search", "30")
    assert "The search stopped" not in out
    _, stopped, _ = grade(capsys, str(tmp_path / "calculated.csv"), "--scene", "table-4-1", "--search", "0.0001")
    assert "The search stopped after 0.0001 s of processor time; --search 0.001 makes it longer." in " ".join(
        stopped.split()
    )
    first = "\n".join(named(out).splitlines()[:4])
    assert "vertex not relative to the centre of mass" in first
    assert "impulse applied as a permanent force" in first


def test_columns_and_units_of_another_program(capsys, tmp_path, right):
    names = {"t_s": "Time (ms)"} | {f"v0{axis}_m": f"P {axis}" for axis in "xyz"}
    rows = [
        {other: float(row[ours]) * (1000 if ours == "t_s" else 100) for ours, other in names.items()} for row in right
    ]
    path = write(tmp_path / "foreign.csv", [{k: f"{v!r}" for k, v in row.items()} for row in rows])
    mapped = [f"{other}={'t_ms' if ours == 't_s' else ours[:-1] + 'cm'}" for ours, other in names.items()]
    words = [word for pair in mapped for word in ("--map", pair)]
    code, out, _ = grade(capsys, path, "--scene", "brick-tumble", *words)
    assert code == 0
    assert "Correct" in out


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "empty"),
        ("t_s,v0x_m,v0y_m,v0z_m\n0,1,2\n", "line 2"),
        ("t_s,v0x_m,v0y_m,v0z_m\n0,1,2,nan\n", "nan"),
        ("t_s,v0x_m,v0y_m,v0z_m\n1,1,2,3\n0,1,2,3\n", "later"),
        ("a,b\n1,2\n", "--map"),
        ("t_s;v0x_m;v0y_m;v0z_m\n0;1,5;2,5;3,5\n", "decimal"),
    ],
)
def test_a_bad_file_is_refused_in_one_line(capsys, tmp_path, text, told):
    path = tmp_path / "bad.csv"
    path.write_text(text)
    code, out, err = grade(capsys, str(path), "--scene", "brick-tumble")
    assert code == 2
    assert out == ""
    assert err.count("\n") == 1
    assert "bad.csv" in err
    assert told in err


def test_a_tolerance_makes_it_a_check(capsys, tmp_path):
    rows = fly("mujoco:implicit", tmp_path / "implicit.csv")
    assert np.isfinite(float(rows[-1]["x_m"]))
    words = (str(tmp_path / "implicit.csv"), "--scene", "brick-tumble", "--tolerance")
    assert grade(capsys, *words, "1e-6")[0] == 1
    assert grade(capsys, *words, "10")[0] == 0


DOCS = Path(__file__).parents[3] / "docs"
PAGE = (DOCS / "grade.md").read_text(encoding="utf-8")


def table(first):
    """Return the rows of the table of the page that begins with a word."""
    _, _, rest = PAGE.partition(f"| {first} |")
    rows = rest.partition("\n\n")[0].splitlines()[2:]
    return [[cell.strip() for cell in row.strip("|").split("|")] for row in rows]


def test_the_page_has_every_verdict():
    known = {**vars(verdict), **vars(sensor_grade), **vars(contact_grade)}
    verdicts = {value for name, value in known.items() if name.isupper() and isinstance(value, str)}
    verdicts -= {sensor_grade.ACCELEROMETER}
    assert {row[0] for row in table("verdict")} == verdicts


def test_the_page_has_every_unit():
    said = {row[0].partition(" ")[0].strip(",:"): row[2].split(", ") for row in table("quantity")}
    assert said["time"] == list(UNITS["time"])
    assert said["centre"] == list(UNITS["length"])
    assert said["velocity"] == list(UNITS["speed"])
    assert said["angular"] == list(UNITS["rate"])
    assert table("reading")[0][2].split(", ") == list(UNITS["acceleration"])


def confusion_rows():
    with (DOCS / "confusion.csv").open(newline="") as file:
        return list(csv.DictReader(file))


@pytest.mark.parametrize("number", [0, 2, -1])
def test_the_confusion_table_is_what_its_script_makes(number):
    shown = confusion_rows()[number]
    made = confusion.confused((int(shown["mistakes"]), int(shown["scene"])))
    values = shown["values"].removeprefix("'")  # the mark of a cell that a spreadsheet would run: it begins with -
    assert (made.planted, made.values, made.named) == (shown["planted"], values, shown["named"])


@pytest.mark.parametrize(("mistakes", "asked"), [(1, 0.9), (2, 0.6)])
def test_the_confusion_table_says_what_its_rows_say(mistakes, asked):
    seen = [row for row in confusion_rows() if row["mistakes"] == str(mistakes) and row["seen"] == "True"]
    right = sum(row["right"] == "True" for row in seen)
    assert right >= asked * len(seen)
    assert f"{right} of {len(seen)} (" in (DOCS / "confusion.md").read_text(encoding="utf-8")
