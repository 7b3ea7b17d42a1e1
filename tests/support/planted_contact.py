"""An engine above a plane with a law of contact of its choice: right, or wrong in one way that has a name.

One step is semi-implicit Euler.  The body does not turn: a ball that hits without friction, or a box on its face.
"""

import math

import numpy as np

METHODS = (
    "right",
    "diamond",
    "square",
    "another-friction",
    "creeps",
    "e-squared",
    "dead",
    "by-the-step",
    "early",
    "tunnels",
    "thin",
    "gains",
)
# Scenes that it can run.
SLIDE = """
title = "slide"
duration = 0.6
samples = 12
step = 0.004
gravity = [0.0, -9.81, 0.0]
[body]
shape = "box"
size = [0.5, 0.1, 0.4]
mass = 5.0
position = [0.3, 0.05, -0.2]
velocity = [1.0, 0.0, 0.5]
[plane]
restitution = 0.0
friction = 0.4
"""
BALL = """
title = "ball"
duration = 0.9
samples = 9
step = 0.004
gravity = [0.0, -9.81, 0.0]
[body]
shape = "sphere"
radius = 0.05
mass = 0.3
position = [0.0, 0.6, 0.0]
[plane]
restitution = 0.6
friction = 0.0
"""
ROLL = """
title = "roll"
duration = 0.9
samples = 9
step = 0.004
gravity = [0.0, -9.81, 0.0]
[body]
shape = "sphere"
radius = 0.1
mass = 0.3
position = [0.0, 0.1, 0.0]
velocity = [1.5, 0.0, 0.4]
angular_velocity = [6.0, 2.0, 9.0]
[plane]
restitution = 0.0
friction = 0.3
"""
FEATURES = {"gravity", "plane"}
ABOUT = {"version": "1", "precision": "double", "switched_off": []}
CREEP, EARLY, GAIN, THIN = 2e-3, 5e-3, 1.05, 0.05


class World:
    """Bodies: where they are, and the law."""

    def __init__(self, scene, method):
        self.scene, self.method, self.plane = scene, method, scene.plane
        self.normal = scene.plane.normal
        self.half = scene.body.radius or float(scene.body.size[1]) / 2
        self.friction = scene.plane.friction * (1.25 if method == "another-friction" else 1.0)


def build(scene, method):
    return World(scene, method)


def write(world, states):
    world.states = states.copy()


def read(world):
    return world.states.copy()


def advance(world, n, dt):
    for state in world.states:
        advance_throw(world, state, n, dt)


def advance_throw(world, state, n, dt):
    normal, pull = world.normal, world.scene.gravity
    for _ in range(n):
        before, v = state[7:10] @ normal, state[7:10] + dt * pull
        height = (state[0:3] - world.plane.point) @ normal - world.half
        up = v @ normal
        if world.method == "thin" and height + dt * up < -THIN:
            up = 0.0
        if height + dt * up < (EARLY if world.method == "early" else 0.0) and up < 0 and world.method != "tunnels":
            v = v - up * normal
            weight = -dt * (pull @ normal)
            if world.scene.body.radius:  # a solid ball: 5/7 of a change of the slip is one of the spin
                slip = v - world.half * np.cross(state[10:13], normal)
                gained = (slowed(world, slip, 3.5 * weight) - slip) / 3.5
                v = v + gained
                state[10:13] -= 2.5 / world.half * np.cross(normal, gained)
            else:
                v = slowed(world, v, weight)
            if before < 2 * dt * (pull @ normal):  # faster than a body that lies there
                v = v - restitution(world, height, up, dt) * up * normal
        state[7:10] = v
        state[0:3] += dt * v


def restitution(world, height, up, dt):
    """The ratio of speeds; by-the-step: by how much of the step is left when the plane is met."""
    e = world.plane.restitution
    if world.method == "by-the-step":
        return e * (0.5 + height / (-up * dt))
    return {"e-squared": e * e, "dead": 0.0, "gains": GAIN}.get(world.method, e)


def slowed(world, v, weight):
    """The velocity along the plane after friction at most mu times the weight [m/s] of one step."""
    most, speed = world.friction * weight, math.sqrt(v @ v)
    if world.method == "creeps" and speed <= max(most, CREEP):
        return v * (CREEP / speed) if speed else v
    if world.method in ("diamond", "square"):
        return by_axes(world, v, most)
    return v * (1 - most / speed) if speed > most else 0 * v


def by_axes(world, v, most):
    """The same by a pyramid along x and z, for a plane whose normal is y."""
    x, z = v[0], v[2]
    if world.method == "square":
        x, z = (np.sign(one) * max(abs(one) - most, 0.0) for one in (x, z))
    else:
        first = min(most, abs(abs(x) - abs(z)))  # along the larger component, until both are equal
        if abs(x) >= abs(z):
            x -= np.sign(x) * first
        else:
            z -= np.sign(z) * first
        rest = (most - first) / 2
        x, z = (np.sign(one) * max(abs(one) - rest, 0.0) for one in (x, z))
    return np.array((x, 0.0, z))
