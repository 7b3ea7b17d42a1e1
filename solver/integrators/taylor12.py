"""The Taylor series of quaternion and angular momentum, to the twelfth power of the step."""

import numpy as np
from numpy.typing import NDArray

from tumble.solver.compilation import kernel
from tumble.solver.quaternion import normalise, plus, steady_turn
from tumble.solver.series import momentum_terms, quaternion_terms
from tumble.solver.spins import load, store
from tumble.solver.vectors import Vector, add, scale, times


@kernel
def taylor12(spins: NDArray[np.float64], n: int, dt: float, inverse_moments: Vector, gyroscopic: Vector | None) -> None:
    """Take n steps of dq/dt = q w~/2 and dL/dt = L x w, with w = I0^-1 L, all in body axes.

    spins: q, then L in body axes, (N, 7).  Where w is constant the series of q is that of an exponential.
    Source: `tumble.solver.series`; order 12.
    """
    half_step = scale(dt / 2.0, inverse_moments)
    for spin in spins:
        q, momentum = load(spin)
        if gyroscopic is None:
            q = steady_turn(q, times(half_step, momentum), n)
        else:
            for _ in range(n):
                terms = momentum_terms(momentum, scale(dt, gyroscopic))
                l1, l2, l3, l4, l5, l6, l7, l8, l9, l10, l11, l12 = terms
                q1, q2, q3, q4, q5, q6, q7, q8, q9, q10, q11, q12 = quaternion_terms(q, momentum, terms, half_step)
                # The least terms first.
                q_end = plus(q7, plus(q8, plus(q9, plus(q10, plus(q11, q12)))))
                q_change = plus(q1, plus(q2, plus(q3, plus(q4, plus(q5, plus(q6, q_end))))))
                end = add(l7, add(l8, add(l9, add(l10, add(l11, l12)))))
                change = add(l1, add(l2, add(l3, add(l4, add(l5, add(l6, end))))))
                q, momentum = normalise(plus(q, q_change)), add(momentum, change)
        store(spin, q, momentum)
