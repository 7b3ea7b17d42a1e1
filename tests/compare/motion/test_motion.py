"""Films: who is watched flies as it does unwatched, and the tables say where everything is."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tumble.compare.comparison.against_truth import compare
from tumble.compare.motion.film import FRAMES, film, filmed, instants
from tumble.compare.motion.results import TRUTH, film_tables, hull
from tumble.compare.run.flight import legs, takes_same_steps
from tumble.compare.run.running_engines import RunningEngine, launched
from tumble.compare.run.truths import true_answer
from tumble.scenarios.frames import vertices
from tumble.scenarios.impulse import strike_point
from tumble.scenarios.read import catalogue, read_scene, read_scenes
from tumble.scenarios.truth import truth

MINE = Path(__file__).parents[3] / "tumble" / "starters" / "mine.py"
STEPPED = ("tumble:rk4", "tumble:matrix-euler", "mujoco:euler", "pybullet:multibody")


@pytest.mark.parametrize("scene", read_scenes(catalogue()), ids=lambda scene: scene.name)
def test_the_instants_hold_the_scenes_own_and_no_step_is_cut(scene):
    times = instants(scene, scene.step)
    assert set(scene.times.tolist()) <= set(times)
    assert times == sorted(set(times))
    assert min(FRAMES, scene.duration / scene.step) * 0.5 <= len(times) <= 2 * FRAMES
    watched, own = legs(filmed(scene, scene.step), scene.step), legs(scene, scene.step)
    assert sum(leg.n for leg in watched) == sum(leg.n for leg in own)


@pytest.fixture(scope="module")
def films():
    scenes = [read_scene(name) for name in ("die-vertex", "two-hits")]
    with launched(STEPPED) as running_engines:
        return film(running_engines, scenes), compare(running_engines, scenes)


def test_who_is_watched_flies_to_the_last_bit_as_unwatched(films):
    for shot, compared in zip(*films, strict=True):
        rows = np.searchsorted(shot.scene.rows, compared.scene.rows)
        for run in compared.runs:
            seen = shot.trajectories[run.engine, run.method]
            assert (seen.vertices[rows] == run.flight.vertices).all(), run.name


def test_one_run_is_both_the_film_and_the_comparison_where_its_steps_are_the_same(films, monkeypatch):
    shots, alone = films
    asked = []
    simulate = RunningEngine.simulate

    def counted(running_engine, scene, method, dt, *more, **others):
        asked.append((scene.name, method))
        return simulate(running_engine, scene, method, dt, *more, **others)

    monkeypatch.setattr(RunningEngine, "simulate", counted)
    scenes = [comparison.scene for comparison in alone]
    watched = [filmed(scene, scene.step) for scene in scenes]
    with launched([*STEPPED, "tumble:exact", str(MINE)]) as running_engines:
        both = compare(running_engines, scenes, watched=watched)
    twice = {"exact", "semi-implicit-euler"}
    assert {method for _, method in asked if asked.count((scenes[0].name, method)) == 2} == twice, (
        "a method that takes the whole way at once, and a file whose steps need not add up, run twice"
    )
    assert len(asked) == len(scenes) * (len(STEPPED) + 2 * len(twice))
    for comparison, before, shot in zip(both, alone, shots, strict=True):
        runs = {run.name: run for run in comparison.runs}
        for own in before.runs:
            run = runs[own.name]
            assert (run.status, run.flight.steps) == (own.status, own.flight.steps)
            assert (run.flight.times == own.flight.times).all()
            assert (run.distances == own.distances).all()
            assert (run.flight.states == own.flight.states).all()
            assert run.flight.probe is not None
            film = comparison.watched[run.engine, run.method]
            assert (film.states == shot.trajectories[run.engine, run.method].states).all()


def test_a_run_that_diverges_is_made_again_at_the_scenes_own_samples():
    scene = read_scene("rod-stiff")
    long, dt = replace(scene, times=scene.times[-1:]), scene.duration / 64
    watched = [filmed(long, dt)]
    assert takes_same_steps(long, watched[0], dt)
    with launched(["tumble:rk4"]) as running_engines:
        (alone,) = compare(running_engines, [long], dt)
        (both,) = compare(running_engines, [long], dt, watched=watched)
    film = both.watched["tumble", "rk4"]
    assert film.diverged_at is not None
    assert film.diverged_at < long.duration
    assert both.runs[0].flight.steps == alone.runs[0].flight.steps > film.steps


def test_the_truth_of_a_film_is_the_truth(films):
    for shot, compared in zip(*films, strict=True):
        rows = np.searchsorted(shot.scene.rows, compared.scene.rows)
        apart = np.linalg.norm(shot.truth.vertices[rows] - compared.truth.vertices, axis=-1).max(axis=-1)
        assert (apart <= shot.truth.bound[rows] + compared.truth.bound).all()


def test_a_truth_without_its_floor_is_else_the_same():
    scene = replace(read_scene("two-hits"), title="")
    whole, bare = truth(scene), truth(scene, with_input_error=False)
    assert (bare.input_error == 0).all()
    assert (whole.input_error > 0).any()
    assert (bare.states == whole.states).all()
    assert (bare.bound == whole.bound).all()


def test_the_tables_say_where_everything_is(films):
    shots, _ = films
    tables = film_tables(shots)
    motion = tables["motion.csv"]
    own = motion[(motion["scene"] == "die-vertex") & (motion["engine"] == "mujoco")]
    shot = shots[0]
    flight = shot.trajectories["mujoco", "euler"]
    assert (own[["x_m", "y_m", "z_m"]].to_numpy() == flight.states[:, 0, 0:3]).all()
    errors = np.linalg.norm(flight.vertices[:, 0] - shot.truth.vertices[:, 0], axis=-1).max(axis=-1)
    assert (own["error_m"].to_numpy() == errors).all()
    # Free flight keeps the angular momentum in world axes; in the body's its length.
    true = motion[(motion["scene"] == "die-vertex") & (motion["engine"] == TRUTH)]
    lengths = np.linalg.norm(true[["l1_kg_m2_s", "l2_kg_m2_s", "l3_kg_m2_s"]].to_numpy(), axis=1)
    assert np.ptp(lengths) < 1e-14 * lengths.max()
    assert set(tables["deformed.csv"]["method"]) == {"matrix-euler"}
    struck = tables["loads.csv"].query("scene == 'two-hits' and kind == 'impulse'")
    scene = shots[1].scene
    assert struck["t_s"].tolist() == [impulse.time for impulse in scene.impulses]
    row = int(np.searchsorted(scene.rows, scene.impulses[1].time))
    landed = strike_point(scene.impulses[1], shots[1].truth.states[row, 0], scene.body)
    assert struck[["x_m", "y_m", "z_m"]].to_numpy()[1].tolist() == landed.tolist()


def test_a_hull_is_seen_from_outside():
    body = read_scene("dzhanibekov").body
    faces = hull(body.points)
    volume = 0.0
    for a, b, c in (body.points[face] for face in faces):
        normal = np.cross(b - a, c - a)
        assert ((body.points - a) @ normal <= 1e-12).all(), "no point lies outside a face"
        volume += float(a @ normal) / 6
    assert volume > 0
    assert hull(vertices(np.eye(1, 13, 3)[0], body.points * (1.0, 1.0, 0.0))) == []


@pytest.mark.parametrize("name", ["two-hits", "tether-critical"])
def test_a_films_truth_is_the_scenes_own_bit_for_bit(name):
    scene = read_scene(name)
    own, seen = true_answer(scene), true_answer(filmed(scene, scene.step))
    assert len(seen.truth.times) > 2 * len(scene.rows)
    found = seen.at(scene).truth
    for column in ("times", "states", "vertices"):
        assert np.array_equal(getattr(found, column), getattr(own.truth, column))
    # What it is known to is of the steps that it took, of which there are more.
    for column in ("bound", "input_error"):
        assert getattr(found, column) == pytest.approx(getattr(own.truth, column), rel=1e-6)
    assert found.horizon == math.inf


def test_a_films_truth_ends_for_the_scene_at_the_last_of_its_own_rows():
    scene = read_scene("two-hits")
    seen = true_answer(filmed(scene, scene.step))
    between = (scene.times[3] + scene.times[4]) / 2
    cut = seen._replace(truth=replace(seen.truth, horizon=between, why="it is far"))
    assert cut.at(scene).truth.horizon == scene.times[3]
    assert cut.at(scene).truth.why == "it is far"
    early = seen._replace(truth=replace(seen.truth, horizon=scene.times[0] / 2, why="it is far"))
    assert early.at(scene) == (None, "there is no truth at the first sample: it is far")
