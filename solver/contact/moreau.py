"""Moreau and Jean's time stepping: velocities jump once a step, by impulses in Coulomb's round cone.

A step: half a step of free motion; gravity's impulse, and at the points that are then at or below the plane contact's,
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
    lever_of,
    momentum_of,
    point_count,
    response,
    spin_of,
    struck,
    velocity_at,
)
from tumble.solver.vectors import Vector, add, scale

Array = NDArray[np.float64]

# After the state: how many steps Gauss-Seidel did not solve.
UNSOLVED, MOREAU_WIDTH = 26, 27
# Of the greatest velocity of a point: what a sweep may still change; and how many sweeps there are.
SOLVED, MOST_SWEEPS = 1e-13, 2000


@kernel
def moreau(rows: Array, n: int, dt: float, ground: Ground) -> None:
    """Take n steps.

    Parameters
    ----------
    rows : (N, MOREAU_WIDTH)
        changed in place; plane's frame
    n
    dt : s
    ground
    """
    count = point_count(ground)
    active, levers, impulses = np.empty(count, np.int64), np.empty((count, 3)), np.empty((count, 3))
    targets, responses = np.empty(count), np.empty((count, 6))
    for row in rows:
        x, v = (row[0], row[1], row[2]), (row[7], row[8], row[9])
        q, l_body = (row[3], row[4], row[5], row[6]), (row[10], row[11], row[12])
        for _ in range(n):
            x = add(x, scale(0.5 * dt, v))
            q, l_body = turned_freely(q, l_body, 0.5 * dt, ground)
            w = spin_of(q, l_body, ground)
            touching = 0
            for number in range(count):
                lever = lever_of(q, number, ground)
                if x[2] + lever[2] <= 0.0:
                    active[touching] = number
                    levers[touching, 0], levers[touching, 1], levers[touching, 2] = lever
                    targets[touching] = -ground.restitution * min(velocity_at(v, w, lever)[2], 0.0)
                    W = response(q, lever, ground)
                    for part in range(6):
                        responses[touching, part] = W[part]
                    impulses[touching, 0], impulses[touching, 1], impulses[touching, 2] = 0.0, 0.0, 0.0
                    touching += 1
            v = add(v, scale(dt, ground.gravity))
            if touching:
                v, w, is_solved = _met(q, v, w, levers, responses, targets, impulses, touching, ground)
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
    q: tuple[float, float, float, float],
    v: Vector,
    w: Vector,
    levers: Array,
    responses: Array,
    targets: Array,
    impulses: Array,
    count: int,
    ground: Ground,
) -> tuple[Vector, Vector, bool]:
    """Return velocity and spin after the impulses of all contacts, found by turns, and whether they settled."""
    for _ in range(MOST_SWEEPS):
        changed, fastest = 0.0, 0.0
        for each in range(count):
            lever = (levers[each, 0], levers[each, 1], levers[each, 2])
            W = (
                responses[each, 0],
                responses[each, 1],
                responses[each, 2],
                responses[each, 3],
                responses[each, 4],
                responses[each, 5],
            )
            p = (impulses[each, 0], impulses[each, 1], impulses[each, 2])
            u = velocity_at(v, w, lever)
            # What the point would do without its own impulse, counted from the speed that it has to rise with.
            own = (
                W[0] * p[0] + W[3] * p[1] + W[4] * p[2],
                W[3] * p[0] + W[1] * p[1] + W[5] * p[2],
                W[4] * p[0] + W[5] * p[1] + W[2] * p[2],
            )
            b = (u[0] - own[0], u[1] - own[1], u[2] - own[2] - targets[each])
            then = impulse_in_cone(W, b, ground.friction)
            change = (then[0] - p[0], then[1] - p[1], then[2] - p[2])
            v, w = struck(q, v, w, lever, change, ground)
            impulses[each, 0], impulses[each, 1], impulses[each, 2] = then
            size = math.sqrt(change[0] * change[0] + change[1] * change[1] + change[2] * change[2])
            whole = math.sqrt(then[0] * then[0] + then[1] * then[1] + then[2] * then[2])
            changed, fastest = max(changed, size), max(fastest, whole)
        if count == 1 or changed <= SOLVED * fastest:
            return v, w, True
    return v, w, False


@inner
def _left_inside(z: float, v: Vector, w: Vector, levers: Array, count: int, dt: float) -> float:
    """Return how far the deepest point would still be below the plane at the end of the step [m]."""
    deepest = 0.0
    for each in range(count):
        lever = (levers[each, 0], levers[each, 1], levers[each, 2])
        left = -(z + lever[2]) - 0.5 * dt * max(velocity_at(v, w, lever)[2], 0.0)
        deepest = max(deepest, left)
    return deepest
