"""The flight from one blow to the next, or to where the floor begins or ceases to push: steps of one series each."""

from typing import NamedTuple

import numpy as np

from tumble.scenarios.frames import Array
from tumble.scenarios.truth.compilation import inner, kernel
from tumble.scenarios.truth.double_double import add, minus, over, scaled
from tumble.scenarios.truth.forced.laws import AXES, MOMENTUM, SIZE, V
from tumble.scenarios.truth.forced.series import Program, expand, value_at
from tumble.scenarios.truth.forced.switches import NEVER, corrected, next_switch

ARRIVED, SWITCHED, UNDERWAY, LOST = 0, 1, 2, 3
# Of what the tolerance would allow; and how much longer a step may be than the one before.
CAUTION, GROWTH = 0.9, 8.0
# Where the series overflow, the next try is so much shorter.
SHRINKAGE = 1e-3
# A step that is this small a share of the passage gets nowhere.
SMALLEST = 1e-18


class Accuracy(NamedTuple):
    """How to integrate: order of the series; what its last terms may be, in scales of the state; whether in numbers of

    32 digits or in doubles; stages and tolerance of the collocation where something dies out too fast for series.
    """

    order: int
    tolerance: float
    longer: bool
    creeping: tuple[int, float]


class Scales(NamedTuple):
    """What errors are held against: length [m], slowest rate [1/s], moment of inertia [kg m2]; noise of next_switch."""

    length: float
    rate: float
    moment: float
    noise: Array


class Outcome(NamedTuple):
    """How a passage ended; the next step [s]; how many rows are written; which vertex switched, and to what."""

    how: int
    h: float
    rows: int
    vertex: int
    then: int


@kernel
def integrate(
    state: Array,
    clock: Array,
    end: Array,
    times: Array,
    rows: Array,
    done: int,
    h: float,
    program: Program,
    high: Array,
    low: Array | None,
    gauges: np.ndarray,
    contacts: np.ndarray,
    scales: Scales,
    tolerance: float,
    most_steps: int,
) -> Outcome:
    """Integrate a state, (2, SIZE), from a clock, (2,) [s], both changed in place, and write the state at the times.

    end: (2,) [s]; times: (2, R) [s]; rows: (R, 2, SIZE), from `done` on; h: about how long a step may be [s];
    high, low: room for the series, (series, order + 1), the low parts None for doubles.
    """
    order = high.shape[1] - 1
    for _ in range(most_steps):
        for number in range(SIZE):
            high[number, 0] = state[0, number]
            if low is not None:
                low[number, 0] = state[1, number]
        expand(program, h, high, low)
        ratio = min(stride(high, order, tolerance, scales), GROWTH)
        if not ratio > 0.0:
            if h <= SMALLEST * end[0]:
                return Outcome(LOST, h, done, 0, 0)
            h *= SHRINKAGE
            continue
        outcome = complete(state, clock, end, times, rows, done, h, ratio, high, low, gauges, contacts, scales)
        h, done = h * ratio, outcome.rows
        if outcome.how != UNDERWAY:
            return Outcome(outcome.how, h, done, outcome.vertex, outcome.then)
    return Outcome(UNDERWAY, h, done, 0, 0)


@inner
def complete(
    state: Array,
    clock: Array,
    end: Array,
    times: Array,
    rows: Array,
    done: int,
    h: float,
    ratio: float,
    high: Array,
    low: Array | None,
    gauges: np.ndarray,
    contacts: np.ndarray,
    scales: Scales,
) -> Outcome:
    """Make the step of h times the ratio [s] whose series are there, or less: up to the end, or to the first switch."""
    rest = minus((end[0], end[1]), (clock[0], clock[1]))
    s = (ratio, 0.0)
    last = not ratio * h < rest[0]
    if last:
        s = over(rest, (h, 0.0))
    switch = next_switch(high, gauges, contacts, s[0], scales.noise)
    if switch.at != NEVER:
        s = corrected(high, low, gauges[switch.vertex, switch.gauge], switch.at, s[0])
        last = False
    elif s[0] * h <= SMALLEST * end[0] and not last:
        return Outcome(LOST, h, done, 0, 0)
    now = (end[0], end[1]) if last else add((clock[0], clock[1]), scaled(s, h))
    while done < len(rows) and minus(now, (times[0, done], times[1, done]))[0] >= 0.0:
        since = over(minus((times[0, done], times[1, done]), (clock[0], clock[1])), (h, 0.0))
        for number in range(SIZE):
            rows[done, 0, number], rows[done, 1, number] = value_at(high, low, number, since)
        done += 1
    for number in range(SIZE):
        state[0, number], state[1, number] = value_at(high, low, number, s)
    clock[0], clock[1] = now
    how = SWITCHED if switch.at != NEVER else ARRIVED if last else UNDERWAY
    return Outcome(how, h, done, switch.vertex, switch.then)


@kernel
def complete_step(
    state: Array,
    clock: Array,
    end: Array,
    times: Array,
    rows: Array,
    done: int,
    h: float,
    series: Array,
    gauges: np.ndarray,
    contacts: np.ndarray,
    scales: Scales,
) -> Outcome:
    """Make a step of h [s] whose series, (2, series, order + 1), some other method has found."""
    return complete(
        state, clock, end, times, rows, done, h, 1.0, series[0], series[1], gauges, contacts, scales
    )  # fmt: skip


@kernel
def appraise(program: Program, state: Array, scales: Scales, high: Array, low: Array) -> Array:
    """Return what errors are held against, (SIZE,), and write every series from a state, (2, SIZE), to the first order.

    high, low: (series, 2).
    """
    for number in range(SIZE):
        high[number, 0], low[number, 0] = state[0, number], state[1, number]
    expand(program, 1.0, high, low)
    shares = np.empty(SIZE)
    write_scales(high, scales, shares)
    return shares


@inner
def stride(high: Array, order: int, tolerance: float, scales: Scales) -> float:
    """Return how long a step may be, in steps, for the last terms to be within the tolerance; 0 if they overflow."""
    shares = np.empty(SIZE)
    write_scales(high, scales, shares)
    longest = np.inf
    for number in range(SIZE):
        for power in (order - 1, order):
            share = abs(high[number, power]) / shares[number]
            if not np.isfinite(share):
                return 0.0
            if share > 0.0:
                longest = min(longest, CAUTION * (tolerance / share) ** (1.0 / power))
    return longest


@inner
def write_scales(high: Array, scales: Scales, shares: Array) -> None:
    """Write what an error of each number of the state is held against, (SIZE,).

    Lengths against the body, velocities against the fastest there is, the axes against 1, L against itself, or against
    what that velocity would be as a spin; and neither against less than its change in a step.
    """
    speed, turn = scales.length * scales.rate, 0.0
    for number in range(3):
        speed = max(speed, abs(high[V + number, 0]), abs(high[V + number, 1]))
        turn = max(turn, abs(high[MOMENTUM + number, 0]), abs(high[MOMENTUM + number, 1]))
    turn = max(turn, scales.moment * speed / scales.length)
    for number in range(SIZE):
        shares[number] = scales.length if number < V else speed if number < AXES else 1.0 if number < MOMENTUM else turn
