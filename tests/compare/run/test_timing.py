"""What the clocks say is believed only where it is a time: engines that hide their work from one clock are found."""

import csv
import re
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tumble.compare.ablation.optional_features import QUICK
from tumble.compare.run.provenance import conditions
from tumble.compare.run.running_engines import launched
from tumble.compare.run.status import Failure, Status
from tumble.compare.run.timing import machine_load
from tumble.compare.run.timing.machine_load import Machine, other_work
from tumble.compare.run.timing.readings import (
    MORE,
    PROCESS,
    USUAL,
    Ratio,
    Reading,
    Sampling,
    narrow,
    ratio,
    reading,
    round_robin,
)
from tumble.compare.run.timing.timer import Pace, Ready, Sample
from tumble.compare.run.timing.timing import Cost, Load, costs
from tumble.compare.run.worker import Worker
from tumble.compare.sweep.work_precision import BRIEF
from tumble.scenarios.read import read_scene

ROUNDS = Path(__file__).with_name("rounds.csv")

ENGINE = """
import os, queue, subprocess, sys, threading, time
import numpy as np
METHODS = ("m",)
FEATURES = {"gravity"}
ABOUT = {"version": "1", "precision": "double", "switched_off": []}
def burn(ns):
    end = time.thread_time_ns() + ns
    while time.thread_time_ns() < end: pass
def build(scene, method): return {"pending": 0}
def write(world, states): world.update(states=states, pending=0)
def read(world): return world["states"]
def advance(world, n, dt): burn(n * 20_000)
"""
# Each takes 20 us a step, and shows it to one clock only, or to none.
ENGINES = {
    "honest": "",
    "lazy": """
def advance(world, n, dt): world["pending"] += n
def read(world):
    burn(world.pop("pending") * 20_000)
    world["pending"] = 0
    return world["states"]
""",
    "asynchronous": """
tasks = queue.Queue()
def work():
    while True:
        burn(tasks.get() * 20_000)
        tasks.task_done()
threading.Thread(target=work, daemon=True).start()
def advance(world, n, dt): tasks.put(n)
def read(world):
    tasks.join()
    return world["states"]
""",
    "threaded": """
def advance(world, n, dt):
    thread = threading.Thread(target=burn, args=(n * 20_000,))
    thread.start()
    thread.join()
""",
    "elsewhere": """
code = '''
import sys, time
for line in sys.stdin:
    end = time.thread_time_ns() + int(line)
    while time.thread_time_ns() < end: pass
    print(flush=True)
'''
other = subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
def advance(world, n, dt):
    print(n * 20_000, file=other.stdin, flush=True)
    other.stdout.readline()
""",
    "asleep": """
def advance(world, n, dt): time.sleep(n * 20e-6)
""",
    "free": """
def advance(world, n, dt): pass
""",
    "whatever n": """
def advance(world, n, dt): burn(20_000)
""",
}
FINDINGS = {
    "honest": ("thread CPU", ""),
    "lazy": ("thread CPU", "of its work is done when it is read"),
    "asynchronous": ("", "of its work is done when it is read"),
    "threaded": ("", ""),  # the thread waits and another computes: either clock is right, and both say it
    "elsewhere": ("wall", "it waits: wall time is"),
    "asleep": ("wall", "it waits: wall time is"),
}


def timed(folder: Path, name: str) -> Reading | Failure:
    path = folder / "mine.py"
    path.write_text(ENGINE + ENGINES[name])
    with Worker(str(path), 60.0) as worker:
        worker.describe()
        ready = worker.prepare_timer("it", read_scene("yardstick"), "m", Pace(((1, 0.01),), by_step=True))
        if isinstance(ready, Failure):
            return ready
        samples = [worker.sample("it") for _ in range(20)]
    return reading([sample for sample in samples if not isinstance(sample, Failure)])


@pytest.mark.parametrize("name", FINDINGS)
def test_work_is_timed_wherever_it_is_done(tmp_path, name):
    found = timed(tmp_path, name)
    assert isinstance(found, Reading), found
    clock, finding = FINDINGS[name]
    # A sleep, and work that waits for a core somewhere else, end as late as the machine likes.
    assert 18_000 < found.ns < (30_000 if found.clock == "thread CPU" else np.inf), found
    assert clock in found.clock
    assert finding in found.finding
    assert bool(found.finding) == (name != "honest")


@pytest.mark.parametrize("name", ["free", "whatever n"])
def test_what_does_not_grow_with_the_steps_is_no_time(tmp_path, name):
    found = timed(tmp_path, name)
    assert isinstance(found, Failure), found
    assert found.status is Status.UNTIMED
    assert "is no time" in found.reason


def test_an_untimed_engine_is_nobodys_cheapest(tmp_path, tumble):
    (tmp_path / "mine.py").write_text(ENGINE + ENGINES["free"])
    done = tumble("sweep", "yardstick", "-e", "./mine.py", "-e", "tumble:rk4", "-e", "mujoco:euler")
    assert done.returncode == 0, done.stderr
    assert re.search(r"^fastest: tumble:rk4 to ", done.stdout, re.M)
    assert "mine:m: untimed: 1048576 steps in" in done.stdout


# A body that moves and turns a little, and how it makes n steps.
MOVING = """
import gc, itertools, os
from dataclasses import replace
import numpy as np
METHODS = ("a", "b")
FEATURES = {"gravity"}
ABOUT = {"version": "1", "precision": "double", "switched_off": []}
calls = itertools.count()
def build(scene, method): return {"method": method}
def write(world, states): world.update(states=states.copy(), writes=world.get("writes", 0) + 1)
def read(world): return world["states"].copy()
def steps(world, n, dt):
    states = world["states"]
    for _ in range(n):
        states[:, 0:3] += dt * states[:, 7:10]
        states[:, 10:13] += 1e-3 * dt * np.cross(states[:, 10:13], states[:, 0:3])
def advance(world, n, dt):
"""
# What is left out of long calls, or where one start is written again and again: as for a clock, and for no flight.
LESS_WORK = {
    "steps of what was written before": "steps(world, n if world['writes'] < 4 else n // 4, dt)",
    "a quarter of the steps": "steps(world, n if n < 8 else n // 4, dt)",
    "steps four times as long": "steps(world, n, dt) if n < 8 else steps(world, n // 4, 4 * dt)",
    # Of every call: a flight has more calls than a lap, of growing length, so other numbers of steps are left out.
    "the last step": "steps(world, n if n < 2 else n - 1, dt)",
}
ALL_WORK = {
    "the same bits": "steps(world, n, dt)",
    "never the same bits": "steps(world, n, dt); world['states'][:, 0:3] *= 1 + 1e-15 * np.random.random()",
}
NOTHING_TWICE = "steps(world, n, dt); world['states'][:, 0:3] *= 1 + 0.1 * np.random.random()"
OTHER_WORK = "they are not the same work"


def moving(folder: Path, advance: str, more: str = "") -> str:
    (folder / "mine.py").write_text(f"{MOVING}    {advance}\n{more}\n")
    return str(folder / "mine.py")


def cost_of(path: str, by_step: bool = True) -> Cost | Failure:
    scene = read_scene("brick-tumble")
    with launched([f"{path}:a"]) as (running_engine,):
        load = Load(running_engine, scene, "a")
        assert load.by_step == by_step
        return costs({"it": load}, Sampling(span_s=0.0, rounds=4, budget_s=0.0))["it"]


@pytest.mark.parametrize("what", LESS_WORK)
def test_work_that_is_left_out_while_the_timer_runs_is_not_believed(tmp_path, what):
    found = cost_of(moving(tmp_path, LESS_WORK[what]))
    assert isinstance(found, Failure), found
    assert re.match(r"untimed: [xqvw] of throw 0 is .+ after \d+ timed steps .+ untimed: ", str(found))
    assert found.reason.endswith(OTHER_WORK)


@pytest.mark.parametrize("what", ALL_WORK)
def test_an_engine_that_does_all_its_work_has_its_time(tmp_path, what):
    found = cost_of(moving(tmp_path, ALL_WORK[what]))
    assert isinstance(found, Cost), found
    assert found.reading.ns > 0


def test_what_repeats_nothing_has_no_time(tmp_path):
    found = cost_of(moving(tmp_path, NOTHING_TWICE))
    assert isinstance(found, Failure)
    assert found.reason.endswith(OTHER_WORK)


def test_copies_of_a_flight_that_are_left_out_are_missed(tmp_path):
    """What takes its own steps is timed by flights of many copies at once."""
    whole = "WHOLE = {'a'}"
    assert isinstance(cost_of(moving(tmp_path, "steps(world, n, dt)", whole), by_step=False), Cost)
    one = "world['states'][:1, 0:3] += n * dt * world['states'][:1, 7:10]"
    found = cost_of(moving(tmp_path, one, whole), by_step=False)
    assert isinstance(found, Failure)
    assert str(found).startswith("untimed: x of throw 1 is ")


def sweep_tables(tumble, folder: Path, engine: str) -> tuple[str, list[dict[str, str]], list[dict[str, str]]]:
    """What a sweep of an engine beside ours prints, and its tables of errors and times, and of what digits cost."""
    done = tumble("sweep", "brick-tumble", "-e", engine, "-e", "tumble:rk4", "-o", "out")
    assert done.returncode == 0, done.stderr
    assert "Warning" not in done.stderr
    tables = [(folder / "out" / name).read_text() for name in ("work-precision.csv", "accuracy-cost.csv")]
    measured, digits = (list(csv.DictReader(text.splitlines())) for text in tables)
    return done.stdout, measured, digits


def test_who_does_less_work_for_the_clock_is_on_no_frontier(tmp_path, tumble):
    moving(tmp_path, LESS_WORK["steps of what was written before"])
    said, measured, digits = sweep_tables(tumble, tmp_path, "./mine.py:a")
    assert "mine:a: untimed: " in said
    assert {row["engine"] for row in measured if row["pareto_front"] == "True"} == {"tumble"}
    mine = [row for row in digits if row["engine"] == "mine"]
    assert {row["verdict"] for row in mine} == {"untimed"}
    assert all(row["no_ratio"].endswith(OTHER_WORK) for row in mine)


def test_a_contestant_whose_process_ends_while_it_is_timed_leaves_the_others_their_times(tmp_path):
    """All methods of an engine have one process: the others' timers are made anew in the next."""
    path = moving(tmp_path, "steps(world, n, dt) if world['method'] == 'a' or next(calls) < 200 else os._exit(3)")
    scene = read_scene("brick-tumble")
    with launched([path, "tumble:rk4"]) as (mine, ours):
        loads = {"b": Load(mine, scene, "b"), "a": Load(mine, scene, "a"), "rk4": Load(ours, scene, "rk4")}
        found = costs(loads, Sampling(span_s=0.0, rounds=120, budget_s=0.0))
    assert found["b"] == Failure(
        Status.UNTIMED, "its process ended while it was timed: crashed: its process ended with code 3"
    )
    for key in ("a", "rk4"):
        cost = found[key]
        assert isinstance(cost, Cost), cost
        assert len(cost.reading.samples) == 120


@pytest.mark.parametrize("ns", ["0.0", "-1.0", "float('nan')", "float('inf')"])
def test_a_clock_that_reads_no_time_costs_one_contestant_alone(tmp_path, tumble, ns):
    """An engine file is in the timer's process, and can do there what it likes to the clock."""
    forged = f"""
classes = [one for one in gc.get_objects() if isinstance(one, type) and hasattr(one, "sample")]
(timer,) = [one for one in classes if one.__name__ == "Timer"]
timer.sample = lambda self, made=timer.sample: replace(made(self), advance=({ns},) * 3 + (0.0,), deferred=(0.0,) * 4)
"""
    moving(tmp_path, "steps(world, n, dt)", forged)
    said, measured, _ = sweep_tables(tumble, tmp_path, "./mine.py:a")
    assert re.search(r"mine:a: untimed: (the clock stood still|its clock showed no number) while it was timed", said)
    assert {row["engine"] for row in measured} == {"tumble"}
    assert len(measured) > 5


def rows_of(path: Path) -> dict[str, dict[str, str]]:
    return {row["engine"]: row for row in csv.DictReader(path.read_text().splitlines())}


@pytest.mark.parametrize("name", ["lazy", "asynchronous"])
def test_work_that_is_left_to_be_read_counts_in_compare(tmp_path, tumble, name):
    (tmp_path / "mine.py").write_text(ENGINE + ENGINES[name])
    done = tumble("compare", "yardstick", "-e", "./mine.py", "--dt", "0.02", "-o", "out")
    assert done.returncode == 0, done.stderr
    assert float(rows_of(tmp_path / "out" / "runs.csv")["mine"]["wall_ns_per_step"]) > 18_000


def test_work_that_is_left_to_be_read_counts_in_check(tmp_path, tumble):
    """20 us a step, where our own rk4 takes a thousandth of that."""
    (tmp_path / "mine.py").write_text(ENGINE + ENGINES["asynchronous"])
    done = tumble("check", "yardstick", "-e", "./mine.py", "-e", "tumble:rk4", "--accept", "-o", "record")
    assert done.returncode == 0, done.stderr
    assert float(rows_of(tmp_path / "record" / "times.csv")["mine"]["time_ratio_low"]) > 50


def flat(thread: float, process: float, wall: float, deferred=0.0, queued=0.0) -> Reading:
    return reading([Sample((thread, process, wall, queued), (deferred, deferred, deferred, 0.0))] * 8)


def test_the_right_clock_is_chosen():
    assert flat(100, 101, 105).clock == "thread CPU"
    assert flat(100, 190, 105).clock == "process CPU"
    assert (flat(1, 1, 105).clock, flat(1, 1, 105).ns) == ("wall", 105)
    assert flat(1, 180, 105).ns == 180, "two threads for half as long"
    assert flat(10, 10, 10, 90).ns == 100
    assert flat(100, 100, 100, 1).finding == "", "the first read of cold memory"
    assert flat(100, 100, 900, queued=800).clock == "thread CPU", "others had the core"
    assert (flat(1, 1, 900, queued=500).clock, flat(1, 1, 900, queued=500).ns) == ("wall", 900)
    # Interrupted now and then: not its own doing.
    late = (0, 0, 0, 9, 9, 9, 9, 9)
    held_up = [Sample((100.0, 100.0, 100.0 * (1 + more), 0.0), (0.0,) * 4) for more in late]  # type: ignore[arg-type]
    assert reading(held_up).clock == "thread CPU"


def test_a_process_that_ended_has_no_ratio():
    gone = reading([Sample((np.nan,) * 4, (np.nan,) * 4)] * 8)  # type: ignore[arg-type]
    assert ratio(gone, flat(1, 1, 1)).refusal.startswith("its process ended while it was timed: load ")


def test_a_clock_that_stood_still_has_no_ratio():
    still = Reading(np.array([1.0] * 23 + [0.0]))
    for found in (ratio(still, Reading(np.ones(24))), ratio(Reading(np.ones(24)), still)):
        assert found.refusal.startswith("the clock stood still while it was timed: load ")


def test_a_ratio_is_told_however_wide_its_interval():
    """Samples that a machine with other work has made ten times as long by turns."""
    wild = Reading(np.random.default_rng(1).choice([1.0, 10.0], 48))
    found = ratio(wild, Reading(np.ones(48)))
    assert found.refusal == ""
    assert found.low < 1.05
    assert found.high > 9.5


def test_rounds_are_added_until_ratios_are_narrow_or_the_budget_ends():
    draw = np.random.default_rng(5)

    def sampler(spread: float):
        return lambda: Sample((float(np.exp(draw.normal(0.0, spread))),) * 4, (0.0,) * 4)  # type: ignore[arg-type]

    calm = round_robin({"a": sampler(0.01), "b": sampler(0.01)}, span_s=0.0, rounds=24, budget_s=30.0)
    wild = round_robin({"a": sampler(0.3), "b": sampler(0.3)}, span_s=0.0, rounds=24, budget_s=30.0)
    assert len(calm["a"].samples) == 24
    assert 24 < len(wild["a"].samples) < 2000
    assert narrow(list(wild.values()))
    hopeless = round_robin({"a": sampler(5.0), "b": sampler(5.0)}, span_s=0.0, rounds=24, budget_s=0.2)
    assert not narrow(list(hopeless.values()))


def test_rounds_are_added_for_those_whose_ratio_to_the_unit_is_wide():
    draw, calls = np.random.default_rng(5), dict.fromkeys(("unit", "calm", "wild", "hopeless", "dead"), 0)
    pace = np.exp(0.3 * draw.normal(size=200))

    def sampler(key: str, spread: float):
        def sample() -> Sample | Failure:
            calls[key] += 1
            if key == "dead" and calls[key] > 3:
                return Failure(Status.CRASHED, "dead")
            # The machine slows all of a round alike.
            ns = float(pace[calls["unit"] - 1] * np.exp(draw.normal(0.0, spread)))
            return Sample((ns,) * 4, (0.0,) * 4)  # type: ignore[arg-type]

        return sample

    spreads = {"unit": 0.001, "calm": 0.001, "wild": 0.06, "hopeless": 5.0, "dead": 0.001}
    samplers = {key: sampler(key, spread) for key, spread in spreads.items()}
    found = round_robin(samplers, span_s=0.0, rounds=8, budget_s=30.0, units={"unit"})
    assert calls["calm"] == 8
    assert 8 < calls["wild"] < calls["unit"] == calls["hopeless"] == 8 * MORE
    assert isinstance(found["dead"], Failure)
    # By the rounds that both have, in which the machine was as slow for one as for the other.
    assert ratio(found["calm"], found["unit"]).value == pytest.approx(1.0, abs=0.01)  # type: ignore[arg-type]
    assert ratio(found["unit"], found["calm"]).high < 1.05  # type: ignore[arg-type]


def recorded() -> dict[str, list[np.ndarray]]:
    """ENGINE:METHOD -> the samples of each process [ns], (rounds,): 30 new processes of each, on a busy machine."""
    with ROUNDS.open(newline="") as file:
        rows = list(csv.DictReader(file))
    names = [name for name in rows[0] if name not in ("process", "round")]
    processes = sorted({int(row["process"]) for row in rows})
    return {
        name: [np.array([float(row[name]) for row in rows if int(row["process"]) == each]) for each in processes]
        for name in names
    }


def covered_of_recorded(of: Callable[[Reading, Reading], Ratio]) -> tuple[float, float]:
    """In how many runs the interval covers the ratio that all processes say together; how wide it is, half of it."""
    samples = recorded()
    reference = samples.pop("tumble:rk4")
    covered, widths = [], []
    for own in samples.values():
        found = [of(Reading(a), Reading(b)) for a, b in zip(own, reference, strict=True)]
        middle = np.median([one.value for one in found])
        covered += [one.low <= middle <= one.high for one in found]
        widths += [np.sqrt(one.high / one.low) - 1 for one in found]
    assert len(covered) >= 100
    return float(np.mean(covered)), float(np.median(widths))


def test_intervals_of_recorded_samples_cover_what_all_processes_say_together():
    share, width = covered_of_recorded(ratio)
    assert share >= 0.95
    assert width < 0.1, "an interval that covers everything says nothing"


@pytest.mark.parametrize("few", sorted({USUAL.rounds, BRIEF.sampling.rounds, QUICK.rounds}))
def test_few_rounds_cover_it_too(few):
    share, _ = covered_of_recorded(lambda a, b: ratio(Reading(a.samples[:few]), Reading(b.samples[:few])))
    assert share >= 0.95


def unpaired(a: Reading, b: Reading) -> Ratio:
    """The interval of two medians that know nothing of one another, by the usual bootstrap."""
    draw, count = np.random.default_rng(0), len(a.samples)
    logs = [np.median(np.log(each.samples)[draw.integers(0, count, (400, count))], axis=1) for each in (a, b)]
    return Ratio(*np.exp(np.quantile(logs[0] - logs[1], (0.5, 0.025, 0.975))).tolist())


def thinner(factor: float) -> Callable[[Reading, Reading], Ratio]:
    """Intervals that are so many times as wide as ours."""

    def of(a: Reading, b: Reading) -> Ratio:
        found = ratio(a, b)
        low, high = ((end / found.value) ** factor * found.value for end in (found.low, found.high))
        return Ratio(found.value, low, high)

    return of


def of_one_process(a: Reading, b: Reading) -> Ratio:
    """What chance leaves within one process, and no more."""
    found = ratio(a, b)
    return Ratio(found.value, found.low * np.exp(PROCESS), found.high / np.exp(PROCESS))


WRONG: dict[str, Callable[[Reading, Reading], Ratio]] = {
    "unpaired": unpaired,
    "half as wide": thinner(0.5),
    "rounds dropped": lambda a, b: ratio(Reading(a.samples[:4]), Reading(b.samples[:4])),
    "new processes are as this one": of_one_process,
}


@pytest.mark.parametrize("how", WRONG)
def test_intervals_that_are_made_wrongly_do_not_cover_recorded_samples(how):
    assert covered_of_recorded(WRONG[how])[0] < 0.92


def test_what_the_machine_does_to_both_leaves_ratio_and_interval_alone():
    """A machine that is by turns ten times as slow: rounds are paired, so that it cancels."""
    draw = np.random.default_rng(3)
    a, b = (Reading(draw.lognormal(0.0, 0.02, 48)) for _ in range(2))
    pace = draw.lognormal(0.0, 1.0, 48)
    calm, wild = ratio(a, b), ratio(Reading(a.samples * pace), Reading(b.samples * pace))
    assert (wild.value, wild.low, wild.high) == pytest.approx((calm.value, calm.low, calm.high))


def test_ratios_on_a_busy_machine_are_those_of_a_quiet_one():
    """A known ratio, 3, whatever the machine does: two loops of the same kind, beside a process that burns a core.

    A hundred runs, each as the rounds of a command are.  How many of the intervals cover it depends on what the machine
    does; that 95 of 100 did on one that was recorded is tested above.
    """
    burner = subprocess.Popen([sys.executable, "-c", "while True: pass"])
    try:
        with Worker(str(Path(__file__).parents[2] / "plugins" / "mine.py"), 60.0) as worker:
            worker.describe()
            scene = read_scene("yardstick")
            for key, steps in (("one", 1), ("three", 3)):
                ready = worker.prepare_timer(key, scene, "semi-implicit-euler", Pace(((steps, 0.01),), by_step=True))
                assert isinstance(ready, Ready), ready
            found = []
            for _ in range(100):
                taken = [worker.sample(key) for _ in range(24) for key in ("one", "three")]
                assert not any(isinstance(each, Failure) for each in taken)
                found.append(ratio(reading(taken[1::2]), reading(taken[::2])))  # type: ignore[arg-type]
    finally:
        burner.kill()
        burner.wait()
    # Times that are not of the same rounds, or not of the thread, are off by what the burner takes: by a half.
    assert np.median([one.value for one in found]) == pytest.approx(3.0, rel=0.1)
    assert sum(one.low <= 3.0 <= one.high for one in found) > 50, found


def looks(work: float, stolen: float = 0.0) -> tuple[Machine, Machine]:
    return Machine(100.0, 50.0, 1.0), Machine(110.0, 60.0 + 10.0 * work, 1.0 + 10.0 * stolen)


def test_other_work_on_the_machine_is_seen(monkeypatch):
    monkeypatch.setattr(machine_load, "share_of_frequency", lambda: 1.0)
    monkeypatch.setattr(machine_load.os, "cpu_count", lambda: 4)
    assert other_work(*looks(0.1, 0.01)) == ""
    assert other_work(*looks(1.5)) == "other processes used 1.5 of 4 cores"
    assert other_work(*looks(0.0, 0.4)) == "the host took 10% of the time"
    monkeypatch.setattr(machine_load, "share_of_frequency", lambda: 0.5)
    assert other_work(*looks(0.0)) == "the processors ran at 50% of their frequency"


def test_other_work_is_logged_once_and_stands_in_the_conditions(monkeypatch, caplog):
    """Beside processes of the test's own that burn two cores; the clock's own work is no other work's."""
    monkeypatch.setattr(machine_load, "seen", [])
    burners = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(2)]
    sample = Sample((1e6,) * 4, (0.0,) * 4)  # type: ignore[arg-type]

    def working() -> Sample:
        until = time.thread_time() + 0.002
        while time.thread_time() < until:
            pass
        return sample

    try:
        for _ in range(2):
            round_robin({"a": working}, span_s=1.0, rounds=24)
    finally:
        for burner in burners:
            burner.kill()
            burner.wait()
    assert len(caplog.messages) == 1, "twice sampled, once logged"
    assert "other processes used" in caplog.messages[0]
    assert [row.value for row in conditions("x") if row.what == "other work"] == machine_load.seen
