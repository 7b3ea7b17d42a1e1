"""SciPy's DOP853 on a compiled right-hand side: what a numerate user writes instead of calling an engine.

All 13 numbers are one system, in the layout of a state but with the angular velocity in body axes.
"""

# SciPy has no type stubs, and its atol may be an array.
# pyright: reportArgumentType=false

import copy
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import version
from typing import TYPE_CHECKING

import numba
import numpy as np
from numpy.typing import NDArray
from scipy.integrate import DOP853

if TYPE_CHECKING:
    from scenarios.scene import Scene

Array = NDArray[np.float64]
Slope = Callable[[float, Array], Array]
Triple = tuple[float, float, float]

METHODS = ("dop853",)
ADAPTIVE = METHODS
FEATURES = {"gravity"}
ABOUT = {
    "version": version("scipy"),
    "precision": "double",
    "switched_off": [
        "Python in the right-hand side: it is compiled, the body's moments and gravity constants in it",
        "dense output: a sample is where solve_ivp to that instant would end, not the interpolant of order 7",
        "tolerances for single numbers: rtol is TOLERANCE, atol is TOLERANCE times the size of the body, 1 for the "
        "quaternion, and the initial speed and spin",
    ],
}

DEFAULT_TOLERANCE = 1e-9
LEAST_TOLERANCE = 2.3e-14  # SciPy raises an rtol below 100 eps to that, and warns

# A flight that blew up is full of inf and nan for a judge to see; numpy need not say so as well.
silently = np.errstate(all="ignore")


@dataclass(eq=False)
class World:
    """The question, and every throw twice: its solver, and its row of here, (N, 13), at the instant last asked for.

    That instant is begin [s] and steps of dt [s] after `write`.  asked: the tolerance; size of the body [m].
    A solver's steps are its own and never cut; there is none for a state that is not finite.
    """

    slope: Slope
    asked: float
    size: float
    here: Array = field(default_factory=lambda: np.empty((0, 13)))
    solvers: list[DOP853 | None] = field(default_factory=list)
    begin: float = 0.0
    steps: int = 0
    dt: float = 0.0


def build(scene: "Scene", method: str) -> World:
    """Return a world with the scene's equations compiled.  Raises ValueError for a method or tolerance there is not."""
    name, at, tolerance = method.partition("@")
    asked = float(tolerance) if at else DEFAULT_TOLERANCE
    if name not in METHODS or not 0.0 < asked < 1.0:
        raise ValueError(f"{method!r} is not dop853, or dop853@TOLERANCE with a tolerance between 0 and 1")
    gravity = (0.0, 0.0, 0.0) if scene.gravity is None else tuple(scene.gravity.tolist())
    size = np.linalg.norm(scene.body.points, axis=1).max()
    return World(compiled(tuple(scene.body.moments.tolist()), gravity), asked, length(size))


@cache
def compiled(moments: Triple, gravity: Triple) -> Slope:
    """Return the right-hand side for one body: x' = v, q' = q w~/2, v' = g and Euler's I w' = (I w) x w."""
    a, b, c = moments

    @numba.njit("float64[::1](float64, float64[::1])", error_model="numpy")
    def slope(t: float, y: Array) -> Array:
        qw, qx, qy, qz = y[3], y[4], y[5], y[6]
        wx, wy, wz = y[10], y[11], y[12]
        rate = np.empty(13)
        rate[0:3] = y[7:10]
        rate[3] = -0.5 * (qx * wx + qy * wy + qz * wz)
        rate[4] = 0.5 * (qw * wx + qy * wz - qz * wy)
        rate[5] = 0.5 * (qw * wy + qz * wx - qx * wz)
        rate[6] = 0.5 * (qw * wz + qx * wy - qy * wx)
        rate[7], rate[8], rate[9] = gravity
        rate[10] = (b - c) / a * (wy * wz)
        rate[11] = (c - a) / b * (wz * wx)
        rate[12] = (a - b) / c * (wx * wy)
        return rate

    return slope


@silently
def write(world: World, states: Array) -> None:
    """Put the throws into these states, (N, 13), each with a solver that has not stepped yet."""
    world.here = states.copy()
    q = world.here[:, 3:7] = states[:, 3:7] / np.linalg.norm(states[:, 3:7], axis=1, keepdims=True)
    world.here[:, 10:13] = turned(states[:, 10:13], q * (1, -1, -1, -1))
    world.solvers = [solver_from(world, y) for y in world.here]
    world.begin, world.steps, world.dt = 0.0, 0, 0.0


def solver_from(world: World, y: Array) -> DOP853 | None:
    """Return a solver at t = 0 that is bound for no instant, or None where SciPy would refuse y or never return."""
    if not np.isfinite((y, world.slope(0.0, y))).all():
        return None
    tolerance = max(world.asked, LEAST_TOLERANCE)
    scale = np.repeat((world.size, 1.0, length(y[7:10]), length(y[10:13])), (3, 4, 3, 3))
    return DOP853(world.slope, 0.0, y.copy(), np.inf, rtol=tolerance, atol=tolerance * scale)


def length(vector: Array) -> float:
    """Return the length of a vector, or 1 where there is none: a tolerance of 0 could not be met."""
    return float(np.linalg.norm(vector)) or 1.0


@silently
def advance(world: World, n: int, dt: float) -> None:
    """Find the throws n steps of dt [s] later; the steps taken are DOP853's own."""
    if dt != world.dt:
        world.begin, world.steps, world.dt = world.begin + world.steps * world.dt, 0, dt
    world.steps += n
    t = world.begin + world.steps * dt
    for y, solver in zip(world.here, world.solvers, strict=True):
        y[:] = np.nan if solver is None else state_at(t, solver)


def state_at(t: float, solver: DOP853) -> Array | float:
    """Return y at t [s], (13,), as solve_ivp to that instant ends, or nan where DOP853 fails.

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
    states = world.here.copy()
    q = states[:, 3:7] = states[:, 3:7] / np.linalg.norm(states[:, 3:7], axis=1, keepdims=True)
    states[:, 10:13] = turned(states[:, 10:13], q)
    return states


def audit(world: World) -> list[str]:
    """Return that the tolerance was not the one asked for, where SciPy has none so small."""
    if world.asked >= LEAST_TOLERANCE:
        return []
    return [f"tolerance {world.asked:g} raised to {LEAST_TOLERANCE:g}, the least SciPy takes"]


def turned(vectors: Array, q: Array) -> Array:
    """Return vectors, (N, 3), turned by unit quaternions w x y z, (N, 4): v + 2 (w n + n x n) x v, n = (x, y, z)."""
    across = 2.0 * np.cross(q[:, 1:4], vectors)
    return vectors + q[:, 0:1] * across + np.cross(q[:, 1:4], across)
