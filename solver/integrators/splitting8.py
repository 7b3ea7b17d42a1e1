"""The splitting composed with itself to order 8."""

import numpy as np
from numpy.typing import NDArray

from tumble.solver.compilation import kernel
from tumble.solver.integrators.splitting import symmetric_step
from tumble.solver.quaternion import steady_turn
from tumble.solver.spins import load, store
from tumble.solver.vectors import Vector, scale, times

_HALF = (
    0.74167036435061295344822780,
    -0.40910082580003159399730010,
    0.19075471029623837995387626,
    -0.57386247111608226665638773,
    0.29906418130365592384446354,
    0.33462491824529818378495798,
    0.31529309239676659663205666,
)
STRETCHES = np.array([*_HALF, 1.0 - 2.0 * sum(_HALF), *reversed(_HALF)])


@kernel
def splitting8(
    spins: NDArray[np.float64], n: int, dt: float, inverse_moments: Vector, gyroscopic: Vector | None
) -> None:
    """Take n steps, each of fifteen steps of `splitting` forwards and backwards in time that cancel its errors.

    spins: q, then L in body axes, (N, 7).
    Source: Suzuki & Umeno (1993), coefficients in Hairer, Lubich & Wanner, "Geometric Numerical Integration" (2006),
    section V.3.2, eq. 3.11 ff.; order 8.
    """
    half_step = scale(dt / 2.0, inverse_moments)
    for spin in spins:
        q, momentum = load(spin)
        if gyroscopic is None:
            q = steady_turn(q, times(half_step, momentum), n)
        else:
            for _ in range(n):
                for stretch in STRETCHES:
                    q, momentum = symmetric_step(q, momentum, scale(stretch, half_step))
        store(spin, q, momentum)
