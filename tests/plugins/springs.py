"""Semi-implicit Euler with tethers, written by hand, and what silently hides that it blows up.

symplectic      as it is: on an undamped tether stable up to w dt = 2
clamped         every velocity component is cut off at 50, as game engines do
speed-clamped   the lengths of v and w are
reset           put back to where it started when a coordinate or velocity passes 1e6, as MuJoCo does
"""

import mine
import numpy as np

METHODS = ("symplectic", "clamped", "speed-clamped", "reset")
FEATURES = {"gravity", "tether"}
ABOUT = {"version": "1", "precision": "double", "switched_off": []}
FASTEST, FURTHEST = 50.0, 1e6


class World:
    def __init__(self, scene, method):
        self.body, self.tethers, self.method = scene.body, scene.tethers, method
        self.gravity = np.zeros(3) if scene.gravity is None else scene.gravity


def build(scene, method):
    return World(scene, method)


def write(world, states):
    world.states = states.copy()
    world.start = states.copy()


def read(world):
    return world.states.copy()


@np.errstate(all="ignore")
def advance(world, n, dt):
    for _ in range(n):
        for state, start in zip(world.states, world.start, strict=True):
            kick(world, state, dt)
            cut_off(world, state)
            mine.step(state, world.body.moments, world.gravity, dt)
            if world.method == "reset" and not np.abs(state).max() < FURTHEST:
                state[:] = start


def kick(world, state, dt):
    turned = mine.axes(state[3:7])
    for tether in world.tethers:
        lever = turned @ tether.point_body
        d = state[0:3] + lever - tether.anchor
        force = -tether.stiffness * d - tether.damping * (state[7:10] + np.cross(state[10:13], lever))
        state[7:10] += dt * force / world.body.mass
        state[10:13] += turned @ (dt * (turned.T @ np.cross(lever, force)) / world.body.moments)


def cut_off(world, state):
    if world.method == "clamped":
        np.clip(state[7:13], -FASTEST, FASTEST, out=state[7:13])
    if world.method == "speed-clamped":
        for part in (state[7:10], state[10:13]):
            part *= min(1.0, FASTEST / max(np.linalg.norm(part), 1e-300))
