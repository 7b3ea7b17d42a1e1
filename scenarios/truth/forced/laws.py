"""The equations of motion and the force laws, written down as operations on series.

The body is told by its centre of mass x, its velocity v, the file's axes as the columns of a matrix, and its angular
momentum L along those axes: `SIZE` numbers.  Vectors are arrays of `Expression`, and every coefficient is a fraction.
A force is a function here, a field of `Throw` and a line of `pull`.
"""

from typing import NamedTuple

import numpy as np

from tumble.scenarios.truth.forced.series import Expression, Program, Script
from tumble.scenarios.truth.inertia import Numbers, inverse
from tumble.scenarios.truth.rational import cross
from tumble.scenarios.truth.throw import Ground, Spring, Throw

# Where the numbers of a state stand: x, v, the matrix of the axes row by row, L.
X, V, AXES, MOMENTUM, SIZE = 0, 3, 6, 15, 18

Vector = np.ndarray


class Motion(NamedTuple):
    """x [m] and v [m/s], world; axes and axes', (3, 3); L [kg m2/s] and w [rad/s], file axes."""

    x: Vector
    v: Vector
    axes: np.ndarray
    axes_rate: np.ndarray
    L: Vector
    w: Vector


class Pull(NamedTuple):
    """Force [N], world axes, and torque about the centre of mass [N m], file axes."""

    force: Vector
    torque: Vector


class Equations(NamedTuple):
    """The program, and the series of each vertex's height above the floor [m] and of its thrust [N], (n, 2)."""

    program: Program
    gauges: np.ndarray


def equations(throw: Throw, pressing: np.ndarray) -> Equations:
    """Return the equations of motion: x' = v, m v' = F, axes' = axes [w], L' = L x w + torque.

    pressing: which vertices the floor pushes, (n,).  Source: Goldstein, "Classical Mechanics" (1980), eqs. 1-24, 5-39.
    """
    script = Script(SIZE)
    motion = motion_of(script.state(), inverse(throw.solid.tensor))
    gauges = floor_gauges(throw, motion)
    force, torque = pull(throw, motion, gauges, pressing)
    rates = np.concatenate(
        (
            motion.v,
            force / throw.solid.mass + throw.gravity,
            motion.axes_rate.ravel(),
            cross(motion.L, motion.w) + torque,
        )
    )
    rows = np.array([[script.row(value) for value in gauge] for gauge in gauges], dtype=np.int64).reshape(-1, 2)
    return Equations(script.program(list(rates)), rows)


def motion_of(state: Vector, inverse_tensor: Numbers) -> Motion:
    """Return what a state (SIZE,) says."""
    axes, L = state[AXES:MOMENTUM].reshape(3, 3), state[MOMENTUM:]
    w = inverse_tensor @ L
    # A point p of the body moves by axes' p = axes (w x p): each row of the axes by row x w.
    axes_rate = np.stack([cross(row, w) for row in axes])
    return Motion(state[X:V], state[V:AXES], axes, axes_rate, L, w)


def pull(throw: Throw, motion: Motion, gauges: list, pressing: np.ndarray) -> Pull:
    """Return the sum of all forces but gravity and of their torques."""
    pulls = [tether_pull(spring, motion) for spring in throw.springs]
    if throw.drag is not None:
        pulls.append(drag_pull(throw.drag, motion))
    if throw.ground is not None:
        pulls.append(floor_push(throw.ground, throw.points, motion, gauges, pressing))
    nothing = Pull(0 * motion.v, 0 * motion.L)
    return Pull(
        sum((each.force for each in pulls), nothing.force), sum((each.torque for each in pulls), nothing.torque)
    )


def tether_pull(spring: Spring, motion: Motion) -> Pull:
    """Return F = -k d - c p', or with a rest length along the line only: F = -(k (|d| - l0) + c d'.u) u, u = d/|d|."""
    stiffness, damping, rest_length = spring.strength
    d = motion.x + motion.axes @ spring.point - spring.anchor
    d_rate = motion.v + motion.axes_rate @ spring.point
    if not rest_length:
        return acting_at(spring.point, -(stiffness * d + damping * d_rate), motion)
    length = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt()
    u = d / length
    return acting_at(spring.point, u * -(stiffness * (length - rest_length) + damping * (d_rate @ u)), motion)


def acting_at(point: Numbers, force: Vector, motion: Motion) -> Pull:
    """Return a force on a point of the body, (3,)."""
    return Pull(force, cross(point, motion.axes.T @ force))


def drag_pull(drag: Numbers, motion: Motion) -> Pull:
    """Return F = -linear v and torque = -angular w."""
    return Pull(-drag[0] * motion.v, -drag[1] * motion.w)


def floor_gauges(throw: Throw, motion: Motion) -> list[tuple[Expression, Expression]]:
    """Return each vertex's height y above the floor and its thrust N = -k y - c y'; none without a floor."""
    if throw.ground is None:
        return []
    normal, (height, stiffness, damping) = throw.ground
    up, up_rate = normal @ motion.axes, normal @ motion.axes_rate
    heights = [normal @ motion.x + up @ point - height for point in throw.points]
    speeds = [normal @ motion.v + up_rate @ point for point in throw.points]
    return [(y, -(stiffness * y + damping * rate)) for y, rate in zip(heights, speeds, strict=True)]


def floor_push(ground: Ground, points: Numbers, motion: Motion, gauges: list, pressing: np.ndarray) -> Pull:
    """Return the sum over the vertices that the floor pushes of N n.

    Which they are, y < 0 and N > 0, is not asked here: between two switches the law has no corner.
    """
    pushed = np.flatnonzero(pressing)
    if not len(pushed):
        return Pull(0 * motion.v, 0 * motion.L)
    thrusts = [gauges[vertex][1] for vertex in pushed]
    arm = thrusts @ points[pushed]
    return Pull(ground.normal * np.sum(thrusts), cross(arm, ground.normal @ motion.axes))
