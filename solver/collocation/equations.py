"""What the equations of motion ask of the slopes at the stages of a step: all stages, and all instants, at once.

Numbers are eight: of the three stages, or of up to eight instants.
"""

# The equations of motion take eight states at once, and states without rotation, which pyright cannot know.
# pyright: reportArgumentType=false

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tumble.solver.collocation.scheme import Scheme
from tumble.solver.compilation import inlined
from tumble.solver.eight import COUNT, Eight, eight, fused_eight, lane, loaded
from tumble.solver.forces import Forces
from tumble.solver.motion import free_slope, if_turning, slope
from tumble.solver.quaternion import Quaternion, conjugate, norm_squared, product, product_vector, stretch
from tumble.solver.vectors import Vector, add, dot, scale, times

Array = NDArray[np.float64]
Eights = tuple[Eight, Eight, Eight]
# x, q, v and L, also of a body that never turns.
Whole = tuple[Vector, Quaternion, Vector, Vector]

NOTHING = (0.0, 0.0, 0.0)
# Where forces are looked at: at the instants of the mean, or at the stages.
AT_INSTANTS, AT_STAGES = 0, 1


class Slopes(NamedTuple):
    """dq/dt, dv/dt and dL/dt at the stages."""

    turns: Quaternion
    accelerations: Vector
    twists: Vector


class Stages(NamedTuple):
    """q, v and L at the stages."""

    q: Quaternion
    v: Vector
    l_body: Vector


class Pushes(NamedTuple):
    """What forces do at eight instants: q, v and L there, acceleration and torque; no q, L or torque without turns."""

    q: Quaternion | None
    v: Vector
    l_body: Vector | None
    acceleration: Vector
    torque: Vector | None


@inlined
def rows(factor: float, table: Array, first: int = 0) -> Eights:
    """Return three rows of a table, (N, 8), times a factor."""
    return factor * loaded(table, first), factor * loaded(table, first + 1), factor * loaded(table, first + 2)


@inlined
def _moved(start: float, rows: Eights, numbers: Eight) -> Eight:
    """Return a number plus three rows, each times the number of one stage."""
    first = fused_eight(rows[0], eight(lane(numbers, 0)), eight(start))
    return fused_eight(rows[2], eight(lane(numbers, 2)), fused_eight(rows[1], eight(lane(numbers, 1)), first))


@inlined
def moved(start: Vector, rows: Eights, slopes: Vector) -> Vector:
    """Return a vector plus three rows, each times the vector of one stage."""
    return _moved(start[0], rows, slopes[0]), _moved(start[1], rows, slopes[1]), _moved(start[2], rows, slopes[2])


@inlined
def moved_quaternion(start: Quaternion, rows: Eights, slopes: Quaternion) -> Quaternion:
    """Return a quaternion plus three rows, each times the quaternion of one stage."""
    x, y, z = moved((start[1], start[2], start[3]), rows, (slopes[1], slopes[2], slopes[3]))
    return _moved(start[0], rows, slopes[0]), x, y, z


@inlined
def stages_of(state: Whole, slopes: Slopes, to_stages: Eights) -> Stages:
    """Return the states at the stages, from the slopes there; to_stages: dt times the method's."""
    _, q, v, l_body = state
    return Stages(
        moved_quaternion(q, to_stages, slopes.turns),
        moved(v, to_stages, slopes.accelerations),
        moved(l_body, to_stages, slopes.twists),
    )


@inlined
def wanted(
    stages: Stages,
    pushes: Pushes,
    method: Scheme,
    look: int,
    inverse_moments: Vector | None,
    gyroscopic: Vector | None,
) -> tuple[Vector, Vector]:
    """Return dv/dt and dL/dt as the equations of motion ask for them at the stages, by what forces do where they look.

    A torque is averaged as what it pushes at q, and a stage turns the mean back: Cohen & Hairer, "Linear
    energy-preserving integrators for Poisson systems" (2011), eq. 3.
    """
    means, first, acceleration = method.means, look * COUNT, pushes.acceleration
    mean = (
        seen(acceleration[0], means, first),
        seen(acceleration[1], means, first),
        seen(acceleration[2], means, first),
    )
    return mean, _twists(stages, _push(pushes.q, pushes.torque, means, first), inverse_moments, gyroscopic)


@inlined
def pushes_at(
    state: Whole,
    slopes: Slopes,
    stages: Stages,
    dt: float,
    method: Scheme,
    look: int,
    inverse_moments: Vector | None,
    forces: Forces,
) -> Pushes:
    """Return what forces do where they look, AT_INSTANTS or AT_STAGES.

    Velocities are a step's own parabola, positions its integral: so a damper never drives.
    """
    integrals, values = rows(dt, method.integrals, 3 * look), rows(1.0, method.values, 3 * look)
    x = moved(state[0], integrals, stages.v)
    q = if_turning(moved_quaternion(state[1], integrals, slopes.turns), inverse_moments)
    v = moved(NOTHING, values, stages.v)
    l_body = if_turning(moved(NOTHING, values, stages.l_body), inverse_moments)
    _, _, acceleration, torque = slope((x, q, v, l_body), inverse_moments, None, forces)
    return Pushes(q, v, l_body, acceleration, torque)


@inlined
def seen(numbers: Eight, table: Array, first: int = 0) -> Eight:
    """Return the sum of eight rows of a table, (N, 8), each times the number at one instant."""
    even, odd = loaded(table, first) * eight(lane(numbers, 0)), loaded(table, first + 1) * eight(lane(numbers, 1))
    even = fused_eight(loaded(table, first + 2), eight(lane(numbers, 2)), even)
    odd = fused_eight(loaded(table, first + 3), eight(lane(numbers, 3)), odd)
    even = fused_eight(loaded(table, first + 4), eight(lane(numbers, 4)), even)
    odd = fused_eight(loaded(table, first + 5), eight(lane(numbers, 5)), odd)
    even = fused_eight(loaded(table, first + 6), eight(lane(numbers, 6)), even)
    return even + fused_eight(loaded(table, first + 7), eight(lane(numbers, 7)), odd)


@inlined
def _push(q: Quaternion | None, torque: Vector | None, means: Array, first: int) -> Quaternion | None:
    """Return what torques at the instants push at q, q tau~ / |q|^2, as it counts for each stage."""
    if q is None:
        return q
    a, b, c, d = stretch(1.0 / norm_squared(q), product_vector(q, torque))
    return seen(a, means, first), seen(b, means, first), seen(c, means, first), seen(d, means, first)


@inlined
def _twists(
    stages: Stages, push: Quaternion | None, inverse_moments: Vector | None, gyroscopic: Vector | None
) -> Vector:
    """Return dL/dt at the stages from what pushes at q there."""
    if push is None:
        return eight(0.0), eight(0.0), eight(0.0)
    _, _, _, free = free_slope((NOTHING, stages.q, stages.v, stages.l_body), inverse_moments, gyroscopic)
    torque = product(conjugate(stages.q), push)
    return add(free, (torque[1], torque[2], torque[3]))


@inlined
def spin_power(torque: Vector | None, l_body: Vector | None, inverse_moments: Vector | None) -> Eight:
    """Return tau . w [W]."""
    if inverse_moments is None:
        return 0.0
    return dot(torque, times(inverse_moments, l_body))


@inlined
def turned(
    q: Quaternion, turns: Quaternion, l_body: Vector, to_stages: Eights, inverse_moments: Vector | None
) -> Quaternion:
    """Return dq/dt = q w~/2 at the stages, for their L, from slopes that are nearly that.

    Put in twice: each time what is off becomes less by a quarter of the angle of the step's turn.
    """
    if inverse_moments is None:
        return turns
    half = scale(0.5, times(inverse_moments, l_body))
    once = product_vector(moved_quaternion(q, to_stages, turns), half)
    return product_vector(moved_quaternion(q, to_stages, once), half)
