"""A body whose face lies on the plane: it slides, stops, holds; or the face's edge is where it would tip.

Friction of a body that only slides is mu N against its velocity wherever it presses, so how the pressure is spread does
not matter; its centre must lie within the touching points, or the body tips.  Of a face that also spins it does
matter, and the law leaves it open, unless there is no friction.
"""

from typing import Any

import numpy as np

from tumble.scenarios.truth.contact.approach import Flight
from tumble.scenarios.truth.contact.setting import Setting, length, tangents, unit
from tumble.scenarios.truth.contact.slip_flow import SlipFlow
from tumble.scenarios.truth.flight import Pose
from tumble.scenarios.truth.inertia import Numbers
from tumble.scenarios.truth.rational import cross

# Of the lever of gravity: how far outside the touching points the pressure's centre may seem to be by rounding.
ROUNDED = 2.0**-40


class Face:
    """Points that touch the plane, not all on a line: pose laid flat, and where the pressure's centre may be.

    pose: with the points on the plane, no velocity along the normal, no spin across it; height: of the centre of mass.
    """

    def __init__(self, setting: Setting, pose: Pose, points: tuple[int, ...]) -> None:
        self.setting = setting
        normal, mp = setting.normal, setting.mp
        across = pose.axes @ _across(setting, points)
        turn = turning_between(mp, across if across @ normal < 0 else -across, -normal)
        axes = turn @ pose.axes
        arms = setting.face_points(points) @ axes.T
        self.height = -sum(arms @ normal) / len(arms)
        x = pose.x - normal * ((pose.x - setting.point) @ normal - self.height)
        w = normal * (pose.w_world @ normal)
        self.pose = Pose(x, axes, setting.along(pose.v), w)
        self._frame = np.array(tangents(mp, normal, 0 * normal))
        self._points, self._places = points, [arm @ self._frame.T for arm in arms]
        self._corners = _hull(self._places)

    def carries(self, force_along: Numbers, torque: Numbers) -> bool:
        """Return whether the face can press so that the body does not tip.

        force_along: friction over the normal force, (3,); torque: that the body needs about its centre of mass beyond
        friction's, over the normal force [m], (3,).
        """
        normal = self.setting.normal
        # r x n N + (-h n) x F = torque, so the centre of pressure is at r = n x torque - h F, over N.
        centre = (cross(normal, torque) - force_along * self.height) @ self._frame.T
        allowed = ROUNDED * float(self.setting.reach)
        if self.setting.rim is not None:
            return bool(length(self.setting.mp, centre) <= self.setting.rim[0] + allowed)
        return all(
            _side(*edge, centre) >= -allowed
            for edge in zip(self._corners, np.roll(self._corners, -1, axis=0), strict=True)
        )

    def tipping_edge(self, force_along: Numbers) -> tuple[int, ...]:
        """Return the points on the edge that the pressure's centre lies beyond."""
        centre = force_along * -self.height @ self._frame.T
        edges = list(zip(self._corners, np.roll(self._corners, -1, axis=0), strict=True))
        beyond = min(edges, key=lambda edge: _side(*edge, centre))
        near = ROUNDED * float(self.setting.reach)
        return tuple(
            point for point, place in zip(self._points, self._places, strict=True) if abs(_side(*beyond, place)) <= near
        )

    @property
    def carries_all(self) -> bool:
        """Whether it can press against friction in any direction."""
        reach = self.setting.friction * self.height
        if self.setting.rim is not None:
            return bool(self.setting.rim[0] >= reach)
        inside = (
            _side(*edge, 0 * edge[0]) for edge in zip(self._corners, np.roll(self._corners, -1, axis=0), strict=True)
        )
        return bool(min(inside) >= reach)


class Resting:
    """A body that stays where it is."""

    name = "rests"

    def __init__(self, setting: Setting, pose: Pose, since: Any) -> None:
        zero = 0 * pose.v
        self.since, self.until = since, setting.mp.inf
        self._pose = pose._replace(v=zero, w_world=zero)

    def at(self, time: Any) -> Pose:
        """Return the pose."""
        return self._pose


class Sliding:
    """A body that slides on its face with friction until it stops."""

    name = "slides"

    def __init__(self, setting: Setting, pose: Pose, since: Any, last: Any) -> None:
        self._setting, self.since, self._pose = setting, since, pose
        mp = setting.mp
        self._frame = np.array(tangents(mp, setting.normal, pose.v))
        hold = setting.friction * setting.pressing
        matrix = np.array(((hold, 0 * hold), (0 * hold, hold)))
        drift = self._frame @ setting.gravity_along
        self._flow = SlipFlow(mp, drift, matrix, self._frame @ pose.v, with_path=True)
        clock = np.array((mp.zero, mp.zero, mp.one))
        self._end, reached = self._flow.until(clock, -(max(last - since, mp.zero) + 1))
        self.until = mp.inf if reached else since + self._end.passed
        self.is_straight = self._flow.steady

    def at(self, time: Any) -> Pose:
        """Return the pose at an instant."""
        t = time - self.since
        now = self._flow.at(t) if t < self._end.passed else self._end
        return self._pose._replace(x=self._pose.x + now.path @ self._frame, v=now.velocity @ self._frame)


class Gliding:
    """A body whose face slides and spins without friction, or slides from rest against it: a constant acceleration."""

    name = "slides"

    def __init__(self, setting: Setting, pose: Pose, since: Any) -> None:
        gravity = setting.gravity_along
        size = length(setting.mp, gravity)
        self._pull = gravity if not size else gravity * (1 - setting.friction * setting.pressing / size)
        self._pose, self.since, self.until = pose, since, setting.mp.inf
        self._turning = Flight(setting, pose, since)

    def at(self, time: Any) -> Pose:
        """Return the pose at an instant."""
        t, start = time - self.since, self._pose
        x = start.x + start.v * t + self._pull * (t * t / 2)
        return Pose(x, self._turning.at(time).axes, start.v + self._pull * t, start.w_world)


def gyration(setting: Setting, pose: Pose) -> Numbers:
    """Return the torque that a steady spin needs, w x I w, over the weight on the plane [m], (3,)."""
    L = pose.axes @ setting.momentum_body(pose)
    return cross(pose.w_world, L) / (setting.mass * setting.pressing)


def friction_of(setting: Setting, direction: Numbers) -> Numbers:
    """Return friction over the normal force while the body slides along a direction, (3,)."""
    return unit(setting.mp, direction) * -setting.friction


def spans_a_face(setting: Setting, points: tuple[int, ...]) -> bool:
    """Return whether the points do not all lie on a line."""
    return len(points) > 2 and bool(_across(setting, points).any())


def turning_between(mp: Any, a: Numbers, b: Numbers) -> Numbers:
    """Return the rotation by the shortest way from one unit vector to another that is not opposite, (3, 3)."""
    x, y, z = cross(a, b)
    zero = 0 * x
    skew = np.array(((zero, -z, y), (z, zero, -x), (-y, x, zero)))
    turn = skew + skew @ skew / (1 + a @ b)
    turn[np.diag_indices(3)] += mp.one
    return turn


def _across(setting: Setting, points: tuple[int, ...]) -> Numbers:
    """Return a unit vector across the face, body axes, (3,); zeros for points on a line."""
    corners = setting.face_points(points)
    first = corners[0]
    second = max(corners, key=lambda corner: (corner - first) @ (corner - first))
    along = second - first
    third = max(corners, key=lambda corner: _square(cross(corner - first, along)))
    across = cross(third - first, along)
    size = setting.mp.sqrt(across @ across)
    if float(size) <= ROUNDED * float(setting.reach) ** 2:
        return 0 * across
    return across / size


def _square(vector: Numbers) -> Any:
    return vector @ vector


def _hull(points: list[Numbers]) -> Numbers:
    """Return the corners of the convex hull, anticlockwise, (k, 2).

    Source: Andrew, "Another efficient algorithm for convex hulls in two dimensions", Inf. Process. Lett. 9 (1979) 216.
    """
    ordered = sorted(points, key=lambda point: (point[0], point[1]))

    def chain(corners: list[Numbers]) -> list[Numbers]:
        found: list[Numbers] = []
        for corner in corners:
            while len(found) > 1 and _turn(found[-2], found[-1], corner) <= 0:
                found.pop()
            found.append(corner)
        return found[:-1]

    return np.array(chain(ordered) + chain(ordered[::-1]))


def _turn(a: Numbers, b: Numbers, c: Numbers) -> Any:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _side(a: Numbers, b: Numbers, point: Numbers) -> float:
    """Return how far a point is to the left of an edge [m]."""
    edge = (b - a).astype(float)
    return float(_turn(a, b, point)) / float(np.hypot(*edge))
