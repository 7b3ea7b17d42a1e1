"""Extreme cases: that they are what their names say, that our best method holds them, and that nobody is waited for."""

import tracemalloc
from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest

from tumble.compare.run.flight import legs, simulate
from tumble.compare.run.running_engines import launched
from tumble.compare.stability.extremes import (
    BEST,
    FLOORS,
    OF_A_PAGE,
    PAGE_BUDGET_S,
    ExtremeRow,
    extreme,
    missed,
    too_long,
)
from tumble.compare.stability.schemas import EXTREMES
from tumble.compare.tables.frames import read_text, rows
from tumble.scenarios.frames import rotation_matrix
from tumble.scenarios.read import BadScene, catalogue, extremes, read_scene
from tumble.scenarios.scene import Scene
from tumble.scenarios.truth import truth

CASES = {name: read_scene(name) for name in extremes()}
# Those whose truth and flights take a moment.
QUICK = (
    "spin-1e6",
    "step-1",
    "needle",
    "inertia-1e6",
    "far-1e7",
    "separatrix",
    "impulse-1e15",
    "no-impulse",
    "denormal",
)


@pytest.fixture(scope="module")
def truths():
    return {name: truth(CASES[name]) for name in QUICK}


def test_every_case_of_the_list_is_there():
    assert {f"spin-1e{power}" for power in range(2, 7)} <= set(CASES)
    assert {CASES[name].step for name in CASES if name.startswith("step-")} == {1e-6, 1e-4, 1e-2, 1.0}
    assert {CASES["mass-1e-9"].body.mass, CASES["mass-1e12"].body.mass} == {1e-9, 1e12}
    assert np.ptp(CASES["micrometre"].body.points) < 5e-6
    assert np.ptp(CASES["thousand-km"].body.points) >= 1e6
    moments = CASES["inertia-1e6"].body.moments
    assert moments.max() / moments.min() == pytest.approx(1e6)
    assert sum(leg.n for leg in legs(CASES["steps-1e8"], CASES["steps-1e8"].step)) == 10**8
    assert not set(CASES) & set(catalogue())


def test_the_cases_are_what_they_are_called():
    turned = CASES["turns-1e5"]
    w = np.linalg.norm(turned.start[0, 10:13])
    assert w * turned.duration / (2 * np.pi) == pytest.approx(1e5, rel=0.05)
    axis = CASES["middle-axis"]
    middle = int(np.argsort(axis.body.moments)[1])
    assert np.flatnonzero(axis.start[0, 10:13]).tolist() == [middle]
    edge = CASES["separatrix"]
    b = sorted(edge.body.moments)[1]
    w_body = rotation_matrix(edge.start[0, 3:7]).T @ edge.start[0, 10:13]
    moments = edge.body.moments
    off = (moments * w_body) @ (moments * w_body) / (b * (moments * w_body) @ w_body) - 1
    assert 1e-13 < abs(off) < 1e-11
    assert np.linalg.norm(CASES["impulse-1e15"].impulses[0].value) == pytest.approx(1e15, rel=0.02)
    blows = CASES["ten-impulses"].impulses
    assert len(blows) == 10
    assert len({blow.time for blow in blows}) == 1
    assert not CASES["no-impulse"].start[0, 7:13].any()
    assert 5e-324 in CASES["denormal"].start


def test_a_case_has_a_name_and_a_word_that_is_none_is_refused_with_the_nearest():
    assert read_scene("spin-1e4").title == "Spin of 9700 rad/s at a step of 1 ms"
    with pytest.raises(BadScene, match=r"unknown scene 'spin-1e44': did you mean 'spin-1e4'\?"):
        read_scene("spin-1e44")


@pytest.mark.parametrize("name", extremes())
def test_every_case_is_free_and_says_what_it_is_there_for(name):
    case = read_scene(name)
    assert case.is_free
    assert case.source.startswith("Tumble: ")
    assert len(case.times) == 16


def test_the_cases_of_a_page_are_cases_and_short():
    assert set(OF_A_PAGE) < set(CASES)
    assert len(OF_A_PAGE) == len(set(OF_A_PAGE))
    for name in OF_A_PAGE:
        steps = sum(leg.n for leg in legs(CASES[name], CASES[name].step))
        assert steps * 50e-6 < PAGE_BUDGET_S, "an engine of the slowest kind would not be run"


def test_our_best_method_holds_every_quick_case(truths):
    engine, _, method = BEST.partition(":")
    with launched([BEST], 60.0) as (running_engine,):
        rows = [extreme(running_engine, method, CASES[name], truths[name]) for name in QUICK]
    assert {row.engine for row in rows} == {engine}
    assert missed(rows) == [], [(row.scene, row.error_over_resolution) for row in rows]
    assert {row.verdict for row in rows} == {"stable"}


def test_a_miss_is_told():
    engine, method = BEST.split(":")
    row = ExtremeRow(
        scene="c",
        title="C",
        engine=engine,
        method=method,
        dt_s=0.1,
        status="ok",
        verdict="stable",
        error_over_resolution=FLOORS * 1.01,
        why="",
        size_m=0.2,
    )
    assert missed([row]) == [row]
    assert missed([replace(row, error_over_resolution=FLOORS)]) == []
    assert missed([replace(row, error_over_resolution=None)]), "no flight is no success"
    assert missed([replace(row, engine="mine")]) == [], "others may miss"


def test_one_row_a_contestant_with_its_reason(truths):
    with launched(["tumble:rk4", "mujoco:implicitfast", "handcalc:all-mended"], 60.0) as running_engines:
        rows = {
            (name, running_engine.title): extreme(running_engine, running_engine.methods[0], CASES[name], truths[name])
            for name in ("spin-1e6", "no-impulse")
            for running_engine in running_engines
        }
    assert rows["spin-1e6", "tumble"].verdict == "diverged"
    assert rows["spin-1e6", "mujoco"].verdict == "damped"
    assert "energy of the spin falls" in rows["spin-1e6", "mujoco"].why
    assert rows["no-impulse", "mujoco"].verdict == rows["no-impulse", "tumble"].verdict == "stable"
    assert rows["no-impulse", "mujoco"].error_over_resolution < FLOORS
    refused = rows["spin-1e6", "handcalc"]
    assert (refused.verdict, refused.max_error_m) == ("refused", None)
    assert "Table 4.1" in refused.why


def test_what_does_not_fit_the_budget_is_told_from_its_first_steps():
    case = CASES["steps-1e8"]
    near = replace(case, duration=10.0, times=np.array([10.0]), step=1e-6)
    true = truth(near)
    with launched(["mujoco:rk4", "scipy", "tumble:exact"], 60.0) as running_engines:
        rk4, dop853, exact = (
            extreme(running_engine, running_engine.methods[0], near, true, budget_s=1e-3)
            for running_engine in running_engines
        )
    for row in (rk4, dop853):
        assert row.verdict == "no-return"
        assert "0.001" in row.why
    assert "1e+07 steps" in rk4.why
    assert exact.verdict == "stable", "one step for all"


STEADY = """
import time
METHODS = ("coasts", "crawls", "tastes")
ADAPTIVE = ("tastes",)
FEATURES = {"gravity"}
ABOUT = {"version": "1", "precision": "double", "switched_off": []}
STEP_NS = {"coasts": 10, "crawls": 1000, "tastes": 10}
def build(scene, method): return {}
def write(world, states): world["states"] = states
def advance(world, n, dt):
    time.sleep(LATE_S)
    world["states"][:, 0:3] += n * dt * world["states"][:, 7:10]
def read(world): return world["states"]
"""


def test_what_is_too_long_is_the_same_on_a_machine_that_is_busy(tmp_path):
    """Steps that take no time, and the same that are kept waiting: by the wall clock the latter would take minutes."""
    case = CASES["turns-1e5"]
    rows = []
    for name, late_s in (("quiet", "0.0"), ("busy", "0.05")):
        (tmp_path / f"{name}.py").write_text(STEADY.replace("LATE_S", late_s))
        with launched([str(tmp_path / f"{name}.py")], 60.0) as (running_engine,):
            rows.append([too_long(running_engine, method, case, 0.1) for method in running_engine.methods])
    coasts, crawls, tastes = rows[0]
    assert (coasts, tastes) == (None, None)
    assert str(crawls) == "timeout: 5e+05 steps would take 0.5 s, the limit is 0.1 s"
    assert rows[1] == rows[0]


def test_an_adaptive_method_that_computes_too_long_is_told_so(tmp_path):
    busy = "end = time.process_time() + 0.02\n    while time.process_time() < end: pass"
    (tmp_path / "mine.py").write_text(STEADY.replace("time.sleep(LATE_S)", busy))
    with launched([str(tmp_path / "mine.py")], 60.0) as (running_engine,):
        found = too_long(running_engine, "tastes", CASES["turns-1e5"], 4.0)
    assert str(found).startswith("timeout: 1000 s of motion would take 5"), found


def test_an_adaptive_method_that_would_not_end_is_not_waited_for(tmp_path):
    """A microsecond a radian: 1/256 of 1e16 rad would take a year, and is never asked for."""
    busy = """w = np.linalg.norm(world["states"][0, 10:13])
    end = time.process_time() + 1e-6 * w * n * dt
    while time.process_time() < end: pass"""
    text = STEADY.replace("import time", "import time\nimport numpy as np").replace("time.sleep(LATE_S)", busy)
    (tmp_path / "mine.py").write_text(text)
    with launched([str(tmp_path / "mine.py")], 5.0) as (running_engine,):
        found = too_long(running_engine, "tastes", CASES["impulse-1e15"], 0.25)
    assert "s of motion would take 1" in str(found), found
    assert float(str(found).split("take ")[1].split(" s")[0]) > 1e9


def test_a_long_flight_takes_no_more_memory():
    engine = import_module("tumble.compare.engines.tumble")
    scene = CASES["steps-1e8"]

    def flight(steps: int) -> Scene:
        seconds = steps * scene.step
        return replace(scene, duration=seconds, times=np.linspace(0, seconds, 17)[1:])

    def peak(steps: int) -> int:
        flown = flight(steps)
        tracemalloc.start()
        simulate(engine, flown, "rk4", scene.step)
        _, most = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        return most

    simulate(engine, flight(1600), "rk4", scene.step)  # compiles, which takes memory once
    assert peak(1_600_000) < 1.5 * peak(1600)


def test_the_command_runs_a_case_that_is_named_and_says_what_became_of_it(tumble, tmp_path):
    done = tumble("stability", "spin-1e4", "-e", "mujoco:euler+defaults", "-o", "out")
    assert done.returncode == 0, done.stderr
    assert "reset" in done.stdout
    assert "stiffest mode" not in done.stdout, "it is mapped as well"
    (row,) = rows(EXTREMES, read_text("extremes.csv", (tmp_path / "out" / "extremes.csv").read_text(), EXTREMES))
    assert (row.scene, row.verdict, row.size_m) == (
        "spin-1e4",
        "reset",
        pytest.approx(np.sqrt(0.4**2 + 0.15**2 + 0.1**2) / 2),
    )
    assert "silent failures,,mujoco,euler+defaults,,1.0,1," in (tmp_path / "out" / "findings.csv").read_text()
