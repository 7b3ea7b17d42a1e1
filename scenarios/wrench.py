"""What pulls at a body at one instant, by the laws of `scenarios.scene`: force and torque, for engines told of both.

An engine with no such laws of its own is given the wrench once a step, as its users give it.  The truth and our solver
have each written the laws anew, in other variables: a mistake here shows as an error against both.
"""

import math
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

try:
    from numba import njit  # pyright: ignore[reportAssignmentType]

    from tumble.kernel_cache import keep  # pyright: ignore[reportAssignmentType]
except ModuleNotFoundError:  # in an environment that an engine has to itself: slower, with the same numbers

    def njit(**_: object) -> Callable:
        """Compile nothing."""
        return lambda function: function

    def keep(compiled: Any, source: Path) -> Any:  # pyright: ignore[reportRedeclaration]
        """Keep nothing on disk."""
        return compiled


from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Scene

Vector = tuple[float, float, float]
Wrench = Callable[[Array], Array]


def wrench(scene: Scene) -> Wrench:
    """Return a compiled function that gives the wrench of a scene's tethers, drag and floor; gravity is left out.

    Parameters
    ----------
    scene

    Returns
    -------
    function
        states (N, 13) -> (N, 6): force [N] and torque about the centre of mass [N m], world axes
    """
    laws = numbers(scene)

    def now(states: Array) -> Array:
        return net_wrenches(states, *laws)

    now(np.array(scene.start))
    return now


def numbers(scene: Scene) -> tuple[Array, Array, Array, Array]:
    """Return the numbers of a scene's force laws, as `net_wrenches` takes them.

    Parameters
    ----------
    scene

    Returns
    -------
    tethers : (T, 9)
    drag : (2,)
    floor : (6,)
    feet : (n, 3)
    """
    tethers = [
        (*each.point_body, *each.anchor, each.stiffness, each.damping, each.rest_length) for each in scene.tethers
    ]
    drag = (scene.drag.linear, scene.drag.angular) if scene.drag else (0.0, 0.0)
    floor, feet = (0.0,) * 6, np.empty((0, 3))
    if scene.floor:
        floor = (*scene.floor.normal, scene.floor.height, scene.floor.stiffness, scene.floor.damping)
        feet = scene.body.points
    return np.array(tethers, dtype=float).reshape(-1, 9), np.array(drag), np.array(floor), np.array(feet)


@partial(keep, source=Path(__file__).parent)
@njit(error_model="numpy")
def net_wrenches(states: Array, tethers: Array, drag: Array, floor: Array, feet: Array) -> Array:
    """Return the sum of all force laws for each state.

    Parameters
    ----------
    states : (N, 13)
    tethers : (T, 9), SI
        point in body axes, anchor, stiffness, damping, rest length
    drag : (2,), SI
        linear, angular
    floor : (6,), SI
        unit normal, height, stiffness, damping
    feet : (n, 3), m
        points that the floor can touch, body axes

    Returns
    -------
    wrenches : (N, 6)
        force [N] and torque [N m], world axes
    """
    wrenches = np.empty((len(states), 6))
    for i in range(len(states)):
        state, total = states[i], wrenches[i]
        for axis in range(3):  # written to a slice, it would compile for three times as long
            total[axis] = -drag[0] * state[7 + axis]
            total[3 + axis] = -drag[1] * state[10 + axis]  # a scalar times w is the same in body and in world axes
        for tether in tethers:
            lever = turned(state, (tether[0], tether[1], tether[2]))
            add(total, lever, tether_force(*motion(state, lever), tether))
        for foot in feet:
            lever = turned(state, (foot[0], foot[1], foot[2]))
            add(total, lever, floor_force(*motion(state, lever), floor))
    return wrenches


@njit(error_model="numpy")
def tether_force(p: Vector, p_dot: Vector, tether: Array) -> Vector:
    """Return F = -k d - c p' where the rest length is 0, else F = -(k (|d| - l0) + c p'.u) u with u = d/|d| [N].

    d = p - anchor [m].  Where d is 0 the line has no direction, and pulls in none.
    """
    d = (p[0] - tether[3], p[1] - tether[4], p[2] - tether[5])
    stiffness, damping, rest_length = tether[6], tether[7], tether[8]
    if rest_length == 0.0:
        return (
            -stiffness * d[0] - damping * p_dot[0],
            -stiffness * d[1] - damping * p_dot[1],
            -stiffness * d[2] - damping * p_dot[2],
        )
    length = math.sqrt(dot(d, d))
    if length == 0.0:
        return 0.0, 0.0, 0.0
    u = (d[0] / length, d[1] / length, d[2] / length)
    tension = stiffness * (length - rest_length) + damping * dot(p_dot, u)
    return -tension * u[0], -tension * u[1], -tension * u[2]


@njit(error_model="numpy")
def floor_force(p: Vector, p_dot: Vector, floor: Array) -> Vector:
    """Return N = max(0, -k y - c y') along the normal for a point at height y < 0, else none [N]."""
    normal, stiffness, damping = (floor[0], floor[1], floor[2]), floor[4], floor[5]
    y = dot(normal, p) - floor[3]
    if y >= 0.0:
        return 0.0, 0.0, 0.0
    push = max(0.0, -stiffness * y - damping * dot(normal, p_dot))
    return push * normal[0], push * normal[1], push * normal[2]


@njit(error_model="numpy")
def motion(state: Array, lever: Vector) -> tuple[Vector, Vector]:
    """Return where the point at that lever is and its velocity, p = x + r and p' = v + w x r."""
    across = cross((state[10], state[11], state[12]), lever)
    return (
        (state[0] + lever[0], state[1] + lever[1], state[2] + lever[2]),
        (state[7] + across[0], state[8] + across[1], state[9] + across[2]),
    )


@njit(error_model="numpy")
def add(total: Array, lever: Vector, force: Vector) -> None:
    """Add a force and its torque r x F to a wrench."""
    torque = cross(lever, force)
    for axis in range(3):
        total[axis] += force[axis]
        total[3 + axis] += torque[axis]


@njit(error_model="numpy")
def turned(state: Array, vector: Vector) -> Vector:
    """Return a vector of body axes in world axes: v + 2 (w n + n x n) x v for q = (w, n).

    Parameters
    ----------
    state : (13,)
    vector : (3,)
        body axes

    Returns
    -------
    vector : (3,)
        world axes
    """
    n = (state[4], state[5], state[6])
    once = cross(n, vector)
    twice = cross(n, once)
    return (
        vector[0] + 2.0 * (state[3] * once[0] + twice[0]),
        vector[1] + 2.0 * (state[3] * once[1] + twice[1]),
        vector[2] + 2.0 * (state[3] * once[2] + twice[2]),
    )


@njit(error_model="numpy")
def cross(a: Vector, b: Vector) -> Vector:
    """Return a x b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@njit(error_model="numpy")
def dot(a: Vector, b: Vector) -> float:
    """Return a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
