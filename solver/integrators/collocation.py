"""Collocation in three stages: all of gauss6 and radau5 but their numbers.

Over a step the slope of the state is a parabola in time, right at three instants, the stages.  Newton's method finds
it.  Its Jacobian is that of the equations of motion at the middle stage, by the complex step through the very force
terms, renewed where it serves badly; that decides how soon the slopes are found, not what is found.

A step is taken in halves, and those again, where Newton's method does not find it; where it turns the body too far for
a parabola; and where the instants at which forces are looked at do not show clearly what work they do, as at the touch
of a floor.  At that kink Newton's method can also jump between the two sides for ever: until the part of the step is so
short that either side is as good, to rounding.  Where no part is short enough, or too many are needed, the state
becomes nan.

Source: Hairer & Wanner, "Solving Ordinary Differential Equations II" (1996), sections IV.5 and IV.8.
"""

# The equations of motion take complex states, and states without rotation, which pyright cannot know.
# pyright: reportArgumentType=false

import math
from typing import NamedTuple

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from solver.compilation import inner, kernel
from solver.forces import Forces
from solver.motion import free_slope, load, slope, store
from solver.quaternion import Quaternion, conjugate, norm_squared, normalise, product, product_vector, stretch
from solver.vectors import Vector, dot, times

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
Columns = NDArray[np.int64]

# What is stepped of a state x, q, v, L_body: all of it, or only what moves, or only what turns.
WHOLE = np.arange(13)
PLACE = np.array([0, 1, 2, 7, 8, 9])
SPIN = np.array([3, 4, 5, 6, 10, 11, 12])

# So small that its square is lost in rounding, and with it the error of the derivative.
# Source: Squire & Trapp, "Using complex variables to estimate derivatives of real functions" (1998).
IMAGINARY = 1e-100
# A Jacobian serves badly where a correction is more than POOR of the one before.
MOST_CORRECTIONS, POOR = 20, 0.3
# Newton's method has ended where the next correction would be less than a rounding of what it corrects ...
LEAST_CHANGE = 2.0**-55
# ... or where rounding keeps the corrections from shrinking: so small, relative to the body's place and size.
ROUNDING = 1e-12
# The most that a step's forces may do of unclear work, in parts of the body's energy of motion.
UNCLEAR = 1e-3
# The power of a linear spring in a step is a polynomial of this degree, which nobody need call unclear.
SPRING_DEGREE = 5
# The furthest turn in a step that is not taken in halves [rad]; the least part of a step, and how many may be tried.
FURTHEST_TURN, LEAST_PART, MOST_PARTS = 1.0, 2.0**-40, 2**14


class Scheme(NamedTuple):
    """A method as numbers, for a step from 0 to 1.

    coefficients, (3, 3), and weights, (3,): the integrals of a parabola, given at the stages, up to the stages and 1.
    integrals and values, (k, 3): its integrals up to the instants at which forces are looked at, and its values there;
    means, (3, k): the force that counts for a stage, from the forces at the instants; roughness, (k,): the part of a
    curve that is beyond the fifth degree and so no linear spring's power, as far as the instants show one.
    real_rate, to_real, from_real: the real eigenvalue of the coefficients, its left and its right eigenvector;
    pair_rate, to_pair, from_pair: the same of one eigenvalue of the conjugate pair.
    """

    coefficients: Array
    weights: Array
    integrals: Array
    values: Array
    means: Array
    roughness: Array
    real_rate: float
    to_real: Array
    from_real: Array
    pair_rate: complex
    to_pair: ComplexArray
    from_pair: ComplexArray


def scheme(stages: Array, instants: Array) -> Scheme:
    """Return the method with these three stages, which looks at forces at these instants, all in [0, 1].

    The force that counts for a stage is its mean over the step, weighed with the stage's own parabola, by the
    quadrature of the instants; where they are the stages themselves, it is the force there.
    Source of the mean: Hairer, "Energy-preserving variant of collocation methods" (2010), definition 1.
    """
    parabolas = _lagrange(stages)
    integrals = [parabola.integ() for parabola in parabolas]
    coefficients = _at(integrals, stages)
    weights = _at(integrals, np.ones(1))[0]
    values = _at(parabolas, instants)
    # What makes Legendre's coefficients of a curve from its values at the instants: first its mean, last its roughness.
    legendre = np.linalg.inv(np.polynomial.legendre.legvander(2.0 * instants - 1.0, len(instants) - 1))
    rates, right = np.linalg.eig(coefficients)
    left = np.linalg.inv(right)
    real, pair = np.argmin(np.abs(np.imag(rates))), np.argmax(np.imag(rates))
    return Scheme(
        coefficients=coefficients,
        weights=weights,
        integrals=_at(integrals, instants),
        values=values,
        means=np.ascontiguousarray((legendre[0][:, None] * values / weights).T),
        roughness=legendre[-1].copy() if len(instants) > SPRING_DEGREE + 1 else np.zeros(len(instants)),
        real_rate=float(rates[real].real),
        to_real=np.ascontiguousarray(np.real(left[real])),
        from_real=np.ascontiguousarray(np.real(right[:, real])),
        pair_rate=complex(rates[pair]),
        to_pair=np.ascontiguousarray(left[pair]),
        from_pair=np.ascontiguousarray(right[:, pair]),
    )


def _lagrange(points: Array) -> list[Polynomial]:
    """Return the polynomials that are 1 at one of the points and 0 at the others."""
    others = [np.delete(points, number) for number in range(len(points))]
    return [Polynomial.fromroots(roots) / np.prod(own - roots) for own, roots in zip(points, others, strict=True)]


def _at(polynomials: list[Polynomial], points: Array) -> Array:
    """Return the values of polynomials, the columns, at points, the rows."""
    return np.ascontiguousarray(np.stack([polynomial(points) for polynomial in polynomials], axis=-1))


def turn(spins: Array, n: int, dt: float, method: Scheme, inverse_moments: Vector, gyroscopic: Vector | None) -> None:
    """Take n steps of dt [s] of the rotation alone, with no torque.

    spins: q, then L in body axes, (N, 7), altered in place; nan where a step was not found.
    """
    rows = np.zeros((len(spins), 14))
    rows[:, SPIN] = spins
    _collocate(rows, n, dt, SPIN, method, 1.0, inverse_moments, gyroscopic, Forces(1.0))
    spins[:] = rows[:, SPIN]


def fly(
    rows: Array,
    n: int,
    dt: float,
    method: Scheme,
    moments: Vector,
    inverse_moments: Vector | None,
    gyroscopic: Vector | None,
    forces: Forces,
) -> None:
    """Take n steps of dt [s] of whole states, or of position and velocity where inverse_moments is None.

    rows: x, q, v, L in body axes and the count of steps that were not found, (N, 14), altered in place.
    """
    columns = PLACE if inverse_moments is None else WHOLE
    reach = math.sqrt(max(moments) / forces.mass)
    _collocate(rows, n, dt, columns, method, reach, inverse_moments, gyroscopic, forces)


@kernel
def _collocate(
    rows: Array,
    n: int,
    dt: float,
    columns: Columns,
    method: Scheme,
    reach: float,
    inverse_moments: Vector | None,
    gyroscopic: Vector | None,
    forces: Forces,
) -> None:
    """Take n steps of these columns of rows; reach [m]: the body's size, as its radius of gyration has it."""
    state, slopes = np.empty(13), np.zeros((3, 13))
    for row in rows:
        for a in range(13):
            state[a] = row[a]
        for step in range(n):
            if not _advance(state, slopes, dt, columns, method, reach, inverse_moments, gyroscopic, forces):
                row[13] += n - step
                break
        for a in columns:
            row[a] = state[a]


@inner
def _advance(
    state: Array,
    slopes: Array,
    dt: float,
    columns: Columns,
    method: Scheme,
    reach: float,
    inverse_moments: Vector | None,
    gyroscopic: Vector | None,
    forces: Forces,
) -> bool:
    """Take one step, in halves where it must be, and return whether all of it was found; if not the state is nan."""
    done, part = 0.0, 1.0
    for _ in range(MOST_PARTS):
        if _found(state, slopes, part * dt, columns, method, reach, inverse_moments, gyroscopic, forces):
            for a in columns:
                state[a] += part * dt * _sum(method.weights, slopes, a)
            state[3], state[4], state[5], state[6] = normalise((state[3], state[4], state[5], state[6]))
            done += part
            if done == 1.0:
                return True
            # Back to the longest part that begins here.
            while part < 1.0 and done % (2.0 * part) == 0.0:
                part *= 2.0
        elif part > LEAST_PART:
            part /= 2.0
        else:
            break
    for a in columns:
        state[a] = math.nan
    return False


@inner
def _sum(weights: Array, slopes: Array, a: int) -> float:
    """Return the weighted sum of column a of three rows."""
    return weights[0] * slopes[0, a] + weights[1] * slopes[1, a] + weights[2] * slopes[2, a]


@inner
def _found(
    state: Array,
    slopes: Array,
    dt: float,
    columns: Columns,
    method: Scheme,
    reach: float,
    inverse_moments: Vector | None,
    gyroscopic: Vector | None,
    forces: Forces,
) -> bool:
    """Put the slopes at the stages of one step into slopes, (3, 13), and return whether they could be found."""
    m = len(columns)
    stages, wanted, corrections = np.empty((3, 13)), np.empty((3, 13)), np.zeros((3, 13))
    real, real_order, real_part = np.empty((m, m)), np.empty(m, np.int64), np.empty(m)
    pair, pair_order, pair_part = np.empty((m, m), np.complex128), np.empty(m, np.int64), np.empty(m, np.complex128)
    for i in range(3):
        for a in columns:
            slopes[i, a] = 0.0
    previous, stale = math.inf, True
    for _ in range(MOST_CORRECTIONS):
        for i in range(3):
            for a in range(13):
                stages[i, a] = state[a] + dt * _sum(method.coefficients[i], slopes, a)
        if not _turn(stages, dt, inverse_moments) <= FURTHEST_TURN:
            return False
        if stale:
            _put_jacobian(stages[1], columns, inverse_moments, gyroscopic, forces, real)
            for r in range(m):
                for c in range(m):
                    pair[r, c] = -dt * method.pair_rate * real[r, c]
                    real[r, c] = -dt * method.real_rate * real[r, c]
                pair[r, r] += 1.0
                real[r, r] += 1.0
            _factorise(real, real_order)
            _factorise(pair, pair_order)
        roughness = _put_wanted(state, slopes, stages, dt, method, inverse_moments, gyroscopic, forces, wanted)
        for r in range(m):
            real_part[r], pair_part[r] = 0.0, 0.0
            for i in range(3):
                missing = wanted[i, columns[r]] - slopes[i, columns[r]]
                real_part[r] += method.to_real[i] * missing
                pair_part[r] += method.to_pair[i] * missing
        _substitute(real, real_order, real_part)
        _substitute(pair, pair_order, pair_part)
        for i in range(3):
            for r in range(m):
                correction = method.from_real[i] * real_part[r] + 2.0 * (method.from_pair[i] * pair_part[r]).real
                slopes[i, columns[r]] += correction
                corrections[i, columns[r]] = dt * correction
        change, shift = _sizes(corrections, stages, reach)
        shrinking = change / previous if previous < math.inf else POOR
        if change * shrinking <= LEAST_CHANGE or (shrinking > 0.5 and shift < ROUNDING):
            least = forces.mass * (ROUNDING * reach / dt) ** 2
            return abs(dt * roughness) <= UNCLEAR * (_energy(stages, forces.mass, inverse_moments) + least)
        if not shrinking < (1.0 if stale else 2.0):
            return False
        previous, stale = change, shrinking > POOR
    return False


@inner
def _put_jacobian(
    state: Array,
    columns: Columns,
    inverse_moments: Vector | None,
    gyroscopic: Vector | None,
    forces: Forces,
    jacobian: Array,
) -> None:
    """Put the derivative of the slope by the state into jacobian, (m, m)."""
    near, change = np.empty(13, np.complex128), np.empty(13, np.complex128)
    for a in range(13):
        near[a] = state[a]
    for c in range(len(columns)):
        near[columns[c]] = complex(state[columns[c]], IMAGINARY)
        store(change, slope(load(near, inverse_moments), inverse_moments, gyroscopic, forces))
        near[columns[c]] = state[columns[c]]
        for r in range(len(columns)):
            jacobian[r, c] = change[columns[r]].imag / IMAGINARY


@inner
def _put_wanted(
    state: Array,
    slopes: Array,
    stages: Array,
    dt: float,
    method: Scheme,
    inverse_moments: Vector | None,
    gyroscopic: Vector | None,
    forces: Forces,
    wanted: Array,
) -> float:
    """Put the slopes that the equations of motion ask for at the stages into wanted, (3, 13).

    Returns how rough the power of the forces is [W].
    Velocities are a step's own parabola, positions its integral: so a damper never drives.
    A torque is averaged as what it pushes at q, and a stage turns the mean back: Cohen & Hairer, "Linear
    energy-preserving integrators for Poisson systems" (2011), eq. 3.
    """
    here, pushes = np.empty(13), np.zeros((3, 4))
    roughness = 0.0
    for i in range(3):
        store(wanted[i], free_slope(load(stages[i], inverse_moments), inverse_moments, gyroscopic))
    for k in range(len(method.means[0])):
        for a in range(7):
            here[a] = state[a] + dt * _sum(method.integrals[k], slopes, a)
        for a in range(7, 13):
            here[a] = _sum(method.values[k], stages, a)
        there = load(here, inverse_moments)
        _, _, acceleration, torque = slope(there, inverse_moments, None, forces)
        for i in range(3):
            for a in range(3):
                wanted[i, 7 + a] += method.means[i, k] * acceleration[a]
        _add_pushes(pushes, method.means, k, there[1], torque)
        power = forces.mass * dot(acceleration, there[2]) + _spin_power(torque, there[3], inverse_moments)
        roughness += method.roughness[k] * power
    _add_torques(wanted, stages, pushes, inverse_moments)
    return roughness


@inner
def _spin_power(torque: Vector | None, l_body: Vector | None, inverse_moments: Vector | None) -> float:
    """Return tau . w [W]."""
    if inverse_moments is None:
        return 0.0
    return dot(torque, times(inverse_moments, l_body))


@inner
def _energy(stages: Array, mass: float, inverse_moments: Vector | None) -> float:
    """Return the mean energy of motion at the stages [J]."""
    energy = 0.0
    for i in range(3):
        _, _, v, l_body = load(stages[i], inverse_moments)
        energy += (mass * dot(v, v) + _spin_power(l_body, l_body, inverse_moments)) / 6.0
    return energy


@inner
def _add_pushes(pushes: Array, means: Array, k: int, q: Quaternion | None, torque: Vector | None) -> None:
    """Add a torque at the instant k to what pushes at q, (3, 4): q tau~ / |q|^2."""
    if q is None:
        return
    push = stretch(1.0 / norm_squared(q), product_vector(q, torque))
    for i in range(3):
        for a in range(4):
            pushes[i, a] += means[i, k] * push[a]


@inner
def _add_torques(wanted: Array, stages: Array, pushes: Array, inverse_moments: Vector | None) -> None:
    """Add the torque that pushes at the q of a stage to the stage's dL/dt."""
    if inverse_moments is None:
        return
    for i in range(3):
        q, push = (
            (stages[i, 3], stages[i, 4], stages[i, 5], stages[i, 6]),
            (pushes[i, 0], pushes[i, 1], pushes[i, 2], pushes[i, 3]),
        )
        torque = product(conjugate(q), push)
        for a in range(3):
            wanted[i, 10 + a] += torque[1 + a]


@inner
def _turn(stages: Array, dt: float, inverse_moments: Vector | None) -> float:
    """Return how far the body turns in a step [rad]."""
    if inverse_moments is None:
        return 0.0
    furthest = 0.0
    for i in range(3):
        w_body = times(inverse_moments, (stages[i, 10], stages[i, 11], stages[i, 12]))
        furthest = max(furthest, dot(w_body, w_body))
    return abs(dt) * math.sqrt(furthest)


@inner
def _sizes(corrections: Array, stages: Array, reach: float) -> tuple[float, float]:
    """Return how large corrections of the stages are: of what they correct, and of the body's place and size."""
    dx, dq, dv, dl = _squares(corrections)
    x, _, v, l_body = _squares(stages)
    shift = max(dx / (x + reach * reach), dq)
    return math.sqrt(max(shift, max(_part(dv, v), _part(dl, l_body)))), math.sqrt(shift)


@inner
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


@inner
def _part(part: float, whole: float) -> float:
    """Return part / whole, and nothing for no part of nothing."""
    return part / whole if part != 0.0 else 0.0


@inner
def _factorise(matrix: Array | ComplexArray, order: Columns) -> None:
    """Replace a matrix by its factors L, below the diagonal, and U; the diagonal, of U, is inverted.

    order: the rows that partial pivoting exchanged.
    Source: Golub & Van Loan, "Matrix Computations" (2013), section 3.4.
    """
    n = len(matrix)
    for k in range(n):
        best, size = k, 0.0
        for i in range(k, n):
            candidate = abs(matrix[i, k].real) + abs(matrix[i, k].imag)
            if candidate > size:
                best, size = i, candidate
        order[k] = best
        if best != k:
            for j in range(n):
                matrix[k, j], matrix[best, j] = matrix[best, j], matrix[k, j]
        matrix[k, k] = 1.0 / matrix[k, k]
        for i in range(k + 1, n):
            matrix[i, k] *= matrix[k, k]
            for j in range(k + 1, n):
                matrix[i, j] -= matrix[i, k] * matrix[k, j]


@inner
def _substitute(matrix: Array | ComplexArray, order: Columns, right: Array | ComplexArray) -> None:
    """Replace the right-hand side of a linear equation by its solution, given the factors of its matrix."""
    n = len(matrix)
    for k in range(n):
        right[k], right[order[k]] = right[order[k]], right[k]
    for k in range(n):
        for j in range(k):
            right[k] -= matrix[k, j] * right[j]
    for k in range(n - 1, -1, -1):
        for j in range(k + 1, n):
            right[k] -= matrix[k, j] * right[j]
        right[k] *= matrix[k, k]
