"""Several flights in doubles side by side, for throws that differ in their numbers only: as lanes of one vector.

They take the steps of the first, of which the others are changes by a billionth, so that what the steps leave out
cancels in the differences.  A lane's clock goes at its own pace.  Throws above a floor, which each touch it at an
instant of their own, and throws whose equations differ in more than numbers are not flown so.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from tumble.scenarios.frames import Array
from tumble.scenarios.truth.compilation import inner, kernel
from tumble.scenarios.truth.double_double import pairs
from tumble.scenarios.truth.forced.flight import (
    AT_A_TIME,
    NO_NEXT_STEP,
    Budget,
    Integration,
    Trajectory,
    passages,
    start_of,
    struck,
)
from tumble.scenarios.truth.forced.laws import SIZE, equations
from tumble.scenarios.truth.forced.passage import (
    ARRIVED,
    GROWTH,
    LOST,
    SHRINKAGE,
    SMALLEST,
    UNDERWAY,
    Accuracy,
    Scales,
    stride,
)
from tumble.scenarios.truth.forced.series import LINEAR, QUOTIENT, ROOT, Program, summed
from tumble.scenarios.truth.lanes import WIDTH, lanes, load, root_of, store
from tumble.scenarios.truth.throw import Throw


class Numbers(NamedTuple):
    """A program's coefficients, (terms, WIDTH), and offsets, (offsets, WIDTH), and each lane's second, (1, WIDTH)."""

    coefficients: Array
    offsets: Array
    second: Array


class Together:
    """Flies throws, WIDTH at most, in doubles within a budget; program: of the first."""

    def __init__(
        self, throws: Sequence[Throw], accuracy: Accuracy, budget: Budget, program: Program, numbers: Numbers
    ) -> None:
        self._throws, self._budget, self._tolerance = throws, budget, accuracy.tolerance
        self._program, self._numbers = program, numbers
        self._high = np.zeros((program.series, accuracy.order + 1, WIDTH))
        self._leader = Integration(throws[0], accuracy, budget)
        self._scales = self._leader.scales(pairs(start_of(throws[0])), 1.0)
        # No step: what compiling takes is not the flight's.
        self._leap(np.zeros((SIZE, WIDTH)), 0.0, 0.0, np.zeros(0), np.zeros((0, SIZE, WIDTH)), 0, 0.0, 0)

    def run(self) -> list[Trajectory]:
        """Return the flights, which end where the first of them does.  Raises RayMissed."""
        throws, leader = self._throws, self._throws[0]
        states, steps = [pairs(start_of(throw)) for throw in throws], 0
        rows, known, why = np.full((len(throws), len(leader.times), 2, SIZE), np.nan), len(leader.times), ""
        for passage in passages(leader):
            states = [struck(state, passage, throw) for state, throw in zip(states, throws, strict=True)]
            within = slice(passage.first, passage.first + passage.instants)
            times = np.array([float(time - passage.begin) for time in leader.times[within]])
            done = int(np.searchsorted(times, 0.0, side="right"))
            rows[:, within][:, :done] = np.array(states)[:, np.newaxis]
            if passage.end == passage.begin:
                continue
            together, part = in_lanes([state[0] for state in states]), np.zeros((passage.instants, SIZE, WIDTH))
            span, begin = float(passage.end - passage.begin), done
            self._scales = self._leader.scales(states[0], span)
            clock, h, how = 0.0, span, UNDERWAY
            while how == UNDERWAY and not (steps and self._budget.is_up()):
                how, clock, h, done = self._leap(together, clock, span, times, part, done, h, AT_A_TIME)
                steps += AT_A_TIME
            rows[:, within][:, begin:done, 0] = part[begin:done, :, : len(throws)].transpose(2, 0, 1)
            rows[:, within][:, begin:done, 1] = 0.0
            at = f"at {float(passage.begin) + clock:.6g} s"
            if how == LOST or not np.isfinite(together).all():
                known, why = passage.first + done, NO_NEXT_STEP.format(at=at)
            elif how == UNDERWAY:
                known, why = passage.first + done, f"{self._budget.said} were up {at}"
            if why:
                break
            states = [np.stack((state, 0.0 * state)) for state in together.T[: len(throws)]]
        finite = np.isfinite(rows[:, :known]).all(axis=(0, 2, 3))
        known = known if finite.all() else int(np.argmin(finite))
        return [Trajectory(each[:known], steps, False, why) for each in rows]

    def _leap(self, state, clock, span, times, rows, done, h, most_steps) -> tuple[int, float, float, int]:
        """Make at most so many steps."""
        return integrate_together(
            state, clock, span, times, rows, done, h,
            self._program, self._numbers, self._high, self._scales, self._tolerance, most_steps,
        )  # fmt: skip


def side_by_side(throws: Sequence[Throw], accuracy: Accuracy, budget: Budget) -> Together | None:
    """Return what flies throws as one, or None where they do not have one program, or it would need 32 digits."""
    if accuracy.longer or not 1 < len(throws) <= WIDTH or any(throw.ground is not None for throw in throws):
        return None
    programs = [equations(throw, np.zeros(len(throw.points), dtype=bool)).program for throw in throws]
    first = programs[0]
    if not all(
        np.array_equal(getattr(first, name), getattr(other, name))
        for other in programs[1:]
        for name in ("operations", "terms", "rates")
    ):
        return None
    last = throws[0].times[-1]
    seconds = [np.array([float(throw.times[-1] / last) if last else 1.0]) for throw in throws]
    numbers = [[each.coefficients for each in programs], [each.offsets for each in programs], seconds]
    return Together(throws, accuracy, budget, first, Numbers(*map(in_lanes, numbers)))


def in_lanes(values: list[Array]) -> Array:
    """Return one array of each lane as an array, (..., WIDTH); the last goes on in the lanes that are left."""
    return np.stack([*values, *[values[-1]] * (WIDTH - len(values))], axis=-1)


@kernel
def integrate_together(
    state: Array,
    clock: float,
    end: float,
    times: Array,
    rows: Array,
    done: int,
    h: float,
    program: Program,
    numbers: Numbers,
    high: Array,
    scales: Scales,
    tolerance: float,
    most_steps: int,
) -> tuple[int, float, float, int]:
    """Integrate states, (SIZE, WIDTH), in place, from a clock to an end [s], and write them at the times, (R,) [s].

    rows: (R, SIZE, WIDTH), from `done` on; h: about how long a step may be [s]; high: room for the series, (series,
    order + 1, WIDTH).  Clocks are the first lane's.  Returns how it ended, the clock, the next step, the rows written.
    """
    order = high.shape[1] - 1
    for _ in range(most_steps):
        for number in range(SIZE):
            store(high, number * (order + 1), load(state, number))
        expand_together(program, numbers, h, order, high)
        ratio = min(stride(high[:, :, 0], order, tolerance, scales), GROWTH)
        if not ratio > 0.0:
            if h <= SMALLEST * end:
                return LOST, clock, h, done
            h *= SHRINKAGE
            continue
        last = not ratio * h < end - clock
        s = (end - clock) / h if last else ratio
        if s * h <= SMALLEST * end and not last:
            return LOST, clock, h, done
        now = end if last else clock + s * h
        while done < len(times) and times[done] <= now:
            for number in range(SIZE):
                value = value_together(high, number, (times[done] - clock) / h)
                store(rows, done * SIZE + number, value)
            done += 1
        for number in range(SIZE):
            store(state, number, value_together(high, number, s))
        clock, h = now, h * ratio
        if last:
            return ARRIVED, clock, h, done
    return UNDERWAY, clock, h, done


@inner
def expand_together(program: Program, numbers: Numbers, h: float, order: int, high: Array) -> None:
    """Write the series' coefficients as `tumble.scenarios.truth.forced.series.expand` does."""
    states, count = len(program.rates), order + 1
    step = h * load(numbers.second, 0)
    for k in range(count):
        for number in range(len(program.operations)):
            operation = program.operations[number]
            kind, left, right, offset = operation[0], operation[1], operation[2], operation[3]
            target = states + number
            if kind == LINEAR:
                value = load(numbers.offsets, offset) if k == 0 else lanes(0.0)
                for term in range(left, right):
                    value = value + load(numbers.coefficients, term) * load(high, program.terms[term] * count + k)
            else:
                a, b, first, last = summed(kind, left, right, target, k)
                value = convolved(high, a, b, first, last, k)
                if kind == QUOTIENT:
                    value = (load(high, left * count + k) - value) / load(high, right * count)
                elif kind == ROOT and k == 0:
                    value = root_of(load(high, left * count))
                elif kind == ROOT:
                    value = (load(high, left * count + k) - value) / (2.0 * load(high, target * count))
            store(high, target * count + k, value)
        if k < order:
            share = step / (k + 1.0)
            for state in range(states):
                store(high, state * count + k + 1, share * load(high, program.rates[state] * count + k))


@inner
def convolved(high: Array, a: int, b: int, first: int, last: int, k: int) -> Any:
    """Return the sum of a_j b_(k-j) for j from first to last."""
    count = high.shape[1]
    total = lanes(0.0)
    for j in range(first, last + 1):
        total = total + load(high, a * count + j) * load(high, b * count + k - j)
    return total


@inner
def value_together(high: Array, row: int, s: float) -> Any:
    """Return a series' value at t/h = s, by Horner's rule."""
    count = high.shape[1]
    total = lanes(0.0)
    for k in range(count - 1, -1, -1):
        total = total * s + load(high, row * count + k)
    return total
