"""`tumble grade` on files of a program that it did not write: support/programs.py, sharing nothing with its models.

Each case plants one or two mistakes and has the names that must be found, words of the text after a colon, and bounds
of the value; nothing else may be named.  The rest of a program is accurate enough to have no effect.
"""

import math
from pathlib import Path

import numpy as np
import pytest
from programs import Program, fly, read, write

from tumble.__main__ import main
from tumble.compare.grade.grade import grade
from tumble.compare.grade.verdicts import EXPLAINED_WHOLLY, TOO_LITTLE
from tumble.scenarios.read import read_scene

CATALOGUE = Path(__file__).parents[3] / "scenarios" / "catalogue"
PLANK = """
title    = "Plank, struck at a corner"
duration = 1.5
samples  = 30
step     = 0.001
gravity  = [0.0, -9.81, 0.0]
[body]
shape = "box"
size = [0.6, 0.3, 0.1]
mass = 1.7
position = [0.2, 1.0, -0.4]
orientation = [0.9, 0.1, -0.3, 0.3]
velocity = [0.4, 2.0, -0.7]
angular_velocity = [1.0, 2.0, -0.5]
[[impulse]]
value = [0.7, -0.3, 1.1]
vertex = 5
"""
HUNG = PLANK.partition("[[impulse]]")[0].replace("1.5", "1.0") + (
    "[[tether]]\nvertex = 7\nanchor = [0.0, 2.0, 0.0]\nstiffness = 60.0\ndamping = 0.4\n"
    "[drag]\nlinear = 0.8\nangular = 0.01\n"
)
DROPPED = PLANK.partition("[[impulse]]")[0].replace("1.5", "0.8") + "[floor]\nstiffness = 2e3\ndamping = 15.0\n"
DIE = PLANK.replace("[0.6, 0.3, 0.1]", "[0.5, 0.5, 0.5]")
DRAGGED = PLANK.partition("[[impulse]]")[0] + "[drag]\nlinear = 0.8\nangular = 0.03\n"
OWN = {"dragged": DRAGGED, "plank": PLANK, "hung": HUNG, "dropped": DROPPED, "die": DIE}

FULL, SIX, FOUR = repr, "{:.6g}".format, "{:.4f}".format


def turned(
    scene="plank", *, form=FULL, kind="pose", velocities=False, order="wxyz", conjugate=False, flip=None, **what
):
    """Return a case: a scene, a program and how it writes."""
    written = {"form": form, "kind": kind, "velocities": velocities, "order": order, "conjugate": conjugate}
    return scene, Program(**what), written | {"flip": flip}


def smooth(scene="plank", dt=0.001, every=25, **what):
    """Return a case whose steps are too fine to be seen."""
    return turned(scene, dt=dt, every=every, **what)


def euler(scene="plank", method="symplectic", dt=0.01, every=3, **what):
    """Return a case whose mistake is the step."""
    return turned(scene, method=method, dt=dt, every=every, **what)


def rungs(scene="plank", dt=0.02, **what):
    """Return a case whose mistake is the step of a method of higher order, one a row."""
    return turned(scene, dt=dt, every=1, **what)


SINGLE = {
    # --- impulse
    "force over a time": (
        smooth(lasts=0.3, kind=(0, 3, 5), form=SIX),
        "impulse-as-force",
        (0.299, 0.301),
    ),
    "force at a point that stays": (
        smooth(lasts=0.3, held="world point", form=SIX),
        "impulse-as-force: at a point fixed in the world",
        (0.299, 0.301),
    ),
    "force of constant torque": (
        smooth(lasts=0.3, held="torque", form=SIX),
        "impulse-as-force: with a constant torque",
        (0.299, 0.301),
    ),
    "force without end": (
        smooth(lasts=1.0, forever=True, form=FOUR),
        "impulse-as-permanent-force",
        None,
    ),
    "force over the first step": (
        smooth("two-hits", dt=0.0005, lasts=0.02, every=50, form=FOUR),
        "impulse-as-force-over-one-step",
        (0.0195, 0.0205),
    ),
    "point from the origin": (smooth(arm="origin", form=SIX), "impulse-lever-from-origin", None),
    "at the centre": (smooth("two-hits", arm="none", kind="matrix"), "impulse-at-centre-of-mass", None),
    "lever reversed": (smooth("two-hits", arm="reversed", form=FOUR), "impulse-lever-reversed", None),
    "another vertex": (smooth(vertex=1, kind=(0,), form=SIX), "impulse-at-wrong-vertex: vertex 1", None),
    # --- clock
    "ahead": (smooth(ahead=0.05, form=SIX), "clock-offset", (0.0499, 0.0501)),
    "behind": (
        smooth("brick-tumble", dt=0.002, until=2.0, ahead=-0.1, form=SIX),
        "log-lag: late",
        (0.099, 0.101),
    ),
    "fast clock": (smooth("two-hits", rate=1.05, form=FOUR), "clock-rate", (1.0499, 1.0501)),
    "coarse physics": (
        smooth("two-hits", dt=0.002, tick=10, every=7, form=FOUR),
        "fixed-physics-step",
        (0.0199, 0.0201),
    ),
    # --- forces
    "no gravity": (smooth("brick-tumble", until=1.0, gravity=0.0, form=SIX), "gravity-missing", None),
    "double gravity": (smooth("die-straight", gravity=2.0, kind="matrix"), "gravity-doubled", None),
    "gravity up": (smooth(gravity=-1.0, kind=(7,), form=FOUR), "gravity-reversed", None),
    "gravity along z": (smooth(gravity_axes=(0, 2, 1), velocities=True), "gravity-along-wrong-axis: along -z", None),
    "linear damping": (smooth(dt=0.0005, every=50, linear=0.05, form=FOUR), "linear-damping", (0.049, 0.051)),
    "linear damping, exp": (
        smooth("die-straight", dt=0.0005, every=20, linear=0.1, damped="exp", form=FOUR),
        "linear-damping",
        (0.099, 0.101),
    ),
    "angular damping, implicit": (
        smooth("brick-tumble", until=1.5, angular=0.05, damped="implicit", form=FOUR),
        "angular-damping",
        (0.049, 0.051),
    ),
    "PyBullet's damping": (
        smooth(dt=0.0005, every=50, linear=0.04, angular=0.04, damped="bullet", form=FOUR, kind="matrix"),
        "pybullet-default-damping",
        None,
    ),
    "no tether": (smooth("hung", without="tether", form=SIX), "tether-missing", None),
    "no drag": (smooth("hung", without="drag", form=SIX), "drag-missing", None),
    "no floor": (smooth("dropped", without="floor", form=SIX), "floor-missing", None),
    # --- coefficients and laws of the scene's forces
    "half of the drag": (
        smooth("dragged", linear_drag=0.5, form=SIX),
        "linear-drag-wrong-magnitude: half",
        (0.4999, 0.5001),
    ),
    "drag not divided by the mass": (
        smooth("dragged", linear_drag=1.7, form=SIX),
        "linear-drag-wrong-magnitude: not divided by the mass",
        (1.6999, 1.7001),
    ),
    "drag, all of it": (
        smooth("dragged", linear_drag=0.73, angular_drag=0.73, form=SIX),
        "drag-wrong-magnitude: linear drag and angular drag",
        (0.729, 0.731),
    ),
    "more angular drag": (
        smooth("dragged", angular_drag=1.3, form=SIX),
        "angular-drag-wrong-magnitude: or the inertia divided by that",
        (1.299, 1.301),
    ),
    "no angular drag": (smooth("hung", angular_drag=0.0), "angular-drag-missing", None),
    "quadratic drag": (smooth("dragged", drags="quadratic", form=SIX), "drag-quadratic", None),
    "quadratic angular drag": (smooth("hung", drags="quadratic spin"), "angular-drag-quadratic", None),
    "undivided angular drag": (
        smooth("dragged", drags="undivided", form=SIX),
        "angular-drag-not-divided-by-inertia",
        None,
    ),
    "stiffer tether": (
        smooth("hung", stiffness=1.23, form=SIX),
        "tether-stiffness-wrong-magnitude",
        (1.2299, 1.2301),
    ),
    "tether pushes": (smooth("hung", stiffness=-1.0, form=SIX), "tether-stiffness-reversed", None),
    "no damper": (smooth("hung", damper=0.0, form=SIX), "tether-damping-missing", None),
    "tether without torque": (smooth("hung", hangs="no torque", form=SIX), "tether-torque-missing", None),
    "tether of a body that never turns": (
        smooth("hung", hangs="no turn", form=SIX),
        "tether-point-not-rotated",
        None,
    ),
    "tether's lever never turns": (smooth("hung", hangs="still lever", form=SIX), "tether-lever-not-rotated", None),
    "damper of the centre": (smooth("hung", hangs="centre's velocity", form=SIX), "tether-damps-centre", None),
    "damper along the line": (smooth("hung", hangs="along the line", form=SIX), "tether-damper-direction", None),
    "tether not divided by the mass": (
        smooth("hung", hangs="undivided", form=SIX),
        "tether-not-divided-by-mass",
        None,
    ),
    "anchor at the origin": (smooth("hung", anchor=0.0, form=SIX), "tether-anchor-at-origin", None),
    "tether at another vertex": (
        smooth("hung", hangs="other vertex", form=SIX),
        "tether-at-wrong-vertex: vertex 6",
        None,
    ),
    "put to rest": (
        smooth("dragged", dt=2e-4, every=125, rests=1.5, form=FOUR),
        "spin-threshold: below 1.5 rad/s",
        None,
    ),
    # --- rotation
    "a moment of inertia": (
        smooth("brick-tumble", until=2.0, moments=(1.0, 1.15, 1.0), form=SIX),
        "wrong-moment-of-inertia-y",
        (1.149, 1.151),
    ),
    "moments from the own edges": (smooth(own_edges=True, form=SIX), "inertia-of-own-edges", None),
    "no gyroscopic term": (smooth(gyroscopic="still in world"), "gyroscopic-term-missing", None),
    "no cross product": (
        smooth("dzhanibekov", until=4.0, dt=0.002, gyroscopic="still in body"),
        "gyroscopic-term-missing",
        None,
    ),
    "gyroscopic term reversed": (smooth(gyroscopic="reversed", form=SIX), "gyroscopic-term-reversed", None),
    "Q w~ of a cube": (smooth("die", wrong_side=True), "angular-velocity-in-wrong-frame: w is in world axes", None),
    "Q w~ of a plank": (smooth(wrong_side=True, form=SIX), "angular-velocity-in-wrong-frame: w is in world axes", None),
    "spin in body axes": (smooth(spin_in_body=True, form=SIX), "start-spin-in-body-axes", None),
    "edges as half edges": (smooth(inertia=4.0), "wrong-inertia: edges used as half edges", None),
    "half edges as edges": (
        smooth("two-hits", dt=0.0005, every=50, inertia=0.25, form=FOUR),
        "wrong-inertia: half edges used as edges",
        None,
    ),
    "sphere": (smooth(sphere=True), "spherical-inertia", None),
    "wrong axes": (smooth(inertia_axes=(1, 2, 0)), "inertia-axes-permuted: x y z have those of y z x", None),
    "degrees": (smooth(spin=math.pi / 180, form=SIX), "start-spin-read-as-degrees", None),
    "into degrees": (
        smooth("brick-tumble", until=0.5, dt=0.0001, every=20, spin=180 / math.pi, form=FOUR),
        "start-spin-converted-to-degrees",
        None,
    ),
    # --- what is written
    "xyzw": (smooth(order="xyzw"), "quaternion-xyzw-read-as-wxyz", None),
    "conjugate": (smooth(conjugate=True), "attitude-inverted", None),
    "transposed": (smooth("two-hits", conjugate=True, kind="matrix", form=FOUR), "attitude-inverted", None),
    "left-handed": (
        smooth(flip=[[1, 0, 0], [0, 0, 1], [0, 1, 0]], kind=range(8), form=SIX),
        "left-handed-axes: replaced by x z y",
        None,
    ),
    "z reversed": (
        smooth(flip=np.diag([1, 1, -1]), kind="matrix", form=SIX),
        "left-handed-axes: replaced by x y -z",
        None,
    ),
    # --- steps
    "explicit": (euler(method="explicit"), "explicit-euler", (0.00999, 0.01001)),
    "explicit, body axes": (
        euler(method="explicit", axes="body", form=SIX),
        "explicit-euler: angular velocity stored in body axes",
        (0.0099, 0.0101),
    ),
    "explicit, L": (euler(method="explicit", axes="momentum"), "explicit-euler: momentum stored", (0.00999, 0.01001)),
    "explicit, rotations": (
        euler("brick-tumble", method="explicit", turn="exponential", until=1.0, dt=0.002, every=5),
        "explicit-euler: exact rotations",
        (0.00199, 0.00201),
    ),
    "explicit, by no name": (euler(method="explicit", dt=0.0075, form=SIX), "explicit-euler", (0.00745, 0.00755)),
    "symplectic": (euler(dt=0.02, kind=(2,)), "symplectic-euler", (0.0199, 0.0201)),
    "symplectic, body axes": (
        euler("two-hits", axes="body", turn="exponential", dt=0.005, form=SIX),
        "symplectic-euler",
        (0.0049, 0.0051),
    ),
    "symplectic, L": (euler(axes="momentum", velocities=True), "symplectic-euler: momentum stored", (0.00999, 0.01001)),
    "never normalised": (
        euler(method="explicit", normalised=False),
        "quaternion-never-normalised",
        (0.00999, 0.01001),
    ),
    "never normalised, vertices": (
        euler(method="explicit", axes="body", normalised=False, kind=(0, 3, 7), form=SIX),
        "quaternion-never-normalised",
        (0.0099, 0.0101),
    ),
    "Runge-Kutta, L": (rungs(axes="momentum"), "runge-kutta-4: momentum stored", (0.0199, 0.0201)),
    "stages normalised": (rungs(stages="normalised"), "runge-kutta-4: q normalised in each stage", (0.0199, 0.0201)),
    "stages normalised, L": (
        rungs(stages="normalised", axes="momentum"),
        "runge-kutta-4: momentum stored, q normalised in each stage",
        (0.0199, 0.0201),
    ),
    "stages raw": (rungs("two-hits", stages="raw"), "runge-kutta-4: not normalised", (0.0199, 0.0201)),
    "stages raw, with drag": (rungs("dragged", stages="raw"), "runge-kutta-4: not normalised", (0.0199, 0.0201)),
    "stages raw, L": (
        rungs(stages="raw", axes="momentum"),
        "runge-kutta-4: momentum stored, R from the q of each stage",
        (0.0199, 0.0201),
    ),
    "stages raw, R I^-1 R^T": (
        rungs(stages="raw with R I^-1 R^T"),
        "runge-kutta-4: axes, R I^-1 R^T from the q of each stage",
        (0.0199, 0.0201),
    ),
    "stages raw, R I^-1 R^T, L": (
        rungs(stages="raw with R I^-1 R^T", axes="momentum"),
        "runge-kutta-4: momentum stored, R I^-1 R^T from the q of each stage",
        (0.0199, 0.0201),
    ),
    "leapfrog, L": (
        rungs("dragged", method="leapfrog", axes="momentum", turn="exponential"),
        "velocity-verlet: momentum stored, attitude rotated by the w of mid-step",
        (0.0199, 0.0201),
    ),
    "leapfrog, L, to first order": (
        rungs("two-hits", method="leapfrog", axes="momentum", form=SIX),
        "velocity-verlet: momentum stored, attitude rotated by the w of mid-step, quaternion updated to first order",
        (0.0199, 0.0201),
    ),
    "sheared matrix": (
        euler(method="explicit", axes="momentum", turn="matrix", kind="matrix", until=0.5, every=1),
        "matrix-euler",
        (0.0099, 0.0101),
    ),
}

PAIRS = {
    "symplectic without gravity": (
        euler(axes="body", gravity=0.0),
        {"gravity-missing": 0.0, "symplectic-euler": 0.01},
    ),
    "explicit with damping": (
        euler(method="explicit", axes="body", angular=0.3),
        {"angular-damping": 0.3, "explicit-euler": 0.01},
    ),
    "force and tick": (
        smooth("two-hits", dt=0.002, lasts=0.3, tick=10, every=7, form=FOUR),
        {"impulse-as-force": 0.3, "fixed-physics-step": 0.02},
    ),
    "half of the gravity upon raw stages": (
        rungs("two-hits", stages="raw", gravity=0.5),
        {"gravity-wrong-magnitude": 0.5, "runge-kutta-4": 0.02},
    ),
    "spin in body axes upon a leapfrog": (
        rungs(method="leapfrog", axes="momentum", turn="exponential", spin_in_body=True),
        {"start-spin-in-body-axes": 0.0, "velocity-verlet": 0.02},
    ),
    "xyzw without gyroscopic term": (
        smooth(gyroscopic="still in world", order="xyzw"),
        {"quaternion-xyzw-read-as-wxyz": 0.0, "gyroscopic-term-missing": 0.0},
    ),
}


@pytest.fixture
def graded(tmp_path):
    """Return a function that simulates and writes a case, and returns its grade."""

    def run(case):
        scene, program, written = case
        path = CATALOGUE / f"{scene}.toml"
        if scene in OWN:
            path = tmp_path / f"{scene}.toml"
            path.write_text(OWN[scene])
        file = write(tmp_path / "program.csv", fly(path, program), read(path).vertices, **written)
        return grade(Path(file), read_scene(str(path)), {}, search_s=30.0)

    return run


@pytest.mark.parametrize("case_name", SINGLE)
def test_a_mistake_is_named(graded, case_name):
    case, expected, bounds = SINGLE[case_name]
    name, _, words = expected.partition(": ")
    found = graded(case)
    assert found.verdict == EXPLAINED_WHOLLY
    (mistake,) = found.diagnosis.best.mistakes
    assert mistake.hypothesis.name == name
    assert words in mistake.text
    if bounds:
        assert bounds[0] < mistake.value < bounds[1], mistake.text


@pytest.mark.parametrize("case_name", PAIRS)
def test_two_mistakes_are_named(graded, case_name):
    case, expected = PAIRS[case_name]
    found = {mistake.hypothesis.name: mistake.value for mistake in graded(case).diagnosis.best.mistakes}
    assert found == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("form", [FULL, SIX, FOUR])
def test_a_right_program_is_called_right(graded, form):
    found = graded(smooth("plank", dt=0.0005, every=50, form=form, velocities=True))
    assert found.verdict.startswith("correct") or found.verdict == TOO_LITTLE


def test_single_precision_is_named(graded):
    found = graded(smooth("table-4-1", every=5, number=np.float32))
    assert found.measured.single


def test_an_angular_velocity_in_degrees_is_reported(tmp_path, capsys):
    scene, program, _ = smooth()
    path = tmp_path / "plank.toml"
    path.write_text(OWN[scene])
    rows = [(*row[:-1], np.degrees(row[-1])) for row in fly(path, program)]
    file = write(tmp_path / "degrees.csv", rows, read(path).vertices, velocities=True)
    assert main(["grade", file, "--scene", str(path)]) == 0
    assert "the angular velocity in the file is in degrees" in " ".join(capsys.readouterr().out.split())
