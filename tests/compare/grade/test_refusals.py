"""All questions that a student's file leaves open, in one line, with the options that answer them."""

import csv
import re
import shlex

import numpy as np
import pytest
from engine_logs import log, read
from scipy.spatial.transform import Rotation

from tumble.__main__ import main
from tumble.compare.grade.read import header, suggestions

SCENE = "two-hits"


@pytest.fixture(scope="module")
def rows(tmp_path_factory):
    path = tmp_path_factory.mktemp("right") / "right.csv"
    assert main(["run", SCENE, "-e", "tumble:exact", "-o", str(path)]) == 0
    return read(path)


@pytest.fixture
def grade(tmp_path, capsys):
    def run(text, *words):
        path = tmp_path / "student.csv"
        path.write_text(text)
        capsys.readouterr()
        code = main(["grade", str(path), "--scene", SCENE, *words])
        return code, *capsys.readouterr()

    return run


def text(lines):
    return "\n".join(lines) + "\n"


def likely(err):
    """Return the options of a refusal."""
    assert err.count("\n") == 1, err
    return shlex.split(re.search(r"; likely: (.*?)(?:;|$)", err.strip())[1])


@pytest.mark.parametrize("country", [{}, {"separator": ";", "decimal": ","}])
def test_one_line_asks_for_everything_and_its_options_are_enough(grade, rows, country):
    late = [(t + 3.42, *rest) for t, *rest in rows]
    file = text(log(late, "unity", form="{:.5f}", **country))
    code, out, err = grade(file)
    assert (code, out) == (2, "")
    for asked in (
        "the time",
        "its clock starts at 3.42 s",
        "the angles Rotation X, Rotation Y, Rotation Z",
    ):
        assert asked in err
    assert ("decimal signs" in err) == bool(country)
    assert err.index("clock starts") < err.index("the angles"), "the clock is asked about before the convention"
    code, out, err = grade(file, *likely(err))
    assert code == 0, err
    assert "is right, to its printed digits" in " ".join(out.split())


def test_three_columns_of_a_rotation_are_angles_and_four_are_a_quaternion(grade, rows):
    """`Rotation X=qx` was the first hint, and then qw was missing."""
    _, _, err = grade(text(log(rows, "unity")))
    assert "Rotation X=rx_deg" in err
    assert "=qx" not in err
    _, _, err = grade(text(log(rows, "unity quaternion")))
    assert "rotx=qx" in err
    assert "rotw=qw" in err
    assert "=rx" not in err


def test_the_clock_is_right_before_the_angles_are_tried(grade, rows):
    """By a clock that starts elsewhere no convention would fit."""
    names = ["t_s", "x_m", "y_m", "z_m", "rx", "ry", "rz"]
    angles = [Rotation.from_matrix(r).as_euler("YXZ", degrees=True)[[1, 0, 2]] for _, _, r, _, _ in rows]
    lines = [",".join(f"{n:.6f}" for n in (t + 7.5, *x, *a)) for (t, x, _, _, _), a in zip(rows, angles, strict=True)]
    code, _, err = grade(text([",".join(names), *lines]))
    assert code == 2
    words = likely(err)
    assert words[words.index("--start") + 1] == "7.5"
    assert words[words.index("--euler") + 1] == "godot"
    assert grade(text([",".join(names), *lines]), *words)[0] == 0


def test_the_nearest_convention_is_offered_where_none_fits(grade, tmp_path, capsys):
    """A body that turns a little too fast from the start fits nothing to a twentieth, and one convention best."""
    path = tmp_path / "fast.csv"
    assert main(["run", SCENE, "-e", "tumble:exact", "-o", str(path)]) == 0
    with path.open(newline="") as file:
        cells = list(csv.DictReader(file))
    capsys.readouterr()
    lines = ["t_s,x_m,y_m,z_m,rx_deg,ry_deg,rz_deg"]
    for row in cells:
        q = [float(row[name]) for name in ("qx", "qy", "qz", "qw")]
        spun = Rotation.from_rotvec([0.0, 0.0, 0.6 * float(row["t_s"])]) * Rotation.from_quat(q)
        angles = spun.as_euler("ZYX", degrees=True)[::-1]
        lines.append(",".join([row["t_s"], row["x_m"], row["y_m"], row["z_m"], *map(repr, angles.tolist())]))
    code, _, err = grade(text(lines))
    assert code == 2
    assert "no convention of rx_deg, ry_deg, rz_deg fits two-hits; the nearest, " in err
    assert "is Blender or Ros's: --euler blender" in err


def test_a_program_is_offered_where_only_its_units_fit(grade, rows):
    """Unreal's centimetres taken for metres are 450 times the body off, in any convention of angles."""
    file = text(log([(t + 3.42, *rest) for t, *rest in rows], "unreal", form="{:.5f}"))
    code, _, err = grade(file)
    assert code == 2
    assert err.rstrip().endswith("; it fits as Unreal writes it: --like unreal")
    code, out, err = grade(file, "--like", "unreal")
    assert code == 0, err
    assert "is right, to its printed digits" in " ".join(out.split())


def test_other_axes_of_ones_own_may_be_said_before_the_angles(grade, rows):
    lines = list(log(rows, "unity", form="{:.6f}"))
    code, _, err = grade(text(lines), "--axes", "x,y,-z")
    assert code == 2
    assert grade(text(lines), "--axes", "x,y,-z", *likely(err))[0] == 0


def test_a_unit_of_time_is_found_with_the_rest(grade, rows):
    """rostopic prints nanoseconds since 1970."""
    lines = list(log(rows, "ros"))
    stamped = [lines[0].replace("time", "%time", 1)]
    for (t, *_), line in zip(rows, lines[1:], strict=True):
        stamped.append(f"{1_600_000_000_000_000_000 + round(t * 1e9)},{line.partition(',')[2]}")
    code, _, err = grade(text(stamped))
    assert code == 2
    assert "%time=t_ns" in err
    assert "--start" in err


def test_what_is_bad_whatever_is_answered_is_said_as_well(grade, rows):
    lines = list(log([(t + 3.42, *rest) for t, *rest in rows], "unity"))
    lines[4] = lines[4].replace(",", ",none,", 1).rpartition(",")[0]
    _, _, err = grade(text(lines))
    assert "its clock starts" in err
    assert "line 5, Position X = 'none'" in err


def test_a_question_of_a_wide_file_is_asked_only_where_there_is_one(tmp_path, rows, monkeypatch, capsys):
    """To think of what 100,000 columns may mean took 10 s, for nothing."""

    def never(*_):
        raise AssertionError("nothing is to be asked")

    for module, name in ((header, "likely_names"), (header, "angles_of"), (suggestions, "_likely")):
        monkeypatch.setattr(module, name, never)
    names = ["t_s", "x_m", "y_m", "z_m", "qw", "qx", "qy", "qz", *(f"c{n}" for n in range(20_000))]
    q = [Rotation.from_matrix(r).as_quat() for _, _, r, _, _ in rows]
    lines = [
        [*map(repr, map(float, (t, *x, *np.roll(a, 1)))), *["1"] * 20_000]
        for (t, x, *_), a in zip(rows, q, strict=True)
    ]
    path = tmp_path / "wide.csv"
    path.write_text("\n".join([",".join(names), *map(",".join, lines)]) + "\n")
    assert main(["grade", str(path), "--scene", SCENE, "--tolerance", "1e-9"]) == 0
    capsys.readouterr()


def test_names_of_columns_are_read_in_no_time_however_they_are_made():
    """Of names that repeat a word that may stand before others, none takes longer than the others."""
    from time import process_time

    begin = process_time()
    for word in ("time", "obj", "body", "rot", "global", "e", "position", "x"):
        for count in range(1, 60):
            name = word * count + "!"
            suggestions.likely_names([name, f"{name} (m)", f"{name}_x"], {}, ())
            suggestions.angles_of([f"{name} x", name])
    few = process_time() - begin
    begin = process_time()
    for _ in range(1000):
        suggestions.likely_names(["time", "position.x (m)", "body_x"], {}, ())
        suggestions.angles_of(["rotation x", "roll"])
    assert few < 100 * (process_time() - begin)
