"""Readings of a sensor: planted mistakes are named, noise is no mistake, and bad input is one line."""

import re
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from in_process import tumble as command
from scipy.spatial.transform import Rotation
from sensor_programs import (
    MISTAKES,
    Imu,
    Motion,
    bug_reports,
    combined,
    random_scene,
    random_times,
    readings,
    toml,
    write,
)

from tumble.compare.grade.measure.whiteness import is_white
from tumble.compare.grade.sensor_grade import SensorGrade
from tumble.compare.grade.study import grade_file
from tumble.compare.grade.verdicts import (
    CORRECT_TO_DIGITS,
    CORRECT_TO_NOISE,
    CORRECT_TO_RESOLUTION,
    EXPLAINED_WHOLLY,
    FOLLOWS_MOTION,
    NO_MISTAKE_SEEN,
    RIGHT,
)
from tumble.reports.sensor_grade import sensor_headline
from tumble.scenarios.read import read_scene, scene_of

ROOT = Path(__file__).parents[3]
EXAMPLES = ROOT / "docs/sensors"
LATE = "sensor-late"


def scene_like(seed: int, gravity: bool = True) -> dict:
    """Return a random scene, of a seed, with gravity where a test is about it."""
    scene = random_scene(np.random.default_rng(seed))
    return scene | ({"gravity": [0.0, -9.81, 0.0]} if gravity else {})


def graded(folder: Path, scene: dict, times: np.ndarray, rows: np.ndarray, digits: int = 0) -> SensorGrade:
    """Return the grade of readings written to a file."""
    write(folder / "imu.csv", times, rows, digits)
    found = grade_file(str(folder / "imu.csv"), scene_of(toml(scene), folder / "scene.toml", "scene.toml"))
    assert found.pose is None
    assert found.sensor is not None
    return found.sensor


def named(found: SensorGrade) -> set:
    return {mistake.hypothesis.name for device in found.devices for mistake in device.mistakes}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_planted_mistake_is_named_alone_and_with_a_late_clock(mistake, tmp_path):
    scene = scene_like(list(MISTAKES).index(mistake))
    motion, rng = Motion(scene), np.random.default_rng(0)
    times = np.arange(101) / 50
    for names in ({mistake}, {mistake, LATE}):
        found = graded(tmp_path, scene, times, readings(scene, motion, times, combined(*names), rng))
        assert (named(found), found.verdict) == (names, EXPLAINED_WHOLLY), sensor_headline(found)


def test_a_right_program_is_right_and_to_its_digits(tmp_path):
    scene = scene_like(77)
    times = np.arange(101) / 50
    rows = readings(scene, Motion(scene), times, Imu(), np.random.default_rng(0))
    assert graded(tmp_path, scene, times, rows).verdict == CORRECT_TO_RESOLUTION
    assert graded(tmp_path, scene, times, rows, digits=5).verdict == CORRECT_TO_DIGITS
    rows[60, 1] += 0.1
    assert graded(tmp_path, scene, times, rows, digits=5).verdict not in RIGHT, (
        "one reading is off by far more than its digits"
    )


def test_the_files_of_three_bug_reports_are_what_those_programs_write():
    scene = tomllib.loads((EXAMPLES / "brick-imu.toml").read_text(encoding="utf-8"))
    for name, rows in bug_reports(scene, np.arange(101) / 50).items():
        seen = np.loadtxt(EXAMPLES / f"{name}.csv", delimiter=",", skiprows=1)[:, 1:]
        assert np.abs(seen - rows).max() < 1e-4, name
    assert np.allclose(
        np.linalg.norm(bug_reports(at_centre(scene), np.arange(3) / 50)["rocketpy-1175"][:, :3], axis=1), 19.62
    )


def at_centre(scene: dict) -> dict:
    return scene | {"sensor": [scene["sensor"][0] | {"point": [0.0, 0.0, 0.0]}]}


def test_the_examples_of_the_guide_print_what_it_shows(tmp_path):
    """The three bug reports are named in the first sentence."""
    guide = (ROOT / "docs/grade.md").read_text(encoding="utf-8")
    shown = re.findall(r"^ {4}\$ tumble (grade docs/sensors/.*)\n((?: {4}.*\n)+)", guide, re.MULTILINE)
    assert len(shown) == 3
    for words, printed in shown:
        found = command(ROOT, *words.split())
        assert found.returncode == 0
        first = " ".join(found.stdout.partition("\n\n")[0].split())
        assert " ".join(printed.split()) == first


def test_noise_is_no_mistake_and_hides_none(tmp_path):
    """A small share of tools/sensor_noise.py, with files that differ from run to run."""
    seed = np.random.SeedSequence().entropy % 2**32
    print(f"seed {seed}")
    rng = np.random.default_rng(seed)
    for mistake in (None, None, *rng.choice(list(MISTAKES), 2)):
        scene = scene_like(int(rng.integers(2**32)))
        times = random_times(rng, scene)
        program = Imu() if mistake is None else combined(mistake)
        rows = readings(scene, Motion(scene), times, replace(program, noise=(0.02, 0.002)), rng)
        verdict = graded(tmp_path, scene, times, rows, digits=8).verdict
        assert (verdict in (CORRECT_TO_NOISE, NO_MISTAKE_SEEN)) if mistake is None else (verdict not in RIGHT), mistake


def test_readings_of_a_wrong_motion_are_compared_with_that_motion(tmp_path):
    """A falling brick without gravity: a right sensor on it, and one that also leaves out w x (w x r)."""
    scene = tomllib.loads((EXAMPLES / "brick-imu.toml").read_text(encoding="utf-8"))
    (tmp_path / "scene.toml").write_text(toml(scene), encoding="utf-8")
    weightless = Motion({key: value for key, value in scene.items() if key != "gravity"})
    times = np.arange(101) / 50
    states = [weightless.pieces[-1][1](t) for t in times]
    poses = [(*s[0:3], *np.roll(Rotation.from_matrix(s[6:15].reshape(3, 3)).as_quat(), 1)) for s in states]
    weightless.gravity = np.array(scene["gravity"])  # which its accelerometer takes off all the same
    weightless.rates = lambda t, state: (
        Motion.rates(weightless, t, state) - np.concatenate((np.zeros(3), weightless.gravity, np.zeros(12)))
    )
    for program, verdict, named_ones in (
        (Imu(), FOLLOWS_MOTION, set()),
        (Imu(centripetal=0.0), EXPLAINED_WHOLLY, {"sensor-centripetal-term-missing"}),
    ):
        rows = readings(scene, weightless, times, program, np.random.default_rng(0))
        header = "t_s,x_m,y_m,z_m,qw,qx,qy,qz,ax_m_s2,ay_m_s2,az_m_s2"
        table = np.column_stack((times, poses, rows[:, :3]))
        np.savetxt(tmp_path / "both.csv", table, "%.12g", ",", header=header, comments="")
        found = grade_file(str(tmp_path / "both.csv"), read_scene(str(tmp_path / "scene.toml")))
        assert {m.hypothesis.name for m in found.pose.diagnosis.best.mistakes} == {"gravity-missing"}
        assert found.sensor.devices[0].measured.worst > 5.0, "against the true motion"
        assert (found.sensor.verdict, named(found.sensor)) == (verdict, named_ones)


def test_mistakes_that_noise_hides_are_listed(tmp_path):
    scene = scene_like(3)
    scene["sensor"][0]["point"] = [1e-4, 0.0, 0.0]
    times = np.arange(201) / 100
    rows = readings(scene, Motion(scene), times, Imu(noise=(0.1, 0.01)), np.random.default_rng(1))
    found = graded(tmp_path, scene, times, rows)
    assert found.verdict == NO_MISTAKE_SEEN
    assert "alpha x r" in sensor_headline(found)


def test_whiteness():
    rng = np.random.default_rng(4)
    noise = rng.standard_normal((1000, 3))
    runs = [slice(0, 1000)]
    assert is_white(noise, runs)
    walk = noise.copy()
    for k in range(1, 1000):
        walk[k] = 0.3 * walk[k - 1] + noise[k]
    assert not is_white(walk, runs)
    assert not is_white(noise + 0.3 * np.sin(np.arange(1000) / 150)[:, None], runs), "a slow drift below the noise"
    noise[500] *= 20
    assert not is_white(noise, runs), "a spike"


COLUMNS = "t_s,ax,ay,az,gx,gy,gz"
BAD = {
    "no sensor": ("", "", ["--map", "ax=ax_g"], "has no sensor, so readings have no reference: add [[sensor]]"),
    "several": ("imu", "tail", [], "has several sensors: give one of them with --sensor NAME: 'imu', 'tail'"),
    "unknown": ("imu", "tail", ["--sensor", "nose"], "--sensor 'nose': bricks has no such sensor, only 'imu', 'tail'"),
    "unit": ("imu", "", [], "'ax', 'ay', 'az', 'gx', 'gy', 'gz': in which unit?  If SI: --map ax=ax_m_s2"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_one_line(case, tmp_path):
    first, second, options, line = BAD[case]
    scene = {key: value for key, value in scene_like(1).items() if key != "sensor"}
    text = toml(scene) + "".join(
        f'[[sensor]]\nname = "{name}"\nkind = "imu"\nrate = 100.0\n' for name in (first, second) if name
    )
    (tmp_path / "bricks.toml").write_text(text)
    header = COLUMNS if case in ("unit", "no sensor") else "t_s,ax_m_s2,ay_m_s2,az_m_s2"
    rows = "\n".join(",".join([f"{0.01 * k:.2f}", *["0.5"] * header.count(",")]) for k in range(20))
    (tmp_path / "imu.csv").write_text(f"{header}\n{rows}\n")
    found = command(tmp_path, "grade", "imu.csv", "--scene", "bricks.toml", *options)
    assert found.returncode == 2
    assert line in found.stderr
    assert found.stderr.count("\n") == 1
