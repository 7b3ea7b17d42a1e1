"""What a person does in the lab, without a browser, with real engines."""

import ast
import os
import shutil
import subprocess
import sys
import threading
import time
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from tumble.compare.run.engines.registry import package
from tumble.compare.run.flight import Trajectory
from tumble.compare.run.process.process import Died
from tumble.compare.run.status import Failure
from tumble.lab.background import Job, Workers
from tumble.lab.draft import Draft
from tumble.lab.pool import Contestant, Pool
from tumble.lab.readings import error_rows, errors_over_time, felt, readings, sensor_readings
from tumble.lab.refusals import Refused
from tumble.lab.sentences import sentence
from tumble.lab.session import LEAD_S, Session
from tumble.scenarios.frames import rotation_matrix
from tumble.scenarios.read import BadScene, read_scene
from tumble.scenarios.truth.sensors import sensor_truth
from tumble.scenarios.wrench import wrench

PLUGINS = Path(__file__).parents[2] / "plugins"
PATIENCE_S = 60.0
EYE = np.array([3.0, 6.0, 20.0])
HUNG = """
import os
from pathlib import Path

METHODS, FEATURES, ABOUT = ("forever",), {"gravity"}, {"version": "1"}


def build(scene, method): return scene
def write(world, states): pass
def read(world): return world.start
def advance(world, n, dt):
    Path(__file__).with_name("pid").write_text(str(os.getpid()))
    while True: pass
"""


def click(session: Session, at=(0.7, 3.1, 2.5), magnitude: float = 5.0) -> None:
    """Click a place of the cube, [m], world."""
    session.click(EYE.tolist(), (np.array(at) - EYE).tolist(), magnitude)


def test_the_first_click_throws_and_the_second_does_not(session):
    click(session)
    thrown = session.thrown
    with pytest.raises(Refused, match="Reset"):
        click(session)
    assert session.thrown is thrown
    session.reset()
    click(session)
    assert session.thrown is not thrown


def test_a_click_beside_the_body_throws_nothing(session):
    with pytest.raises(Refused, match="missed"):
        click(session, at=(4.0, 2.5, 0.0))
    assert session.throw is None


def test_an_impulse_of_nothing_is_refused(session):
    with pytest.raises(Refused):
        click(session, magnitude=0.0)
    assert session.throw is None


def test_the_impulse_acts_along_the_ray_where_it_hits(session, until):
    click(session)
    until(lambda: session.throw.is_complete)
    ((impulse, place),) = session.impulses_until(0.0)
    assert place == pytest.approx((0.7, 3.1, 2.5), abs=1e-12)
    moments = session.draft.scene.body.moments
    spin = np.cross(place - session.draft.scene.start[0, 0:3], impulse.value) / moments
    assert session.throw.true_states[0, 7:10] == pytest.approx(impulse.value / 1.0)
    assert session.throw.true_states[0, 10:13] == pytest.approx(spin)


@pytest.mark.parametrize("contestant", ["tumble:rk4", "mujoco:euler", "pybullet:multibody"])
def test_run_of_the_saved_scene_is_the_same_trajectory_to_the_last_bit(session, until, tmp_path, contestant):
    session.edit({("body", "size"): [5.0, 3.0, 5.0]})  # too low for the ray of the file's own throw
    session.click([3.0, 6.0, 20.0], [-0.115, -0.145, -0.875], 5.0)
    until(lambda: session.throw.is_complete)
    folder = session.files().tables(session.throw)
    scene = session.files().scene_file
    done = subprocess.run(
        [sys.executable, "-P", "-m", "tumble", "run", scene.name, "-e", contestant],
        cwd=tmp_path, capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    kept = folder / f"trajectory-{contestant.replace(':', '-')}.csv"
    assert kept.read_text(encoding="utf-8") == done.stdout


def test_time_waits_for_the_truth_but_not_for_good(session, pool, until, monkeypatch):
    monkeypatch.setattr(pool.background, "send", lambda calls: Job(calls, Job.cancel))  # never begun
    click(session)
    until(lambda: len(session.throw.answers) == len(session.throw.contestants))
    time.sleep(0.5)
    for _ in range(3):  # each look is one of the page's
        shown = session.shown()
    assert shown.time <= LEAD_S * session.clock.speed
    assert shown.whose == session.contestants[0].name
    assert "truth" in sentence(session, shown, [])
    monkeypatch.setattr(session, "_patience_s", 0.0)
    until(lambda: session.shown().time > 2 * LEAD_S * session.clock.speed)


def test_an_impulse_is_seen_for_a_while_and_then_it_is_past(session, until):
    click(session)
    until(lambda: session.throw.is_complete)
    assert len(session.impulses_lately(0.0)) == len(session.impulses_lately(0.1)) == 1
    assert session.impulses_lately(0.2) == []
    assert len(session.impulses_until(0.2)) == 1


def test_before_a_throw_nothing_has_struck_the_body(session):
    assert session.draft.scene.impulses
    assert session.impulses_until(0.0) == []


def test_again_is_a_second_impulse_at_the_time_shown(session, until):
    click(session)
    until(lambda: session.throw.is_complete)
    session.go_to(0.2)
    session.again()
    state = session.shown().state
    face = state[0:3] + rotation_matrix(state[3:7]) @ np.array([0.3, 0.2, 2.5])
    session.click(EYE.tolist(), (face - EYE).tolist(), 3.0)
    first, second = session.throw.scene.impulses
    assert (first.time, second.time) == (0.0, session.shown().time)
    until(lambda: session.throw.is_complete)
    row = int(np.searchsorted(session.throw.scene.rows, second.time))
    for flight in session.throw.trajectories().values():
        assert flight.vertices[:, 0] == pytest.approx(session.throw.true_vertices, abs=1e-9)
        jumped = flight.states[row, 0, 7:10] - flight.states[row - 1, 0, 7:10]
        assert jumped == pytest.approx(second.value)


def test_again_is_refused_where_there_is_nothing_to_strike(session, until):
    with pytest.raises(Refused):
        session.again()
    click(session)
    until(lambda: session.throw.is_complete)
    session.go_to(0.5)
    with pytest.raises(Refused, match="ended"):
        session.again()


def test_an_edit_throws_again_and_a_bad_one_changes_nothing(session, until):
    click(session)
    session.edit({("body", "mass"): 2.0})
    until(lambda: session.throw.is_complete)
    assert session.throw.true_states[0, 7:10] == pytest.approx(session.throw.scene.impulses[0].value / 2.0)
    before = session.thrown, session.draft
    with pytest.raises(BadScene):
        session.edit({("body", "mass"): -1.0})
    with pytest.raises(BadScene):
        session.edit({("body", "size"): [0.1, 0.1, 0.1]})  # too small for the ray of the click
    assert (session.thrown, session.draft) == before


def test_at_its_defaults_pybullet_is_slowed_and_in_fair_settings_it_is_not(session, until):
    pybullet = Contestant("pybullet", "multibody", "pybullet")
    session.engage([pybullet])
    session.use_defaults(True)
    click(session)
    until(lambda: session.throw.is_complete)
    (row,) = error_rows(session.throw, len(session.throw.scene.times), None)
    assert row.contestant.method == "multibody+defaults"
    assert row.off_m > 0.1
    session.use_defaults(False)
    until(lambda: session.throw.is_complete)
    (row,) = error_rows(session.throw, len(session.throw.scene.times), None)
    assert row.contestant == pybullet
    assert row.off_m < 1e-9


def test_a_hung_engine_is_a_line_and_the_others_fly(tmp_path, until):
    with Pool(time_limit=600.0) as pool:
        hold_hung_engine(pool, tmp_path, until)


def test_an_engine_that_hangs_as_it_starts_is_started_once_and_the_others_fly(tmp_path, until, monkeypatch):
    monkeypatch.setattr("tumble.lab.pool.READY_S", 0.5)
    stuck = "from pathlib import Path\nwith Path(__file__).with_name('begun').open('a') as file: file.write('x')\n"
    (tmp_path / "stuck.py").write_text(f"{stuck}while True: pass", encoding="utf-8")
    with Pool(time_limit=60.0) as pool:
        begun = time.monotonic()
        hangs, _ = pool.ready([str(tmp_path / "stuck.py"), "tumble:rk4"])
        assert time.monotonic() - begun < PATIENCE_S / 2
        right = pool.contestant("tumble", "rk4")
        session = Session(Draft.opened("table-4-1-ray"), [hangs, right], pool, tmp_path, lambda: None)
        until((tmp_path / "begun").exists)
        for _ in range(3):
            click(session)
            until(lambda: right in session.throw.answers)
            assert hangs.name == "stuck"
            assert {row.contestant: row for row in error_rows(session.throw, 5, None)}[hangs].status == "running"
            session.reset()
        assert (tmp_path / "begun").read_text() == "x"


def test_an_engine_that_nobody_asked_for_flies_its_default_when_it_is_chosen(session, pool, until):
    (scipy,) = (one for one in pool.all_contestants() if one.engine == "scipy")
    assert (scipy.method, scipy.name) == ("", "scipy")
    session.engage([scipy])
    click(session)
    until(lambda: session.throw.is_complete)
    (row,) = error_rows(session.throw, 5, None)
    assert row.contestant.name == "scipy:dop853"
    assert row.off_m < 1e-6
    assert session.contestants == [row.contestant]
    assert "scipy:dop853" in [one.name for one in pool.all_contestants()]


def test_an_engine_without_the_laws_of_a_scene_is_given_their_force(session, until):
    session.open("tether-critical")
    session.engage([Contestant("pybullet", "multibody", "pybullet")])
    session.click([1.0, 2.0, 5.0], [-0.2, -0.4, -1.0], 1.0)
    until(lambda: session.throw.is_complete)
    (row,) = error_rows(session.throw, 5, None)
    assert row.contestant.name == "pybullet:multibody+held"
    assert row.off_m < 0.1


def test_a_truth_that_is_not_wanted_any_more_keeps_nobody_waiting(until):
    workers = Workers()
    slow = [workers.send([(time.sleep, 600.0)]) for _ in range(3)]
    for job in slow:
        job.stop()
    until(lambda: all(job.futures[0].done() for job in slow))
    assert workers.send([(abs, -1), (abs, -2)]).futures[1].result(PATIENCE_S) == 2
    workers.close()


def test_a_throw_that_is_reset_stops_its_truth(session, pool, monkeypatch):
    sent = []
    send = pool.background.send
    monkeypatch.setattr(pool.background, "send", lambda calls: sent.append(send(calls)) or sent[-1])
    stopped = []
    click(session)
    (job,) = sent
    monkeypatch.setattr(job, "stop", lambda: stopped.append(job))
    session.reset()
    assert stopped == [job]


def test_a_worker_that_died_is_replaced(until):
    workers = Workers()
    died = [workers.send([(os._exit, 3)]).futures[0] for _ in range(2)]
    until(lambda: all(isinstance(future.exception(PATIENCE_S), Died) for future in died))
    assert workers.send([(abs, -1)]).futures[0].result(PATIENCE_S) == 1
    workers.close()


def test_engines_that_come_up_at_once_are_not_parsed_at_once(monkeypatch):
    inside, most = [], []

    def slowly(source):
        inside.append(1)
        most.append(len(inside))
        time.sleep(0.05)
        inside.pop()
        return ast.Module([], [])

    monkeypatch.setattr("tumble.compare.run.engines.registry.ast", SimpleNamespace(parse=slowly))
    threads = [threading.Thread(target=package.__wrapped__, args=(name,)) for name in ("mujoco", "pybullet", "scipy")]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert most == [1, 1, 1]


def test_two_engine_files_of_one_name_are_two_contestants(tmp_path):
    for folder in ("old", "new"):
        (tmp_path / folder).mkdir()
        shutil.copy(PLUGINS / "mine.py", tmp_path / folder / "mine.py")
    with Pool(time_limit=60.0) as pool:
        one, other = pool.ready(str(tmp_path / folder / "mine.py") for folder in ("old", "new"))
        assert [each.name.partition(":")[0] for each in (one, other)] == ["old/mine", "new/mine"]
        session = Session(Draft.opened("table-4-1-ray"), [one, other], pool, tmp_path, lambda: None)
        click(session)
        runs = session.throw.comparison().runs
        assert [run.engine for run in runs] == ["old/mine", "new/mine"]
        session.close()


def hold_hung_engine(pool, tmp_path, until):
    (tmp_path / "hung.py").write_text(HUNG, encoding="utf-8")
    hung, right = pool.ready([str(tmp_path / "hung.py"), "tumble:rk4"])
    session = Session(Draft.opened("table-4-1-ray"), [hung, right], pool, tmp_path, lambda: None)
    click(session)
    until(lambda: right in session.throw.answers and session.throw.truth_is_complete)
    rows = {row.contestant: row for row in error_rows(session.throw, 5, None)}
    assert rows[hung].status == "running"
    assert rows[right].off_m < 1e-9
    hanging = session.throw
    until((tmp_path / "pid").exists)
    until(lambda: (tmp_path / "pid").read_text())
    process = Path("/proc", (tmp_path / "pid").read_text())
    session.reset()
    until(lambda: not process.exists())  # ended: nobody waits for the time limit
    click(session)
    assert hung not in hanging.answers
    until(lambda: right in session.throw.answers)
    session.close()


def test_the_whole_truth_in_parts_is_the_truth(session, until):
    session.open("two-hits")
    session.throw_own()
    until(lambda: session.throw.is_complete)
    from tumble.scenarios.truth import truth

    whole, found = truth(session.throw.scene), session.throw.comparison().truth
    assert np.array_equal(found.times, whole.times)
    assert np.abs(found.vertices - whole.vertices).max() <= 2 * np.spacing(np.abs(whole.vertices).max())
    assert session.throw.known == len(whole.times)


def test_the_numbers_are_those_of_the_coursework(session, until):
    click(session)
    until(lambda: session.throw.is_complete)
    session.go_to(0.3)
    shown = session.shown()
    ((impulse, place),) = session.impulses_until(shown.time)
    told = {one.name: one for one in readings(1.0, shown.time, shown.state, shown.vertices, impulse, place)}
    assert told["centre of mass"].values == pytest.approx(np.array([0.0, 2.5, 0.0]) + 0.3 * impulse.value)
    assert told["impulse"].values == pytest.approx((5.0,))
    assert told["hit point"].values == pytest.approx(tuple(place))
    assert (told["mass"].unit, told["angular velocity"].unit, told["time"].unit) == ("kg", "rad/s", "s")
    # An accelerometer at the clicked point of a cube that spins freely: w^2 r towards the axis; a gyro beside it.
    scene, point = session.thrown.scene, session.struck_point(shown.time)
    force, spin = (np.array(one.values) for one in sensor_readings(scene, shown.state, point, None, at_impulse=False))
    axes = rotation_matrix(shown.state[3:7])
    w = shown.state[10:13]
    arm = place - scene.start[0, :3]  # as it was at the click, when the body was not turned
    assert axes @ spin == pytest.approx(w)
    assert force == pytest.approx(np.cross(spin, np.cross(spin, arm)))
    assert sensor_readings(scene, shown.state, point, None, at_impulse=True)[0].values == ()
    corners = np.array([told[f"vertex {number}"].values for number in range(8)])
    assert np.linalg.norm(corners - told["centre of mass"].values, axis=1) == pytest.approx(np.full(8, 2.5 * 3**0.5))


def test_an_accelerometer_in_the_lab_feels_the_forces_of_a_scene():
    scene = read_scene("tether-undamped")
    (sensor,) = scene.sensors
    true = sensor_truth(scene, replace(sensor, orientation=np.array([1.0, 0, 0, 0])), times=np.array([0.0, 0.01]))
    force, _ = felt(scene, scene.start[0], sensor.point_body, wrench(scene))
    assert force == pytest.approx(true.specific_force[0, 0], rel=1e-12)


def test_the_curves_end_with_the_errors_of_the_table(session, until):
    session.open("brick-tumble")
    session.throw_own()
    until(lambda: session.throw.is_complete)
    _, curves = errors_over_time(session.throw)
    for row in error_rows(session.throw, len(session.throw.scene.times), None):
        assert curves[row.contestant][-1] == max(row.off_m, row.resolution_m)


def test_the_vertex_named_is_the_one_that_is_told_of(session, until):
    session.engage([Contestant("pybullet", "multibody+defaults", "pybullet")])
    click(session)
    until(lambda: session.throw.is_complete)
    (flight,) = session.throw.trajectories().values()
    off = np.linalg.norm(flight.vertices[5, 0] - session.throw.true_vertices[5], axis=-1)
    (worst,) = error_rows(session.throw, 5, None)
    assert (worst.vertex, worst.off_m) == (int(np.argmax(off)), off.max())
    for vertex in range(8):
        (row,) = error_rows(session.throw, 5, vertex)
        assert (row.vertex, row.off_m) == (vertex, off[vertex])
        assert np.array_equal(row.position, flight.vertices[5, 0, vertex])


def test_a_rigid_body_has_no_surface_to_click_but_flies_as_written(session, until):
    session.open("dzhanibekov")
    with pytest.raises(Refused):
        click(session)
    session.throw_own()
    until(lambda: session.throw.trajectories())


def test_two_sessions_have_a_throw_each(session, pool, tmp_path, until):
    other = Session(Draft.opened("two-hits"), session.contestants, pool, tmp_path, lambda: None)
    click(session)
    other.throw_own()
    until(lambda: session.throw.is_complete and other.throw.is_complete)
    assert session.throw.scene.name == "table-4-1-ray"
    assert all(
        isinstance(answer, Trajectory) for answer in (*session.throw.answers.values(), *other.throw.answers.values())
    )
    other.close()
    assert not isinstance(session.throw.answers[session.contestants[0]], Failure)


def test_a_loaded_trajectory_is_shown_and_graded(session, until, tmp_path):
    session.engage([Contestant("pybullet", "multibody+defaults", "pybullet")])
    click(session)
    until(lambda: session.throw.is_complete)
    kept = session.files().tables(session.throw) / "trajectory-pybullet-multibody+defaults.csv"
    told: list[str] = []
    session.load("<b>mine</b>.csv", kept.read_bytes(), told.append)
    until(lambda: told)
    assert told == [""]
    assert not session.foreign.is_right
    assert session.foreign.verdict.startswith("<b>mine</b>.csv is wrong")
    assert "damping" in " ".join(session.foreign.details)
    assert session.foreign.at(0.0) == pytest.approx(np.zeros((8, 3)), abs=1e-12)
    (row,) = error_rows(session.throw, len(session.throw.scene.times), None)
    assert session.foreign.errors[-1] == pytest.approx(row.off_m)
    assert session.foreign.at(session.throw.scene.duration)[row.vertex] == pytest.approx(row.error)
    assert not list(tmp_path.glob(".lab-*"))


def test_a_file_that_is_no_trajectory_is_refused_by_its_own_name(session, until, tmp_path):
    click(session)
    told: list[str] = []
    session.load("mine.csv", b"a,b\n1,2\n", told.append)
    until(lambda: told)
    assert told[0].startswith("mine.csv")
    assert str(tmp_path) not in told[0]
    assert session.foreign is None


def test_what_is_kept_never_goes_over_what_is_there(session, until, tmp_path):
    (tmp_path / "table-4-1-ray-1.toml").write_text("mine")
    click(session)
    first = session.files().scene_file
    session.reset()
    click(session)
    second = session.files().scene_file
    assert (first.name, second.name) == ("table-4-1-ray-2.toml", "table-4-1-ray-3.toml")
    assert (tmp_path / "table-4-1-ray-1.toml").read_text() == "mine"
    assert len(read_scene(str(first)).impulses) == 1


def test_above_a_plane_a_method_that_has_one_runs_and_the_end_of_the_truth_is_said(session, pool, until):
    plane = read_scene("tip-over")
    assert pool.instead(pool.contestant("tumble", "rk4"), plane).method == "events"
    assert pool.instead(pool.contestant("pybullet", "multibody"), plane) is None
    session.engage(pool.ready(["mujoco:euler"]))
    session.open("tip-over")
    session.throw_own()
    until(lambda: session.throw.is_complete)
    assert 0 < session.throw.truth_ends < plane.duration
    session.go_to(0.0)
    assert sentence(session, session.shown(), error_rows(session.throw, 0, None)).startswith("All contestants are")
    session.go_to(0.9)
    shown = session.shown()
    said = sentence(session, shown, error_rows(session.throw, shown.frame, None))
    assert said.startswith(f"The truth is known until {session.throw.truth_ends:.3g} s: an edge begins to slip")
    assert said.endswith("Shown now: mujoco:euler.")
    with pytest.raises(Refused, match="ends before this time"):
        session.again()
    tables = session.files().tables(session.throw)
    errors = pd.read_csv(tables / "vertex-errors.csv")
    assert errors.t_s.max() == pytest.approx(session.throw.truth_ends)
    assert np.isfinite(errors.error_m).all()
