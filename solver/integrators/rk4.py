"""The classical Runge-Kutta method: on quaternion and body-frame angular momentum, and on a state under forces."""

import math

import numpy as np
from numpy.typing import NDArray

from tumble.solver import motion
from tumble.solver.body import products
from tumble.solver.compilation import kernel, scalar
from tumble.solver.forces import Forces
from tumble.solver.fused import fused_scale, fused_times
from tumble.solver.motion import plus_times, slope
from tumble.solver.quaternion import Quaternion, plus, product, product_vector, stretch
from tumble.solver.spins import load, store
from tumble.solver.vectors import Vector, add, scale, times

# Steps between two looks at the quaternion's length.  In one step the length shrinks to no less than a half.
BLOCK = 64
# Of the stages after the first: how far ahead, in steps, and the weight.
STAGES = ((0.5, 2.0), (0.5, 2.0), (1.0, 1.0))


@scalar
def stage_momenta(
    momentum: Vector, dt: float, gyroscopic: Vector | None
) -> tuple[Vector, Vector, Vector, Vector, Vector]:
    """Return L at the four stages and after the step, for dL/dt = L x w; dt gyroscopic is taken in once a step."""
    if gyroscopic is None:
        return momentum, momentum, momentum, momentum, momentum
    half_step = scale(dt / 2.0, gyroscopic)
    slope_1 = products(momentum)
    second = fused_times(half_step, slope_1, momentum)
    slope_2 = products(second)
    third = fused_times(half_step, slope_2, momentum)
    slope_3 = products(third)
    fourth = fused_times(scale(2.0, half_step), slope_3, momentum)
    sum_of_slopes = fused_scale(2.0, add(slope_2, slope_3), add(slope_1, products(fourth)))
    return momentum, second, third, fourth, fused_times(scale(1.0 / 3.0, half_step), sum_of_slopes, momentum)


@scalar
def _increment(u1: Vector, u2: Vector, u3: Vector, u4: Vector) -> Quaternion:
    """Return the quaternion m of a step q + q m, for dq/dt = q w~/2, with u = dt/4 w at the four stages.

    The equation is linear in q, so q factors out of every stage: k1 ... k4 are dt/2 times the slopes from q = 1.  Where
    w is constant so is m, and the compiler takes it out of the loop.
    """
    k1 = (0.0, u1[0], u1[1], u1[2])
    k2 = product_vector((1.0, u1[0], u1[1], u1[2]), u2)
    k3 = product_vector((1.0 + k2[0], k2[1], k2[2], k2[3]), u3)
    k4 = product_vector((1.0 + 2.0 * k3[0], 2.0 * k3[1], 2.0 * k3[2], 2.0 * k3[3]), u4)
    return stretch(1.0 / 3.0, plus(plus(k1, k4), stretch(2.0, plus(k2, k3))))


@scalar
def _rescaled(q: Quaternion) -> Quaternion:
    """Return q times the power of two that brings its length near 1, which changes no digit of its direction."""
    _, exponent = math.frexp(max(abs(q[0]), abs(q[1]), abs(q[2]), abs(q[3])))
    return stretch(math.ldexp(1.0, -exponent), q)


@kernel
def rk4(spins: NDArray[np.float64], n: int, dt: float, inverse_moments: Vector, gyroscopic: Vector | None) -> None:
    """Take n steps of dq/dt = q w~/2 and dL/dt = L x w, with w = I0^-1 L, all in body axes.

    spins: q of any length, then L in body axes, (N, 7).
    The length of q is free to wander, for only its direction is read, and a normalisation would cost as much as a
    stage; powers of two keep it from underflow.  Body axes turn at |w|: stable up to |w| dt = 2 sqrt(2).
    Source: Kutta (1901); Hairer, Norsett & Wanner, "Solving Ordinary Differential Equations I" (1993), table II.1.2;
    order 4.
    """
    quarter_step = scale(dt / 4.0, inverse_moments)
    for spin in spins:
        q, momentum = load(spin)
        for done in range(0, n, BLOCK):
            for _ in range(min(BLOCK, n - done)):
                l1, l2, l3, l4, momentum = stage_momenta(momentum, dt, gyroscopic)
                u1, u2, u3, u4 = (
                    times(quarter_step, l1),
                    times(quarter_step, l2),
                    times(quarter_step, l3),
                    times(quarter_step, l4),
                )
                q = plus(q, product(q, _increment(u1, u2, u3, u4)))
            q = _rescaled(q)
        store(spin, q, momentum)


@scalar
def _rescaled_if_any(q: Quaternion | None) -> Quaternion | None:
    if q is None:
        return q
    return _rescaled(q)


@kernel
def rk4_forced(
    rows: NDArray[np.float64],
    n: int,
    dt: float,
    moments: Vector,
    inverse_moments: Vector | None,
    gyroscopic: Vector | None,
    forces: Forces,
) -> None:
    """Take n steps of the equations of motion, `tumble.solver.motion.slope`.

    rows: x, q of any length, v, L in body axes, (N, 13).  The length of q is treated, and the source is, as in rk4.
    """
    for row in rows:
        state = motion.load(row, inverse_moments)
        for done in range(0, n, BLOCK):
            for _ in range(min(BLOCK, n - done)):
                rate = slope(state, inverse_moments, gyroscopic, forces)
                six_slopes = rate
                for ahead, weight in STAGES:
                    rate = slope(plus_times(state, ahead * dt, rate), inverse_moments, gyroscopic, forces)
                    six_slopes = plus_times(six_slopes, weight, rate)
                state = plus_times(state, dt / 6.0, six_slopes)
            x, q, v, l_body = state
            state = x, _rescaled_if_any(q), v, l_body
        motion.store(row, state)
