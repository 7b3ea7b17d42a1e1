"""Files in other formats and with other clocks through `tumble grade`: graded as the plain file, or refused."""

import csv
import io
import re
import shlex
import sys

import pytest

from tumble.__main__ import main

SCENE = "two-hits"
POSE = ["t_s", "x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"]


@pytest.fixture(scope="module")
def rows(tmp_path_factory):
    path = tmp_path_factory.mktemp("right") / "right.csv"
    assert main(["run", SCENE, "-e", "tumble:exact", "-o", str(path)]) == 0
    with path.open(newline="") as file:
        return [[f"{float(row[name]):.6f}" for name in POSE] for row in csv.DictReader(file)]


@pytest.fixture
def grade(tmp_path, capsys):
    def run(text, *words):
        path = tmp_path / "their.txt"
        path.write_text(text)
        code = main(["grade", str(path), "--scene", SCENE, *words])
        return code, *capsys.readouterr()

    return run


def lines(rows, separator=","):
    return "".join(separator.join(row) + "\n" for row in rows)


def as_json(row):
    t, x, y, z, *q = row
    w, i, j, k = q
    return f'{{"t_s": {t}, "p": [{x}, {y}, {z}], "q": {{"w": {w}, "x": {i}, "y": {j}, "z": {k}}}}}\n'


MAPS = [word for axis in "xyz" for word in ("--map", f"p_{axis}={axis}_m")]
MAPS += [word for axis in "wxyz" for word in ("--map", f"q_{axis}=q{axis}")]
FORMS = {
    "no header": (lambda rows: lines(rows), ["--columns", ",".join(POSE)]),
    "spaces": (lambda rows: "  ".join(POSE) + "\n" + lines(rows, "   "), []),
    "spaces, no header": (lambda rows: lines(rows, "  "), ["--columns", ",".join(POSE)]),
    "comments": (
        lambda rows: "# made by hand\n#\n" + ",".join(POSE) + "\n" + lines(rows[:5]) + "# so\n" + lines(rows[5:]),
        [],
    ),
    "a comment between rows": (
        lambda rows: ",".join(POSE) + "\n" + lines(rows[:5]) + "# so, it goes on\n" + lines(rows[5:]),
        [],
    ),
    "header in a comment": (lambda rows: f"# {' '.join(POSE)}\n" + lines(rows, " "), []),
    "JSON lines": (lambda rows: "".join(map(as_json, rows)), MAPS),
}


@pytest.mark.parametrize("form", FORMS)
def test_graded_as_the_plain_file_with_the_same_digits(grade, rows, form):
    write, words = FORMS[form]
    _, as_csv, _ = grade(",".join(POSE) + "\n" + lines(rows))
    code, out, err = grade(write(rows), *words)
    assert code == 0, err
    assert out == as_csv
    assert "printed digits" in out


@pytest.mark.parametrize("form", FORMS)
def test_lines_keep_their_numbers(grade, rows, form):
    write, words = FORMS[form]
    text = write([*rows[:7], ["0.75", "1e99", *rows[7][2:]], *rows[8:]])
    line = next(number for number, line in enumerate(text.splitlines(), 1) if "1e99" in line)
    code, out, err = grade(text, *words)
    assert (code, out) == (2, "")
    assert f"line {line}, " in err


def test_no_header_is_offered_columns(grade, rows):
    _, _, err = grade(lines(rows))
    offer = re.search(r"--columns \S+", err)[0]
    code, out, err = grade(lines(rows), *shlex.split(offer))
    assert code == 0, err
    assert "\nCorrect" in out or out.startswith("Correct") or "right" in out.split("\n", 1)[0]


def test_a_clock_that_does_not_start_at_0(grade, rows):
    header, late = ",".join(POSE) + "\n", [[f"{float(row[0]) + 3.42:.6f}", *row[1:]] for row in rows]
    code, _, err = grade(header + lines(late))
    assert code == 2
    first = float(re.search(r"--start (\S+)", err)[1])
    assert first == pytest.approx(float(late[0][0]))
    code, _, err = grade(header + lines(late), "--start", "3.42", "--tolerance", "1e-4")
    assert code == 0, err


def test_a_longer_file_is_cut_with_one_note_and_a_shorter_is_read(grade, rows):
    header = ",".join(POSE) + "\n"
    longer = [*rows, *([f"{2.0 + 0.1 * n:.6f}", "9", "9", "9", *rows[0][4:]] for n in range(3, 40))]
    code, _, err = grade(header + lines(longer), "--tolerance", "1e-4")
    assert code == 0, err
    assert err.count("two-hits (2 s) are ignored") == 1
    code, _, err = grade(header + lines(rows[:9]), "--tolerance", "1e-4")
    assert code == 0
    assert err == ""


def test_standard_input(rows, capsys, monkeypatch):
    text = ",".join(POSE) + "\n" + lines(rows)
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(text.encode())))
    assert main(["grade", "-", "--scene", SCENE, "--tolerance", "1e-4"]) == 0
    assert "standard input" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ('{"t_s": 0}\n[1]\n', "line 2: must be an object"),
        ('{"t_s": 0}\n{"t_s": 1,\n', "line 2: not JSON"),
        ('{"t_s": 0}\n{"s": 1}\n', "line 2: 't_s': missing"),
        ("PAR1 is no table", "Parquet"),
        ("1 2 3\n", "--columns"),
    ],
)
def test_what_cannot_be_read_is_one_line(grade, text, why):
    code, out, err = grade(text)
    assert (code, out) == (2, "")
    assert why in err
    assert err.count("\n") == 1
