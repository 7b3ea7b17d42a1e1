"""The hand calculation of the CE1051A report, eq. 4.1, with its three mistakes, and with each of them mended.

    p = A t^2 / 2 + R(w t) p0

1. impulse: the 5 N s given to the cube are read as a constant force of 5 N, so A t^2/2 stands where J t/m belongs;
2. vertex: p0 is not taken from the centre of mass, so the cube turns about the world's origin;
3. clock: t is read off the screen, and the positions belong to earlier steps of the physics clock.

A method's name says which mistakes are mended.  Each is still a rigid motion, so a state holds it whole.
"""

import math
from dataclasses import dataclass, field
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from tumble.scenarios.frames import Array, quaternion_product
from tumble.scenarios.published import table_4_1

if TYPE_CHECKING:
    from tumble.scenarios.scene import Scene

MISTAKES = ("impulse", "vertex", "clock")
MENDED: dict[str, frozenset[str]] = {
    "as-printed": frozenset(),
    **{"+".join(some) + "-mended": frozenset(some) for count in (1, 2) for some in combinations(MISTAKES, count)},
    "all-mended": frozenset(MISTAKES),
}

METHODS = tuple(MENDED)
DEFAULT = ()  # a calculation has no settings
FEATURES: frozenset[str] = frozenset()
INSTANTS = tuple(table_4_1().physics_times.tolist())
EXEMPT = {
    "straight": "v is taken for an acceleration and the body turns about the world's origin, as in the report",
    "converges": "the angular velocity stays as it is, as in the report, and there are no steps",
}
ABOUT = {"version": "CE1051A, eq. 4.1", "precision": "double", "switched_off": []}

FORCE_LASTED_S = 1.0  # reading f N s as f N gives the impulse one second to act


@dataclass
class World:
    """The start, and how far the physics clock has come, kept as counts so that it never drifts."""

    mended: frozenset[str]
    start: Array = field(default_factory=lambda: np.empty((0, 13)))
    steps: dict[float, int] = field(default_factory=dict)

    @property
    def time(self) -> float:
        """Physics time since write [s]."""
        return math.fsum(n * dt for dt, n in self.steps.items())


def build(scene: "Scene", method: str) -> World:
    """Return a world for Table 4.1's throw; the clock on the screen is known only at its five instants."""
    if tuple(scene.times.tolist()) != INSTANTS:
        raise NotImplementedError("the hand calculation was made for the five instants of Table 4.1 only")
    return World(MENDED[method])


def write(world: World, states: Array) -> None:
    """Start again from these states."""
    world.start = states.copy()
    world.steps = {}


def advance(world: World, n: int, dt: float) -> None:
    """Let the physics clock move on."""
    world.steps[dt] = world.steps.get(dt, 0) + n


def read(world: World) -> Array:
    """Return eq. 4.1 at the time reached, as states (N, 13)."""
    states = world.start.copy()
    if not any(world.steps.values()):
        return states
    t = world.time if "clock" in world.mended else screen_clock(world.time)
    for state, start in zip(states, world.start, strict=True):
        x0, v0, w = start[0:3], start[7:10], start[10:13]
        turn = axis_angle_matrix(w, t)
        if "impulse" in world.mended:
            shift, velocity = v0 * t, v0
        else:
            acceleration = v0 / FORCE_LASTED_S
            shift, velocity = acceleration * t**2 / 2, acceleration * t
        carried = x0 if "vertex" in world.mended else turn @ x0
        state[0:3] = carried + shift
        state[3:7] = quaternion_product(axis_angle_quaternion(w, t), start[3:7])
        state[7:10] = velocity if "vertex" in world.mended else velocity + np.cross(w, carried)
    return states


def screen_clock(t: float) -> float:
    """Return the time on the screen while physics is at t [s]; between the printed rows it is t itself."""
    table = table_4_1()
    row = int(np.argmin(abs(table.physics_times - t)))
    return float(table.clock[row]) if math.isclose(table.physics_times[row], t, rel_tol=1e-9) else t


def axis_angle_matrix(w: Array, t: float) -> Array:
    """Return the standard rotation matrix about w by the angle |w| t (CE1051A report, eqs. 2.15 and 4.6)."""
    rate = np.linalg.norm(w)
    a, b, g = w / rate if rate else np.zeros(3)
    cos, sin = math.cos(rate * t), math.sin(rate * t)
    c = 1 - cos
    return np.array(
        [
            [a * a * c + cos, a * b * c - g * sin, a * g * c + b * sin],
            [a * b * c + g * sin, b * b * c + cos, b * g * c - a * sin],
            [a * g * c - b * sin, b * g * c + a * sin, g * g * c + cos],
        ]
    )


def axis_angle_quaternion(w: Array, t: float) -> Array:
    """Return the same turn as a quaternion w x y z."""
    rate = np.linalg.norm(w)
    half = rate * t / 2
    return np.array([math.cos(half), *(math.sin(half) * (w / rate if rate else w))])
