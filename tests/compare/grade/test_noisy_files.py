"""Files with noise: values are fitted to all rows, as precisely as these allow, before what is left is judged."""

import numpy as np
import pytest
from explained import evaluator_of, explained
from pose_files import write_poses

from tools.random_programs.dialect import Dialect
from tools.random_programs.measurement import measured
from tools.random_programs.program import Program as Drawn
from tools.random_programs.scene import read as drawn_scene
from tools.random_programs.scheme import Reading, Scheme
from tumble.compare.grade.grade import grade
from tumble.compare.grade.hypotheses.explanation import Mistake
from tumble.compare.grade.hypotheses.scheme_hypotheses import Step
from tumble.compare.grade.model.program_model import FINE, correct_program
from tumble.compare.grade.search.causal import CausalSearch
from tumble.compare.grade.verdicts import EXPLAINED_WHOLLY
from tumble.scenarios.frames import quaternion_product
from tumble.scenarios.read import read_scene, scene_path

SCENE = read_scene("brick-tumble")
NOISE, ROWS = 3e-4, 301


def noisy(folder, program):
    """Return the file of a program, with noise of each coordinate [m], and half of it of the attitude [rad]."""
    random, times = np.random.default_rng(5), np.linspace(0.0, 3.0, ROWS)
    pose = program.output(times, FINE)
    turns = np.column_stack((np.ones(ROWS), 0.25 * NOISE * random.standard_normal((ROWS, 3))))
    q = np.array([quaternion_product(*both) for both in zip(turns, pose.q, strict=True)])
    x = pose.x + NOISE * random.standard_normal(pose.x.shape)
    return write_poses(folder / "noisy.csv", times, x, q, form="%.7f")


def moved(program, place, by):
    """Return a program whose start is another one."""
    start = program.start.copy()
    start[place] = by(start[place])
    return program.but(start=start)


@pytest.mark.parametrize(
    ("name", "place", "by", "within"),
    [
        # The mean of N rows is known to the noise over their root: three of these; an attitude half as much.
        ("wrong-start-position", slice(0, 3), lambda x: x + np.array((0.05, 0.0, -0.02)), 3 * NOISE / np.sqrt(ROWS)),
        (
            "wrong-start-attitude",
            slice(3, 7),
            lambda q: quaternion_product(np.array((np.cos(0.1), np.sin(0.1), 0.0, 0.0)), q),
            3 * NOISE / 4 / np.sqrt(ROWS),
        ),
    ],
)
def test_a_start_is_that_of_all_rows_and_not_of_the_first_one(tmp_path, name, place, by, within):
    program = moved(correct_program(SCENE, 0), place, by)
    found = grade(noisy(tmp_path, program), SCENE, {}, search_s=0.1)
    assert found.verdict == EXPLAINED_WHOLLY
    [start] = [m.hypothesis for m in found.diagnosis.best.mistakes if m.hypothesis.name == name]
    assert np.abs(np.abs(start.value) - np.abs(program.start[place])).max() < within


def test_a_rate_is_fitted_to_the_noise_of_all_rows(tmp_path):
    """The search fits it only to what single precision, which these digits do not refute, would leave open."""
    program = correct_program(SCENE, 0).but(damping=(0.0, 0.0142, 0.0, 0.0, 0.0))
    assert explained(noisy(tmp_path, program), SCENE, 0.1) == {"quadratic-drag": pytest.approx(0.0142, rel=2e-4)}


def measured_file(folder, scene, noise, **scheme):
    """Return the file of a program of single precision that shares no code with ours; noise: over the body's size."""
    throw = drawn_scene(scene_path(scene).read_text(), scene)
    rows = measured(Drawn(Scheme(single=True, **scheme)).rows(throw), throw, noise, False, np.random.default_rng(1))
    path = folder / "measured.csv"
    path.write_text(Dialect(digits=7).text(rows))
    return path


def evaluator_and_steps(file, scene):
    """Return what evaluates mistakes, and a function that returns a step of a gyroscopic term and a rotation."""
    evaluator, _ = evaluator_of(file, read_scene(scene), single=True)
    schemes = CausalSearch(evaluator).proposals.schemes
    return evaluator, lambda term, turn, dt: Mistake(schemes.step(Step(term, turn)), dt)


def test_single_precision_is_weighed_against_noise_and_not_against_digits(tmp_path):
    """The motion amplifies it to centimetres in the end, of which a wrong program happens to leave less."""
    euler = {"dt": 1 / 60, "spacing": 1 / 60, "gyroscopic": "implicit"}
    file = measured_file(tmp_path, "dzhanibekov", 5e-5, **euler)
    evaluator, step = evaluator_and_steps(file, "dzhanibekov")
    right, wrong = (evaluator.explain((step("implicit", turn, 1 / 60),)) for turn in ("exponential", "first order"))
    assert evaluator.is_noisy
    assert (right.is_whole, wrong.is_whole) == (True, False)
    assert right.rms_m > wrong.rms_m
    assert right.weight < wrong.weight
    weighed = []
    evaluator._vagueness = lambda scale: weighed.append(scale.floors_m.min()) or 0.0
    evaluator._explain(right.mistakes, 0.0)
    assert weighed == [pytest.approx(evaluator._noise_m, rel=0.01)], "no row is more precise than its noise"


def test_noise_is_seen_at_first_where_rows_between_ticks_hide_it(tmp_path):
    """Later, what single precision makes is as large."""
    euler = {"dt": 1 / 120, "spacing": 0.02, "gyroscopic": "explicit", "turning": "first order"}
    file = measured_file(tmp_path, "brick-tumble", 5e-5, reading=Reading(between="held"), **euler)
    evaluator, step = evaluator_and_steps(file, "brick-tumble")
    tick = Mistake(next(h for h in evaluator.hypotheses if h.name == "fixed-physics-step"), 1 / 120)
    assert not evaluator.is_noisy
    assert evaluator.explain((step("explicit", "first order", 1 / 120), tick)).is_noise
    assert not evaluator.explain((step("explicit", "exponential", 1 / 120), tick)).is_whole


def test_no_noise_is_seen_where_rows_exclude_it(tmp_path):
    euler = {"dt": 1 / 120, "spacing": 1 / 60, "gyroscopic": "explicit", "turning": "first order"}
    evaluator, step = evaluator_and_steps(measured_file(tmp_path, "brick-tumble", 0.0, **euler), "brick-tumble")
    wrong = (step("explicit", "exponential", 1 / 120),)
    errors = evaluator._errors(evaluator.program_with(wrong))
    assert np.abs(errors[:17]).max() > 1e-5
    assert evaluator._noise_at_first(errors) == 0.0
    assert evaluator._noise_at_first(1e-4 * errors) > 0.0, "as large as the digits may be off"
    assert not evaluator.explain(wrong).is_whole
