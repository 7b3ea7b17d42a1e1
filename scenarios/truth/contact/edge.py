"""A body that tips over an edge which stays where it is: a pendulum, in Jacobi's functions; and a block that rocks.

The edge is a principal direction of the body and level with gravity, so the motion is in a plane.  x is the angle of
the centre of mass about the edge from where it hangs: x'' = -k^2 sin x, k^2 = m l g / (I + m l^2).
"""

import math
from typing import Any, NamedTuple

import numpy as np

from tumble.scenarios.truth.contact.face import turning_between
from tumble.scenarios.truth.contact.impact import STICKS, Impact, velocity_at
from tumble.scenarios.truth.contact.setting import Setting, length, unit
from tumble.scenarios.truth.elliptic import JacobiFunctions
from tumble.scenarios.truth.flight import Pose
from tumble.scenarios.truth.inertia import Numbers
from tumble.scenarios.truth.rational import cross

# How far a motion may be from one in a plane, of its own size, by rounding.
ROUNDED = 2.0**-40


class Pendulum:
    """x'' = -k^2 sin x from x and x', given by sin and cos of x / 2: swinging, turning over, or on the separatrix.

    Source: Landau & Lifshitz, "Mechanics" (1976), section 11, problem 1; DLMF 22.19(i).
    """

    def __init__(self, mp: Any, k: Any, half: tuple[Any, Any], rate: Any) -> None:
        self._mp, self._k, (sine, cosine) = mp, k, half
        # sin(x/2) = s sn(u), where it swings; x/2 = am(u), where it turns over.
        square = rate * rate / 4 + k * k * sine * sine
        rest = k * k * cosine * cosine - rate * rate / 4
        self._swings = rest >= 0
        if self._swings:
            self._scale, self._speed, m1 = mp.sqrt(square) / k, k, rest / (k * k)
            sn, cn, dn = (
                (sine / self._scale, rate / (2 * k * self._scale), cosine) if self._scale else (0 * k, mp.one, mp.one)
            )
            self._sign = 1
        else:
            self._scale, self._speed, m1 = mp.one, mp.sqrt(square), -rest / square
            self._sign = 1 if rate > 0 else -1
            sn, cn, dn = self._sign * sine, cosine, abs(rate) / (2 * self._speed)
        self._jacobi = JacobiFunctions(mp, m1)
        self._u0 = sn * mp.elliprf(cn * cn, dn * dn, mp.one)
        if cn < 0 and m1:
            self._u0 = 2 * self._jacobi.quarter_period - self._u0

    def at(self, t: Any) -> tuple[Any, Any, Any]:
        """Return sin(x/2), cos(x/2) and x' at t."""
        sn, cn, dn, _ = self._jacobi(self._u0 + self._speed * t)
        if self._swings:
            return self._scale * sn, dn, 2 * self._k * self._scale * cn
        return self._sign * sn, cn, self._sign * 2 * self._speed * dn


class Edge(NamedTuple):
    """An edge on the plane, straightened: pose; along: its direction, (3,); arm: from it to the centre of mass, (3,);

    moment: of inertia about it [kg m2]; rate: of the turn about `along` [rad/s].
    """

    pose: Pose
    along: Numbers
    arm: Numbers
    moment: Any
    rate: Any


def edge_of(setting: Setting, pose: Pose, points: tuple[int, ...]) -> Edge | None:
    """Return the edge that the points make, where the motion about it is in a plane; None where it is not."""
    mp, normal, size = setting.mp, setting.normal, float(setting.reach)
    corners = setting.points[list(points)]
    second = max(corners, key=lambda corner: (corner - corners[0]) @ (corner - corners[0]))
    line = unit(mp, pose.axes @ (second - corners[0]))
    along = unit(mp, setting.along(line))
    axes = turning_between(mp, line, along) @ pose.axes
    arms = corners @ axes.T
    middle = sum(arms) / len(points)
    arm = -(middle - along * (middle @ along))
    places = arms @ along
    inside = min(places) < -ROUNDED * size and max(places) > ROUNDED * size
    body = axes.T @ along
    twisted = cross(setting.tensor @ body, body)
    gravity = setting.gravity
    fast = float(setting.speed_m_s(pose))
    rate = pose.w_world @ along
    off = length(mp, pose.w_world - along * rate) * size + length(mp, pose.v - cross(along, arm) * rate)
    level = abs(float(gravity @ along)) <= ROUNDED * float(length(mp, gravity))
    is_principal = float(length(mp, twisted)) <= ROUNDED * float(abs(setting.tensor).max())
    if not (inside and is_principal and level and float(off) <= ROUNDED * fast):
        return None
    x = pose.x - normal * ((pose.x - setting.point) @ normal - arm @ normal)
    moment = body @ setting.tensor @ body + setting.mass * (arm @ arm)
    laid = Pose(x, axes, cross(along, arm) * rate, along * rate)
    return Edge(laid, along, arm, moment, rate)


class Tipping:
    """A body that turns about an edge."""

    name = "tips"
    repeats_s = math.inf

    def __init__(self, setting: Setting, edge: Edge, points: tuple[int, ...], since: Any) -> None:
        self.setting, self.points, self.since, self.until = setting, points, since, setting.mp.inf
        self._edge = edge
        mp, gravity = setting.mp, setting.gravity
        self._gravity = gravity - edge.along * (gravity @ edge.along)
        reach, pull = length(mp, edge.arm), length(mp, self._gravity)
        self._k = mp.sqrt(setting.mass * reach * pull / edge.moment)
        down, out = self._gravity / pull, edge.arm / reach
        cos, sin = down @ out, cross(down, out) @ edge.along
        # Half the angle without losing digits near either end.
        half = mp.sqrt((1 + cos) / 2), mp.sqrt((1 - cos) / 2)
        half = (
            (half[0], sin / (2 * half[0])) if cos > 0 else (abs(sin) / (2 * half[1]), half[1] if sin >= 0 else -half[1])
        )
        self._half = half[1], half[0]
        self._pendulum = Pendulum(mp, self._k, self._half, edge.rate)
        self._hinge = edge.pose.x - edge.arm
        k2 = float(self._k) ** 2
        self.fastest = float(mp.sqrt(edge.rate**2 + 4 * self._k**2))
        self.bend = self.fastest**2 + k2
        self.jerk = float(reach) * self.fastest * (4 * k2 + self.fastest**2)

    def _turned(self, time: Any) -> tuple[Any, Any, Any, Any]:
        """Return cos and sin of the angle from the start, x', and x''."""
        sine, cosine, rate = self._pendulum.at(time - self.since)
        first_sine, first_cosine = self._half
        # Of the half angles' difference, doubled.
        s, c = sine * first_cosine - cosine * first_sine, cosine * first_cosine + sine * first_sine
        return c * c - s * s, 2 * s * c, rate, -self._k * self._k * 2 * sine * cosine

    def turned_rad(self, time: Any) -> Any:
        """Return the angle by which the body has turned, below pi [rad]."""
        cos, sin, _, _ = self._turned(time)
        return abs(self.setting.mp.atan2(sin, cos))

    def at(self, time: Any) -> Pose:
        """Return the pose at an instant."""
        cos, sin, rate, _ = self._turned(time)
        edge = self._edge
        x, y, z = edge.along
        zero = 0 * x
        turn = (
            np.outer(edge.along, edge.along) * (1 - cos) + np.array(((zero, -z, y), (z, zero, -x), (-y, x, zero))) * sin
        )
        turn[np.diag_indices(3)] += cos
        arm = turn @ edge.arm
        return Pose(self._hinge + arm, turn @ edge.pose.axes, cross(edge.along, arm) * rate, edge.along * rate)

    def force(self, time: Any) -> Numbers:
        """Return the force of the plane on the body [N], (3,)."""
        _, _, rate, bend = self._turned(time)
        arm = self.at(time).x - self._hinge
        return (cross(self._edge.along, arm) * bend - arm * (rate * rate) - self._gravity) * self.setting.mass


def rock(setting: Setting, pose: Pose, old: tuple[int, ...], new: tuple[int, ...]) -> Impact | None:
    """Return what the landing on a second edge does, without restitution, where friction holds it; None elsewhere.

    The moment of momentum about the new edge stays, and the old one leaves the plane: Housner, "The behavior of
    inverted pendulum structures during earthquakes", Bull. Seism. Soc. Am. 53 (1963) 403, eq. 5.  Where it would not
    leave, a squat block, both hold and the body is at rest.
    """
    before = edge_of(setting, pose, old)
    turned = pose._replace(v=0 * pose.v, w_world=0 * pose.w_world)
    after = edge_of(setting, turned, new)
    if before is None or after is None or setting.restitution:
        return None
    if abs(before.along @ after.along) < 1 - ROUNDED:
        return None
    own = after.moment - setting.mass * (after.arm @ after.arm)
    rate = before.rate * (own + setting.mass * (after.arm @ before.arm)) / after.moment
    stays = rate * before.rate <= 0
    w = before.along * (0 * rate if stays else rate)
    v = cross(w, after.arm)
    J = (v - pose.v) * setting.mass
    along = setting.along(J)
    if length(setting.mp, along) > setting.friction * (J @ setting.normal):
        return None
    then = pose._replace(v=v, w_world=w)
    arm = setting.levers(pose)[new[0]]
    lost = _energy(setting, pose) - _energy(setting, then)
    return Impact(J, velocity_at(pose, arm), 0 * J, then, (STICKS,), lost)


def _energy(setting: Setting, pose: Pose) -> Any:
    w_body = pose.axes.T @ pose.w_world
    return (setting.mass * (pose.v @ pose.v) + w_body @ setting.tensor @ w_body) / 2
