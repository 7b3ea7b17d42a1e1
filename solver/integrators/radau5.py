"""Radau's collocation in three stages: what is overdamped is gone after a step, however long."""

import math

import numpy as np
from numpy.typing import NDArray

from tumble.solver.collocation.scheme import scheme
from tumble.solver.collocation.steps import integrate
from tumble.solver.collocation.turning import turn
from tumble.solver.forces import Forces
from tumble.solver.vectors import Vector

_NODES = np.array([(4.0 - math.sqrt(6.0)) / 10.0, (4.0 + math.sqrt(6.0)) / 10.0, 1.0])
RADAU = scheme(stages=_NODES, instants=_NODES)


def radau5(spins: NDArray[np.float64], n: int, dt: float, inverse_moments: Vector, gyroscopic: Vector | None) -> None:
    """Take n steps of dq/dt = q w~/2 and dL/dt = L x w, with w = I0^-1 L, all in body axes.

    spins: q, then L in body axes, (N, 7).
    It damps what it cannot follow, and so keeps nothing; |q| is put right after every step.  A step that turns the body
    by more than a radian is taken in parts, and where 2^14 are not enough the state becomes nan.
    Source: Ehle (1969); Hairer & Wanner, "Solving Ordinary Differential Equations II" (1996), section IV.5, Radau IIA;
    order 5.
    """
    turn(spins, n, dt, RADAU, inverse_moments, gyroscopic)


def radau5_forced(
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
    L-stable: a decay of any rate ends with the step.  An undamped mode with w dt above 1 is damped too: `gauss6`.
    Source: as of radau5.
    """
    integrate(rows, n, dt, RADAU, moments, inverse_moments, gyroscopic, forces)
