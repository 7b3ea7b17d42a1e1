"""An engine that breaks one law of engines a method, so that the test of each law is seen to fail."""

import mine
import numpy as np

METHODS = (
    "changes-what-is-written",
    "depends-on-how-steps-are-asked-for",
    "remembers",
    "slows-down",
    "floats",
    "takes-little-for-nothing",
    "alters-the-scene",
    "mixes-throws",
    "needs-its-optional",
    "prints-six-digits",
    "reads-x-y-z-w",
    "reverses-the-torque",
    "feels-gravity",
    "feels-the-centre",
    "moves-when-asked",
)
FEATURES = {"gravity"}
OPTIONAL = ("drift",)
ABOUT = {"version": "1", "precision": "double", "switched_off": []}


class World(mine.World):
    def __init__(self, scene, method):
        super().__init__(scene)
        self.method, self.scene = method, scene
        self.flown = 0


def build(scene, method, keep=()):
    world = World(scene, method)
    if method == "alters-the-scene":
        object.__setattr__(scene, "step", 2 * scene.step)
    if method == "takes-little-for-nothing" and max(scene.body.moments) < 1e-6:
        world.moments = np.ones(3)
    world.drifts = method == "needs-its-optional" and "drift" in keep
    if method == "floats":
        world.gravity = np.zeros(3)
    return world


def write(world, states):
    mine.write(world, states)
    if world.method == "changes-what-is-written":
        world.states[:, 10:13] = world.states[:, 12:9:-1]  # another order of axes
    if world.method == "reads-x-y-z-w":
        world.states[:, 3:7] = np.roll(world.states[:, 3:7], 1, axis=1)
    if world.method == "remembers":
        world.states[:, 0] += 1e-15 * world.flown


def advance(world, n, dt):
    for _ in range(n):
        if world.method == "reverses-the-torque":
            reverse(world.states, world.moments, dt)
        mine.advance(world, 1, dt)
    world.flown += n
    if world.method == "depends-on-how-steps-are-asked-for":
        world.states[:, 0] += dt  # one step more for every call
    if world.method == "slows-down":
        world.states[:, 7:10] *= (1 - 1e-9) ** n
    if world.drifts:
        world.states[:, 0] += 1e-9 * n
    if world.method == "mixes-throws":
        world.states[:, 7:10] = world.states[:, 7:10].mean(axis=0)


def reverse(states, moments, dt):
    """Take away twice what a step is about to add."""
    for state in states:
        turn = mine.axes(state[3:7])
        w_body = turn.T @ state[10:13]
        state[10:13] = turn @ (w_body - 2 * dt * np.cross(moments * w_body, w_body) / moments)


def sense(world):
    """Specific force and angular velocity of every sensor of a free body, but for three methods."""
    found = []
    for state in world.states:
        turn = mine.axes(state[3:7])
        w = turn.T @ state[10:13]
        alpha = np.cross(world.moments * w, w) / world.moments
        rows = []
        for sensor in world.scene.sensors:
            mounted, r = mine.axes(sensor.orientation), sensor.point_body
            felt = np.cross(alpha, r) + np.cross(w, np.cross(w, r))
            if world.method == "feels-gravity" and world.scene.gravity is not None:
                felt = felt - turn.T @ world.scene.gravity
            if world.method == "feels-the-centre":
                felt = 0 * felt
            rows.append(np.concatenate((felt @ mounted, w @ mounted)))
        found.append(rows)
    if world.method == "moves-when-asked":
        world.states[:, 0] += 1e-9
    return np.array(found)


def read(world):
    states = mine.read(world)
    if world.method == "reads-x-y-z-w":
        states[:, 3:7] = np.roll(states[:, 3:7], -1, axis=1)
    if world.method == "prints-six-digits":
        return np.array([[float(f"{number:g}") for number in state] for state in states])
    return states
