"""Rotations about the body's own axes in the order 3-2-1-2-3: the symmetric splitting also called NO_SQUISH."""

import numpy as np
from numpy.typing import NDArray

from tumble.solver.compilation import inner, kernel
from tumble.solver.quaternion import Quaternion, cosine_and_sine_ratio, steady_turn
from tumble.solver.spins import load, store
from tumble.solver.vectors import Vector, scale, times


@inner
def _turn_1(q: Quaternion, momentum: Vector, angle: float) -> tuple[Quaternion, Vector]:
    """Return q and L_body after the body has turned about its axis 1 by twice the angle [rad] while L stood still."""
    c, ratio = cosine_and_sine_ratio(angle * angle)
    s = ratio * angle
    # 1 - cos and not cos: what rounding does to a small angle does not lengthen L.
    versine, sine = 2.0 * s * s, 2.0 * s * c
    w, x, y, z = q
    _, L2, L3 = momentum
    return (
        (c * w - s * x, c * x + s * w, c * y + s * z, c * z - s * y),
        (momentum[0], L2 + (sine * L3 - versine * L2), L3 - (sine * L2 + versine * L3)),
    )


@inner
def _turn_2(q: Quaternion, momentum: Vector, angle: float) -> tuple[Quaternion, Vector]:
    """Return what `_turn_1` does, about axis 2: the same with the axes in the order 2, 3, 1."""
    (w, y, z, x), (L2, L3, L1) = _turn_1((q[0], q[2], q[3], q[1]), (momentum[1], momentum[2], momentum[0]), angle)
    return (w, x, y, z), (L1, L2, L3)


@inner
def _turn_3(q: Quaternion, momentum: Vector, angle: float) -> tuple[Quaternion, Vector]:
    """Return what `_turn_1` does, about axis 3: the same with the axes in the order 3, 1, 2."""
    (w, z, x, y), (L3, L1, L2) = _turn_1((q[0], q[3], q[1], q[2]), (momentum[2], momentum[0], momentum[1]), angle)
    return (w, x, y, z), (L1, L2, L3)


@inner
def symmetric_step(q: Quaternion, momentum: Vector, half_step: Vector) -> tuple[Quaternion, Vector]:
    """Return q and L_body after one step 3-2-1-2-3.  half_step: dt/2 over the moments."""
    q, momentum = _turn_3(q, momentum, half_step[2] / 2.0 * momentum[2])
    q, momentum = _turn_2(q, momentum, half_step[1] / 2.0 * momentum[1])
    q, momentum = _turn_1(q, momentum, half_step[0] * momentum[0])
    q, momentum = _turn_2(q, momentum, half_step[1] / 2.0 * momentum[1])
    return _turn_3(q, momentum, half_step[2] / 2.0 * momentum[2])


@kernel
def splitting(
    spins: NDArray[np.float64], n: int, dt: float, inverse_moments: Vector, gyroscopic: Vector | None
) -> None:
    """Take n steps, each of five exact flows of the parts L1^2/2A, L2^2/2B, L3^2/2C of the energy.

    spins: q, then L in body axes, (N, 7).
    Every part turns the body and leaves L in the world alone, so L is kept; the step is symplectic, so the energy is
    off by O(dt^2) for ever but does not drift.  With equal moments the energy needs no splitting: the flow is exact.
    Source: McLachlan, "Explicit Lie-Poisson integration and the Euler equations" (1993); Dullweber, Leimkuhler &
    McLachlan, J. Chem. Phys. 107 (1997) 5840; Miller et al., J. Chem. Phys. 116 (2002) 8649 (NO_SQUISH); order 2.
    """
    half_step = scale(dt / 2.0, inverse_moments)
    for spin in spins:
        q, momentum = load(spin)
        if gyroscopic is None:
            q = steady_turn(q, times(half_step, momentum), n)
        else:
            for _ in range(n):
                q, momentum = symmetric_step(q, momentum, half_step)
        store(spin, q, momentum)
