"""The Runge-Kutta-Munthe-Kaas method of order 4, for many throws."""

import numpy as np
from numpy.typing import NDArray

from tumble.solver.ensemble.blocks import IN_ORDER, LANES, load_block, share_out, store_block
from tumble.solver.ensemble.lanes import add, cross, dot, lane, lanes_kernel, product, scale, times, widest_vectors
from tumble.solver.quaternion import Quaternion, exponential
from tumble.solver.vectors import Vector

# A step's multiplications and additions, a fused one counted as two.
FLOPS = 144


@lane
def turn_by(u: Vector) -> Quaternion:
    """Return exp(u~), the rotation by 2 |u| [rad] about u, by Taylor's series.

    To rounding up to 1 rad; where the momentum becomes unstable, at 2.8 rad, still to 1e-11.
    """
    s = dot(u, u)
    # The odd and the even terms apart: half the waiting of Horner's scheme.
    s2 = s * s
    cosine = (1.0 - s * (1 / 2)) + s2 * (
        (1 / 24 - s * (1 / 720)) + s2 * ((1 / 40320 - s * (1 / 3628800)) + s2 * (1 / 479001600 - s * (1 / 87178291200)))
    )
    sine = (1.0 - s * (1 / 6)) + s2 * (
        (1 / 120 - s * (1 / 5040)) + s2 * ((1 / 362880 - s * (1 / 39916800)) + s2 * (1 / 6227020800))
    )
    return (cosine, sine * u[0], sine * u[1], sine * u[2])


@lane
def momentum_rate(l_body: Vector, gyroscopic: Vector) -> Vector:
    """Return dL/dt = L x w, as `tumble.solver.body.momentum_rate` does."""
    return times(gyroscopic, (l_body[1] * l_body[2], l_body[2] * l_body[0], l_body[0] * l_body[1]))


@lane
def step(
    q: Quaternion, momentum: Vector, half_step: Vector, mean_step: Vector, bracket_step: Vector
) -> tuple[Quaternion, Vector]:
    """Return q and L after one step.

    half_step: dt/2 times the gyroscopic coefficients; mean_step: dt/12 times the inverse moments, for half the mean
    turn; bracket_step: dt^2/24 times what makes L1 x L4 into w1 x w4.
    """
    second = add(momentum, momentum_rate(momentum, half_step))
    third = add(momentum, momentum_rate(second, half_step))
    fourth = add(momentum, momentum_rate(third, scale(2.0, half_step)))
    # k1 + 2 k2 + 2 k3 by the stages that they led to: a fused multiply-add each, and no slope kept.
    stages = add(add(second, fourth), scale(2.0, third))
    slopes = add(add(stages, scale(-4.0, momentum)), momentum_rate(fourth, half_step))
    mean = add(stages, add(momentum, second))
    turn = add(times(mean_step, mean), times(bracket_step, cross(momentum, fourth)))
    return product(q, turn_by(turn)), add(momentum, scale(1.0 / 3.0, slopes))


@lanes_kernel
def _rkmk4(
    first: int,
    last: int,
    spins: NDArray[np.float64],
    n: int,
    half_step: Vector,
    mean_step: Vector,
    bracket_step: Vector,
) -> None:
    widest_vectors()
    block = np.empty(7 * LANES)
    for begin in range(first, last, LANES):
        load_block(spins, 0, IN_ORDER, begin, last, block)
        for _ in range(n):
            for i in range(LANES):
                q = (block[i], block[LANES + i], block[2 * LANES + i], block[3 * LANES + i])
                momentum = (block[4 * LANES + i], block[5 * LANES + i], block[6 * LANES + i])
                q, momentum = step(q, momentum, half_step, mean_step, bracket_step)
                block[i], block[LANES + i], block[2 * LANES + i], block[3 * LANES + i] = q
                block[4 * LANES + i], block[5 * LANES + i], block[6 * LANES + i] = momentum
        store_block(spins, IN_ORDER, begin, last, block)


@lanes_kernel
def _constant_turn(first: int, last: int, spins: NDArray[np.float64], n: int, half_step: Vector) -> None:
    """Take n steps of one and the same turn, which is all there is for equal moments; half_step: dt/2 / moments."""
    widest_vectors()
    block = np.empty(11 * LANES)
    for begin in range(first, last, LANES):
        load_block(spins, 0, IN_ORDER, begin, last, block)
        for i in range(LANES):
            u = (
                half_step[0] * block[4 * LANES + i],
                half_step[1] * block[5 * LANES + i],
                half_step[2] * block[6 * LANES + i],
            )
            turn = exponential(u)
            block[7 * LANES + i], block[8 * LANES + i], block[9 * LANES + i], block[10 * LANES + i] = turn
        for _ in range(n):
            for i in range(LANES):
                q = (block[i], block[LANES + i], block[2 * LANES + i], block[3 * LANES + i])
                turn = (block[7 * LANES + i], block[8 * LANES + i], block[9 * LANES + i], block[10 * LANES + i])
                block[i], block[LANES + i], block[2 * LANES + i], block[3 * LANES + i] = product(q, turn)
        store_block(spins, IN_ORDER, begin, last, block)


def rkmk4(spins: NDArray[np.float64], n: int, dt: float, inverse_moments: Vector, gyroscopic: Vector | None) -> None:
    """Take n steps of q = q exp(dt/12 (w1 + 2 w2 + 2 w3 + w4) + dt^2/24 w1 x w4), with dL/dt = L x w by RK4.

    spins: q, then L in body axes, (N, 7), C order, altered in place; as `tumble.solver.integrators` has it.
    w1 ... w4 = I0^-1 L at the four stages of L, whose own equation does not know q: one exponential and one commutator
    a step.  The length of q is left to rounding.
    Source: Munthe-Kaas, "High order Runge-Kutta methods on manifolds" (1999), example 3; the single commutator as in
    Iserles, Munthe-Kaas, Norsett & Zanna, "Lie-group methods" (2000), section 4; order 4.
    """
    a, b, c = inverse_moments
    if gyroscopic is None:
        share_out(_constant_turn, len(spins), n * FLOPS, spins, n, (dt / 2 * a, dt / 2 * b, dt / 2 * c))
        return
    half_step = (dt / 2 * gyroscopic[0], dt / 2 * gyroscopic[1], dt / 2 * gyroscopic[2])
    mean_step = (dt / 12 * a, dt / 12 * b, dt / 12 * c)
    bracket = dt * dt / 24
    bracket_step = (bracket * b * c, bracket * c * a, bracket * a * b)
    share_out(_rkmk4, len(spins), n * FLOPS, spins, n, half_step, mean_step, bracket_step)
