"""Steps of whatever length a tolerance allows, of order eight, that run ahead of the instant asked for."""

import math

import numpy as np
from numpy.typing import NDArray

from tumble.solver.body import momentum_rate
from tumble.solver.compilation import inner, kernel
from tumble.solver.dop853 import ERROR_3, ERROR_5, STAGES, WEIGHTS
from tumble.solver.quaternion import Quaternion, normalise, product_vector
from tumble.solver.spins import load_anchor, store, store_anchor
from tumble.solver.vectors import Vector, dot, scale, times

Array = NDArray[np.float64]
State = tuple[Quaternion, Vector]

# The next step is this much shorter than what the error would just allow, and changes no more than that at once.
SAFETY, LEAST_CHANGE, GREATEST_CHANGE = 0.9, 1 / 3, 6.0
# Radians of the first step at tolerance 1; too long a guess costs one trial.
FIRST_TURN = 4.0
# Beyond so many steps for one instant the method gives up, and its state is nan.
MOST_STEPS = 100_000


@inner
def _slope(q: Quaternion, momentum: Vector, inverse_moments: Vector, gyroscopic: Vector | None) -> State:
    """Return dq/dt = q w~/2 and dL/dt = L x w, in body axes: the place for a torque."""
    turning = product_vector(q, scale(0.5, times(inverse_moments, momentum)))
    if gyroscopic is None:
        return turning, (0.0, 0.0, 0.0)
    return turning, momentum_rate(momentum, gyroscopic)


@inner
def _ahead(q: Quaternion, momentum: Vector, weights: Array, slopes: Array, count: int, dt: float) -> State:
    """Return q and L after dt [s] at the weighted mean of the first slopes, (count, 7)."""
    dw, dx, dy, dz, d1, d2, d3 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for stage in range(count):
        weight = weights[stage]
        dw += weight * slopes[stage, 0]
        dx += weight * slopes[stage, 1]
        dy += weight * slopes[stage, 2]
        dz += weight * slopes[stage, 3]
        d1 += weight * slopes[stage, 4]
        d2 += weight * slopes[stage, 5]
        d3 += weight * slopes[stage, 6]
    return (
        (q[0] + dt * dw, q[1] + dt * dx, q[2] + dt * dy, q[3] + dt * dz),
        (momentum[0] + dt * d1, momentum[1] + dt * d2, momentum[2] + dt * d3),
    )


@inner
def _step(
    q: Quaternion, momentum: Vector, dt: float, slopes: Array, inverse_moments: Vector, gyroscopic: Vector | None
) -> State:
    """Return q and L one step of dt [s] on, and leave the slopes of its stages in slopes, (12, 7)."""
    for stage in range(len(WEIGHTS)):
        q_stage, momentum_stage = _ahead(q, momentum, STAGES[stage], slopes, stage, dt)
        q_slope, momentum_slope = _slope(q_stage, momentum_stage, inverse_moments, gyroscopic)
        slopes[stage, 0], slopes[stage, 1], slopes[stage, 2], slopes[stage, 3] = q_slope
        slopes[stage, 4], slopes[stage, 5], slopes[stage, 6] = momentum_slope
    return _ahead(q, momentum, WEIGHTS, slopes, len(WEIGHTS), dt)


@inner
def _squared(weights: Array, slopes: Array, per_momentum: float) -> float:
    """Return the squared length of the weighted sum of slopes, L counted in its own length."""
    q, momentum = _ahead((0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0), weights, slopes, len(weights), 1.0)
    off = scale(per_momentum, momentum)
    return q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] + dot(off, off)


@inner
def _estimate(slopes: Array, dt: float, momentum: Vector) -> float:
    """Return about how far one step is off: in q, or in L relative to L.

    Source: Hairer, Norsett & Wanner (1993), eq. II.10.17.
    """
    length = dot(momentum, momentum)
    per_momentum = 1.0 / math.sqrt(length) if length > 0.0 else 0.0
    return combined(_squared(ERROR_5, slopes, per_momentum), _squared(ERROR_3, slopes, per_momentum), dt)


@inner
def combined(fifth: float, third: float, dt: float) -> float:
    """Return the estimate of order 8 from the squares of those of orders 5 and 3, both over dt."""
    if fifth == 0.0:
        return 0.0
    return abs(dt) * fifth / math.sqrt(fifth + 0.01 * third)


@inner
def regrown(length: float, off: float, growth: float) -> tuple[float, float]:
    """Return the length of the next step and how much it may grow thereafter, from how many tolerances one was off."""
    if not off > 1.0:
        return length * (min(growth, SAFETY * off**-0.125) if off > 0.0 else growth), GREATEST_CHANGE
    return length * max(LEAST_CHANGE, SAFETY * off**-0.125), 1.0


@kernel
def adaptive(
    spins: Array,
    n: int,
    dt: float,
    inverse_moments: Vector,
    gyroscopic: Vector | None,
    tolerance: float,
) -> None:
    """Turn for n dt from where the count of n began, in steps that are each off by the tolerance at most.

    spins: q, then L in body axes; both at the end of the last step taken; its time since the count began [s] and the
    length of the next [s], 0 before the first, (N, 16).
    The steps taken do not depend on the instants asked for: each of those is read by one more step, back from the end
    of the last, of the same order and no longer, which is then forgotten.
    Source: `tumble.solver.dop853`; step control: Hairer, Norsett & Wanner (1993), section II.4; order 8.
    """
    t = n * dt
    slopes = np.empty((len(WEIGHTS), 7))
    for spin in spins:
        q, momentum = load_anchor(spin)
        time, length = spin[14], spin[15]
        if length == 0.0:
            w_body = times(inverse_moments, momentum)
            speed = math.sqrt(dot(w_body, w_body))
            length = FIRST_TURN * tolerance**0.125 / speed if speed > 0.0 else abs(t)
        growth = GREATEST_CHANGE
        tries = 0
        while abs(time) < abs(t):
            # Short fractions of a second, whose sums are exact.
            step = math.copysign(np.float64(np.float32(length)), t)
            q_next, momentum_next = _step(q, momentum, step, slopes, inverse_moments, gyroscopic)
            off = _estimate(slopes, step, momentum) / tolerance
            tries += 1
            if not math.isfinite(off) or tries > MOST_STEPS:
                q, momentum, time = (math.nan, math.nan, math.nan, math.nan), (math.nan, math.nan, math.nan), t
            elif off <= 1.0:
                q, momentum, time = normalise(q_next), momentum_next, time + step
            length, growth = regrown(length, off, growth)
        store_anchor(spin, q, momentum)
        spin[14], spin[15] = time, length
        if time != t:
            q, momentum = _step(q, momentum, t - time, slopes, inverse_moments, gyroscopic)
        store(spin, q, momentum)
