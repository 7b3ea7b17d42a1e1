"""`tumble grade --like PROGRAM` on files that little scripts write as six programs do: right in one go."""

import re
import shlex

import pytest
from engine_logs import LOGS, MIRRORED, log, moved, read

from tumble.__main__ import main

Y_UP, Z_UP = "two-hits", "brick-tumble"
# As in other countries, and as where somebody has forgotten that it is one.
GERMAN, FORGETFUL = {"separator": ";", "decimal": ","}, {"separator": ",", "decimal": ","}


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    """Return a function that gives the rows of a right flight of a scene, by a contestant."""
    known = {}

    def rows(scene, contestant="tumble:exact"):
        if (scene, contestant) not in known:
            path = tmp_path_factory.mktemp("right") / "right.csv"
            assert main(["run", scene, "-e", contestant, "-o", str(path)]) == 0
            known[scene, contestant] = read(path)
        return known[scene, contestant]

    return rows


@pytest.fixture
def grade(tmp_path, capsys):
    """Write lines, grade them, and return the exit code, what was printed and what was noted."""

    def run(lines, *words, scene=Y_UP):
        path = tmp_path / "log.csv"
        path.write_text("\n".join(lines) + "\n")
        capsys.readouterr()
        code = main(["grade", str(path), "--scene", scene, *words])
        return code, *capsys.readouterr()

    return run


def later(rows, seconds):
    """Return rows by a clock that shows so much more [s]."""
    return [(t + seconds, *rest) for t, *rest in rows]


def up_z(rows):
    """Return rows of a scene with z up as one with y up would have them: what the scripts take."""

    def turned(v):
        return [v[0], v[2], -v[1]]

    def both(r):
        columns = [turned(column) for column in zip(*r, strict=True)]
        columns = [columns[0], columns[2], [-part for part in columns[1]]]
        return [list(row) for row in zip(*columns, strict=True)]

    return [(t, turned(x), both(r), turned(v), turned(w)) for t, x, r, v, w in rows]


def options(err):
    """Return the options that --like prints."""
    line = re.search(r"--like \w+ reads the file with (.*)", err)[1]
    return shlex.split(line.partition("; in the best reading")[0])


@pytest.mark.parametrize("kind", LOGS)
@pytest.mark.parametrize("scene", [Y_UP, Z_UP])
def test_a_right_file_is_right_in_one_go(grade, flown, kind, scene):
    rows = flown(scene) if scene == Y_UP else up_z(flown(scene))
    lines = list(log(later(rows, 3.42), kind, form="{:.7f}"))
    program = kind.partition(" ")[0]
    code, out, err = grade(lines, "--like", program, scene=scene)
    assert code == 0, err
    assert "is right, to its printed digits" in " ".join(out.split()), out + err
    assert "Also: " not in out
    again = grade(lines, *options(err), scene=scene)
    assert again[:2] == (0, out), "the printed options do the same"


@pytest.mark.parametrize("country", [GERMAN, FORGETFUL])
@pytest.mark.parametrize("kind", ["unity", "unreal", "ros"])
def test_decimal_commas_are_seen(grade, flown, kind, country):
    code, out, err = grade(list(log(flown(Y_UP), kind, **country)), "--like", kind)
    assert code == 0, err
    assert "is right, to its printed digits" in " ".join(out.split())
    assert "--decimal ," in err


@pytest.mark.parametrize("kind", ["unity", "mujoco"])
def test_the_scenes_own_numbers_are_told_from_the_programs_axes(grade, flown, kind):
    """Somebody who types the scene's numbers into a program has them in its axes as they are, and is not wrong."""
    # What the script will move into the program's world is moved out of it first.
    to_ours, handed = {"unity": (MIRRORED, -1), "mujoco": ([[1, 0, 0], [0, 0, 1], [0, -1, 0]], 1)}[kind]
    rows = [moved(row, to_ours, handed) for row in flown(Y_UP)]
    code, out, err = grade(list(log(rows, kind)), "--like", kind)
    assert code == 0, err
    assert "is right, to its printed digits" in " ".join(out.split())
    assert "--axes" not in options(err)


def test_a_wrong_file_is_read_right_and_called_wrong(grade, flown):
    rows = up_z(flown(Z_UP, "mujoco:euler"))
    code, out, err = grade(list(log(later(rows, 1.0), "unity", form="{:.8f}")), "--like", "unity", scene=Z_UP)
    assert code == 0, err
    assert "--axes unity" in err
    assert "MuJoCo" in out.split("\n\n")[0]


def test_given_options_have_priority(grade, flown):
    lines = list(log(later(flown(Y_UP), 2.0), "unity"))
    _, out, err = grade(lines, "--like", "unity", "--start", "1.9", "--map", "Position X=x_m")
    assert "--start" not in options(err), "it is given already"
    assert "is wrong" in " ".join(out.split())


def test_a_file_that_fits_in_no_reading_is_reported(grade, flown):
    right = flown(Y_UP)
    rows = [(t, x, last[2], v, w) for (t, x, _, v, w), last in zip(right, reversed(right), strict=True)]
    _, _, err = grade(list(log(rows, "godot")), "--like", "godot", "--search", "0.05")
    assert "in the best reading its first rows are" in err


def test_an_unknown_program_is_refused(grade, flown, capsys):
    with pytest.raises(SystemExit):
        grade(["t_s"], "--like", "unitiy")
    assert "did you mean 'unity'?" in capsys.readouterr().err
