"""The work of the forces over a step: whether it is seen clearly, and that it is done.

In a step of many periods a stiff force goes far up and down between the stages, and a mean of it that eight instants
see asks more of the slopes than a Jacobian of one instant can tell.  The forces at the stages do not; but they miss a
little of the work, which an impulse then does.
Source: Hairer, Lubich & Wanner, "Geometric Numerical Integration" (2006), section IV.4, of steps that are projected.
"""

# Where q is not None neither is L or the torque, which pyright cannot know.
# pyright: reportArgumentType=false

import math
from typing import NamedTuple

from tumble.solver.collocation.equations import (
    Pushes,
    Slopes,
    Stages,
    Whole,
    moved_quaternion,
    rows,
    seen,
    spin_power,
)
from tumble.solver.collocation.scheme import Scheme
from tumble.solver.compilation import inlined
from tumble.solver.eight import Eight, lane
from tumble.solver.quaternion import Quaternion, conjugate, norm_squared, product
from tumble.solver.vectors import Vector, add, dot, scale

# What is a rounding of the body's place and size, and what comes of it.
ROUNDING, FEW_ROUNDINGS = 1e-12, 2.0**-48
# The most that a step's forces may do of unclear work, in parts of the body's energy of motion.  Measured on bouncing
# floors and tethers that slacken, undamped, at 0.1 to 100 rad a step: with twenty times as much a step takes a fifth
# less and the energy is off by three to twenty times as much.
UNCLEAR = 1e-5
# The most work that the stages may miss, in parts of the energy of motion.
MOST_MISSED = 0.01


class Work(NamedTuple):
    """What work [J] is to be done in a step, if it is counted, and what roundings are worth.

    push, twist: the acceleration and the torque of the last force that is seen.
    """

    is_counted: bool
    done: float
    rounding: float
    push: Vector
    twist: Vector


UNCOUNTED = Work(False, 0.0, 0.0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


@inlined
def is_clear(
    power: Eight, stages: Stages, dt: float, method: Scheme, least: float, mass: float, inverse_moments: Vector | None
) -> bool:
    """Return whether the work [J] that the instants do not show clearly is little beside the energy of motion.

    Or beside the least [J] that counts.

    It is what the last two degrees of the power would come to, were two more pairs to fall off as they did.
    """
    degrees = seen(power, method.degrees)
    before, last = abs(lane(degrees, 4)) + abs(lane(degrees, 5)), abs(lane(degrees, 6)) + abs(lane(degrees, 7))
    falling = last / before if last < before else 1.0
    twice = mass * dot(stages.v, stages.v) + spin_power(stages.l_body, stages.l_body, inverse_moments)
    energy = (lane(twice, 0) + lane(twice, 1) + lane(twice, 2)) / 6.0
    return abs(dt) * last * falling * falling <= UNCLEAR * (energy + least)


@inlined
def least_energy(dt: float, reach: float, mass: float) -> float:
    """Return the energy [J] of a motion that in a step is a rounding of the body's place and size."""
    return mass * (ROUNDING * reach / dt) ** 2


@inlined
def rounding_worth(stiffness: float, dt: float, reach: float, mass: float) -> float:
    """Return what energy [J] a few roundings of the body's place make in its springs.

    stiffness: the sum of all modes' (w dt)^2.
    """
    return mass * abs(stiffness) * (FEW_ROUNDINGS * reach / dt) ** 2


@inlined
def power_of(pushes: Pushes, mass: float, inverse_moments: Vector | None) -> Eight:
    """Return the forces' power [W]."""
    return mass * dot(pushes.acceleration, pushes.v) + spin_power(pushes.torque, pushes.l_body, inverse_moments)


@inlined
def power_along(pushes: Pushes, slopes: Slopes, method: Scheme, mass: float, inverse_moments: Vector | None) -> Eight:
    """Return the forces' power [W] at the instants, on the way that the body takes.

    Its w is what q turns by, 2 q* dq/dt / |q|^2: between the stages that is not quite I^-1 times the parabola of L.
    """
    return mass * dot(pushes.acceleration, pushes.v) + _turn_power(pushes.q, pushes.torque, slopes, method)


@inlined
def _turn_power(q: Quaternion | None, torque: Vector | None, slopes: Slopes, method: Scheme) -> Eight:
    if q is None:
        return 0.0
    turns = moved_quaternion((0.0, 0.0, 0.0, 0.0), rows(1.0, method.values), slopes.turns)
    _, x, y, z = product(conjugate(q), turns)
    return 2.0 / norm_squared(q) * dot(torque, (x, y, z))


@inlined
def counted(power: Eight, pushes: Pushes, dt: float, method: Scheme, rounding: float) -> Work:
    """Return the work that the instants see, and the last force."""
    done = dt * lane(seen(power, method.degrees), 0)
    return Work(True, done, rounding, _last(pushes.acceleration), _last(pushes.torque))


@inlined
def balanced(state: Whole, after: Whole, work: Work, mass: float, inverse_moments: Vector | None) -> tuple[Whole, bool]:
    """Return the state after a step once that work is done in it, and whether it could be.

    What is missed is done by an impulse of so many seconds of the last force: by the smaller root of a quadratic
    equation, or not at all where roundings are worth more.
    """
    x, q, v, l_body = after
    before = 0.5 * _twice_energy(state[2], state[3], mass, inverse_moments)
    moving = 0.5 * _twice_energy(v, l_body, mass, inverse_moments)
    missed = work.done - (moving - before)
    if abs(missed) <= work.rounding:
        return after, True
    rate = mass * dot(work.push, v) + spin_power(work.twist, l_body, inverse_moments)
    square = rate * rate + 2.0 * missed * _twice_energy(work.push, work.twist, mass, inverse_moments)
    per = rate + math.copysign(math.sqrt(max(square, 0.0)), rate)
    if not (square >= 0.0 and per != 0.0 and abs(missed) <= MOST_MISSED * (before + moving)):
        return after, False
    seconds = 2.0 * missed / per
    return (x, q, add(v, scale(seconds, work.push)), add(l_body, scale(seconds, work.twist))), True


@inlined
def _last(numbers: Vector | None) -> Vector:
    """Return what a vector is at the last instant: nothing for a body that never turns."""
    if numbers is None:
        return 0.0, 0.0, 0.0
    return lane(numbers[0], 7), lane(numbers[1], 7), lane(numbers[2], 7)


@inlined
def _twice_energy(v: Vector, l_body: Vector, mass: float, inverse_moments: Vector | None) -> float:
    """Return m v^2 + L . w [J]."""
    return mass * dot(v, v) + spin_power(l_body, l_body, inverse_moments)
