"""How a sliding velocity changes under a drift and Coulomb friction: the one equation of slip.

    ds/dP = d - M s/|s|,  s and d in the plane, (2,), M symmetric and positive definite, (2, 2).

In an impact P is the impulse along the normal, d and M are blocks of the contact's inverse inertia (Keller, "Impact
with friction", J. Appl. Mech. 53 (1986) 1).  Of a body that slides on an incline P is time, d is gravity along the plane.

With s = r (cos a, sin a) and dP = r dT the equation is a polynomial one and its angle a alone moves it:

    a' = k(a),  r' = r h(a),  h + i k = e^(-ia) (d - M e^(ia)).

A slip that ends, r -> 0, does so as T goes to infinity, exponentially, where in P it has fractional powers: Batlle, "The
sliding velocity flow of rough collisions in multibody systems", J. Appl. Mech. 63 (1996) 804.  Cosine, sine, r and P
are Taylor series in T whose coefficients are whole numbers, in units of 2^-bits.
"""

from collections.abc import Iterator
from math import ldexp
from operator import mul
from typing import Any, NamedTuple

import numpy as np

from scenarios.truth.inertia import Numbers

# More bits than the answer is asked for, and half its bits: what rounding takes, and what long steps make of it.
GUARD = 32
MOST_STEPS = 3000
# A slip that has lost all but 2^-SPARE of its last bit has ended.
SPARE = 16
# How steps are counted: durations are whole numbers over 2^GRAIN, at most LONGEST.
GRAIN, LONGEST = 20, 64
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
    """Taylor series in T from the start of a step, whole numbers over 2^bits; and how long it is, over 2^GRAIN.

    cos, sin, speed, passed: of the direction, r and P; along: r cos, r sin; path: of their integrals over P, or none.
    """

    cos: list[int]
    sin: list[int]
    speed: list[int]
    passed: list[int]
    along: tuple[list[int], list[int]]
    path: tuple[list[int], ...]
    duration: int


class SlipFlow:
    """The flow from a sliding velocity that is not zero.

    mp: context at the working precision; drift: d, (2,); friction: M, (2, 2); start: s, (2,); with_path: whether the
    integral of s over P is wanted.  steady: whether the direction of s keeps itself, so that s is a line in P.
    """

    def __init__(self, mp: Any, drift: Numbers, friction: Numbers, start: Numbers, with_path: bool = False) -> None:
        self._mp = mp
        self._speed_unit = mp.sqrt(start @ start)
        self._rate_unit = max(mp.mpf(abs(value)) for value in (*drift, *friction.flat))
        self.direction = start / self._speed_unit
        self.rate, turn = rates(drift, friction, self.direction)
        self.steady = abs(turn) <= mp.ldexp(self._rate_unit, mp.prec // ROUNDED - mp.prec)
        if self.steady:
            return
        self._guard = GUARD + mp.prec // 2
        self._bits, self._order, self._with_path = mp.prec + self._guard, max(16, int(mp.prec * 0.36)), with_path
        self._drift = [self._whole(value / self._rate_unit) for value in drift]
        self._friction = [[self._whole(value / self._rate_unit) for value in row] for row in friction]
        cos, sin = map(self._whole, self.direction)
        # cos, sin, r, P and the path.
        self._front = [cos, sin, 1 << self._bits, 0, *([0, 0] if with_path else [])]
        self._steps: list[Step] = []

    def until(self, gauge: Numbers, constant: Any) -> tuple[Sliding, bool]:
        """Return the slip where gauge @ (s1, s2, P) + constant first rises to zero, and True; or else its end, and False.

        gauge: (3,); constant: below zero, and so is what it makes at the start.
        """
        if self.steady:
            return self._straight(gauge, constant)
        scales = np.array((self._speed_unit, self._speed_unit, self._speed_unit / self._rate_unit))
        factors = [self._whole(factor) for factor in gauge * scales]
        for step in self._all_steps():
            series = [
                sum(factor * each for factor, each in zip(factors, terms, strict=True)) >> self._bits
                for terms in zip(*step.along, step.passed, strict=True)
            ]
            series[0] += self._whole(constant)
            T = self._first_rise(series, step.duration)
            if T is not None:
                return self._sliding(step, T), True
        return self._end(), False

    def at(self, passed: Any) -> Sliding:
        """Return the slip after P, which is before its end."""
        if self.steady:
            along = self._speed_unit + self.rate * passed
            path = self._speed_unit * passed + self.rate * passed * passed / 2
            return Sliding(self.direction * along, passed, self.direction * path)
        for step, T in self.where(passed):
            if T is not None:
                return self._sliding(step, self._whole(T))
        return self._end()

    def where(self, passed: Any) -> Iterator[tuple[Step, Any]]:
        """Yield the steps up to the one in which P has that value, each with None, the last with its T there."""
        whole = self._whole(passed * self._rate_unit / self._speed_unit)
        for step in self._all_steps():
            last = step.duration << self._bits >> GRAIN
            if self._value(step.passed, last) >= whole:
                series = [step.passed[0] - whole, *step.passed[1:]]
                yield step, self._number(self._zero(series, 0, last))
                return
            yield step, None

    def series(self, step: Step) -> tuple[Numbers, Numbers, tuple[Numbers, Numbers]]:
        """Return dP/dT, P, and s as series in T, each (order + 1,)."""
        unit = self._speed_unit / self._rate_unit
        speed, passed, *along = (
            np.array([self._number(number) for number in series]) for series in (step.speed, step.passed, *step.along)
        )
        return speed * unit, passed * unit, (along[0] * self._speed_unit, along[1] * self._speed_unit)

    def duration(self, step: Step) -> Any:
        """Return how long a step is in T."""
        return self._number(step.duration << self._bits >> GRAIN)

    def _straight(self, gauge: Numbers, constant: Any) -> tuple[Sliding, bool]:
        mp = self._mp
        slope = (gauge[:2] @ self.direction) * self.rate + gauge[2]
        first = (gauge[:2] @ self.direction) * self._speed_unit + constant
        stop = -self._speed_unit / self.rate if self.rate < 0 else mp.inf
        reached = -first / slope if slope > 0 else mp.inf
        return self.at(min(stop, reached)), bool(reached <= stop)

    def _all_steps(self) -> Iterator[Step]:
        """Yield the steps, as far as they are asked for, until r is nothing."""
        number = 0
        while number < len(self._steps) or self._front[2] >> self._guard - SPARE > 0:
            if number == len(self._steps):
                if number == MOST_STEPS:
                    raise ArithmeticError("a slip has no end")
                self._steps.append(self._grow())
            yield self._steps[number]
            number += 1

    def _grow(self) -> Step:
        """Return the step from the front, and move the front to its end.

        Source of the step length: Jorba & Zou, "A software package for the numerical integration of ODEs by means of
        high-order Taylor methods", Experiment. Math. 14 (2005) 99.
        """
        bits = self._bits
        cos, sin, speed, passed, *path = ([number] for number in self._front)
        first, second, rate, turn = [], [], [], []
        along: tuple[list[int], list[int]] = ([], [])
        for k in range(self._order + 1):
            for column, (drift, row) in enumerate(zip(self._drift, self._friction, strict=True)):
                pull = (drift if k == 0 else 0) - ((row[0] * cos[k] + row[1] * sin[k]) >> bits)
                (first, second)[column].append(pull)
            rate.append(_product(cos, first, bits) + _product(sin, second, bits))
            turn.append(_product(cos, second, bits) - _product(sin, first, bits))
            along[0].append(_product(speed, cos, bits))
            along[1].append(_product(speed, sin, bits))
            if k == self._order:
                break
            n = k + 1
            for integral, way in zip(path, along, strict=False):
                integral.append(_product(speed, way, bits) // n)
            passed.append(speed[k] // n)
            cos_next, sin_next = -_product(sin, turn, bits) // n, _product(cos, turn, bits) // n
            speed.append(_product(speed, rate, bits) // n)
            cos.append(cos_next)
            sin.append(sin_next)
        duration = self._duration((cos, sin, speed))
        step = Step(cos, sin, speed, passed, along, tuple(path), duration)
        T = duration << bits >> GRAIN
        self._front = [self._value(series, T) for series in (cos, sin, speed, passed, *path)]
        return step

    def _duration(self, grown: tuple[list[int], ...]) -> int:
        """Return how long a step may be, over 2^GRAIN: its last terms are below the working precision."""
        longest = float(LONGEST)
        for series in grown:
            for power in (self._order - 1, self._order):
                size = abs(series[power]).bit_length()
                room = max(series[0].bit_length(), self._bits)
                if size:
                    longest = min(longest, 2.0 ** ((room - self._mp.prec - 12 - size) / power))
        return max(1, int(ldexp(longest, GRAIN)))

    def _first_rise(self, series: list[int], duration: int) -> int | None:
        """Return the first T, over 2^bits, at which a polynomial that begins below zero is zero, None if none is."""
        near = np.array([ldexp(float(number), -self._bits) for number in series])
        powers, end = np.arange(len(near)), ldexp(duration, -GRAIN)
        steepest = float((np.maximum(near[1:], 0.0) * powers[1:] * end ** powers[:-1]).sum())
        values, T = near[::-1], 0.0
        below = float(np.polyval(values, T))
        # Steps that no polynomial of this slope can rise within.
        while below < -NEAR * steepest * end:
            T -= below / steepest
            if T >= end:
                return None
            below = float(np.polyval(values, T))
        if not steepest:
            return None
        whole, last = int(ldexp(T, self._bits)), duration << self._bits >> GRAIN
        return self._zero(series, whole, last)

    def _zero(self, series: list[int], guess: int, last: int) -> int:
        """Return where a polynomial rises through zero, from a guess just before it, by Newton's and halving's steps."""
        low, high, T = 0, last, guess
        slopes = [k * number for k, number in enumerate(series)][1:]
        for _ in range(2 * self._bits):
            value = self._value(series, T)
            low, high = (T, high) if value <= 0 else (low, T)
            slope = self._value(slopes, T)
            then = T - (value << self._bits) // slope if slope > 0 else -1
            if not low <= then <= high:
                then = (low + high) >> 1
            if abs(then - T) <= 1:
                return then
            T = then
        return T

    def _sliding(self, step: Step, T: int) -> Sliding:
        speed, along = self._speed_unit, np.array([self._number(self._value(way, T)) for way in step.along])
        unit = speed / self._rate_unit
        path = np.array([self._number(self._value(way, T)) for way in step.path] or [self._mp.zero] * 2)
        return Sliding(along * speed, unit * self._number(self._value(step.passed, T)), path * (speed * unit))

    def _end(self) -> Sliding:
        """Return where the slip ends: what the last step has left decays along the direction that it has reached."""
        cos, sin, speed, passed, *path = map(self._number, self._front)
        direction = np.array((cos, sin))
        friction = np.array([[self._number(number) for number in row] for row in self._friction])
        rate, _ = rates(np.array([self._number(number) for number in self._drift]), friction, direction)
        unit = self._speed_unit / self._rate_unit
        along = np.array(path or [self._mp.zero] * 2)
        return Sliding(0 * direction, unit * (passed - speed / rate), along * (self._speed_unit * unit))

    def _value(self, series: list[int], T: int) -> int:
        bits, value = self._bits, 0
        for number in reversed(series):
            value = (value * T >> bits) + number
        return value

    def _whole(self, value: Any) -> int:
        return int(self._mp.ldexp(self._mp.mpf(value), self._bits))

    def _number(self, whole: int) -> Any:
        return self._mp.ldexp(self._mp.mpf(whole), -self._bits)


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


def _product(a: list[int], b: list[int], bits: int) -> int:
    """Return the term of a product of two series that the shorter of them reaches, rounded down."""
    count = min(len(a), len(b))
    return sum(map(mul, a[:count], b[count - 1 :: -1])) >> bits
