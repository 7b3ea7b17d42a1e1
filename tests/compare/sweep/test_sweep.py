"""The ladder, the clock and what is read off them: on planted runs with known answers, and on a real sweep."""

import re
import subprocess
import sys
from dataclasses import replace
from itertools import groupby, islice, pairwise, product
from time import thread_time_ns
from types import ModuleType

import numpy as np
import pytest

from tumble.compare.judge.errors import Run
from tumble.compare.judge.orders import Level, local_orders
from tumble.compare.run.engines.registry import Finding
from tumble.compare.run.flight import Trajectory
from tumble.compare.run.running_engines import launched
from tumble.compare.run.timing.readings import PROCESS, Reading, round_robin
from tumble.compare.run.timing.timer import Pace, Ready, Timer
from tumble.compare.sweep import work_precision
from tumble.compare.sweep.longer_steps import COUNTS
from tumble.compare.sweep.pareto_front import (
    accuracy_cost_rows,
    by_contestant,
    equivalent_rows,
    order_rows,
    pareto_front,
    reach,
    work_precision_rows,
)
from tumble.compare.sweep.results import measured
from tumble.compare.sweep.schemas import AccuracyCostRow
from tumble.compare.sweep.work_precision import (
    LAST_HALVINGS,
    TARGETS_M,
    Effort,
    Sweep,
    Timed,
    at_floor,
    climb,
    ladders,
    levels,
    may_reach,
    sweep,
)
from tumble.reports.sweep_text import cost
from tumble.scenarios.frames import vertices
from tumble.scenarios.read import read_scene
from tumble.scenarios.truth import truth
from tumble.solver.collocation.newton import FURTHEST_TURN

SCENE = replace(read_scene("two-hits"), impulses=(), times=np.array([1.0]), duration=1.0)
TRUTH = truth(SCENE)


def planted(dt: float, off_m: float, run_ns: float, method="planted", notes=(), factors=(1.0, 1.0)) -> Timed:
    """Return a run that is off by a known distance and took a known time, its halves that many times as long."""
    states = TRUTH.states.copy()
    states[1:, :, 0] += off_m
    flight = Trajectory(SCENE.rows, states, vertices(states, SCENE.body.points), round(1 / dt), 1e-3, notes)
    samples = np.repeat(factors, 10) * run_ns * dt
    return Timed(Run(SCENE, "mine", method, dt, flight, TRUTH), run_ns, Reading(samples), True, Ready(0.0, 0.0, 0.0, 0))


def ladder(order: float, constant: float, count=12, method="planted", speed=1.0) -> list[Timed]:
    steps = [2.0**-k for k in range(count)]
    return [planted(dt, constant * dt**order, 100.0 / dt / speed, method) for dt in steps]


def of(timed: list[Timed]) -> Sweep:
    return Sweep(SCENE, tuple(timed), ())


@pytest.mark.parametrize("order", [1, 2, 4])
def test_the_order_is_read_off_the_errors(order):
    (row,) = order_rows(of(ladder(order, 1e-2)))
    # The planted position is rounded to 1e-16 m.
    assert row.order == pytest.approx(order, abs=1e-3)
    assert row.order_high - row.order_low < 0.01
    assert row.translation_m == pytest.approx(1e-2 * row.dt_s**order)
    assert row.attitude_m == 0


def test_the_order_is_read_off_the_last_steps_where_large_errors_rose_before():
    """A tumbling body's errors need not fall until they are small; a sequence may end before they are."""
    errors_m = (0.02, 0.025, 0.02, 0.01, 0.005, 0.0025, 0.00125)
    (row,) = order_rows(of([planted(2.0**-k, off_m, 100.0 * 2**k) for k, off_m in enumerate(errors_m)]))
    assert row.order == pytest.approx(1.0)


def test_the_order_is_read_off_the_steps_that_were_taken():
    """Samples cut each run into one step more than its stated step says."""
    counts = (4, 6, 8, 12, 16, 24)
    cut = [planted(1 / count, 1e-2 / (count + 1) ** 2, 100.0 * count) for count in counts]
    for each, count in zip(cut, counts, strict=True):
        object.__setattr__(each.run, "answer", replace(each.run.flight, steps=count + 1))
    (row,) = order_rows(of(cut))
    assert row.order == pytest.approx(2, abs=1e-3)
    steps = {(each.dt_s, each.dt_taken_s) for each in work_precision_rows(of(cut))}
    assert steps == {(1 / count, 1 / (count + 1)) for count in counts}
    (digit,) = (each for each in accuracy_cost_rows(of(cut), "mine:planted") if each.target_m == 1e-3)
    assert (digit.dt_s, digit.dt_taken_s) == (1 / 4, 1 / 5)


def test_steps_that_samples_cut_to_one_length_are_one_run_and_hide_no_order():
    ladder = [Level(0.02, 1e-4, 0.0), Level(0.02, 1e-4, 0.0), Level(0.01, 2.5e-5, 0.0), Level(0.005, 6.25e-6, 0.0)]
    assert local_orders(ladder, 1.0) == pytest.approx([2.0, 2.0])


def test_where_smaller_steps_stop_paying():
    errors = [1e-3 * 2.0 ** (-4 * k) if k < 6 else 1e-10 * 2.0 ** (k - 6) for k in range(12)]
    (row,) = order_rows(of([planted(2.0**-k, off, 100.0 * 2**k) for k, off in enumerate(errors)]))
    assert row.bends
    assert row.best_dt_s == 2.0**-6
    assert row.worsens
    assert (row.finest_dt_s, row.finest_error_m) == (2.0**-11, pytest.approx(32e-10))
    single = of([replace(each, run=replace(each.run, rounding=2.0**-24)) for each in ladder(1, 1e-2)])
    (straight,) = order_rows(single)
    assert not straight.worsens
    assert straight.precision == "single"
    furthest = float(abs(TRUTH.vertices).max())
    assert straight.rounding_m == pytest.approx(furthest * 2.0**-24, rel=1e-2)
    assert row.order == pytest.approx(4, abs=0.2)


def test_what_a_digit_costs_is_interpolated_on_the_frontier():
    # error = 1e-2 dt, time = 100/dt ns: 1e-3 m at dt = 0.1 takes 1000 ns, between the measured 1/8 and 1/16.
    verdict, run_ns, run = reach(ladder(1, 1e-2), 1e-3)
    assert (verdict, run.run.dt) == ("reached", 1 / 16)
    assert run_ns == pytest.approx(1000.0)


def test_nothing_is_extrapolated():
    coarse_enough = ladder(1, 1e-4)
    assert reach(coarse_enough, 1e-3)[0] == "at most"
    assert reach(coarse_enough, 1e-12) == ("not reached", None, None)


def test_a_flagged_run_never_counts():
    flagged = planted(0.5, 1e-9, 1.0, notes=(Finding("clamped", "clamped"),))
    assert reach([flagged, *ladder(1, 1e-2)], 1e-9) == ("not reached", None, None)
    assert flagged not in pareto_front([flagged, *ladder(1, 1e-2)])


def test_a_costlier_run_with_no_smaller_error_is_not_on_the_frontier():
    good, bad = planted(0.5, 1e-3, 10.0), planted(0.25, 1e-3, 20.0)
    assert pareto_front([bad, good]) == [good]


def test_errors_below_the_limit_are_the_limit():
    assert planted(0.5, 0.0, 1.0).error_m == TRUTH.resolution.max()


def test_ratios_are_quoted_against_one_contestant_with_their_interval():
    slow, fast = ladder(1, 1e-2, method="slow"), ladder(1, 1e-2, method="fast", speed=4.0)
    rows = {(row.method, row.target_m): row for row in accuracy_cost_rows(of(slow + fast), "mine:fast")}
    row = rows["slow", 1e-3]
    assert row.ratio == pytest.approx(4.0)
    assert row.ratio_low < 4.0 < row.ratio_high
    assert (row.ratio_high / row.ratio_low) ** 0.5 - 1 == pytest.approx(PROCESS, rel=0.05), "its samples are all alike"
    assert rows["fast", 1e-3].ratio == pytest.approx(1.0)
    assert (rows["slow", 1e-12].ratio, rows["slow", 1e-12].no_ratio) == (None, "")


def slow_rows(factors: tuple[float, float]) -> list[AccuracyCostRow]:
    """What is said of a contestant whose samples are by turns so many times as long as those of another."""
    fast = ladder(1, 1e-2, method="fast", speed=4.0)
    steps = [each.run.dt for each in fast]
    wild = [planted(dt, 1e-2 * dt, 100.0 / dt, "slow", (), factors) for dt in steps]
    return [row for row in accuracy_cost_rows(of(wild + fast), "mine:fast") if row.method == "slow" and row.run_us]


def test_a_ratio_that_is_hardly_known_is_told_as_its_interval():
    rows = slow_rows((1.0, 9.0))
    assert rows
    for row in rows:
        assert row.ratio_low < 4.5
        assert row.ratio_high > 35
        assert row.no_ratio == ""
        assert re.search(r" \([\d.]+ to [\d.]+\)$", cost(row))


@pytest.mark.parametrize("factors", [(0.0, 0.0), (1.0, 0.0), (1.0, -1.0), (1.0, np.nan), (1.0, np.inf)])
def test_what_has_no_time_is_on_no_frontier_and_costs_nobody_else_a_row(factors):
    honest = ladder(1, 1e-2)
    alone = of(honest)
    # Nearer and cheaper than anybody, if its clock could be believed.
    wild = [planted(each.run.dt, 1e-4 * each.run.dt, 1e-3, "wild", (), factors) for each in honest]
    beside = of(wild + honest)
    assert list(work_precision_rows(beside)) == list(work_precision_rows(alone))
    assert any(row.pareto_front for row in work_precision_rows(beside))
    assert list(accuracy_cost_rows(beside, "mine:planted")) == list(accuracy_cost_rows(alone, "mine:planted"))


def test_what_is_untimed_says_so_at_every_digit():
    honest, wild = ladder(1, 1e-2), ladder(1, 1e-2, method="wild")
    why = "untimed: the clock stood still while it was timed: load 1.0 on 2 cores"
    found = Sweep(SCENE, tuple(honest), tuple(each.run for each in wild), {"mine:wild": why})
    rows = [row for row in accuracy_cost_rows(found, "mine:planted") if row.method == "wild"]
    assert [(row.target_m, row.verdict, row.run_us, row.no_ratio) for row in rows] == [
        (target, "untimed", None, why) for target in TARGETS_M
    ]
    assert {cost(row) for row in rows} == {"untimed"}


def test_one_integrator_under_two_names_is_found():
    a, b, c = (ladder(1, 1e-2, method=name) for name in "abc")
    b = [planted(each.run.dt, 1e-2 * each.run.dt + 1e-9, each.run_ns, "b") for each in b]
    c = [planted(each.run.dt, -1e-2 * each.run.dt, each.run_ns, "c") for each in c]
    (row,) = equivalent_rows(of(a + b + c))
    assert (row.contestant_a, row.contestant_b) == ("mine:a", "mine:b")


def test_the_ladder_ends_at_the_floor_and_not_before():
    falling = [each.run for each in ladder(1, 1e-2)]
    assert not at_floor(falling)
    flat = [planted(2.0**-k, 1e-8, 1.0).run for k in range(4)]
    assert at_floor(falling[:3] + flat)
    rough = [planted(2.0**-k, 1.0, 1.0).run for k in range(6)]
    assert not at_floor(rough), "errors as large as the body say nothing about small steps"


def test_the_last_halvings_are_made_where_an_error_that_is_reported_may_be_among_them():
    first_order = [each.run for each in ladder(1, 1e-2)]  # 1e-2/2048 m at the end
    assert may_reach(first_order, [1.3e-6], 2)
    assert not may_reach(first_order, [1.2e-6, 1e-5], 2)
    assert may_reach(first_order, [1.2e-6], 3)
    assert may_reach([each.run for each in ladder(2, 1e-2, 6)], [1e-6], 2), "by its own order"
    assert may_reach(first_order[:3], [1e-9], 2), "two pairs of levels tell no order"
    bent = [*first_order[:3], planted(2.0**-3, 1e-2 * 2.0**-4, 1.0).run]
    assert may_reach(bent, [1e-9], 2), "of orders 1, 1 and 2 none is known"


def test_a_shorter_sequence_reaches_every_error_that_a_whole_one_reaches(monkeypatch):
    names = ("tumble:symplectic-euler", "tumble:matrix-euler", "mujoco:euler", "pybullet")
    budgets_s = (0.004, 0.008, 0.016)
    found: dict[int, list[list[float]]] = {LAST_HALVINGS: [], 0: []}
    with launched(names) as running_engines:
        for halvings, budget_s in product(found, budgets_s):
            monkeypatch.setattr(work_precision, "LAST_HALVINGS", halvings)
            runs = ladders(running_engines, SCENE, effort=Effort(budget_s))
            for _, own in groupby(runs, lambda run: (run.engine, run.method)):
                found[halvings].append([float(run.distances.max()) for run in own])
    for shorter, whole in zip(found[LAST_HALVINGS], found[0], strict=True):
        assert [min(shorter) <= target for target in TARGETS_M] == [min(whole) <= target for target in TARGETS_M]
    assert sum(map(len, found[LAST_HALVINGS])) < sum(map(len, found[0]))


def burner(ns_per_step: int) -> ModuleType:
    """Return an engine whose step takes a known thread CPU time."""
    engine = ModuleType("burner")

    def advance(world, n, dt):
        end = thread_time_ns() + n * ns_per_step
        while thread_time_ns() < end:
            pass

    engine.build = lambda scene, method: {}  # type: ignore[attr-defined]
    engine.write = lambda world, states: None  # type: ignore[attr-defined]
    engine.advance = advance  # type: ignore[attr-defined]
    engine.read = lambda world: SCENE.start  # type: ignore[attr-defined]
    return engine


def test_the_clock_reads_a_known_ratio():
    pace = Pace(((1, 0.01),), by_step=True)
    slow, fast = (Timer(burner(ns), SCENE, "", pace) for ns in (30_000, 10_000))
    readings = round_robin({"slow": slow.sample, "fast": fast.sample}, span_s=0.0, rounds=10)
    # Each step ends up to one reading of the clock, 1 us, late.
    assert readings["slow"].ns / readings["fast"].ns == pytest.approx(3.0, rel=0.15)
    assert readings["fast"].ns == pytest.approx(10_000, rel=0.15)


@pytest.fixture(scope="module")
def real() -> Sweep:
    with launched(["tumble:rk4", "mujoco:euler", "mujoco:rk4", "pybullet:multibody"]) as running_engines:
        assert next(levels(running_engines[0], SCENE, "rk4")) == ("rk4", 1.0)
        return sweep(running_engines, SCENE)


def test_a_real_ladder_has_four_levels_a_decade_around_each_error_that_is_reported(real):
    for timed in by_contestant(real.timed).values():
        # From two steps a flight on: one and two are an octave apart.
        ladder = sorted((each for each in timed if each.run.dt < SCENE.duration), key=lambda each: each.run.dt)
        for fine, coarse in pairwise(ladder):
            assert coarse.run.dt / fine.run.dt <= 2.0
            if any(fine.error_m <= target < coarse.error_m for target in TARGETS_M):
                assert coarse.run.dt / fine.run.dt < 10**0.25


def test_every_level_is_run_while_it_is_cheap():
    with launched(["tumble:rk4", "tumble:symplectic-euler"]) as (solver,):
        counts = [round(SCENE.duration / dt) for _, dt in islice(levels(solver, SCENE, "rk4"), 20)]
        assert counts == list(COUNTS[:20])
        costly = [round(SCENE.duration / dt) for _, dt in levels(solver, SCENE, "rk4") if dt < 1e-7]
    assert costly
    assert all(count.bit_count() == 1 for count in costly)


@pytest.mark.parametrize("method", ["gauss6", "radau5"])
def test_a_sweep_has_no_step_that_is_taken_in_parts(method):
    """A step that turns the body by 29 rad was one in the table, with the error of its parts without their cost."""
    scene = read_scene("yardstick")
    true = truth(scene)
    with launched([f"tumble:{method}"]) as (solver,):
        found = climb(solver, {None: (scene, true)}, method, Effort(), 0.0)
    fastest = float(np.linalg.norm(true.states[..., 10:13], axis=-1).max())
    assert all(each.dt * fastest <= FURTHEST_TURN for each in found)
    errors = [float(each.run(scene, "tumble", true).distances.max()) for each in found]
    assert min(errors) < 1e-11
    assert errors[0] > 1e3 * min(errors)


def test_real_orders_and_equals_are_found(real):
    orders = {f"{row.engine}:{row.method}": row.order for row in order_rows(real)}
    assert orders["tumble:rk4"] == pytest.approx(4, abs=0.2)
    assert orders["mujoco:rk4"] == pytest.approx(4, abs=0.2)
    assert orders["mujoco:euler"] == pytest.approx(1, abs=0.2)
    assert {(row.contestant_a, row.contestant_b) for row in equivalent_rows(real)} == {
        ("mujoco:euler", "pybullet:multibody")
    }


def test_every_timed_run_has_its_row_with_the_clocks_time(real):
    rows = list(work_precision_rows(real))
    assert [row.error_m for row in rows] == [each.error_m for each in real.timed]
    assert all(0 < row.run_us <= row.p90_run_us for row in rows)
    assert all(row.run_us == pytest.approx(row.steps * row.step_ns / 1e3) for row in rows)
    per_step = {(row.engine, row.method): set() for row in rows}
    for row in rows:
        per_step[row.engine, row.method].add(round(row.step_ns, 6))  # pyright: ignore[reportCallIssue]
    assert all(len(times) == 1 for times in per_step.values()), "one clock reading serves a whole ladder"


def test_what_is_called_wall_is_the_wall_time_of_the_flight(real):
    runs = measured([real], "tumble:rk4")["runs.csv"]
    flown = [run for run in real.runs if run.status == "ok"]
    assert len(flown) > 10
    assert list(runs[runs["status"] == "ok"]["wall_s"]) == [run.flight.wall_s for run in flown]


SLEEPY = """
import os, time
METHODS = ("drifts",)
FEATURES = {"gravity"}
STEP_NS = 100_000
ABOUT = {"version": "1", "precision": "double", "switched_off": []}
def build(scene, method): return {}
def write(world, states): world["states"] = states
def advance(world, n, dt):
    time.sleep(LATE_S)
    world["states"][:, 0:3] += n * dt * (1 + dt) * world["states"][:, 7:10]
def read(world): return world["states"]
"""


def test_a_ladder_has_the_same_rungs_whatever_the_machine_does(tmp_path):
    """Beside a process that burns a core, and with steps that take a hundred times as long: what a clock would see."""
    found = []
    for name, late_s in (("quiet", "0.0"), ("busy", "0.02")):
        (tmp_path / name).mkdir()
        path = tmp_path / name / "sleepy.py"
        path.write_text(SLEEPY.replace("LATE_S", late_s))
        burner = subprocess.Popen([sys.executable, "-c", "while True: pass"]) if name == "busy" else None
        try:
            with launched([str(path)]) as (sleepy,):
                found.append([each.dt for each in climb(sleepy, {None: (SCENE, TRUTH)}, "drifts", Effort(0.01), 0.0)])
        finally:
            if burner:
                burner.kill()
                burner.wait()
    quiet, busy = found
    assert quiet == busy
    # 100 steps by what it says of itself; of more than 3 every second level is left out, and the last two of all, which
    # reach no error that is reported.
    assert [round(SCENE.duration / dt) for dt in quiet] == [1, 2, 3, 4, 8, 16]


def test_our_rk4_reaches_a_millionth_sooner_than_mujocos(real):
    own, theirs = (reach(by_contestant(real.timed)[name, "rk4"], 1e-6)[1] for name in ("tumble", "mujoco"))
    assert own < theirs
