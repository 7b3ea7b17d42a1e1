"""SciPy's DOP853 on a compiled right-hand side: what a numerate user writes instead of calling an engine.

It integrates the quaternion and the angular velocity in body axes, and, where more than gravity pulls at the body, its
position and velocity too; the parabola of a free flight is written down.
"""

# SciPy has no type stubs, and its atol may be an array.
# pyright: reportArgumentType=false

import copy
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING

import numba
import numpy as np
from numpy.typing import NDArray
from scipy.integrate import DOP853

from tumble.compare.engines.parts.turn import turned as rotated
from tumble.compare.engines.parts.turn import turned_back
from tumble.kernel_cache import keep
from tumble.scenarios import wrench
from tumble.scenarios.wrench import net_wrenches, numbers, turned

if TYPE_CHECKING:
    from tumble.scenarios.scene import Scene

Array = NDArray[np.float64]
Slope = Callable[[float, Array], Array]

METHODS = ("dop853",)
DEFAULT = ()  # solve_ivp's is RK45
ADAPTIVE = {"dop853": 1e-9}
FEATURES = {"gravity", "tether", "drag", "floor"}
PACKAGES = ("scipy",)
IMPORTS = ("numba",)
ABOUT = {
    "version": version("scipy"),
    "precision": "double",
    "switched_off": [
        "the translation of a free flight: it is written down in closed form, as in our own solver",
        "Python in the right-hand side: it is compiled",
        "dense output: a sample is where solve_ivp to that instant ends, not on the interpolant of order 7",
        "nothing else: rtol is TOLERANCE; atol is TOLERANCE for q, TOLERANCE times the initial spin for w, and with "
        "forces TOLERANCE times the body's radius for x, the rate the motion begins with being the spin of w and v",
    ],
    "defaults": ["rtol 1e-3 and atol 1e-6: a user of solve_ivp who sets nothing gets those, and method RK45"],
}

# What the kernels here are made of: this folder, and the laws of forces.
HERE, LAWS = Path(__file__).parent, Path(wrench.__file__).parent
LEAST_TOLERANCE = 2.3e-14  # SciPy raises an rtol below 100 eps to that, and warns

# A flight that blew up is full of inf and nan for a judge to see; numpy need not say so as well.
silently = np.errstate(all="ignore")


@dataclass(eq=False)
class World:
    """The throws as written, (N, 13), and what is integrated of them at the instant last asked for.

    That instant is begin [s] and steps of dt [s] after `write`.  asked: the tolerance; gravity [m/s2], (3,).
    motions: q and w_body, (N, 7), or with x and v after them, (N, 13), where forces act; radius: that of the body [m],
    None where none act.  solvers: one a throw, whose steps no instant cuts short; none where the throw is not finite.
    """

    slope: Slope
    asked: float
    gravity: Array
    radius: float | None = None
    start: Array = field(default_factory=lambda: np.empty((0, 13)))
    motions: Array = field(default_factory=lambda: np.empty((0, 7)))
    solvers: list[DOP853 | None] = field(default_factory=list)
    begin: float = 0.0
    steps: int = 0
    dt: float = 0.0

    @property
    def elapsed(self) -> float:
        """The instant last asked for [s], counted, not added up step by step."""
        return self.begin + self.steps * self.dt


def build(scene: "Scene", method: str) -> World:
    """Return a world with the body's equations compiled.  Raises ValueError for a method or tolerance there is not."""
    name, at, tolerance = method.partition("@")
    asked = float(tolerance) if at else ADAPTIVE["dop853"]
    if name not in METHODS or not 0.0 < asked < 1.0:
        raise ValueError(f"{method!r} is not dop853, or dop853@TOLERANCE with a tolerance between 0 and 1")
    gravity = np.zeros(3) if scene.gravity is None else scene.gravity
    if scene.is_free:
        spin = partial(spun, *scene.body.moments.tolist())
        spin(0.0, np.ones(7))  # compiled before any clock runs
        return World(spin, asked, gravity)
    slope = partial(pulled, scene.body.mass, np.array(scene.body.moments), np.array(gravity), *numbers(scene))
    slope(0.0, np.ones(13))
    return World(slope, asked, gravity, scene.body.reach)


@partial(keep, source=HERE)
@numba.njit(error_model="numpy")
def spun(a: float, b: float, c: float, t: float, y: Array) -> Array:
    """Return the right-hand side for moments a, b, c [kg m2]: q' = q w~/2 and Euler's I w' = (I w) x w."""
    qw, qx, qy, qz, wx, wy, wz = y[0], y[1], y[2], y[3], y[4], y[5], y[6]
    rate = np.empty(7)
    rate[0] = -0.5 * (qx * wx + qy * wy + qz * wz)
    rate[1] = 0.5 * (qw * wx + qy * wz - qz * wy)
    rate[2] = 0.5 * (qw * wy + qz * wx - qx * wz)
    rate[3] = 0.5 * (qw * wz + qx * wy - qy * wx)
    rate[4] = (b - c) / a * (wy * wz)
    rate[5] = (c - a) / b * (wz * wx)
    rate[6] = (a - b) / c * (wx * wy)
    return rate


@partial(keep, source=HERE, others=(LAWS,))
@numba.njit(error_model="numpy")
def pulled(
    mass: float,
    moments: Array,
    gravity: Array,
    tethers: Array,
    drag: Array,
    floor: Array,
    feet: Array,
    t: float,
    y: Array,
) -> Array:
    """Return the right-hand side where forces act: that of the spin with a torque, x' = v and v' = g + F/m."""
    states = np.empty((1, 13))
    state, rate = states[0], np.empty(13)
    length = math.sqrt(y[0] * y[0] + y[1] * y[1] + y[2] * y[2] + y[3] * y[3])
    # Axis by axis: slices would compile for three times as long.
    for axis in range(3):
        state[axis], state[7 + axis] = y[7 + axis], y[10 + axis]
    for number in range(4):
        state[3 + number] = y[number] / length
    state[10], state[11], state[12] = turned(state, (y[4], y[5], y[6]))
    total = net_wrenches(states, tethers, drag, floor, feet)[0]
    for axis in range(3):
        state[4 + axis] *= -1.0  # from here on it turns world axes into body axes
    torque = turned(state, (total[3], total[4], total[5]))
    spin = spun(moments[0], moments[1], moments[2], t, y)
    for number in range(7):
        rate[number] = spin[number]
    for axis in range(3):
        rate[4 + axis] += torque[axis] / moments[axis]
        rate[7 + axis], rate[10 + axis] = y[10 + axis], gravity[axis] + total[axis] / mass
    return rate


@silently
def write(world: World, states: Array) -> None:
    """Put the throws into these states, (N, 13), each with a solver that has not stepped yet."""
    world.start = states.copy()
    q = states[:, 3:7] / np.linalg.norm(states[:, 3:7], axis=1, keepdims=True)
    spins = np.hstack((q, turned_back(states[:, 10:13], q)))
    world.motions = spins if world.radius is None else np.hstack((spins, states[:, 0:3], states[:, 7:10]))
    world.solvers = [solver_from(world, y) for y in world.motions.copy()]
    world.begin, world.steps, world.dt = 0.0, 0, 0.0


def solver_from(world: World, y: Array) -> DOP853 | None:
    """Return a solver at t = 0 that is bound for no instant, or None where SciPy would refuse y or never return."""
    slope = world.slope(0.0, y)
    if not np.isfinite((y, slope)).all():
        return None
    tolerance = max(world.asked, LEAST_TOLERANCE)
    return DOP853(world.slope, 0.0, y, np.inf, rtol=tolerance, atol=tolerance * scale(y, slope, world.radius))


def scale(y: Array, slope: Array, radius: float | None) -> Array:
    """Return what the motion is to be resolved to a share of: q, w_body and, where forces act, x and v."""
    spin = float(np.linalg.norm(y[4:7]))
    if radius is None:
        return np.repeat((1.0, spin or 1.0), (4, 3))  # a body at rest meets any tolerance but 0, which makes 0/0
    # A body that is pulled from rest has no spin yet: what it gains within a radian is the root of its acceleration.
    v, w_dot, v_dot = (float(np.linalg.norm(part)) for part in (y[10:13], slope[4:7], slope[10:13]))
    rate = max(spin, v / radius, np.sqrt(w_dot), np.sqrt(v_dot / radius)) or 1.0
    return np.repeat((1.0, rate, radius, radius * rate), (4, 3, 3, 3))


@silently
def advance(world: World, n: int, dt: float) -> None:
    """Find the throws n steps of dt [s] later; the steps taken are DOP853's own."""
    if dt != world.dt:
        world.begin, world.steps, world.dt = world.elapsed, 0, dt
    world.steps += n
    for y, solver in zip(world.motions, world.solvers, strict=True):
        y[:] = np.nan if solver is None else state_at(world.elapsed, solver)


def state_at(t: float, solver: DOP853) -> Array | float:
    """Return q and w_body at t [s], (7,), as solve_ivp to that instant ends, or nan where DOP853 fails.

    The solver goes up to the step that would pass t.  That one is cut short at t, as solve_ivp cuts it, in a copy: so
    that no instant asked for moves those after it.
    """
    while solver.status == "running" and solver.t + solver.h_abs <= t:
        solver.step()
    last = copy.copy(solver)
    last.t_bound = t
    while last.status == "running":
        last.step()
    return last.y if last.status == "finished" else np.nan


@silently
def read(world: World) -> Array:
    """Return the states of the throws, (N, 13)."""
    q = world.motions[:, 0:4] / np.linalg.norm(world.motions[:, 0:4], axis=1, keepdims=True)
    w = rotated(world.motions[:, 4:7], q)
    if world.radius is not None:
        return np.hstack((world.motions[:, 7:10], q, world.motions[:, 10:13], w))
    t, x, v = world.elapsed, world.start[:, 0:3], world.start[:, 7:10]
    return np.hstack((x + t * (v + t / 2.0 * world.gravity), q, v + t * world.gravity, w))


def audit(world: World) -> list[tuple[str, str]]:
    """Return that the tolerance was not the one asked for, where SciPy has none so small."""
    if world.asked >= LEAST_TOLERANCE:
        return []
    return [("tolerance", f"tolerance {world.asked:g} raised to {LEAST_TOLERANCE:g}, the least SciPy takes")]
