"""Parsers against damaged files: whatever is in one, an object comes back or one line, and soon.

The tests give each parser a few; `python tests/support/fuzz.py 100000 [PARSER ...]` gives each that many.  Every file
has a number, from which all of it follows: `python tests/support/fuzz.py 1 records 1234` makes number 1234 again.
"""

import json
import os
import random
import re
import signal
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass, field, replace
from io import StringIO
from pathlib import Path
from unittest.mock import patch
from xml.etree import ElementTree

import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

from tumble.__main__ import main as tumble
from tumble.compare.check.changes import compare_records
from tumble.compare.check.junit import junit
from tumble.compare.check.markdown import summary
from tumble.compare.check.record import BadRecord, Record, read_record, texts
from tumble.compare.check.schemas import CELLS, QUESTIONS, TIMES, CellRow, QuestionRow, TimeRow
from tumble.compare.check.tolerances import BadTolerance, Tolerances, read_tolerances
from tumble.compare.grade.measure.errors import measure
from tumble.compare.grade.model.reference import Reference
from tumble.compare.grade.read.columns import BadTrajectory
from tumble.compare.grade.read.conventions import Conventions
from tumble.compare.grade.read.formats import as_csv
from tumble.compare.grade.read.mapping import mapping_file, mapping_of
from tumble.compare.grade.read.trajectory import Trajectory
from tumble.compare.run.engines.registry import BadEngine, Finding, engine_info, load
from tumble.compare.run.flight import Probe
from tumble.compare.run.flight import Trajectory as Flight
from tumble.compare.run.process import message
from tumble.compare.run.process.message import PREFIX, Malformed, lengths, unpacked
from tumble.compare.run.status import Failure, Status
from tumble.compare.run.timing.timer import Sample
from tumble.compare.tables.files import write_folder
from tumble.compare.tables.frames import frame
from tumble.compare.tables.shared import ENGINES, EngineRow
from tumble.scenarios.frames import rotation_matrix, vertices
from tumble.scenarios.read import BadScene, read_scene
from tumble.scenarios.surface import read_surface

ROOT = Path(__file__).parents[2]
# What takes longer hangs: a parser takes milliseconds, but a search for what is wrong many seconds where others work.
LONGEST_S = 60
TOKENS = (
    b"nan", b"-inf", b"1e400", b"-0.0", b"0", b"-1", b"5e-324", b"9" * 400, b"0x" + b"f" * 60, b"true", b"[", b"]]",
    b"{", b"}", b'"', b"'''", b"=", b",", b"\n", b"\r", b"\t", b"\x00", b"\x1b[31m", b"\xff", b"\xef\xbb\xbf",
    "\u202e".encode(), b"#", b".", b"a.b.c", b"[[impulse]]", b"[floor]", b"kept", b"ok", b"flagged: x",
    b"skipped: ", b"=1+1", b"-",
)  # fmt: skip


def damaged(rng: random.Random, seeds: list[bytes], others: list[bytes]) -> bytes:
    """Return one of the seeds with other numbers in it, or pieces cut out, put in, doubled, or taken from others."""
    text = rng.choice(seeds)
    for _ in range(rng.randint(1, 3)):
        numbers = [match.span() for match in re.finditer(rb"\d[\d.]*", text)]
        if numbers and rng.random() < 0.5:
            begin, end = rng.choice(numbers)
            piece = rng.choice((number(rng), rng.choice(TOKENS[:8])))
        else:
            begin = rng.randint(0, len(text))
            end = min(len(text), begin + rng.choice((0, 1, 2, 5, 40)))
            other = rng.choice(others)
            cut = rng.randint(0, len(other))
            own = text[begin:end] * 2
            piece = rng.choice((b"", rng.choice(TOKENS), bytes([rng.randrange(256)]), own, other[cut : cut + 40]))
        text = text[:begin] + piece + text[end:]
    return text


def number(rng: random.Random) -> bytes:
    """Return a number of any size, more often of a person's."""
    size = rng.choice((rng.uniform(-3, 3), rng.uniform(-320, 300)))
    return f"{rng.choice((1, 1, -1)) * 10.0**size:.{rng.randint(1, 17)}g}".encode()


class HangsError(BaseException):
    """What no parser may catch: a TimeoutError is an OSError, and those are the user's."""


@contextmanager
def in_time() -> Iterator[None]:
    """Raise HangsError where what is done inside does not end."""

    def too_long(*_: object) -> None:
        raise HangsError(f"took more than {LONGEST_S} s")

    before = signal.signal(signal.SIGALRM, too_long)
    signal.alarm(LONGEST_S)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


@dataclass
class Outcome:
    """What became of files: how many were read and how many refused, and what else happened, each with its number."""

    found: int = 0
    refused: int = 0
    lost: list[str] = field(default_factory=list)


def outcomes(read: Callable[[random.Random], object], refusal: type[Exception], name: str, numbers: range) -> Outcome:
    """Return what became of the files with these numbers: whatever is neither an object nor one line is lost."""
    outcome, rng = Outcome(), random.Random()
    for number in numbers:
        rng.seed(f"{name} {number}")
        try:
            with in_time(), warnings.catch_warnings():
                warnings.simplefilter("error")
                try:
                    read(rng)
                    outcome.found += 1
                except refusal as error:
                    outcome.refused += 1
                    if not str(error).isprintable():
                        raise AssertionError(f"not one line: {error!r}") from error
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            outcome.lost.append(f"{name} {number}: {type(error).__name__}: {' '.join(str(error).split())[:200]}")
    return outcome


def scenes(folder: Path, numbers: range) -> Outcome:
    """Fuzz scene files."""
    file = folder / "scene.toml"
    seeds, bad = (
        [path.read_bytes() for path in sorted((ROOT / where).glob("*.toml"))]
        for where in ("scenarios/catalogue", "tests/bad")
    )

    def read(rng: random.Random) -> None:
        file.write_bytes(damaged(rng, seeds, bad))
        read_scene(str(file))

    return outcomes(read, BadScene, "scenes", numbers)


def tolerances(folder: Path, numbers: range) -> Outcome:
    """Fuzz tolerance files."""
    file = folder / "tolerances.toml"
    seeds = [b"max_error_m = 0.1\ntime_ratio = 2\n", b"energy_drift = 1e-3 # a word\nattitude_order = 0.5\n"]

    def read(rng: random.Random) -> None:
        file.write_bytes(damaged(rng, seeds, seeds))
        read_tolerances(str(file))

    return outcomes(read, BadTolerance, "tolerances", numbers)


BASE = Record(
    ("s", "./t.toml"),
    ("e", "./mine.py:m"),
    "tumble check",
    frame(
        QUESTIONS,
        (
            QuestionRow(
                scene="s",
                step_s=0.5,
                samples=5,
                truth="exact",
                resolution_m=1e-15,
                size_m=0.3,
                x_m=1.0,
                y_m=2.0,
                z_m=3.0,
            ),
            QuestionRow(
                scene="t",
                step_s=0.5,
                samples=5,
                truth="none",
                resolution_m=None,
                size_m=1.0,
                x_m=None,
                y_m=None,
                z_m=None,
            ),
        ),
    ),
    frame(
        ENGINES,
        (
            EngineRow(
                engine="e",
                status="ok",
                why="",
                version="1",
                precision="double",
                methods="m",
                features="",
                switched_off="nothing",
            ),
            EngineRow(
                engine="mine",
                status="ok",
                why="",
                version="1",
                precision="double",
                methods="m",
                features="",
                switched_off="",
            ),
        ),
    ),
    frame(
        CELLS,
        (
            CellRow(
                scene="s",
                engine="e",
                method="m",
                steps=99,
                status="ok",
                why="",
                max_error_m=1e-3,
                rms_error_m=5e-4,
                final_error_m=9e-4,
                resolution_m=1e-15,
                rounding_m=1e-13,
                energy_drift=-1e-3,
                momentum_drift=1e-14,
                angular_momentum_drift=2e-3,
                attitude_order=2.0,
                translation_order=1.0,
                spin_energy="decays",
            ),
            CellRow(
                scene="s",
                engine="mine",
                method="m",
                steps=99,
                status="flagged",
                why="off by 3 m",
                max_error_m=1e-3,
                rms_error_m=5e-4,
                final_error_m=9e-4,
                resolution_m=1e-15,
                rounding_m=1e-13,
                energy_drift=0.0,
                momentum_drift=0.0,
                angular_momentum_drift=0.0,
            ),
            CellRow(scene="t", engine="e", method="m", steps=None, status="skipped", why="has no floor"),
        ),
    ),
    frame(
        TIMES,
        (
            TimeRow(scene="s", engine="e", method="m", reference="tumble:rk4", time_ratio=1.5),
            TimeRow(scene="s", engine="mine", method="m", reference="tumble:rk4", time_ratio=None),
        ),
    ),
)


# Of the records that are read one in so many is held against the undamaged one too, which takes ten times as long.
HELD = 8


def records(folder: Path, numbers: range) -> Outcome:
    """Fuzz baselines; of what is read some is held against the undamaged one or that against it, and all is said."""
    whole = {name: text.encode() for name, text in texts(BASE).items()}
    write_folder(folder, texts(BASE))

    def read(rng: random.Random) -> None:
        name = rng.choice(list(whole))
        (folder / name).write_bytes(damaged(rng, [whole[name]], list(whole.values())))
        try:
            record = read_record(folder)
        finally:
            (folder / name).write_bytes(whole[name])
        if rng.randrange(HELD):
            return
        outcome = compare_records(*rng.sample((BASE, record), 2), Tolerances())  # pyright: ignore[reportCallIssue]
        assert summary(outcome, ("--baseline", "b")).startswith("## tumble check: ")
        ElementTree.fromstring(junit(outcome, ("--baseline", "b")))
        # What was read is what is written: no cell is taken for something else.
        assert texts(replace(record, command=BASE.command)).keys() == whole.keys()

    return outcomes(read, BadRecord, "records", numbers)


@dataclass(frozen=True)
class Foreign:
    """A trajectory of some program, and how its user has it graded."""

    scene: str
    header: list[str]
    rows: list[list[str]]
    separator: str = ","
    end: str = "\n"
    mark: bytes = b""
    map_file: bytes = b""
    options: tuple[str, ...] = ()

    def text(self) -> bytes:
        """Return the file; with no header of its own it begins with the rows."""
        written = (self.header, *self.rows) if self.header else self.rows
        lines = (self.separator.join(cells) + self.end for cells in written)
        return self.mark + "".join(lines).encode()


def foreign() -> list[Foreign]:
    """Return one good file of every kind that is read."""
    scene = read_scene("two-hits")
    times = np.linspace(0, scene.duration, 12)
    states = Reference(scene).states(0, times)
    x, q = states[:, 0:3], states[:, 3:7]
    points = vertices(states, scene.body.points).reshape(len(times), -1)
    pose = ["t_s", "x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"]
    swift = [*pose, "vx_m_s", "vy_m_s", "vz_m_s", "wx_rad_s", "wy_rad_s", "wz_rad_s"]
    matrix = [*pose[:4], *(f"r{row}{column}" for row in "123" for column in "123")]
    corners = ["t_s", *(f"v{number}{axis}_m" for number in range(8) for axis in "xyz")]

    def rows(*columns: np.ndarray, form: str = ".9g") -> list[list[str]]:
        return [[f"{value:{form}}" for value in row] for row in np.column_stack((times, *columns))]

    fitted_pose = rows(x, q)
    comma = [[cell.replace(".", ",") for cell in row] for row in fitted_pose]
    spoken = [[row[0], '"a, ""b"""', *row[1:], "text"] for row in fitted_pose]
    throws = [[throw, *row] for throw in "01" for row in fitted_pose]
    named = ["Time (ms)", "Pos X", "Pos Y", "Pos Z", "q0", "q1", "q2", "q3"]
    names = ["t_ms", "x_cm", "y_cm", "z_cm", "qx", "qy", "qz", "qw"]
    said = dict(zip(named, names, strict=True))
    toml = "[columns]\n" + "".join(f"{column!r} = {name!r}\n" for column, name in said.items())
    maps = tuple(word for column, name in said.items() for word in ("--map", f"{column}={name}"))
    other = rows(x * 100, q[:, [1, 2, 3, 0]])
    other = [[f"{float(row[0]) * 1000:g}", *row[1:]] for row in other]
    angles = Rotation.from_quat(q[:, [1, 2, 3, 0]]).as_euler("YXZ", degrees=True)[:, [1, 0, 2]]
    turned = [*pose[:4], "rx_deg", "ry_deg", "rz_deg"]
    spoken_json = [[json.dumps(dict(zip(pose, map(float, row), strict=True)))] for row in fitted_pose]
    nested = [
        [json.dumps({"t_s": float(row[0]), "p": [float(cell) for cell in row[1:4]], "q": row[4:]})]
        for row in fitted_pose
    ]
    return [
        Foreign("two-hits", [], fitted_pose, options=("--columns", ",".join(pose))),
        Foreign("two-hits", [], fitted_pose, "  ", options=("--columns", ",".join(pose), "--start", "0.0")),
        Foreign("two-hits", pose, fitted_pose, " ", mark=b"# made by hand\n", options=("--axes", "x,y,z")),
        Foreign("two-hits", turned, rows(x, angles), options=("--euler", "unity")),
        Foreign("two-hits", [], spoken_json),
        Foreign("two-hits", [], nested, options=("--map", "p_x=x_m")),
        Foreign("two-hits", pose, fitted_pose),
        Foreign("two-hits", swift, rows(x, q, states[:, 7:13], form=".17g")),
        Foreign("two-hits", matrix, rows(x, rotation_matrix(q).reshape(-1, 9))),
        Foreign("two-hits", corners, rows(points)),
        Foreign("two-hits", corners[:4], rows(points[:, :3], form=".4f"), "\t", "\r\n", b"\xef\xbb\xbf"),
        Foreign("two-hits", [*pose, *corners[1:]], rows(x, q, points), options=("--by", "pose")),
        Foreign("two-hits", pose, comma, ";", options=("--decimal", ",")),
        Foreign("two-hits", [pose[0], "note", *pose[1:], "x"], spoken, options=("--map", "x=ignore")),
        Foreign("two-hits", named, other, options=maps),
        Foreign("two-hits", named, other, map_file=toml.encode()),
        Foreign("many-throws", ["throw", *pose], throws),
    ]


NAMES = (
    "t_s", "t_ms", "t", "Time", "x_m", "x_cm", "x_in", "qw", "q0", "r11", "r00", "v0x_m", "v7z_mm", "v8x_m", "v00x_m",
    "v999999x_m", "vx_m_s", "wz_rpm", "wx", "throw", "roll", "ignore", "", "Pos X (cm)", "omega.z [deg/s]", "a=b", "-x",
    "nan", "'", "q\u0301", "x" * 300,
)  # fmt: skip
CELLS = (
    "", " ", "nan", "inf", "-inf", "1e400", "1e308", "-1e99", "0e400", "1e-400", "5e-324", "9" * 400, "1_0", "0x1p3",
    "1,5", "1.5.2", '"1"', '"', '""', "1e" + "9" * 5000, "1d5", "-0", "--1", "\u0661", "\x1b[31m", "\x00", "true",
    "None", "=1+1", "\ufeff1", "\u20281", "1\r", "1\n",
)  # fmt: skip


def mishandled(rng: random.Random, good: Foreign) -> Foreign:
    """Return a file as somebody else's program, spreadsheet or hand might have left it."""
    header, rows = list(good.header), [list(row) for row in good.rows if row]
    if not header or not rows:
        return good
    match rng.randrange(12):
        case 0:
            header[rng.randrange(len(header))] = rng.choice((*NAMES, *good.header))
        case 1:
            order = rng.sample(range(len(header)), rng.randint(1, len(header)))
            header, *rows = ([row[place] for place in order if place < len(row)] for row in (header, *rows))
        case 2:
            for _ in range(rng.randint(1, 3)):
                row = rng.choice(rows)
                row[rng.randrange(len(row))] = rng.choice(CELLS)
        case 3:
            row = rng.choice(rows)
            row[rng.randrange(len(row))] = number(rng).decode()
        case 4:
            place = rng.randrange(len(header))
            factor = 10 ** rng.uniform(-3, 3)
            for row in rows:
                row[place : place + 1] = [scaled(cell, factor) for cell in row[place : place + 1]]
        case 5:
            rng.shuffle(rows)
        case 6:
            rows.insert(rng.randint(0, len(rows)), rng.choice((list(rng.choice(rows)), [], [""] * len(header))))
        case 7:
            rows = rows[: rng.randint(0, 3)]
        case 8:
            row = rng.choice((header, *rows))
            row[rng.randrange(len(row)) :] = rng.choice(([], ["1", "2"], [*row, ""]))
        case 9:
            return replace(good, separator=rng.choice((",", ";", "\t", " ", "|", ", ", ",\t", ",,")))
        case 10:
            return replace(good, end=rng.choice(("\r", "\r\n", "\n\n", "", ",\n", ";\r\n", "\u2028", "\x0b\n", " \n")))
        case _:
            return replace(good, options=(*good.options, *rng.choice(OPTIONS)))
    return replace(good, header=header, rows=rows)


def scaled(cell: str, factor: float) -> str:
    """Return a cell in some other unit."""
    try:
        return f"{float(cell.replace(',', '.')) * factor:.6g}"
    except ValueError:
        return cell


OPTIONS = (
    ("--by", "vertices"), ("--by", "matrix"), ("--decimal", ","), ("--map", "x_m=y_m"), ("--map", "qw=qx"),
    ("--map", "t_s=t_ms"), ("--map", "=t_s"), ("--map", "t_s"), ("--map", "nothing=t_s"), ("--map", "x_m=ignore"),
    ("--euler", "zxy"), ("--euler", "extrinsic-"), ("--axes", "unity"), ("--axes", "x,y"), ("--axes", "z,-x,y"),
    ("--start", "0.5"), ("--start", "-1e9"), ("--columns", "t_s,x_m"), ("--columns", "x"),
    ("--map", "t_s=t_s", "--map", "t_s=t_s"), ("--map-file", "/nowhere.toml"), ("--map", "x_m=v0x_km"),
)  # fmt: skip
# Of the trajectories that are read one in so many goes through the whole command: its search takes many seconds.
WHOLLY = 4000


def precise(_reference: Reference, _throw: int, times: np.ndarray, *_: object) -> np.ndarray:
    """Return the resolution of a reference that is as good as exact [m], (T,)."""
    return np.full(len(times), 1e-12)


def trajectories(folder: Path, numbers: range) -> Outcome:
    """Fuzz trajectories of other programs, with what their users say of them; each that is read is measured too."""
    file, beside, tables = folder / "f.csv", folder / "f.csv.toml", folder / "tables"
    seeds = foreign()
    texts = [seed.text() for seed in seeds]
    scenes = {name: read_scene(name) for name in ("two-hits", "many-throws")}
    # Compiles what a search takes, before the clock runs.
    wrong = replace(seeds[0], header=[*seeds[0].header[:4], "qx", "qy", "qz", "qw"])
    file.write_bytes(wrong.text())
    graded(file, wrong, tables)

    def read(rng: random.Random) -> None:
        each = rng.choice(seeds)
        for _ in range(rng.randint(0, 2)):
            each = mishandled(rng, each)
        text = each.text()
        if rng.random() < 0.4:
            text = damaged(rng, [text], texts)
        if rng.random() < 0.02:
            text = text.decode(errors="replace").encode(rng.choice(("utf-16", "utf-8-sig", "utf-32")))
        file.write_bytes(text)
        beside.unlink(missing_ok=True)
        if each.map_file:
            beside.write_bytes(damaged(rng, [each.map_file], [each.map_file]) if rng.random() < 0.5 else each.map_file)
        pairs = [word for option, word in zip(each.options[::2], each.options[1::2], strict=True) if option == "--map"]
        chosen = dict(zip(each.options[::2], each.options[1::2], strict=True))
        by, decimal = chosen.get("--by"), chosen.get("--decimal", ".")
        columns = chosen["--columns"].split(",") if "--columns" in chosen else []
        start = float(chosen["--start"]) if "--start" in chosen else None
        mapping = mapping_file(beside) if each.map_file else {}
        scene = scenes[each.scene]
        # The truth takes 0.2 s and knows nothing of a file but its times: it is left to the whole command.
        with patch.object(Reference, "resolution", precise), ExitStack() as drafts:
            path, name, first_line = as_csv(str(file), columns, decimal, drafts)
            reading = Conventions(chosen.get("--euler"), chosen.get("--axes"), start, name, first_line)
            found = measure(Trajectory(path, scene, mapping | mapping_of(pairs), by, decimal, reading), scene)
        assert np.isfinite((found.worst_m, found.rms_m, found.final_m, found.half_m)).all(), found
        if rng.randrange(WHOLLY) == 0:
            graded(file, each, tables)

    return outcomes(read, BadTrajectory, "trajectories", numbers)


def graded(file: Path, each: Foreign, tables: Path) -> None:
    """Have the command grade a file; whatever it says, its tables are there whole or not at all."""
    said, told = StringIO(), StringIO()
    with redirect_stdout(said), redirect_stderr(told):
        code = tumble(["grade", str(file), "--scene", each.scene, *each.options, "-o", str(tables)])
    assert code in (0, 2), told.getvalue()
    left = sorted(os.listdir(tables)) if tables.exists() else []
    assert left in (
        [],
        [
            "conditions.csv",
            "diagnosis.csv",
            "explanations.csv",
            "grade-parts.csv",
            "grade-vertices.csv",
            "grade.csv",
        ],
    ), left
    assert code == 2 or "error: largest" in said.getvalue(), said.getvalue()


def meshes(folder: Path, numbers: range) -> Outcome:
    """Fuzz mesh files, in text and in bytes, of each format that is read."""
    seeds = {".stl": [(ROOT / "scenarios/catalogue/mesh_die.stl").read_bytes()], ".ply": [], ".off": []}
    solid = trimesh.load_mesh(ROOT / "scenarios/catalogue/mesh_die.stl")
    for ending in seeds:
        seeds[ending].append(solid.export(file_type=ending[1:]))
    seeds = {
        ending: [each.encode() if isinstance(each, str) else each for each in texts] for ending, texts in seeds.items()
    }

    def read(rng: random.Random) -> None:
        ending = rng.choice(list(seeds))
        (folder / f"mesh{ending}").write_bytes(damaged(rng, seeds[ending], seeds[ending]))
        read_surface(folder / f"mesh{ending}")

    return outcomes(read, ValueError, "meshes", numbers)


def messages(folder: Path, numbers: range) -> Outcome:
    """Fuzz what the process of an engine sends: flights, samples, failures and words."""
    scene = read_scene("two-hits")
    rows = len(scene.rows)
    states, points = np.ones((rows, 1, 13)), np.ones((rows, 1, *scene.body.points.shape))
    probe = Probe(states[:2, 0], states[:2, 0], 1.0)
    flight = Flight(scene.rows, states, points, 7, 1.0, (Finding("other", "x"),), probe=probe)
    answers = (
        (Flight | Failure, flight),
        (Flight | Failure, Failure(Status.TIMEOUT, "")),
        (Sample | Failure, Sample((1.0,) * 4, (0.0,) * 4)),
        (str | Failure, "how"),
    )
    hints, whole = zip(*((hint, b"".join(map(bytes, message.frame(answer)))) for hint, answer in answers), strict=True)

    def read(rng: random.Random) -> None:
        place = rng.randrange(len(whole))
        data = whole[place]
        head, _ = lengths(data[: PREFIX.size])
        if rng.random() < 0.1:
            lengths(damaged(rng, [data], list(whole))[: PREFIX.size].ljust(PREFIX.size))
        parts = [data[PREFIX.size : PREFIX.size + head], data[PREFIX.size + head :]]
        hit = rng.random() < 0.7
        parts[not hit] = damaged(rng, [parts[not hit]], parts)
        unpacked(hints[place], *parts)

    return outcomes(read, Malformed, "messages", numbers)


def programs(folder: Path, numbers: range) -> Outcome:
    """Fuzz the files that say how a program is started; none is."""
    file = folder / "mine.toml"
    good = (
        b'command = ["sh", "-c", "exit"]\nmethods = ["rk4", "euler"]\nfeatures = ["gravity"]\nprecision = "double"\n'
        b'version = "1.2"\nswitched_off = []\n',
        b'command = ["true"]\nmethods = ["m"]\nfeatures = []\nprecision = "single"\nlargest_turn = 0.5\n'
        b'[schemes]\nm = "rk4"\n[exempt]\ngravity = "none"\n',
    )

    def read(rng: random.Random) -> None:
        file.write_bytes(damaged(rng, list(good), list(good)))
        engine_info(str(file), load(str(file)))

    return outcomes(read, BadEngine, "programs", numbers)


PARSERS = {
    "scenes": scenes,
    "tolerances": tolerances,
    "records": records,
    "trajectories": trajectories,
    "meshes": meshes,
    "messages": messages,
    "programs": programs,
}
# Of all that is tried: what people write most, and strangers send, most often.
SHARES = {
    "scenes": 0.25, "tolerances": 0.1, "records": 0.05, "trajectories": 0.1, "meshes": 0.15, "messages": 0.25,
    "programs": 0.1,
}  # fmt: skip
# Files are written here where there is such a folder: in memory, a disk does nothing for the test.
MEMORY = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None


def fuzz(name: str, numbers: range) -> Outcome:
    """Give a parser the files with these numbers."""
    with tempfile.TemporaryDirectory(dir=MEMORY) as folder:
        return PARSERS[name](Path(folder), numbers)


def main(count: int, name: str = "", first: int = 0) -> None:
    """Give each parser, or the one named, so many damaged files from a number on and say what became of them."""
    lost = []
    for each in [name] if name else PARSERS:
        begin, outcome = time.monotonic(), fuzz(each, range(first, first + count))
        lost += outcome.lost
        took = f"{time.monotonic() - begin:.0f} s"
        print(f"{each}: {outcome.found} read, {outcome.refused} refused in one line, {len(outcome.lost)} lost, {took}")
    sys.exit("\n".join(lost) or 0)


if __name__ == "__main__":
    main(int(sys.argv[1]), *sys.argv[2:3], *map(int, sys.argv[3:4]))
