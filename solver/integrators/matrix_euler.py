"""Explicit Euler on the rotation matrix, as the first report does it (IGR202, section 3.1)."""

import numpy as np
from numpy.typing import NDArray

from tumble.solver.compilation import kernel, scalar
from tumble.solver.vectors import Vector, add, cross, dot, scale


@scalar
def _inverse_inertia_times(e1: Vector, e2: Vector, e3: Vector, inverse_moments: Vector, momentum: Vector) -> Vector:
    """Return R I0^-1 R^T L, with the columns e1, e2, e3 of R."""
    return add(
        scale(inverse_moments[0] * dot(e1, momentum), e1),
        add(scale(inverse_moments[1] * dot(e2, momentum), e2), scale(inverse_moments[2] * dot(e3, momentum), e3)),
    )


@kernel
def matrix_euler(
    spins: NDArray[np.float64], n: int, dt: float, inverse_moments: Vector, gyroscopic: Vector | None
) -> None:
    """Take n steps of w = R I0^-1 R^T L and R += dt [w]x R, with L constant in world axes.

    spins: the columns of R, the body's axes in world axes, then L, (N, 12).
    R is never made orthonormal again: each step lengthens what is perpendicular to w by sqrt(1 + (|w| dt)^2), so the
    die grows and, where w wanders, shears.  Source: IGR202 report, section 3.1; order 1.
    """
    for spin in spins:
        e1, e2, e3 = (spin[0], spin[1], spin[2]), (spin[3], spin[4], spin[5]), (spin[6], spin[7], spin[8])
        momentum = (spin[9], spin[10], spin[11])
        w_world = scale(inverse_moments[0], momentum)
        for _ in range(n):
            if gyroscopic is not None:
                w_world = _inverse_inertia_times(e1, e2, e3, inverse_moments, momentum)
            turn = scale(dt, w_world)
            e1, e2, e3 = add(e1, cross(turn, e1)), add(e2, cross(turn, e2)), add(e3, cross(turn, e3))
        spin[0], spin[1], spin[2] = e1
        spin[3], spin[4], spin[5] = e2
        spin[6], spin[7], spin[8] = e3
