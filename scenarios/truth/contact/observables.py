"""What of a motion above a plane a small shift of an instant does not spoil: numbers an engine can be held to.

A position at a sample is off by the speed times the shift of a contact; velocities after an impact, an apex, where and
when a body stops are not.  Each belongs to a window of time, from the event that makes it to the next.
"""

from collections.abc import Iterator
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from tumble.scenarios.truth.contact.disc import RollingDisc
from tumble.scenarios.truth.contact.edge import Tipping
from tumble.scenarios.truth.contact.setting import Setting, length
from tumble.scenarios.truth.contact.timeline import IMPACT, RESTS, ROLLS, STOPS, Event, Phase, Timeline
from tumble.scenarios.truth.contact.top import Top
from tumble.scenarios.truth.inertia import Numbers
from tumble.scenarios.truth.rational import cross

# Of the time for which a body tips: when its angle and spin are read, before it lands or slips.
TIPPED = 0.9


class Observed(NamedTuple):
    """A number, its name and unit, and from when until when the motion shows it [s]."""

    name: str
    unit: str
    value: Any
    begins: Any
    ends: Any


def observed(setting: Setting, motion: Timeline) -> list[Observed]:
    """Return the observables of a motion, in order of time."""
    last = min(setting.times[-1], motion.ended)
    found = [*_of_events(setting, motion, last), *_of_phases(setting, motion, last)]
    return sorted(found, key=lambda one: float(one.begins))


def _of_events(setting: Setting, motion: Timeline, last: Any) -> Iterator[Observed]:
    impacts = 0
    for event, then in pairwise([*motion.events, None]):
        assert event is not None
        end = last if then is None else then.time
        if event.kind == IMPACT:
            impacts += 1
            yield from _of_impact(setting, event, end, impacts)
        elif event.kind == RESTS:
            yield Observed("instant of rest", "s", event.time, event.time, end)
            yield Observed("height at rest", "m", _height(setting, event.after.x), event.time, end)


def _of_impact(setting: Setting, event: Event, end: Any, number: int) -> Iterator[Observed]:
    assert event.impact is not None
    after, label = event.after, f"after impact {number}"
    yield Observed(f"instant of impact {number}", "s", event.time, event.time, end)
    yield from _vector(f"velocity {label}", "m/s", after.v, event.time, end)
    yield from _vector(f"spin {label}", "rad/s", after.w_world, event.time, end)
    yield Observed(f"rebound speed {label}", "m/s", event.impact.after @ setting.normal, event.time, end)
    yield Observed(f"energy lost in impact {number}", "J", event.impact.energy_lost, event.time, end)
    rise = after.v @ setting.normal
    if setting.restitution and setting.pressing > 0 and rise > 0 and event.time + rise / setting.pressing <= end:
        apex = _height(setting, after.x) + rise * rise / (2 * setting.pressing)
        yield Observed(f"apex {label}", "m", apex, event.time, end)


def _of_phases(setting: Setting, motion: Timeline, last: Any) -> Iterator[Observed]:
    for phase, then in pairwise([*motion.phases, None]):
        assert phase is not None
        end = last if then is None else then.since
        if end <= phase.since:
            continue
        stopped = next(
            (event.kind for event in motion.events if event.time == end and event.kind in (ROLLS, STOPS)), ""
        )
        if phase.name in ("slides", "slips") and stopped:
            yield from _of_path(setting, phase, end, "stops" if stopped == STOPS else "begins to roll")
        elif phase.name in ("slides", "slips", "rolls"):
            yield from _of_going(setting, phase, end)
        elif phase.name == "rests":
            start, finish = phase.at(phase.since), phase.at(end)
            drift = length(setting.mp, finish.x - start.x) / (end - phase.since)
            yield Observed("creep speed", "m/s", drift, phase.since, end)
            yield Observed("height at rest", "m", _height(setting, start.x), phase.since, end)
        elif isinstance(phase, Tipping) and phase.since == 0:
            yield from _of_tipping(setting, phase, end)
        elif isinstance(phase, Top):
            yield from _of_top(setting, phase, end)
        elif isinstance(phase, RollingDisc) and phase.is_straight:
            yield from _of_going(setting, phase, end)
        elif isinstance(phase, RollingDisc) and phase.since == 0:
            yield from _of_rolling_disc(setting, phase, end)


def _of_tipping(setting: Setting, phase: Tipping, end: Any) -> Iterator[Observed]:
    """Yield how far a body tips, how fast it is at that angle, and that its edge stays."""
    instant = end * setting.mp.mpf(TIPPED)
    yield Observed("angle it has tipped by", "rad", phase.turned_rad(instant), instant, instant)
    yield from _vector("spin at that angle", "rad/s", phase.at(instant).w_world, instant, instant)
    yield Observed("creep speed of the edge", "m/s", setting.mp.zero, phase.since, instant)


def _of_top(setting: Setting, phase: Top, end: Any) -> Iterator[Observed]:
    """Yield how a top precesses, nutates and spins, and that its tip stays."""
    took, since = end - phase.since, phase.since
    yield Observed("mean precession", "rad/s", phase.precessed_rad(end) / took, since, end)
    yield Observed("mean spin about the axis", "rad/s", phase.spin_rad_s, since, end)
    if phase.nutation_s <= took:
        yield Observed("greatest tilt of the axis", "rad", phase.greatest_tilt_rad, since, end)
    yield Observed("creep speed of the tip", "m/s", setting.mp.zero, since, end)


def _of_rolling_disc(setting: Setting, phase: RollingDisc, end: Any) -> Iterator[Observed]:
    """Yield how a disc on its rim precesses and tilts, that it has no slip, and that this takes no energy."""
    yield Observed("mean precession", "rad/s", phase.precessed_rad(end) / end, phase.since, end)
    yield Observed("greatest tilt of the axis", "rad", phase.greatest_tilt_rad(end), phase.since, end)
    yield Observed("creep speed of the rim", "m/s", setting.mp.zero, phase.since, end)
    yield Observed("energy lost as it rolls", "J", setting.mp.zero, phase.since, end)


def _of_path(setting: Setting, phase: Phase, end: Any, what: str) -> Iterator[Observed]:
    """Yield when, how far and in which direction a slip ends."""
    start, finish = phase.at(phase.since), phase.at(end)
    yield Observed(f"instant it {what}", "s", end, phase.since, end)
    way = finish.x - start.x
    yield Observed(f"distance until it {what}", "m", length(setting.mp, way), phase.since, end)
    if any(way) and any(start.v):
        along = setting.along(start.v)
        turned = setting.mp.atan2(cross(along, way) @ setting.normal, along @ way)
        yield Observed(f"turn of the path until it {what}", "rad", turned, phase.since, end)
    if what != "stops":
        yield from _vector(f"velocity as it {what}", "m/s", finish.v, end, end)
        yield from _vector(f"spin as it {what}", "rad/s", finish.w_world, end, end)


def _of_going(setting: Setting, phase: Phase, end: Any) -> Iterator[Observed]:
    """Yield the mean acceleration of a body that goes on along the plane."""
    start, finish = phase.at(phase.since), phase.at(end)
    gained = (finish.v - start.v) / (end - phase.since)
    yield from _vector(f"mean acceleration while it {phase.name}", "m/s2", gained, phase.since, end)


def _height(setting: Setting, x: Numbers) -> Any:
    return (x - setting.point) @ setting.normal


def _vector(name: str, unit: str, vector: Numbers, begins: Any, ends: Any) -> Iterator[Observed]:
    for axis, value in zip("xyz", np.asarray(vector), strict=True):
        yield Observed(f"{name}, {axis}", unit, value, begins, ends)
