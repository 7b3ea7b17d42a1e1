"""What `tumble sweep` and `tumble advise` say, of planted runs with known answers."""

import io
import re
from dataclasses import replace

import numpy as np
import pytest

from tumble.compare.judge.cost import Timed
from tumble.compare.judge.errors import Run
from tumble.compare.run.flight import Trajectory, legs
from tumble.compare.run.running_engines import launched
from tumble.compare.run.timing.readings import Reading
from tumble.compare.run.timing.timer import Ready
from tumble.compare.sweep.longer_steps import longer_steps
from tumble.compare.sweep.work_precision import Effort, Sweep, sweep
from tumble.reports.sweep_text import advice_text, sweep_text
from tumble.reports.terminal import console
from tumble.scenarios.frames import vertices
from tumble.scenarios.read import read_scene
from tumble.scenarios.scene import frozen_array
from tumble.scenarios.truth import truth

SCENE = replace(read_scene("two-hits"), impulses=(), times=frozen_array([0.25, 0.5, 0.75, 1.0]), duration=1.0)
TRUTH = truth(SCENE)


def planted(engine: str, method: str, off_m: float, run_ns: float, dt: float = 0.125) -> Timed:
    """Return a run that is off by a known distance and took a known time."""
    states = TRUTH.states.copy()
    states[1:, :, 0] += off_m
    flight = Trajectory(SCENE.rows, states, vertices(states, SCENE.body.points), round(1 / dt), 1e-3, ())
    run = Run(SCENE, engine, method, dt, flight, TRUTH)
    return Timed(run, run_ns, Reading(np.full(8, run_ns * dt)), True, Ready(0.0, 0.0, 0.0, 0))


def said(pieces) -> str:
    out = console(record=True, file=io.StringIO())
    for piece in pieces:
        out.print(piece)
    return out.export_text()


def advised(*timed: Timed, tolerance_m: float = 1e-3, named: tuple[str, ...] = ()) -> str:
    return said(advice_text(Sweep(SCENE, timed, ()), tolerance_m, named))


def answer(text: str) -> str:
    return " ".join(text.partition("\n\n")[0].split())


def test_the_best_engine_that_is_not_ours_stands_beside_ours():
    text = advised(
        planted("tumble", "rk4", 1e-4, 100.0), planted("one", "a", 1e-4, 300.0), planted("two", "b", 1e-4, 200.0)
    )
    assert "use tumble:rk4 with a step of 0.125 s" in answer(text)
    assert "Best other engine: two:b with a step of 0.125 s" in answer(text)


def test_where_another_engine_is_cheapest_it_is_the_answer():
    text = advised(planted("tumble", "rk4", 1e-4, 100.0), planted("one", "a", 1e-4, 30.0))
    assert "use one:a with a step of 0.125 s" in answer(text)
    assert "tumble" not in answer(text)


def test_where_no_other_engine_is_good_enough_the_nearest_is_said():
    far = planted("one", "a", 0.5, 30.0), planted("two", "b", 0.02, 90.0)
    text = answer(advised(planted("tumble", "rk4", 1e-4, 100.0), *far))
    assert "two:b comes closest, with an error of 20 mm" in text
    alone = answer(advised(planted("tumble", "rk4", 1e-4, 100.0)))
    assert "No other engine stays within it: none was measured." in alone
    none = answer(advised(*far))
    assert none.startswith("two-hits: no contestant stays within 1 mm")
    assert "two:b comes closest" in none


def test_the_hand_calculation_is_no_engine_to_use():
    by_hand = planted("handcalc", "as-printed", 1e-5, 10.0)
    text = advised(by_hand, planted("tumble", "rk4", 1e-4, 100.0), planted("one", "a", 1e-4, 300.0))
    assert "use tumble:rk4" in answer(text)
    assert "one:a" in answer(text)
    assert "as-printed" in text, "it has its line in the table"


def test_each_contestant_that_was_named_has_its_line():
    timed = planted("one", "a", 1e-4, 10.0), planted("one", "b", 1e-4, 20.0), planted("one", "c", 0.5, 5.0)
    lines = {name: [line.split()[:2] for line in advised(*timed, named=name).splitlines()] for name in ((), ("one:b",))}
    assert ["one", "b"] not in lines[()]
    assert ["one", "b"] in lines["one:b",]
    both = advised(*timed, named=("one:a", "one:b", "one:c")).splitlines()
    assert [line.split()[1] for line in both if line.startswith("one ")] == ["a", "b", "c"]
    assert next(line for line in both if line.startswith("one c") or line.split()[1:2] == ["c"]).endswith("not reached")


def test_who_is_cheapest_is_who_the_table_says():
    """At 1e-3 m two runs of `fine` lie around 1.0 us, and `coarse` has one run at 1.1 us that no other run equals."""
    timed = (
        planted("tumble", "fine", 1.2e-3, 900.0, 0.5),
        planted("tumble", "fine", 1e-7, 1500.0, 0.25),
        planted("one", "coarse", 9e-4, 1100.0),
    )
    text = said(sweep_text(Sweep(SCENE, timed, ()), "tumble:fine"))
    fine_us, coarse_us = (
        float(re.search(rf"^{who} .*?([\d.]+) \(", text, re.M)[1]) for who in ("tumble:fine", "one:coarse")
    )
    assert fine_us < coarse_us
    assert "fastest: tumble:fine to 1e-03 m and 1e-06 m\n" in text
    assert "own solver: one:coarse to 1e-03 m\n" in text


def test_what_the_intervals_do_not_tell_apart_is_cheapest_together():
    timed = planted("tumble", "a", 1e-4, 100.0), planted("one", "b", 1e-4, 101.0), planted("one", "c", 1e-4, 300.0)
    text = said(sweep_text(Sweep(SCENE, timed, ()), "tumble:a"))
    assert "fastest: tumble:a or one:b to 1e-03 m\n" in text
    assert "own solver: one:b to 1e-03 m\n" in text


def test_longer_steps_end_where_they_are_judged():
    hits = read_scene("two-hits")
    dense = replace(hits, times=frozen_array(np.linspace(0.01, hits.duration, 300)))
    longer = longer_steps(dense)
    cuts = {impulse.time for impulse in hits.impulses} - {0.0}
    assert list(longer) == sorted(longer, reverse=True)
    assert longer
    for dt, scene in longer.items():
        assert cuts < {*scene.times.tolist()}
        assert scene.times[-1] == hits.duration
        assert all(leg.n == 1 and leg.dt <= dt * (1 + 1e-9) for leg in legs(scene, dt))
        assert len(legs(scene, dt)) < 300
    assert longer_steps(replace(hits, impulses=(), times=frozen_array([hits.duration]))) == {}


SPARSE = """
title = "A slow turn, sampled densely"
duration = 2.0
samples = 200
step = 0.002
[body]
shape = "box"
size = [0.4, 0.15, 0.1]
mass = 2.4
angular_velocity = [0.5, -0.3, 0.4]
"""


def test_samples_that_bound_a_step_are_said_and_can_be_passed(tmp_path):
    """By RK4 a body that turns by 1.4 rad needs steps of some tenths of a second for 1 mm; samples are 10 ms apart."""
    (tmp_path / "slow.toml").write_text(SPARSE)
    scene = read_scene(str(tmp_path / "slow.toml"))
    effort, tolerance_m = Effort(budget_s=0.01), 1e-3
    with launched(["tumble:rk4", "mujoco:rk4"]) as running_engines:
        within = sweep(running_engines, scene, effort=effort, enough_m=tolerance_m)
        beyond = sweep(running_engines, scene, effort=effort, enough_m=tolerance_m, beyond_samples=True)
    bound = "--beyond-samples"
    assert bound in answer(said(advice_text(within, tolerance_m)))
    assert bound not in answer(said(advice_text(beyond, tolerance_m)))
    shortest, longer = (
        min(each.run.dt for each in one.timed if each.run.engine == "mujoco") for one in (within, beyond)
    )
    assert shortest == 0.01
    assert longer > 0.1
    best = min((each for each in beyond.timed if each.error_m <= tolerance_m), key=lambda each: each.run_ns)
    true = truth(replace(scene, times=best.run.scene.times))
    off = np.linalg.norm(best.run.flight.vertices - true.vertices, axis=-1)
    assert best.error_m == pytest.approx(off.max(), rel=1e-6), "it is judged where its own steps end"
    assert best.run.flight.steps == len(best.run.scene.times)
