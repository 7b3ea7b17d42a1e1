"""A body that turns about points of the plane that stay where they are: how long friction can hold them there."""

import math
from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

import numpy as np

from tumble.scenarios.truth.contact.approach import NoContactFound, motion_along, safe_step
from tumble.scenarios.truth.contact.setting import Setting
from tumble.scenarios.truth.flight import Pose
from tumble.scenarios.truth.inertia import Numbers

SLIPS, LANDS = "slips", "lands"
MOST_LOOKS = 20_000
# Of a gauge's first value or greatest: how near to zero the secant's steps begin, and what counts as none at the start.
NEAR, NONE = 1e-7, 1e-12
# Of a radian: how far a body that begins to tip from rest turns before it is looked at again.
FIRST = 1e-4


class Begun(Protocol):
    """A phase of a setting that began at an instant [s]."""

    setting: Setting
    since: Any


class Pinned(Protocol):
    """A phase in which some points stay; fastest: a bound of its spin [rad/s]; bend: of its

    square and of how fast the spin changes, together [1/s2]; jerk: of d3x/dt3 of its centre [m/s3]; repeats_s: after
    which time all repeats, and no other point lands, inf where that is not so [s]."""

    setting: Setting
    points: tuple[int, ...]
    since: Any
    until: Any
    fastest: float
    bend: float
    jerk: float
    repeats_s: float

    def at(self, time: Any) -> Pose:
        """Return the pose at an instant."""
        ...

    def force(self, time: Any) -> Numbers:
        """Return the force of the plane on the body [N], (3,)."""
        ...


class Failure(NamedTuple):
    """What ends such a phase, SLIPS or LANDS, of which point, and when."""

    how: str
    point: int
    time: Any


def hold(setting: Setting, force: Numbers) -> Any:
    """Return mu N - |T|, which is below zero where the points slip or leave the plane [N]."""
    normal = force @ setting.normal
    along = setting.along(force)
    return setting.friction * normal - setting.mp.sqrt(along @ along)


def failure(phase: Pinned, near: Pinned, until: Any) -> Failure | None:
    """Return what ends a phase first, None if nothing does before an instant; near: the same in doubles.

    Looks as far apart as the gauges cannot fall to zero within, by bounds of their slopes; then secants.  Raises
    NoContactFound.
    """
    time, first = 0.0, True
    setting = near.setting
    reach, mass = float(setting.reach), float(setting.mass)
    gravity = mass * float(np.linalg.norm(setting.gravity.astype(float)))
    steepest = mass * near.jerk * (1 + float(setting.friction))
    others = [point for point in range(len(setting.points)) if point not in near.points and math.isinf(near.repeats_s)]
    pin = setting.points[near.points[0]]
    bends = near.bend * np.array([float(setting.mp.sqrt((p - pin) @ (p - pin))) for p in setting.points[others]])
    end = min(float(until - phase.since), near.repeats_s)
    for _ in range(MOST_LOOKS):
        if time > end:
            return None
        held = float(hold(setting, near.force(near.since + time)))
        if first and held < -NONE * gravity:
            return Failure(SLIPS, near.points[0], phase.since)
        if held <= NEAR * gravity and not first:
            slips = zero_of(lambda t: hold(phase.setting, phase.force(t)), phase, time)
            return Failure(SLIPS, near.points[0], slips)
        heights = rates = bends
        if others:
            heights, rates = motion_along(setting, near.at(near.since + time), setting.normal.astype(float))
            heights, rates = heights[others], rates[others]
        for number in np.flatnonzero((heights < NEAR * reach) & (rates < 0)):
            if not first:
                point = others[int(number)]
                return Failure(
                    LANDS, point, zero_of(lambda t, p=point: phase.setting.gaps(phase.at(t))[p], phase, time)
                )
        safe = safe_step(np.maximum(heights, 0.0), rates, bends)
        if first:
            # What lies on the plane still, and leaves it from rest.
            safe = np.maximum(safe, FIRST / max(near.fastest, np.sqrt(near.bend)))
        step = min([max(held, NEAR * gravity) / steepest, *safe])
        time, first = time + float(step), False
        if not np.isfinite(time):
            return None
    raise NoContactFound("the search for the end of a lasting contact takes too many steps")


def zero_of(gauge: Callable[[Any], Any], phase: Begun, guess: float) -> Any:
    """Return when a gauge is zero, near an instant after the start, by secants."""
    mp = phase.setting.mp
    before, now = phase.since + guess * (1 - 1e-6), phase.since + mp.mpf(guess)
    low, value = gauge(before), gauge(now)
    for _ in range(60):
        if value == low:
            break
        then = now - value * (now - before) / (value - low)
        before, low = now, value
        now, value = then, gauge(then)
        if abs(now - before) <= mp.ldexp(abs(now), 6 - mp.prec):
            return now
    if abs(now - before) > mp.ldexp(abs(now), -mp.prec // 2):
        raise NoContactFound("a lasting contact has no clear end")
    return now
