"""Never right beyond what the printed digits leave, and too coarse to grade where they leave more than shows a body."""

import csv

import numpy as np
import pytest

from tumble.__main__ import main
from tumble.compare.grade.grade import COARSE, grade
from tumble.compare.grade.measure.errors import moved_by
from tumble.compare.grade.model.reference import Reference
from tumble.compare.grade.verdicts import CORRECT_TO_DIGITS, TOO_COARSE, TOO_LITTLE
from tumble.scenarios.frames import vertices
from tumble.scenarios.read import read_scene

SCENE = "two-hits"
POSE = ["x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"]


@pytest.fixture(scope="module")
def right():
    times = np.linspace(0, 2, 61)
    return times, Reference(read_scene(SCENE)).states(0, times)[:, :7]


def graded(folder, times, pose, form):
    """Return the grade of a file; form: of each of the seven numbers."""
    path = folder / "file.csv"
    with path.open("w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["t_s", *POSE])
        rows.writerows(
            [repr(t), *(each.format(n) for each, n in zip(form, row, strict=True))]
            for t, row in zip(times.tolist(), pose.tolist(), strict=True)
        )
    return path, grade(path, read_scene(SCENE), {})


def test_metres_and_an_attitude_that_stands_still_are_not_right(tmp_path, right, capsys):
    times, pose = right
    still = np.hstack((pose[:, :3], np.tile([1.0, 0.0, 0.0, 0.0], (len(pose), 1))))
    path, found = graded(tmp_path, times, still, ["{:.0f}"] * 7)
    assert found.measured.worst_m > found.measured.half_m > found.scale.size_m
    assert found.verdict == TOO_COARSE
    assert main(["grade", str(path), "--scene", SCENE]) == 0
    out = capsys.readouterr().out
    assert "is too coarse to grade" in " ".join(out.split())
    assert "right" not in out.split("\n\n")[0]


@pytest.mark.parametrize("places", range(6))
def test_a_right_file_is_right_only_while_its_digits_show_the_body(tmp_path, right, places):
    _, found = graded(tmp_path, *right, [f"{{:.{places}f}}"] * 7)  # pyright: ignore[reportCallIssue]
    m = found.measured
    assert m.worst_m <= m.half_m, "it is right"
    assert found.verdict == (TOO_COARSE if m.half_m > COARSE * found.scale.size_m else CORRECT_TO_DIGITS)
    assert (found.verdict == CORRECT_TO_DIGITS) == (places > 1)


def test_numbers_that_are_cut_off_are_beyond_what_rounding_leaves(tmp_path, right, capsys):
    """Cut at the sixth decimal and not rounded there: off by up to a whole unit, where digits leave half of one."""
    times, pose = right
    cut = np.hstack((np.floor(pose[:, :3] * 1e6) / 1e6, pose[:, 3:]))
    path, found = graded(tmp_path, times, cut, [*["{:.6f}"] * 3, *["{:.12f}"] * 4])
    assert found.measured.half_m < found.measured.worst_m < 2 * found.measured.half_m
    assert found.verdict == TOO_LITTLE
    assert main(["grade", str(path), "--scene", SCENE]) == 0
    first = " ".join(capsys.readouterr().out.split("\n\n")[0].split())
    assert "is nearly right" in first
    assert "printed digits allow about as much" in first


def test_how_far_a_vertex_moves_in_a_moment_is_never_underestimated():
    scene = read_scene(SCENE)
    reference, late = Reference(scene), 0.005
    times = np.linspace(0.01, 0.7, 50)
    states, after, before = (reference.states(0, at) for at in (times, times + late, times - late))
    bound = moved_by(np.full(50, late), states, scene)
    for other in (after, before):
        moved = np.linalg.norm(vertices(other, scene.body.points) - vertices(states, scene.body.points), axis=-1)
        assert (moved.max(axis=1) <= bound).all()
