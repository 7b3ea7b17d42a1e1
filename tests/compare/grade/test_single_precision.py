"""What single precision may explain: what it costs a program, by its twin in double precision, and not much more."""

from pathlib import Path

import numpy as np
import pytest
from pose_files import write_poses
from programs import Program, fly, multiply, read, write
from scipy.spatial.transform import Rotation

from tools.random_programs.program import Program as Drawn
from tools.random_programs.scene import read as drawn_scene
from tools.random_programs.scheme import Scheme as DrawnScheme
from tumble.compare.grade.grade import context_of, grade, scale_of
from tumble.compare.grade.measure.errors import measure
from tumble.compare.grade.measure.significance import EXPLAINED
from tumble.compare.grade.measure.single_precision import single_floor, stepwise
from tumble.compare.grade.model.kernel.dynamics import ALONG_SCREW, EXPLICIT, EXPONENTIAL, IN_BODY_AXES, Scheme
from tumble.compare.grade.model.program_model import FINE, correct_program, output_points
from tumble.compare.grade.model.reference import Reference
from tumble.compare.grade.read.conventions import Conventions
from tumble.compare.grade.read.trajectory import Trajectory
from tumble.compare.grade.search.evaluator import Evaluator
from tumble.compare.grade.verdicts import EXPLAINED_WHOLLY, TOO_LITTLE
from tumble.reports.grade import headline
from tumble.scenarios.frames import rotation_matrix
from tumble.scenarios.read import read_scene, scene_path

CATALOGUE = Path(__file__).parents[3] / "scenarios" / "catalogue"
# Of what is allowed.  Of 432 other programs in steps of their own, the worst cost 0.58, and half of them 0.1 to 0.25.
MOST, LEAST = 0.7, 0.05
STEP, ROWS = 1 / 240, 4


@pytest.mark.parametrize("every", [1, ROWS])
@pytest.mark.parametrize("scene", ["brick-tumble", "two-hits", "yardstick"])
def test_what_single_precision_costs_is_allowed(scene, every):
    path = CATALOGUE / f"{scene}.toml"
    step = STEP * ROWS / every
    runs = [fly(path, Program(dt=step, every=every, until=2.0, number=number)) for number in (np.float64, np.float32)]
    right = read_scene(scene)
    points, times = output_points(right.body), np.array([row[0] for row in runs[0]])
    exact, single = (np.array([x + points @ R.T for _, x, R, *_ in run], float) for run in runs)
    error = np.sqrt(np.square(single - exact).sum(axis=2).mean(axis=1))
    allowed = EXPLAINED * single_floor(stepwise(correct_program(right, 0), step), times, points)
    assert LEAST < np.sqrt(np.square(error / allowed).mean()) < MOST


@pytest.mark.parametrize("dt", [1 / 60, 1 / 240])
def test_what_single_precision_costs_a_spin_taken_from_attitudes_is_allowed(dt):
    """It is a small difference of rounded numbers, divided by the step."""
    scene, count = read_scene("dzhanibekov"), round(4.0 / dt)
    scheme = Scheme(dt, EXPONENTIAL, EXPLICIT, True, 1.0, recovers=True)
    program, points = correct_program(scene, 0).but(gyroscopic=0.0, scheme=scheme), output_points(scene.body)
    runs = [recovered_run(number, scene.start[0], dt, count) for number in (np.float64, np.float32)]
    exact, single = (np.einsum("tij,kj->tki", rotation_matrix(attitudes), points) for attitudes in runs)
    times = dt * np.arange(count + 1)
    simulated = np.einsum("tij,kj->tki", program.output(times, FINE).axes, points)
    assert np.abs(simulated - exact).max() < 1e-9, "it is the same program"
    error = np.sqrt(np.square(single - exact).sum(axis=2).mean(axis=1))[1:]
    ratio = error / (EXPLAINED * single_floor(program, times, points)[1:])
    assert LEAST < np.sqrt(np.square(ratio).mean()) < 1.0


def recovered_run(number, start, dt, count):
    """Return the attitudes of a program that takes w from each two of them, with no other change of w."""
    q, w = start[3:7].astype(number), start[10:13].astype(number)
    found = [q]
    for _ in range(count):
        angle = np.sqrt(w @ w) * number(dt)
        half = number(0.5) * angle
        turn = np.concatenate(([np.cos(half)], np.sin(half) * w / np.sqrt(w @ w))).astype(number)
        new = multiply(turn, q)
        new = new / np.sqrt(new @ new)
        w = number(2) * multiply(new, q * np.array((1, -1, -1, -1), number))[1:] / number(dt)
        q = new
        found.append(q)
    return np.array(found, dtype=float)


@pytest.mark.parametrize(("axes", "kind"), [("body", IN_BODY_AXES), ("screw", ALONG_SCREW)])
@pytest.mark.parametrize("scene", ["die-vertex", "yardstick"])
def test_what_single_precision_costs_a_velocity_in_body_axes_is_allowed(scene, axes, kind):
    """Each step turns it back, which makes it a little longer or shorter, always alike."""
    throw, own = drawn_scene(scene_path(scene).read_text(), scene), read_scene(scene)
    drawn = [
        Drawn(DrawnScheme(dt=STEP, spacing=STEP, gyroscopic="explicit", velocity=axes, single=each)).rows(throw)
        for each in (True, False)
    ]
    scheme = Scheme(STEP, EXPONENTIAL, EXPLICIT, True, 1.0, velocity_axes=kind)
    times = np.arange(int(own.duration / STEP)) * STEP
    allowed = EXPLAINED * single_floor(correct_program(own, 0).but(scheme=scheme), times, own.body.points)
    off = np.linalg.norm(drawn[0].x - drawn[1].x, axis=1)[: len(times)]
    share = np.sqrt(np.square(off).mean() / np.square(allowed).mean())
    assert LEAST < share < MOST


def test_what_single_precision_costs_is_in_the_units_of_the_file():
    scene, times = read_scene("brick-tumble"), np.linspace(0.0, 2.0, 41)
    program, points = stepwise(correct_program(scene, 0), STEP), output_points(scene.body)
    in_cm = program.but(output_transforms=(lambda pose: pose._replace(x=100.0 * pose.x, axes=100.0 * pose.axes),))
    in_m, found = (single_floor(each, times, points) for each in (program, in_cm))
    assert found == pytest.approx(100.0 * in_m)


def test_a_mistake_that_is_larger_is_not_hidden(tmp_path):
    """In double precision, and printed in seven digits: single precision would cost 0.3 mm, the mistake does 4 mm."""
    path = CATALOGUE / "yardstick.toml"
    program = Program(dt=STEP, every=ROWS, axes="body", until=3.0, moments=(1.002, 1.0, 1.0))
    file = write(tmp_path / "inertia.csv", fly(path, program), read(path).vertices, form="{:.7f}".format)
    graded = grade(Path(file), read_scene("yardstick"), {}, search_s=0.1)
    assert 3e-3 < graded.measured.worst_m < 5e-3
    assert graded.measured.may_be_single
    assert not graded.hidden_by_single


@pytest.mark.parametrize(("linear", "says"), [(0.0, "Single precision in short steps would explain"), (0.01, "0.01")])
def test_rounding_in_a_hundred_steps_a_row_is_no_part_of_a_mistake(tmp_path, linear, says):
    """Few programs take so many: a mistake that explains more than rounding is named."""
    path = CATALOGUE / "die-straight.toml"
    program = Program(dt=0.0005, every=100, number=np.float32, linear=linear)
    file = write(tmp_path / "short.csv", fly(path, program), read(path).vertices, form="{:.6g}".format)
    graded = grade(Path(file), read_scene("die-straight"), {})
    assert graded.verdict == (EXPLAINED_WHOLLY if linear else TOO_LITTLE)
    assert says in headline(graded)


@pytest.mark.parametrize(
    ("attitude", "centre", "may_be"),
    [(np.float64, np.float64, False), (np.float64, np.float32, True), (np.float32, np.float64, True)],
)
def test_round_numbers_do_not_speak_for_single_precision(tmp_path, attitude, centre, may_be):
    """In a free flight from round values the centre's numbers are short, so they refute nothing."""
    states = Reference(scene := read_scene("brick-tumble")).states(0, times := np.arange(51) * 0.02)
    x, q = states[:, :3].astype(centre), states[:, 3:7].astype(attitude)
    file = write_poses(tmp_path / "flight.csv", times, x, q, form="%.9g")
    assert measure(Trajectory(file, scene, {}), scene).may_be_single is may_be


@pytest.mark.parametrize(("coordinate", "may_be"), [(np.float64, False), (np.float32, True)])
def test_one_coordinate_of_single_precision_shows_that_a_program_may_be_of_that(tmp_path, coordinate, may_be):
    """It may turn the others, and the attitude, into other axes in double precision when it writes them."""
    states = Reference(scene := read_scene("two-hits")).states(0, times := np.arange(51) * 0.02)
    x, q = states[:, :3].copy(), states[:, 3:7]
    x[:, 2] = x[:, 2].astype(coordinate)
    file = write_poses(tmp_path / "turned.csv", times, x, q, form="%.9g")
    assert measure(Trajectory(file, scene, {}), scene).may_be_single is may_be


@pytest.mark.parametrize(("centre", "may_be"), [(None, True), (np.float64, False), (np.float32, True)])
def test_angles_do_not_speak_against_single_precision(tmp_path, centre, may_be):
    """A program converts its attitude to angles when it writes them, perhaps in double precision; None: it rests."""
    states = Reference(scene := read_scene("two-hits")).states(0, times := np.arange(51) * 0.02)
    x = np.zeros((51, 3)) if centre is None else states[:, :3].astype(centre)
    angles = Rotation.from_quat(states[:, 3:7], scalar_first=True).as_euler("XYZ", degrees=True)
    names = ["t_s", "x_m", "y_m", "z_m", "rx_deg", "ry_deg", "rz_deg"]
    np.savetxt(file := tmp_path / "a.csv", np.c_[times, x, angles], "%.9g", ",", header=",".join(names), comments="")
    trajectory = Trajectory(file, scene, {}, conventions=Conventions(euler="XYZ"))
    assert measure(trajectory, scene).may_be_single is may_be


def test_a_run_that_diverged_is_not_explained_and_warns_nobody(tmp_path):
    """Its errors are too large to be squared; a warning would be an error here."""
    scene = read_scene("brick-tumble")
    states = Reference(scene).states(0, times := np.arange(51) * 0.02)
    file = write_poses(tmp_path / "right.csv", times, states[:, :3], states[:, 3:7])
    measured = measure(Trajectory(file, scene, {}), scene)
    sample, points = measured.sample, output_points(scene.body)
    evaluator = Evaluator(context_of(scene, 0, measured), [], sample, points, scale_of(sample, scene), single=True)
    floors_m = evaluator.search_scale.floors_m
    errors = np.full((len(sample), 4, 3), 1e200)
    assert not evaluator.is_within_floor((), errors, sample.times, floors_m)
    assert evaluator.is_within_floor((), 0.0 * errors, sample.times, floors_m)


@pytest.mark.parametrize(
    ("grows", "digits", "gyroscopic", "named"),
    [
        (3e-4, 7, True, {}),
        (3.5e-3, 7, True, {}),
        (3e-4, 15, True, {"angular-damping-reversed"}),
        (3e-2, 7, True, {"angular-damping-reversed"}),
        (3e-4, 7, False, {"gyroscopic-term-missing"}),
    ],
)
def test_so_slow_a_growth_as_rounding_makes_is_no_mistake(tmp_path, grows, digits, gyroscopic, named):
    """In 0.4 s a spin that grows at 3e-4 /s grows by 1.2e-4, at 3.5e-3 /s by 1.4e-3: steps may all round upwards.

    In a file of 15 digits it cannot.
    """
    scene = read_scene("spin-fast")
    program = correct_program(scene, 0).but(damping=(0.0, 0.0, -grows, 0.0, 0.0), gyroscopic=1.0 if gyroscopic else 0.0)
    pose = program.output(np.arange(41) * 0.01, FINE)
    file = write_poses(tmp_path / "grows.csv", pose.times, pose.x, pose.q, form=f"%.{digits}g")
    found = grade(file, scene, {})
    assert found.diagnosis.best.names == set(named)
    assert bool(found.diagnosis.best.drift) is (digits == 7 and grows < 1e-2)
    assert found.verdict == (EXPLAINED_WHOLLY if named else TOO_LITTLE)
    assert ("rounds in the same direction in every step" in headline(found)) is (not named)
