"""A body that turns about a point, or an edge, which friction holds where it is: the equations of motion, of order 8.

The force of the plane is what keeps the point from accelerating, F = -K^-1 a with K the point's response and a what it
would do without; of an edge what the turn about it asks of the centre.
"""

import math

import numpy as np
from numpy.typing import NDArray

from tumble.solver.body import momentum_rate
from tumble.solver.compilation import inner
from tumble.solver.contact.ground import Ground, lever_of, lever_rate, response, solved, spin_of
from tumble.solver.dop853 import ERROR_3, ERROR_5, STAGES, WEIGHTS
from tumble.solver.integrators.adaptive import combined
from tumble.solver.quaternion import Quaternion, normalise, product_vector, rotate, rotate_back
from tumble.solver.vectors import Vector, add, cross, dot, scale, times

Array = NDArray[np.float64]
State = tuple[Vector, Quaternion, Vector, Vector]

TOLERANCE = 2e-16
# A step turns the body by no more [rad], and sees so what its points do between its ends.
LARGEST_TURN = 0.25
MOST_TRIES = 60


@inner
def reaction(state: State, first: int, second: int, ground: Ground) -> tuple[Vector, Vector]:
    """Return the force of the plane [N], plane's frame, and dL/dt in body axes [N m].

    first: the point that stays, of a disc the lowest of a rim, which rolls; second: the other end of an edge that does,
    -1 where none.
    """
    _, q, _, l_body = state
    w_body = times(ground.inverse_moments, l_body)
    free = momentum_rate(l_body, ground.gyroscopic)
    lever = lever_of(q, first, ground)
    w = rotate(q, w_body)
    if second >= 0:
        along = add(lever_of(q, second, ground), scale(-1.0, lever))
        along = scale(1.0 / math.sqrt(dot(along, along)), along)
        arm = add(scale(dot(lever, along), along), scale(-1.0, lever))
        axis = rotate_back(q, along)
        moment = dot(axis, times(ground.moments, axis)) + ground.mass * dot(arm, arm)
        bend = ground.mass * dot(cross(arm, ground.gravity), along) / moment
        pull = add(scale(bend, cross(along, arm)), cross(w, cross(w, arm)))
        force = scale(ground.mass, add(pull, scale(-1.0, ground.gravity)))
        return force, scale(bend, times(ground.moments, axis))
    bend = rotate(q, times(ground.inverse_moments, free))
    without = add(ground.gravity, add(cross(bend, lever), cross(w, lever_rate(q, w, first, ground))))
    force = scale(-1.0, solved(response(q, lever, ground), without))
    return force, add(free, rotate_back(q, cross(lever, force)))


@inner
def step(state: State, length: float, first: int, second: int, ground: Ground, slopes: Array) -> State:
    """Return the state a step [s] on, and leave the stages' slopes in slopes, (12, 13)."""
    stage_state = state
    for stage in range(13):
        sums = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        x_0, x_1, x_2, q_0, q_1, q_2, q_3, v_0, v_1, v_2, l_0, l_1, l_2 = sums
        for before in range(min(stage, 12)):
            weight = length * (STAGES[stage, before] if stage < 12 else WEIGHTS[before])
            x_0 += weight * slopes[before, 0]
            x_1 += weight * slopes[before, 1]
            x_2 += weight * slopes[before, 2]
            q_0 += weight * slopes[before, 3]
            q_1 += weight * slopes[before, 4]
            q_2 += weight * slopes[before, 5]
            q_3 += weight * slopes[before, 6]
            v_0 += weight * slopes[before, 7]
            v_1 += weight * slopes[before, 8]
            v_2 += weight * slopes[before, 9]
            l_0 += weight * slopes[before, 10]
            l_1 += weight * slopes[before, 11]
            l_2 += weight * slopes[before, 12]
        x, q, v, l_body = state
        stage_state = (
            (x[0] + x_0, x[1] + x_1, x[2] + x_2),
            normalise((q[0] + q_0, q[1] + q_1, q[2] + q_2, q[3] + q_3)),
            (v[0] + v_0, v[1] + v_1, v[2] + v_2),
            (l_body[0] + l_0, l_body[1] + l_1, l_body[2] + l_2),
        )
        if stage == 12:
            break
        force, twist = reaction(stage_state, first, second, ground)
        # q as it is, not normalised: its length is a constant of the exact equation.
        turning = product_vector(
            (q[0] + q_0, q[1] + q_1, q[2] + q_2, q[3] + q_3),
            scale(0.5, times(ground.inverse_moments, stage_state[3])),
        )
        slopes[stage, 0], slopes[stage, 1], slopes[stage, 2] = stage_state[2]
        slopes[stage, 3], slopes[stage, 4], slopes[stage, 5], slopes[stage, 6] = turning
        slopes[stage, 7] = ground.gravity[0] + force[0] / ground.mass
        slopes[stage, 8] = ground.gravity[1] + force[1] / ground.mass
        slopes[stage, 9] = ground.gravity[2] + force[2] / ground.mass
        slopes[stage, 10], slopes[stage, 11], slopes[stage, 12] = twist
    return stage_state


@inner
def _off(slopes: Array, length: float, sizes: tuple[float, float, float]) -> float:
    """Return about how far a step was off: in x, v and L over their sizes, and in q."""
    fifth, third = 0.0, 0.0
    for part in range(13):
        five, three = 0.0, 0.0
        for stage in range(12):
            five += ERROR_5[stage] * slopes[stage, part]
            three += ERROR_3[stage] * slopes[stage, part]
        size = sizes[0] if part < 3 else 1.0 if part < 7 else sizes[1] if part < 10 else sizes[2]
        fifth += (five / size) * (five / size)
        third += (three / size) * (three / size)
    return combined(fifth, third, length)


@inner
def good_step(
    state: State, length: float, first: int, second: int, ground: Ground, slopes: Array
) -> tuple[float, State]:
    """Return how long a step [s] is within the tolerance, no longer than one that turns the body far, and its end."""
    w = spin_of(state[1], state[3], ground)
    pull = math.sqrt(dot(ground.gravity, ground.gravity))
    swing = math.sqrt(pull / ground.reach)
    rate = math.sqrt(dot(w, w)) + swing
    length = min(length, LARGEST_TURN / rate) if length > 0.0 else 0.5 * LARGEST_TURN / rate
    least = min(ground.moments[0], ground.moments[1], ground.moments[2])
    sizes = (ground.reach, ground.reach * rate, least * rate)
    then = step(state, length, first, second, ground, slopes)
    for _ in range(MOST_TRIES):
        off = _off(slopes, length, sizes) / TOLERANCE
        if off <= 1.0:
            break
        length *= max(0.2, 0.9 * off**-0.125)
        then = step(state, length, first, second, ground, slopes)
    return length, then


@inner
def hold(state: State, first: int, second: int, ground: Ground) -> float:
    """Return how far friction is from giving way [N], negative where it has."""
    force, _ = reaction(state, first, second, ground)
    return ground.friction * force[2] - math.sqrt(force[0] * force[0] + force[1] * force[1])
