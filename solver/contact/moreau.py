"""Moreau and Jean's time stepping: velocities jump once a step, by impulses in Coulomb's round cone.

A step: half a step of free motion; gravity's impulse, and contact's at the points that would end below the plane,
with u_n >= -e u_n(before) and friction against the slip *after* it; half a step of free motion.  A point's depth that
the velocity does not take out of the plane within the step is taken out by a shift.  Without contact it is exact.
First order: an impact is up to half a step late or early.
Sources: Moreau, "Unilateral contact and dry friction in finite freedom dynamics" (1988); Jean, Comput. Methods Appl.
Mech. Engrg. 177 (1999) 235.
"""

import numpy as np
from numpy.typing import NDArray

from tumble.solver.compilation import inner, kernel
from tumble.solver.contact.approach import turned_freely
from tumble.solver.contact.cone import CONTACT, by_turns, lever_in, set_contact
from tumble.solver.contact.ground import (
    QUARTERS,
    Ground,
    lever_of,
    momentum_of,
    point_count,
    spin_of,
    velocity_at,
)
from tumble.solver.vectors import Vector, add, scale

Array = NDArray[np.float64]

# After the state: how many steps Gauss-Seidel did not solve, and the last impulse of every point, with which it begins.
UNSOLVED, IMPULSES = 26, 27
# Of the greatest impulse: what a sweep may still change.
SOLVED = 1e-12


def moreau_width(ground: Ground) -> int:
    """Return how many numbers a row has."""
    rims = 0 if not ground.rim else 2 if ground.half else 1
    return IMPULSES + 3 * (1 if ground.radius else QUARTERS * rims or len(ground.points))


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
    active, contacts = np.empty(count, np.int64), np.empty((count, CONTACT))
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
                    set_contact(contacts[touching], q, lever, -ground.restitution * min(rate, 0.0), ground)
                    for part in range(3):
                        contacts[touching, part] = row[at + part]
                    touching += 1
                else:
                    row[at], row[at + 1], row[at + 2] = 0.0, 0.0, 0.0
            v = add(v, scale(dt, ground.gravity))
            if touching:
                v, w, is_solved = by_turns(q, v, w, contacts[:touching], SOLVED, ground)
                row[UNSOLVED] += 0.0 if is_solved else 1.0
                for each in range(touching):
                    for part in range(3):
                        row[active[each] + part] = contacts[each, part]
                l_body = momentum_of(q, w, ground)
                x = (x[0], x[1], x[2] + _left_inside(x[2], v, w, contacts[:touching], dt))
            x = add(x, scale(0.5 * dt, v))
            q, l_body = turned_freely(q, l_body, 0.5 * dt, ground)
        row[0], row[1], row[2] = x
        row[3], row[4], row[5], row[6] = q
        row[7], row[8], row[9] = v
        row[10], row[11], row[12] = l_body


@inner
def _left_inside(z: float, v: Vector, w: Vector, contacts: Array, dt: float) -> float:
    """Return how far the deepest point would still be below the plane at the end of the step [m]."""
    deepest = 0.0
    for contact in contacts:
        lever = lever_in(contact)
        left = -(z + lever[2]) - 0.5 * dt * max(velocity_at(v, w, lever)[2], 0.0)
        deepest = max(deepest, left)
    return deepest
