"""How a sliding velocity changes under a drift and Coulomb friction: the one equation of slip.

    ds/dP = d - M s/|s|,  s and d in the plane, (2,), M symmetric and positive definite, (2, 2).

In an impact P is the impulse along the normal, d and M are blocks of the contact's inverse inertia (Keller, "Impact
with friction", J. Appl. Mech. 53 (1986) 1).  Of a body that slides on an incline P is time, d is gravity along the
plane.

With r = |s| and dP = r dT it is linear but for r, and homogeneous, so that every step can begin at r = 1:

    s' = d r - M s,  r^2 = s.s,  P' = r.

A slip that ends, r -> 0, does so exponentially as T goes to infinity, where in P it has fractional powers: Batlle, "The
sliding velocity flow of rough collisions in multibody systems", J. Appl. Mech. 63 (1996) 804.  s, r and P are Taylor
series in T whose coefficients are whole numbers, in units of 2^-bits.
"""

from collections.abc import Iterator
from math import ldexp
from operator import mul
from typing import Any, NamedTuple, Protocol

import numpy as np

from tumble.scenarios.truth.inertia import Numbers

# More bits than the answer is asked for, and half its bits: what rounding takes, and what long steps make of it.
GUARD = 32
# A slip that has lost all but 2^-SPARE of its last bit has ended.
SPARE = 16
TERMS_PER_BIT, FEWEST_TERMS = 0.36, 24
MOST_STEPS = 3000
# How steps are counted: durations are whole numbers over 2^GRAIN.
GRAIN = 20
# Of what a polynomial can rise by in a step: how near to zero Newton's steps begin.
NEAR = 1e-6
# A direction keeps itself where it turns, of the largest rate, by no more than all but this share of the bits says.
ROUNDED = 6


class Sliding(NamedTuple):
    """A sliding velocity s, (2,); how much of P has gone by; the integral of s over P, (2,), 0 where none is kept."""

    velocity: Numbers
    passed: Any
    path: Numbers


class Step(NamedTuple):
    """Taylor series in T from the start of a step, whole numbers over 2^bits, where r = 1; and how long it is, over

    2^GRAIN.  slip: of s, two; speed: of r; passed: of P; path: of the integrals of s over P, two or none.  speed_unit:
    r at the start; before: P and path there.
    """

    slip: tuple[list[int], list[int]]
    speed: list[int]
    passed: list[int]
    path: tuple[list[int], ...]
    duration: int
    speed_unit: Any
    before: tuple[Any, Numbers]


class Rider(Protocol):
    """What goes along with a flow as series in the same T."""

    def grown(self, flow: "SlipFlow", step: Step) -> tuple[list[int], ...]:
        """Return its series over a step."""
        ...

    def taken(self, flow: "SlipFlow", step: Step) -> None:
        """Go to the end of the step whose series were grown."""
        ...


class SlipFlow:
    """The flow from a sliding velocity that is not zero.

    mp: context at the working precision; drift: d, (2,); friction: M, (2, 2); start: s, (2,); with_path: whether the
    integral of s over P is wanted; rider: what else is a series in T, and must have converged at a step's end.  steady:
    whether the direction of s keeps itself, so that s is a line in P; bits: of the whole numbers.
    """

    def __init__(
        self,
        mp: Any,
        drift: Numbers,
        friction: Numbers,
        start: Numbers,
        with_path: bool = False,
        rider: Rider | None = None,
    ) -> None:
        self._mp, self._first_speed = mp, mp.sqrt(start @ start)
        self._rate_unit = max(mp.mpf(abs(value)) for value in (*drift, *friction.flat))
        self.direction = start / self._first_speed
        self.rate, turn = rates(drift, friction, self.direction)
        self.steady = abs(turn) <= mp.ldexp(self._rate_unit, mp.prec // ROUNDED - mp.prec)
        if self.steady:
            return
        self.bits, self._with_path = mp.prec + GUARD + mp.prec // 2, with_path
        self._order = max(FEWEST_TERMS, int(mp.prec * TERMS_PER_BIT))
        self._drift = [self.whole(value / self._rate_unit) for value in drift]
        self._friction = [[self.whole(value / self._rate_unit) for value in row] for row in friction]
        # Where the next step starts: direction, r, P and path.
        self._front = self.direction, self._first_speed, mp.zero, 0 * start
        self._rider = rider
        self._steps: list[Step] = []

    def until(self, gauge: Numbers, constant: Any) -> tuple[Sliding, bool]:
        """Return the slip where gauge @ (s1, s2, P) + constant first rises to zero, and True; else its end, and False.

        gauge: (3,); constant: below zero, and so is what it makes at the start.
        """
        if self.steady:
            return self._straight(gauge, constant)
        for step in self._all_steps():
            unit = step.speed_unit
            scales = (unit, unit, unit / self._rate_unit)
            size = max(abs(factor * scale) for factor, scale in zip(gauge, scales, strict=True))
            factors = [self.whole(factor * scale / size) for factor, scale in zip(gauge, scales, strict=True)]
            terms = zip(*step.slip, step.passed, strict=True)
            a, b, c = factors
            series = [(a * first + b * second + c * passed) >> self.bits for first, second, passed in terms]
            series[0] += self.whole((constant + gauge[2] * step.before[0]) / size)
            T = self._first_rise(series, step.duration)
            if T is not None:
                return self._sliding(step, T), True
        return self._end(), False

    def at(self, passed: Any) -> Sliding:
        """Return the slip after P, which is before its end."""
        if self.steady:
            along = self._first_speed + self.rate * passed
            path = self._first_speed * passed + self.rate * passed * passed / 2
            return Sliding(self.direction * along, passed, self.direction * path)
        for step, T in self.where(passed):
            if T is not None:
                return self._sliding(step, self.whole(T))
        return self._end()

    def where(self, passed: Any) -> Iterator[tuple[Step, Any]]:
        """Yield the steps up to the one in which P has that value, each with None, the last with its T there."""
        for step in self._all_steps():
            whole = self.whole((passed - step.before[0]) * self._rate_unit / step.speed_unit)
            last = step.duration << self.bits >> GRAIN
            if self.value(step.passed, last) >= whole:
                series = [step.passed[0] - whole, *step.passed[1:]]
                yield step, self.number(self._zero(series, 0, last))
                return
            yield step, None

    def series(self, step: Step) -> tuple[Numbers, Numbers, tuple[Numbers, Numbers]]:
        """Return dP/dT, P, and s as series in T, each (order + 1,)."""
        speed, passed, *slip = (
            np.array([self.number(number) for number in series]) for series in (step.speed, step.passed, *step.slip)
        )
        unit = step.speed_unit / self._rate_unit
        passed = passed * unit
        passed[0] = passed[0] + step.before[0]
        return speed * unit, passed, (slip[0] * step.speed_unit, slip[1] * step.speed_unit)

    def duration(self, step: Step) -> Any:
        """Return how long a step is in T."""
        return self.number(step.duration << self.bits >> GRAIN)

    def _straight(self, gauge: Numbers, constant: Any) -> tuple[Sliding, bool]:
        mp = self._mp
        slope = (gauge[:2] @ self.direction) * self.rate + gauge[2]
        first = (gauge[:2] @ self.direction) * self._first_speed + constant
        stop = -self._first_speed / self.rate if self.rate < 0 else mp.inf
        reached = -first / slope if slope > 0 else mp.inf
        return self.at(min(stop, reached)), bool(reached <= stop)

    def _all_steps(self) -> Iterator[Step]:
        """Yield the steps, as far as they are asked for, until r is nothing."""
        number, least = 0, self._mp.ldexp(self._first_speed, -self._mp.prec - SPARE)
        while number < len(self._steps) or self._front[1] > least:
            if number == len(self._steps):
                if number == MOST_STEPS:
                    raise ArithmeticError("a slip has no end")
                self._grow()
            yield self._steps[number]
            number += 1

    def _grow(self) -> None:
        """Add the step from the front, and move the front to its end.

        Source of the step length: Jorba & Zou, "A software package for the numerical integration of ODEs by means of
        high-order Taylor methods", Experiment. Math. 14 (2005) 99.
        """
        bits, direction, unit, passed_before, path_before = self.bits, *self._front
        (d1, d2), ((a, b), (_, c)) = self._drift, self._friction
        first, second, speed, passed = [self.whole(direction[0])], [self.whole(direction[1])], [1 << bits], [0]
        path: tuple[list[int], ...] = ([0], [0]) if self._with_path else ()
        for k in range(self._order):
            n = k + 1
            for integral, slip in zip(path, (first, second), strict=False):
                integral.append((sum(map(mul, slip, speed[::-1])) >> bits) // n)
            passed.append(speed[k] // n)
            x, y, r = first[k], second[k], speed[k]
            first.append(((d1 * r - a * x - b * y) >> bits) // n)
            second.append(((d2 * r - b * x - c * y) >> bits) // n)
            # 2 r_n = (s.s)_n - the products of the r between, for r_0 = 1.
            inner = _square_term(first, n) + _square_term(second, n) - _square_term(speed, n)
            speed.append(inner >> bits + 1)
        duration = self.bearable((first, second, speed))
        step = Step((first, second), speed, passed, path, duration, unit, (passed_before, path_before))
        if self._rider is not None:
            step = step._replace(duration=min(duration, self.bearable(self._rider.grown(self, step))))
            self._rider.taken(self, step)
        self._steps.append(step)
        end = self._sliding(step, step.duration << bits >> GRAIN)
        size = self._mp.sqrt(end.velocity @ end.velocity)
        self._front = end.velocity / size, size, end.passed, end.path

    def bearable(self, grown: tuple[list[int], ...]) -> int:
        """Return how long a step may be, over 2^GRAIN: its last terms are below the working precision."""
        spare = self.bits - self._mp.prec - 12
        # A term that is nothing may be rounded to it: its size counts as one unit, or a long step makes that large.
        longest = min(
            2.0 ** ((spare - max(1, abs(series[power]).bit_length())) / power)
            for series in grown
            for power in (self._order - 1, self._order)
        )
        return max(1, int(ldexp(longest, GRAIN)))

    def _first_rise(self, series: list[int], duration: int) -> int | None:
        """Return the first T, over 2^bits, at which a polynomial that begins below zero is zero, None if none is."""
        near = np.array([ldexp(float(number), -self.bits) for number in series])
        powers, end = np.arange(len(near)), ldexp(duration, -GRAIN)
        steepest = float((np.maximum(near[1:], 0.0) * powers[1:] * end ** powers[:-1]).sum())
        if not steepest:
            return None
        values, T = near[::-1], 0.0
        below = float(np.polyval(values, T))
        # Steps that no polynomial of this slope can rise within.
        while below < -NEAR * steepest * end:
            T -= below / steepest
            if end <= T:
                return None
            below = float(np.polyval(values, T))
        whole, last = int(ldexp(T, self.bits)), duration << self.bits >> GRAIN
        return self._zero(series, whole, last) if self.value(series, last) >= 0 or below > 0 else None

    def _zero(self, series: list[int], guess: int, last: int) -> int:
        """Return where a polynomial rises through zero, from a guess just before it, by Newton's steps and halving."""
        low, high, T = 0, last, guess
        slopes = [k * number for k, number in enumerate(series)][1:]
        for _ in range(2 * self.bits):
            value = self.value(series, T)
            low, high = (T, high) if value <= 0 else (low, T)
            slope = self.value(slopes, T)
            then = T - (value << self.bits) // slope if slope > 0 else -1
            if not low <= then <= high:
                then = (low + high) >> 1
            if abs(then - T) <= 1:
                return then
            T = then
        return T

    def _sliding(self, step: Step, T: int) -> Sliding:
        speed, unit = step.speed_unit, step.speed_unit / self._rate_unit
        slip = np.array([self.number(self.value(each, T)) for each in step.slip])
        passed = step.before[0] + unit * self.number(self.value(step.passed, T))
        path = step.before[1]
        if step.path:
            path = path + np.array([self.number(self.value(way, T)) for way in step.path]) * (speed * unit)
        return Sliding(slip * speed, passed, path)

    def _end(self) -> Sliding:
        """Return where the slip ends: what the last step has left decays along the direction that it has reached."""
        direction, speed, passed, path = self._front
        drift, friction = (np.array(self._numbers(each)) for each in (self._drift, self._friction))
        rate, _ = rates(drift, friction, direction)
        return Sliding(0 * direction, passed - speed / (rate * self._rate_unit), path)

    def value(self, series: list[int], T: int) -> int:
        """Return a series at T, whole numbers over 2^bits."""
        bits, value = self.bits, 0
        for number in reversed(series):
            value = (value * T >> bits) + number
        return value

    def whole(self, value: Any) -> int:
        """Return a number in units of 2^-bits, rounded to a whole one."""
        return int(self._mp.ldexp(self._mp.mpf(value), self.bits))

    def number(self, whole: int) -> Any:
        """Return what a whole number of 2^-bits is."""
        return self._mp.ldexp(self._mp.mpf(whole), -self.bits)

    def _numbers(self, whole: Any) -> Any:
        return [self._numbers(each) for each in whole] if isinstance(whole, list) else self.number(whole)


def rates(drift: Numbers, friction: Numbers, direction: Numbers) -> tuple[Any, Any]:
    """Return h and k of a direction, a unit vector, (2,): how fast the slip grows and turns, times its speed."""
    pull = drift - friction @ direction
    return direction @ pull, direction[0] * pull[1] - direction[1] * pull[0]


def sticking_friction(drift: Numbers, matrix: Numbers) -> Numbers:
    """Return the friction over P that keeps a point from slipping, (2,): -matrix^-1 drift; matrix: (2, 2)."""
    (a, b), (_, d) = matrix
    return np.array((b * drift[1] - d * drift[0], b * drift[0] - a * drift[1])) / (a * d - b * b)


def outgoing(mp: Any, drift: Numbers, friction: Numbers) -> tuple[Numbers, Any]:
    """Return the direction, (2,), in which a slip begins where friction cannot hold, and its rate > 0.

    (M + l) s = d with |s| = 1: |(M + l)^-1 d| falls from more than 1 at l = 0 to 0, so there is one l > 0.
    """
    (a, b), (_, d) = friction
    first, second = drift

    def direction(rate: Any) -> Numbers:
        left, right = a + rate, d + rate
        return np.array((right * first - b * second, left * second - b * first)) / (left * right - b * b)

    def slope(rate: Any, found: Numbers) -> Any:
        left, right = a + rate, d + rate
        inner = np.array((right * found[0] - b * found[1], left * found[1] - b * found[0])) / (left * right - b * b)
        return -(found @ inner) / mp.sqrt(found @ found)

    # 1 / |.| is concave and rises: Newton's steps from the left never pass the root.
    rate = mp.zero
    for _ in range(mp.prec):
        found = direction(rate)
        size = mp.sqrt(found @ found)
        step = (size - 1) * size / -slope(rate, found)
        rate += step
        if abs(step) <= mp.ldexp(rate, -mp.prec + 4):
            break
    found = direction(rate)
    return found / mp.sqrt(found @ found), rate


def _square_term(series: list[int], n: int) -> int:
    """Return the n-th term of the square of a series, with no part of its own n-th term where it has none yet."""
    known = len(series) > n
    low = 0 if known else 1
    half = (n + 1) // 2
    total = 2 * sum(map(mul, series[low:half], series[n - low : n - half : -1]))
    return total + series[n // 2] ** 2 if n % 2 == 0 else total
