"""Mistakes that look alike for a while, or in noise: the search follows one of them, and tries the others later."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from explained import evaluator_of, explained
from explanations import hypothesis, mistakes_of
from planted import Spoilt
from pose_files import write_poses
from programs import Program, fly, read, write

from tumble.compare.grade.hypotheses.explanation import Mistake
from tumble.compare.grade.model.program_model import FINE, correct_program
from tumble.compare.grade.search.causal import Candidate, CausalSearch
from tumble.compare.grade.search.closing import Closing
from tumble.compare.grade.search.proposals import _same_values
from tumble.scenarios.read import read_scene, scene_path

FAR = """
title = "Brick thrown far from the origin"
duration = 1.0
samples = 50
step = 0.001
gravity = [0.0, -9.81, 0.0]
[body]
shape = "box"
size = [0.4, 0.15, 0.1]
mass = 2.4
position = [-1.3, -1.2, 0.2]
angular_velocity = [-3.0, -1.0, -2.0]
"""
THROWN = FAR.replace("angular_", "velocity = [0.0, -5.6, 0.8]\nangular_").replace(
    "[-3.0, -1.0, -2.0]", "[-0.4, 0.5, -0.4]"
)
SMALL = """
title = "Small body thrown from the origin"
duration = 3.0
samples = 20
step = 0.001
gravity = [0.0, -9.81, 0.0]
[body]
shape = "rigid"
mass = 1.2
inertia = [[0.0024, -0.0005, 0.0003], [-0.0005, 0.0033, -0.0009], [0.0003, -0.0009, 0.0028]]
points = [[0.03, 0.0, -0.04], [0.02, 0.01, -0.02], [0.06, 0.0, -0.05], [-0.01, -0.02, -0.05], [0.06, -0.01, 0.01]]
velocity = [1.3, 1.2, -0.2]
angular_velocity = [0.0, 0.8, 0.0]
"""
SLOW = THROWN.replace("[0.4, 0.15, 0.1]", "[1.25, 1.04, 1.43]").replace("duration = 1.0", "duration = 1.5")


@pytest.fixture
def scene_file(tmp_path, request):
    """The scene file whose text a test asks for."""
    path = tmp_path / "scene.toml"
    path.write_text(request.param, encoding="utf-8")
    return path


def mistakes(file, scene, search_s=0.1):
    """Return the mistakes of a file that is explained, by name: their values; search_s: a twentieth of the time."""
    return explained(file, read_scene(str(scene)), search_s)


@pytest.mark.parametrize("scene_file", [FAR], indirect=True)
def test_a_unit_is_named_though_a_start_of_any_size_looks_like_it_at_first(tmp_path, scene_file):
    """With any start velocity and acceleration as well, that explained the first part of the run."""
    rows = fly(scene_file, Program(dt=0.001, every=20, gravity_axes=(2, 0, 1)))
    rows = [(t, 100.0 * x, *rest) for t, x, *rest in rows]
    file = write(tmp_path / "cm.csv", rows, read(scene_file).vertices, form="{:.6g}".format)
    assert mistakes(file, scene_file).keys() == {"wrong-length-unit", "gravity-along-wrong-axis"}


def test_errors_of_many_sizes_of_the_body_have_their_causes(tmp_path):
    """Neither mistake alone makes them as small as the body."""
    thrown, scene_file = tmp_path / "thrown.toml", tmp_path / "weightless.toml"
    thrown.write_text(SMALL, encoding="utf-8")
    scene_file.write_text(SMALL.replace("gravity = [0.0, -9.81, 0.0]\n", ""), encoding="utf-8")
    rows = [(t, 100.0 * x, *rest) for t, x, *rest in fly(thrown, Program(dt=0.001, every=25))]
    file = write(tmp_path / "cm.csv", rows, read(thrown).vertices, form="{:.8g}".format)
    assert mistakes(file, scene_file).keys() == {"wrong-length-unit", "gravity-added"}


@pytest.mark.parametrize(
    ("acceleration", "name"), [((0.0, -9.81, 0.0), "gravity-added"), ((0.5, -9.8, 0.0), "constant-acceleration")]
)
def test_what_has_a_name_is_named_before_its_values_are_made_plain(tmp_path, acceleration, name):
    """An acceleration of any size and direction explains gravity as well as gravity does."""
    thrown, scene_file = tmp_path / "thrown.toml", tmp_path / "weightless.toml"
    without = SMALL.replace("gravity = [0.0, -9.81, 0.0]\n", "")
    thrown.write_text(f"gravity = {list(acceleration)}\n{without}", encoding="utf-8")
    scene_file.write_text(without, encoding="utf-8")
    pose = correct_program(read_scene(str(thrown)), 0).output(np.arange(61) * 0.05, FINE)
    file = write_poses(tmp_path / "right.csv", pose.times, pose.x, pose.q)
    evaluator, every = evaluator_of(file, read_scene(str(scene_file)))
    any_size = next(h for h in every if h.name == "constant-acceleration")
    best = evaluator.explain((Mistake(any_size, acceleration),))
    assert best.is_whole
    assert Closing(evaluator, CausalSearch(evaluator)).simplified(best).names == {name}


class HitAtItsCentre(Spoilt):
    """A body that does not rotate."""

    def strike(self, impulse):
        """Apply an impulse."""
        self.push(np.array(impulse["value"]), np.zeros(3))


@pytest.mark.parametrize("late_s", [0.004, 0.006])
def test_a_time_and_a_step_whose_ticks_it_falls_on_are_named_together(tmp_path, late_s):
    """The time that fits best without steps is between two ticks, and no fit passes from there to the right one."""
    path = scene_path("die-straight")
    throw = read(path)
    late = replace(throw, impulses=[{**impulse, "time": late_s} for impulse in throw.impulses])
    flight = HitAtItsCentre(late, dt=0.002, every=2, method="symplectic", turn="exponential", until=0.8)
    file = write(tmp_path / "late.csv", flight.rows(), throw.vertices, form="{:.8g}".format)
    found = mistakes(file, path)
    assert found == {"impulse-at-wrong-time": pytest.approx(late_s), "symplectic-euler": pytest.approx(0.002)}


def with_noise(rows, sigma, seed):
    """Yield rows of a program with noise of each number of the centre [m], and less of the quaternion."""
    random = np.random.default_rng(seed)
    for t, x, R, q, *rest in rows:
        yield t, x + sigma * random.standard_normal(3), R, q + 0.5 * sigma * random.standard_normal(4), *rest


def test_what_was_as_good_before_is_tried_with_what_has_been_added():
    """In noise, drags in the first and the second power of the speed are alike until the body stops."""
    before = [mistakes_of("a"), mistakes_of("b"), mistakes_of("c")]
    stops, other_stop = mistakes_of("s")[0], mistakes_of("s")[0]
    scores = {"as": 9.0, "bs": 4.0}
    search = CausalSearch.__new__(CausalSearch)
    search._proposals, search._cost = SimpleNamespace(ordered=tuple), len
    search._fitted = lambda mistakes: fitted(mistakes, scores)
    pool = [fitted((*before[0], stops), scores)]
    swapped = search._swapped(pool, [*before[:2], (*before[2], other_stop)])
    assert ["".join(m.hypothesis.name for m in each.mistakes) for each in swapped] == ["bs", "as"]
    assert search._swapped(pool, [pool[0].mistakes, before[1]]) == pool, "nothing was added"


def fitted(mistakes, scores):
    """Return a candidate whose score is looked up by its mistakes' names."""
    score = scores["".join(m.hypothesis.name for m in mistakes)]
    return Candidate(mistakes, score, score, False, score)


@pytest.mark.parametrize(
    ("values", "unit", "tried"),
    [((0.0, 1.0), "s", [0.025]), ((-1.0, 1.0), "s", [0.025, -0.025]), ((0.0, 1.0), "m", []), ((0.1, 1.0), "s", [])],
)
def test_another_mistake_of_a_part_is_tried_with_the_same_value(values, unit, tried):
    """A body that starts late has the rows of a program that logs late, until an impulse acts."""
    late, starts = (replace(hypothesis("a"), unit=each) for each in ("s", unit))
    assert _same_values(Mistake(late, 0.025), replace(starts, values=values)) == tried


@pytest.mark.parametrize("scene_file", [SLOW], indirect=True)
@pytest.mark.parametrize("seed", [1, 2])
def test_in_noise_a_step_is_a_part_of_the_row_interval_if_that_fits_better(tmp_path, scene_file, seed):
    """Steps of 1/960 s, forty in an interval; a step of 1 ms, which is no part of one, leaves noise as well."""
    throw = read(scene_file)
    flight = Spoilt(
        throw, dt=1 / 960, every=40, method="symplectic", turn="exponential", axes="body", gyroscopic="still in body"
    )
    file = write(tmp_path / "noisy.csv", with_noise(flight.rows(), 2e-4, seed), throw.vertices, form="{:.5g}".format)
    assert mistakes(file, scene_file) == {"gyroscopic-term-missing": 0.0, "symplectic-euler": pytest.approx(1 / 960)}


@pytest.mark.parametrize("method", ["explicit", "symplectic"])
def test_noise_and_single_precision_explain_together_what_neither_explains_alone(tmp_path, method):
    """Rounding moves the last rows by 0.5 mm and the first by nothing, and the noise is 15 um.

    Its numbers are none of single precision, though the program is.
    """
    path = scene_path("yardstick")
    program = Program(
        dt=1 / 240, every=8, method=method, turn="exponential", axes="momentum", until=5.0, number=np.float32
    )
    file = write(
        tmp_path / "noisy.csv", with_noise(fly(path, program), 1.5e-5, 1), read(path).vertices, form="{:.8g}".format
    )
    assert mistakes(file, path) == {f"{method}-euler": pytest.approx(1 / 240)}
