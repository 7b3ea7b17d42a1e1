"""Moreau and Jean's time stepping: velocities jump once a step, by impulses in Coulomb's round cone.

A step: half a step of free motion; gravity's impulse, and contact's at the points that would end below the plane,
with u_n >= -e u_n(before) and friction against the slip *after* it; half a step of free motion.  A point's depth that
the velocity does not take out of the plane within the step is taken out by a shift.  Without contact it is exact.
First order: an impact is up to half a step late or early.
Sources: Moreau, "Unilateral contact and dry friction in finite freedom dynamics" (1988); Jean, Comput. Methods Appl.
Mech. Engrg. 177 (1999) 235.
"""

import math

import numpy as np
from numpy.typing import NDArray

from tumble.solver.compilation import inner, kernel
from tumble.solver.contact.approach import turned_freely
from tumble.solver.contact.cone import impulse_in_cone
from tumble.solver.contact.ground import (
    Ground,
    Symmetric,
    applied,
    lever_of,
    momentum_of,
    point_count,
    response,
    spin_of,
    struck,
    velocity_at,
)
from tumble.solver.quaternion import Quaternion
from tumble.solver.vectors import Vector, add, dot, scale

Array = NDArray[np.float64]

# After the state: how many steps Gauss-Seidel did not solve, and the last impulse of every point, with which it begins.
UNSOLVED, IMPULSES = 26, 27
# Of the greatest impulse: what a sweep may still change; and how many sweeps there are.
SOLVED, MOST_SWEEPS = 1e-12, 1000


def moreau_width(ground: Ground) -> int:
    """Return how many numbers a row has."""
    return IMPULSES + 3 * (1 if ground.radius else len(ground.points))


@kernel
def moreau(rows: Array, n: int, dt: float, ground: Ground) -> None:
    """Take n steps.

    Parameters
    ----------
    rows : (N, moreau_width(ground))
        changed in place; plane's frame
    n
    dt : s
    ground
    """
    count = point_count(ground)
    active, levers = np.empty(count, np.int64), np.empty((count, 3))
    targets, responses = np.empty(count), np.empty((count, 6))
    for row in rows:
        x, v = (row[0], row[1], row[2]), (row[7], row[8], row[9])
        q, l_body = (row[3], row[4], row[5], row[6]), (row[10], row[11], row[12])
        for _ in range(n):
            x = add(x, scale(0.5 * dt, v))
            q, l_body = turned_freely(q, l_body, 0.5 * dt, ground)
            w = spin_of(q, l_body, ground)
            fall, touching = 0.5 * dt * dt * ground.gravity[2], 0
            for number in range(count):
                lever = lever_of(q, number, ground)
                rate = velocity_at(v, w, lever)[2]
                at = IMPULSES + 3 * number
                if x[2] + lever[2] + 0.5 * dt * rate + fall <= 0.0:
                    active[touching] = at
                    levers[touching, 0], levers[touching, 1], levers[touching, 2] = lever
                    targets[touching] = -ground.restitution * min(rate, 0.0)
                    W = response(q, lever, ground)
                    for part in range(6):
                        responses[touching, part] = W[part]
                    touching += 1
                else:
                    row[at], row[at + 1], row[at + 2] = 0.0, 0.0, 0.0
            v = add(v, scale(dt, ground.gravity))
            if touching:
                v, w, is_solved = _met(row, q, v, w, active, levers, responses, targets, touching, ground)
                row[UNSOLVED] += 0.0 if is_solved else 1.0
                l_body = momentum_of(q, w, ground)
                x = (x[0], x[1], x[2] + _left_inside(x[2], v, w, levers, touching, dt))
            x = add(x, scale(0.5 * dt, v))
            q, l_body = turned_freely(q, l_body, 0.5 * dt, ground)
        row[0], row[1], row[2] = x
        row[3], row[4], row[5], row[6] = q
        row[7], row[8], row[9] = v
        row[10], row[11], row[12] = l_body


@inner
def _met(
    row: Array,
    q: Quaternion,
    v: Vector,
    w: Vector,
    active: NDArray[np.int64],
    levers: Array,
    responses: Array,
    targets: Array,
    count: int,
    ground: Ground,
) -> tuple[Vector, Vector, bool]:
    """Return velocity and spin after the impulses of all contacts, found by turns, and whether they settled."""
    for each in range(count):
        v, w = struck(q, v, w, _three(levers[each], 0), _three(row, active[each]), ground)
    for _ in range(MOST_SWEEPS):
        changed, largest = 0.0, 0.0
        for each in range(count):
            at = active[each]
            lever, p = _three(levers[each], 0), _three(row, at)
            W = _row_of(responses, each)
            u, own = velocity_at(v, w, lever), applied(W, p)
            # What the point would do without its own impulse, counted from the speed that it has to rise with.
            b = (u[0] - own[0], u[1] - own[1], u[2] - own[2] - targets[each])
            then = impulse_in_cone(W, b, ground.friction)
            change = (then[0] - p[0], then[1] - p[1], then[2] - p[2])
            v, w = struck(q, v, w, lever, change, ground)
            row[at], row[at + 1], row[at + 2] = then
            changed, largest = max(changed, math.sqrt(dot(change, change))), max(largest, math.sqrt(dot(then, then)))
        if count == 1 or changed <= SOLVED * largest:
            return v, w, True
    return v, w, False


@inner
def _three(row: Array, at: int) -> Vector:
    return row[at], row[at + 1], row[at + 2]


@inner
def _row_of(responses: Array, each: int) -> Symmetric:
    return (
        responses[each, 0],
        responses[each, 1],
        responses[each, 2],
        responses[each, 3],
        responses[each, 4],
        responses[each, 5],
    )


@inner
def _left_inside(z: float, v: Vector, w: Vector, levers: Array, count: int, dt: float) -> float:
    """Return how far the deepest point would still be below the plane at the end of the step [m]."""
    deepest = 0.0
    for each in range(count):
        lever = _three(levers[each], 0)
        left = -(z + lever[2]) - 0.5 * dt * max(velocity_at(v, w, lever)[2], 0.0)
        deepest = max(deepest, left)
    return deepest
