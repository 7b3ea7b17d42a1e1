"""Every verdict is planted: a true flight is doctored, or an engine that hides its blow-up is flown."""

import importlib
import importlib.util
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tumble.compare.engines import FINDINGS
from tumble.compare.judge.balance import energies, mechanical_energy
from tumble.compare.judge.errors import Run
from tumble.compare.judge.verdict import AUDITED, HOLDS, WORDS, bounded, verdict
from tumble.compare.run.engines.registry import Finding
from tumble.compare.run.flight import Trajectory, simulate
from tumble.compare.run.status import Failure, Status
from tumble.compare.stability.columns import columns
from tumble.scenarios.frames import Array, quaternion_product, vertices
from tumble.scenarios.read import read_scene
from tumble.scenarios.scene import Scene
from tumble.scenarios.truth import truth

PLUGINS = Path(__file__).parents[2] / "plugins"
ROWS = 33
FREE = read_scene("brick-tumble")
FREE = replace(FREE, duration=4.0, times=np.linspace(0, 4.0, ROWS)[1:])
TRUE = truth(FREE)
# Nothing but a spin about a principal axis.
STEADY = replace(FREE, gravity=None, start=np.array([[0, 0, 0, 1.0, 0, 0, 0, 0, 0, 0, 0, 0, 6.0]]))
TRUE_STEADY = truth(STEADY)
TETHER = read_scene("tether-undamped")

few = settings(derandomize=True, deadline=None, max_examples=12)


def run_of(scene: Scene, states: Array, true=None, notes=(), deform=1.0) -> Run:
    points = deform * vertices(states, scene.body.points)
    rows = scene.rows[: len(states)]
    return Run(scene, "planted", "", 0.01, Trajectory(rows, states, points, 1000, 1e-3, tuple(notes)), true)


def doctored(change, scene: Scene = FREE, true=TRUE) -> Run:
    """Return the true flight with its states changed by a function of (states, share of the flight)."""
    states = true.states.copy()
    change(states, np.linspace(0, 1, len(states))[:, None, None])
    return run_of(scene, states, true)


def words(run: Run) -> str:
    return verdict(run).word


def speed_up(by):
    def change(states, share):
        states[:, :, 10:13] *= np.sqrt(1 + by * share)

    return change


def test_the_truth_is_stable():
    said = verdict(run_of(FREE, TRUE.states.copy(), TRUE))
    assert (said.word, said.why) == ("stable", "")
    assert said.energy_ratio == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize(("by", "word"), [(0.5, "drifting"), (-0.5, "damped"), (0.02, "stable"), (-0.02, "stable")])
def test_energy_that_leaves_its_band(by, word):
    said = verdict(doctored(speed_up(by)))
    assert said.word == word
    assert said.energy_ratio == pytest.approx(1 + by, abs=1e-9)


def test_energy_lost_at_once_and_for_good_is_damped():
    def change(states, share):
        states[1:, :, 10:13] *= np.sqrt(0.8)

    assert words(doctored(change)) == "damped"


def test_energy_gained_at_once_and_for_good_is_drifting():
    def change(states, share):
        states[1:, :, 10:13] *= 1.5

    assert words(doctored(change)) == "drifting"


def test_energy_that_swings_and_comes_back_is_stable():
    def change(states, share):
        states[:, :, 10:13] *= np.sqrt(1 + 0.04 * np.sin(23 * share))

    assert words(doctored(change)) == "stable"


def test_angular_momentum_that_turns_away_is_drifting():
    def change(states, share):  # every body and its spin turned about x by up to 0.5 rad: the energy knows nothing
        for row, part in zip(states, share.ravel(), strict=True):
            turn = np.array([np.cos(part / 4), np.sin(part / 4), 0, 0])
            row[0, 3:7] = quaternion_product(turn, row[0, 3:7])
            w = quaternion_product(quaternion_product(turn, np.array([0, *row[0, 10:13]])), turn * (1, -1, -1, -1))
            row[0, 10:13] = w[1:]

    said = verdict(doctored(change))
    assert said.word == "drifting"
    assert "angular momentum" in said.why


def test_a_body_that_swells_is_drifting():
    said = verdict(run_of(STEADY, TRUE_STEADY.states.copy(), TRUE_STEADY, deform=1.05))
    assert said.word == "drifting"
    assert "no rigid body" in said.why


def test_what_is_not_finite_and_what_has_a_thousand_times_the_energy_diverged():
    def lost(states, share):
        states[20:] = np.nan

    assert words(doctored(lost)) == "diverged"
    assert words(doctored(speed_up(2e3))) == "diverged"


@pytest.mark.parametrize("norm", [False, True])
def test_a_velocity_that_stops_at_one_number_is_clamped(norm):
    def change(states, share):
        v = states[:, :, 7:10]
        if norm:
            v *= np.minimum(1.0, 9.0 / np.linalg.norm(v, axis=-1, keepdims=True))
        else:
            np.clip(v, -9.0, 9.0, out=v)

    said = verdict(doctored(change))
    assert said.word == "clamped"
    assert "9 m/s" in said.why


def test_a_velocity_that_physics_keeps_is_no_clamp():
    assert words(run_of(STEADY, TRUE_STEADY.states.copy(), TRUE_STEADY)) == "stable"
    drifting = replace(STEADY, start=STEADY.start + np.eye(13)[7] * 3.0)
    assert words(run_of(drifting, truth(drifting).states, None)) == "stable"


def test_an_attitude_that_lags_behind_a_right_spin_is_under_rotated():
    def change(states, share):
        angle = 0.9 * 6.0 * 4.0 * share.ravel()
        states[:, 0, 3], states[:, 0, 6] = np.cos(angle / 2), np.sin(angle / 2)

    said = verdict(doctored(change, STEADY, TRUE_STEADY))
    assert said.word == "under-rotated"
    assert "0.075 rad too little of 0.75" in said.why

    def ahead(states, share):
        angle = 1.1 * 6.0 * 4.0 * share.ravel()
        states[:, 0, 3], states[:, 0, 6] = np.cos(angle / 2), np.sin(angle / 2)

    assert words(doctored(ahead, STEADY, TRUE_STEADY)) == "stable", "too much is another mistake"


def test_back_at_the_start_or_at_the_origin_is_reset():
    def start(states, share):
        states[10:] = TRUE.states[: len(states) - 10]

    def origin(states, share):
        states[12] = [0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0]

    assert words(doctored(start)) == words(doctored(origin)) == "reset"


def test_a_body_at_rest_is_neither_reset_nor_frozen():
    rest = replace(STEADY, start=np.eye(13)[3:4])
    states = np.repeat(rest.start[None], ROWS, axis=0)
    assert words(run_of(rest, states, truth(rest))) == words(run_of(rest, states)) == "stable"


def test_a_body_that_never_moves_is_frozen():
    def change(states, share):
        states[:] = states[0]

    assert words(doctored(change)) == "frozen"
    assert words(run_of(FREE, np.repeat(TRUE.states[:1], ROWS, axis=0))) == "frozen", "its velocity says so itself"


def test_a_spin_that_stands_still_where_the_true_one_turns_lost_its_torque():
    uneven = replace(STEADY, start=np.array([[0, 0, 0, 1.0, 0, 0, 0, 0, 0, 0, 1.0, 5.0, 2.0]]))
    true = truth(uneven)

    def change(states, share):
        w = states[0, 0, 10:13]
        rate = np.linalg.norm(w)
        half = rate * 4.0 * share.ravel() / 2
        states[:, 0, 3:7] = np.column_stack((np.cos(half), np.sin(half)[:, None] * w / rate))
        states[:, 0, 10:13] = w

    assert words(doctored(change, uneven, true)) == "lost-torque"


@pytest.mark.parametrize(
    ("failure", "word"),
    [
        (Failure(Status.SKIPPED, "it has no floor"), "refused"),
        (Failure(Status.MISSING, "not installed"), "refused"),
        (Failure(Status.CRASHED, "ValueError: its process is fine"), "refused"),
        (Failure(Status.TIMEOUT, "no answer within 1 s"), "no-return"),
        (Failure(Status.CRASHED, "its process was killed by SIGSEGV", process_died=True), "no-return"),
    ],
)
def test_no_flight(failure, word):
    said = verdict(Run(FREE, "planted", "", 0.01, failure, TRUE))
    assert said.word == word
    assert said.why
    assert said.energy_ratio is None


@pytest.mark.parametrize(
    ("kind", "word"),
    [
        *((kind, kind) for kind in AUDITED),
        ("damped", "stable"),  # so little that no number shows it
        ("other", "stable"),  # as of a user's file that finds in words alone, whatever the words
    ],
)
def test_what_only_the_audit_can_see(kind, word):
    assert words(run_of(FREE, TRUE.states.copy(), TRUE, [Finding(kind, "clamped, the state was reset")])) == word
    assert word in WORDS
    assert set(AUDITED) < set(WORDS)
    assert set(AUDITED) < set(FINDINGS)


def plugin(name: str, monkeypatch) -> ModuleType:
    monkeypatch.syspath_prepend(str(PLUGINS))
    return importlib.import_module(name)


@pytest.fixture(scope="module")
def springs() -> ModuleType:
    with pytest.MonkeyPatch.context() as patch:
        return plugin("springs", patch)


@pytest.fixture(scope="module")
def column():
    (found,) = columns(TETHER, [1.0])
    return found


def probed(engine, column, method, w_dt, steps=300) -> Run:
    dt = w_dt / column.mode.rate
    scene = column.probe(dt, steps)
    return Run(scene, "planted", method, dt, simulate(engine, scene, method, dt), None)


@pytest.mark.parametrize("method", ["clamped", "speed-clamped", "reset"])
@few
@given(w_dt=st.floats(2.2, 32.0))
def test_what_hides_a_blow_up_is_never_stable(springs, column, method, w_dt):
    run = probed(springs, column, method, w_dt)
    said = verdict(run)
    assert np.isfinite(run.flight.states).all(), "nothing is hidden"
    assert said.word not in HOLDS
    assert not bounded(run, said)


def test_the_clamp_is_named(springs, column):
    assert verdict(probed(springs, column, "clamped", 8.0)).word == "clamped"
    assert verdict(probed(springs, column, "speed-clamped", 8.0)).word == "clamped"
    assert verdict(probed(springs, column, "symplectic", 8.0)).word == "diverged"
    assert verdict(probed(springs, column, "reset", 8.0)).word in ("reset", "diverged", "drifting")


@few
@given(w_dt=st.floats(0.05, 1.8))
def test_a_symplectic_step_below_its_limit_is_bounded(springs, column, w_dt):
    run = probed(springs, column, "symplectic", w_dt)
    assert bounded(run, verdict(run))


@pytest.mark.parametrize("w_dt", [3.0, 8.0, 32.0])
@pytest.mark.parametrize("stiffer", [1.0, 100.0])
def test_pybullet_at_its_default_limit_is_never_stable(w_dt, stiffer):
    """Its states stay finite up to w dt = 32 and beyond, which is how it looks stable."""
    engine = pytest.importorskip("pybullet") and importlib.import_module("tumble.compare.engines.pybullet")
    column = columns(TETHER, [stiffer])[0]
    run = probed(engine, column, "multibody+defaults", w_dt)
    assert np.isfinite(run.flight.states).all()
    assert verdict(run).word == "clamped"


def test_mujocos_auto_reset_is_seen():
    engine = pytest.importorskip("mujoco") and importlib.import_module("tumble.compare.engines.mujoco")
    column = columns(read_scene("tether-critical"), [1.0])[0]
    assert verdict(probed(engine, column, "rk4+defaults", 8.0, 1000)).word == "reset"


def test_the_energy_of_a_scene_with_every_force_is_what_its_work_says():
    """The derivative of the energy along any motion is minus the power of the dampers: here there are none."""
    scene = replace(
        TETHER,
        gravity=np.array([0.3, -9.81, 1.0]),
        tethers=(TETHER.tethers[0], replace(TETHER.tethers[0], rest_length=0.3, stiffness=50.0)),
        floor=read_scene("floor-stiff").floor,
    )
    from tumble.scenarios.wrench import wrench

    state = np.array([[0.1, 0.45, -0.2, 0.9, 0.1, 0.3, -0.2, 0.3, -0.2, 0.5, 1.0, -2.0, 0.7]])
    state[:, 3:7] /= np.linalg.norm(state[:, 3:7])
    force, torque = np.split(wrench(scene)(state)[0], 2)
    power = (force + scene.body.mass * scene.gravity) @ state[0, 7:10] + torque @ state[0, 10:13]
    h = 1e-6
    moved = []
    for sign in (1, -1):
        there = state.copy()
        there[:, 0:3] += sign * h * state[:, 7:10]
        turn = np.array([1.0, *(sign * h * state[0, 10:13] / 2)])
        there[0, 3:7] = quaternion_product(turn / np.linalg.norm(turn), state[0, 3:7])
        moved.append(mechanical_energy(there, scene)[0])
    # A cube's kinetic energy does not change with its attitude, so what changes is what is stored.
    assert -(moved[0] - moved[1]) / (2 * h) == pytest.approx(power, rel=1e-7)


def test_without_a_truth_a_damped_scene_may_lose_energy_and_an_undamped_one_may_not():
    rows = np.repeat(TETHER.start[None], ROWS, axis=0)
    rows[1:, :, 0:3] += 0.005  # nearer to the anchor, so with less energy, and at rest
    rows[1:, :, 0:3] += np.linspace(0, 1e-6, ROWS - 1)[:, None, None]
    undamped = replace(TETHER, times=np.linspace(0, 1, ROWS)[1:], duration=1.0)
    damped = replace(undamped, tethers=(replace(TETHER.tethers[0], damping=1.0),))
    assert words(run_of(undamped, rows)) == "damped"
    assert words(run_of(damped, rows)) == "stable"
    assert [each.decays for each in energies(run_of(damped, rows))] == [True]
