"""heyoka's adaptive Taylor integrator, compiled for one body: the reference integrator of celestial mechanics.

All 13 numbers are one system, in the layout of a state but with the angular velocity in body axes.
"""

from dataclasses import dataclass, field
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

import heyoka
import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from scenarios.scene import Scene

Array = NDArray[np.float64]
Equations = list[tuple[heyoka.expression, heyoka.expression]]

METHODS = ("taylor",)
ADAPTIVE = METHODS
FEATURES = {"gravity"}
ABOUT = {
    "version": version("heyoka"),
    "precision": "double",
    "switched_off": [
        "parameters: the body's moments and gravity are constants that heyoka compiles in",
        "dense output: a sample is where propagate_until to that instant ends",
        "nothing else: TOLERANCE is heyoka's tol, relative to the largest of the 13 numbers, or absolute below 1",
    ],
}

DEFAULT_TOLERANCE = 1e-9
LEAST_TOLERANCE = np.finfo(float).eps

# A flight that blew up is full of inf and nan for a judge to see; numpy need not say so as well.
silently = np.errstate(all="ignore")


@dataclass(eq=False)
class Anchor:
    """An end of a step that no instant asked for has cut short: y, (13,), at time [s], a double and its rounding.

    steps: how many lead from here to the instant last asked for, the last of them cut short there.
    """

    y: Array
    time: tuple[float, float] = (0.0, 0.0)
    steps: int = 0


@dataclass(eq=False)
class World:
    """One integrator, flown for every throw in turn; here are the throws, (N, 13), at the instant last asked for.

    That instant is begin [s] and steps of dt [s] after `write`.
    """

    taylor: Any
    here: Array = field(default_factory=lambda: np.empty((0, 13)))
    anchors: list[Anchor] = field(default_factory=list)
    begin: float = 0.0
    steps: int = 0
    dt: float = 0.0


def build(scene: "Scene", method: str) -> World:
    """Return a world with the scene's equations compiled.  Raises ValueError for a method or tolerance there is not."""
    name, at, asked = method.partition("@")
    tolerance = float(asked) if at else DEFAULT_TOLERANCE
    if name not in METHODS or not LEAST_TOLERANCE <= tolerance < 1.0:
        raise ValueError(f"{method!r} is not taylor, or taylor@TOLERANCE from {LEAST_TOLERANCE:.2g} to below 1")
    return World(heyoka.taylor_adaptive(equations(scene), [0.0] * 13, tol=tolerance))


def equations(scene: "Scene") -> Equations:
    """Return x' = v, q' = q w~/2, v' = g and Euler's I w' = (I w) x w."""
    position = heyoka.make_vars("x", "y", "z")
    attitude = qw, qx, qy, qz = heyoka.make_vars("qw", "qx", "qy", "qz")
    velocity = heyoka.make_vars("vx", "vy", "vz")
    w_body = wx, wy, wz = heyoka.make_vars("wx", "wy", "wz")
    turning = (
        -0.5 * (qx * wx + qy * wy + qz * wz),
        0.5 * (qw * wx + qy * wz - qz * wy),
        0.5 * (qw * wy + qz * wx - qx * wz),
        0.5 * (qw * wz + qx * wy - qy * wx),
    )
    gravity = (0.0, 0.0, 0.0) if scene.gravity is None else scene.gravity.tolist()
    a, b, c = scene.body.moments.tolist()
    euler = ((b - c) / a * (wy * wz), (c - a) / b * (wz * wx), (a - b) / c * (wx * wy))
    return [
        *zip(position, velocity, strict=True),
        *zip(attitude, turning, strict=True),
        *zip(velocity, map(heyoka.expression, gravity), strict=True),
        *zip(w_body, euler, strict=True),
    ]


@silently
def write(world: World, states: Array) -> None:
    """Put the throws into these states, (N, 13)."""
    world.here = states.copy()
    q = world.here[:, 3:7] = states[:, 3:7] / np.linalg.norm(states[:, 3:7], axis=1, keepdims=True)
    world.here[:, 10:13] = turned(states[:, 10:13], q * (1, -1, -1, -1))
    world.anchors = [Anchor(y) for y in world.here.copy()]
    world.begin, world.steps, world.dt = 0.0, 0, 0.0


def advance(world: World, n: int, dt: float) -> None:
    """Find the throws n steps of dt [s] later; the steps taken are heyoka's own."""
    if dt != world.dt:
        world.begin, world.steps, world.dt = world.begin + world.steps * world.dt, 0, dt
    world.steps += n
    t = world.begin + world.steps * dt
    taylor = world.taylor
    state = taylor.state
    for y, anchor in zip(world.here, world.anchors, strict=True):
        taylor.dtime = anchor.time
        state[:] = anchor.y
        if anchor.steps > 1:
            move_up(taylor, anchor, t)
        anchor.steps = taylor.propagate_until(t)[3]
        y[:] = state


def move_up(taylor: Any, anchor: Anchor, t: float) -> None:
    """Move the anchor up to the last whole step before the instant last asked for; t [s] is no earlier.

    To go on from that instant itself would let it move all that come after it.  Flying the steps again costs up to
    twice the time where many of them are between two samples, and nothing where there is one sample.
    """
    taylor.propagate_until(t, max_steps=anchor.steps - 1)
    anchor.y[:] = taylor.state
    anchor.time = taylor.dtime


@silently
def read(world: World) -> Array:
    """Return the states of the throws, (N, 13)."""
    states = world.here.copy()
    q = states[:, 3:7] = states[:, 3:7] / np.linalg.norm(states[:, 3:7], axis=1, keepdims=True)
    states[:, 10:13] = turned(states[:, 10:13], q)
    return states


def turned(vectors: Array, q: Array) -> Array:
    """Return vectors, (N, 3), turned by unit quaternions w x y z, (N, 4): v + 2 (w n + n x n) x v, n = (x, y, z)."""
    across = 2.0 * np.cross(q[:, 1:4], vectors)
    return vectors + q[:, 0:1] * across + np.cross(q[:, 1:4], across)
