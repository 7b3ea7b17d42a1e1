"""Files with noise: values are fitted to all rows, as precisely as these allow, before what is left is judged."""

import numpy as np
import pytest
from explained import explained
from pose_files import write_poses

from tumble.compare.grade.grade import grade
from tumble.compare.grade.model.program_model import FINE, correct_program
from tumble.compare.grade.verdicts import EXPLAINED_WHOLLY
from tumble.scenarios.frames import quaternion_product
from tumble.scenarios.read import read_scene

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
