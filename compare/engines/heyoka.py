"""heyoka's adaptive Taylor integrator, compiled for one body: the reference integrator of celestial mechanics.

It integrates the quaternion and the angular velocity in body axes; the parabola of a free flight is written down.
heyoka has one norm for all numbers of a state.  With the fall among them the attitude would be held to a tolerance
hundreds of times as loose, and over some minutes to none; so it would with a fast spin.  Therefore the initial angular
speed is the unit of angular velocity, and time is counted in radians at that speed, which leaves the equations as
they are.
"""

from dataclasses import dataclass, field
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

import heyoka
import numpy as np
from numpy.typing import NDArray

from tumble.compare.engines.parts.turn import turned, turned_back

if TYPE_CHECKING:
    from tumble.scenarios.scene import Scene

Array = NDArray[np.float64]

METHODS = ("taylor",)
DEFAULT = ()  # its own tolerance is 2.2e-16
ADAPTIVE = {"taylor": 1e-9}
REUSES_WORLD = True
FEATURES = {"gravity"}
PACKAGES = ("heyoka",)
PINS = ("heyoka==7.13.2",)
ABOUT = {
    "version": version("heyoka"),
    "precision": "double",
    "switched_off": [
        "the translation: it is written down in closed form, as in our own solver",
        "parameters: the moments of inertia are constants that heyoka compiles in",
        "units: angular velocity is in those of the initial one, and time in radians at that",
        "dense output: a sample is where propagate_until to that instant ends",
        "nothing else: TOLERANCE is heyoka's tol",
    ],
    "defaults": ["tol 2.2e-16, the rounding of a double"],
}

LEAST_TOLERANCE = np.finfo(float).eps

# A flight that blew up is full of inf and nan for a judge to see; numpy need not say so as well.
silently = np.errstate(all="ignore")


@dataclass(eq=False)
class Anchor:
    """An end of a step that no instant cut short: q and w_body / speed, (7,), at time [rad], a double and its rounding.

    speed: of the throw's first turning [rad/s], or 1 where that is none or not finite.
    steps: how many lead from here to the instant last asked for, the last of them cut short there.
    """

    spin: Array
    speed: float
    time: tuple[float, float] = (0.0, 0.0)
    steps: int = 0


@dataclass(eq=False)
class World:
    """The throws as written, (N, 13), and their q and w_body / speed, (N, 7), at the instant last asked for.

    That instant is begin [s] and steps of dt [s] after `write`.  taylor: one integrator, flown for every throw in turn,
    with an anchor for each; gravity [m/s2], (3,).
    """

    taylor: Any
    gravity: Array
    start: Array = field(default_factory=lambda: np.empty((0, 13)))
    spins: Array = field(default_factory=lambda: np.empty((0, 7)))
    anchors: list[Anchor] = field(default_factory=list)
    begin: float = 0.0
    steps: int = 0
    dt: float = 0.0

    @property
    def elapsed(self) -> float:
        """The instant last asked for [s], counted, not added up step by step."""
        return self.begin + self.steps * self.dt


def build(scene: "Scene", method: str) -> World:
    """Return a world with the body's equations compiled.  Raises ValueError for a method or tolerance there is not."""
    name, at, asked = method.partition("@")
    tolerance = float(asked) if at else ADAPTIVE["taylor"]
    if name not in METHODS or not LEAST_TOLERANCE <= tolerance < 1.0:
        raise ValueError(f"{method!r} is not taylor, or taylor@TOLERANCE from {LEAST_TOLERANCE:.2g} to below 1")
    gravity = np.zeros(3) if scene.gravity is None else scene.gravity
    system = equations(*scene.body.moments.tolist())
    return World(heyoka.taylor_adaptive(system, [0.0] * len(system), tol=tolerance), gravity)


def equations(a: float, b: float, c: float) -> list[tuple[heyoka.expression, heyoka.expression]]:
    """Return q' = q w~/2 and Euler's I w' = (I w) x w for moments a, b, c [kg m2]."""
    qw, qx, qy, qz, wx, wy, wz = heyoka.make_vars("qw", "qx", "qy", "qz", "wx", "wy", "wz")
    return [
        (qw, -0.5 * (qx * wx + qy * wy + qz * wz)),
        (qx, 0.5 * (qw * wx + qy * wz - qz * wy)),
        (qy, 0.5 * (qw * wy + qz * wx - qx * wz)),
        (qz, 0.5 * (qw * wz + qx * wy - qy * wx)),
        (wx, (b - c) / a * (wy * wz)),
        (wy, (c - a) / b * (wz * wx)),
        (wz, (a - b) / c * (wx * wy)),
    ]


@silently
def write(world: World, states: Array) -> None:
    """Put the throws into these states, (N, 13)."""
    world.start = states.copy()
    q = states[:, 3:7] / np.linalg.norm(states[:, 3:7], axis=1, keepdims=True)
    w_body = turned_back(states[:, 10:13], q)
    speeds = np.linalg.norm(w_body, axis=1)
    speeds[(speeds == 0.0) | ~np.isfinite(speeds)] = 1.0
    world.spins = np.hstack((q, w_body / speeds[:, np.newaxis]))
    world.anchors = [Anchor(spin, speed) for spin, speed in zip(world.spins.copy(), speeds.tolist(), strict=True)]
    world.begin, world.steps, world.dt = 0.0, 0, 0.0


def advance(world: World, n: int, dt: float) -> None:
    """Find the throws n steps of dt [s] later; the steps taken are heyoka's own."""
    if dt != world.dt:
        world.begin, world.steps, world.dt = world.elapsed, 0, dt
    world.steps += n
    t, taylor = world.elapsed, world.taylor
    state = taylor.state
    for spin, anchor in zip(world.spins, world.anchors, strict=True):
        taylor.dtime = anchor.time
        state[:] = anchor.spin
        angle = anchor.speed * t
        if anchor.steps > 1:
            move_up(anchor, taylor, angle)
        anchor.steps = taylor.propagate_until(angle)[3]
        spin[:] = state


def move_up(anchor: Anchor, taylor: Any, angle: float) -> None:
    """Move the anchor up to the last whole step before the instant last asked for; angle [rad] is no earlier.

    To go on from that instant itself would let it move all that come after it.  Flying the steps again costs up to
    twice the time where many of them are between two samples, and nothing where there is one sample.
    """
    taylor.propagate_until(angle, max_steps=anchor.steps - 1)
    anchor.spin[:] = taylor.state
    anchor.time = taylor.dtime


@silently
def read(world: World) -> Array:
    """Return the states of the throws, (N, 13)."""
    t, x, v = world.elapsed, world.start[:, 0:3], world.start[:, 7:10]
    q = world.spins[:, 0:4] / np.linalg.norm(world.spins[:, 0:4], axis=1, keepdims=True)
    fallen = x + t * (v + t / 2.0 * world.gravity)
    w_body = world.spins[:, 4:7] * [[anchor.speed] for anchor in world.anchors]
    return np.hstack((fallen, q, v + t * world.gravity, turned(w_body, q)))
