"""The truth under forces, against exact solutions and against heyoka's Taylor integrator on quaternions."""

import math
from dataclasses import replace

import heyoka as hy
import numpy as np
import pytest

from tumble.scenarios.frames import quaternion_product, rotation_matrix, vertices
from tumble.scenarios.impulse import jump
from tumble.scenarios.read import read_scene
from tumble.scenarios.truth import truth

EPS = np.finfo(float).eps

BODY = """
title = "planted"
duration = {duration}
samples = {samples}
step = 0.001
{more}
[body]
shape = "box"
size = [0.4, 0.15, 0.1]
mass = 2.4
position = [0.3, -1.2, 0.7]
orientation = [0.8, 0.2, -0.4, 0.4]
velocity = [0.5, 3.0, -1.0]
angular_velocity = [0.9, -1.1, 1.4]
{forces}
"""
GRAVITY = "gravity = [0.0, -9.81, 0.0]"
FORCES = {
    "tether": "[[tether]]\nvertex = 7\nanchor = [0.0, 0.5, 0.0]\nstiffness = 80.0\ndamping = 0.6",
    "line": "[[tether]]\nvertex = 2\nanchor = [0.0, 1.0, 0.5]\nstiffness = 60.0\ndamping = 0.4\nrest_length = 0.7",
    "drag": "[drag]\nlinear = 0.3\nangular = 0.02",
    "stiff": "[[tether]]\nvertex = 7\nanchor = [0.3, -1.2, 0.9]\nstiffness = 1e5\ndamping = 0.5",
}
IMPULSE = "\n[[impulse]]\ntime = 0.35\nvalue = [-3.1, 0.9, 2.2]\nvertex = 0"


@pytest.fixture
def scene_of(tmp_path):
    def written(text):
        (tmp_path / "planted.toml").write_text(text, encoding="utf-8")
        return read_scene(str(tmp_path / "planted.toml"))

    return written


def off(scene, states):
    """The largest distance of a vertex from the truth [m], and the truth's limit, of one throw told in doubles.

    The limit, and not the bound, since what is held against it starts from a rounded angular velocity.
    """
    true = truth(replace(scene, written=None))
    points = vertices(np.asarray(states, dtype=float), scene.body.points)
    return np.linalg.norm(points - true.vertices[:, 0], axis=-1).max(), true.resolution.max()


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def turned(q, a):
    """q a q* / |q|^2, of heyoka's expressions."""
    w, axis = q[0], q[1:]
    twice = [2.0 * c for c in cross(axis, a)]
    second = cross(axis, twice)
    return [a[i] + w * twice[i] + second[i] for i in range(3)]


def heyoka_states(scene):
    """States of the first throw at the scene's rows, in 80-bit numbers, rounded at the end."""
    state = hy.make_vars(*(f"y{number}" for number in range(13)))
    x, q, v, w = state[0:3], state[3:7], state[7:10], state[10:13]
    body, mass = scene.body, scene.body.mass
    moments = body.moments.tolist()
    gravity = np.zeros(3) if scene.gravity is None else scene.gravity
    force = [hy.expression(mass * g) for g in gravity.tolist()]
    torque = [hy.expression(0.0)] * 3
    inverse = [q[0], *(-c for c in q[1:])]
    for tether in scene.tethers:
        point = tether.point_body.tolist()
        line = [a + b - c for a, b, c in zip(x, turned(q, point), tether.anchor.tolist(), strict=True)]
        rate = [a + b for a, b in zip(v, turned(q, cross(w, point)), strict=True)]
        if tether.rest_length:
            length = hy.sqrt(sum(c * c for c in line))
            pull = tether.stiffness * (length - tether.rest_length)
            pull += tether.damping * sum(a * b for a, b in zip(line, rate, strict=True)) / length
            own = [-pull * c / length for c in line]
        else:
            own = [-tether.stiffness * a - tether.damping * b for a, b in zip(line, rate, strict=True)]
        force = [a + b for a, b in zip(force, own, strict=True)]
        torque = [a + b for a, b in zip(torque, cross(point, turned(inverse, own)), strict=True)]
    if scene.drag:
        force = [a - scene.drag.linear * b for a, b in zip(force, v, strict=True)]
        torque = [a - scene.drag.angular * b for a, b in zip(torque, w, strict=True)]
    gyroscopic = cross([m * c for m, c in zip(moments, w, strict=True)], w)
    half = [0.5 * c for c in w]
    slopes = [
        *v,
        -(q[1] * half[0] + q[2] * half[1] + q[3] * half[2]),
        q[0] * half[0] + q[2] * half[2] - q[3] * half[1],
        q[0] * half[1] + q[3] * half[0] - q[1] * half[2],
        q[0] * half[2] + q[1] * half[1] - q[2] * half[0],
        *(f / mass for f in force),
        *((t + g) / m for t, g, m in zip(torque, gyroscopic, moments, strict=True)),
    ]
    long = np.longdouble
    taylor = hy.taylor_adaptive(list(zip(state, slopes, strict=True)), np.zeros(13, dtype=long), fp_type=long)

    def write(row):
        row = row.astype(long)
        axes = rotation_matrix(row[3:7] / np.sqrt(row[3:7] @ row[3:7]))
        taylor.state[:] = np.concatenate(
            (row[0:3], row[3:7] / np.sqrt(row[3:7] @ row[3:7]), row[7:10], axes.T @ row[10:13])
        )

    def read():
        row = taylor.state.copy()
        return np.concatenate((row[0:10], rotation_matrix(row[3:7]) @ row[10:13]))

    write(scene.start[0])
    rows = []
    stops = sorted({*scene.rows.tolist(), *(impulse.time for impulse in scene.impulses)})
    for stop in stops:
        taylor.propagate_until(long(stop))
        for impulse in scene.impulses:
            if impulse.time == stop:
                # The jump is in doubles: half an ulp of the velocities, which the test allows for.
                write(jump(impulse, read().astype(float)[np.newaxis], scene.body)[0])
        if stop in scene.rows:
            rows.append(read())
    return np.array(rows)


@pytest.mark.parametrize("names", [("tether",), ("line",), ("drag",), ("stiff",), ("tether", "line", "drag")])
def test_a_second_integrator_in_longer_numbers(scene_of, names):
    duration = 0.3 if names == ("stiff",) else 1.0
    forces = "\n".join(FORCES[name] for name in names)
    scene = scene_of(BODY.format(duration=duration, samples=8, more=GRAVITY, forces=forces))
    error, bound = off(scene, heyoka_states(scene))
    # The vertices are rounded here as well: some roundings of coordinates of about 1 m.
    assert error < bound + 8 * EPS
    assert bound < 1e-12


def test_a_blow_between_samples(scene_of):
    scene = scene_of(BODY.format(duration=1.0, samples=7, more=GRAVITY, forces=FORCES["tether"] + IMPULSE))
    error, bound = off(scene, heyoka_states(scene))
    # Velocities of about 20 m/s at the corners, rounded once by the jump here, for 0.65 s.
    assert error < bound + 100 * EPS
    unstruck = replace(scene, impulses=())
    assert off(unstruck, heyoka_states(scene))[0] > 0.1, "the blow is felt"


def test_drag_under_gravity_is_elementary(scene_of):
    drag = "[drag]\nlinear = 0.7\nangular = 0.0"
    scene = scene_of(
        BODY.format(duration=5.0, samples=10, more=GRAVITY, forces=drag).replace("[0.9, -1.1, 1.4]", "[0, 0, 0]")
    )
    rate, t = 0.7 / scene.body.mass, scene.rows[:, np.newaxis]
    start = scene.start[0]
    falling = scene.gravity / rate
    fade = -np.expm1(-rate * t) / rate
    states = np.tile(start, (len(t), 1))
    states[:, 0:3] += falling * t + (start[7:10] - falling) * fade
    error, bound = off(scene, states)
    # Falls of 50 m, in terms of 170 m that cancel.
    assert error < bound + 4 * EPS * 170
    assert bound < 1e-12


def test_a_cube_that_drag_slows_down_turns_about_one_axis(scene_of):
    text = BODY.format(duration=4.0, samples=8, more="", forces="[drag]\nlinear = 0.0\nangular = 0.03")
    scene = scene_of(text.replace("[0.4, 0.15, 0.1]", "[0.4, 0.4, 0.4]"))
    rate, w = 0.03 / scene.body.moments[0], scene.start[0, 10:13]
    speed = np.linalg.norm(w)
    states = np.tile(scene.start[0], (len(scene.rows), 1))
    states[:, 0:3] += scene.rows[:, np.newaxis] * scene.start[0, 7:10]
    for state, t in zip(states, scene.rows, strict=True):
        half = -speed * math.expm1(-rate * t) / rate / 2
        a, (b, c, d) = math.cos(half), math.sin(half) * w / speed
        state[3:7] = quaternion_product(np.array((a, b, c, d)), scene.start[0, 3:7])
    error, bound = off(scene, states)
    assert error < bound + 40 * EPS


def test_a_point_that_bounces_on_a_spring(scene_of):
    scene = scene_of(
        """
title = "bouncing point"
duration = 2.0
samples = 16
step = 0.001
gravity = [0.0, -9.81, 0.0]
[body]
shape = "rigid"
mass = 1.5
inertia = [[0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]]
points = [[0.0, 0.0, 0.0]]
position = [0.0, 0.3, 0.0]
[floor]
height = 0.0
stiffness = 2.0e4
damping = 0.0
"""
    )
    g, h, k, m = 9.81, 0.3, 2.0e4, 1.5
    omega, fall, impact = math.sqrt(k / m), math.sqrt(2 * h / g), math.sqrt(2 * g * h)
    # In contact y = -sag + sag cos(omega s) - (impact/omega) sin(omega s): symmetric about its deepest instant.
    sag = m * g / k
    contact = 2 * (math.pi - math.atan2(impact / omega, sag)) / omega
    states = np.tile(scene.start[0], (len(scene.rows), 1))
    for state, t in zip(states, scene.rows, strict=True):
        s = (t + fall) % (2 * fall + contact)
        if s < 2 * fall:
            state[1] = h - g * (s - fall) ** 2 / 2
        else:
            s -= 2 * fall
            state[1] = -sag + sag * math.cos(omega * s) - impact / omega * math.sin(omega * s)
    error, bound = off(scene, states)
    # The instants above are off by some roundings of 2 s, at 2.4 m/s.
    assert error < bound + 40 * EPS
    assert bound < 1e-12


def test_the_floor_is_what_a_rounded_input_does(scene_of):
    text = BODY.format(duration=1.0, samples=4, more=GRAVITY, forces=FORCES["tether"])
    plain = truth(scene_of(text))
    changed = truth(scene_of(text.replace("stiffness = 80.0", f"stiffness = {80.0 * (1 + 2.0**-30)!r}")))
    moved = np.linalg.norm(changed.vertices - plain.vertices, axis=-1).max() * 2.0**-23
    # One of some thirty numbers: no more than all of them, and they are not a thousand times as much.
    assert moved < 3 * plain.input_error.max() < 3000 * moved


def test_it_says_how_it_was_made(scene_of):
    assert truth(read_scene("brick-tumble")).how == "exact"
    assert "Taylor" in truth(scene_of(BODY.format(duration=0.1, samples=1, more="", forces=FORCES["drag"]))).how


def test_a_body_that_damping_holds_fast(scene_of):
    """A damper of 1e6 N s/m: in 1 s the spring creeps 1e-4 of its stretch, by c p' = -k p to the first order in 1/c."""
    forces = "[[tether]]\nvertex = 7\nanchor = [0.0, 0.0, 0.0]\nstiffness = 100.0\ndamping = 1e6"
    text = BODY.format(duration=1.0, samples=4, more="", forces=forces)
    for old in ("[0.5, 3.0, -1.0]", "[0.9, -1.1, 1.4]"):
        text = text.replace(old, "[0, 0, 0]")
    true = truth(scene_of(text))
    start, end = true.vertices[0, 0, 7], true.vertices[-1, 0, 7]
    # What is left out is of the next order in k/c, and the body's own inertia, m/c times the first.
    np.testing.assert_allclose(end - start, -1e-4 * start, rtol=1e-3)
    assert true.bound.max() < 1e-11
