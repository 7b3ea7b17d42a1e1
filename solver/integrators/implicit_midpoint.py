"""The implicit midpoint rule on the angular momentum, with Cayley's turn."""

import math

import numpy as np
from numpy.typing import NDArray

from tumble.solver.body import momentum_rate, momentum_resolved
from tumble.solver.compilation import inner, kernel
from tumble.solver.quaternion import Quaternion, normalise, product
from tumble.solver.spins import load, store
from tumble.solver.vectors import Vector, add, dot, scale, times

# Newton's correction falls quadratically: one of this size, relative to L, was the last that doubles can see.
SMALL = 1e-10
ITERATIONS = 20
# The furthest that the midpoint is followed at once, relative to L, and how often that is tried.
FURTHEST, MOST_TRIALS = 0.2, 1000


@inner
def _newton(start: Vector, half_gyroscopic: Vector, near: Vector) -> tuple[Vector, bool]:
    """Return the L that solves L = start + dt/2 L x w, by Newton's method, and whether that converged.

    half_gyroscopic: dt/2 times `tumble.solver.body.Body.gyroscopic`.  near: where to begin.
    """
    x, y, z = middle = near
    for _ in range(ITERATIONS):
        rate = momentum_rate(middle, half_gyroscopic)
        missing = (start[0] + rate[0] - x, start[1] + rate[1] - y, start[2] + rate[2] - z)
        correction = momentum_resolved(middle, half_gyroscopic, missing)
        x, y, z = middle = add(middle, correction)
        if dot(correction, correction) <= SMALL * SMALL * dot(middle, middle):
            return middle, True
    return middle, False


@inner
def _followed(start: Vector, half_gyroscopic: Vector) -> Vector:
    """Return the same L, followed from dt = 0, where it is start, as dt grows; nan where it is lost.

    Every midpoint is on a sphere whose diameter is start, so it cannot go to infinity on the way.
    Source: Allgower & Georg, "Numerical Continuation Methods" (1990), section 2.1, with the trivial predictor.
    """
    middle, done, part = start, 0.0, 1.0
    for _ in range(MOST_TRIALS if math.isfinite(dot(start, start)) else 0):
        further = min(done + part, 1.0)
        then, found = _newton(start, scale(further, half_gyroscopic), middle)
        change = add(then, scale(-1.0, middle))
        if found and dot(change, change) <= FURTHEST * FURTHEST * dot(start, start):
            middle, done, part = then, further, 2.0 * part
            if done == 1.0:
                return middle
        else:
            part /= 2.0
    return (math.nan, math.nan, math.nan)


@inner
def _after(q: Quaternion, momentum: Vector, middle: Vector, half_step: Vector) -> tuple[Quaternion, Vector]:
    """Return q and L after a step in whose middle L is middle."""
    half_turn = times(half_step, middle)
    q = normalise(product(q, (1.0, half_turn[0], half_turn[1], half_turn[2])))
    return q, add(scale(2.0, middle), scale(-1.0, momentum))


@inner
def _easy_steps(
    q: Quaternion, momentum: Vector, n: int, half_step: Vector, half_gyroscopic: Vector
) -> tuple[Quaternion, Vector, int]:
    """Return q and L after the first of n steps, to where Newton's method does not converge, and how many are left."""
    for step in range(n):
        near = add(momentum, momentum_rate(momentum, half_gyroscopic))
        middle, found = _newton(momentum, half_gyroscopic, near)
        if not found:
            return q, momentum, n - step
        q, momentum = _after(q, momentum, middle, half_step)
    return q, momentum, 0


@kernel
def implicit_midpoint(
    spins: NDArray[np.float64], n: int, dt: float, inverse_moments: Vector, gyroscopic: Vector | None
) -> None:
    """Take n steps of L += dt M x w(M) with M = (L + L')/2, and q = q cay(dt w(M)).

    spins: q, then L in body axes, (N, 7).
    Midpoints keep every quadratic: |L| and the energy.  Cayley's turn, by 2 arctan(|w| dt/2), is the very one by which
    L turns in the body, so L in the world is kept too.  All that at any step, for there always is a midpoint: only what
    overflows becomes nan.  Steps of some radians have several, and a flight that is turned round may find another.
    Source: Austin, Krishnaprasad & Wang, "Almost Poisson integration of rigid body systems" (1993); Hairer, Lubich &
    Wanner, "Geometric Numerical Integration" (2006), sections IV.2.1 and VII.5; order 2.
    """
    half_step = scale(dt / 2.0, inverse_moments)
    for spin in spins:
        q, momentum = load(spin)
        if gyroscopic is None:
            for _ in range(n):
                q, _ = _after(q, momentum, momentum, half_step)
        else:
            half_gyroscopic, left = scale(dt / 2.0, gyroscopic), n
            while left > 0:
                q, momentum, left = _easy_steps(q, momentum, left, half_step, half_gyroscopic)
                if left > 0:
                    q, momentum = _after(q, momentum, _followed(momentum, half_gyroscopic), half_step)
                    left -= 1
        store(spin, q, momentum)
