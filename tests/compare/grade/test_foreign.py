"""Files as other programs, spreadsheets and hands leave them, through the command: read right, or asked in one line."""

import csv
import os
import re
import resource
import shlex
import subprocess

import in_process
import numpy as np
import pytest
from apart import engine
from scipy.spatial.transform import Rotation

from tumble.__main__ import main
from tumble.compare.grade.measure.errors import measure
from tumble.compare.grade.read.cells import LOOKED_AT
from tumble.compare.grade.read.trajectory import Trajectory
from tumble.scenarios.read import read_scene

SCENE = "two-hits"
POSE = ["t_s", "x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"]
CORNERS = [f"v{number}{axis}_m" for number in range(8) for axis in "xyz"]
MATRIX = [f"r{row}{column}" for row in "123" for column in "123"]


def flown(scene, path, contestant="tumble:exact"):
    """Return what a contestant flew: column name -> cells in 17 digits."""
    in_process.tumble(path.parent, "run", scene, "-e", contestant, "-o", str(path)).check_returncode()
    with path.open(newline="") as file:
        header, *rows = csv.reader(file)
    return dict(zip(header, map(list, zip(*rows, strict=True)), strict=True))


@pytest.fixture(scope="module")
def right(tmp_path_factory):
    columns = flown(SCENE, tmp_path_factory.mktemp("right") / "right.csv")
    q = np.array([columns[name] for name in ("qx", "qy", "qz", "qw")], dtype=float).T
    matrices = Rotation.from_quat(q).as_matrix().reshape(-1, 9)
    return columns | {
        name: [repr(cell) for cell in column.tolist()] for name, column in zip(MATRIX, matrices.T, strict=True)
    }


def text(columns, names=None, separator=",", end="\n"):
    """Return some columns as a file; names: column in the file -> column of ours, or a list of ours."""
    names = names or list(columns)
    choice_cost = [columns[names[name] if isinstance(names, dict) else name] for name in names]
    return "".join(separator.join(cells) + end for cells in (list(names), *zip(*choice_cost, strict=True)))


def scaled(columns, factor, *names):
    """Return columns with some of them in another unit."""
    return columns | {name: [repr(float(cell) * factor) for cell in columns[name]] for name in names}


@pytest.fixture
def grade(tmp_path, capsys):
    """Write a file and grade it; the exit code, what was printed, notes."""

    def run(content, *words, scene=SCENE):
        path = tmp_path / "their.csv"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        code = main(["grade", str(path), "--scene", scene, *words])
        out, err = capsys.readouterr()
        return code, out, err

    return run


@pytest.fixture
def correct(grade):
    """Grade a file that must be read, and found right to 1e-12 m or to its digits, and return what was printed."""

    def run(content, *words, **scene):
        code, out, err = grade(content, *words, **scene)
        assert code == 0, err
        assert "\nCorrect" in out
        return out

    return run


@pytest.fixture
def refused(grade):
    """Grade a file that must be refused in one line, and return the line."""

    def run(content, *words, **scene):
        code, out, err = grade(content, *words, **scene)
        assert code == 2
        assert out == ""
        assert err.count("\n") == 1
        assert err.rstrip("\n").isprintable()
        assert len(err) < 1500
        return err

    return run


def maps(said):
    return [word for column, name in said.items() for word in ("--map", f"{column}={name}")]


# --- what is read ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("names", "kind"),
    [
        (POSE, "centre and quaternion"),
        (POSE[::-1], "centre and quaternion"),
        ([*POSE, "vx_m_s", "vy_m_s", "vz_m_s", "wx_rad_s", "wy_rad_s", "wz_rad_s"], "centre and quaternion"),
        ([*POSE[:4], *MATRIX], "centre and matrix"),
        ([*MATRIX[::-1], *POSE[:4]], "centre and matrix"),
        (["t_s", *CORNERS], "vertices"),
        (["v5z_m", "v5x_m", "t_s", "v5y_m"], "vertices"),
        ([*CORNERS[3:9], "t_s", *CORNERS[18:21]], "vertices"),
    ],
)
def test_each_description_in_any_order(correct, right, names, kind):
    assert f"read as {kind};" in correct(text(right, names))


@pytest.mark.parametrize("kind", ["matrix", "vertices", "pose"])
def test_a_transposed_or_shifted_description_is_not_right(tmp_path, right, kind):
    names = {name: name for name in {"matrix": [*POSE[:4], *MATRIX], "vertices": ["t_s", *CORNERS], "pose": POSE}[kind]}
    one, other = {"matrix": ("r12", "r21"), "vertices": ("v0x_m", "v1z_m"), "pose": ("qx", "qy")}[kind]
    names[one], names[other] = other, one
    path = tmp_path / "wrong.csv"
    path.write_text(text(right, names))
    scene = read_scene(SCENE)
    assert measure(Trajectory(path, scene, {}), scene).worst_m > 0.05


FOREIGN = {
    "Time [ms]": "t_ms", "Pos X": "x_cm", "Pos Y": "y_cm", "Pos Z": "z_cm",
    "q1": "qx", "q2": "qy", "q3": "qz", "q4": "qw",
    "a": "vx_cm_s", "b": "vy_cm_s", "c": "vz_cm_s", "om 1": "wx_deg_s", "om 2": "wy_deg_s", "om 3": "wz_deg_s",
}  # fmt: skip


@pytest.fixture
def foreign(right):
    """A file in ms, cm, cm/s and deg/s, the quaternion scalar last, under names of another program."""
    factors = {"ms": 1000, "cm": 100, "cm_s": 100, "deg_s": 180 / np.pi}
    ours = {"ms": "_s", "cm": "_m", "cm_s": "_m_s", "deg_s": "_rad_s"}
    columns, names = right, {}
    for column, name in FOREIGN.items():
        quantity, _, unit = name.partition("_")
        names[column] = quantity + ours.get(unit, "")
        if unit:
            columns = scaled(columns, factors[unit], names[column])
    return text(columns, names)


def test_names_and_units_on_the_command_line(correct, foreign):
    out = correct(foreign, *maps(FOREIGN))
    # Velocities in the wrong unit would be off by more than all there is.
    drifts = [float(drift) for drift in re.findall(r"(?:energy|momentum) (\S+?),? ", out)]
    assert len(drifts) == 3
    assert max(map(abs, drifts)) < 1e-12


def toml(said):
    return "[columns]\n" + "".join(f'"{column}" = "{name}"\n' for column, name in said.items())


def test_names_and_units_in_a_file_beside_it_or_anywhere(correct, refused, foreign, tmp_path):
    (tmp_path / "map.toml").write_text(toml(FOREIGN))
    correct(foreign, "--map-file", str(tmp_path / "map.toml"))
    refused(foreign)
    (tmp_path / "their.csv.toml").write_text(toml(FOREIGN))
    correct(foreign)
    # What is said on the command line goes before the file, and another file before the one beside.
    (tmp_path / "their.csv.toml").write_text(toml(FOREIGN | {"Time [ms]": "t_s"}))
    assert "lasts 2 s" in refused(foreign)
    correct(foreign, "--map", "Time [ms]=t_ms")
    correct(foreign, "--map-file", str(tmp_path / "map.toml"))


@pytest.mark.parametrize(
    ("written", "told"),
    [
        ("columns = 3", "must be a table"),
        ("[columns]\nt = 3", "must be a name"),
        ("[column]\nt = 't_s'", "unknown key"),
        ("[columns\n", "not TOML"),
        ("[columns]\nTime = 't_h'", "t_s, t_ms, t_us, t_ns, t_min"),
        ("[columns]\nTime = 'speed'", "unknown name"),
        ("[columns]\nTiem = 't_s'", "did you mean 'Time'?"),
    ],
)
def test_a_bad_mapping_file(refused, right, tmp_path, written, told):
    (tmp_path / "their.csv.toml").write_text(written)
    assert told in refused(text(right, {"Time": "t_s", **{name: name for name in POSE[1:]}}))


def test_the_same_place_said_twice(correct, refused, right):
    both = [*POSE, *CORNERS]
    correct(text(right, both))
    shifted = scaled(right, 1.01, "x_m")
    told = refused(text(shifted, both))
    assert ": its vertices and its pose are" in told
    assert "--by vertices or --by pose" in told
    correct(text(shifted, both), "--by", "vertices")
    assert "only vertices and pose" in refused(text(right, both), "--by", "matrix")


def test_single_precision_said_twice_is_said_alike(grade, tmp_path):
    """An engine's quaternion is of length 1 to 1e-7 only: corners that follow from it are not those of a unit one."""
    with engine("rapier"):
        columns = flown(SCENE, tmp_path / "single.csv", "rapier")
    code, out, err = grade(text(columns, [*POSE, *CORNERS]))
    assert (code, "--by" in err) == (0, False)
    assert "gyroscopic term" in out
    apart = scaled(columns, 1.00001, "x_m")
    assert "--by vertices or --by pose" in grade(text(apart, [*POSE, *CORNERS]))[2]


def test_a_file_is_of_single_precision_where_its_centre_is(grade, tmp_path):
    """PhysX has a mesh's principal axes apart from its frame: the attitude is worked out in doubles as it is read."""
    with engine("physx"):
        columns = flown("mesh-die", tmp_path / "single.csv", "physx")
    assert any(float(np.float32(cell)) != float(cell) for cell in columns["qw"])
    _, out, err = grade(text(columns), scene="mesh-die")
    assert "--by" not in err
    assert "PhysX" in out


def test_separators_decimal_commas_line_ends_and_marks(correct, refused, right):
    whole = text(right, POSE)
    correct(whole.replace(",", "\t").replace("\n", "\r\n"))
    correct(b"\xef\xbb\xbf" + whole.encode())
    correct(whole.removesuffix("\n"))
    correct(whole.replace("\n", "\n\n"))
    correct(whole + ",,,,,,,\n")
    german = whole.replace(",", ";").replace(".", ",")
    correct(german, "--decimal", ",")
    assert "--decimal ," in refused(german)
    assert "a decimal point, but --decimal ," in refused(whole.replace(",", ";"), "--decimal", ",")
    assert "not UTF-8" in refused(whole.replace("t_s", "t_s,µ").encode("latin-1"))
    assert "UTF-16" in refused(whole.encode("utf-16"))
    assert "CR alone" in refused(whole.replace("\n", "\r"))
    assert "only one column" in refused(whole.replace(",", "|"))


def test_a_separator_after_every_cell(correct, right):
    header, *rows = text(right, POSE).splitlines()
    correct("\n".join([header, *(f"{row}," for row in rows)]))
    correct("\n".join([f"{header},", *(f"{row}," for row in rows)]))
    correct("\n".join([f"{header},", *rows]))


def test_decimal_commas_in_cells_that_commas_separate(correct, refused, right):
    header, *rows = [line.split(",") for line in text(right, POSE).splitlines()]
    quoted = [",".join(f'"{cell.replace(".", ",")}"' for cell in row) for row in rows]
    correct("\n".join([",".join(header), *quoted]), "--decimal", ",")
    # Where every number has a comma, two cells are one number; where one has none, nothing says which.
    bare = [",".join(f"{float(cell):.9f}".replace(".", ",") for cell in row) for row in rows]
    correct("\n".join([",".join(header), *bare]), "--decimal", ",")
    assert "give --decimal ," in refused("\n".join([",".join(header), *bare]))
    bare[3] = bare[3].replace(",", ".", 1)
    assert "decimal commas need" in refused("\n".join([",".join(header), *bare]), "--decimal", ",")


def test_extra_columns_quotes_and_blanks_mean_nothing(correct, right):
    note = ['"a ""big"" one, \nof two lines"'] * len(right["t_s"])
    padded = {name: [f"  {cell} " for cell in cells] for name, cells in right.items()}
    names = {f" {name} ": name for name in POSE}
    correct(text(padded | {"note": note}, {"note": "note", **names, "": "note", "x y": "note"}))
    quoted = {name: [f'"{cell}"' for cell in cells] for name, cells in right.items()}
    correct(text(quoted, {f'"{name}"': name for name in POSE}))


def test_one_row_two_rows(grade, correct, right):
    lines = text(right, POSE).splitlines(keepends=True)
    correct("".join(lines[:2]))
    correct("".join(lines[:3]))
    wrong = text(scaled(right, 1.1, "x_m"), POSE).splitlines(keepends=True)
    code, out, _ = grade("".join(wrong[:2]))
    assert code == 0
    assert "one row is too few" in out


def test_many_throws(correct, refused, tmp_path):
    scene = "many-throws"
    columns = flown(scene, tmp_path / "throws.csv")
    several = text(columns)
    assert f"{len(columns['t_s'])} rows of 24 throws" in correct(several, scene=scene)
    # Rows sorted by time, not by throw, and a column of another name.
    header, *rows = several.splitlines()
    rows.sort(key=lambda row: float(row.split(",")[1]))
    mixed = "\n".join([header.replace("member", "run"), *rows])
    correct(mixed, "--map", "run=throw", scene=scene)
    assert "a column `member`" in refused(mixed, scene=scene)
    assert "from 0 to 23" in refused("\n".join([header, f"24{rows[0][1:]}"]), scene=scene)
    assert "member = 0.5" in refused("\n".join([header, f"0.5{rows[0][1:]}"]), scene=scene)


# --- what is asked ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "names",
    [
        ["time", *POSE[1:]],
        ["Time (s)", *POSE[1:]],
        ["# t [sec]", "position.x (m)", "position.y (m)", "position.z (m)", "quat.w", "quat.x", "quat.y", "quat.z"],
        ["T", "X", "Y", "Z", "Q W", "Q X", "Q Y", "Q Z"],
        ["timestamp", "x", "y", "z", "orientation_w", "orientation_x", "orientation_y", "orientation_z"],
        ["-t", "pos 'x'", "pos $y", "`pos` z", "q=w", "qx", "qy", "qz"],
    ],
)
def test_foreign_names_are_asked_for_with_options_that_a_shell_takes(correct, refused, right, names):
    whole = text(right, dict(zip(names, POSE, strict=True)))
    told = refused(whole)
    options = told[re.search(r"'?--map", told).start() :].partition("; ")[0].strip()
    assert "\n" not in options
    echoed = subprocess.run(["bash", "-c", f"printf '%s\\n' {options}"], capture_output=True, text=True, check=True)
    assert echoed.stdout.splitlines() == shlex.split(options)
    correct(whole, *echoed.stdout.splitlines())


@pytest.mark.parametrize(
    ("header", "told"),
    [
        ("t_s,x_m,y_m,z_m,q0,q1,q2,q3", ("which is the scalar?", "--map q0=qw", "--map q3=qw")),
        ("t_s,x,y_m,z_m,qw,qx,qy,qz", ("in which unit?", "--map x=x_m", "cm")),
        ("t_s,x_m,y_m,z_m,roll,pitch,yaw", ("attitude", "'roll', 'pitch', 'yaw' are Euler angles")),
        ("t_s,x_m,y_m,z_m,Euler X (deg),Euler Y (deg),Euler Z (deg)", ("are Euler angles", "nearest, ", "--euler ")),
        ("t_s,x_m,y_m,z_m,Euler X,Euler Y", ("are angles, but not one for each",)),
        ("t_s,x_m,y_m,z_m,a", ("the attitude is missing",)),
        ("t_s,a,b", ("the pose is missing", "'a', 'b'", "--map COLUMN=NAME")),
        ("a,b,c", ("t_s", "--map COLUMN=NAME")),
        ("t_s,x_m,y_m,qw,qx,qy,qz", ("z missing", "x, y")),
        ("t_s,x_m,y_m,z_m,qw,qx,qy", ("qz missing",)),
        ("t_s,v0x_m,v0y_m", ("v0z missing",)),
        ("t_s,v8x_m,v8y_m,v8z_m", ("vertices 0 to 7",)),
        ("t_s,x_m,x_cm,y_m,z_m,qw,qx,qy,qz", ("both x", "--map x_cm=ignore")),
        ("t_s,t_s,x_m", ("two columns are called 't_s'",)),
        ("t_s,x_m,y_m,z_m,r00,r01,r02,r10,r11,r12,r20,r21,r22", ("--map r00=r11", "--map r22=r33")),
        ("0,0.3,1.2,0.7", ("--columns t_s,",)),
        (",,,", ("no header",)),
    ],
)
def test_what_a_header_does_not_say_is_asked(refused, header, told):
    line = refused(f"{header}\n" + ",".join("0" * len(header.split(","))) + "\n")
    assert all(words in line for words in told), line


@pytest.mark.parametrize(
    ("row", "cell", "told"),
    [
        (3, "nan", "line 5, x_m = 'nan': must be a finite number"),
        (3, "", "line 5, x_m = ''"),
        (3, "1_0", "line 5, x_m = '1_0'"),
        (3, "1e400", "line 5, x_m = '1e400'"),
        (3, "-1e200", "line 5, x_m = '-1e200'"),
        (3, "1;5", "line 5, x_m = '1;5'"),
        (3, "1,5", "line 5: 9 cells, but the header has 8"),
        (3, '"1', "line 2"),
        (3, "\0", "line 5: a null byte"),
    ],
)
def test_a_bad_cell_is_named_with_its_line(refused, right, row, cell, told):
    lines = [line.split(",") for line in text(right, POSE).splitlines()]
    lines[row + 1][1] = cell
    line = refused("\n".join(map(",".join, lines)))
    assert told in line or (cell == '"1' and "not CSV" in line)


def test_a_line_is_counted_across_blank_lines_and_far_into_a_file(refused):
    """The quick way of reading hands over to the slow one part by part: line numbers must not notice."""
    count = 40_000
    times = np.linspace(0, 2, count)
    lines = ["t_s,v0x_m,v0y_m,v0z_m", *(f"{t:.9f},0.123456789,0.123456789,0.123456789" for t in times)]
    bad = [*lines]
    bad[count - 7] = "1.5,0,0,none"
    assert f"line {count - 6}, v0z_m = 'none'" in refused("\n".join(bad))
    bad.insert(100, "")
    bad.insert(200, '0.00995,"0",0,0')
    # A line more, and one that is a copy of another instant: the first of what is wrong is named.
    assert "line 202, t = " in refused("\n".join(bad))
    del bad[200]
    assert f"line {count - 5}, v0z_m = 'none'" in refused("\n".join(bad))
    late = [*lines]
    late[count - 7] = late[count - 8]
    assert f"line {count - 6}, t = " in refused("\n".join(late))


def test_a_line_that_does_not_end(refused):
    endless = f"2.{'0' * 2_500_000}"
    assert "line 3: longer than 1000000 bytes" in refused(
        f"t_s,v0x_m,v0y_m,v0z_m\n0,1,2,3\n1,1,2,{endless}\n1.5,1,2,3\n"
    )


def test_times_beyond_the_scene_and_out_of_order(refused, right):
    rows = text(right, POSE)
    late = scaled(right, 1000, "t_s")
    told = refused(text(late, POSE))
    assert "two-hits lasts 2 s" in told
    assert "--map COLUMN=t_ms" in told or "--map t_s=t_ms" in told
    header, *lines = rows.splitlines()
    assert "line 3, t = " in refused("\n".join([header, *lines[::-1]]))
    assert "line 4" in refused("\n".join([header, *lines[:2], *lines[1:]]))
    assert "from 0 to" in refused("\n".join([header, f"-0.1{lines[0][lines[0].index(',') :]}"]))


def test_a_quaternion_of_zeros(refused, right):
    zero = right | {name: ["0"] * len(right["t_s"]) for name in POSE[4:]}
    assert "line 2: the quaternion is zero" in refused(text(zero, POSE))


def test_what_is_no_plain_file(tmp_path, capsys):
    pipe = tmp_path / "pipe.csv"
    os.mkfifo(pipe)
    for path, told in (
        (pipe, "not a plain file"),
        (tmp_path, "not a plain file"),
        (tmp_path / "none.csv", "no such file"),
        ("a" * 300, "cannot be read: File name too long"),
        ("a\0b", "null"),
    ):
        assert main(["grade", str(path), "--scene", SCENE]) == 2
        out, err = capsys.readouterr()
        assert out == ""
        assert err.count("\n") == 1
        assert told in err


def test_tables_are_written_all_or_none(tumble, right, tmp_path):
    (tmp_path / "good.csv").write_text(text(right, POSE))
    (tmp_path / "other.csv").write_text(text(right, ["t_s", *CORNERS]))
    (tmp_path / "bad.csv").write_text("t_s,a\n0,1\n")
    tables = tmp_path / "tables"

    def graded(file, **settings):
        done = tumble("grade", file, "--scene", SCENE, "-o", "tables", **settings)
        if done.returncode:
            assert done.returncode == 2
            assert len(done.stderr.splitlines()) == 1
        return done.returncode

    # A file may grow to 1000 bytes only: the last table cannot be written; a module's bytecode would be cut off there.
    full = {
        "preexec_fn": lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000)),
        "env": os.environ | {"PYTHONDONTWRITEBYTECODE": "1"},
    }
    assert graded("bad.csv") == 2
    assert not tables.exists()
    assert graded("good.csv", **full) == 2
    assert os.listdir(tables) == []
    assert graded("good.csv") == 0
    before = contents(tables)
    assert sorted(before) == [
        "conditions.csv",
        "datapackage.json",
        "diagnosis.csv",
        "grade-parts.csv",
        "grade-vertices.csv",
        "grade.csv",
    ]
    assert graded("bad.csv") == 2
    assert graded("other.csv", **full) == 2
    assert contents(tables) == before


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


# --- how numbers are printed ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("printed", [".4f", ".6g", ".5e"])
def test_digits_are_those_of_the_whole_file(tmp_path, printed):
    """A place that grows from 1 to 81 m: of fixed places its last digit stays, of six figures it grows later on."""
    path = tmp_path / "growing.csv"
    times = np.linspace(0, 2, 20 * LOOKED_AT)
    places = 1.0001 + 40 * times
    places[330] = 5000.1234  # alone: nowhere that is looked at
    lines = (f"{t!r},{x:{printed}},{x:{printed}},{x:{printed}}" for t, x in zip(times.tolist(), places, strict=True))
    path.write_text("\n".join(["t_s,v0x_m,v0y_m,v0z_m", *lines]))
    halves = Trajectory(path, read_scene(SCENE), {}).half_digits("v0x", places)
    figures = 0.5 * 10.0 ** (np.floor(np.log10(places)) - 5)
    np.testing.assert_allclose(halves, np.full(len(times), 0.5e-4) if printed == ".4f" else figures, rtol=1e-9)
