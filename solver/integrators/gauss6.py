"""Gauss's collocation in three stages, with forces averaged so that energy is kept: stable at any step."""

import numpy as np
from numpy.typing import NDArray

from tumble.solver.collocation.scheme import scheme
from tumble.solver.collocation.steps import integrate
from tumble.solver.collocation.turning import turn
from tumble.solver.forces import Forces
from tumble.solver.vectors import Vector


def _gauss(count: int) -> NDArray[np.float64]:
    """Return Gauss's nodes in [0, 1]."""
    return (1.0 + np.polynomial.legendre.leggauss(count)[0]) / 2.0


# Eight instants: their means are right up to the fifteenth degree, of which a linear spring's power has five, and with
# two degrees more they still see where power is no smooth curve.
GAUSS = scheme(stages=_gauss(3), instants=_gauss(8))


def gauss6(spins: NDArray[np.float64], n: int, dt: float, inverse_moments: Vector, gyroscopic: Vector | None) -> None:
    """Take n steps of dq/dt = q w~/2 and dL/dt = L x w, with w = I0^-1 L, all in body axes.

    spins: q, then L in body axes, (N, 7).
    Collocation at Gauss's nodes keeps every quadratic: |q|, |L| and the energy, but not L in the world, a cubic of q
    and L.  It is stable for every |w| dt; a step that turns the body by more than a radian is taken in parts, and where
    2^14 are not enough the state becomes nan.  Where no step is parted it is reversible; else the way back may be
    parted elsewhere.
    Source: Butcher (1964); Hairer, Lubich & Wanner, "Geometric Numerical Integration" (2006), section II.1.3 and
    theorem IV.2.2; order 6.
    """
    turn(spins, n, dt, GAUSS, inverse_moments, gyroscopic)


def gauss6_forced(
    rows: NDArray[np.float64],
    n: int,
    dt: float,
    moments: Vector,
    inverse_moments: Vector | None,
    gyroscopic: Vector | None,
    forces: Forces,
) -> None:
    """Take n steps of the equations of motion, `tumble.solver.motion.slope`.

    rows: x, q, v, L in body axes and the count of steps that were not found, (N, 14).
    The force of a stage is a mean over the step: where forces have a potential the energy is kept, to the quadrature of
    the mean, and a damper only takes.  A step whose work that quadrature leaves unclear is taken in parts too.
    In a step of several periods of a spring it is the force at the stage, as in Gauss's own method, and after the step
    an impulse along the force does what work that misses: the energy is kept as well, but such steps do not reverse.
    For linear forces this is Gauss's method itself: A-stable, so that a mode of any w dt neither grows nor, undamped,
    dies; but an overdamped one dies slowly, its sign changing every step: that is for `radau5`.
    Source: Hairer, "Energy-preserving variant of collocation methods" (2010); Cohen & Hairer, "Linear energy-preserving
    integrators for Poisson systems" (2011), which keep |q| as well; order 6.
    """
    integrate(rows, n, dt, GAUSS, moments, inverse_moments, gyroscopic, forces)
