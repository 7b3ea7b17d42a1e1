"""The implicit midpoint rule on the angular momentum, with Cayley's turn."""

import math

import numpy as np
from numpy.typing import NDArray

from solver.body import momentum_rate
from solver.compilation import inner, kernel
from solver.quaternion import normalise, product
from solver.spins import load, store
from solver.vectors import Vector, add, cross, dot, scale, times

# Newton's correction falls quadratically: one of this size, relative to L, was the last that doubles can see.
SMALL = 1e-10
ITERATIONS = 20


@inner
def _solved(row1: Vector, row2: Vector, row3: Vector, right: Vector) -> Vector:
    """Return the solution of three linear equations by Cramer's rule."""
    minor1, minor2, minor3 = cross(row2, row3), cross(row3, row1), cross(row1, row2)
    sum_of_minors = add(scale(right[0], minor1), add(scale(right[1], minor2), scale(right[2], minor3)))
    return scale(1.0 / dot(row1, minor1), sum_of_minors)


@inner
def _midpoint(start: Vector, half_gyroscopic: Vector) -> Vector:
    """Return the L that solves L = start + dt/2 L x w, by Newton's method; nan where that does not converge.

    half_gyroscopic: dt/2 times `solver.body.Body.gyroscopic`.
    """
    x, y, z = middle = add(start, momentum_rate(start, half_gyroscopic))
    a, b, c = half_gyroscopic
    for _ in range(ITERATIONS):
        rate = momentum_rate(middle, half_gyroscopic)
        missing = (start[0] + rate[0] - x, start[1] + rate[1] - y, start[2] + rate[2] - z)
        correction = _solved((1.0, -a * z, -a * y), (-b * z, 1.0, -b * x), (-c * y, -c * x, 1.0), missing)
        x, y, z = middle = add(middle, correction)
        if dot(correction, correction) <= SMALL * SMALL * dot(middle, middle):
            return middle
    return (math.nan, math.nan, math.nan)


@kernel
def implicit_midpoint(
    spins: NDArray[np.float64], n: int, dt: float, inverse_moments: Vector, gyroscopic: Vector | None
) -> None:
    """Take n steps of L += dt M x w(M) with M = (L + L')/2, and q = q cay(dt w(M)).

    spins: q, then L in body axes, (N, 7).
    Midpoints keep every quadratic: |L| and the energy.  Cayley's turn, by 2 arctan(|w| dt/2), is the very one by which
    L turns in the body, so L in the world is kept too.  Where Newton's method finds no midpoint the state becomes nan.
    Source: Austin, Krishnaprasad & Wang, "Almost Poisson integration of rigid body systems" (1993); Hairer, Lubich &
    Wanner, "Geometric Numerical Integration" (2006), sections IV.2.1 and VII.5; order 2.
    """
    half_step = scale(dt / 2.0, inverse_moments)
    for spin in spins:
        q, momentum = load(spin)
        middle = momentum
        for _ in range(n):
            if gyroscopic is not None:
                middle = _midpoint(momentum, scale(dt / 2.0, gyroscopic))
                momentum = add(scale(2.0, middle), scale(-1.0, momentum))
            half_turn = times(half_step, middle)
            q = normalise(product(q, (1.0, half_turn[0], half_turn[1], half_turn[2])))
        store(spin, q, momentum)
