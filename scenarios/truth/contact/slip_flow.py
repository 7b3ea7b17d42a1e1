"""How a sliding velocity changes under a drift and Coulomb friction: the one equation of slip.

    ds/dP = d - M s/|s|,  s and d in the plane, (2,), M symmetric and positive definite, (2, 2).

In an impact P is the impulse along the normal, d and M are blocks of the contact's inverse inertia (Keller, "Impact
with friction", J. Appl. Mech. 53 (1986) 1).  Of a body that slides on an incline P is time, d is gravity along the
plane.

With r = |s| and dP = r dT it is linear but for r, and homogeneous, so that every step can begin at r = 1:

    s' = d r - M s,  r^2 = s.s,  P' = r.

A slip that ends, r -> 0, does so exponentially as T goes to infinity, where in P it has fractional powers: Batlle, "The
sliding velocity flow of rough collisions in multibody systems", J. Appl. Mech. 63 (1996) 804.  s, r and P are Taylor
series in T whose coefficients are whole numbers, in units of 2^-bits.  Where r has lost digits, a step needs as many
fewer; where the direction keeps itself, s is a line in P.
"""

from collections.abc import Iterator
from math import ldexp, log2
from operator import mul
from typing import Any, NamedTuple, Protocol

import numpy as np

from tumble.scenarios.truth.inertia import Numbers

# More bits than the answer is asked for, and half its bits: what rounding takes, and what long steps make of it.
GUARD = 32
# A slip that has lost all but 2^-SPARE of its last bit has ended; of that bit, what the last terms may be, in bits.
SPARE, SPARE_TERMS = 16, 2
TERMS_PER_BIT, FEWEST_TERMS = 0.45, 28
# A step has at least that many bits, whatever its slip has lost.
FEWEST_BITS = 24
MOST_STEPS = 3000
# How steps are counted: durations are whole numbers over 2^GRAIN.
GRAIN = 20
# Of what a polynomial can rise by in a step: how near to zero Newton's steps begin.
NEAR = 1e-6
# A direction keeps itself where it turns, of the largest rate, by no more than all but this share of the bits says: at
# the start, where it may be meant to; and by no more than rounding where a slip has come to it.
ROUNDED, ROUNDED_BITS = 6, 8


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
        self._law = drift, friction
        self.rate, turn = rates(drift, friction, self.direction)
        self.steady = abs(turn) <= mp.ldexp(self._rate_unit, mp.prec // ROUNDED - mp.prec)
        self.bits, self._with_path = mp.prec + GUARD + mp.prec // 2, with_path
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
        return self._straight(gauge, constant)

    def at(self, passed: Any) -> Sliding:
        """Return the slip after P, which is before its end."""
        for step, T in self.where(passed):
            if T is not None:
                return self._sliding(step, T)
        return self._along(passed)

    def where(self, passed: Any) -> Iterator[tuple[Step, int | None]]:
        """Yield the steps up to the one in which P has that value, each with None, the last with its T there, whole."""
        for step in self._all_steps():
            whole = self.whole((passed - step.before[0]) * self._rate_unit / step.speed_unit)
            last = self.duration(step)
            if self.value(step.passed, last) >= whole:
                series = [step.passed[0] - whole, *step.passed[1:]]
                yield step, self._zero(series, 0, last)
                return
            yield step, None

    def clock_unit(self, step: Step) -> Any:
        """Return what of P goes by in a step for each unit of its series."""
        return step.speed_unit / self._rate_unit

    def duration(self, step: Step) -> int:
        """Return how long a step is in T, whole."""
        return step.duration << self.bits >> GRAIN

    def _straight(self, gauge: Numbers, constant: Any) -> tuple[Sliding, bool]:
        """Return the same as `until` of what is left of the slip when its direction keeps itself."""
        mp = self._mp
        direction, passed, speed, rate = self.line()
        slope = (gauge[:2] @ direction) * rate + gauge[2]
        first = (gauge[:2] @ direction) * speed + gauge[2] * passed + constant
        if not self._keeps(direction, speed):
            return Sliding(0 * direction, passed - min(speed / rate, 0 * speed), self._front[3]), False
        stop = passed - speed / rate if rate < 0 else mp.inf
        reached = passed - first / slope if slope > 0 else mp.inf
        if reached <= stop:
            return self._along(reached), True
        end = self._along(stop)
        return end._replace(velocity=0 * direction), False

    def line(self) -> tuple[Numbers, Any, Any, Any]:
        """Return the direction that keeps itself at last, from which P on, with which speed, and the speed's rate."""
        direction, speed, passed, _ = self._front
        return direction, passed, speed, rates(*self._law, direction)[0]

    def _along(self, passed: Any) -> Sliding:
        """Return the slip after P along the direction that keeps itself."""
        direction, before, speed, rate = self.line()
        more, path = passed - before, self._front[3]
        return Sliding(direction * (speed + rate * more), passed, path + direction * ((speed + rate * more / 2) * more))

    def _all_steps(self) -> Iterator[Step]:
        """Yield the steps, as far as they are asked for, until r is nothing or the direction keeps itself."""
        number = 0
        while number < len(self._steps) or not self._ends():
            if number == len(self._steps):
                if number == MOST_STEPS:
                    raise ArithmeticError("a slip has no end")
                self._grow()
            yield self._steps[number]
            number += 1

    def _ends(self) -> bool:
        """Return whether no step is needed from the front on: r is nothing, or the direction keeps itself."""
        mp, (direction, speed, _, _) = self._mp, self._front
        return self._keeps(direction, speed) or bool(speed <= mp.ldexp(self._first_speed, -mp.prec - SPARE))

    def _keeps(self, direction: Numbers, speed: Any) -> bool:
        """Return whether the direction keeps itself, to what rounding says of s, wherever the slip goes from here.

        The angle's rate k has a slope k' and |k''| <= bend: with k' < 0 and |k| bend < k'^2 / 4 the angle falls into
        the root of k that is near (Kantorovich), and what it is off by dies out.
        """
        if self.steady:
            return True
        mp = self._mp
        (x, y), (d1, d2), ((a, b), (_, c)) = direction, *self._law
        rate, turn = rates(*self._law, direction)
        most = mp.sqrt(d1 * d1 + d2 * d2) + abs(a - c) / 2 + abs(b)
        slope = (a - c) * (x * x - y * y) + 4 * b * x * y - (d1 * x + d2 * y)
        falls_in = slope < 0 and 4 * abs(turn) * (4 * most) < slope * slope
        # An error of the direction counts by the speed that is left; a slip that grows keeps its share of it.
        share = min(speed / self._first_speed, mp.one) if rate < 0 else mp.one
        return bool((abs(turn) if falls_in else most) * share <= mp.ldexp(self._rate_unit, ROUNDED_BITS - mp.prec))

    def _grow(self) -> None:
        """Add the step from the front, and move the front to its end.

        Source of the step length: Jorba & Zou, "A software package for the numerical integration of ODEs by means of
        high-order Taylor methods", Experiment. Math. 14 (2005) 99.
        """
        bits, direction, unit, passed_before, path_before = self.bits, *self._front
        lost = min(max(0, int(log2(float(self._first_speed / unit)))), self._mp.prec - FEWEST_BITS)
        order = max(FEWEST_TERMS, int((self._mp.prec - lost) * TERMS_PER_BIT))
        (d1, d2), ((a, b), (_, c)) = self._drift, self._friction
        first, second, speed, passed = [self.whole(direction[0])], [self.whole(direction[1])], [1 << bits], [0]
        path: tuple[list[int], ...] = ([0], [0]) if self._with_path else ()
        # The terms so far, (s1, s2, r) of each in turn, and the other way round with -r: one sum is s.s - r r.
        terms, mirrored = [first[0], second[0], speed[0]], [0] * (3 * order + 3)
        for k in range(order):
            n, half = k + 1, k // 2 + 1
            for integral, slip in zip(path, (first, second), strict=False):
                integral.append((sum(map(mul, slip, speed[::-1])) >> bits) // n)
            passed.append(speed[k] // n)
            x, y, r = first[k], second[k], speed[k]
            first.append(((d1 * r - a * x - b * y) >> bits) // n)
            second.append(((d2 * r - b * x - c * y) >> bits) // n)
            # 2 r_n = (s.s)_n - the products of the r between, for r_0 = 1.
            inner = 2 * (first[0] * first[n] + second[0] * second[n])
            inner += 2 * sum(map(mul, terms[3 : 3 * half], mirrored[3 * (order - k) : 3 * (order - n + half)]))
            if n % 2 == 0:
                inner += first[half] ** 2 + second[half] ** 2 - speed[half] ** 2
            speed.append(inner >> bits + 1)
            terms += first[n], second[n], speed[n]
            mirrored[3 * (order - n) : 3 * (order - k)] = first[n], second[n], -speed[n]
        duration = self.bearable((first, second, speed), lost)
        step = Step((first, second), speed, passed, path, duration, unit, (passed_before, path_before))
        if self._rider is not None:
            step = step._replace(duration=min(duration, self.bearable(self._rider.grown(self, step))))
            self._rider.taken(self, step)
        self._steps.append(step)
        end = self._sliding(step, self.duration(step))
        size = self._mp.sqrt(end.velocity @ end.velocity)
        self._front = end.velocity / size, size, end.passed, end.path

    def bearable(self, grown: tuple[list[int], ...], lost: int = 0) -> int:
        """Return how long a step may be, over 2^GRAIN: its last terms are below the working precision.

        lost: bits less than that.
        """
        spare = self.bits - self._mp.prec - SPARE_TERMS + lost
        # A term that is nothing may be rounded to it: its size counts as one unit, or a long step makes that large.
        longest = min(
            2.0 ** ((spare - max(1, abs(series[power]).bit_length())) / power)
            for series in grown
            for power in (len(series) - 2, len(series) - 1)
        )
        return max(1, int(ldexp(longest, GRAIN)))

    def _first_rise(self, series: list[int], duration: int) -> int | None:
        """Return the first T, over 2^bits, at which a polynomial that begins below zero is zero, None if none is."""
        near, end = [ldexp(float(number), -self.bits) for number in series], ldexp(duration, -GRAIN)
        steepest = sum(max(number, 0.0) * k * end ** (k - 1) for k, number in enumerate(near) if k)
        if not steepest:
            return None
        T, below = 0.0, near[0]
        # Steps that no polynomial of this slope can rise within.
        while below < -NEAR * steepest * end:
            T -= below / steepest
            if end <= T:
                return None
            below = 0.0
            for number in reversed(near):
                below = below * T + number
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
