"""Regression checks: what is worse is named and fails, what is not does not, and no record is misread."""

import ast
import csv
import io
import logging
import math
import os
import re
import shlex
import shutil
import subprocess
import sys
from dataclasses import fields, replace
from pathlib import Path
from xml.etree import ElementTree

import in_process
import numpy as np
import pandas as pd
import pytest
import yaml
from patience import PATIENCE_S

from tumble.compare.check import study
from tumble.compare.check.changes import Outcome, compare_records, within
from tumble.compare.check.junit import junit
from tumble.compare.check.markdown import MOST_CHARACTERS, summary
from tumble.compare.check.record import FORMAT, BadRecord, Record, read_record, texts
from tumble.compare.check.schemas import CELLS, QUESTIONS, TIMES, CellRow, QuestionRow, TimeRow
from tumble.compare.check.study import Measuring, accept_record
from tumble.compare.check.times import nearer
from tumble.compare.check.tolerances import BadTolerance, Tolerances, read_tolerances
from tumble.compare.check.words import behaviours
from tumble.compare.judge.ladder import one_order
from tumble.compare.judge.trend import trend
from tumble.compare.run.progress import no_display
from tumble.compare.tables.files import write_folder
from tumble.compare.tables.frames import frame
from tumble.compare.tables.frames import rows as rows_of
from tumble.compare.tables.shared import ENGINES, EngineRow
from tumble.solver.registry import METHODS

ROOT = Path(__file__).parents[3]
MINE = (ROOT / "tests/plugins/mine.py").read_text(encoding="utf-8")
AGAINST = ("--baseline", "base")

# A triaxial box that is struck and falls: short, so that a pure Python engine is quick at every step of the ladder.
SPIN = """title = "a"
duration = 0.2
samples = 4
step = 0.005
gravity = [0.0, -9.81, 0.0]
[body]
shape = "box"
size = [0.4, 0.15, 0.1]
mass = 2.4
angular_velocity = [0.3, 9.0, 0.4]
[[impulse]]
value = [0.1, 0.9, 0.2]
vertex = 0
"""

CELL = CellRow(
    scene="s",
    engine="e",
    method="m",
    steps=100,
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
)
QUESTION = QuestionRow(
    scene="s", step_s=0.5, samples=5, truth="exact", resolution_m=1e-15, size_m=0.3, x_m=1.0, y_m=2.0, z_m=3.0
)
ENGINE = EngineRow(
    engine="e", status="ok", why="", version="1.0", precision="double", methods="m", features="gravity", switched_off=""
)
BASE = Record(
    ("s",),
    ("e",),
    "tumble check s -e e --accept -o base",
    frame(QUESTIONS, [QUESTION]),
    frame(ENGINES, [ENGINE]),
    frame(CELLS, [CELL]),
)
TABLES = {"questions": QUESTIONS, "engines": ENGINES, "cells": CELLS, "times": TIMES}


def of(**tables) -> Record:
    """Return a record with these rows in its tables, by their names."""
    return replace(BASE, **{name: frame(TABLES[name], rows) for name, rows in tables.items()})


def told(old: Record | CellRow, new: Record | CellRow, tolerances: Tolerances = Tolerances()) -> Outcome:  # noqa: B008
    """Hold two records, or two that have only these cells, against each other."""
    old, new = (of(cells=[each]) if isinstance(each, CellRow) else each for each in (old, new))
    return compare_records(old, new, tolerances)


def verdicts(old: CellRow, new: CellRow, tolerances: Tolerances = Tolerances()) -> dict[str, str]:  # noqa: B008
    return {change.column: change.verdict for change in told(old, new, tolerances).changes}


def rows(path: Path) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(path.read_text(encoding="utf-8"))))


# What counts as a change.


def test_the_same_is_no_change():
    outcome = told(BASE, BASE)
    assert (outcome.changes, outcome.unchanged, outcome.failed) == ((), 1, False)


@pytest.mark.parametrize("column", ["max_error_m", "rms_error_m", "final_error_m", "angular_momentum_drift"])
def test_a_column_has_its_tolerance_to_both_sides(column):
    value = getattr(CELL, column)
    assert verdicts(CELL, replace(CELL, **{column: 1.04 * value})) == {}
    assert verdicts(CELL, replace(CELL, **{column: 1.06 * value})) == {column: "worse"}
    assert verdicts(CELL, replace(CELL, **{column: value / 1.04})) == {}
    assert verdicts(CELL, replace(CELL, **{column: value / 1.06})) == {column: "better"}
    assert verdicts(CELL, replace(CELL, **{column: 1.06 * value}), Tolerances(**{column: 0.07})) == {}


def test_a_drift_counts_by_its_size():
    assert verdicts(CELL, replace(CELL, energy_drift=1e-3)) == {}
    assert verdicts(CELL, replace(CELL, energy_drift=-2e-3)) == {"energy_drift": "worse"}


def test_errors_below_the_limit_compare_as_the_limit():
    exact = replace(CELL, max_error_m=1e-17, resolution_m=1e-12, rounding_m=0.0)
    assert verdicts(exact, replace(exact, max_error_m=9e-13)) == {}
    assert verdicts(exact, replace(exact, max_error_m=1.1e-12)) == {"max_error_m": "worse"}


def test_what_rounding_explains_is_no_change():
    tiny = replace(CELL, max_error_m=1e-13, rounding_m=2e-13)
    assert verdicts(tiny, replace(tiny, max_error_m=2.9e-13)) == {}
    assert verdicts(tiny, replace(tiny, max_error_m=3.1e-13)) == {"max_error_m": "worse"}
    # 100 steps round a drift by 100 x 2^-52 = 2.2e-14, and the body is 0.3 m: 1e-13 m are 3.3e-13 of it.
    assert verdicts(CELL, replace(CELL, momentum_drift=3e-13)) == {}
    assert verdicts(CELL, replace(CELL, momentum_drift=4e-13)) == {"momentum_drift": "worse"}


def test_without_bound_is_worse_than_any():
    lost = replace(CELL, status="diverged", why="at 1 s", max_error_m=math.inf, final_error_m=math.inf)
    assert verdicts(CELL, lost) == {"status": "worse", "max_error_m": "worse", "final_error_m": "worse"}
    assert verdicts(lost, lost) == {}
    assert verdicts(lost, CELL) == {"status": "better", "max_error_m": "better", "final_error_m": "better"}


@pytest.mark.parametrize(
    ("old", "new", "verdict"),
    [
        ("ok", "flagged: clamped", "worse"),
        ("flagged: clamped", "diverged at 2 s", "worse"),
        ("ok", "skipped: no floor", "worse"),
        ("diverged at 2 s", "skipped: no floor", "worse"),
        ("skipped: no floor", "crashed: SIGSEGV", "worse"),
        ("timeout", "missing: no wheel", "changed"),
        ("crashed: SIGSEGV", "ok", "better"),
        ("flagged: off by 3.2e-05 of it", "flagged: off by 4.2e-05 of it", None),
        ("flagged: clamped at 1 s", "flagged: clamped at 1 s; lost torque", "worse"),
        ("flagged: clamped; lost torque", "flagged: clamped", "better"),
        ("diverged at 2 s", "diverged at 2.1 s", None),
        ("crashed: A", "crashed: B", None),
    ],
)
def test_statuses_have_an_order(old, new, verdict):
    columns = (zip(("status", "why"), each.replace(":", "", 1).split(" ", 1), strict=False) for each in (old, new))
    found = verdicts(*(replace(CELL, **dict(each)) for each in columns))
    assert found.get("status") == verdict


def test_a_cell_without_a_flight_says_so_and_no_more():
    crashed = CellRow(scene="s", engine="e", method="m", steps=None, status="crashed", why="SIGSEGV")
    assert verdicts(CELL, crashed) == {"status": "worse"}
    assert verdicts(crashed, CELL) == {"status": "better"}


@pytest.mark.parametrize(
    ("old", "new", "verdict"),
    [
        ("conserved", "decays", "worse"),
        ("oscillates", "grows", "worse"),
        ("grows", "decays", "changed"),
        ("decays", "conserved", "better"),
        ("", "grows", None),
    ],
)
def test_energies_have_an_order(old, new, verdict):
    found = verdicts(replace(CELL, spin_energy=old), replace(CELL, spin_energy=new))
    assert found.get("spin_energy") == verdict


def test_orders_of_attitude_and_translation_are_told_apart_and_by_name():
    better = told(CELL, replace(CELL, attitude_order=4.1))
    (said,) = behaviours(better.changes)
    assert f"{said.contestant} {said.words}" == "e:m attitude order 2 -> 4"
    assert said.verdict == "better"
    worse = told(replace(CELL, translation_order=1.9), CELL)
    (said,) = behaviours(worse.changes)
    assert f"{said.contestant} {said.words}" == "e:m translation order 2 -> 1"
    assert worse.failed
    assert verdicts(CELL, replace(CELL, attitude_order=1.8)) == {}
    assert verdicts(CELL, replace(CELL, attitude_order=None)) == {"attitude_order": "changed"}
    (said,) = behaviours(told(CELL, replace(CELL, attitude_order=1.7)).changes)
    assert said.words == "attitude order 2 -> 1.7", "called by one number, and not one"


def test_gone_fails_and_new_does_not():
    other = replace(CELL, method="n")
    assert [change.verdict for change in told(CELL, other).changes] == ["gone", "new"]
    gone = told(of(cells=[CELL, other]), BASE)
    assert gone.failed
    assert gone.unchanged == 1
    assert not told(BASE, of(cells=[CELL, other])).failed


def test_a_missing_engine_is_missing_by_every_method():
    missing = CellRow(scene="s", engine="e", method="", steps=None, status="missing", why="no module named e")
    two = of(cells=[CELL, replace(CELL, method="n")])
    lost = told(two, missing)
    assert [(change.method, change.verdict, change.column) for change in lost.changes] == [
        ("m", "worse", "status"),
        ("n", "worse", "status"),
    ]
    found = told(of(cells=[missing]), two)
    assert [change.verdict for change in found.changes] == ["new", "new"]


@pytest.mark.parametrize("changed", [{"step_s": 0.02}, {"samples": 6}, {"x_m": 1.0 + 1e-9}])
def test_another_question_is_not_compared_and_fails(changed):
    new = of(questions=[replace(QUESTION, **changed)], cells=[replace(CELL, max_error_m=9.0)])
    outcome = told(BASE, new)
    assert [change.verdict for change in outcome.changes] == ["incomparable"]
    assert outcome.failed
    assert outcome.unchanged == 0


def test_the_truths_own_rounding_is_the_same_question():
    moved = replace(QUESTION, x_m=1.0 + 1e-10)  # a billionth of 0.3 m
    assert told(BASE, of(questions=[moved])).changes == ()


def test_what_was_not_asked_for_is_not_gone():
    other = replace(CELL, engine="f")
    both = of(cells=[CELL, other])

    def kept(record: Record, *asked) -> list[CellRow]:
        return rows_of(CELLS, within(record, *asked).cells)

    assert kept(of(cells=[CELL, replace(CELL, method="n")]), ["s"], {"e": ["m"]}) == [CELL]
    assert kept(both, ["s"], {"e": ["m"]}) == [CELL]
    assert kept(both, ["./s.toml"], {"dir/f.py": [""]}) == [other]
    assert kept(both, [], {}) == [CELL, other]
    assert kept(both, ["t"], {}) == []


def time_row(ratio: float | None, scene="s", method="m", reference="r", within=0.1) -> TimeRow:
    """Return a row with an interval of that half width."""
    low, high = (None, None) if ratio is None else (ratio / (1 + within), ratio * (1 + within))
    return TimeRow(
        scene=scene,
        engine="e",
        method=method,
        reference=reference,
        time_ratio=ratio,
        time_ratio_low=low,
        time_ratio_high=high,
    )


def test_times_have_changed_where_their_intervals_are_further_apart_than_the_tolerance():
    timed = of(times=[time_row(2.0)])

    def verdict(ratio: float | None, **row) -> list[str]:
        new = of(times=[time_row(ratio, **row)])
        return [change.verdict for change in told(timed, new).changes]

    assert verdict(3.1) == [], "from 1.8 to 2.2, and from 2.8: less than half more"
    assert verdict(3.1, within=0.0) == []
    assert verdict(3.7) == ["worse"], "from 1.8 to 2.2, and from 3.4"
    assert verdict(3.7, within=0.3) == [], "nobody knows it well enough"
    assert verdict(1.2) == []
    assert verdict(1.0) == ["better"]
    assert verdict(None) == []
    assert verdict(9.0, reference="another") == []
    assert told(timed, BASE).changes == ()


def test_of_two_measurements_the_nearer_counts():
    def row(ratio, method="m"):
        return time_row(ratio, method=method)

    before = [row(2.0), row(2.0, "n"), row(2.0, "o")]
    found = [row(4.0), row(1.0, "n"), row(5.0, "o"), row(7.0, "p")]
    again = [row(2.1), row(0.5, "n"), row(None, "o")]
    assert rows_of(TIMES, nearer(*(frame(TIMES, each) for each in (before, found, again)))) == [
        row(2.1),  # an accident of the first process
        row(1.0, "n"),  # found twice
        row(None, "o"),  # not steady
        row(7.0, "p"),  # new
    ]


@pytest.mark.parametrize(("again", "told_of"), [(2.1, []), (4.2, ["worse"])])
def test_a_changed_time_is_told_only_if_it_is_found_twice(monkeypatch, again, told_of):
    def timed(ratio: float) -> Record:
        return of(times=[time_row(ratio), time_row(1.0, scene="t")])

    asked = []

    def measured(how: Measuring, baseline: Record, display: object) -> Record:
        asked.append([*how.scenes])
        return timed(first if len(asked) == 1 else again)

    monkeypatch.setattr(study, "measure_record", measured)
    baseline, first = replace(timed(2.0), scenes=("dir/s.toml", "t")), 4.0
    new = study.measured_twice(baseline, Tolerances(), Measuring(), no_display)
    assert asked == [[], ["dir/s.toml"]], "the other scene's times have not changed"
    assert [change.verdict for change in told(baseline, new).changes if change.column == "time_ratio"] == told_of
    first = 2.2
    asked.clear()
    study.measured_twice(baseline, Tolerances(), Measuring(), no_display)
    assert asked == [[]], "nothing changed, so nothing is measured again"


# What is measured.


@pytest.mark.parametrize(
    ("drift", "word"),
    [
        ([0, 1e-10, -9e-10], "conserved"),
        ([0, 1e-3, 2e-3], "grows"),
        ([0, -1e-3, -2e-3], "decays"),
        ([0, 2e-3, 0.5e-3], "oscillates"),
        ([0, 1.0, math.nan], "grows"),
    ],
)
def test_the_energys_trend_has_a_word(drift, word):
    quiet = np.zeros(3)
    assert trend(np.column_stack((quiet, drift))) == word


@pytest.mark.parametrize(
    ("slopes", "order"),
    [([3.9, 4.0, 4.1], 4.0), ([1.1, 6.0, 6.1], 6.05), ([2.0], None), ([1.0, 2.0, 3.0], None), ([], None)],
)
def test_an_order_is_told_where_neighbours_agree(slopes, order):
    assert one_order(slopes) == (None if order is None else pytest.approx(order))


@pytest.fixture(scope="module")
def recorded(tmp_path_factory) -> Path:
    """A folder with a scene, an engine file and an accepted record of some of ours, of MuJoCo and of that file."""
    folder = tmp_path_factory.mktemp("check")
    (folder / "spin.toml").write_text(SPIN)
    (folder / "mine.py").write_text(MINE)
    engines = ("./mine.py", "tumble", "mujoco:rk4", "mujoco:euler")
    done = check(folder, "spin.toml", *(word for name in engines for word in ("-e", name)), "--accept", "-o", "base")
    assert done.returncode == 0, done.stderr
    assert done.stdout == ""
    return folder


def check(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """Run `tumble check WORDS` in a folder."""
    return in_process.tumble(folder, "check", *words)


def copy(recorded: Path, to: Path) -> Path:
    """Return a folder of a test's own."""
    return Path(shutil.copytree(recorded, to / "own"))


def test_an_engine_file_that_a_record_names_runs_only_when_it_is_named_again(recorded, tmp_path):
    folder = copy(recorded, tmp_path)
    (folder / "mine.py").write_text('open("PWNED", "w")\n' + MINE)
    for words in (("--baseline", "base"), ("--accept", "--baseline", "base")):
        done = check(folder, *words)
        assert done.returncode == 2
        assert "./mine.py" in done.stderr
        assert "--trust" in done.stderr
        assert "-e ./mine.py" in done.stderr
        assert done.stderr.count("\n") == 1
        assert not (folder / "PWNED").exists()
    check(folder, "-e", "./mine.py", "--no-times", "--baseline", "base")
    assert (folder / "PWNED").exists()


def test_orders_and_energies_are_what_the_methods_claim(recorded):
    by_method = {row["method"]: row for row in rows(recorded / "base/cells.csv") if row["engine"] == "tumble"}
    claimed = {name: method for name, method in METHODS.items() if method.order and name in by_method}
    told = {name: by_method[name]["attitude_order"] for name in claimed}
    read = {name: float(order) for name, order in told.items() if order}
    assert set(read) >= {"rk4", "splitting", "implicit-midpoint", "symplectic-euler"}
    assert {name: round(order) for name, order in read.items()} == {name: claimed[name].order for name in read}
    # The centre of mass is read only where a parabola is not exact.
    assert round(float(by_method["symplectic-euler"]["translation_order"])) == 1
    assert by_method["rk4"]["translation_order"] == ""
    keeping = {name for name, method in METHODS.items() if method.keeps_energy and name in by_method}
    assert {by_method[name]["spin_energy"] for name in keeping if by_method[name]["status"] == "ok"} == {"conserved"}
    assert by_method["quaternion-euler"]["spin_energy"] == "grows"


def test_times_are_ratios_to_a_reference_of_the_same_run(recorded):
    ratios = {(row["engine"], row["method"]): row for row in rows(recorded / "base/times.csv")}
    assert {row["reference"] for row in ratios.values()} == {"tumble:rk4"}
    assert float(ratios["tumble", "rk4"]["time_ratio"]) == 1.0
    mine = ratios["mine", "semi-implicit-euler"]["time_ratio"]
    assert not mine or float(mine) > 10, "pure Python is slower than a compiled step by far more"


def test_a_second_run_finds_nothing(recorded, tmp_path):
    folder = copy(recorded, tmp_path)
    (folder / "base/times.csv").unlink()  # a busy machine may well be slower by half
    done = check(folder, "--trust", "--baseline", "base")
    assert done.returncode == 0, done.stdout
    assert done.stdout.startswith("## tumble check: nothing changed\n")
    assert len(rows(folder / "base/cells.csv")) == int(re.search(r"(\d+) unchanged", done.stdout)[1])


# The gyroscopic torque with its sign turned round, and a step that takes the old velocity for the pose.
SPOILED = MINE.replace("np.cross(moments * w_body, w_body)", "np.cross(w_body, moments * w_body)")
NEW_FIRST, OLD_FIRST = "    v += dt * gravity\n    x += dt * v\n", "    x += dt * v\n    v += dt * gravity\n"
EULER = MINE.replace(NEW_FIRST, OLD_FIRST)


def test_a_spoiled_engine_is_worse_in_words_and_the_command_it_names_shows_it(recorded, tmp_path):
    assert SPOILED != MINE
    folder = copy(recorded, tmp_path)
    (folder / "mine.py").write_text(SPOILED)
    done = check(folder, "spin.toml", "-e", "./mine.py", "--baseline", "base", "-o", "out")
    assert done.returncode == 1
    assert "## tumble check: worse" in done.stdout
    assert re.search(r"`mine:semi-implicit-euler` on `spin`: .*largest error [\d.e-]+ m -> [\d.e-]+ m \(", done.stdout)
    assert "No longer measured" not in done.stdout, "the other contestants were not asked for"
    assert (folder / "out/summary.md").read_text() == done.stdout
    again = re.search(r"^  `(tumble check .*)`$", done.stdout, re.MULTILINE)[1]
    assert shlex.split(again)[2:] == ["spin.toml", "-e", "./mine.py:semi-implicit-euler", "--baseline", "base"]
    assert check(folder, *shlex.split(again)[2:]).returncode == 1
    suite = ElementTree.fromstring((folder / "out/junit.xml").read_text())
    (case,) = suite.iter("testcase")
    assert case.get("name") == "mine:semi-implicit-euler"
    assert again in case.find("failure").text
    assert suite.get("failures") == "1"
    assert not read_record(folder / "out").cells.equals(read_record(folder / "base").cells)


def test_blessing_shows_the_change_fails_once_and_then_holds(recorded, tmp_path):
    assert EULER != MINE
    folder = copy(recorded, tmp_path)
    first = check(folder, "spin.toml", "-e", "./mine.py", "--no-times", "--accept", "-o", "own")
    assert (first.returncode, first.stdout) == (0, "")
    assert not (folder / "own/times.csv").exists()
    same = check(folder, "--trust", "--accept", "-o", "own")
    assert same.returncode == 0
    (folder / "mine.py").write_text(EULER)
    changed = check(folder, "--trust", "--accept", "--baseline", "own")
    assert changed.returncode == 1
    assert "energy drift" in changed.stdout
    assert "the baseline was updated" in changed.stderr
    assert check(folder, "-e", "./mine.py", "--baseline", "own").returncode == 0


FAILING = {
    "raise ValueError('lost')": "mine:semi-implicit-euler on spin: crashed: ValueError: lost",
    "import time; time.sleep(1000)": "mine:semi-implicit-euler on spin: timeout",
}


@pytest.mark.parametrize("body", FAILING)
def test_what_gives_no_answer_is_no_record(recorded, tmp_path, body):
    folder = copy(recorded, tmp_path)
    (folder / "mine.py").write_text(
        MINE.replace("def advance(world, n, dt):", f"def advance(world, n, dt):\n    {body}")
    )
    words = ("spin.toml", "-e", "./mine.py", "-e", "tumble:rk4", "--no-times", "--time-limit", "20", "--accept")
    for output in ("fresh", "base"):
        before = tables(folder / output)
        refused = check(folder, *words, "-o", output)
        assert refused.returncode == 1
        assert FAILING[body] in refused.stderr
        assert "tumble:rk4" not in refused.stderr
        assert "nothing was recorded" in refused.stderr
        assert tables(folder / output) == before
    assert check(folder, *words, "-o", "fresh", "--accept-failures").returncode == 0
    assert len(read_record(folder / "fresh").cells) == 2


def tables(folder: Path) -> dict[str, bytes]:
    """Return the bytes of every file of a folder."""
    return {path.name: path.read_bytes() for path in folder.glob("*")}


def test_what_is_missing_is_no_record_either(tmp_path):
    (tmp_path / "spin.toml").write_text(SPIN)
    (tmp_path / "away" / "mujoco").mkdir(parents=True)
    (tmp_path / "away" / "mujoco" / "__init__.py").write_text("raise ImportError('gone', name='mujoco')")
    words = [sys.executable, "-P", "-m", "tumble", "check", "spin.toml", "-e", "mujoco", "--no-times", "--accept"]
    away = os.environ | {"PYTHONPATH": str(tmp_path / "away")}
    done = subprocess.run(
        [*words, "-o", "base"], cwd=tmp_path, env=away, capture_output=True, text=True, timeout=PATIENCE_S
    )
    assert (done.returncode, done.stdout) == (1, "")
    assert "mujoco on spin: missing: no module named mujoco" in done.stderr
    assert not list((tmp_path / "base").glob("*"))


def test_two_records_are_compared_and_nothing_is_flown(recorded, tmp_path):
    folder = copy(recorded, tmp_path)
    new = read_record(folder / "base")
    slower = replace(new, cells=new.cells[new.cells.method == "rk4"].assign(attitude_order=2.0))
    engines = new.engines.assign(version=new.engines.version + "x")
    write_folder(folder / "new", texts(replace(slower, engines=engines)))
    (folder / "mine.py").unlink()
    (folder / "spin.toml").unlink()
    done = check(folder, "spin.toml", "-e", "mujoco:rk4", "--baseline", "base", "--candidate", "new", "-o", "out")
    assert done.returncode == 1, done.stderr
    assert "`mujoco:rk4` attitude order 4 -> 2 (worse) on `spin`" in done.stdout
    assert "`mujoco 4.0.0 -> 4.0.0x`" in done.stdout
    assert "tumble:rk4" not in done.stdout
    assert sorted(os.listdir(folder / "out")) == ["junit.xml", "summary.md"]


# What a record may be.


def test_a_record_comes_back(tmp_path):
    hostile = replace(
        CELL,
        scene="=1+1",
        engine="'=x",
        method='a,"b"\nc`|<i>',
        status="flagged",
        why="\\u202e\\x1b[31m",
        energy_drift=-1e-3,
    )
    record = Record(
        ("./a b.toml", "it's"),
        ("./x.py:m",),
        "tumble check '=1'",
        frame(
            QUESTIONS, [replace(QUESTION, scene="=1+1", truth="-no", resolution_m=None, x_m=None, y_m=None, z_m=None)]
        ),
        frame(ENGINES, [replace(ENGINE, version="+1", switched_off="@x")]),
        frame(CELLS, [hostile, replace(hostile, method="'''", max_error_m=math.inf)]),
        frame(TIMES, [TimeRow(scene="=1+1", engine="'=x", method="m", reference="r", time_ratio=None)]),
    )
    write_folder(tmp_path, texts(record))
    back = read_record(tmp_path)
    assert (back.scenes, back.contestants, back.command) == (record.scenes, record.contestants, record.command)
    for name in TABLES:
        pd.testing.assert_frame_equal(getattr(back, name), getattr(record, name))
    write_folder(tmp_path, texts(replace(record, times=frame(TIMES, []))))
    assert len(read_record(tmp_path).times) == 0


def test_conditions_come_last_so_that_half_a_record_is_none():
    assert list(texts(BASE))[-1] == "conditions.csv"


HEADER = ",".join(CELLS.names)
BROKEN = {
    ("conditions.csv", FORMAT, "tumble check 1"): "is in format 'tumble check 1'; this Tumble reads",
    ("conditions.csv", FORMAT, "tumble tables 1"): "is in format 'tumble tables 1'; this Tumble reads",
    ("conditions.csv", "format,", "formt,"): "states no format; this Tumble reads",
    ("conditions.csv", "what,value", "what;value"): "conditions.csv: columns 'what;value': must be what,value",
    ("conditions.csv", "scenes,s", "scenes,'s"): "conditions.csv: scenes cannot be read",
    ("cells.csv", "scene,engine", "scene,machine"): f"must be {HEADER}",
    ("cells.csv", "s,e,m,100,", "s,e,m,1x,"): "cells.csv: line 2: steps = '1x': must be a whole number",
    ("cells.csv", "s,e,m,100,", "s,e,m,-1,"): "row 1: steps = -1: must be a whole number from 0 to 10",
    ("cells.csv", ",2.0,1.0,decays", ",2.0,one,decays"): "line 2: translation_order = 'one': must be a number",
    ("cells.csv", ",2.0,1.0,decays", ",2.0,inf,decays"): "row 1: translation_order = inf: must be finite",
    ("cells.csv", ",2.0,1.0,decays", ",2.0,1.0,rises"): "spin_energy = 'rises': must be one of conserved, oscillates",
    ("cells.csv", ",2.0,1.0,decays", ",2.0,1.0"): "cells.csv: line 2: 16 cells: must be 17",
    ("cells.csv", "\ns,", "\nt,"): "cells.csv has scene 't', which questions.csv does not have",
    ("cells.csv", "decays", "dec\"ays\nx"): "cells.csv:",
    ("cells.csv", ",0.001,", ",-1.0,"): "row 1: max_error_m = -1.0: must be >= 0",
    ("cells.csv", ",0.001,", ",-inf,"): "row 1: max_error_m = -inf: must be >= 0",
    ("cells.csv", ",0.001,", ",nan,"): "cells.csv: line 2: max_error_m = 'nan': must be a number",
    ("cells.csv", ",0.001,", ",,"): "cells.csv: max_error_m of 's e:m' is empty, but its status is ok",
    ("cells.csv", ",0.0005,0.0009,", ",0.0005,,"): "cells.csv: final_error_m of 's e:m' is empty",
    ("cells.csv", ",-0.001,", ",,"): "cells.csv: energy_drift of 's e:m' is empty",
    ("cells.csv", ",1e-15,1e-13,", ",1e-15,inf,"): "row 1: rounding_m = inf: must be finite and >= 0",
    ("cells.csv", ",1e-15,1e-13,", ",1e-15,-1e-13,"): "row 1: rounding_m = -1e-13: must be finite and >= 0",
    ("cells.csv", ",1e-15,1e-13,", ",,1e-13,"): "cells.csv: resolution_m of 's e:m' is empty",
    ("cells.csv", ",ok,", ",OK ,"): "cells.csv: status = 'OK ': must be one of ok, flagged, diverged, skipped, missing",
    ("cells.csv", ",ok,", ",,"): "cells.csv: status = '': must be one of ok",
    ("questions.csv", ",1e-15,0.3,", ",1e-15,-0.3,"): "row 1: size_m = -0.3: must be finite and >= 0",
    ("questions.csv", ",1e-15,", ",,"): "questions.csv: resolution_m of 's' is empty",
    ("questions.csv", ",2.0,", ",,"): "questions.csv: y_m of 's' is empty, but its truth is exact",
    ("questions.csv", "s,0.5,", "s,,"): "questions.csv: line 2: step_s = '': must be a number",
}  # fmt: skip


@pytest.mark.parametrize("damage", BROKEN, ids=lambda damage: f"{damage[0]}:{damage[2]!r}")
def test_a_broken_or_foreign_record_is_refused_in_one_line(tmp_path, damage):
    name, old, new = damage
    write_folder(tmp_path, texts(BASE))
    text = (tmp_path / name).read_text(encoding="utf-8")
    assert old in text
    (tmp_path / name).write_text(text.replace(old, new), encoding="utf-8")
    with pytest.raises(BadRecord) as refused:
        read_record(tmp_path)
    assert BROKEN[damage] in str(refused.value)
    assert str(refused.value).startswith(str(tmp_path))
    assert str(refused.value).isprintable()


def test_a_row_that_is_there_twice_is_refused(tmp_path):
    write_folder(tmp_path, texts(of(cells=[CELL, CELL])))
    with pytest.raises(BadRecord, match="two rows for 's e m'"):
        read_record(tmp_path)


def test_what_is_no_record_is_refused_in_one_line(tumble, tmp_path):
    (tmp_path / "empty").mkdir()
    (tmp_path / "bytes").mkdir()
    (tmp_path / "bytes/conditions.csv").write_bytes(b"\xff\x00")
    for words, why in {
        ("--baseline", "nowhere"): "nowhere: no such folder",
        ("--baseline", "empty"): "empty: not a record of `tumble check`: it has no conditions.csv",
        ("--baseline", "bytes"): "conditions.csv: not CSV",
        (): "give --baseline DIR to compare with a record, or --accept -o DIR to make one",
        ("--baseline", "a", "--accept-failures"): "--accept-failures needs --accept",
        ("--accept",): "--accept: give -o DIR to record into",
        ("--accept", "--baseline", "a", "-o", "b"): "--accept writes one record",
        ("--accept", "--candidate", "a", "-o", "b"): "--accept records what it runs",
        ("--baseline", "a", "-o", "./a"): "-o ./a is one of the records compared",
        ("--baseline", "empty", "--tolerances", "none.toml"): "none.toml: no such file",
    }.items():
        done = tumble("check", *words)
        assert (done.returncode, done.stdout) == (2, "")
        assert why in done.stderr
        assert len(done.stderr.splitlines()) == 1


# Tolerances.


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("max_eror_m = 1", "'max_eror_m': unknown key; did you mean 'max_error_m'?"),
        ("max_error_m = -1", "max_error_m = -1: must be a finite number >= 0"),
        ("max_error_m = inf", "max_error_m = inf: must be a finite number >= 0"),
        ("max_error_m = nan", "max_error_m = nan: must be a finite number >= 0"),
        ("max_error_m = true", "max_error_m = True: must be a finite number >= 0"),
        ("max_error_m = '1'", "max_error_m = '1': must be a finite number >= 0"),
        ("[max_error_m]", "max_error_m = {}: must be a finite number >= 0"),
        ("max_error_m", "not TOML"),
        ("a = " + "1" * 5000, "not TOML"),
        ("a = " + "[" * 100_000, "not TOML: nested too deeply"),
    ],
)
def test_tolerances_that_cannot_be_used_are_refused(tmp_path, text, why):
    file = tmp_path / "t.toml"
    file.write_text(text)
    with pytest.raises(BadTolerance) as refused:
        read_tolerances(str(file))
    assert why in str(refused.value)
    assert str(refused.value).startswith(str(file))


def test_a_file_overrides_what_it_names(tmp_path):
    (tmp_path / "t.toml").write_text("max_error_m = 3\ntime_ratio = 0.1\n")
    assert read_tolerances(str(tmp_path / "t.toml")) == Tolerances(max_error_m=3, time_ratio=0.1)
    assert read_tolerances(None) == Tolerances()


# What is said.


def test_a_summary_fits_a_comment_and_says_what_it_left_out():
    cells = [replace(CELL, method=f"m{number}") for number in range(2000)]
    worse = [replace(cell, max_error_m=1.0) for cell in cells]
    outcome = told(of(cells=cells), of(cells=worse))
    text = summary(outcome, AGAINST)
    assert MOST_CHARACTERS - 500 < len(text) < 65_536
    assert re.search(r"\d+ more lines", text)
    assert "2000 worse" in text
    assert len(list(ElementTree.fromstring(junit(outcome, AGAINST)).iter("failure"))) == 2000


def test_junit_counts_what_it_holds():
    new = of(
        cells=[
            replace(CELL, max_error_m=1.0),
            CellRow(scene="s", engine="e", method="n", steps=None, status="skipped", why="no floor"),
        ]
    )
    root = ElementTree.fromstring(junit(told(BASE, new), AGAINST))
    (suite,) = root
    assert (suite.get("tests"), suite.get("failures"), suite.get("skipped")) == ("2", "1", "0"), (
        "new: told, not skipped"
    )
    same = ElementTree.fromstring(junit(told(new, new), AGAINST))
    assert (same.get("tests"), same.get("failures"), same.get("skipped")) == ("2", "0", "1")


# What the documentation promises.

PAGE = (ROOT / "docs/check.md").read_text(encoding="utf-8")


def test_the_page_states_every_tolerance():
    stated = re.findall(r"^\| `(\w+)` \|.*by more than ([\d.]+)", PAGE, re.MULTILINE)
    assert stated == [(field.name, f"{field.default:g}") for field in fields(Tolerances)]


def test_the_page_shows_the_test_file_as_it_is():
    (shown,) = re.findall(r"^```python\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
    file = (ROOT / "docs/test_mine.py").read_text(encoding="utf-8")
    assert shown == file
    assert len([line for line in file.splitlines() if line]) <= 10
    assert not re.search(r"^(?:import|from) (?:tumble|compare|scenarios|solver|reports)", file, re.MULTILINE)


def test_the_test_file_guards_an_engine_as_pytest_sees_it(tmp_path):
    shutil.copy(ROOT / "docs/test_mine.py", tmp_path)
    (tmp_path / "mine.py").write_text(MINE)
    (tmp_path / "spin.toml").write_text(SPIN)
    bless = ast.get_docstring(ast.parse((ROOT / "docs/test_mine.py").read_text())).splitlines()[-1]
    words = ["spin.toml" if word == "two-hits" else word for word in shlex.split(bless)[2:]]  # for the sake of time
    assert check(tmp_path, *words).returncode == 0
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"

    def pytest_run() -> subprocess.CompletedProcess[str]:
        words = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "test_mine.py"]
        return subprocess.run(
            words, cwd=tmp_path, env={**os.environ, "PATH": path}, capture_output=True, text=True, timeout=PATIENCE_S
        )

    assert pytest_run().returncode == 0
    (tmp_path / "mine.py").write_text(SPOILED)
    spoiled = pytest_run()
    assert spoiled.returncode == 1
    assert "largest error" in spoiled.stdout


WORKFLOW = (ROOT / "docs/tumble-check.yml").read_text(encoding="utf-8")


def test_the_readme_shows_the_workflow_as_it_is():
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    (shown,) = re.findall(r"^```yaml\n(.*?)^```", readme, re.MULTILINE | re.DOTALL)
    assert shown == WORKFLOW


def test_the_workflows_steps_guard_an_engine(tmp_path):
    """Its steps run here as runners run them: each with bash -e, beside a checkout of ours in .tumble.

    All jobs share a folder, in which each finds what another has uploaded.
    """

    def jobs_of(shard: object) -> dict:
        return yaml.safe_load(WORKFLOW.replace("${{ matrix.shard }}", str(shard)))["jobs"]

    jobs = jobs_of("")
    shards = jobs["part"]["strategy"]["matrix"]["shard"]
    assert (shards, jobs["check"]["needs"]) == ([1, 2, 3, 4], "part")
    assert jobs["check"]["steps"][:4] == jobs["part"]["steps"][:4]
    (tmp_path / ".tumble").symlink_to(ROOT, target_is_directory=True)
    (tmp_path / "mine.py").write_text(MINE)
    (tmp_path / "spin.toml").write_text(SPIN)
    summary = tmp_path / "summary"

    def record() -> None:
        shutil.rmtree(tmp_path / "baseline", ignore_errors=True)
        words = ("spin.toml", "-e", "./mine.py", "--no-times", "--accept", "-o", "baseline")
        assert check(tmp_path, *words).returncode == 0

    record()

    def is_done(job: str, shard: object = "") -> bool:
        good = True
        for step in jobs_of(shard)[job]["steps"]:
            if not (good or step.get("if") == "always()"):
                continue
            if "upload-artifact" in step.get("uses", ""):
                assert (tmp_path / step["with"]["path"]).is_dir()
            elif "run" in step:
                words = ["bash", "-e", "-c", step["run"]]
                env = {**os.environ, "GITHUB_STEP_SUMMARY": str(summary)}
                done = subprocess.run(words, cwd=tmp_path, env=env, capture_output=True, text=True, timeout=PATIENCE_S)
                good = good and done.returncode == 0
        return good

    (tmp_path / "mine.py").write_text(SPOILED)
    assert all(is_done("part", shard) for shard in shards)
    assert not is_done("check")
    assert "largest error" in summary.read_text()
    assert (tmp_path / "checked/junit.xml").is_file()
    record()
    assert is_done("check"), "nothing has changed since"


# Tumble's own record.


def test_the_accepted_record_is_whole():
    record = read_record(ROOT / "tests/golden")
    assert record.times is None, "no time of one machine binds another"
    assert set(record.engines.status) == {"ok"}
    assert set(record.cells.engine) == {"tumble", "handcalc", "mujoco", "pybullet"}
    assert told(record, record).changes == ()


def test_a_record_in_format_2_is_read(caplog, tmp_path):
    """A record of the release before format 3: one column and two words have other names."""
    folder = Path(__file__).with_name("format-2")
    before = (folder / "cells.csv").read_text()
    assert "limit_m" in before
    assert ",wavers" in before
    with caplog.at_level(logging.INFO, logger="tumble"):
        record = read_record(folder)
    assert [message for message in caplog.messages if "--accept rewrites it in format 3" in message]
    cells = rows_of(CELLS, record.cells)
    assert sum(cell.max_error_m is not None for cell in cells) > 90
    assert all((cell.resolution_m is None) == (cell.max_error_m is None) for cell in cells)
    assert record.cells["spin_energy"].value_counts().to_dict() == {
        {"kept": "conserved", "wavers": "oscillates"}.get(word, word): before.count(f",{word}\n")
        for word in ("kept", "wavers", "grows", "decays", "")
    }
    caplog.clear()
    accept_record(tmp_path, record)
    again = read_record(tmp_path)
    assert not caplog.messages, "it is in format 3 now"
    assert told(record, again).changes == ()


def test_a_drift_that_roundings_of_single_precision_explain_is_no_change():
    """The same change is one in an engine of doubles."""
    old = replace(CELL, steps=1000, angular_momentum_drift=1e-6, rounding_m=0.0)
    new = replace(old, angular_momentum_drift=5e-5)

    def columns(precision: str) -> list[str]:
        engines = [replace(ENGINE, precision=precision)]
        outcome = told(of(cells=[old], engines=engines), of(cells=[new], engines=engines))
        return [change.column for change in outcome.changes]

    assert (columns("double"), columns("single")) == (["angular_momentum_drift"], [])


NARROW = """

seen = []


def build(scene, method):
    seen.append(scene.start.copy())
    if not np.array_equal(seen[0], seen[-1]):
        raise ValueError("another start")
    return World(scene)
"""


def test_a_run_whose_neighbour_is_lost_leaves_a_record_that_can_be_read(tmp_path):
    """The engine fails where its start is not the one in the file: what its roundings come to is then unknown."""
    (tmp_path / "mine.py").write_text(MINE + NARROW)
    words = ("two-hits", "-e", "mine.py", "--no-times")
    assert check(tmp_path, *words, "--accept", "-o", "base").returncode == 0
    (cell,) = rows(tmp_path / "base/cells.csv")
    assert (cell["status"], cell["rounding_m"]) == ("ok", "")
    assert check(tmp_path, *words, "--baseline", "base").returncode == 0


BOUNCES = """
title = "Cube that bounces on its corners and is soon chaotic"
duration = 10.0
samples = 10
step = 0.002
gravity = [0.0, -9.81, 0.0]
[body]
shape = "box"
size = [1.0, 1.0, 1.0]
mass = 1.0
position = [0.0, 3.0, 0.0]
orientation = [0.8, 0.3, 0.1, 0.5]
angular_velocity = [1.0, 2.0, 0.5]
[floor]
height = 0.0
stiffness = 2.0e4
"""


def test_a_scene_whose_truth_ends_before_the_run_is_recorded_and_held_to_what_is_known(tmp_path):
    (tmp_path / "bounces.toml").write_text(BOUNCES)
    done = check(tmp_path, "bounces.toml", "-e", "tumble:rk4", "--no-times", "--accept", "-o", "base")
    assert done.returncode == 0, done.stderr
    (question,) = rows(tmp_path / "base/questions.csv")
    assert float(question["resolution_m"]) < 1e-6 * float(question["size_m"]), "beyond its horizon nobody is judged"
    again = check(tmp_path, "--no-times", "--baseline", "base", "--candidate", "base")
    assert again.returncode == 0
    assert "nothing changed" in again.stdout
