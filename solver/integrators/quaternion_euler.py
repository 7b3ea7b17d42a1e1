"""Explicit Euler on the quaternion, normalised, as the first report mends it (IGR202, section 3.2)."""

import numpy as np
from numpy.typing import NDArray

from tumble.solver.compilation import kernel
from tumble.solver.quaternion import normalise, plus, product_vector, rotate_back, vector_product
from tumble.solver.spins import load, store
from tumble.solver.vectors import Vector, scale, times


@kernel
def quaternion_euler(
    spins: NDArray[np.float64], n: int, dt: float, inverse_moments: Vector, gyroscopic: Vector | None
) -> None:
    """Take n steps of Q += dt/2 w~ Q, normalised, with w = R I0^-1 R^T L and L constant in world axes.

    spins: Q, then L, (N, 7).
    A trap: the report prints Q w~, which is right for w in body axes, but its w (section 3.1) is in world axes, for
    which the product is w~ Q.  Mixed up, the body turns about the wrong axis, and a symmetric die hides it.
    Source: IGR202 report, section 3.2; order 1.
    """
    half_step = scale(dt / 2.0, inverse_moments)
    for spin in spins:
        q, momentum = load(spin)
        for _ in range(n):
            if gyroscopic is None:
                change = vector_product(times(half_step, momentum), q)
            else:
                # Q w~_body = w~_world Q, and I0^-1 gives w_body first.
                change = product_vector(q, times(half_step, rotate_back(q, momentum)))
            q = normalise(plus(q, change))
        store(spin, q, momentum)
