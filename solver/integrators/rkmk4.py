"""Runge-Kutta on the rotation group, of fourth order: one exponential and one commutator a step."""

import numpy as np
from numpy.typing import NDArray

from tumble.solver.compilation import kernel
from tumble.solver.fused import fused_cross, fused_exponential, fused_product, fused_scale
from tumble.solver.integrators.rk4 import stage_momenta
from tumble.solver.spins import load, store
from tumble.solver.vectors import Vector, add, scale, times


@kernel
def rkmk4(spins: NDArray[np.float64], n: int, dt: float, inverse_moments: Vector, gyroscopic: Vector | None) -> None:
    """Take n steps of q = q exp(u~), with u from w at the four stages of rk4 on dL/dt = L x w, all in body axes.

    spins: q, then L in body axes, (N, 7).
    The commutator's sign is that of dq/dt = q w~/2, where w multiplies on the right.  A product of unit quaternions
    keeps its length but for rounding, so nothing is normalised.  L is stepped as in rk4, and is stable as far.
    Source: Munthe-Kaas, "High order Runge-Kutta methods on manifolds" (1999), with the commutators of Munthe-Kaas &
    Owren, "Computations in a free Lie algebra" (1999); Iserles et al., "Lie-group methods" (2000); order 4.
    """
    half_step = scale(dt / 2.0, inverse_moments)
    for spin in spins:
        q, momentum = load(spin)
        for _ in range(n):
            l1, l2, l3, l4, momentum = stage_momenta(momentum, dt, gyroscopic)
            sum_of_turns = times(half_step, fused_scale(2.0, add(l2, l3), add(l1, l4)))
            turn = fused_cross(times(half_step, l1), times(half_step, l4), sum_of_turns)
            q = fused_product(q, fused_exponential(scale(1.0 / 6.0, turn)))
        store(spin, q, momentum)
