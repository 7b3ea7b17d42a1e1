"""What a scene needs, by its numbers: what it has not got is nothing to its motion, and what it has is not missed."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from tumble.scenarios.frames import rotation_matrix
from tumble.scenarios.needs import FORCES, needs
from tumble.scenarios.read import read_scene
from tumble.scenarios.scene import Scene, frozen_array
from tumble.scenarios.truth import truth

HEAD = 'title = "t"\nduration = 1.0\nsamples = 4\nstep = 0.01\n'
CUBE = '[body]\nshape = "box"\nsize = [2.0, 2.0, 2.0]\nmass = 2.0\n'
BRICK = '[body]\nshape = "box"\nsize = [1.0, 2.0, 3.0]\nmass = 2.0\n'
# Two moments alike, about x and y.
TOP = '[body]\nshape = "box"\nsize = [1.0, 1.0, 3.0]\nmass = 2.0\n'
# Its only point is its centre of mass.
SPECK = '[body]\nshape = "rigid"\nmass = 2.0\ninertia = [[3, 0, 0], [0, 4, 0], [0, 0, 5]]\npoints = [[0, 0, 0]]\n'
GRAVITY = "gravity = [0, -9.81, 0]\n"
DOWN = "[[impulse]]\ntime = 0.5\nmagnitude = 2\nray = { origin = [0, 9, 0], direction = [0, -1, 0] }\n"
examples = settings(max_examples=60, derandomize=True, deadline=None)


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("scenes")


@pytest.fixture(scope="module")
def read(folder):
    def made(body: str, before: str = "") -> Scene:
        path = folder / "scene.toml"
        path.write_text(HEAD + before + body)
        return read_scene(str(path))

    return made


# --- rotation, and the gyroscopic term


@pytest.mark.parametrize(
    ("body", "w", "has"),
    [
        (CUBE, (1, 2, 3), ("rotation",)),
        (TOP, (1, 2, 0), ("rotation",)),
        (TOP, (0, 0, 3), ("rotation",)),
        (TOP, (1, 0, 3), ("rotation", "gyroscopic")),
        (BRICK, (0, 3, 0), ("rotation",)),
        (BRICK, (0, 3, 1e-300), ("rotation", "gyroscopic")),
        (BRICK, (1e-200, 1e-200, 0), ("rotation", "gyroscopic")),
        (BRICK, (1e300, 1e300, 0), ("rotation", "gyroscopic")),
        (BRICK, (0, 0, 0), ()),
    ],
)
def test_moments_and_spin_decide_about_the_gyroscopic_term(read, body, w, has):
    assert needs(read(f"{body}angular_velocity = {list(map(float, w))}\n")) == has


@pytest.mark.parametrize(
    ("orientation", "w", "along"),
    [
        ((1, 1, 0, 0), (0, 0, 5), True),  # a quarter turn, whose quaternion is irrational
        ((1, 1, 1, 1), (0, 0, 5), True),
        ((0.8, 0, 0, 0.6), (0, 0, 5), True),
        ((0.8, 0, 0, 0.6), (5, 0, 0), False),
        ((0.8, 0.1, 0.2, 0.3), (0, 0, 5), False),
    ],
)
def test_a_spin_is_along_an_axis_of_the_body_and_not_of_the_world(read, orientation, w, along):
    turned = read(f"{BRICK}orientation = {list(map(float, orientation))}\nangular_velocity = {list(map(float, w))}\n")
    assert ("gyroscopic" in needs(turned)) != along


@pytest.mark.parametrize(
    ("forces", "may_leave"),
    [
        ("[drag]\nlinear = 0.3\nangular = 0.2\n", False),
        ("[[tether]]\nvertex = 0\nanchor = [0, 9, 0]\nstiffness = 5\n", True),
        ("[floor]\nstiffness = 1e4\n", True),
        ("[[impulse]]\ntime = 0.5\nvalue = [1, 0, 0]\nvertex = 0\n", True),
        ("[[impulse]]\ntime = 0.5\nvalue = [1, 2, 3]\npoint_body = [0, 0, 0]\n", False),
    ],
)
def test_a_torque_may_take_a_spin_off_its_axis(read, forces, may_leave):
    assert ("gyroscopic" in needs(read(f"{BRICK}angular_velocity = [0.0, 3.0, 0.0]\n{forces}"))) == may_leave


def test_a_blow_at_the_start_can_take_a_spin_off_its_axis_and_put_it_back(read):
    # J = 3 at (0.5, 0, 0) along y turns about z; the moments about z and about y are 5/6 and 5/3.
    blow = "[[impulse]]\nvalue = [0, {}, 0]\npoint_body = [0.5, 0, 0]\n"
    spinning = BRICK + "angular_velocity = [0.0, 3.0, 0.0]\n"
    assert "gyroscopic" in needs(read(spinning + blow.format(3)))
    assert needs(read(spinning + blow.format(3) + blow.format(-3))) == ("rotation",)
    assert needs(read(BRICK + blow.format(3))) == ("rotation",)
    assert needs(read(BRICK + blow.format(3) + blow.format(-3))) == ()


@pytest.mark.parametrize(
    ("impulse", "turns"),
    [
        ("time = 0.5\nvalue = [1, 2, 3]\npoint = [0, 0, 0]", False),  # at rest, it is still there
        ("value = [0, -4, 0]\npoint = [0, 1, 0]\n[[impulse]]\ntime = 0.5\nvalue = [0, 1, 0]\npoint = [0, 7, 0]", False),
        ("value = [4, 0, 0]\npoint = [0, 0, 0]\n[[impulse]]\ntime = 0.5\nvalue = [0, 1, 0]\npoint = [0, 7, 0]", True),
        ("value = [1, 2, 3]\nvertex = 0", True),
    ],
)
def test_where_a_blow_lands_decides_whether_a_body_at_rest_turns(read, impulse, turns):
    assert ("rotation" in needs(read(f"{CUBE}[[impulse]]\n{impulse}\n"))) == turns


@pytest.mark.parametrize(
    ("body", "turns"),
    [
        (CUBE, False),  # falls away below the ray, which meets its middle
        (CUBE + "velocity = [1.0, 0.0, 0.0]\n", True),  # half a metre beside it by then
        (CUBE + "velocity = [9.0, 0.0, 0.0]\n", True),  # out of its way: only the flight can tell what comes of that
        (CUBE + "[drag]\nlinear = 0.5\n", True),  # where that leaves it, only the flight can tell
    ],
)
def test_a_later_ray_meets_a_falling_body_where_it_is_by_then(read, body, turns):
    assert ("rotation" in needs(read(body + DOWN, GRAVITY))) == turns


def test_the_second_of_two_later_blows_meets_a_body_that_may_have_turned(read):
    blow = "[[impulse]]\ntime = {}\nvalue = [0, 1, 0]\npoint_body = {}\n"
    straight, aside = "[0, 0.3, 0]", "[0.3, 0, 0]"
    assert needs(read(BRICK + blow.format(0.2, straight) + blow.format(0.4, aside))) == ("rotation", "later impulses")
    assert "gyroscopic" in needs(read(BRICK + blow.format(0.2, aside) + blow.format(0.4, straight)))


# --- forces


@pytest.mark.parametrize(
    ("body", "before", "has"),
    [
        (CUBE, "gravity = [0, -0.0, 0]\n", ()),
        (CUBE, GRAVITY, ("gravity",)),
        (CUBE + "[[tether]]\nvertex = 0\nanchor = [0, 9, 0]\nstiffness = 0\ndamping = 0\nrest_length = 3\n", "", ()),
        (CUBE + "[[tether]]\nvertex = 0\nanchor = [0, 9, 0]\nstiffness = 0\ndamping = 1\n", "", ("tether", "rotation")),
        (CUBE + "[drag]\n", "", ()),
        (CUBE + "[drag]\nlinear = 1\n", "", ("drag",)),
        (CUBE + "[drag]\nangular = 1\n", "", ("drag",)),  # of a body that never spins
        (CUBE + "angular_velocity = [1.0, 2.0, 0.0]\n[drag]\nangular = 1\n", "", ("drag", "rotation")),
        (CUBE + "[floor]\nstiffness = 0\n", "", ()),
        (CUBE + "[floor]\nstiffness = 1\n", "", ("floor", "rotation")),
        (CUBE + "[[impulse]]\ntime = 0.5\nvalue = [0, 0, 0]\nvertex = 0\n", "", ()),
        (SPECK + "[[tether]]\nvertex = 0\nanchor = [0, 9, 0]\nstiffness = 4\n", "", ("tether",)),
    ],
)
def test_a_force_without_strength_is_none_and_one_without_a_lever_turns_nobody(read, body, before, has):
    assert needs(read(body, before)) == has


def test_two_tethers_are_there_if_one_of_them_pulls(read):
    tether = "[[tether]]\nvertex = {}\nanchor = [0, 9, 0]\nstiffness = {}\n"
    both = read(BRICK + tether.format(0, 0) + tether.format(7, 5))
    assert len(both.tethers) == 1
    assert needs(both) == ("tether", "rotation", "gyroscopic")
    assert needs(read(BRICK + tether.format(0, 0) + tether.format(7, 0))) == ()


def test_the_names_of_forces_come_first_and_in_order(read):
    every = "[[tether]]\nvertex = 0\nanchor = [0, 9, 0]\nstiffness = 5\n[drag]\nlinear = 1\n[floor]\nstiffness = 1e4\n"
    every += "[plane]\npoint = [0, -9, 0]\nrestitution = 0\nfriction = 0\n"
    assert needs(read(BRICK + every, GRAVITY))[: len(FORCES)] == FORCES


# --- many throws


def test_one_throw_of_many_that_turns_is_enough(read):
    still = read(BRICK)
    starts = np.repeat(still.start, 5, axis=0)
    assert needs(replace(still, start=frozen_array(starts))) == ("throws",)
    starts[3, 10:13] = 0, 0, 2
    assert needs(replace(still, start=frozen_array(starts))) == ("rotation", "throws")
    starts[4, 10:13] = 0, 1, 2
    assert needs(replace(still, start=frozen_array(starts))) == ("rotation", "gyroscopic", "throws")


def test_throws_that_are_spread_need_what_any_of_them_does(read):
    blow = "[[impulse]]\nvalue = [0, 3, 0]\npoint_body = [0.5, 0, 0]\n[ensemble]\nthrows = 4\n"
    assert needs(read(BRICK + blow)) == ("rotation", "throws")
    assert needs(read(BRICK + blow + "magnitude = 0.5\n")) == ("rotation", "throws")
    assert needs(read(BRICK + blow + "cone = 0.5\n")) == ("rotation", "gyroscopic", "throws")
    assert needs(read(BRICK + blow.replace("4", "1") + "cone = 0.5\n")) == ("rotation",)


# --- bodies


@pytest.mark.parametrize("kind", ["stl", "ply", "off"])
@pytest.mark.parametrize("name", ["box", "icosahedron", "icosphere"])
def test_a_cube_or_a_ball_from_a_mesh_has_no_gyroscopic_term(read, folder, name, kind):
    shape = getattr(trimesh.creation, name)()
    shape.export(folder / f"shape.{kind}")
    assert needs(
        read(f'[body]\nshape = "mesh"\nfile = "shape.{kind}"\nmass = 1.0\nangular_velocity = [1.0, 2.0, 3.0]\n')
    ) == ("rotation",)


# --- against the truth


components = st.sampled_from([0.0, 0.0, 1.0, -2.0, 0.3])
vectors = st.tuples(components, components, components).map(list)
quaternions = st.tuples(*[st.sampled_from([0.0, 1.0, 1.0, -1.0, 0.6])] * 4).filter(any).map(list)
blows = st.builds(
    "[[impulse]]\ntime = {}\nvalue = {}\npoint_body = {}\n".format, st.sampled_from([0.0, 0.0, 0.5]), vectors, vectors
)


@examples
@given(st.sampled_from([CUBE, TOP, BRICK]), quaternions, vectors, vectors, st.lists(blows, max_size=2))
def test_what_is_not_needed_the_true_motion_has_not_got(read, body, orientation, velocity, w, blows):
    scene = read(f"{body}orientation = {orientation}\nvelocity = {velocity}\nangular_velocity = {w}\n{''.join(blows)}")
    true, has = truth(scene), needs(scene)
    states = true.states[:, 0]
    axes = rotation_matrix(states[:, 3:7])
    # A dozen roundings of numbers below 100.
    slack = 1e-13
    if "rotation" not in has:
        assert np.abs(axes - axes[0]).max() == 0, "it turns"
    if "gyroscopic" not in has:
        w_body = np.einsum("rji,rj->ri", axes, states[:, 10:13])
        later = [impulse.time for impulse in scene.impulses if impulse.time > 0]
        for first in (0.0, *later):
            stretch = w_body[(true.times >= first) & (true.times < min([t for t in later if t > first], default=2.0))]
            assert np.abs(stretch - stretch[0]).max() <= slack * max(1.0, np.abs(stretch).max()), "it precesses"


@examples
@given(quaternions, vectors, vectors)
def test_what_is_needed_the_true_motion_shows(read, orientation, velocity, w):
    scene = read(f"{BRICK}orientation = {orientation}\nvelocity = {velocity}\nangular_velocity = {w}\n")
    states, has = truth(scene).states[:, 0], needs(scene)
    assert ("rotation" in has) == any(w)
    if "gyroscopic" in has:
        # The least of these spins, 0.3 rad/s, is at least 0.01 rad/s off its axis, or by rounding alone.
        turned = np.linalg.norm(np.diff(states[:, 10:13], axis=0), axis=1).max()
        off_axis = np.sort(np.abs(rotation_matrix(states[0, 3:7]).T @ states[0, 10:13]))[1]
        assert turned > 0 or off_axis < 1e-15


# --- the list


def test_scenes_are_listed_with_what_they_need(tumble):
    said = tumble("scenes")
    assert said.returncode == 0
    assert said.stderr == ""
    lines = said.stdout.splitlines()
    assert "die-straight" in said.stdout
    needed = next(line for line in lines if line.startswith("two-hits "))
    assert needed.split(maxsplit=1)[1] == "gravity, rotation, gyroscopic, later impulses"
    assert "Brick, two impulses" in lines[lines.index(needed) + 1]


def test_the_list_of_scenes_fits_a_terminal():
    code = (
        "import pty, sys; sys.argv = ['tumble', 'scenes'];"
        f"pty.spawn([{sys.executable!r}, '-P', '-m', 'tumble', 'scenes'])"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env={"COLUMNS": "60"})
    lines = said.stdout.splitlines()
    assert max(map(len, lines)) <= 60
    assert any(line.startswith("two-hits ") for line in lines)
