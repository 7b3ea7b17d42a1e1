"""Free flight above the plane, and which point meets it first, when.

The first contact is found in doubles by conservative advancement: no point's height can fall faster than its velocity
and a bound of its acceleration let it, so steps that stay above that parabola pass no contact (Mirtich & Canny,
"Impulse-based simulation of rigid bodies", I3D (1995) 181).  From where a point is as near as doubles can tell,
Newton's steps give the instant with all digits; that there is one root, and where, is Kantorovich's condition with the
same bound.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from tumble.scenarios.frames import Array
from tumble.scenarios.truth.contact.impact import velocity_at
from tumble.scenarios.truth.contact.setting import FLAT, Setting
from tumble.scenarios.truth.flight import Arc, Pose
from tumble.scenarios.truth.inertia import Numbers
from tumble.scenarios.truth.rational import cross

# Of the body's size: the height at which Newton's steps take over, and for each radian turned, what doubles lose.
NEAR, LOST_PER_RADIAN = 2.0**-36, 2.0**-48
MOST_ADVANCES = 20_000
# Of the time left: a step that is none.
TINY = 1e-15
# Kantorovich's h = |g| |g''| / g'^2 must be below 1/2; with this much less Newton's first step is nearly the last.
TRANSVERSAL = 1 / 8


class NoContactFound(Exception):
    """The search for the next contact did not end; the text says why."""


class Flight:
    """Free flight under gravity from a pose at an instant: the closed form of `tumble.scenarios.truth.flight`."""

    name = "flight"

    def __init__(self, setting: Setting, pose: Pose, since: Any) -> None:
        self._setting, self.since, self.until = setting, since, setting.mp.inf
        self._arc = Arc(pose.x, pose.v, setting.gravity, since)
        self._rotation = setting.turning.start(pose.axes, setting.momentum_body(pose))

    def at(self, time: Any) -> Pose:
        """Return the pose at an instant."""
        x, v = self._arc.at(time)
        axes, L_body = self._rotation.at(time - self.since)
        return Pose(x, axes, v, axes @ (self._setting.inverse @ L_body))


class Meeting(NamedTuple):
    """The points that meet the plane, by number, and when."""

    points: tuple[int, ...]
    time: Any


def meeting(setting: Setting, near: Setting, flight: Flight, pose: Pose, until: Any) -> Meeting | None:
    """Return the first contact of a flight from a pose not approaching the plane, None if none before an instant.

    near: the same setting in doubles.  Raises NoContactFound.
    """
    if setting.radius is not None:
        time = _sphere_meets(setting, pose)
        return None if time is None or flight.since + time > until else Meeting((0,), flight.since + time)
    rough = in_doubles(near, pose)
    advance = _advance if setting.rim is None else _advance_disc
    found = advance(near, rough, float(until - flight.since))
    if found is None:
        return None
    points, guess = found
    return _refined(setting, flight, points, flight.since + setting.mp.mpf(guess), until)


def meets_near(setting: Setting, flight: Flight, point: int, guess: float, pose: Pose) -> Any:
    """Return when a point meets the plane, from an instant near to that: in doubles, of inputs changed a little."""
    if setting.radius is not None:
        time = _sphere_meets(setting, pose)
        if time is None:
            raise NoContactFound("a changed flight does not meet the plane")
        return flight.since + time
    return _newton(setting, flight, point, setting.mp.mpf(guess), transversal=False)


def in_doubles(near: Setting, pose: Pose) -> Pose:
    """Return a pose in doubles."""
    return Pose(*(near.numbers(part) for part in pose))


def _sphere_meets(setting: Setting, pose: Pose) -> Any:
    """Return after what time the sphere's lowest point falls to the plane, None where it never does."""
    # What has just left the plane is on it: below by rounding, it would seem never to fall.
    height, rate = max(setting.gaps(pose)[0], 0 * setting.reach), pose.v @ setting.normal
    pull = setting.gravity @ setting.normal
    square = rate * rate - 2 * pull * height
    if square < 0 or (rate >= 0 and pull >= 0):
        return None
    root = setting.mp.sqrt(square)
    if pull < 0:
        return (rate + root) / -pull
    return 2 * height / (root - rate)


def _advance(near: Setting, pose: Pose, until: float) -> tuple[list[int], float] | None:
    """Return the points that come as near as doubles can tell, and when; None if none before an instant."""
    flight = Flight(near, pose, 0.0)
    normal, reach = near.normal.astype(float), float(near.reach)
    pull = float(near.gravity @ near.normal)
    moments = near.moments.astype(float)
    L = float(np.linalg.norm(near.momentum_body(pose).astype(float)))
    spin = min(L / moments.min(), np.sqrt(float(pose.w_world @ (pose.axes @ near.momentum_body(pose))) / moments.min()))
    # |p''| <= |w'| |p| + |w|^2 |p|, and |w'| <= |w|^2 by Euler's equations, A + B >= C.
    turning = 2 * spin * spin * np.linalg.norm(near.points.astype(float), axis=1)
    bend = turning - pull
    time, leaving = 0.0, True
    for _ in range(MOST_ADVANCES):
        if time > until:
            return None
        now = flight.at(time)
        heights, rates = motion_along(near, now, normal)
        close = NEAR * reach + LOST_PER_RADIAN * reach * (1 + spin * time)
        # What has just left the plane is on it still, and rises.
        low = (heights < close) & ((rates < 0) | (not leaving))
        if low.any():
            return np.flatnonzero(heights < max(heights.min(), 0.0) + 2 * close).tolist(), time
        step = safe_step(np.maximum(heights, 0.0), rates, bend).min()
        centre = float((now.x - near.point) @ near.normal) - reach - close
        if centre > 0:
            step = max(
                step, safe_step(np.array([centre]), np.array([float(now.v @ near.normal)]), np.array([-pull]))[0]
            )
        if not step > 0:
            raise NoContactFound("impacts follow one another too closely")
        time, leaving = time + float(step), False
        if not np.isfinite(time):
            return None
    raise NoContactFound("the search for the next contact takes too many steps")


def _advance_disc(near: Setting, pose: Pose, until: float) -> tuple[list[int], float] | None:
    """Return the rims of a disc that come as near as doubles can tell, and when; None if none before an instant.

    The height of each point p of the body is h + p.n, in body axes, n' = n x w and |p.n''| <= 2 w^2 |p|: so none is
    below h + h' t - g t^2 / 2 - a |P (n + n' t)| - b |z (n + n' t)| - w^2 |p| t^2, P across the axis, which is concave.
    """
    assert near.rim is not None
    flight, (radius, half) = Flight(near, pose, 0.0), map(float, near.rim)
    normal, reach, pull = near.normal.astype(float), float(near.reach), float(near.gravity @ near.normal)
    moments, L = near.moments.astype(float), float(np.linalg.norm(near.momentum_body(pose).astype(float)))
    fastest = L / moments.min()
    time, leaving = 0.0, True
    for _ in range(MOST_ADVANCES):
        if time > until:
            return None
        now = flight.at(time)
        axes, w = now.axes.astype(float), now.w_world.astype(float)
        n, turns = normal @ axes, np.cross(normal, w) @ axes
        height = float((now.x - near.point) @ near.normal)
        close = reach * (NEAR + LOST_PER_RADIAN * (1 + fastest * time))
        levers = near.levers(now)
        gaps = height + (levers @ near.normal).astype(float)
        rates = np.array([float(velocity_at(now, lever) @ near.normal) for lever in levers])
        if ((gaps < close) & ((rates < 0) | (not leaving))).any():
            return np.flatnonzero(gaps < max(gaps.min(), 0.0) + 2 * close).tolist(), time
        bend = reach * fastest**2 - pull / 2
        falls = height - min(gaps.min(), 0.0), float(now.v @ near.normal), bend
        step = _last_zero(_no_lower(falls, n, turns, radius, half), until - time + 1)
        if not step > 0:
            raise NoContactFound("impacts follow one another too closely")
        time, leaving = time + step, False
    raise NoContactFound("the search for the next contact takes too many steps")


def _no_lower(
    falls: tuple[float, float, float], n: Array, turns: Array, radius: float, half: float
) -> Callable[[float], float]:
    """Return what no point of a disc is below, as a function of time; falls: height, its rate, and what bends it."""

    def height(t: float) -> float:
        m = n + turns * t
        return falls[0] + (falls[1] - falls[2] * t) * t - radius * math.hypot(m[0], m[1]) - half * abs(m[2])

    return height


def _last_zero(concave: Callable[[float], float], most: float) -> float:
    """Return up to where a concave function that begins at zero or above stays so, at most `most`, by halving."""
    if concave(most) >= 0:
        return most
    low, high = 0.0, most
    while high - low > 1e-3 * high and high > TINY * most:
        middle = (low + high) / 2
        low, high = (middle, high) if concave(middle) >= 0 else (low, middle)
    return low


def motion_along(setting: Setting, pose: Pose, normal: Array) -> tuple[Array, Array]:
    """Return heights above the plane [m] and their rates [m/s] of all points, (n,), in doubles."""
    axes = pose.axes.astype(float)
    arms = setting.points.astype(float) @ axes.T
    heights = float((pose.x - setting.point) @ setting.normal) + arms @ normal
    rates = float(pose.v @ setting.normal) + np.cross(pose.w_world.astype(float), arms) @ normal
    return heights, rates


def safe_step(heights: Array, rates: Array, bend: Array) -> Array:
    """Return how long h + h' t - bend t^2 / 2 stays above zero from h >= 0, (n,)."""
    square = rates * rates + 2 * bend * heights
    root = np.sqrt(np.maximum(square, 0.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        falling = np.where(square > 0, 2 * heights / (root - rates), np.inf)
        rising = np.where(bend > 0, (rates + root) / bend, np.inf)
    return np.where(rates < 0, falling, rising)


def _refined(setting: Setting, flight: Flight, points: list[int], guess: Any, until: Any) -> Meeting | None:
    """Return the first of the points to meet the plane, with those that meet it at the same instant."""
    time = min(_newton(setting, flight, point, guess) for point in points)
    if time > until:
        return None
    pose = flight.at(time)
    touching = setting.touching_m(pose)
    gaps = setting.gaps(pose)
    return Meeting(tuple(point for point, gap in enumerate(gaps) if gap <= touching), time)


def _newton(setting: Setting, flight: Flight, point: int, time: Any, transversal: bool = True) -> Any:
    """Return when a point's height falls through zero.  Raises NoContactFound where it only grazes the plane."""
    mp = setting.mp
    size = setting.reach
    for _ in range(mp.prec):
        pose = flight.at(time)
        lever = setting.lever(pose, point)
        height = (pose.x - setting.point + lever) @ setting.normal
        rate = velocity_at(pose, lever) @ setting.normal
        w = pose.w_world
        bend = 2 * (w @ w) * size + abs(setting.gravity @ setting.normal) + _rolls_over(setting, pose)
        if transversal and not (rate < 0 and abs(height) * bend <= TRANSVERSAL * rate * rate):
            raise NoContactFound(
                f"{setting.point_name(point)} grazes the plane, or its impacts follow one another without end, "
                f"at {float(time):.6g} s"
            )
        step = height / rate
        time = time - step
        if abs(step * rate) <= mp.ldexp(size, -mp.prec // 2 - 8):
            # The next step would be no more than this one squared.
            return time - _remainder(setting, flight.at(time), point)
    raise NoContactFound(f"{setting.point_name(point)} has no clear instant of contact")


def _rolls_over(setting: Setting, pose: Pose) -> Any:
    """Return a bound of how fast the rate of a disc's lowest point changes by its being another one [m/s2].

    d2|P n|/dt2 is at most that of the vector and the square of its turn over |P n|, and that twice near by.
    """
    if setting.rim is None or (sine := setting.sine_of_tilt(pose)) <= FLAT:
        return setting.mp.zero
    return 2 * setting.rim[0] * (pose.w_world @ pose.w_world) / sine


def _remainder(setting: Setting, pose: Pose, point: int) -> Any:
    lever = setting.lever(pose, point)
    height: Numbers = (pose.x - setting.point + lever) @ setting.normal
    return height / ((pose.v + cross(pose.w_world, lever)) @ setting.normal)
