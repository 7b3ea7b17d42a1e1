"""Contact in files of programs that share nothing with Tumble: right ones are right, and each mistake is named."""

import ast
import math
import re
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from in_process import tumble as command

from tools.contact_programs import programs
from tools.contact_programs.programs import Program, Scene, rows_of, toml, written
from tumble.compare.grade.grade import Grade
from tumble.compare.grade.model.contact_law import Approach, ContactLaw, after_impact
from tumble.compare.grade.study import grade_file
from tumble.compare.grade.verdicts import CORRECT_TO_DIGITS, CORRECT_TO_STEP, EXPLAINED_WHOLLY
from tumble.scenarios.read import read_scene, scene_of

TILT = 0.2
DROP = Scene("drop", 0.7, 0.0, radius=0.1, x=(0.0, 1.1, 0.0), duration=1.6)
THROW = Scene("throw", 0.7, 0.3, radius=0.1, x=(0.0, 1.1, 0.0), v=(1.0, 0.0, 0.7), w=(-8.0, 2.0, 6.0), duration=1.6)
SLIDE = Scene("slide", 0.0, 0.4, half=(0.25, 0.05, 0.25), x=(0.0, 0.05, 0.0), v=(1.8, 0.0, 0.8), duration=0.8)
HOLD = Scene("hold", 0.0, 0.5, 0.3, half=(0.2, 0.05, 0.2), x=(0.0, 0.05, 0.0), duration=0.5)
ROLL = Scene("roll", 0.0, 0.3, radius=0.1, x=(0.0, 0.1, 0.0), v=(2.0, 0.0, 0.0), w=(15.0, 0.0, 10.0), duration=1.0)
CORNER = Scene(
    "corner",
    0.6,
    0.3,
    half=(0.1, 0.15, 0.2),
    x=(0.0, 0.4, 0.0),
    v=(0.8, -1.0, 0.4),
    w=(1.0, 0.5, -2.0),
    q=(0.8, 0.3, -0.4, 0.33166247903554),
    duration=0.12,
)
TWICE = Scene(
    "corner",
    0.5,
    0.0,
    half=(0.008, 0.008, 0.008),
    mass=0.005,
    x=(0.0, 0.03, 0.0),
    v=(0.5, -1.0, 0.3),
    w=(10.0, 5.0, -20.0),
    q=tuple((np.array((0.8, 0.3, -0.4, 0.35)) / np.linalg.norm((0.8, 0.3, -0.4, 0.35))).tolist()),
    duration=0.04,
)
MISTAKES = {
    "contact-restitution-squared": (DROP, "e squared", {}),
    "contact-product-rule": (replace(THROW, mu=0.15), "product rule", {}),
    "contact-friction-squared": (ROLL, "product rule", {}),
    "contact-friction-at-centre": (THROW, "friction at centre", {}),
    "contact-pyramid": (SLIDE, "pyramid", {"cone": "diamond"}),
    "contact-bounce-threshold": (DROP, "bounce threshold", {"speed": 2.6}),
    "contact-gravity-before-bounce": (DROP, "gravity first", {}),
    "contact-push-out": (DROP, "push-out", {"share": 0.5}),
    "contact-tunnelling": (DROP, "tunnelling", {"thickness": 0.001}),
    "contact-without-touching": (THROW, "margin", {"margin": 0.08}),
    "contact-wrong-normal": (
        replace(THROW, duration=1.0),
        "wrong normal",
        {"normal": (math.sin(TILT), math.cos(TILT), 0.0)},
    ),
    "contact-sleep": (SLIDE, "sleep", {"speed": 0.5}),
    "contact-creep": (HOLD, "creep", {"speed": 0.02}),
}


def graded(folder: Path, scene: Scene, program: Program) -> Grade:
    """Return the grade of a program's file."""
    (folder / "log.csv").write_text(written(scene, program, rows_of(scene, program)), encoding="utf-8")
    found = grade_file(str(folder / "log.csv"), scene_of(toml(scene), folder / "scene.toml", "scene.toml")).pose
    assert found is not None
    return found


def named(found: Grade) -> list[str]:
    assert found.contact is not None
    return [mistake.hypothesis.name for mistake in found.contact.mistakes]


def test_the_programs_share_nothing_with_the_project():
    for file in Path(programs.__file__).parent.rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            for name in names:
                assert name.split(".")[0] in {*sys.stdlib_module_names, "numpy"} or name.startswith(
                    "tools.contact_programs"
                ), (file, name)


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_planted_mistake_is_named(mistake, tmp_path):
    scene, planted, values = MISTAKES[mistake]
    found = graded(tmp_path, scene, Program("steps", 1 / 240, 2, 7, mistake=planted, values=values))
    assert (named(found), found.verdict) == ([mistake], EXPLAINED_WHOLLY)


def test_a_creep_is_found_in_rows_of_many_steps(tmp_path):
    scene = replace(SLIDE, mu=0.53, incline=0.2, v=(-1.1, 0.0, 0.3))
    found = graded(tmp_path, scene, Program("steps", 1 / 1200, 10, 6, mistake="creep", values={"speed": 0.2}))
    assert (named(found), found.verdict) == (["contact-creep"], EXPLAINED_WHOLLY)


def test_a_body_that_is_shaken_on_the_plane_slides_all_the_same(tmp_path):
    # A yielding contact lifts the body by less than a thousandth of its size in every other row.
    rows = rows_of(SLIDE, Program("steps", 1 / 240, 1, 9, mistake="pyramid", values={"cone": "diamond"}))
    rows[1::2, 1] += 1e-4
    (tmp_path / "log.csv").write_text(written(SLIDE, Program("steps", 1 / 240, 1, 9), rows), encoding="utf-8")
    found = grade_file(str(tmp_path / "log.csv"), scene_of(toml(SLIDE), tmp_path / "scene.toml", "scene.toml")).pose
    assert found is not None
    assert named(found) == ["contact-pyramid"]


@pytest.mark.parametrize("clamp", [False, True])
@pytest.mark.parametrize("scene", [DROP, THROW, SLIDE, HOLD, ROLL], ids=lambda scene: scene.kind)
def test_a_right_program_is_right_to_its_step(scene, clamp, tmp_path):
    found = graded(tmp_path, scene, Program("steps", 1 / 100, 1, 6, clamp=clamp, bounce_first=not clamp))
    assert found.verdict in (CORRECT_TO_STEP, CORRECT_TO_DIGITS)


def test_a_right_program_without_steps_is_right_to_its_digits_and_a_corner_has_both_laws(tmp_path):
    assert graded(tmp_path, THROW, Program("events", 1 / 100, 1, 6)).verdict == CORRECT_TO_DIGITS
    assert graded(tmp_path, CORNER, Program("events", 1 / 1000, 1, 6)).verdict == CORRECT_TO_STEP
    # Friction after the normal impulse is another law, where the slip turns in the impact of a corner.
    found = graded(tmp_path, CORNER, Program("steps", 1 / 2000, 2, 7))
    assert (named(found), found.verdict) == (["contact-friction-after-normal"], EXPLAINED_WHOLLY)


@pytest.mark.parametrize(("mistake", "name"), [("", None), ("e squared", "contact-restitution-squared")])
def test_two_corners_that_meet_the_plane_between_two_rows_are_compared_as_one(mistake, name, tmp_path):
    # The second one follows after 62 us.
    found = graded(tmp_path, TWICE, Program("steps", 5e-5, 8, 9, mistake=mistake))
    assert found.contact is not None
    assert [bool(one.chain) for one in found.contact.motion.impacts] == [True]
    assert named(found) == ([name] if name else [])
    assert found.verdict == (EXPLAINED_WHOLLY if name else CORRECT_TO_STEP)


def test_a_missing_rebound_is_found_though_it_is_shorter_than_four_rows_or_the_contact_yields(tmp_path):
    scene, cut = replace(DROP, e=0.31), Program("steps", 1e-3, 10, 7, mistake="bounce threshold", values={"speed": 1.0})
    assert named(graded(tmp_path, scene, cut)) == ["contact-bounce-threshold"]
    # A ball that sinks in for 20 rows and comes to rest.
    program = Program("steps", 1e-3, 2, 9)
    rows = np.array([rows_of(DROP, program)[0]] * 801)
    t = np.arange(801) * 0.002
    met = np.sqrt(2 / 9.81)
    into = np.maximum(t - met, 0.0)
    rows[:, 1] = np.where(t < met, 1.1 - 9.81 / 2 * t**2, 0.1 - 9.81 * met * into * np.exp(-into / 0.005))
    (tmp_path / "log.csv").write_text(written(DROP, program, rows), encoding="utf-8")
    found = grade_file(str(tmp_path / "log.csv"), scene_of(toml(DROP), tmp_path / "scene.toml", "scene.toml")).pose
    assert found is not None
    assert named(found) == ["contact-no-restitution"]


def test_a_creep_is_not_taken_for_a_late_start(tmp_path):
    # A box that slides from rest: viscous friction delays it by a time that is no half of a step of these rows.
    scene = replace(HOLD, mu=0.36, incline=0.4455, duration=1.1)
    found = graded(tmp_path, scene, Program("steps", 1 / 600, 10, 8, mistake="creep", values={"speed": 0.01}))
    assert named(found) == ["contact-creep"]


def test_a_corner_that_friction_holds_leaves_the_plane_without_slip_and_energy_is_not_gained():
    body = scene_of(toml(CORNER), Path("scene.toml"), "scene.toml").body
    lever = np.array((0.05, -0.12, -0.2))
    at = Approach(np.array((0.1, 0.2, -2.0)), np.array((1.0, -2.0, 0.5)), np.eye(3), lever, 0.0)
    for how in ("instant", "whole"):
        v, w = after_impact(body, at, ContactLaw(0.5, 50.0, in_impact=how))
        before, after = (each + np.cross(spin, lever) for each, spin in ((at.v, at.w), (v, w)))
        assert after == pytest.approx((0.0, 0.0, -0.5 * before[2]), abs=1e-9), how


def test_the_command_prints_observables_and_writes_tables(tmp_path, monkeypatch):
    program = Program("steps", 1 / 240, 2, 7, mistake="e squared")
    (tmp_path / "log.csv").write_text(written(DROP, program, rows_of(DROP, program)), encoding="utf-8")
    (tmp_path / "drop.toml").write_text(toml(DROP), encoding="utf-8")
    monkeypatch.setenv("COLUMNS", "80")
    found = command(tmp_path, "grade", "log.csv", "--scene", "drop.toml", "-o", "out")
    assert found.returncode == 0, found.stderr
    assert found.stdout.startswith("log.csv is wrong: the restitution is e^2 = 0.49")
    assert re.search(r"restitution +0\.4[89]\d* +0\.7 ", found.stdout)
    assert "contact-restitution-squared" in (tmp_path / "out/contact-diagnosis.csv").read_text(encoding="utf-8")
    assert (tmp_path / "out/contact-grade.csv").read_text(encoding="utf-8").count("restitution") >= 2


def test_the_whole_impulse_is_named_before_a_pyramid_that_in_plane_motion_is_the_same(tmp_path):
    """PyBullet applies Coulomb's friction to the impulse as a whole; the slip stays on an axis of the pyramid."""
    shown = command(tmp_path, "scenes", "die-corner-planar")
    (tmp_path / "planar.toml").write_text(shown.stdout.replace("samples  = 20", "samples  = 125"), encoding="utf-8")
    flown = command(tmp_path, "run", "planar.toml", "-e", "pybullet:multibody")
    (tmp_path / "log.csv").write_text(flown.stdout, encoding="utf-8")
    found = grade_file(str(tmp_path / "log.csv"), read_scene(str(tmp_path / "planar.toml"))).pose
    assert found is not None
    assert found.contact is not None
    names = [one.mistakes[0].hypothesis.name for one in found.contact.explanations]
    assert names == ["contact-whole-impulse", "contact-pyramid", "contact-pyramid"]


def test_a_wrong_flight_is_reported_before_its_contact(tmp_path):
    text = written(DROP, Program("steps", 1 / 100, 1, 7), rows_of(DROP, Program("steps", 1 / 100, 1, 7)))
    header, *lines = text.splitlines()
    rows = [line.split(",") for line in lines]
    # Half of the gravity: x is a column of the world's y.
    slow = [",".join((t, x, f"{1.1 - 0.5 * (1.1 - float(y)):.9g}", *rest)) for t, x, y, *rest in rows]
    (tmp_path / "log.csv").write_text("\n".join((header, *slow)) + "\n", encoding="utf-8")
    found = grade_file(str(tmp_path / "log.csv"), scene_of(toml(DROP), tmp_path / "scene.toml", "scene.toml")).pose
    assert found is not None
    assert found.contact is not None
    assert found.contact.is_wrong_before
    assert found.verdict not in (CORRECT_TO_STEP, CORRECT_TO_DIGITS)
