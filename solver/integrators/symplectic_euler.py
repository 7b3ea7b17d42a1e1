"""What a game engine writes: velocities first, then positions with the new ones, and a rotation by exp(dt w)."""

import numpy as np
from numpy.typing import NDArray

from solver.compilation import kernel, scalar
from solver.quaternion import Quaternion, exponential, norm_squared, product, rotate_back, stretch
from solver.spins import load, store
from solver.vectors import Vector, scale, times


@scalar
def _length_correction(q: Quaternion) -> float:
    """Return 1/|q| for |q| near 1, by one Newton step: it can be taken while the step that it corrects is computed."""
    return 1.5 - 0.5 * norm_squared(q)


@kernel
def symplectic_euler(
    spins: NDArray[np.float64], n: int, dt: float, inverse_moments: Vector, gyroscopic: Vector | None
) -> None:
    """Take n steps of q = exp(dt w) q, with w = R I0^-1 R^T L and L constant in world axes.

    spins: q, then L, (N, 7).
    L is kept exactly; for equal moments w is constant and the rotation exact.  Symplectic is the translation only: with
    unequal moments the energy drifts, at first order, so this must not be confused with a splitting.
    Source: the order of updates is that of Hairer, Lubich & Wanner, "Geometric Numerical Integration" (2006), section
    I.1.2; the rotation is a Lie-Euler step, section IV.8; order 1.
    """
    half_step = scale(dt / 2.0, inverse_moments)
    for spin in spins:
        q, momentum = load(spin)
        if gyroscopic is None:
            turn = exponential(times(half_step, momentum))
            for _ in range(n):
                q = stretch(_length_correction(q), product(turn, q))
        else:
            for _ in range(n):
                # q exp(dt w_body) = exp(dt w_world) q, and I0^-1 gives w_body first.
                half_turn = times(half_step, rotate_back(q, momentum))
                q = stretch(_length_correction(q), product(q, exponential(half_turn)))
        store(spin, q, momentum)
