"""A whole throw with forces: the blows, and the passages between them.

What is read from the scene and what a blow does is exact, in fractions; a passage is integrated in numbers of 32
digits, or for the sensitivities in doubles.
"""

from collections.abc import Iterator
from itertools import zip_longest
from time import thread_time
from typing import NamedTuple

import numpy as np

from tumble.scenarios.frames import Array
from tumble.scenarios.truth.deadline import Deadline, current
from tumble.scenarios.truth.double_double import fractions_of, pairs
from tumble.scenarios.truth.flight import lever
from tumble.scenarios.truth.forced.collocation import continued, slopes_by_state, solved, tableau
from tumble.scenarios.truth.forced.laws import AXES, MOMENTUM, SIZE, Equations, V, X, equations
from tumble.scenarios.truth.forced.passage import (
    ARRIVED,
    CAUTION,
    LOST,
    SMALLEST,
    SWITCHED,
    UNDERWAY,
    Accuracy,
    Outcome,
    Scales,
    appraise,
    complete_step,
    integrate,
)
from tumble.scenarios.truth.forced.series import Program
from tumble.scenarios.truth.forced.switches import ABOVE, HEIGHT, IDLE, PRESSING, THRUST
from tumble.scenarios.truth.inertia import Numbers
from tumble.scenarios.truth.rational import Fraction, cross
from tumble.scenarios.truth.throw import ExactImpulse, Throw

# Steps between two looks at the clock, and how many switches may come without an instant between them.
AT_A_TIME, MOST_SWITCHES = 500, 200
# Seconds of processor time for the answer, as much for its check, and for all that the inputs do.
BUDGET_S = 20.0
# How many e-folds of a decay a step by series bears, and how many such steps are too many.
STABLE, STIFF_STEPS = 15.0, 4000
# How much longer a collocation step may be than the one before, and what is left of one that failed.
LONGER, FAILED = 5.0, 0.2
# How much longer it may be for its polynomial to say about where it goes.
FORESEEN = 2.0
# What makes the last step end beyond the end, not a rounding before it.
REACHING = 1 + 1e-15
# The shares of size and distance, and of the thrust they make, below which a floor's gauge is rounding.
NOISE, NOISE_IN_DOUBLES = 1e-27, 1e-15
NO_NEXT_STEP = "the motion has no next step {at}: it has no direction there, or no finite rates"


class Trajectory(NamedTuple):
    """The states at the instants that were reached, (R, 2, SIZE), how many steps it took, whether some by collocation,

    and why it went no further.
    """

    rows: Array
    steps: int
    crept: bool
    why: str


class Passage(NamedTuple):
    """The way from one instant with blows to the next, or to the throw's end: which blows, begin and end [s], the first

    of the throw's instants within, and how many there are.
    """

    blows: list[int]
    begin: Fraction
    end: Fraction
    first: int
    instants: int


class Budget:
    """BUDGET_S of this thread's processor time, from the first question on: compiling, which comes before, is free.

    And no more wall time than each part of the truth may take: the answer, its check and the inputs have one each.
    """

    def __init__(self) -> None:
        self._end: float | None = None
        self._wall = Deadline(float("inf"))

    def is_up(self) -> bool:
        """Return whether it is used up."""
        return self.left_s() < 0.0

    def left_s(self) -> float:
        """Return what is left of it [s]."""
        if self._end is None:
            self._end, self._wall = thread_time() + BUDGET_S, Deadline(current().limit_s)
        return min(self._end - thread_time(), self._wall.left_s())

    @property
    def said(self) -> str:
        """What it is, in words: what comes first."""
        if current().limit_s < BUDGET_S:
            return f"the {current().limit_s:g} s of --time-limit"
        return f"the {BUDGET_S:g} s of processor time that each flight is given"


class Integration:
    """Flies one throw in one manner within a budget."""

    def __init__(self, throw: Throw, accuracy: Accuracy, budget: Budget) -> None:
        self._throw, self._accuracy, self._budget = throw, accuracy, budget
        self._equations: dict[bytes, Equations] = {}
        self.steps, self.crept = 0, False
        # The series of the collocation step before, and how long it was [s], where the motion went on from it.
        self._before: tuple[Array, float] | None = None
        self.length = length_of(throw)

    def run(self) -> Trajectory:
        """Return the flight, blows of an instant included in its row.  Raises RayMissed."""
        throw = self._throw
        state = pairs(start_of(throw))
        rows = np.full((len(throw.times), 2, SIZE), np.nan)
        for passage in passages(throw):
            state, first = struck(state, passage, throw), passage.first
            reached, why = self._advance(state, passage.begin, passage.end, rows, first, passage.instants)
            if why:
                return Trajectory(rows[: first + reached], self.steps, self.crept, why)
        return Trajectory(rows, self.steps, self.crept, "")

    def _advance(
        self, state: Array, begin: Fraction, end: Fraction, rows: Array, first: int, count: int
    ) -> tuple[int, str]:
        """Fly from one blow to the next; return how many rows were reached, and why not all."""
        times = pairs([time - begin for time in self._throw.times[first : first + count]])
        span, clock = pairs([end - begin])[:, 0], np.zeros(2)
        part = rows[first : first + count]
        done = int(np.searchsorted(times[0], 0.0, side="right"))
        part[:done] = state
        if end == begin:
            return done, ""
        scales = self.scales(state, float(span[0]))
        contacts = self._contacts(state, scales)
        h, switches, stiff, self._before = float(span[0]), 0, None, None
        while True:
            program, gauges = self._equations_for(contacts)
            if stiff is None:
                stiff = self._is_stiff(program, state, scales, float(span[0] - clock[0]))
            step = self._creep if stiff else self._leap
            before = clock[0]
            outcome = step(state, clock, span, times, part, done, h, program, gauges, contacts, scales)
            done, h = outcome.rows, outcome.h
            at = f"at {float(begin) + clock[0]:.6g} s"
            if outcome.how == ARRIVED:
                return done, ""
            if outcome.how == LOST:
                return done, NO_NEXT_STEP.format(at=at)
            if outcome.how == SWITCHED:
                contacts[outcome.vertex] = outcome.then
                switches, stiff = (0 if clock[0] > before else switches + 1), None
                self._before = None
            if switches > MOST_SWITCHES:
                return done, f"the floor pushes on and off without end {at}"
            if self._budget.is_up():
                return done, f"{self._budget.said} were up {at}"

    def _leap(self, state, clock, span, times, part, done, h, program, gauges, contacts, scales) -> Outcome:
        """Make some hundred steps by series."""
        high = np.zeros((program.series, self._accuracy.order + 1))
        low = np.zeros_like(high) if self._accuracy.longer else None
        self.steps += AT_A_TIME
        return integrate(
            state, clock, span, times, part, done, h,
            program, high, low, gauges, contacts, scales, self._accuracy.tolerance, AT_A_TIME,
        )  # fmt: skip

    def _creep(self, state, clock, span, times, part, done, h, program, gauges, contacts, scales) -> Outcome:
        """Make one step by collocation."""
        stages, tolerance = self._accuracy.creeping
        rule = tableau(stages)
        shares = appraise(program, state, scales, *np.zeros((2, program.series, 2)))
        while h > SMALLEST * span[0]:
            h = min(h, float((span[0] - clock[0]) + (span[1] - clock[1])) * REACHING)
            before, guess = self._before, None
            if before is not None and h <= FORESEEN * before[1]:
                guess = continued(before[0], h / before[1], rule)
            found = solved(program, state, h, rule, shares, guess)
            if found is None:
                h *= FAILED
                continue
            off = found.unresolved
            factor = CAUTION * (tolerance / off) ** (1 / (stages + 1)) if off else LONGER
            if off <= tolerance:
                self.steps, self.crept = self.steps + 1, True
                outcome = complete_step(
                    state, clock, span, times, part, done, h, found.series, gauges, contacts, scales
                )  # fmt: skip
                if outcome.how == UNDERWAY:
                    state[:], self._before = found.end, (found.series, h)
                return outcome._replace(h=h * min(factor, LONGER))
            h *= max(factor, FAILED)
        return Outcome(LOST, h, done, 0, 0)

    def _is_stiff(self, program: Program, state: Array, scales: Scales, rest: float) -> bool:
        """Return whether what dies out, rather than what moves, would make series take thousands of steps."""
        if not self._accuracy.longer:
            return False
        shares = appraise(program, state, scales, *np.zeros((2, program.series, 2)))
        derivatives = slopes_by_state(program, state, shares)
        if not np.isfinite(derivatives).all():
            return False
        rates = np.linalg.eigvals(derivatives / shares[:, np.newaxis] * shares)
        decay, turn = float(-rates.real.min()), float(abs(rates.imag).max())
        return decay * rest > STABLE * STIFF_STEPS and decay > turn * STABLE

    def _equations_for(self, contacts: np.ndarray) -> Equations:
        pressing = contacts == PRESSING
        key = pressing.tobytes()
        if key not in self._equations:
            self._equations[key] = equations(self._throw, pressing)
        return self._equations[key]

    def scales(self, state: Array, span: float) -> Scales:
        """Return what errors of a passage of so long [s] from a state, (2, SIZE), are held against."""
        throw, noise = self._throw, np.zeros(2)
        if throw.ground is not None:
            height, stiffness, damping = map(float, throw.ground.strength)
            far = self.length + float(np.linalg.norm(state[0, X:V])) + abs(height)
            noise[HEIGHT] = (NOISE if self._accuracy.longer else NOISE_IN_DOUBLES) * far
            noise[THRUST] = (stiffness + damping / span) * noise[HEIGHT]
        moment = float(min(throw.solid.tensor.diagonal()))
        return Scales(self.length, 1.0 / span, moment, noise)

    def _contacts(self, state: Array, scales: Scales) -> np.ndarray:
        """Return how each vertex stands to the floor, (n,)."""
        throw = self._throw
        contacts = np.full(len(throw.points), ABOVE)
        if throw.ground is None:
            return contacts
        program, gauges = self._equations_for(contacts)
        high, low = np.zeros((2, program.series, 2))
        appraise(program, state, scales, high, low)
        readings = high[gauges, 0]
        below = readings[:, HEIGHT] < 0.0
        contacts[below] = np.where(readings[below, THRUST] > 0.0, PRESSING, IDLE)
        return contacts


def length_of(throw: Throw) -> float:
    """Return how far the body's points reach [m], or where it is but a point, how far its moments say they might."""
    reach = np.linalg.norm(throw.points.astype(float), axis=1).max()
    spread = np.sqrt(float(max(throw.solid.tensor.diagonal()) / throw.solid.mass))
    return float(max(reach, spread))


def start_of(throw: Throw) -> Numbers:
    """Return the state before any blow in fractions, (SIZE,)."""
    L = throw.solid.tensor @ (throw.axes.T @ throw.w_world)
    return np.concatenate((throw.x, throw.v, throw.axes.ravel(), L))


def passages(throw: Throw) -> Iterator[Passage]:
    """Tell a throw's passages, in order."""
    starts = sorted({Fraction(0), *(impulse.time for impulse in throw.impulses)})
    for begin, after in zip_longest(starts, starts[1:]):
        blows = [number for number, impulse in enumerate(throw.impulses) if impulse.time == begin]
        within = [row for row, time in enumerate(throw.times) if begin <= time and (after is None or time < after)]
        end = throw.times[-1] if after is None else min(after, throw.times[-1])
        yield Passage(blows, begin, end, within[0] if within else 0, len(within))
        if end == throw.times[-1]:
            return


def struck(state: Array, passage: Passage, throw: Throw) -> Array:
    """Return the state, (2, SIZE), after the blows that a passage begins with.  Raises RayMissed."""
    for number in passage.blows:
        state = pairs(_applied(fractions_of(state), throw.impulses[number], throw))
    return state


def _applied(state: Numbers, impulse: ExactImpulse, throw: Throw) -> Numbers:
    """Return the state after a blow J: v += J/m, L += lever x J, along the body's axes.  Raises RayMissed."""
    axes = state[AXES:MOMENTUM].reshape(3, 3)
    arm = lever(impulse, state[X:V], axes, throw)
    after = state.copy()
    after[V:AXES] += impulse.value / throw.solid.mass
    after[MOMENTUM:] += axes.T @ cross(arm, impulse.value)
    return after
