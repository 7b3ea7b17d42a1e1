"""A disc that rolls on its rim without slip: the steady circle of a spun coin, and every motion about it.

In the frame of the rim's lowest point, e1 along the plane, e2 up the disc, e3 along the axis, that point stays at
r = (0, -a, c) from the centre.  With n = (0, sin t, cos t), t the tilt of the axis, and the spin w = (p, q, s)

    v = -w x r,   F = m (v' + W x v - g),   L' + W x L = r x F,   W = (p, q, q cot t),

t' = p, the frame turns about n at q / sin t, and the disc in the frame at s - q cot t.  All of it is Taylor series in
time, whose coefficients are whole numbers over 2^bits; the only division is by sin t.  Source: O'Reilly, "The dynamics
of rolling disks and sliding disks", Nonlinear Dynamics 10 (1996) 287; Routh, "Dynamics of a System of Rigid Bodies",
Advanced Part (1905), arts. 241-245.
"""

import math
from collections.abc import Iterator
from operator import mul
from typing import Any, NamedTuple

import numpy as np

from tumble.scenarios.frames import Array
from tumble.scenarios.truth.contact.approach import NoContactFound
from tumble.scenarios.truth.contact.pinned import Failure, hold, zero_of
from tumble.scenarios.truth.contact.setting import FLAT, TOUCHING, Setting, length, unit
from tumble.scenarios.truth.deadline import current
from tumble.scenarios.truth.flight import Pose
from tumble.scenarios.truth.inertia import Numbers
from tumble.scenarios.truth.rational import cross

# More bits than the answer is asked for; and what of them the last terms of a step leave alone.
GUARD, SPARE_TERMS = 40, 2
TERMS_PER_BIT, FEWEST_TERMS, MOST_STEPS = 0.36, 24, 20_000
# Of a gauge's size, how near to zero its root is looked for.
NEAR = 1e-9
# Of its fastest turn: what of the others is none but for rounding.
ROUNDED = 2.0**-40
# Of the weight: what friction may seem to lack at the start by rounding.
NONE = 1e-12
# How rolling ends by itself, and what is said of it.
SLIPS, ON_ITS_FACE, ON_ITS_SIDE = "slips", "falls flat", "falls on its side"
ENDS = {
    SLIPS: "a rim begins to slip",
    ON_ITS_FACE: "a disc falls flat",
    ON_ITS_SIDE: "a disc falls on its side",
}
# The columns of a state: w in the frame; sin t and cos t; the direction of e1 and the angle of the disc in the frame,
# by cosine and sine each; the way of the lowest point; and the angle by which the frame has turned.
P, Q, S, SIN, COS, COS_1, SIN_1, COS_3, SIN_3, AHEAD, ASIDE, PRECESSED = range(12)
Series = list[int]


class Step(NamedTuple):
    """Series over a step, by column, and of the force over the mass, in the frame; begins, length: of time.

    Whole numbers over 2^bits; lengths in radii, time in the phase's unit.
    """

    columns: tuple[Series, ...]
    force: tuple[Series, Series, Series]
    begins: int
    length: int


class RollingDisc:
    """A disc on the lowest point of one rim, which has no slip, or of both where it goes straight on; rims: which."""

    name = "rolls on its rim"

    def __init__(self, setting: Setting, pose: Pose, rims: tuple[int, ...], since: Any) -> None:
        assert setting.rim is not None
        self.setting, self.rims, self.since, self.until = setting, rims, since, setting.mp.inf
        mp, normal, (self._radius, half) = setting.mp, setting.normal, setting.rim
        self._bits = mp.prec + GUARD
        place = pose.x + sum(setting.levers(pose)[list(rims)]) / len(rims)
        self._place = place - normal * ((place - setting.point) @ normal)
        # e3 is on the side of the centre; of a disc without thickness on either.
        e3 = pose.axes[:, 2] * (-1 if rims == (1,) else 1)
        if len(rims) > 1:
            half, e3 = 0 * half, unit(mp, setting.along(e3))
        cosine = e3 @ normal
        across = normal * cosine - e3
        sine = mp.sqrt(across @ across)
        self._ahead, self._aside = cross(across, normal) / sine, across / sine
        self._axes, self._frame = pose.axes, self._frame_of(mp.one, mp.zero, sine, cosine)
        p, q, s = pose.w_world @ self._frame
        if len(rims) > 1:
            p, q = mp.zero, mp.zero
        pull = mp.sqrt(setting.gravity @ setting.gravity)
        # The fastest that anything here turns or falls: so all numbers are about 1.
        self._unit = 1 / max(abs(p), abs(q), abs(s), abs(q / sine), mp.sqrt(pull / self._radius))
        self._c = -half / self._radius
        size = setting.mass * self._radius**2
        self._set_law(setting.tensor[0, 0] / size, setting.tensor[2, 2] / size)
        pulls = setting.pressing, setting.gravity @ self._ahead, setting.gravity @ self._aside
        self._pulls = [self._whole(pull * self._unit**2 / self._radius) for pull in pulls]
        turns = np.array((p, q, s)) * self._unit
        start = (*turns, sine, cosine, mp.one, mp.zero, mp.one, mp.zero, mp.zero, mp.zero, mp.zero)
        # A wheel that is upright and only rolls goes on so.
        self.is_straight = max(map(abs, (turns[0], turns[1], cosine))) <= ROUNDED
        self._front, self._clock = [self._whole(value) for value in start], 0
        self._steps: list[Step] = []

    def _frame_of(self, cos_1: Any, sin_1: Any, sine: Any, cosine: Any) -> Numbers:
        """Return e1, e2, e3, the columns, (3, 3)."""
        normal = self.setting.normal
        e1, beside = self._ahead * cos_1 + self._aside * sin_1, self._aside * cos_1 - self._ahead * sin_1
        return np.array((e1, normal * sine + beside * cosine, normal * cosine - beside * sine)).T

    def _set_law(self, across: Any, along: Any) -> None:
        """Set the constants of the equations of motion; across, along: moments over m a^2.

        With u = W x v - g over a they are
            (A + 1 + c^2) p' = -u3 - c u2 - C q s + A f q,
            (A + c^2) q' + c s' = c u1 - A f p + C p s,     c q' + (C + 1) s' = u1,     f = q cot t.
        """
        c = self._c
        determinant = (across + c * c) * (along + 1) - c * c
        inverse = 1 / (across + 1 + c * c), (along + 1) / determinant, c / determinant, (across + c * c) / determinant
        self._law = tuple(map(self._whole, (c, across, along, *inverse)))

    def _grow(self) -> None:
        """Add the step from the front, and move the front to its end."""
        bits, (c, A, C, of_p, of_q, mixed, of_s) = self._bits, self._law
        columns = tuple([number] for number in self._front)
        p, q, s, sine, cosine, cos_1, sin_1, cos_3, sin_3, ahead, aside, precessed = columns
        first, second, third = force = [], [], []
        press, pull_ahead, pull_aside = self._pulls
        is_sloped = bool(pull_ahead or pull_aside)
        frame_turns: Series = []
        lean: Series = []
        turns: Series = []
        across: Series = []

        def times(a: Series, b: Series) -> int:
            return sum(map(mul, a, b[::-1])) >> bits

        for k in range(max(FEWEST_TERMS, int(self.setting.mp.prec * TERMS_PER_BIT))):
            n = k + 1
            inner = sum(map(mul, sine[1:], frame_turns[::-1]))
            frame_turns.append(((q[k] << bits) - inner) // sine[0])
            lean.append(times(frame_turns, cosine))
            turns.append(s[k] - lean[k])
            qp, fp, fq, fs = times(q, p), times(lean, p), times(lean, q), times(lean, s)
            pp, qq, qs, ps = times(p, p), times(q, q), times(q, s), times(p, s)
            u1 = qp - ((c * fp + pull_ahead * cos_1[k] + pull_aside * sin_1[k]) >> bits)
            u2 = ((press * sine[k] - c * fq) >> bits) - fs - pp
            u3 = ((press * cosine[k] + c * (pp + qq)) >> bits) + qs
            if is_sloped:
                across.append((pull_aside * cos_1[k] - pull_ahead * sin_1[k]) >> bits)
                u2, u3 = u2 - times(across, cosine), u3 + times(across, sine)
            about_1 = -u3 - ((c * u2 + C * qs - A * fq) >> bits)
            about_2 = (c * u1 - A * fp + C * ps) >> bits
            p_rate, q_rate = of_p * about_1 >> bits, (of_q * about_2 - mixed * u1) >> bits
            s_rate = (of_s * u1 - mixed * about_2) >> bits
            first.append(u1 - s_rate - (c * q_rate >> bits))
            second.append(u2 + (c * p_rate >> bits))
            third.append(u3 + p_rate)
            rates = (
                (p, p_rate),
                (q, q_rate),
                (s, s_rate),
                (sine, times(p, cosine)),
                (cosine, -times(p, sine)),
                (ahead, -times(turns, cos_1)),
                (aside, -times(turns, sin_1)),
                (cos_1, -times(frame_turns, sin_1)),
                (sin_1, times(frame_turns, cos_1)),
                (cos_3, -times(turns, sin_3)),
                (sin_3, times(turns, cos_3)),
                (precessed, frame_turns[k]),
            )
            for series, rate in rates:
                series.append(rate // n)
        length = self._bearable(columns)
        self._steps.append(Step(columns, force, self._clock, length))
        self._front, self._clock = [self._value(series, length) for series in columns], self._clock + length

    def _bearable(self, columns: tuple[Series, ...]) -> int:
        """Return how long a step may be: its last terms are below the working precision.

        Source: Jorba & Zou, "A software package for the numerical integration of ODEs by means of high-order Taylor
        methods", Experiment. Math. 14 (2005) 99.
        """
        spare = GUARD - SPARE_TERMS
        longest = min(
            (spare - max(1, abs(series[power]).bit_length())) / power
            for series in columns
            for power in (len(series) - 2, len(series) - 1)
        )
        return int(math.ldexp(2.0**longest, 30)) << self._bits >> 30

    def _value(self, series: Series, t: int) -> int:
        """Return a series at t."""
        bits, value = self._bits, 0
        for number in reversed(series):
            value = (value * t >> bits) + number
        return value

    def _whole(self, value: Any) -> int:
        """Return a number in units of 2^-bits, rounded to a whole one."""
        return int(self.setting.mp.ldexp(self.setting.mp.mpf(value), self._bits))

    def _number(self, whole: int) -> Any:
        return self.setting.mp.ldexp(self.setting.mp.mpf(whole), -self._bits)

    def _step_at(self, time: Any) -> tuple[Step, int]:
        """Return the step in which an instant is, and how long after its start."""
        t = self._whole((time - self.since) / self._unit)
        while self._clock < t:
            self._take()
        if not self._steps:
            self._take()
        step = next(step for step in reversed(self._steps) if step.begins <= t or step is self._steps[0])
        return step, t - step.begins

    def _take(self) -> None:
        current().check()
        if len(self._steps) == MOST_STEPS:
            raise NoContactFound("a disc that rolls takes too many steps")
        self._grow()

    def _at(self, time: Any, *columns: int) -> list[Any]:
        """Return columns of the state at an instant."""
        step, t = self._step_at(time)
        return [self._number(self._value(step.columns[column], t)) for column in columns]

    def at(self, time: Any) -> Pose:
        """Return the pose at an instant."""
        p, q, s, sine, cosine, cos_1, sin_1, cos_3, sin_3, ahead, aside = self._at(
            time, P, Q, S, SIN, COS, COS_1, SIN_1, COS_3, SIN_3, AHEAD, ASIDE
        )
        frame = self._frame_of(cos_1, sin_1, sine, cosine)
        e1, e2, e3 = frame.T
        spun = np.array((e1 * cos_3 + e2 * sin_3, e2 * cos_3 - e1 * sin_3, e3)).T
        way = self._ahead * ahead + self._aside * aside
        x = self._place + (way + e2 - e3 * self._c) * self._radius
        v = np.array((-(self._c * q + s), self._c * p, p)) * (self._radius / self._unit)
        return Pose(x, spun @ self._frame.T @ self._axes, frame @ v, frame @ np.array((p, q, s)) / self._unit)

    def force(self, time: Any) -> Numbers:
        """Return the force of the plane on the body [N], (3,)."""
        step, t = self._step_at(time)
        own = np.array([self._number(self._value(series, t)) for series in step.force])
        cos_1, sin_1, sine, cosine = self._at(time, COS_1, SIN_1, SIN, COS)
        scale = self.setting.mass * self._radius / self._unit**2
        return self._frame_of(cos_1, sin_1, sine, cosine) @ own * scale

    def precessed_rad(self, time: Any) -> Any:
        """Return the angle by which the lowest point has gone about the normal, as seen from the centre [rad]."""
        return self._at(time, PRECESSED)[0]

    def tilt_rad(self, time: Any) -> Any:
        """Return the angle of the axis from the normal [rad]."""
        sine, cosine = self._at(time, SIN, COS)
        return self.setting.mp.atan2(sine, cosine)

    def greatest_tilt_rad(self, until: Any) -> Any:
        """Return the greatest angle of the axis from the normal up to an instant [rad]."""
        found = [self.tilt_rad(self.since), self.tilt_rad(until)]
        for step in self._steps:
            rate = self._floats(step.columns[P])
            end = min(math.ldexp(float(step.length), -self._bits), float((until - self.since) / self._unit))
            if rate[0] > 0 > np.polynomial.polynomial.polyval(end, rate):
                begins, fall = math.ldexp(float(step.begins), -self._bits), _first_fall(rate, end)
                guess = float(self._unit) * (begins + (end if fall is None else fall))
                found.append(self.tilt_rad(zero_of(lambda t: self._at(t, P)[0], self, guess)))
        return max(found)

    def _floats(self, series: Series) -> Array:
        return np.array([math.ldexp(float(number), -self._bits) for number in series])

    def gauge(self, how: str, time: Any) -> Any:
        """Return what is above zero until the disc ends to roll in that way: slips, falls flat or on its side."""
        if how == SLIPS:
            return hold(self.setting, self.force(time))
        return self._at(time, SIN)[0] - FLAT if how == ON_ITS_FACE else self._at(time, COS)[0]

    def failure(self, until: Any) -> Failure | None:
        """Return what ends the rolling first, None if nothing does before an instant.  Raises NoContactFound."""
        setting = self.setting
        weight = float(setting.mass) * float(setting.mp.sqrt(setting.gravity @ setting.gravity))
        if float(self.gauge(SLIPS, self.since)) < -NONE * weight:
            return Failure(SLIPS, self.rims[0], self.since)
        unit, number = float(self._unit), 0
        while self.since + self._unit * self._number(self._clock if number else 0) < until:
            self._take()
            step = self._steps[number]
            begins, length = (math.ldexp(float(whole), -self._bits) for whole in (step.begins, step.length))
            falls = [(_first_fall(terms, length), how) for how, terms in self._gauges(step)]
            found = [(begins + t, how) for t, how in falls if t is not None]
            for guess, how in sorted(found)[:1]:
                instant = zero_of(lambda time, how=how: self.gauge(how, time), self, guess * unit)
                return Failure(how, self.rims[0], instant) if instant <= until else None
            number += 1
        return None

    def _gauges(self, step: Step) -> Iterator[tuple[str, Array]]:
        """Yield, as polynomials of a step's time, gauges of the signs of those of `gauge`."""
        e1, e2, e3 = (self._floats(series) for series in step.force)
        sine, cosine = self._floats(step.columns[SIN]), self._floats(step.columns[COS])
        press = np.convolve(e2, sine) + np.convolve(e3, cosine)
        aside = np.convolve(e2, cosine) - np.convolve(e3, sine)
        held = float(self.setting.friction) ** 2 * np.convolve(press, press) - np.convolve(aside, aside)
        held[: 2 * len(e1) - 1] -= np.convolve(e1, e1)
        yield SLIPS, held
        yield ON_ITS_FACE, sine - FLAT * (np.arange(len(sine)) == 0)
        if self._c:
            yield ON_ITS_SIDE, cosine


def goes_straight(setting: Setting, pose: Pose, still: Any) -> bool:
    """Return whether a disc on both rims turns about its axis alone, and gravity does not pull along that.

    still: a speed that counts as none [m/s].
    """
    axis, w = pose.axes[:, 2], pose.w_world
    across = w - axis * (w @ axis)
    pulls = abs(setting.gravity @ axis) > TOUCHING * length(setting.mp, setting.gravity)
    return not pulls and bool(length(setting.mp, across) * setting.reach <= still)


def _first_fall(terms: Array, length: float) -> float | None:
    """Return where a polynomial comes near to zero first, None if it does not within a length.

    It cannot fall to zero sooner than the bound of its slope, the sum of its terms', lets it.
    """
    powers = np.arange(1, len(terms))
    steepest = float((np.abs(terms[1:]) * powers) @ length ** (powers - 1.0))
    near, t = NEAR * float(np.abs(terms) @ length ** np.arange(float(len(terms)))), 0.0
    while t < length:
        value = float(np.polynomial.polynomial.polyval(t, terms))
        if value <= near:
            return t
        t += value / steepest if steepest else length
    return None
