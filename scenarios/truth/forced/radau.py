"""One step of Radau's collocation: a polynomial from the start whose slope is right at s instants, the last the end.

Its order is 2s - 1 and it damps what is too fast to follow (L-stable).  The stages, changes of the state since the
start of the step, come from one another by plain iteration where the step resolves all there is, and by Newton's with
the exact derivatives where something stiff lies below it.
Source: Hairer & Wanner, "Solving Ordinary Differential Equations II" (1996), sections IV.5 and IV.8.
"""

from functools import cache
from typing import Any, NamedTuple

import numpy as np

from scenarios.frames import Array
from scenarios.truth.forced.compilation import inlined, inner
from scenarios.truth.forced.laws import AXES, MOMENTUM, SIZE, Forces, Solid, V, X, motion_of, slope

ITERATIONS = 24
# What an iteration may still change when it counts as done: beyond it there is only rounding.
CONVERGED, ROUNDING = 1e-12, 1e-17
# Of the complex step: so small that its square is nothing beside 1.
TINY = 1e-100


class Tableau(NamedTuple):
    """nodes: instants of the stages, in steps, (s,); matrix: stages = h matrix slopes, (s, s);

    powers: from the values at the start and the stages, (s + 1,), to the coefficients of their polynomial in
    2 t/h - 1, (s + 1, s + 1); tail: to its last two Legendre coefficients, (2, s + 1).
    """

    nodes: Array
    matrix: Array
    powers: Array
    tail: Array


@cache
def tableau(stages: int) -> Tableau:
    """Return Radau's right-hand collocation with that many stages, every number the double nearest to the exact one."""
    from mpmath import MPContext

    mp: Any = MPContext()
    mp.prec = 250
    nodes = radau_nodes(mp, stages)
    # Slopes are told by a polynomial of degree s - 1, values by one of degree s that is 0 at the start.
    through_slopes = mp.matrix([[node**power for power in range(stages)] for node in nodes]) ** -1
    integrals = mp.matrix([[node ** (power + 1) / (power + 1) for power in range(stages)] for node in nodes])
    from_start = [mp.mpf(0), *nodes]
    through_values = mp.matrix([[(2 * node - 1) ** power for power in range(stages + 1)] for node in from_start]) ** -1
    legendre = mp.matrix([[mp.legendre(power, 2 * node - 1) for power in range(stages + 1)] for node in from_start])
    return Tableau(
        np.array([float(node) for node in nodes]),
        _doubles(integrals * through_slopes),
        _doubles(through_values),
        _doubles(legendre**-1)[-2:],
    )


def _doubles(matrix: Any) -> Array:
    return np.array(matrix.tolist(), dtype=float)


def radau_nodes(mp: Any, stages: int) -> list[Any]:
    """Return the zeros of (P_s - P_{s-1})(2 t - 1), the last of which is 1."""
    series = np.zeros(stages + 1)
    series[-2:] = -1.0, 1.0
    rough = np.sort(np.polynomial.legendre.legroots(series))[:-1]
    defect = lambda u: mp.legendre(stages, u) - mp.legendre(stages - 1, u)  # noqa: E731
    return [*((1 + mp.findroot(defect, root)) / 2 for root in rough), mp.mpf(1)]


class Step(NamedTuple):
    """A step being made from the state y, (SIZE,): its stages and their slopes, (s, SIZE), the scale of each number of

    the state, (SIZE,), and room for one state and its slope, (SIZE,).  (Loops below name single numbers rather than
    rows, since to make a row of an array an object costs as much as all its sums.)
    """

    y: Array
    stages: Array
    slopes: Array
    scales: Array
    here: Array
    rates: Array


@inner
def new_step(stages: int) -> Step:
    """Return room for a step."""
    return Step(
        np.empty(SIZE),
        np.zeros((stages, SIZE)),
        np.zeros((stages, SIZE)),
        np.ones(SIZE),
        np.empty(SIZE),
        np.empty(SIZE),
    )


@inlined
def go_to(step: Step, stage: int) -> None:
    """Put the state at a stage, or at the start if that is -1, into its room."""
    for number in range(SIZE):
        step.here[number] = step.y[number] + (step.stages[stage, number] if stage >= 0 else 0.0)


@inlined
def evaluate(step: Step, solid: Solid, forces: Forces, pressing: np.ndarray) -> None:
    """Write the slopes at the stages."""
    for stage in range(len(step.stages)):
        go_to(step, stage)
        slope(step.here, solid, forces, pressing, step.rates)
        for number in range(SIZE):
            step.slopes[stage, number] = step.rates[number]


@inner
def set_scales(step: Step, h: float, solid: Solid, least: float) -> None:
    """Write what a change of each number of the state is held against during the step.

    Lengths against the body and the way it goes; velocities against its fastest point, and at least what would move it
    by that share of its size and distance; L against itself, or what that speed would be as the slowest of spins.
    """
    reach, turn = 0.0, 0.0
    speed = least * (solid.radius + length(step.y, X)) / h
    for stage in range(len(step.stages)):
        go_to(step, stage)
        stage_row, rates = step.stages[stage], step.slopes[stage]
        reach = max(reach, length(stage_row, X))
        spin = solid.radius * length(motion_of(step.here, solid).w, 0)
        speed = max(speed, length(step.here, V) + h * length(rates, V) + spin)
        turn = max(turn, length(step.here, MOMENTUM) + h * length(rates, MOMENTUM))
    slowest = min(solid.moments[0], solid.moments[1], solid.moments[2]) * speed / solid.radius
    for number in range(SIZE):
        if number < V:
            step.scales[number] = solid.radius + reach
        elif number < AXES:
            step.scales[number] = speed
        elif number < MOMENTUM:
            step.scales[number] = 1.0
        else:
            step.scales[number] = turn + slowest


@inlined
def length(row: Array | tuple, at: int) -> float:
    """Return the length of a vector in a row."""
    return np.sqrt(row[at] ** 2 + row[at + 1] ** 2 + row[at + 2] ** 2)


@inlined
def change_over(step: Step, stage: int, moved: Array) -> float:
    """Take over what a stage moves by, (SIZE,), and return the largest move, in scales; nan where any is."""
    largest = 0.0
    for number in range(SIZE):
        step.stages[stage, number] += moved[number]
        share = abs(moved[number]) / step.scales[number] if moved[number] != 0.0 else 0.0
        if not share <= largest:
            largest = share
    return largest


@inlined
def defect(step: Step, h: float, rule: Tableau, stage: int, off: Array) -> None:
    """Write how far a stage is from what the slopes say it is, (SIZE,)."""
    for number in range(SIZE):
        off[number] = -step.stages[stage, number]
    for other in range(len(step.stages)):
        share = h * rule.matrix[stage, other]
        for number in range(SIZE):
            off[number] += share * step.slopes[other, number]


@inlined
def is_done(change: float, earlier: float) -> bool:
    """Whether an iteration changes nothing any more but the rounding, which it does not improve on."""
    return change <= ROUNDING or (change < CONVERGED and change >= earlier)


@inner
def iterate(
    step: Step, h: float, rule: Tableau, solid: Solid, forces: Forces, pressing: np.ndarray, least: float
) -> tuple[bool, float]:
    """Improve the stages in place, each from all slopes, until nothing but rounding changes; least: as in set_scales.

    Returns whether that came about, and the factor by which the changes fell.
    """
    before, last, rate = np.inf, np.inf, 0.0
    moved = np.empty(SIZE)
    for iteration in range(ITERATIONS):
        evaluate(step, solid, forces, pressing)
        if iteration == 0:
            set_scales(step, h, solid, least)
        change = 0.0
        for stage in range(len(step.stages)):
            defect(step, h, rule, stage, moved)
            change = max(change, change_over(step, stage, moved))
        if is_done(change, before):
            return True, rate
        # Place and velocity are improved in turns, so it takes two iterations to see how fast they are.
        if change > CONVERGED:
            rate = np.sqrt(change / before)
        if not rate < 1.0 or not np.isfinite(change):
            return False, rate
        before, last = last, change
    return False, rate


@inner
def newton(
    step: Step, h: float, rule: Tableau, solid: Solid, forces: Forces, pressing: np.ndarray, least: float
) -> bool:
    """Improve the stages in place by Newton's iteration until nothing but rounding changes; return whether it did."""
    count = len(step.stages)
    matrix, off = np.empty((count * SIZE, count * SIZE)), np.empty((count, SIZE))
    last = np.inf
    for iteration in range(ITERATIONS):
        evaluate(step, solid, forces, pressing)
        if iteration == 0:
            set_scales(step, h, solid, least)
        for stage in range(count):
            defect(step, h, rule, stage, off[stage])
        put_derivatives(step, h, rule, solid, forces, pressing, matrix)
        if not np.isfinite(matrix).all():
            return False
        moved = np.linalg.solve(matrix, off.ravel()).reshape((count, SIZE))
        change = 0.0
        for stage in range(count):
            change = max(change, change_over(step, stage, moved[stage]))
        if is_done(change, last):
            return True
        if not np.isfinite(change) or (change > last and iteration > 3):
            return False
        last = change
    return False


@inner
def put_derivatives(
    step: Step, h: float, rule: Tableau, solid: Solid, forces: Forces, pressing: np.ndarray, matrix: Array
) -> None:
    """Write 1 - h (tableau x slope's derivatives at every stage), (s SIZE, s SIZE).

    Source of the complex step: Squire & Trapp, "Using complex variables to estimate derivatives of real functions",
    SIAM Rev. 40 (1998) 110.
    """
    here, rates = np.empty(SIZE, dtype=np.complex128), np.empty(SIZE, dtype=np.complex128)
    for other in range(len(step.stages)):
        for number in range(SIZE):
            go_to(step, other)
            for place in range(SIZE):
                here[place] = step.here[place]
            here[number] += TINY * 1j
            slope(here, solid, forces, pressing, rates)
            for stage in range(len(step.stages)):
                share = h * rule.matrix[stage, other] / TINY
                for row in range(SIZE):
                    matrix[stage * SIZE + row, other * SIZE + number] = -share * rates[row].imag
    for number in range(len(matrix)):
        matrix[number, number] += 1.0


@inlined
def stand_still(step: Step) -> None:
    """Guess stages that do not move."""
    for stage in range(len(step.stages)):
        for number in range(SIZE):
            step.stages[stage, number] = 0.0


@inner
def follow(step: Step, begin: float, ratio: float, rule: Tableau) -> None:
    """Replace the stages by those of a step `ratio` times as long from `begin`, in steps, on the same polynomial."""
    coefficients = np.zeros((len(rule.powers), SIZE))
    for power in range(len(coefficients)):
        for stage in range(len(step.stages)):
            for number in range(SIZE):
                coefficients[power, number] += rule.powers[power, stage + 1] * step.stages[stage, number]
    follow_to(coefficients, 2.0 * begin - 1.0, step.here)
    for stage in range(len(step.stages)):
        follow_to(coefficients, 2.0 * (begin + ratio * rule.nodes[stage]) - 1.0, step.rates)
        for number in range(SIZE):
            step.stages[stage, number] = step.rates[number] - step.here[number]


@inner
def follow_to(coefficients: Array, u: float, value: Array) -> None:
    """Write a polynomial's value, its coefficients a row a power, by Horner's rule."""
    for number in range(SIZE):
        total = 0.0
        for power in range(len(coefficients) - 1, -1, -1):
            total = total * u + coefficients[power, number]
        value[number] = total


@inlined
def unresolved(step: Step, rule: Tableau) -> float:
    """Return how much of the stages the last two powers of their polynomial make up, in scales.

    The last but one counts for a tenth, so that the last may not hide in a zero of its own.
    """
    largest = 0.0
    for number in range(SIZE):
        last, before = 0.0, 0.0
        for stage in range(len(step.stages)):
            before += rule.tail[0, stage + 1] * step.stages[stage, number]
            last += rule.tail[1, stage + 1] * step.stages[stage, number]
        part = max(abs(last), 0.1 * abs(before))
        largest = max(largest, part / step.scales[number] if part != 0.0 else 0.0)
    return largest
