"""Steps for what dies out far faster than it moves, such as a corner held by a damper: Radau's collocation.

A step is a polynomial from the start whose slope is right at s instants, the last the end; its order is 2s - 1 and it
damps what is too fast to follow.  Slopes and sums are in numbers of 32 digits; Newton's iteration needs derivatives and
a matrix factored in doubles only, which cost it turns, not digits.  The derivatives are those at every instant, not at
the start: what is a billion times stiffer along a line than across it allows that line to turn only then.
Source: Hairer & Wanner, "Solving Ordinary Differential Equations II" (1996), sections IV.5 and IV.8.
"""

from functools import cache
from math import comb
from typing import Any, NamedTuple

import numpy as np

from tumble.scenarios.frames import Array
from tumble.scenarios.truth.compilation import kernel
from tumble.scenarios.truth.double_double import add, minus, pairs, scaled, times
from tumble.scenarios.truth.forced.laws import SIZE
from tumble.scenarios.truth.forced.series import Program, expand
from tumble.scenarios.truth.rational import Fraction

ITERATIONS = 40
# What an iteration may still change when it counts as done, in scales; by how much it has to shrink each time; from
# where on the matrix is kept while it does; and the turns in which it may grow, with the derivatives of a rough guess.
CONVERGED, CONTRACTION, NEAR, ROUGH_TURNS = 1e-29, 0.3, 1e-7, 4
# The change of a number that tells a derivative: half of the digits for it, half for the difference.
NUDGE = 1e-14


class Tableau(NamedTuple):
    """matrix: stages = h matrix slopes, (2, s, s); powers: from the values at the start and the stages to the

    coefficients of their polynomial in t/h, (2, s + 1, s + 1); nodes: the stages' instants in t/h, (s,).
    """

    matrix: Array
    powers: Array
    nodes: Array


@cache
def tableau(stages: int) -> Tableau:
    """Return Radau's right-hand collocation with that many stages, to 32 digits."""
    from mpmath import MPContext

    mp: Any = MPContext()
    mp.prec = 400
    nodes = radau_nodes(mp, stages)
    # Slopes are told by a polynomial of degree s - 1, values by one of degree s that is 0 at the start.
    through_slopes = mp.matrix([[node**power for power in range(stages)] for node in nodes]) ** -1
    integrals = mp.matrix([[node ** (power + 1) / (power + 1) for power in range(stages)] for node in nodes])
    from_start = [mp.mpf(0), *nodes]
    through_values = mp.matrix([[node**power for power in range(stages + 1)] for node in from_start]) ** -1
    return Tableau(_pairs(integrals * through_slopes), _pairs(through_values), np.array(nodes, dtype=float))


def _pairs(matrix: Any) -> Array:
    return pairs([[Fraction(*number.as_integer_ratio()) for number in row] for row in matrix.tolist()])


def radau_nodes(mp: Any, stages: int) -> list[Any]:
    """Return the zeros of (P_s - P_{s-1})(2 t - 1), the last of which is 1."""
    series = np.zeros(stages + 1)
    series[-2:] = -1.0, 1.0
    rough = np.sort(np.polynomial.legendre.legroots(series))[:-1]
    defect = lambda u: mp.legendre(stages, u) - mp.legendre(stages - 1, u)  # noqa: E731
    return [*((1 + mp.findroot(defect, root)) / 2 for root in rough), mp.mpf(1)]


class Solved(NamedTuple):
    """A step: its series in t/h, (2, series, s + 1); the state at its end, (2, SIZE), which the series, being sums of

    large numbers, have with fewer digits; what it leaves unresolved, in scales.
    """

    series: Array
    end: Array
    unresolved: float


def continued(series: Array, longer: float, rule: Tableau) -> Array:
    """Return how a step's series, (2, series, s + 1), go on over another so many times as long: a guess of its stages,

    (2, s, SIZE), in doubles.
    """
    powers = (1 + longer * rule.nodes)[:, np.newaxis] ** np.arange(series.shape[2]) - 1
    stages = powers @ series[0, :SIZE].T
    return np.array((stages, np.zeros_like(stages)))


def solved(
    program: Program, state: Array, h: float, rule: Tableau, scales: Array, guess: Array | None = None
) -> Solved | None:
    """Return a step of h [s] from a state, (2, SIZE), or None where the iteration does not converge.

    scales: of the state's numbers, (SIZE,); guess: of the stages, (2, s, SIZE).
    """
    count = rule.matrix.shape[1]
    stages = np.zeros((2, count, SIZE)) if guess is None else guess
    values = np.zeros((2, count + 1, program.series))
    last, reuse, factors, order = np.inf, False, np.empty((0, 0)), np.empty(0, dtype=np.int64)
    for turn in range(ITERATIONS):
        off = defects(program, state, stages, h, rule.matrix, values)
        if not reuse:
            factors = newton_matrix(program, state, stages, h, rule.matrix[0], scales)
            order = factor(factors)
        moved = backsolved(factors, order, off.ravel()).reshape(count, SIZE)
        if not np.isfinite(moved).all():
            return None
        correct(stages, moved)
        change = float((abs(moved) / scales).max())
        if change <= CONVERGED:
            break
        slow = turn > 0 and change > CONTRACTION * last
        # The last digits only go round in circles; anything else does not converge.
        if slow and change < CONVERGED * 1e3:
            break
        if slow and not reuse and turn >= ROUGH_TURNS:
            return None
        last, reuse = change, change < NEAR and not slow
    else:
        return None
    series = polynomials(values, rule.powers)
    return Solved(series, values[:, -1, :SIZE].copy(), unresolved(series[0, :SIZE], scales))


def unresolved(coefficients: Array, scales: Array) -> float:
    """Return the last two Legendre coefficients of polynomials in t/h, (SIZE, s + 1), the larger, in scales.

    The last but one counts for a tenth, so that the last may not hide in a zero of its own.
    """
    degree = coefficients.shape[1] - 1
    # P_s(2 t - 1) = (2 s over s) (t^s - s/2 t^(s-1) + ...)
    last = coefficients[:, -1] / comb(2 * degree, degree)
    before = (coefficients[:, -2] + degree / 2 * coefficients[:, -1]) / comb(2 * degree - 2, degree - 1)
    return float((np.maximum(abs(last), 0.1 * abs(before)) / scales).max())


@kernel
def newton_matrix(program: Program, state: Array, stages: Array, h: float, weights: Array, scales: Array) -> Array:
    """Return the derivatives of what `defects` tells by the stages, with the opposite sign, (s SIZE, s SIZE)."""
    count = stages.shape[1]
    matrix, here = np.eye(count * SIZE), np.empty((2, SIZE))
    for node in range(count):
        for place in range(SIZE):
            stage = (stages[0, node, place], stages[1, node, place])
            here[0, place], here[1, place] = add((state[0, place], state[1, place]), stage)
        derivatives = slopes_by_state(program, here, scales)
        for other in range(count):
            for row in range(SIZE):
                for column in range(SIZE):
                    part = h * weights[other, node] * derivatives[row, column]
                    matrix[other * SIZE + row, node * SIZE + column] -= part
    return matrix


@kernel
def factor(matrix: Array) -> np.ndarray:
    """Put a matrix's factors in its place, by rows with pivots; return the rows' order.

    BLAS would start threads for so small a matrix.  Source: Golub & Van Loan, "Matrix Computations" (2013), 3.4.
    """
    size = len(matrix)
    order = np.arange(size)
    for step in range(size):
        pivot = step + np.argmax(np.abs(matrix[step:, step]))
        if pivot != step:
            order[step], order[pivot] = order[pivot], order[step]
            for column in range(size):
                matrix[step, column], matrix[pivot, column] = matrix[pivot, column], matrix[step, column]
        top = matrix[step]
        for row in range(step + 1, size):
            share = matrix[row, step] / top[step]
            matrix[row, step] = share
            if share != 0.0:
                below = matrix[row]
                for column in range(step + 1, size):
                    below[column] -= share * top[column]
    return order


@kernel
def backsolved(factors: Array, order: np.ndarray, right: Array) -> Array:
    """Return the solution of a linear system whose matrix `factor` has factored."""
    size = len(right)
    solution = right[order]
    for row in range(size):
        for column in range(row):
            solution[row] -= factors[row, column] * solution[column]
    for row in range(size - 1, -1, -1):
        for column in range(row + 1, size):
            solution[row] -= factors[row, column] * solution[column]
        solution[row] /= factors[row, row]
    return solution


@kernel
def slopes_by_state(program: Program, state: Array, scales: Array) -> Array:
    """Return the derivatives of the rates by the state's numbers, (SIZE, SIZE)."""
    high, low = np.zeros((program.series, 1)), np.zeros((program.series, 1))
    derivatives, base = np.empty((SIZE, SIZE)), np.empty((2, SIZE))
    for number in range(-1, SIZE):
        for place in range(SIZE):
            high[place, 0], low[place, 0] = state[0, place], state[1, place]
        if number >= 0:
            nudged = add((state[0, number], state[1, number]), (NUDGE * scales[number], 0.0))
            high[number, 0], low[number, 0] = nudged
        expand(program, 1.0, high, low)
        for place in range(SIZE):
            rate = program.rates[place]
            if number < 0:
                base[0, place], base[1, place] = high[rate, 0], low[rate, 0]
            else:
                moved = minus((high[rate, 0], low[rate, 0]), (base[0, place], base[1, place]))
                derivatives[place, number] = moved[0] / (NUDGE * scales[number])
    return derivatives


@kernel
def defects(program: Program, state: Array, stages: Array, h: float, matrix: Array, values: Array) -> Array:
    """Return how far the stages are from what the slopes at them say, (s, SIZE), and write every series' values there.

    stages: changes of the state since the start, (2, s, SIZE); values: at the start and the stages, (2, s + 1, series).
    """
    count = stages.shape[1]
    high, low = np.zeros((program.series, 1)), np.zeros((program.series, 1))
    for node in range(count + 1):
        for place in range(SIZE):
            here = (state[0, place], state[1, place])
            if node > 0:
                here = add(here, (stages[0, node - 1, place], stages[1, node - 1, place]))
            high[place, 0], low[place, 0] = here
        expand(program, 1.0, high, low)
        for row in range(program.series):
            values[0, node, row], values[1, node, row] = high[row, 0], low[row, 0]
    off = np.empty((count, SIZE))
    for stage in range(count):
        for place in range(SIZE):
            rate, total = program.rates[place], (0.0, 0.0)
            for other in range(count):
                weight = (matrix[0, stage, other], matrix[1, stage, other])
                total = add(total, times(weight, (values[0, other + 1, rate], values[1, other + 1, rate])))
            total = scaled(total, h)
            off[stage, place] = minus(total, (stages[0, stage, place], stages[1, stage, place]))[0]
    return off


@kernel
def correct(stages: Array, moved: Array) -> None:
    """Add doubles, (s, SIZE), to pairs, (2, s, SIZE), in place."""
    for stage in range(moved.shape[0]):
        for place in range(moved.shape[1]):
            here = (stages[0, stage, place], stages[1, stage, place])
            stages[0, stage, place], stages[1, stage, place] = add(here, (moved[stage, place], 0.0))


@kernel
def polynomials(values: Array, powers: Array) -> Array:
    """Return the coefficients of the polynomials through values at the nodes, (2, s + 1, n), as (2, n, s + 1)."""
    nodes, rows = values.shape[1], values.shape[2]
    coefficients = np.empty((2, rows, nodes))
    for row in range(rows):
        for power in range(nodes):
            first = (values[0, 0, row], values[1, 0, row])
            total = first if power == 0 else (0.0, 0.0)
            # Of the changes since the start, which are small where the step is.
            for node in range(1, nodes):
                weight = (powers[0, power, node], powers[1, power, node])
                total = add(total, times(weight, minus((values[0, node, row], values[1, node, row]), first)))
            coefficients[0, row, power], coefficients[1, row, power] = total
    return coefficients
