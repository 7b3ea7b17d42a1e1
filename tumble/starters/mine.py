"""An engine of your own: put your integrator into `step`, then run  tumble compare SCENE --engine ./mine.py

A state is x [m], q (w x y z, body to world), v [m/s], w [rad/s], every vector in world axes; one row is one throw.
Body axes are the principal axes.  This one is semi-implicit Euler: first the new velocities, then the pose by them.
"""

import numpy as np

METHODS = ("semi-implicit-euler",)
FEATURES = {"gravity"}
ABOUT = {"version": "1", "precision": "double", "switched_off": []}


class World:
    def __init__(self, scene):
        self.moments = scene.body.moments
        self.gravity = np.zeros(3) if scene.gravity is None else scene.gravity


def build(scene, method):
    return World(scene)


def write(world, states):
    world.states = states.copy()


def advance(world, n, dt):
    for _ in range(n):
        for state in world.states:
            step(state, world.moments, world.gravity, dt)


def read(world):
    return world.states.copy()


def step(state, moments, gravity, dt):
    x, q, v, w = state[0:3], state[3:7], state[7:10], state[10:13]  # views: changing them changes the state
    w_body = axes(q).T @ w
    w_body += dt * np.cross(moments * w_body, w_body) / moments  # Euler's equations: I w' = (I w) x w
    v += dt * gravity
    x += dt * v
    q[:] = product(q, rotation_by(dt * w_body))
    q /= np.linalg.norm(q)
    w[:] = axes(q) @ w_body


def axes(q):
    w, x, y, z = q
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + 2 * w * cross + 2 * cross @ cross


def product(p, q):
    return np.array([p[0] * q[0] - p[1:] @ q[1:], *(p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:]))])


def rotation_by(turn):
    half = np.linalg.norm(turn) / 2
    return np.array([np.cos(half), *(np.sinc(half / np.pi) * turn / 2)])
