"""How late rows are: measured by their first interval, whatever else is wrong; told, and known to the search."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from explained import evaluator_of, explained
from planted import Spoilt
from pose_files import write_poses
from programs import read, write
from scipy.spatial.transform import Rotation

from tumble.compare.grade.grade import grade
from tumble.compare.grade.measure.lateness import first_motion, lateness
from tumble.compare.grade.model.program_model import FINE, correct_program
from tumble.compare.grade.search.causal import CausalSearch
from tumble.scenarios.read import read_scene, scene_path

SPACING_S = 0.02
CORNERS = np.array([[-0.2, 0.1, 0.0], [0.3, 0.1, 0.1], [0.0, -0.3, 0.1], [0.1, 0.0, -0.2]])
# What eight printed digits of metres leave open.
HALF_M = 5e-8


def rows_of(late_s, noise_m=0.0, count=30, tick_s=0.0):
    """Return times and vertices of a body that falls and rotates, read late; between ticks, along straight lines."""
    times = SPACING_S * np.arange(count)
    reached = np.maximum(times - late_s, 0.0)
    vertices = places(reached)
    if tick_s:
        before = np.floor(reached / tick_s + 1e-9) * tick_s
        share = ((reached - before) / tick_s)[:, None, None]
        vertices = (1 - share) * places(before) + share * places(before + tick_s)
    noise = noise_m * np.random.default_rng(1).standard_normal(vertices.shape)
    return times, (vertices + noise).round(7)


def places(times):
    """Return where the vertices are at times [s], (T, K, 3)."""
    turned = Rotation.from_rotvec(times[:, None] * np.array([2.0, -1.0, 3.0])).as_matrix()
    x = times[:, None] * np.array([1.0, 3.0, -0.5]) + times[:, None] ** 2 * np.array([0.0, -4.905, 0.0])
    return x[:, None] + np.einsum("tij,kj->tki", turned, CORNERS)


def measured(late_s, moved_m=0.0, floor_m=HALF_M, true_late_s=0.0, begins_s=0.0, **how):
    """Return the lateness of such rows; of a scene that begins elsewhere, or with an impulse a little later."""
    times, vertices = rows_of(late_s, **how)
    true = places(np.maximum(times - true_late_s, 0.0)) + moved_m
    return lateness(times + begins_s, vertices, true, np.full((len(times), 3), floor_m))


@pytest.mark.parametrize("late_s", [0.0037, 0.01, SPACING_S, 2.5 * SPACING_S, -0.013])
def test_it_is_measured_as_exactly_as_it_says(late_s):
    """The error of the extrapolation is known from rows of which the answer is."""
    found = measured(late_s)
    assert abs(found.seconds - late_s) <= 3 * found.error < 1e-3 * SPACING_S


@pytest.mark.parametrize(
    "how",
    [
        {"late_s": 0.0},
        {"late_s": 0.0004},
        {"late_s": 0.01, "noise_m": 0.02, "floor_m": 0.02},
        {"late_s": 0.0, "tick_s": 0.03},
        {"late_s": -0.01, "moved_m": 0.1},
        {"late_s": 0.01, "true_late_s": 0.01},
        {"late_s": 0.01, "begins_s": 0.5},
        {"late_s": 0.01, "count": 8},
    ],
    ids=["on time", "too little", "noise", "between ticks", "another start", "an impulse", "later rows", "few rows"],
)
def test_it_is_not_told_where_rows_do_not_show_it(how):
    """Early rows do not come from a start elsewhere; one that an impulse moves later has such true rows."""
    assert measured(**how) is None


def begins(late_s, true_late_s=0.0, **how):
    """Return between which rows such a body begins to move, of a scene that begins to move at another time."""
    times, vertices = rows_of(late_s, **how)
    true, floor_m = places(np.maximum(times - true_late_s, 0.0)), max(HALF_M, how.get("noise_m", 0.0))
    return first_motion(times, vertices, true, np.full((len(times), 3), floor_m))


@pytest.mark.parametrize("noise_m", [0.0, 1e-3])
@pytest.mark.parametrize(("late_s", "between"), [(0.025, (0.02, 0.04)), (0.04, (0.04, 0.06)), (0.11, (0.1, 0.12))])
def test_a_body_that_rests_for_whole_intervals_begins_to_move_between_two_rows(late_s, between, noise_m):
    assert begins(late_s, noise_m=noise_m) == pytest.approx(between)


@pytest.mark.parametrize("how", [{"late_s": 0.015}, {"late_s": 0.05, "true_late_s": 0.05}], ids=["late", "an impulse"])
def test_a_body_that_moves_in_the_first_interval_or_should_rest_in_it_begins_nowhere_else(how):
    assert begins(**how) is None


def late_rows(throw, late, **program):
    """Return rows of a program, each as it was some rows before, and as at the start in the first ones."""
    rows = list(Spoilt(throw, **program).rows())
    return [(rows[n][0], *rows[max(0, n - late)][1:]) for n in range(len(rows))]


def test_late_rows_are_told_and_their_first_interval_is_no_collision(tmp_path):
    """The velocity jumps there: that was told as an impulse at a wrong time, or a contact."""
    path = scene_path("brick-tumble")
    throw = read(path)
    file = write(tmp_path / "late.csv", late_rows(throw, 1, dt=0.01, every=2, until=2.0), throw.vertices)
    found = grade(Path(file), read_scene(str(path)), {})
    late = [text for text in found.observations if "late" in text]
    assert late == ["Rows are 0.02 s late: the first interval shows less motion than those after it."]
    assert not any("jumps" in text for text in found.observations)


HIT = """
title = "Box hit twice"
duration = 2.0
samples = 20
step = 0.001
gravity = [0.0, 0.0, -9.81]
[body]
shape = "box"
size = [0.4, 0.25, 0.3]
mass = 1.7
position = [0.3, -0.4, 1.2]
orientation = [0.4, -0.2, 0.7, 0.5]
velocity = [1.3, -2.2, 0.4]
angular_velocity = [2.0, -1.1, 1.6]
[[impulse]]
time = 0.0
value = [-0.6, 0.9, 0.4]
vertex = 2
[[impulse]]
time = 0.75
value = [0.5, 1.0, -1.0]
vertex = 6
"""


@pytest.fixture
def hit(tmp_path):
    """The file of a scene with two impulses."""
    path = tmp_path / "hit.toml"
    path.write_text(HIT, encoding="utf-8")
    return path


def explained_late(tmp_path, scene_file, throw, late, **program):
    """Return the mistakes of a program that flies a throw and writes its rows late, in a twentieth of the time."""
    file = write(tmp_path / "late.csv", late_rows(throw, late, **program), throw.vertices, form="{:.9g}".format)
    return explained(file, read_scene(str(scene_file)), 0.3)


def test_what_the_first_rows_show_is_known_before_the_search(tmp_path, hit):
    """Late rows, and a start attitude that is not set, beside three other mistakes."""
    throw = replace(read(hit), q=np.array([1.0, 0.0, 0.0, 0.0]))
    program = {"dt": 0.004, "method": "explicit", "turn": "exponential", "gyroscopic": "still in world", "gravity": 2.0}
    found = explained_late(tmp_path, hit, throw, 1, every=1, **program)
    gravity = [found.pop(name) for name in ("gravity-doubled", "gravity-wrong-magnitude") if name in found]
    assert gravity in ([0.0], [pytest.approx(2.0)])
    assert found.keys() == {"start-attitude-missing", "gyroscopic-term-missing", "explicit-euler", "log-lag"}


def test_a_search_begins_with_when_a_body_begins_to_move(tmp_path):
    """One that does not rotate may have moved more slowly; and as rows may be held, they may be on time."""
    scene, times = read_scene("die-straight"), SPACING_S * np.arange(40)
    late = correct_program(scene, 0).output(np.maximum(times - 2 * SPACING_S, 0.0), FINE)
    evaluator, _ = evaluator_of(write_poses(tmp_path / "late.csv", times, late.x, late.q), scene)
    assert evaluator.lateness is None
    search = CausalSearch(evaluator)
    search._shown_at_once()
    (best,), *_, on_time = search._known
    assert (best.hypothesis.name, best.value, on_time) == ("log-lag", pytest.approx(0.04), ())
