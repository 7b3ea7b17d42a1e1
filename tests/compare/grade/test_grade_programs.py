"""`tumble grade` on files of a program that it did not write: support/programs.py, sharing nothing with its models.

Each case plants one mistake, or two, and says in which words it must be named first, within which bounds its number
must lie, and that nothing else is named beside it.  What else a program does is accurate enough not to be seen.
"""

import math
import re
from pathlib import Path

import numpy as np
import pytest
from programs import Program, fly, read, write

from tumble.__main__ import main

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
OWN = {"plank": PLANK, "hung": HUNG, "dropped": DROPPED, "die": DIE}

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


SINGLE = {
    # --- impulse
    "force over a time": (
        smooth(lasts=0.3, kind=(0, 3, 5), form=SIX),
        "impulse used as a constant force over",
        (0.299, 0.301),
    ),
    "force at a point that stays": (
        smooth(lasts=0.3, held="world point", form=SIX),
        "constant force over [^:]* at a point that stays in the world",
        (0.299, 0.301),
    ),
    "force of constant torque": (
        smooth(lasts=0.3, held="torque", form=SIX),
        "constant force over [^:]* with a constant torque",
        (0.299, 0.301),
    ),
    "force without end": (
        smooth(lasts=1.0, forever=True, form=FOUR),
        "constant force of as many N .* without end",
        None,
    ),
    "force over the first step": (
        smooth("two-hits", dt=0.0005, lasts=0.02, every=50, form=FOUR),
        "force over a first step of .* lags by half",
        (0.0195, 0.0205),
    ),
    "point from the origin": (smooth(arm="origin", form=SIX), "not taken from the centre of mass", None),
    "at the centre": (smooth("two-hits", arm="none", kind="matrix"), "applied at the centre of mass", None),
    "lever reversed": (smooth("two-hits", arm="reversed", form=FOUR), "wrong sign, F x r", None),
    "another vertex": (smooth(vertex=1, kind=(0,), form=SIX), "impulse applied at vertex 1", None),
    # --- clock
    "ahead": (smooth(ahead=0.05, form=SIX), "ahead of the clock", (0.0499, 0.0501)),
    "behind": (
        smooth("brick-tumble", dt=0.002, until=2.0, ahead=-0.1, form=SIX),
        "rows written .* late",
        (0.099, 0.101),
    ),
    "fast clock": (smooth("two-hits", rate=1.05, form=FOUR), "times as fast as the clock", (1.0499, 1.0501)),
    "coarse physics": (
        smooth("two-hits", dt=0.002, tick=10, every=7, form=FOUR),
        "physics moves in whole steps",
        (0.0199, 0.0201),
    ),
    # --- forces
    "no gravity": (smooth("brick-tumble", until=1.0, gravity=0.0, form=SIX), "gravity missing", None),
    "double gravity": (smooth("die-straight", gravity=2.0, kind="matrix"), "gravity applied twice", None),
    "gravity up": (smooth(gravity=-1.0, kind=(7,), form=FOUR), "gravity of the wrong sign", None),
    "gravity along z": (smooth(gravity_axes=(0, 2, 1), velocities=True), "gravity along -z", None),
    "linear damping": (smooth(dt=0.0005, every=50, linear=0.05, form=FOUR), "linear damping", (0.049, 0.051)),
    "linear damping, exp": (
        smooth("die-straight", dt=0.0005, every=20, linear=0.1, damped="exp", form=FOUR),
        "linear damping",
        (0.099, 0.101),
    ),
    "angular damping, implicit": (
        smooth("brick-tumble", until=1.5, angular=0.05, damped="implicit", form=FOUR),
        "angular damping",
        (0.049, 0.051),
    ),
    "PyBullet's damping": (
        smooth(dt=0.0005, every=50, linear=0.04, angular=0.04, damped="bullet", form=FOUR, kind="matrix"),
        "PyBullet's default damping",
        None,
    ),
    "no tether": (smooth("hung", without="tether", form=SIX), "tether missing", None),
    "no drag": (smooth("hung", without="drag", form=SIX), "drag missing", None),
    "no floor": (smooth("dropped", without="floor", form=SIX), "floor missing", None),
    # --- rotation
    "no gyroscopic term": (smooth(gyroscopic="still in world"), "gyroscopic term missing", None),
    "no cross product": (
        smooth("dzhanibekov", until=4.0, dt=0.002, gyroscopic="still in body"),
        "gyroscopic term missing",
        None,
    ),
    "gyroscopic term reversed": (smooth(gyroscopic="reversed", form=SIX), "gyroscopic term of the wrong sign", None),
    "Q w~ of a cube": (smooth("die", wrong_side=True), "Q w~ where w is in world axes", None),
    "Q w~ of a plank": (smooth(wrong_side=True, form=SIX), "Q w~ where w is in world axes", None),
    "spin in body axes": (smooth(spin_in_body=True, form=SIX), "start taken in body axes", None),
    "edges as half edges": (smooth(inertia=4.0), "edges taken for half edges", None),
    "half edges as edges": (
        smooth("two-hits", dt=0.0005, every=50, inertia=0.25, form=FOUR),
        "half edges taken for edges",
        None,
    ),
    "sphere": (smooth(sphere=True), "inertia of a sphere", None),
    "wrong axes": (smooth(inertia_axes=(1, 2, 0)), "wrong axes: x y z have those of y z x", None),
    "degrees": (smooth(spin=math.pi / 180, form=SIX), "taken for degrees", None),
    "into degrees": (
        smooth("brick-tumble", until=0.5, dt=0.0001, every=20, spin=180 / math.pi, form=FOUR),
        "57 times too fast",
        None,
    ),
    # --- what is written
    "xyzw": (smooth(order="xyzw"), "quaternion written x y z w", None),
    "conjugate": (smooth(conjugate=True), "conjugate", None),
    "transposed": (smooth("two-hits", conjugate=True, kind="matrix", form=FOUR), "transposed", None),
    "left-handed": (
        smooth(flip=[[1, 0, 0], [0, 0, 1], [0, 1, 0]], kind=range(8), form=SIX),
        "left-handed axes: for x y z stand x z y",
        None,
    ),
    "z reversed": (
        smooth(flip=np.diag([1, 1, -1]), kind="matrix", form=SIX),
        "left-handed axes: for x y z stand x y -z",
        None,
    ),
    # --- steps
    "explicit": (euler(method="explicit"), "explicit Euler with a step", (0.00999, 0.01001)),
    "explicit, body axes": (
        euler(method="explicit", axes="body", form=SIX),
        "explicit Euler .* w in body axes",
        (0.0099, 0.0101),
    ),
    "explicit, L": (euler(method="explicit", axes="momentum"), "explicit .* momentum kept", (0.00999, 0.01001)),
    "explicit, rotations": (
        euler("brick-tumble", method="explicit", turn="exponential", until=1.0, dt=0.002, every=5),
        "explicit Euler .* turned by rotations",
        (0.00199, 0.00201),
    ),
    "explicit, by no name": (euler(method="explicit", dt=0.0075, form=SIX), "explicit Euler", (0.00745, 0.00755)),
    "symplectic": (euler(dt=0.02, kind=(2,)), "symplectic Euler with a step", (0.0199, 0.0201)),
    "symplectic, body axes": (
        euler("two-hits", axes="body", turn="exponential", dt=0.005, form=SIX),
        "symplectic Euler with a step",
        (0.0049, 0.0051),
    ),
    "symplectic, L": (euler(axes="momentum", velocities=True), "symplectic .* momentum kept", (0.00999, 0.01001)),
    "never normalised": (
        euler(method="explicit", normalised=False),
        "explicit Euler .* never normalised",
        (0.00999, 0.01001),
    ),
    "never normalised, vertices": (
        euler(method="explicit", axes="body", normalised=False, kind=(0, 3, 7), form=SIX),
        "explicit Euler .* never normalised",
        (0.0099, 0.0101),
    ),
    "sheared matrix": (
        euler(method="explicit", axes="momentum", turn="matrix", kind="matrix", until=0.5, every=1),
        "explicit Euler on the rotation matrix .* not rigid",
        (0.0099, 0.0101),
    ),
}

PAIRS = {
    "symplectic without gravity": (
        euler(axes="body", gravity=0.0),
        ("gravity missing", "symplectic Euler with a step of 0.01 s"),
    ),
    "explicit with damping": (
        euler(method="explicit", axes="body", angular=0.3),
        ("angular damping", "explicit Euler with a step of 0.01 s"),
    ),
    "force and tick": (
        smooth("two-hits", dt=0.002, lasts=0.3, tick=10, every=7, form=FOUR),
        ("impulse used as a constant force over 0.3 s", "whole steps of 0.02 s"),
    ),
    "xyzw without gyroscopic term": (
        smooth(gyroscopic="still in world", order="xyzw"),
        ("quaternion written x y z w", "gyroscopic term missing"),
    ),
}


@pytest.fixture
def graded(capsys, tmp_path):
    """Return a function that flies and writes a case, and gives what grade prints, in one line."""

    def run(case):
        scene, program, written = case
        path = CATALOGUE / f"{scene}.toml"
        if scene in OWN:
            path = tmp_path / f"{scene}.toml"
            path.write_text(OWN[scene])
        file = write(tmp_path / "program.csv", fly(path, program), read(path).vertices, **written)
        code = main(["grade", file, "--scene", str(path)])
        out, err = capsys.readouterr()
        assert code == 0, err
        return " ".join(out.split())

    return run


def named(out):
    """Return what is named, in order."""
    return re.findall(r"(?<= )\d\. (.*?): \S+ [pnfµmk]?m -> \S+ [pnfµmk]?m", out.partition(" at the end ")[2])


def number_in(said):
    """Return the number that was fitted."""
    return float(re.findall(r"-?\d+\.\d+(?:e-\d+)?", said)[0])


@pytest.mark.parametrize("name", SINGLE)
def test_a_mistake_is_named(graded, name):
    case, words, bounds = SINGLE[name]
    out = graded(case)
    said = named(out)
    assert said, out
    assert re.search(words, said[0]), out
    if bounds:
        assert bounds[0] < number_in(said[0]) < bounds[1], out
    assert len(said) == 1, f"an idle addition: {out}"
    assert "What comes nearest" not in out
    assert "Not explained" not in out


@pytest.mark.parametrize("name", PAIRS)
def test_two_mistakes_are_named(graded, name):
    case, both = PAIRS[name]
    out = graded(case)
    said = named(out)
    assert len(said) == 2, out
    assert all(any(words in one for one in said) for words in both), out


@pytest.mark.parametrize("form", [FULL, SIX, FOUR])
def test_a_right_program_is_called_right(graded, form):
    out = graded(smooth("plank", dt=0.0005, every=50, form=form, velocities=True))
    assert not named(out)
    assert "Correct" in out or "too little to tell" in out


def test_single_precision_is_named(graded):
    out = graded(smooth("table-4-1", every=5, number=np.float32))
    assert "single precision" in out


def test_a_spin_in_degrees_is_seen_beside(graded, tmp_path, capsys):
    scene, program, _ = smooth()
    path = tmp_path / "plank.toml"
    path.write_text(OWN[scene])
    rows = [(*row[:-1], np.degrees(row[-1])) for row in fly(path, program)]
    file = write(tmp_path / "degrees.csv", rows, read(path).vertices, velocities=True)
    assert main(["grade", file, "--scene", str(path)]) == 0
    assert "the angular velocity that is written down is in degrees" in " ".join(capsys.readouterr().out.split())
