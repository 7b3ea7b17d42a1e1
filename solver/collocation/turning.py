"""Steps of a rotation that no torque acts on: the stages' L by Newton's method, and then q without iteration.

L does not depend on q, so that Newton's method has three equations a stage; given L at the stages the equations of q
are linear, and are eliminated as quaternions.  The slopes are those that `newton` finds, to rounding.
"""

# The pair of eigenvalues is complex, in functions that are written for real numbers.
# pyright: reportArgumentType=false

import math

import numpy as np
from numpy.typing import NDArray

from tumble.solver.body import momentum_rate, momentum_resolved
from tumble.solver.collocation.newton import (
    FURTHEST_TURN,
    HALVING,
    LEAST_CHANGE,
    MOST_CORRECTIONS,
    MOST_GROWTH,
    POOR,
)
from tumble.solver.collocation.scheme import Scheme
from tumble.solver.collocation.steps import MOST_PARTS, next_part
from tumble.solver.collocation.work import ROUNDING
from tumble.solver.compilation import borrowing, kernel
from tumble.solver.quaternion import (
    Quaternion,
    conjugate,
    norm_squared,
    normalise,
    plus,
    product,
    product_vector,
    stretch,
    vector_product,
)
from tumble.solver.spins import load, store
from tumble.solver.vectors import Vector, add, dot, scale, times

Array = NDArray[np.float64]
Stages = tuple[Vector, Vector, Vector]

NOTHING = (0.0, 0.0, 0.0)
ONE = (1.0, 0.0, 0.0, 0.0)
LOST = (math.nan, math.nan, math.nan)


@kernel
def turn(spins: Array, n: int, dt: float, method: Scheme, inverse_moments: Vector, gyroscopic: Vector | None) -> None:
    """Take n steps of dt [s] of the rotation alone, with no torque.

    spins: q, then L in body axes, (N, 7), altered in place; nan where a step was not found.
    """
    for spin in spins:
        q, momentum = load(spin)
        for _ in range(n):
            q, momentum, found = _advance(q, momentum, dt, method, inverse_moments, gyroscopic)
            if not found:
                break
        store(spin, q, momentum)


@borrowing
def _advance(
    q: Quaternion, momentum: Vector, dt: float, method: Scheme, inverse_moments: Vector, gyroscopic: Vector | None
) -> tuple[Quaternion, Vector, bool]:
    """Return q and L after one step, taken in halves where it must be, and whether all of it was found; else nan."""
    done, part = 0.0, 1.0
    for _ in range(MOST_PARTS):
        stages, found = _momenta(momentum, part * dt, method, inverse_moments, gyroscopic)
        if found:
            q = _turned(q, stages, part * dt, method, inverse_moments)
            momentum = _after(momentum, stages, part * dt, method, gyroscopic)
        done, part = next_part(done, part, found)
        if done == 1.0:
            return q, momentum, True
        if part == 0.0:
            break
    return (math.nan, math.nan, math.nan, math.nan), LOST, False


@borrowing
def _momenta(
    momentum: Vector, dt: float, method: Scheme, inverse_moments: Vector, gyroscopic: Vector | None
) -> tuple[Stages, bool]:
    """Return L at the stages of one step, and whether it was found."""
    if not _turn(momentum, dt, inverse_moments) <= FURTHEST_TURN:
        return (LOST, LOST, LOST), False
    if gyroscopic is None:
        return (momentum, momentum, momentum), True
    return _solved(momentum, dt, method, inverse_moments, gyroscopic)


@borrowing
def _solved(
    momentum: Vector, dt: float, method: Scheme, inverse_moments: Vector, gyroscopic: Vector
) -> tuple[Stages, bool]:
    """Return L at the stages of one step by Newton's method, begun from an L that stands still, and whether it ended.

    The Jacobian is that of the middle stage, new for each correction.
    Source: Hairer & Wanner (1996), eq. IV.8.13.
    """
    slopes = (NOTHING, NOTHING, NOTHING)
    stages = (momentum, momentum, momentum)
    real_rates = scale(dt * method.real_rate, gyroscopic)
    pair_rates = scale(dt * method.pair_rate, gyroscopic)
    previous = math.inf
    for _ in range(MOST_CORRECTIONS):
        missing = (
            add(momentum_rate(stages[0], gyroscopic), scale(-1.0, slopes[0])),
            add(momentum_rate(stages[1], gyroscopic), scale(-1.0, slopes[1])),
            add(momentum_rate(stages[2], gyroscopic), scale(-1.0, slopes[2])),
        )
        real = momentum_resolved(stages[1], real_rates, _sum(method.to_real, missing))
        pair = momentum_resolved(stages[1], pair_rates, _sum(method.to_pair, missing))
        corrections = (
            _correction(method, 0, real, pair),
            _correction(method, 1, real, pair),
            _correction(method, 2, real, pair),
        )
        square = _square(corrections)
        change = abs(dt) * math.sqrt(square / _square(stages)) if square != 0.0 else 0.0
        slopes = (add(slopes[0], corrections[0]), add(slopes[1], corrections[1]), add(slopes[2], corrections[2]))
        stages = _stages(momentum, slopes, dt, method)
        shrinking = change / previous if previous < math.inf else POOR
        if change * shrinking <= LEAST_CHANGE or (shrinking > HALVING and change < ROUNDING):
            return stages, True
        if not (shrinking < MOST_GROWTH and _furthest(stages, dt, inverse_moments) <= FURTHEST_TURN):
            return stages, False
        previous = change
    return stages, False


@borrowing
def _correction(method: Scheme, i: int, real: Vector, pair: tuple[complex, complex, complex]) -> Vector:
    """Return the correction of the slope of stage i."""
    a, b = method.from_real[i], 2.0 * method.from_pair[i]
    return (a * real[0] + (b * pair[0]).real, a * real[1] + (b * pair[1]).real, a * real[2] + (b * pair[2]).real)


@borrowing
def _stages(momentum: Vector, slopes: Stages, dt: float, method: Scheme) -> Stages:
    """Return L at the stages, from its slopes there."""
    return (
        add(momentum, scale(dt, _sum(method.coefficients[0], slopes))),
        add(momentum, scale(dt, _sum(method.coefficients[1], slopes))),
        add(momentum, scale(dt, _sum(method.coefficients[2], slopes))),
    )


@borrowing
def _sum(weights: Array, vectors: Stages) -> Vector:
    """Return the weighted sum of three vectors."""
    a, b, c = vectors
    return (
        weights[0] * a[0] + weights[1] * b[0] + weights[2] * c[0],
        weights[0] * a[1] + weights[1] * b[1] + weights[2] * c[1],
        weights[0] * a[2] + weights[1] * b[2] + weights[2] * c[2],
    )


@borrowing
def _square(vectors: Stages) -> float:
    """Return the sum of the squares of three vectors."""
    return dot(vectors[0], vectors[0]) + dot(vectors[1], vectors[1]) + dot(vectors[2], vectors[2])


@borrowing
def _furthest(stages: Stages, dt: float, inverse_moments: Vector) -> float:
    """Return how far the body turns in a step [rad], at the fastest of its stages; nan if L is nan."""
    first, second = _turn(stages[0], dt, inverse_moments), _turn(stages[1], dt, inverse_moments)
    return max(first, max(second, _turn(stages[2], dt, inverse_moments)))


@borrowing
def _turn(momentum: Vector, dt: float, inverse_moments: Vector) -> float:
    """Return |w dt| [rad]."""
    w_body = times(inverse_moments, momentum)
    return abs(dt) * math.sqrt(dot(w_body, w_body))


@borrowing
def _after(momentum: Vector, stages: Stages, dt: float, method: Scheme, gyroscopic: Vector | None) -> Vector:
    """Return L after one step."""
    if gyroscopic is None:
        return momentum
    rates = (
        momentum_rate(stages[0], gyroscopic),
        momentum_rate(stages[1], gyroscopic),
        momentum_rate(stages[2], gyroscopic),
    )
    return add(momentum, scale(dt, _sum(method.weights, rates)))


@borrowing
def _turned(q: Quaternion, stages: Stages, dt: float, method: Scheme, inverse_moments: Vector) -> Quaternion:
    """Return q after one step of q' = q w~/2, of length 1.

    The stages are q x_i, with x_i = 1 + sum_j a_ij x_j u_j, u_j = dt/2 w~_j: three linear equations of quaternions,
    whose coefficients stand on the right.  They are eliminated in the order of the stages.
    """
    a, half_step = method.coefficients, scale(0.5 * dt, inverse_moments)
    u1, u2, u3 = times(half_step, stages[0]), times(half_step, stages[1]), times(half_step, stages[2])
    # k = u1 (1 - a11 u1)^-1, by which the second and the third equation lose x1.
    first = 1.0 / (1.0 + a[0, 0] * a[0, 0] * dot(u1, u1))
    k = (-first * a[0, 0] * dot(u1, u1), first * u1[0], first * u1[1], first * u1[2])
    u2k, u3k = vector_product(u2, k), vector_product(u3, k)
    c22 = plus(_minus(1.0, a[1, 1], u2), stretch(-a[0, 1] * a[1, 0], u2k))
    c23 = plus(_minus(0.0, a[1, 2], u3), stretch(-a[0, 2] * a[1, 0], u3k))
    c32 = plus(_minus(0.0, a[2, 1], u2), stretch(-a[0, 1] * a[2, 0], u2k))
    c33 = plus(_minus(1.0, a[2, 2], u3), stretch(-a[0, 2] * a[2, 0], u3k))
    right2, right3 = plus(ONE, stretch(a[1, 0], k)), plus(ONE, stretch(a[2, 0], k))
    inverse22 = _inverse(c22)
    m = product(inverse22, c32)
    x3 = product(plus(right3, stretch(-1.0, product(right2, m))), _inverse(plus(c33, stretch(-1.0, product(c23, m)))))
    x2 = product(plus(right2, stretch(-1.0, product(x3, c23))), inverse22)
    x2u2, x3u3 = product_vector(x2, u2), product_vector(x3, u3)
    # x1 u1 = (1 + a12 x2 u2 + a13 x3 u3) k
    x1u1 = product(plus(ONE, plus(stretch(a[0, 1], x2u2), stretch(a[0, 2], x3u3))), k)
    b = method.weights
    change = plus(stretch(b[0], x1u1), plus(stretch(b[1], x2u2), stretch(b[2], x3u3)))
    return normalise(plus(q, product(q, change)))


@borrowing
def _minus(one: float, factor: float, u: Vector) -> Quaternion:
    """Return one - factor u~."""
    return (one, -factor * u[0], -factor * u[1], -factor * u[2])


@borrowing
def _inverse(q: Quaternion) -> Quaternion:
    """Return q^-1 of a quaternion of any length."""
    return stretch(1.0 / norm_squared(q), conjugate(q))
