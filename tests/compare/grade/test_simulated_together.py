"""Programs that are simulated together are those simulated alone; residuals and their squares are as documented."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from explained import evaluator_of
from pose_files import write_poses
from programs import Program, fly, read, write

from tumble.compare.grade.hypotheses.explanation import Mistake
from tumble.compare.grade.hypotheses.mistakes.axes import signed_permutations
from tumble.compare.grade.hypotheses.mistakes.output import _in_axes
from tumble.compare.grade.model.kernel.dynamics import EXPLICIT, QUATERNION, Scheme
from tumble.compare.grade.model.program_model import FINE, Pose, correct_program, outputs
from tumble.compare.grade.search.causal import CausalSearch
from tumble.compare.grade.search.kernels import first_alike, pose_residuals, precisions_of, squares_of
from tumble.compare.grade.search.shells import _arms
from tumble.scenarios.read import read_scene, scene_path

# An impulse; drag and gravity; a tether and gravity; a floor.
SCENES = ("two-hits", "drag-stiff", "tether-critical", "floor-stiff")
ROWS = np.linspace(0.0, 0.2, 5)
STEPS = Scheme(0.02, QUATERNION, EXPLICIT, True, 1.0)


def changed_programs(name, folder):
    """Return a program with each mistake, and one with each upon steps that move the body at ticks."""
    scene = read_scene(name)
    times = np.linspace(0.0, min(0.3, scene.duration), 7)
    right = correct_program(scene, 0).output(times, FINE)
    evaluator, every = evaluator_of(write_poses(folder / "right.csv", times, right.x, right.q), scene)
    correct = evaluator.context.program
    for program in (correct, correct.but(scheme=STEPS, tick=STEPS.step)):
        assert program.numbers is not None  # so that programs made from it have theirs from it
        for hypothesis in every:
            values = hypothesis.values or (0.0,)
            yield hypothesis.change(program, values[len(values) // 2])


@pytest.mark.parametrize("name", SCENES)
def test_a_changed_program_has_the_numbers_of_one_that_is_made_anew(name, tmp_path):
    for program in changed_programs(name, tmp_path):
        assert np.array_equal(program.numbers, replace(program).numbers)


@pytest.mark.parametrize("name", SCENES)
def test_programs_simulated_together_are_those_simulated_alone(name, tmp_path):
    programs = list(changed_programs(name, tmp_path))[::-1]
    for program, together in zip(programs, outputs(programs, ROWS), strict=True):
        alone = program.output(ROWS)
        assert np.array_equal(together.x, alone.x, equal_nan=True)
        assert np.array_equal(together.axes, alone.axes, equal_nan=True)
        assert np.array_equal(together.q, alone.q, equal_nan=True)


def test_what_a_program_writes_is_changed_once_in_a_search(tmp_path):
    """A body of another size changes the vertices in the file, as mistakes of the output do."""
    path = scene_path("brick-tumble")
    rows, corners = fly(path, Program(until=0.5)), read(path).vertices
    file = write(tmp_path / "right.csv", rows, corners, kind=range(len(corners)))
    evaluator, every = evaluator_of(file, read_scene("brick-tumble"))
    size, inverted = (
        next(h for h in every if h.name == name) for name in ("wrong-body-size-along-x", "attitude-inverted")
    )
    simulations = CausalSearch(evaluator)._simulations
    for mistakes in ((Mistake(size, 1.3),), (Mistake(inverted),), (Mistake(size, 1.3), Mistake(inverted))):
        pose = evaluator.program_with(mistakes).output(simulations.shells.times, simulations.fineness)
        expected = simulations.shells.residuals(pose.x[None], pose.axes[None], True)
        for known in ("not yet", "from before"):
            np.testing.assert_allclose(
                simulations.errors([mistakes, ()])[:1], expected, rtol=1e-9, atol=1e-3, err_msg=known
            )


def test_the_squares_of_residuals_are_means_over_shells_and_blocks():
    errors = np.random.default_rng(3).normal(size=(4, 9, 4, 3))
    errors[1, 4, 2], errors[2, 5, 0] = np.nan, 1e9
    edges, points, most = np.array((0, 1, 4, 9)), np.array((0, 1, 4)), 1e6
    found, precisions = np.empty((4, 3, 2)), np.empty((4, 9, 4))
    squares_of(errors, edges, points, most, found)
    precisions_of(found, edges, points, precisions)
    for shell, rows in enumerate(pairwise(edges)):
        for block, own in enumerate(pairwise(points)):
            part = errors[:, slice(*rows), slice(*own)]
            means = np.minimum(np.nan_to_num((part**2).mean(axis=(2, 3)), nan=most), most)
            np.testing.assert_allclose(found[:, shell, block], means.mean(axis=1), rtol=1e-12)
            expected = 1 / (1 + means.mean(axis=1)) / (own[1] - own[0])
            assert precisions[:, slice(*rows), slice(*own)] == pytest.approx(
                np.broadcast_to(expected[:, None, None], precisions[:, slice(*rows), slice(*own)].shape), rel=1e-12
            )


@pytest.mark.parametrize("has_centre", [True, False])
def test_residuals_are_of_the_centre_and_of_three_points_of_the_body(has_centre):
    random = np.random.default_rng(5)
    x, axes, own_x, own_axes = (random.normal(size=shape) for shape in ((2, 5, 3), (2, 5, 3, 3), (5, 3), (5, 3, 3)))
    trust, arms, found = random.uniform(1.0, 9.0, size=(5, 3)), random.normal(size=(3, 3)), np.empty((2, 5, 4, 3))
    pose_residuals(x, axes, own_x, own_axes, arms, has_centre, trust, found)
    centre = own_x - x if has_centre else np.zeros_like(x)
    points = np.einsum("vtij,jk->vtki", own_axes - axes, arms)
    expected = np.concatenate((centre[:, :, None], points), axis=2) * trust[:, None]
    np.testing.assert_allclose(found, expected, rtol=1e-12)


@pytest.mark.parametrize("count", [3, 4, 8])
def test_three_points_move_as_the_vertices_do(count):
    random = np.random.default_rng(6)
    points, moved = random.normal(size=(count, 3)) * (1.0, 0.3, 0.01), random.normal(size=(3, 3))
    assert np.square(moved @ _arms(points)).mean() == pytest.approx(np.square(points @ moved.T).mean(), rel=1e-12)


@pytest.mark.parametrize("vertices", [True, False])
def test_a_pose_in_other_axes_is_turned_by_the_matrix_of_their_names(vertices):
    random = np.random.default_rng(7)
    pose = Pose(np.zeros(2), random.normal(size=(2, 3)), random.normal(size=(2, 3, 3)), random.normal(size=(2, 4)))
    for names in (*signed_permutations(1), *signed_permutations(-1)):
        written = _in_axes(names, vertices)(pose)
        np.testing.assert_allclose(written.x, pose.x @ names.T, rtol=1e-14)
        turned = names @ pose.axes
        np.testing.assert_allclose(written.axes, turned if vertices else turned @ names.T, rtol=1e-14)


def test_rows_that_are_alike_are_those_of_the_first_one():
    rows = np.array(((0.0, 0.0), (3.0, 0.0), (0.5, 0.5), (3.0, 1.0), (3.0, 2.0), (np.inf, 0.0)))
    found = np.empty(len(rows), dtype=int)
    first_alike(rows, 1.0, found)
    assert found.tolist() == [0, 1, 0, 1, 4, 5], "what is like another that is none itself is no first one"
