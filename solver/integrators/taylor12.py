"""The Taylor series of quaternion and angular momentum, to the twelfth power of the step."""

import numpy as np
from numpy.typing import NDArray

from solver.compilation import kernel
from solver.quaternion import normalise, plus, product_vector, stretch
from solver.series import next_momentum, next_quaternion, put_momentum, put_quaternion
from solver.spins import load, store
from solver.vectors import Vector, add, scale, times

Array = NDArray[np.float64]

ORDER = 12


@kernel
def taylor12(spins: Array, n: int, dt: float, inverse_moments: Vector, gyroscopic: Vector | None) -> None:
    """Take n steps of dq/dt = q w~/2 and dL/dt = L x w, with w = I0^-1 L, all in body axes.

    spins: q, then L in body axes, (N, 7).
    Source: Moore, "Interval Analysis" (1966), chapter 11; Jorba & Zou, "A software package for the numerical
    integration of ODEs by means of high-order Taylor methods" (2005); order 12.
    """
    half_step = scale(dt / 2.0, inverse_moments)
    quaternions, half_turns, momenta = np.empty((ORDER, 12)), np.empty((ORDER, 3)), np.empty((ORDER, 8))
    for spin in spins:
        q, momentum = load(spin)
        for _ in range(n):
            q_term, term = q, momentum
            q_rest, rest = (0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
            for power in range(ORDER):
                if gyroscopic is None:
                    q_term = stretch(1.0 / (power + 1), product_vector(q_term, times(half_step, momentum)))
                else:
                    half_turns[power, 0], half_turns[power, 1], half_turns[power, 2] = times(half_step, term)
                    put_quaternion(quaternions, power, q_term)
                    put_momentum(momenta, power, term)
                    q_term = next_quaternion(quaternions, half_turns, power)
                    term = next_momentum(momenta, power, scale(dt, gyroscopic))
                    rest = add(rest, term)
                q_rest = plus(q_rest, q_term)
            q, momentum = normalise(plus(q, q_rest)), add(momentum, rest)
        store(spin, q, momentum)
