"""Newton's method for the slopes at the stages of one step.

Its Jacobian is that of the equations of motion at the middle stage, by the complex step through the very force terms,
renewed where it serves badly; that decides how soon the slopes are found, not what is found.
Source: Hairer & Wanner, "Solving Ordinary Differential Equations II" (1996), section IV.8.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tumble.solver.collocation.corrections import Reduced, put_reduced, resolve
from tumble.solver.collocation.equations import energy, put_jacobian, put_wanted, weighted
from tumble.solver.collocation.scheme import Scheme
from tumble.solver.compilation import borrowing, scalar
from tumble.solver.forces import Forces
from tumble.solver.vectors import Vector, dot, times

Array = NDArray[np.float64]

# A Jacobian serves badly where a correction is more than POOR of the one before.  Measured on the stiff scenes of the
# catalogue, at their own steps and at 30 times those: with 0.1 to 0.9 a step costs the same within a third.  50
# corrections for 20 change nothing; 8 cost 1.6 times as much on a spring, for steps are then taken in halves.
MOST_CORRECTIONS, POOR = 20, 0.3
# A correction that shrinks no more with a new Jacobian leads nowhere; with an old one it may be the Jacobian's fault.
MOST_GROWTH_NEW, MOST_GROWTH_OLD = 1.0, 2.0
# Newton's method has ended where the next correction would be less than a rounding of what it corrects ...
LEAST_CHANGE = 2.0**-55
# ... or where rounding keeps the corrections from halving: so small, relative to the body's place and size.
HALVING, ROUNDING = 0.5, 1e-12
# The most that a step's forces may do of unclear work, in parts of the body's energy of motion: ten times less doubles
# the cost of a long step on a spring that comes and goes, ten times more halves it, and nothing else feels it.
UNCLEAR = 1e-3
# The furthest turn in a step that is not taken in halves [rad]: a parabola for dq/dt is off by some turn^4/4!, a few
# percent.  With half of it or twice as much no step of the stiff scenes costs a tenth more or less.
FURTHEST_TURN = 1.0


class Room(NamedTuple):
    """Where Newton's method works: states, slopes and corrections at the stages, (3, 13), and what resolves them."""

    stages: Array
    wanted: Array
    corrections: Array
    middle: Array
    instant: Array
    pushes: Array
    near: NDArray[np.complex128]
    change: NDArray[np.complex128]
    jacobian: Array
    real: Reduced
    pair: Reduced


@scalar
def room(inverse_moments: Vector | None) -> Room:
    """Return room for steps of a body."""
    m = 3 if inverse_moments is None else 6
    return Room(
        np.zeros((3, 13)),
        np.zeros((3, 13)),
        np.zeros((3, 13)),
        np.zeros(13),
        np.zeros(13),
        np.zeros((3, 4)),
        np.zeros(13, np.complex128),
        np.zeros(13, np.complex128),
        np.zeros((m, 13)),
        Reduced(np.empty((m, m)), np.empty(m, np.int64), np.empty(4), np.zeros(13), np.empty(m)),
        Reduced(
            np.empty((m, m), np.complex128),
            np.empty(m, np.int64),
            np.empty(4, np.complex128),
            np.zeros(13, np.complex128),
            np.empty(m, np.complex128),
        ),
    )


@borrowing
def found(
    state: Array,
    slopes: Array,
    here: Room,
    dt: float,
    method: Scheme,
    reach: float,
    inverse_moments: Vector | None,
    gyroscopic: Vector | None,
    forces: Forces,
) -> bool:
    """Put the slopes at the stages of one step into slopes, (3, 13), and return whether they could be found.

    reach [m]: the body's size, as its radius of gyration has it.
    """
    stages, middle, instant, pushes = here.stages, here.middle, here.instant, here.pushes
    _predict(slopes)
    previous, stale = math.inf, True
    for _ in range(MOST_CORRECTIONS):
        _put_stages(stages, state, slopes, dt, method)
        if not _turn(stages, dt, inverse_moments) <= FURTHEST_TURN:
            return False
        if stale:
            for a in range(13):
                middle[a] = stages[1, a]
            put_jacobian(middle, inverse_moments, gyroscopic, forces, here.near, here.change, here.jacobian)
            put_reduced(here.real, dt * method.real_rate, here.jacobian, middle, inverse_moments)
            put_reduced(here.pair, dt * method.pair_rate, here.jacobian, middle, inverse_moments)
        roughness = put_wanted(
            state, slopes, stages, dt, method, inverse_moments, gyroscopic, forces, instant, pushes, here.wanted
        )
        _correct(slopes, here, dt, method, inverse_moments)
        change, shift = _sizes(here.corrections, stages, reach)
        shrinking = change / previous if previous < math.inf else POOR
        if change * shrinking <= LEAST_CHANGE or (shrinking > HALVING and shift < ROUNDING):
            return _is_clear(dt * roughness, stages, dt, reach, forces.mass, inverse_moments)
        if not shrinking < (MOST_GROWTH_NEW if stale else MOST_GROWTH_OLD):
            return False
        previous, stale = change, shrinking > POOR
    return False


@borrowing
def _predict(slopes: Array) -> None:
    """Begin from a state that stands still.

    The slopes of the step before would serve better, but then a step would depend on more than the state it begins
    from, and two advances would not be one long one to the last bit.
    """
    for i in range(3):
        for a in range(13):
            slopes[i, a] = 0.0


@borrowing
def _put_stages(stages: Array, state: Array, slopes: Array, dt: float, method: Scheme) -> None:
    """Put the states at the stages, (3, 13), from the slopes there: y_i = y + dt sum_j a_ij y'_j."""
    for i in range(3):
        for a in range(13):
            stages[i, a] = state[a] + dt * weighted(method.coefficients[i], slopes, a)


@borrowing
def _correct(slopes: Array, here: Room, dt: float, method: Scheme, inverse_moments: Vector | None) -> None:
    """Correct the slopes by what Newton's method makes of what they miss; here.corrections: dt times that.

    Source: Hairer & Wanner (1996), eq. IV.8.13.
    """
    real, pair = here.real.sides, here.pair.sides
    for a in range(13):
        real[a], pair[a] = 0.0, 0.0
        for i in range(3):
            missing = here.wanted[i, a] - slopes[i, a]
            real[a] += method.to_real[i] * missing
            pair[a] += method.to_pair[i] * missing
    resolve(here.real, dt * method.real_rate, here.jacobian, here.middle, inverse_moments)
    resolve(here.pair, dt * method.pair_rate, here.jacobian, here.middle, inverse_moments)
    for i in range(3):
        for a in range(13):
            correction = method.from_real[i] * real[a] + 2.0 * (method.from_pair[i] * pair[a]).real
            slopes[i, a] += correction
            here.corrections[i, a] = dt * correction


@borrowing
def _is_clear(work: float, stages: Array, dt: float, reach: float, mass: float, inverse_moments: Vector | None) -> bool:
    """Return whether the work [J] that the instants do not show clearly is little beside the energy of motion."""
    least = mass * (ROUNDING * reach / dt) ** 2
    return abs(work) <= UNCLEAR * (energy(stages, mass, inverse_moments) + least)


@borrowing
def _turn(stages: Array, dt: float, inverse_moments: Vector | None) -> float:
    """Return how far the body turns in a step [rad]."""
    if inverse_moments is None:
        return 0.0
    furthest = 0.0
    for i in range(3):
        w_body = times(inverse_moments, (stages[i, 10], stages[i, 11], stages[i, 12]))
        furthest = max(furthest, dot(w_body, w_body))
    return abs(dt) * math.sqrt(furthest)


@borrowing
def _sizes(corrections: Array, stages: Array, reach: float) -> tuple[float, float]:
    """Return how large corrections of the stages are: of what they correct, and of the body's place and size."""
    dx, dq, dv, dl = _squares(corrections)
    x, _, v, l_body = _squares(stages)
    shift = max(dx / (x + reach * reach), dq)
    return math.sqrt(max(shift, max(_part(dv, v), _part(dl, l_body)))), math.sqrt(shift)


@borrowing
def _squares(states: Array) -> tuple[float, float, float, float]:
    """Return the mean |x|^2, |q|^2, |v|^2 and |L|^2 of three states."""
    x, q, v, l_body = 0.0, 0.0, 0.0, 0.0
    for i in range(3):
        for a in range(3):
            x += states[i, a] ** 2 / 3.0
            v += states[i, 7 + a] ** 2 / 3.0
            l_body += states[i, 10 + a] ** 2 / 3.0
        for a in range(3, 7):
            q += states[i, a] ** 2 / 3.0
    return x, q, v, l_body


@borrowing
def _part(part: float, whole: float) -> float:
    """Return part / whole, and nothing for no part of nothing."""
    return part / whole if part != 0.0 else 0.0
