"""What a game engine writes: velocities first, then positions with the new ones, and a rotation by exp(dt w)."""

# Rotation is absent as a whole, which pyright cannot know: where q is not None neither is L or w.
# pyright: reportArgumentType=false

import numpy as np
from numpy.typing import NDArray

from tumble.solver import motion
from tumble.solver.compilation import inlined, inner, kernel, scalar
from tumble.solver.forces import Forces, wrench
from tumble.solver.quaternion import Quaternion, exponential, norm_squared, product, rotate, rotate_back, stretch
from tumble.solver.spins import load, store
from tumble.solver.vectors import Vector, add, scale, times


@scalar
def _length_correction(q: Quaternion) -> float:
    """Return 1/|q| for |q| near 1, by one Newton step: it can be taken while the step that it corrects is computed."""
    return 1.5 - 0.5 * norm_squared(q)


@scalar
def _turned(q: Quaternion, half_turn: Vector) -> Quaternion:
    """Return q after a step, from dt/2 w_body: q exp(dt w_body) = exp(dt w_world) q, and I0^-1 gives w_body first."""
    return stretch(_length_correction(q), product(q, exponential(half_turn)))


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
                q = _turned(q, times(half_step, rotate_back(q, momentum)))
        store(spin, q, momentum)


@inlined
def _kicked(state: motion.State, dt: float, inverse_moments: Vector | None, forces: Forces) -> motion.State:
    """Return the state after dt [s] of force and torque alone."""
    x, q, v, momentum = state
    force, torque = wrench(x, q, v, _spin(q, momentum, inverse_moments), forces)
    return x, q, add(v, scale(dt / forces.mass, force)), _twisted(q, momentum, scale(dt, torque))


@inlined
def _drifted(state: motion.State, dt: float, inverse_moments: Vector | None) -> motion.State:
    """Return the state after dt [s] at its velocities."""
    x, q, v, momentum = state
    return add(x, scale(dt, v)), _swung(q, dt, _spin(q, momentum, inverse_moments)), v, momentum


@inner
def _spin(q: Quaternion | None, momentum: Vector | None, inverse_moments: Vector | None) -> Vector | None:
    """Return w_body = I0^-1 R^T L [rad/s]."""
    if inverse_moments is None:
        return inverse_moments
    return times(inverse_moments, rotate_back(q, momentum))


@inner
def _twisted(q: Quaternion | None, momentum: Vector | None, kick_body: Vector) -> Vector | None:
    """Return L after an angular impulse [N m s] in body axes."""
    if momentum is None:
        return momentum
    return add(momentum, rotate(q, kick_body))


@inner
def _swung(q: Quaternion | None, dt: float, w_body: Vector | None) -> Quaternion | None:
    """Return q after dt [s] at w_body [rad/s]."""
    if q is None:
        return q
    return _turned(q, scale(dt / 2.0, w_body))


@kernel
def symplectic_euler_forced(
    rows: NDArray[np.float64],
    n: int,
    dt: float,
    moments: Vector,
    inverse_moments: Vector | None,
    gyroscopic: Vector | None,
    forces: Forces,
) -> None:
    """Take n steps of a kick, v += dt F/m and L += dt tau, and a drift, x += dt v and q = exp(dt w) q.

    rows: x, q, v, L in world axes, (N, 13).
    What engines do with a force that they are given once a step.  Stable up to 2 over the frequency of a spring.
    Source: as of symplectic_euler.
    """
    for row in rows:
        state = motion.load(row, inverse_moments)
        for _ in range(n):
            state = _drifted(_kicked(state, dt, inverse_moments, forces), dt, inverse_moments)
        motion.store(row, state)
