"""A soft plane that states its own law: springs with dampers at every point, and friction that is viscous when slow.

    N = max(0, -k y - c y')  where y < 0,     F = -mu N s / sqrt(s.s + v_s^2)

y is a point's height over the plane, s its slip.  The numbers follow from the scene: a body that lies on one point
sinks by SAG of its reach, so k = m g / (SAG reach); c gives a central impact of the whole mass the restitution of the
scene (Schwager & Poschel, Granular Matter 9 (2007) 465), but no less than what LARGEST_DAMPING leaves; v_s is SLOW of
sqrt(g reach).  So it is not the rigid law: it sinks, an impact at a corner is more damped, and it creeps on an incline
at v_s t / sqrt(1 - t^2), t = tan(angle) / mu.

A step is cut into parts that resolve the spring; far from the plane it is free flight in closed form.
"""

# `motion.State` is also that of a body that never turns; here every body has q and L.
# pyright: reportArgumentType=false, reportReturnType=false, reportOptionalIterable=false, reportGeneralTypeIssues=false

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tumble.solver.body import momentum_rate
from tumble.solver.compilation import inner, kernel
from tumble.solver.contact.approach import fastest_spin, turned_freely
from tumble.solver.contact.ground import Ground, lever_of, point_count, velocity_at
from tumble.solver.motion import State, plus_times
from tumble.solver.quaternion import normalise, product_vector, rotate, rotate_back
from tumble.solver.vectors import Vector, add, cross, dot, scale, times

Array = NDArray[np.float64]

COMPLIANT_WIDTH = 26
SAG, SLOW = 1e-5, 1e-3
# Of the critical damping: that of e = 0.03.
LARGEST_DAMPING = 3.0
# Where a scene has no gravity [m/s2].
USUAL_GRAVITY = 9.81
# Radians of the spring's phase, or of its damper's or of friction's decay, that a part of a step goes.
PART, FRICTION_PART = 0.025, 0.25


class Softness(NamedTuple):
    """k [N/m], c [N s/m], v_s [m/s]."""

    stiffness: float
    damping: float
    slow: float


def restitution_of(ratio: float) -> float:
    """Return the restitution of a damped spring that only pushes; ratio: of its damping to the critical one.

    Source: Schwager & Poschel, Granular Matter 9 (2007) 465, eqs. 15-17.
    """
    if ratio < 1.0:
        w = math.sqrt(1.0 - ratio * ratio)
        return math.exp(-ratio / w * (math.pi - math.atan2(2.0 * ratio * w, 1.0 - 2.0 * ratio * ratio)))
    if ratio == 1.0:
        return math.exp(-2.0)
    w = math.sqrt(ratio * ratio - 1.0)
    return math.exp(-ratio / w * math.log((ratio + w) / (ratio - w)))


def damping_ratio(restitution: float) -> float:
    """Return the ratio whose restitution that is, LARGEST_DAMPING where it would be more; by halving."""
    low, high = 0.0, LARGEST_DAMPING
    if restitution <= restitution_of(high):
        return high
    for _ in range(100):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if restitution_of(middle) > restitution else (low, middle)
    return 0.5 * (low + high)


def softness_of(ground: Ground) -> Softness:
    """Return the numbers of the law.

    Parameters
    ----------
    ground : the body and the plane

    Returns
    -------
    stiffness [N/m], damping [N s/m] and the speed below which friction is viscous [m/s]
    """
    pull = math.sqrt(sum(part * part for part in ground.gravity)) or USUAL_GRAVITY
    stiffness = ground.mass * pull / (SAG * ground.reach)
    damping = 2.0 * damping_ratio(ground.restitution) * math.sqrt(stiffness * ground.mass)
    return Softness(stiffness, damping, SLOW * math.sqrt(pull * ground.reach))


@inner
def push(state: State, softness: Softness, ground: Ground) -> tuple[Vector, Vector]:
    """Return the force of the plane [N], plane's frame, and its torque [N m], body axes."""
    x, q, v, l_body = state
    w = rotate(q, times(ground.inverse_moments, l_body))
    force, torque = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    for number in range(point_count(ground)):
        lever = lever_of(q, number, ground)
        y = x[2] + lever[2]
        if y < 0.0:
            u = velocity_at(v, w, lever)
            load = -softness.stiffness * y - softness.damping * u[2]
            if load > 0.0:
                share = -ground.friction * load / math.sqrt(u[0] * u[0] + u[1] * u[1] + softness.slow * softness.slow)
                one = (share * u[0], share * u[1], load)
                force, torque = add(force, one), add(torque, cross(lever, one))
    return force, rotate_back(q, torque)


@inner
def _friction_rate(state: State, softness: Softness, ground: Ground) -> float:
    """Return how fast friction can slow a slip now [1/s], no less."""
    x, q, v, l_body = state
    w = rotate(q, times(ground.inverse_moments, l_body))
    most = 1.0 / ground.mass + ground.reach * ground.reach * max(ground.inverse_moments)
    rate = 0.0
    for number in range(point_count(ground)):
        lever = lever_of(q, number, ground)
        y = x[2] + lever[2]
        if y < 0.0:
            u = velocity_at(v, w, lever)
            load = max(0.0, -softness.stiffness * y - softness.damping * u[2])
            rate += load / math.sqrt(u[0] * u[0] + u[1] * u[1] + softness.slow * softness.slow)
    return ground.friction * most * rate


@inner
def _slope(state: State, softness: Softness, ground: Ground) -> State:
    x, q, v, l_body = state
    q = normalise(q)
    force, torque = push((x, q, v, l_body), softness, ground)
    turning = product_vector(state[1], scale(0.5, times(ground.inverse_moments, l_body)))
    fall = add(ground.gravity, scale(1.0 / ground.mass, force))
    return v, turning, fall, add(momentum_rate(l_body, ground.gyroscopic), torque)


@inner
def _stepped(state: State, dt: float, softness: Softness, ground: Ground) -> State:
    """Return the state a step of the classical Runge-Kutta method on."""
    k_1 = _slope(state, softness, ground)
    k_2 = _slope(plus_times(state, 0.5 * dt, k_1), softness, ground)
    k_3 = _slope(plus_times(state, 0.5 * dt, k_2), softness, ground)
    k_4 = _slope(plus_times(state, dt, k_3), softness, ground)
    slopes = plus_times(plus_times(plus_times(k_1, 2.0, k_2), 2.0, k_3), 1.0, k_4)
    x, q, v, l_body = plus_times(state, dt / 6.0, slopes)
    return x, normalise(q), v, l_body


@inner
def _stays_clear(state: State, dt: float, ground: Ground) -> bool:
    """Return whether no point can reach the plane within dt, by a bound of its acceleration."""
    x, q, v, l_body = state
    w = rotate(q, times(ground.inverse_moments, l_body))
    fastest = fastest_spin(q, l_body, ground)
    bend = 2.0 * fastest * fastest * ground.reach - ground.gravity[2]
    for number in range(point_count(ground)):
        lever = lever_of(q, number, ground)
        if x[2] + lever[2] + dt * (velocity_at(v, w, lever)[2] - 0.5 * dt * max(bend, 0.0)) <= 0.0:
            return False
        if x[2] + lever[2] <= 0.0:
            return False
    return True


@kernel
def compliant_steps(rows: Array, n: int, dt: float, ground: Ground, softness: Softness) -> None:
    """Take n steps.

    Parameters
    ----------
    rows : (N, COMPLIANT_WIDTH)
        changed in place; plane's frame
    n
    dt : s
    ground
    softness
    """
    rate = math.sqrt(softness.stiffness / ground.mass)
    rate = max(rate, softness.damping / ground.mass)
    for row in rows:
        state = (
            (row[0], row[1], row[2]),
            (row[3], row[4], row[5], row[6]),
            (row[7], row[8], row[9]),
            (row[10], row[11], row[12]),
        )
        for _ in range(n):
            if _stays_clear(state, dt, ground):
                x, q, v, l_body = state
                q, l_body = turned_freely(q, l_body, dt, ground)
                g = ground.gravity
                state = (add(x, scale(dt, add(v, scale(0.5 * dt, g)))), q, add(v, scale(dt, g)), l_body)
            else:
                left = dt
                while left > 0.0:
                    spin = math.sqrt(dot(state[3], state[3])) * max(ground.inverse_moments)
                    part = PART / max(rate, spin, PART / FRICTION_PART * _friction_rate(state, softness, ground))
                    # A step in equal parts, as far as their length stays what it is.
                    part = left / math.ceil(left / part)
                    state = _stepped(state, part, softness, ground)
                    left = left - part if left > 1.5 * part else 0.0
        x, q, v, l_body = state
        row[0], row[1], row[2] = x
        row[3], row[4], row[5], row[6] = q
        row[7], row[8], row[9] = v
        row[10], row[11], row[12] = l_body


def compliant(rows: Array, n: int, dt: float, ground: Ground) -> None:
    """Take n steps of the soft law whose numbers follow from the ground: `compliant_steps`."""
    compliant_steps(rows, n, dt, ground, softness_of(ground))
