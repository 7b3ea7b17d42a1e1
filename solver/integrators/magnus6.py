"""Magnus's series of sixth order along a Taylor series of the angular momentum: one exponential a step."""

import math

import numpy as np
from numpy.typing import NDArray

from tumble.solver.compilation import inner, kernel
from tumble.solver.quaternion import Quaternion, exponential, product, steady_turn
from tumble.solver.spins import load, store
from tumble.solver.vectors import Vector, add, cross, scale, times

# Gauss's nodes in [0, 1]; the middle one is 1/2.
EARLY, LATE = (1 - math.sqrt(3 / 5)) / 2, (1 + math.sqrt(3 / 5)) / 2

Series = tuple[float, float, float, float, float, float, float, float, float]


@inner
def _momentum_series(momentum: Vector, step_gyroscopic: Vector) -> tuple[Series, Series, Series]:
    """Return the coefficients of (t/dt)^n in the components of L_body, n = 0 ... 8, for dL/dt = L x w.

    Written out, for a loop takes half as long again.  Eight: where dt is so long that L is off, Magnus's series is too.
    step_gyroscopic: dt times `tumble.solver.body.Body.gyroscopic`.  Source: Cauchy products; Jorba & Zou, "A software
    package for the numerical integration of ODEs by means of high-order Taylor methods" (2005), section 2.
    """
    x0, y0, z0 = momentum
    a, b, c = step_gyroscopic
    x1 = a * (y0 * z0)
    y1 = b * (z0 * x0)
    z1 = c * (x0 * y0)
    x2 = a / 2 * (y0 * z1 + y1 * z0)
    y2 = b / 2 * (z0 * x1 + z1 * x0)
    z2 = c / 2 * (x0 * y1 + x1 * y0)
    x3 = a / 3 * (y0 * z2 + y1 * z1 + y2 * z0)
    y3 = b / 3 * (z0 * x2 + z1 * x1 + z2 * x0)
    z3 = c / 3 * (x0 * y2 + x1 * y1 + x2 * y0)
    x4 = a / 4 * (y0 * z3 + y1 * z2 + y2 * z1 + y3 * z0)
    y4 = b / 4 * (z0 * x3 + z1 * x2 + z2 * x1 + z3 * x0)
    z4 = c / 4 * (x0 * y3 + x1 * y2 + x2 * y1 + x3 * y0)
    x5 = a / 5 * (y0 * z4 + y1 * z3 + y2 * z2 + y3 * z1 + y4 * z0)
    y5 = b / 5 * (z0 * x4 + z1 * x3 + z2 * x2 + z3 * x1 + z4 * x0)
    z5 = c / 5 * (x0 * y4 + x1 * y3 + x2 * y2 + x3 * y1 + x4 * y0)
    x6 = a / 6 * (y0 * z5 + y1 * z4 + y2 * z3 + y3 * z2 + y4 * z1 + y5 * z0)
    y6 = b / 6 * (z0 * x5 + z1 * x4 + z2 * x3 + z3 * x2 + z4 * x1 + z5 * x0)
    z6 = c / 6 * (x0 * y5 + x1 * y4 + x2 * y3 + x3 * y2 + x4 * y1 + x5 * y0)
    x7 = a / 7 * (y0 * z6 + y1 * z5 + y2 * z4 + y3 * z3 + y4 * z2 + y5 * z1 + y6 * z0)
    y7 = b / 7 * (z0 * x6 + z1 * x5 + z2 * x4 + z3 * x3 + z4 * x2 + z5 * x1 + z6 * x0)
    z7 = c / 7 * (x0 * y6 + x1 * y5 + x2 * y4 + x3 * y3 + x4 * y2 + x5 * y1 + x6 * y0)
    x8 = a / 8 * (y0 * z7 + y1 * z6 + y2 * z5 + y3 * z4 + y4 * z3 + y5 * z2 + y6 * z1 + y7 * z0)
    y8 = b / 8 * (z0 * x7 + z1 * x6 + z2 * x5 + z3 * x4 + z4 * x3 + z5 * x2 + z6 * x1 + z7 * x0)
    z8 = c / 8 * (x0 * y7 + x1 * y6 + x2 * y5 + x3 * y4 + x4 * y3 + x5 * y2 + x6 * y1 + x7 * y0)
    return (
        (x0, x1, x2, x3, x4, x5, x6, x7, x8),
        (y0, y1, y2, y3, y4, y5, y6, y7, y8),
        (z0, z1, z2, z3, z4, z5, z6, z7, z8),
    )


@inner
def _at(t: float, s: Series) -> float:
    """Return a series at t, in units of the step."""
    t2 = t * t
    even = s[0] + t2 * (s[2] + t2 * (s[4] + t2 * (s[6] + t2 * s[8])))
    return even + t * (s[1] + t2 * (s[3] + t2 * (s[5] + t2 * s[7])))


@inner
def _after(s: Series) -> float:
    """Return a series at the end of the step, the least terms first."""
    return s[0] + (s[1] + (s[2] + (s[3] + (s[4] + (s[5] + (s[6] + (s[7] + s[8])))))))


@inner
def turn_of(early: Vector, middle: Vector, late: Vector) -> Quaternion:
    """Return exp(Omega~/2), the turn of a step, from dt w_body at the three nodes.

    Source: Blanes, Casas, Oteo & Ros, "The Magnus expansion and some of its applications" (2009), eqs. 257-258; every
    commutator is a cross product, with its sign changed, for w_body multiplies on the right.
    """
    a2 = scale(math.sqrt(15) / 3, add(late, scale(-1.0, early)))
    a3 = scale(10 / 3, add(add(early, late), scale(-2.0, middle)))
    c1 = cross(a2, middle)
    c2 = scale(1.0 / 60.0, cross(middle, add(scale(2.0, a3), c1)))
    outer = cross(add(a2, c2), add(scale(-20.0, middle), add(scale(-1.0, a3), c1)))
    return exponential(scale(0.5, add(middle, add(scale(1.0 / 12.0, a3), scale(1.0 / 240.0, outer)))))


@kernel
def magnus6(spins: NDArray[np.float64], n: int, dt: float, inverse_moments: Vector, gyroscopic: Vector | None) -> None:
    """Take n steps of q = q exp(Omega~/2), with L_body by its Taylor series and Omega from w at three Gauss nodes.

    spins: q, then L in body axes, (N, 7).
    Source: Blanes, Casas & Ros, "Improved high order integrators based on the Magnus expansion" (2000); order 6.
    """
    step = scale(dt, inverse_moments)
    for spin in spins:
        q, momentum = load(spin)
        if gyroscopic is None:
            q = steady_turn(q, scale(0.5, times(step, momentum)), n)
        else:
            for _ in range(n):
                x, y, z = _momentum_series(momentum, scale(dt, gyroscopic))
                early = times(step, (_at(EARLY, x), _at(EARLY, y), _at(EARLY, z)))
                middle = times(step, (_at(0.5, x), _at(0.5, y), _at(0.5, z)))
                late = times(step, (_at(LATE, x), _at(LATE, y), _at(LATE, z)))
                q = product(q, turn_of(early, middle, late))
                momentum = (_after(x), _after(y), _after(z))
        store(spin, q, momentum)
