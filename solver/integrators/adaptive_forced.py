"""Steps of whatever length a tolerance allows, of order eight, under forces."""

# Rotation is absent as a whole, which pyright cannot know: where q is not None neither is L or w.
# pyright: reportArgumentType=false

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tumble.solver.compilation import inlined, inner, kernel
from tumble.solver.dips import dips
from tumble.solver.dop853 import ERROR_3, ERROR_5, STAGES, WEIGHTS
from tumble.solver.forces import Forces
from tumble.solver.integrators.adaptive import FIRST_TURN, GREATEST_CHANGE, LEAST_CHANGE, combined, regrown
from tumble.solver.motion import State, load, plus_times, slope, store, times_state
from tumble.solver.quaternion import Quaternion, norm_squared, normalise
from tumble.solver.vectors import Vector, dot

Array = NDArray[np.float64]

# What rounding leaves of a place, to it.
ROUNDING = 2.0**-50
# Beyond so many steps for one instant the method gives up, and its state is nan.
MOST_STEPS = 1_000_000


@inner
def _mean(weights: Array, slopes: Array, count: int, inverse_moments: Vector | None) -> State:
    """Return the weighted sum of the first slopes, (count, 13)."""
    total = times_state(weights[0], load(slopes[0], inverse_moments))
    for stage in range(1, count):
        total = plus_times(total, weights[stage], load(slopes[stage], inverse_moments))
    return total


@inlined
def _step(
    state: State, dt: float, slopes: Array, inverse_moments: Vector | None, gyroscopic: Vector | None, forces: Forces
) -> State:
    """Return the state one step of dt [s] on, and leave the slopes of its stages in slopes, (12, 13)."""
    store(slopes[0], slope(state, inverse_moments, gyroscopic, forces))
    for stage in range(1, len(WEIGHTS)):
        ahead = plus_times(state, dt, _mean(STAGES[stage], slopes, stage, inverse_moments))
        store(slopes[stage], slope(ahead, inverse_moments, gyroscopic, forces))
    return plus_times(state, dt, _mean(WEIGHTS, slopes, len(WEIGHTS), inverse_moments))


@inner
def _speed(state: State, arm: float) -> float:
    """Return |v| + |L|/arm [m/s], for the arm mass times radius [kg m]: no point is much faster; of a slope [m/s2]."""
    _, _, v, l_body = state
    return math.sqrt(dot(v, v)) + math.sqrt(_square(l_body)) / arm


class Fineness(NamedTuple):
    """How large an error is one: of places [m], of velocities [m/s], of q, and of L [kg m2/s]."""

    place: float
    velocity: float
    attitude: float
    momentum: float


@inner
def _fineness(
    before: State,
    after: State,
    dt: float,
    slopes: Array,
    inverse_moments: Vector | None,
    radius: float,
    mass: float,
    tolerance: float,
) -> Fineness:
    """Return what errors count as one.

    A place is measured by radius and way; a velocity by the greatest of any point, or by the one that it would gain
    over the radius.  But no velocity is finer than what the rounding of places makes of it, through the spring that the
    step has felt: a body that has come to rest on stiff ones would never be precise enough.
    """
    arm = mass * radius
    first, last = load(slopes[0], inverse_moments), load(slopes[11], inverse_moments)
    speed = max(_speed(before, arm), _speed(after, arm)) + math.sqrt(radius * _speed(first, arm))
    moved, pulled = plus_times(after, -1.0, before), plus_times(last, -1.0, first)
    way = math.sqrt(dot(moved[0], moved[0]) + 4.0 * radius**2 * _square_of_quaternion(moved[1]))
    spring = _speed(pulled, arm) / way if way > 0.0 else 0.0
    rounding = abs(dt) * spring * ROUNDING * (math.sqrt(dot(before[0], before[0])) + radius)
    velocity = max(tolerance * speed, rounding)
    return Fineness(tolerance * (radius + abs(dt) * speed), velocity, tolerance, arm * velocity)


@inner
def _squared(mean: State, one: Fineness) -> float:
    """Return the square of a mean of slopes, in errors."""
    dx, dq, dv, dl = mean
    return (
        dot(dx, dx) / one.place**2
        + _square_of_quaternion(dq) / one.attitude**2
        + dot(dv, dv) / one.velocity**2
        + _square(dl) / one.momentum**2
    )


@inner
def _estimate(slopes: Array, dt: float, one: Fineness, inverse_moments: Vector | None) -> float:
    """Return about how many errors one step is off.  Source: Hairer, Norsett & Wanner (1993), eq. II.10.17."""
    fifth = _squared(_mean(ERROR_5, slopes, len(ERROR_5), inverse_moments), one)
    third = _squared(_mean(ERROR_3, slopes, len(ERROR_3), inverse_moments), one)
    return combined(fifth, third, dt)


@inlined
def _advanced(
    state: State,
    time: float,
    length: float,
    t: float,
    to_the_end: bool,
    slopes: Array,
    radius: float,
    inverse_moments: Vector | None,
    gyroscopic: Vector | None,
    forces: Forces,
    tolerance: float,
) -> tuple[State, float, float]:
    """Return the state, its time and the length of the next step: after the last whole step before t, or at t."""
    growth, tries = GREATEST_CHANGE, 0
    while time != t:
        left = t - time
        # Short fractions of a second, whose sums are exact.
        step = math.copysign(np.float64(np.float32(length)), t)
        last = abs(step) > abs(left)
        if last and not to_the_end:
            break
        if last:
            step, length = left, abs(left)
        ahead = _step(state, step, slopes, inverse_moments, gyroscopic, forces)
        one = _fineness(state, ahead, step, slopes, inverse_moments, radius, forces.mass, tolerance)
        off = _estimate(slopes, step, one, inverse_moments)
        tries += 1
        if tries > MOST_STEPS or step == 0.0:
            return times_state(math.nan, state), t, length
        if off <= 1.0 and dips(state, ahead, step, tolerance * radius, inverse_moments, forces.floor, forces.points):
            off = math.inf
        if off <= 1.0:
            state, time = _normalised(ahead), t if last else time + step
        # Of a step whose numbers overflow, or that jumps over a contact, all that is known is that it is too long.
        length, growth = regrown(length, off, growth) if off < math.inf else (LEAST_CHANGE * length, 1.0)
    return state, time, length


@kernel
def adaptive_forced(
    rows: Array,
    n: int,
    dt: float,
    moments: Vector,
    inverse_moments: Vector | None,
    gyroscopic: Vector | None,
    forces: Forces,
    tolerance: float,
) -> None:
    """Fly for n dt from where the count of n began, in steps that are each off by the tolerance at most.

    rows: x, q, v, L in body axes; the same at the end of the last whole step before now; its time since the count began
    [s] and the length of the next [s], 0 before the first, (N, 28).
    The whole steps do not depend on the instants asked for: from the last of them before an instant that is reached by
    steps which are forgotten.  Not by one back from beyond it, as in free flight: friction, seen backwards, is an
    explosion.  Where a force has a kink, as a floor has, steps are rejected until they are short; none jumps over a
    contact that comes and goes between its stages.
    Off is a place over the way of the step and the radius of gyration, a velocity over the greatest of any point
    there, whichever is more.
    Source: `tumble.solver.dop853`; step control: Hairer, Norsett & Wanner (1993), section II.4; order 8.
    """
    t = n * dt
    radius = math.sqrt((moments[0] + moments[1] + moments[2]) / (2.0 * forces.mass))
    slopes = np.empty((len(WEIGHTS), 13))
    for row in rows:
        anchor = row[13:26]
        state, time, length = load(anchor, inverse_moments), row[26], row[27]
        if length == 0.0:
            speed = _speed(state, forces.mass * radius)
            length = FIRST_TURN * tolerance**0.125 * radius / speed if speed > 0.0 else abs(t)
        for to_the_end in (False, True):
            state, time, length = _advanced(
                state, time, length, t, to_the_end, slopes, radius, inverse_moments, gyroscopic, forces, tolerance
            )
            if not to_the_end:
                store(anchor, state)
                row[26], row[27] = time, length
        store(row, state)


@inner
def _normalised(state: State) -> State:
    x, q, v, l_body = state
    return x, _unit(q), v, l_body


@inner
def _unit(q: Quaternion | None) -> Quaternion | None:
    if q is None:
        return q
    return normalise(q)


@inner
def _square(a: Vector | None) -> float:
    if a is None:
        return 0.0
    return dot(a, a)


@inner
def _square_of_quaternion(q: Quaternion | None) -> float:
    if q is None:
        return 0.0
    return norm_squared(q)
