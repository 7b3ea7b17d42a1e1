"""What leaving out pays, measured on engines that leave out what we know."""

import csv
import io
from pathlib import Path

import numpy as np
import pytest

from tumble.__main__ import main
from tumble.compare.ablation.optional_features import (
    EVERYTHING,
    AblationRow,
    Build,
    Pair,
    ablate,
    apart_m,
    measured,
    pairs,
)
from tumble.compare.run.flight import Trajectory
from tumble.compare.run.running_engines import launched
from tumble.compare.run.status import Failure, Status
from tumble.compare.run.timing.readings import Reading, Sampling
from tumble.compare.run.timing.timer import Ready
from tumble.compare.run.timing.timing import Cost
from tumble.reports.ablation import band, times
from tumble.scenarios.needs import needs
from tumble.scenarios.read import read_scene

PLUGINS = Path(__file__).parents[2] / "plugins"
SPARING, MINE = str(PLUGINS / "sparing.py"), str(PLUGINS / "mine.py")
COLUMNS = (
    "scene,engine,method,feature,why,cpu_ns_per_step_with,cpu_ns_per_step_without,"
    "ratio,ratio_low,ratio_high,max_difference_m"
)
SCENE = """
title = "Brick, barely turning"
duration = 0.2
times = [0.1, 0.2]
step = 0.02
[body]
shape = "box"
size = [0.4, 0.15, 0.1]
mass = 2.4
velocity = [0.5, 3.0, -1.0]
angular_velocity = [0.2, -0.1, 0.4]
"""
FALLING = "gravity = [0.0, -9.81, 0.0]\n"


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    found = tmp_path_factory.mktemp("scenes")
    (found / "brick.toml").write_text(SCENE)
    (found / "falling.toml").write_text(SCENE.replace("[body]", f"{FALLING}[body]"))
    return found


@pytest.fixture(scope="module")
def ablation(folder):
    with launched([SPARING, MINE]) as running_engines:
        return ablate(running_engines, read_scene(str(folder / "brick.toml")), sampling=Sampling(span_s=0.0))


def rows_of(ablation, method: str) -> dict[str, AblationRow]:
    return {row.feature: row for row in ablation.rows if row.method == method}


def test_every_feature_left_out_has_its_row_and_all_of_them_one(ablation):
    assert list(rows_of(ablation, "careful")) == [EVERYTHING, "ballast", "breeze", "digits", "gravity"]


def test_what_costs_something_is_told_from_what_costs_nothing(ablation):
    """By ratios of the same rounds: whatever else the machine does, it does to both."""
    # Where a busy machine lets no ratio be told, the reason stands in its place.
    rows = {feature: row for feature, row in rows_of(ablation, "careful").items() if "no ratio" not in row.why}
    for row in rows.values():
        assert row.ratio_low <= row.ratio <= row.ratio_high
    # With the ballast a step is four steps' work, of which none but these costs anything worth noticing.
    for costly in {"ballast", EVERYTHING} & rows.keys():
        for free in {"breeze", "gravity"} & rows.keys():
            assert rows[costly].ratio > rows[free].ratio
    assert len({row.cpu_ns_per_step_without for row in rows.values()}) == 1, "one lean build for all"


def test_a_row_has_the_ratio_of_the_rounds_and_the_lower_decile_of_each_time(ablation, folder):
    """Of planted samples, a machine that was ten times as slow in every other round: the ratio is 4 in each."""
    scene = read_scene(str(folder / "brick.toml"))
    with launched([f"{SPARING}:careful"]) as (careful,):
        lean, kept = (Build(careful, scene, "careful", name) for name in ("", "ballast"))
    slow = np.where(np.arange(24) % 2, 1.0, 10.0)
    ready = Ready(0.0, 0.0, 0.0, 0)
    clocked = {lean.key: Cost(Reading(100.0 * slow), ready), kept.key: Cost(Reading(400.0 * slow), ready)}
    row = measured(Pair(kept, lean, 1e-9, 0.0, 0.0), clocked)
    assert (row.cpu_ns_per_step_without, row.cpu_ns_per_step_with) == (100.0, 400.0)
    assert row.ratio == pytest.approx(4.0)
    assert row.ratio_low < 4.0 < row.ratio_high
    assert row.max_difference_m == 1e-9
    gone = measured(Pair(kept, lean, 1e-9, 0.0, 0.0), clocked | {lean.key: Failure(Status.UNTIMED, "it is no time")})
    assert (gone.why, gone.ratio) == ("with the feature off: untimed: it is no time", None)


def test_a_motion_that_stays_is_the_same_to_the_last_bit(ablation):
    assert {row.max_difference_m for row in rows_of(ablation, "careful").values()} == {0.0}


def test_how_far_a_feature_moves_the_vertices(ablation):
    rows = rows_of(ablation, "windy")
    # A breeze of 1e-3 m/s2 along all three axes for 0.2 s; semi-implicit Euler adds one step of 0.02 s to the fall.
    moved = np.sqrt(3) * 1e-3 * 0.2 * (0.2 + 0.02) / 2
    for feature in ("breeze", EVERYTHING):
        assert rows[feature].max_difference_m == pytest.approx(moved, rel=1e-9)
    for feature in ("ballast", "digits", "gravity"):
        assert rows[feature].max_difference_m == 0


def test_only_what_the_flight_is_worse_without_does_harm(ablation):
    assert ablation.resolution_m < 1e-14
    assert {(row.method, row.feature) for row in ablation.altered} == {
        ("careless", "digits"),
        ("careless", EVERYTHING),
    }
    assert {(row.method, row.feature) for row in ablation.inexact} == {("windy", "breeze"), ("windy", EVERYTHING)}


def test_what_cannot_be_built_is_a_row_with_the_reason_and_not_in_everything(ablation):
    fragile = rows_of(ablation, "fragile")
    assert list(fragile) == [EVERYTHING, "ballast", "digits", "gravity", "breeze"]
    assert fragile["breeze"].why == "skipped: it would break"
    brittle = rows_of(ablation, "brittle")
    assert list(brittle) == ["ballast, breeze, digits, gravity"]
    assert brittle.popitem()[1].ratio is None


def test_an_engine_without_spares_is_one_row_that_says_so(ablation):
    (row,) = [row for row in ablation.rows if row.engine == "mine"]
    assert row == AblationRow(scene="brick", engine="mine", method="", feature="", why="no unneeded features")


def test_what_the_scene_has_is_not_left_out(folder):
    scene = read_scene(str(folder / "falling.toml"))
    assert "gravity" in needs(scene)
    with launched([f"{SPARING}:careful", "handcalc"]) as running_engines:
        found = ablate(running_engines, scene, sampling=Sampling(span_s=0.0))
    assert list(rows_of(found, "careful")) == [EVERYTHING, "ballast", "breeze", "digits"]
    assert found.rows[-1] == AblationRow(
        scene="falling", engine="handcalc", method="", feature="", why="skipped: handcalc has no gravity"
    )


def test_what_mujoco_leaves_out_moves_no_bit_and_costs_no_time(folder):
    with launched(["mujoco:rk4"]) as running_engines:
        found = ablate(running_engines, read_scene(str(folder / "brick.toml")), sampling=Sampling(span_s=1.0))
    # A fifth on a quiet machine; on any other, what is left out does not make it slower.
    assert rows_of(found, "rk4")[EVERYTHING].ratio_high > 1
    assert {row.max_difference_m for row in found.rows} == {0.0}


def test_our_solver_pays_for_no_term_that_a_cube_has_not_got():
    with launched(["tumble:rk4"]) as running_engines:
        turning = ablate(running_engines, read_scene("table-4-1"), sampling=Sampling(span_s=0.5))
        straight = ablate(running_engines, read_scene("die-straight"), sampling=Sampling(span_s=0.5))
    everything = rows_of(turning, "rk4")[EVERYTHING]
    assert everything.ratio_high > 1.5
    # What never turns is moved by one product, however many the steps: no time of theirs is left to compare with.
    assert any("with the feature off: untimed" in row.why for row in straight.rows), straight.rows
    assert not turning.altered
    assert not straight.altered


# --- apart from engines


def trajectory(vertices) -> Trajectory:
    vertices = np.array(vertices, dtype=float).reshape(-1, 1, 1, 3)
    return Trajectory(np.arange(len(vertices)), np.zeros((len(vertices), 1, 13)), vertices, 1, 0.0, ())


def test_two_flights_are_as_far_apart_as_their_vertices_ever_are():
    here = trajectory([(0, 0, 0), (1, 1, 1)])
    assert apart_m(here, here) == 0
    assert apart_m(here, trajectory([(0, 0, 0), (1, 4, 5)])) == 5
    lost = trajectory([(0, 0, 0), (np.nan, 1, 1)])
    assert apart_m(here, lost) == apart_m(lost, here) == np.inf
    assert apart_m(lost, lost) == 0


def test_a_ratio_is_quoted_in_as_many_digits_as_it_has():
    assert [times(ratio) for ratio in (None, 1.0, 37.994, 231.4)] == ["", "1.00", "37.99", "231"]
    assert (
        band(
            AblationRow(
                scene="s",
                engine="e",
                method="m",
                feature="f",
                why="",
                cpu_ns_per_step_with=2.0,
                cpu_ns_per_step_without=1.0,
                ratio=2.0,
                ratio_low=1.9,
                ratio_high=2.1,
                max_difference_m=0.0,
            )
        )
        == "1.90-2.10"
    )


# --- the command


def test_the_command_prints_it_and_writes_it(tumble, folder):
    said = tumble("ablate", str(folder / "brick.toml"), "-e", f"{SPARING}:careful", "-e", MINE, "-o", "out", cwd=folder)
    assert said.returncode == 0, said.stderr
    assert "mine: no unneeded features" in said.stdout
    assert "sparing:careful" in said.stdout
    assert "  with ballast" in said.stdout
    assert "identical" in said.stdout
    text = (folder / "out" / "ablation.csv").read_text()
    assert text.splitlines()[0] == COLUMNS
    rows = list(csv.DictReader(io.StringIO(text)))
    assert [row["feature"] for row in rows] == [
        EVERYTHING, "ballast", "breeze", "digits", "gravity", "",
    ]  # fmt: skip
    assert rows[-1]["why"] == "no unneeded features"
    assert rows[0]["max_difference_m"] == "0.0"
    assert not any(rows[-1][column] for column in COLUMNS.split(",")[5:])
    assert {"engines.csv", "conditions.csv"} <= {path.name for path in (folder / "out").iterdir()}


def test_a_harmful_omission_fails_the_command(tumble, folder):
    said = tumble("ablate", str(folder / "brick.toml"), "-e", f"{SPARING}:careless", cwd=folder)
    assert said.returncode == 1
    assert "sparing:careless on brick: digits moves" in said.stderr


@pytest.mark.parametrize("words", [("nowhere",), ("die-straight", "-e", "nobody")])
def test_the_users_mistakes_are_one_line(tumble, words):
    said = tumble("ablate", *words)
    assert said.returncode == 2
    assert said.stdout == ""
    assert len(said.stderr.splitlines()) == 1


def test_an_engine_with_nothing_to_leave_out_is_not_waited_for(tmp_path, monkeypatch, capsys):
    """No timer stands in it, so that there is no round to take, and no warning of a mean of nothing."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.py").write_text((Path(__file__).parents[2] / "plugins/mine.py").read_text(encoding="utf-8"))
    assert main(["ablate", "die-straight", "-e", "./mine.py"]) == 0
    assert "no unneeded features" in capsys.readouterr().out


def test_a_plane_far_below_changes_no_bit_but_one_that_the_body_meets_does(folder, monkeypatch):
    scene = read_scene(str(folder / "falling.toml"))
    with launched(["mujoco:euler", "pybullet:multibody", "tumble:rk4"]) as running_engines:
        found = {one.title: list(pairs(one, scene, None, one.methods[0], [])) for one in running_engines}
        assert [[pair.full.feature for pair in own] for own in found.values()] == [["plane"], ["plane"], []], "no plane"
        assert [pair.apart_m for own in found.values() for pair in own] == [0.0, 0.0]
        monkeypatch.setattr("tumble.compare.ablation.optional_features.FAR", -10.0)
        (met,) = pairs(running_engines[0], scene, None, "euler", [])
        assert met.apart_m > 1e-3
