"""The Runge-Kutta-Munthe-Kaas method of order 4, for many throws.

L is stepped in units of its own on each axis, in which Euler's equations for half a step have no coefficients but
signs: l1' = -l2 l3, l2' = l3 l1, l3' = -l1 l2, with axis 2 that of the middle moment.  A stage then is a fused
multiply-add a number.
"""

import math

import numpy as np
from numpy.typing import NDArray

from tumble.solver.ensemble.blocks import (
    IN_ORDER,
    LANES,
    load_block,
    load_columns,
    order_of,
    share_out,
    store_block,
    store_columns,
)
from tumble.solver.ensemble.lanes import add, cross, dot, lane, lanes_kernel, product, scale, times, widest_vectors
from tumble.solver.quaternion import Quaternion, exponential
from tumble.solver.vectors import Vector

# A step's multiplications and additions, a fused one counted as two.
FLOPS = 136
# A row's numbers: q, L in body axes, and l, which is 0 before the first step.
WIDTH = 10
# Of two equal moments: their difference as a part of 1/moment, too small to change a bit of any L.
LEAST_DIFFERENCE = 1e-60


@lane
def turn_by(u: Vector) -> Quaternion:
    """Return exp(u~), the rotation by 2 |u| [rad] about u, by Taylor's series.

    To rounding up to 0.3 rad, and to a millionth where the momentum becomes unstable, at 2.8 rad: at every step far
    below what the method itself is off.
    """
    s = dot(u, u)
    # The odd and the even terms apart: half the waiting of Horner's scheme.
    s2 = s * s
    cosine = (1.0 - s * (1 / 2)) + s2 * ((1 / 24 - s * (1 / 720)) + s2 * (1 / 40320 - s * (1 / 3628800)))
    sine = (1.0 - s * (1 / 6)) + s2 * ((1 / 120 - s * (1 / 5040)) + s2 * (1 / 362880))
    return (cosine, sine * u[0], sine * u[1], sine * u[2])


@lane
def plus_rate(scaled: Vector, a: Vector, b: Vector) -> Vector:
    """Return l plus what half a step changes it by, at the slope whose products are those of a with b."""
    return (scaled[0] - a[1] * b[2], scaled[1] + a[2] * b[0], scaled[2] - a[0] * b[1])


@lane
def minus(a: Vector, b: Vector) -> Vector:
    """Return a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


@lane
def step(first: Vector, mean_step: Vector, bracket_step: Vector) -> tuple[Vector, Vector]:
    """Return half the turn of a step [rad] and l after it.

    mean_step, bracket_step: what makes half the mean turn of the sum of the stages, and w1 x w4 of l1 x l4.
    """
    second = plus_rate(first, first, first)
    third = plus_rate(first, second, second)
    fourth = plus_rate(first, add(third, third), third)
    # k1 + 2 k2 + 2 k3 + k4 by the stages that they led to.
    gain = minus(third, first)
    gains = add(add(minus(second, first), minus(fourth, first)), add(gain, gain))
    slopes = plus_rate(gains, fourth, fourth)
    middle = add(second, third)
    mean = add(add(first, fourth), add(middle, middle))
    turn = add(times(mean_step, mean), times(bracket_step, cross(first, fourth)))
    return turn, add(first, scale(1.0 / 3.0, slopes))


@lanes_kernel
def _rkmk4(
    first: int,
    last: int,
    spins: NDArray[np.float64],
    n: int,
    axes: tuple[int, int, int],
    unit: Vector,
    per_unit: Vector,
    mean_step: Vector,
    bracket_step: Vector,
) -> None:
    widest_vectors()
    # q, L, l, then half the turn of a step.
    block, order = np.empty(13 * LANES), order_of(axes)
    x, y, z = 3 + order[4], 3 + order[5], 3 + order[6]
    for begin in range(first, last, LANES):
        load_block(spins, 0, order, begin, last, block)
        # Four columns, of which the first has been read.
        load_columns(spins, 6, (10, x, y, z), begin, last, block)
        for i in range(LANES):
            for k in range(3):
                kept = block[(7 + k) * LANES + i]
                block[(7 + k) * LANES + i] = kept if kept != 0.0 else per_unit[k] * block[(4 + k) * LANES + i]
        for _ in range(n):
            # In two loops: each is short enough for the processor to be at several of its vectors at once.
            for i in range(LANES):
                scaled = (block[7 * LANES + i], block[8 * LANES + i], block[9 * LANES + i])
                turn, scaled = step(scaled, mean_step, bracket_step)
                block[7 * LANES + i], block[8 * LANES + i], block[9 * LANES + i] = scaled
                block[10 * LANES + i], block[11 * LANES + i], block[12 * LANES + i] = turn
            for i in range(LANES):
                q = (block[i], block[LANES + i], block[2 * LANES + i], block[3 * LANES + i])
                turn = (block[10 * LANES + i], block[11 * LANES + i], block[12 * LANES + i])
                q = product(q, turn_by(turn))
                block[i], block[LANES + i], block[2 * LANES + i], block[3 * LANES + i] = q
        for i in range(LANES):
            for k in range(3):
                block[(4 + k) * LANES + i] = unit[k] * block[(7 + k) * LANES + i]
        store_block(spins, order, begin, last, block)
        store_columns(spins, 6, (order[6], x, y, z), begin, last, block)


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


def _units(dt: float, differences: Vector) -> Vector:
    """Return the units of L [kg m2/s] on three axes, in which half a step has no coefficients.

    differences: those of the inverse moments in dL/dt = L x w, on axes of which the second has the middle moment.
    """
    a, b, c = (max(abs(difference), LEAST_DIFFERENCE) for difference in differences)
    half = abs(dt) / 2
    sign = math.copysign(1.0, dt * differences[1])
    return sign / (half * math.sqrt(b * c)), sign / (half * math.sqrt(c * a)), sign / (half * math.sqrt(a * b))


def rkmk4(spins: NDArray[np.float64], n: int, dt: float, inverse_moments: Vector, gyroscopic: Vector | None) -> None:
    """Take n steps of q = q exp(dt/12 (w1 + 2 w2 + 2 w3 + w4) + dt^2/24 w1 x w4), with dL/dt = L x w by RK4.

    spins: q, L in body axes, and what the method keeps, 0 before the first step of a dt, (N, WIDTH), C order, altered
    in place; as `tumble.solver.integrators` has it.
    w1 ... w4 = I0^-1 L at the four stages of L, whose own equation does not know q: one exponential and one commutator
    a step.  The length of q is left to rounding.
    Source: Munthe-Kaas, "High order Runge-Kutta methods on manifolds" (1999), example 3; the single commutator as in
    Iserles, Munthe-Kaas, Norsett & Zanna, "Lie-group methods" (2000), section 4; order 4.
    """
    if gyroscopic is None:
        a, b, c = inverse_moments
        share_out(_constant_turn, len(spins), n * FLOPS, spins, n, (dt / 2 * a, dt / 2 * b, dt / 2 * c))
        return
    if n == 0 or dt == 0.0:
        # Nothing moves, and no step has a unit; but the kernel is compiled.
        spins, dt = spins[:0], 1.0
    middle = sorted(range(3), key=lambda axis: inverse_moments[axis])[1]
    axes = ((middle + 2) % 3, middle, (middle + 1) % 3)
    a, b, c = (inverse_moments[axis] for axis in axes)
    unit = x, y, z = _units(dt, (gyroscopic[axes[0]], gyroscopic[axes[1]], gyroscopic[axes[2]]))
    mean_step = (dt / 12 * a * x, dt / 12 * b * y, dt / 12 * c * z)
    bracket = dt * dt / 24
    bracket_step = (bracket * b * c * y * z, bracket * c * a * z * x, bracket * a * b * x * y)
    per_unit = (1 / x, 1 / y, 1 / z)
    share_out(_rkmk4, len(spins), n * FLOPS, spins, n, axes, unit, per_unit, mean_step, bracket_step)
