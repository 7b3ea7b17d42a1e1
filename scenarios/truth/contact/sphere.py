"""A sphere that stays on the plane: it slips, then rolls; and one that bounces without end, in finite time."""

from collections.abc import Iterator
from operator import mul
from typing import Any

import numpy as np

from tumble.scenarios.truth.contact.approach import Flight
from tumble.scenarios.truth.contact.driven_spin import DrivenSpin, turn_of
from tumble.scenarios.truth.contact.impact import velocity_at
from tumble.scenarios.truth.contact.setting import Setting, length, tangents
from tumble.scenarios.truth.contact.slip_flow import SlipFlow, Step
from tumble.scenarios.truth.flight import Pose
from tumble.scenarios.truth.inertia import Numbers
from tumble.scenarios.truth.rational import cross


def laid(setting: Setting, pose: Pose) -> Pose:
    """Return the pose with the sphere on the plane and no velocity along its normal."""
    normal = setting.normal
    x = pose.x - normal * setting.gaps(pose)[0]
    return pose._replace(x=x, v=setting.along(pose.v))


def spread(setting: Setting) -> Any:
    """Return how much more the touching point gains per force along the plane than the centre: 1 + m r^2 / I, 7/2."""
    assert setting.radius is not None
    return 1 + setting.mass * setting.radius**2 / setting.tensor[0, 0]


def rolls(setting: Setting) -> bool:
    """Return whether friction can make a sphere roll: tan <= 7/2 mu on an incline."""
    along = length(setting.mp, setting.gravity_along)
    return bool(along <= spread(setting) * setting.friction * setting.pressing)


class Rolling:
    """A sphere that rolls, or that slips along gravity from no slip, or slides where there is no friction.

    The acceleration of the centre, and of the spin along the plane, is constant.
    """

    def __init__(self, setting: Setting, pose: Pose, since: Any, name: str) -> None:
        self.name, self._setting, self.since, self.until = name, setting, since, setting.mp.inf
        self._pose = laid(setting, pose)
        gravity, normal = setting.gravity_along, setting.normal
        zero = 0 * gravity
        if name == "slides":
            self._pull, self._spin = gravity, zero
        elif name == "rolls":
            self._pull = gravity * (1 - 1 / spread(setting))
            w_n = self._pose.w_world @ normal
            self._pose = self._pose._replace(w_world=normal * w_n + cross(normal, self._pose.v) / setting.radius)
            self._spin = cross(normal, self._pull) / setting.radius
        else:
            friction = gravity * (setting.friction * setting.pressing / length(setting.mp, gravity))
            self._pull = gravity - friction
            self._spin = cross(normal, friction) * setting.mass * setting.radius / setting.tensor[0, 0]
        self._turning = _turning(setting, self._pose, self._spin)

    def at(self, time: Any) -> Pose:
        """Return the pose at an instant."""
        t, start = time - self.since, self._pose
        x = start.x + start.v * t + self._pull * (t * t / 2)
        return Pose(x, self._turning(t), start.v + self._pull * t, start.w_world + self._spin * t)


class Slipping:
    """A sphere that slips, until the touching point has no velocity along the plane.

    The slip s obeys `slip_flow`; the centre has v' = s' / b + (1 - 1/b) g, b = 1 + m r^2 / I.
    """

    name = "slips"

    def __init__(self, setting: Setting, pose: Pose, since: Any, last: Any) -> None:
        self._setting, self.since = setting, since
        assert setting.radius is not None
        self._pose = pose = laid(setting, pose)
        lever = setting.normal * -setting.radius
        slip = setting.along(velocity_at(pose, lever))
        self._frame = np.array(tangents(setting.mp, setting.normal, slip))
        self._slip, self._share = self._frame @ slip, 1 / spread(setting)
        hold = setting.friction * setting.pressing * spread(setting)
        matrix = np.array(((hold, 0 * hold), (0 * hold, hold)))
        drift = self._frame @ setting.gravity_along
        spin = SlipSpin(setting, self)
        self._flow = SlipFlow(setting.mp, drift, matrix, self._slip, with_path=True, rider=spin)
        clock = np.array((0 * hold, 0 * hold, setting.mp.one))
        end, reached = self._flow.until(clock, -(max(last - since, setting.mp.one * 0) + 1))
        self.until = setting.mp.inf if reached else since + end.passed
        self._end = end
        self._turning = lambda t: spin.at(self._flow, t)

    def at(self, time: Any) -> Pose:
        """Return the pose at an instant."""
        t, start, setting = time - self.since, self._pose, self._setting
        now = self._flow.at(t) if t < self._end.passed else self._end
        share, gravity = self._share, setting.gravity_along
        gained, path = (now.velocity - self._slip) @ self._frame, now.path @ self._frame
        v = start.v + gained * share + gravity * ((1 - share) * t)
        first = start.v - (self._slip @ self._frame) * share
        x = start.x + first * t + path * share + gravity * ((1 - share) * t * t / 2)
        return Pose(x, self._turning(t), v, self.spin(now.velocity, v))

    def spin(self, slip: Numbers, v: Numbers) -> Numbers:
        """Return the angular velocity of a slip, (2,), and a velocity of the centre, (3,)."""
        setting = self._setting
        about = setting.normal * (self._pose.w_world @ setting.normal)
        return about + cross(setting.normal, v - slip @ self._frame) / setting.radius

    def spin_factors(self) -> tuple[Numbers, Numbers, Numbers, Numbers]:
        """Return w as a constant and factors of t, s1 and s2, each (3,)."""
        setting, share = self._setting, self._share
        start = self._pose.v - (self._slip @ self._frame) * share
        about = setting.normal * (self._pose.w_world @ setting.normal)
        constant = about + cross(setting.normal, start) / setting.radius
        by_time = cross(setting.normal, setting.gravity_along) * ((1 - share) / setting.radius)
        by_slip = [cross(setting.normal, axis) * ((share - 1) / setting.radius) for axis in self._frame]
        return constant, by_time, by_slip[0], by_slip[1]

    @property
    def axes(self) -> Numbers:
        """The axes at the start, (3, 3)."""
        return self._pose.axes


class SlipSpin:
    """Attitude of a sphere whose slip turns: q' = w q / 2 over the steps of the flow, q a series in its variable T.

    The series' coefficients are whole numbers over 2^bits, as the flow's are.
    """

    def __init__(self, setting: Setting, slipping: Slipping) -> None:
        self._setting, self._axes, self._factors = setting, slipping.axes, slipping.spin_factors()
        self._last: DrivenSpin | None = None
        self._q: list[int] = []
        self._series: list[tuple[list[int], ...]] = []

    def grown(self, flow: SlipFlow, step: Step) -> tuple[list[int], ...]:
        """Return the series of q over a step, four of them."""
        self._next = self._terms(flow, step, self._q or [flow.whole(self._setting.mp.one), 0, 0, 0])
        return self._next

    def taken(self, flow: SlipFlow, step: Step) -> None:
        """Go to the end of the step whose series were grown."""
        self._series.append(self._next)
        self._q = [flow.value(series, flow.duration(step)) for series in self._next]

    def at(self, flow: SlipFlow, t: Any) -> Numbers:
        """Return the axes at t [s], (3, 3)."""
        for (_, T), series in zip(flow.where(t), self._series_of(), strict=False):
            if T is not None:
                return self._turned(flow, [flow.value(each, T) for each in series])
        return self._along_a_line(flow, t)

    def _along_a_line(self, flow: SlipFlow, t: Any) -> Numbers:
        """Return the axes at t [s], (3, 3), after the direction of the slip has begun to keep itself."""
        direction, since, speed, rate = flow.line()
        if self._last is None:
            constant, by_time, by_first, by_second = self._factors
            by_slip = by_first * direction[0] + by_second * direction[1]
            axes = self._turned(flow, self._q) if self._q else self._axes
            w = constant + by_time * since + by_slip * speed
            self._last = DrivenSpin(self._setting, axes, w, by_time + by_slip * rate)
        return self._last.at(t - since)

    def _series_of(self) -> Iterator[tuple[list[int], ...]]:
        number = 0
        while number < len(self._series):
            yield self._series[number]
            number += 1

    def _turned(self, flow: SlipFlow, q: list[int]) -> Numbers:
        return turn_of(np.array([flow.number(number) for number in q])) @ self._axes

    def _terms(self, flow: SlipFlow, step: Step, q: list[int]) -> tuple[list[int], ...]:
        """Return the series of q: dq/dT = r w q / 2, for dt = r dT."""
        bits = flow.bits
        unit = flow.clock_unit(step)
        constant, by_time, by_first, by_second = self._factors
        factors = (
            (constant + by_time * step.before[0]) * unit,
            by_time * (unit * unit),
            by_first * (unit * step.speed_unit),
            by_second * (unit * step.speed_unit),
        )
        x, y, z = (self._driving(flow, step, of_axis) for of_axis in zip(*factors, strict=True))
        a, b, c, d = terms = tuple([number] for number in q)
        for k in range(len(x) - 1):
            u, v, w_ = x[k::-1], y[k::-1], z[k::-1]
            parts = [[sum(map(mul, part, spin)) for spin in (u, v, w_)] for part in (a, b, c, d)]
            (ax, ay, az), (bx, by, bz), (cx, cy, cz), (dx, dy, dz) = parts
            grown = (-bx - cy - dz, ax + dy - cz, ay + bz - dx, az + cx - by)
            for series, number in zip(terms, grown, strict=True):
                series.append((number >> bits + 1) // (k + 1))
        return terms

    def _driving(self, flow: SlipFlow, step: Step, factors: tuple[Any, ...]) -> list[int]:
        """Return r w about an axis, whose w is a constant and factors of P, s1 and s2, as a series."""
        constant, by_passed, by_first, by_second = (flow.whole(factor) for factor in factors)
        terms = zip(step.passed, *step.slip, strict=True)
        w = [(by_passed * p + by_first * a + by_second * b) >> flow.bits for p, a, b in terms]
        w[0] += constant
        return [sum(map(mul, step.speed[: k + 1], w[k::-1])) >> flow.bits for k in range(len(w))]


class Bouncing:
    """A sphere that bounces without slip, or without friction, under gravity straight at the plane: n bounces, closed.

    It leaves the plane at `since`.  The bounces of e < 1 end after 2 u / (g (1 - e)), u being the speed it leaves with.
    """

    name = "bounces"

    def __init__(self, setting: Setting, pose: Pose, since: Any) -> None:
        mp, normal = setting.mp, setting.normal
        self._setting, self.since = setting, since
        self._speed = pose.v @ normal
        self._pose = pose._replace(x=pose.x - normal * setting.gaps(pose)[0], v=setting.along(pose.v))
        self._turning = Flight(setting, self._pose, since)
        e = setting.restitution
        self._first = 2 * self._speed / setting.pressing
        self.until = since + self._first / (1 - e) if e < 1 else mp.inf

    def at(self, time: Any) -> Pose:
        """Return the pose at an instant; at an impact, after it."""
        setting, t = self._setting, time - self.since
        if time >= self.until:
            number, speed, since = 0, 0 * t, t
        else:
            number = self._number(t)
            speed, since = self._speed * setting.restitution**number, t - self.after(number)
        rate = speed - setting.pressing * since if time < self.until else 0 * t
        height = speed * since - setting.pressing * since * since / 2 if time < self.until else 0 * t
        free = self._turning.at(time)
        x = self._pose.x + self._pose.v * t + setting.normal * height
        return Pose(x, free.axes, self._pose.v + setting.normal * rate, free.w_world)

    def after(self, number: int) -> Any:
        """Return how long after `since` the impact of a number is, 0 being the one at `since` [s]."""
        e = self._setting.restitution
        return self._first * number if e == 1 else self._first * (1 - e**number) / (1 - e)

    def speed(self, number: int) -> Any:
        """Return the speed with which it leaves the plane at the impact of a number [m/s]."""
        return self._speed * self._setting.restitution**number

    def impacts(self, last: Any, most: int) -> int:
        """Return how many impacts after the one at `since` come before an instant, at most that many."""
        count = 0
        while (
            count < most
            and self.since + self.after(count + 1) <= last
            and self.since + self.after(count + 1) < self.until
        ):
            count += 1
        return count

    def _number(self, t: Any) -> int:
        mp, e = self._setting.mp, self._setting.restitution
        if e == 1:
            number = int(mp.floor(t / self._first))
        else:
            number = int(mp.floor(mp.log(1 - t * (1 - e) / self._first) / mp.log(e)))
        # A logarithm's rounding may be one off.
        number = max(0, number - 1)
        while self.after(number + 1) <= t:
            number += 1
        return number


def _turning(setting: Setting, pose: Pose, rate: Numbers) -> Any:
    """Return the axes as a function of time [s] for an angular velocity that changes at a constant rate."""
    if any(rate):
        return DrivenSpin(setting, pose.axes, pose.w_world, rate).at
    rotation = setting.turning.start(pose.axes, setting.momentum_body(pose))
    return lambda t: rotation.at(t)[0]
