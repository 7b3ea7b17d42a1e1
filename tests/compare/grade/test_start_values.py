"""A start that differs from the scene is reported with what the file has, in the file's axes."""

import csv

import numpy as np
import pytest
from pose_files import SKEWED, write_poses

from tumble.__main__ import main
from tumble.compare.grade.model.program_model import FINE, correct_program
from tumble.scenarios.frames import quaternion_product
from tumble.scenarios.read import read_scene


@pytest.mark.parametrize(
    ("name", "place", "value"),
    [
        ("wrong-start-position", slice(0, 3), (0.3, 1.25, -0.4)),
        ("wrong-start-attitude", slice(3, 7), (0.5, -0.1, 0.7, 0.5)),
    ],
)
def test_the_value_is_what_the_first_row_has(name, place, value, tmp_path, capsys):
    (tmp_path / "skewed.toml").write_text(SKEWED)
    scene = read_scene(str(tmp_path / "skewed.toml"))
    program = correct_program(scene, 0)
    state = program.start.copy()
    q = np.array(value)
    if place.start == 3:  # the principal axes with the file's axes in them
        w, xyz = scene.body.file_axes[0], -np.array(scene.body.file_axes[1:])
        q = np.array([q[0] * w - q[1:] @ xyz, *(q[0] * xyz + w * q[1:] + np.cross(q[1:], xyz))])
    state[place] = q
    times = np.linspace(0.0, 1.0, 26)
    pose = program.but(start=state).output(times, FINE)
    assert (pose.x[0] if place.start == 0 else pose.q[0]) == pytest.approx(np.array(value), abs=1e-12)
    write_poses(tmp_path / "a.csv", times, pose.x, pose.q)
    assert main(["grade", str(tmp_path / "a.csv"), "--scene", str(tmp_path / "skewed.toml"), "-o", str(tmp_path)]) == 0
    assert ", ".join(f"{number:.4g}" for number in value) in capsys.readouterr().out
    with (tmp_path / "diagnosis.csv").open(encoding="utf-8") as file:
        found = [row for row in csv.DictReader(file) if row["mistake"] == name]
    assert [(row["parameter"], row["unit"]) for row in found] == [("vector", "m" if place.start == 0 else "")]
    assert [float(number) for number in found[0]["value"].split()] == pytest.approx(value, abs=1e-9)


@pytest.mark.parametrize(
    ("line", "other", "named"),
    [
        (
            "velocity = [0.4, 2.0, -0.7]",
            (0.4 / 3.6, 2.0 / 3.6, -0.7 / 3.6),
            "0.2778 times its value (m/s read as km/h)",
        ),
        (
            "angular_velocity = [1.0, 2.0, -0.5]",
            (2 * np.pi, 4 * np.pi, -np.pi),
            "start angular velocity 6.283 times its value (rad/s read as turns/s)",
        ),
    ],
)
def test_a_start_in_another_unit_is_a_factor(line, other, named, tmp_path, capsys):
    scene = tmp_path / "skewed.toml"
    scene.write_text(SKEWED.replace("\n" + line, f"\n{line.partition('=')[0]}= {list(other)}"))
    assert main(["run", str(scene), "-e", "tumble:exact", "-o", str(tmp_path / "a.csv")]) == 0
    scene.write_text(SKEWED)
    capsys.readouterr()
    assert main(["grade", str(tmp_path / "a.csv"), "--scene", str(scene)]) == 0
    assert named in " ".join(capsys.readouterr().out.split()).partition("Most likely cause")[2].partition(".csv")[0]


@pytest.mark.parametrize(
    ("order", "said"),
    [
        ([3, 0, 1, 2], "start attitude set as w x y z and read as x y z w"),
        ([1, 2, 3, 0], "start attitude set as x y z w and read as w x y z"),
    ],
)
def test_an_attitude_read_in_another_order_is_named_in_any_axes(order, said, tmp_path, capsys):
    """In other axes, the attitude of the first row is not the one that the body had."""
    (tmp_path / "skewed.toml").write_text(SKEWED)
    scene = read_scene(str(tmp_path / "skewed.toml"))
    program = correct_program(scene, 0)
    state, times = program.start.copy(), np.linspace(0.0, 1.0, 26)
    q = quaternion_product(state[3:7], scene.body.file_axes)[order]
    state[3:7] = quaternion_product(q, scene.body.file_axes * (1, -1, -1, -1))
    pose = program.but(start=state).output(times, FINE)
    axes = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
    write_poses(tmp_path / "a.csv", times, pose.x @ axes.T, np.hstack((pose.q[:, :1], pose.q[:, 1:] @ axes.T)))
    assert main(["grade", str(tmp_path / "a.csv"), "--scene", str(tmp_path / "skewed.toml")]) == 0
    answer = " ".join(capsys.readouterr().out.split())
    assert "Most likely cause" in answer
    assert f"{said}: " in answer
    assert "wrong axes: x y z replaced by z y -x: " in answer
