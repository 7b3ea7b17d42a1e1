"""The impulse of one contact in Coulomb's round cone, solved exactly, and of several by turns.

    u = W p + b,   u_n >= 0, p_n >= 0, u_n p_n = 0,   |p_t| <= mu p_n,   p_t = -mu p_n u_t / |u_t| where u_t is not 0.

Source: Acary & Brogliato, "Numerical Methods for Nonsmooth Dynamical Systems" (2008), section 13.4 (nonlinear
Gauss-Seidel) and 3.9 (the law).
"""

import math

import numpy as np
from numpy.typing import NDArray

from tumble.solver.compilation import inner
from tumble.solver.contact.ground import Ground, Symmetric, applied, response, solved, struck, velocity_at
from tumble.solver.quaternion import Quaternion
from tumble.solver.vectors import Vector, dot, scale

Array = NDArray[np.float64]

MOST_HALVINGS, MOST_SWEEPS = 100, 1000
# What of a contact stands in a row: its impulse, lever, response, and the speed that it is to rise with.
IMPULSE, LEVER, RESPONSE, RISES, CONTACT = 0, 3, 6, 12, 13


@inner
def impulse_in_cone(W: Symmetric, b: Vector, friction: float) -> Vector:
    """Return p [N s]: none where the point leaves, what makes it stick where the cone has that, else on the cone."""
    if b[2] >= 0.0:
        return (0.0, 0.0, 0.0)
    if friction == 0.0:
        return (0.0, 0.0, -b[2] / W[2])
    stick = scale(-1.0, solved(W, b))
    if stick[2] >= 0.0 and math.hypot(stick[0], stick[1]) <= friction * stick[2]:
        return stick
    return _slipping(W, b, friction)


@inner
def _slipping(W: Symmetric, b: Vector, friction: float) -> Vector:
    """Return p on the cone, against the slip: p_t of (M + l) p_t = -c with the l > 0 that makes |p_t| = mu p_n.

    M and c are W and b along the plane once p_n has been taken out of them.
    """
    xx, yy, zz, xy, xz, yz = W
    low, high = 0.0, xx + yy
    M = (xx - xz * xz / zz, yy - yz * yz / zz, xy - xz * yz / zz)
    c = (b[0] - xz * b[2] / zz, b[1] - yz * b[2] / zz)
    while _beyond(M, c, W, b, high, friction)[0] > 0.0:
        low, high = high, 4.0 * high
        if not math.isfinite(high):
            return (0.0, 0.0, -b[2] / zz)
    at_low, at_high = _beyond(M, c, W, b, low, friction)[0], _beyond(M, c, W, b, high, friction)[0]
    rate = high
    for _ in range(MOST_HALVINGS):
        rate = high - at_high * (high - low) / (at_high - at_low)
        if not low < rate < high:
            rate = 0.5 * (low + high)
        value = _beyond(M, c, W, b, rate, friction)[0]
        if value > 0.0:
            low, at_low, at_high = rate, value, 0.5 * at_high
        else:
            high, at_high, at_low = rate, value, 0.5 * at_low
        if value == 0.0 or high - low <= 1e-15 * high:
            break
    return _beyond(M, c, W, b, rate, friction)[1]


@inner
def _beyond(
    M: tuple[float, float, float], c: tuple[float, float], W: Symmetric, b: Vector, rate: float, friction: float
) -> tuple[float, Vector]:
    """Return how far p is outside of the cone for one l, and p."""
    a, d, off = M[0] + rate, M[1] + rate, M[2]
    determinant = a * d - off * off
    x, y = (off * c[1] - d * c[0]) / determinant, (off * c[0] - a * c[1]) / determinant
    z = -(b[2] + W[4] * x + W[5] * y) / W[2]
    return math.hypot(x, y) - friction * z, (x, y, z)


@inner
def set_contact(contact: Array, q: Quaternion, lever: Vector, rises: float, ground: Ground) -> None:
    """Write a contact into a row, (CONTACT,), without an impulse; rises: its least speed afterwards [m/s]."""
    W = response(q, lever, ground)
    for part in range(3):
        contact[IMPULSE + part], contact[LEVER + part] = 0.0, lever[part]
    for part in range(6):
        contact[RESPONSE + part] = W[part]
    contact[RISES] = rises


@inner
def lever_in(contact: Array) -> Vector:
    """Return the lever of a contact [m]."""
    return contact[LEVER], contact[LEVER + 1], contact[LEVER + 2]


@inner
def _impulse_in(contact: Array) -> Vector:
    return contact[IMPULSE], contact[IMPULSE + 1], contact[IMPULSE + 2]


@inner
def by_turns(
    q: Quaternion, v: Vector, w: Vector, contacts: Array, within: float, ground: Ground
) -> tuple[Vector, Vector, bool]:
    """Return velocity and spin after the impulses of all contacts, found by turns, and whether they settled.

    contacts: (n, CONTACT), with the impulses to begin with, which are replaced by those found.
    within: of the largest impulse, what the last sweep may have changed.
    """
    for contact in contacts:
        v, w = struck(q, v, w, lever_in(contact), _impulse_in(contact), ground)
    for _ in range(MOST_SWEEPS):
        changed, largest = 0.0, 0.0
        for contact in contacts:
            lever, p, at = lever_in(contact), _impulse_in(contact), RESPONSE
            W = (contact[at], contact[at + 1], contact[at + 2], contact[at + 3], contact[at + 4], contact[at + 5])
            u, own = velocity_at(v, w, lever), applied(W, p)
            # What the point would do without its own impulse, counted from the speed that it has to rise with.
            b = (u[0] - own[0], u[1] - own[1], u[2] - own[2] - contact[RISES])
            then = impulse_in_cone(W, b, ground.friction)
            change = (then[0] - p[0], then[1] - p[1], then[2] - p[2])
            v, w = struck(q, v, w, lever, change, ground)
            contact[IMPULSE], contact[IMPULSE + 1], contact[IMPULSE + 2] = then
            changed, largest = max(changed, math.sqrt(dot(change, change))), max(largest, math.sqrt(dot(then, then)))
        if len(contacts) == 1 or changed <= within * largest:
            return v, w, True
    return v, w, False
