"""A symmetric body on its tip, which friction holds: Lagrange's top, in Jacobi's and Legendre's functions.

z, the cosine of the axis' angle from the vertical, swings between two roots of a cubic:

    z'^2 = (1 - z^2)(alpha - beta z) - (b - a z)^2 = beta (z - z1)(z2 - z)(z3 - z),   z = z1 + (z2 - z1) sn^2(u),

and the axis turns about the vertical by the integral of (b - a z) / (1 - z^2), two integrals of the third kind.
Source: Whittaker, "A Treatise on the Analytical Dynamics" (1937), sections 71-72; Goldstein (1980), section 5-7; the
integrals by Carlson's RJ: DLMF 19.25.14.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from tumble.scenarios.truth.contact.setting import TOUCHING, Setting, length, unit
from tumble.scenarios.truth.elliptic import Amplitude, JacobiFunctions, third_kind_angle
from tumble.scenarios.truth.flight import Pose
from tumble.scenarios.truth.inertia import Numbers, identity
from tumble.scenarios.truth.rational import cross

# How far a body may be from symmetric about the line from its tip to its centre, by rounding; how near the axis may
# come to the vertical, where its angles lose their meaning.
ROUNDED, VERTICAL = 2.0**-44, 2.0**-20
# Of its reach: how far its points stay above the plane where none can land.
CLEAR = 1e-6


def is_top(setting: Setting, point: int) -> bool:
    """Return whether the body is symmetric about the line from a point to its centre of mass."""
    tip = setting.points[point]
    axis = unit(setting.mp, tip)
    along = axis @ setting.tensor @ axis
    across = (np.trace(setting.tensor) - along) / 2
    symmetric = identity() * across + np.outer(axis, axis) * (along - across)
    return bool(abs(setting.tensor - symmetric).max() <= ROUNDED * abs(setting.tensor).max())


def is_upright(setting: Setting, pose: Pose, point: int) -> bool:
    """Return whether the axis is too near the vertical for its angles."""
    e3 = unit(setting.mp, pose.axes @ setting.points[point])
    side = cross(e3, setting.gravity)
    return bool(side @ side <= VERTICAL * (setting.gravity @ setting.gravity))


class Top:
    """A symmetric body that turns about its tip."""

    name = "spins on its tip"

    def __init__(self, setting: Setting, pose: Pose, point: int, since: Any) -> None:
        self.setting, self.points, self.since, self.until = setting, (point,), since, setting.mp.inf
        mp, m = setting.mp, setting.mass
        lever = pose.axes @ setting.points[point]
        gap = (pose.x - setting.point + lever) @ setting.normal
        self._tip = pose.x + lever - setting.normal * gap
        self._height = length(mp, lever)
        self._carlson = third_integral(mp)
        self._axes, e3 = pose.axes, -lever / self._height
        body = pose.axes.T @ e3
        self._I3 = body @ setting.tensor @ body
        self._I = (np.trace(setting.tensor) - self._I3) / 2 + m * self._height**2
        pull = length(mp, setting.gravity)
        self._up, self._e3, w = -setting.gravity / pull, e3, pose.w_world
        self._w3 = w @ e3
        self._z0 = e3 @ self._up
        axis_rate = cross(w, e3)
        a, beta = self._I3 * self._w3 / self._I, 2 * m * pull * self._height / self._I
        across = w - e3 * self._w3
        b = a * self._z0 + across @ self._up
        alpha = across @ across + beta * self._z0
        self._a, self._b, self._torque = a, b, m * self._height * pull / self._I
        self._set_course(alpha, beta, axis_rate @ self._up)
        # Bounds: |w|^2 <= w3^2 + alpha + beta, of the axis; and of the centre's third derivative.
        turn = float(mp.sqrt(alpha + beta))
        spin = float(abs(a)) + turn
        torque = float(self._torque)
        self.fastest = float(abs(self._w3)) + turn
        self.bend = self.fastest**2 + torque + spin * turn + float(abs(self._w3)) * turn
        self.jerk = float(self._height) * (3 * torque * turn + spin * (torque + spin * turn))

    def _set_course(self, alpha: Any, beta: Any, rate: Any) -> None:
        """Find the roots between which z swings, and where in its swing it starts; rate: z'."""
        mp, a, b = self.setting.mp, self._a, self._b
        low, middle, high = _roots(mp, (beta, -(alpha + a * a), 2 * a * b - beta, alpha - b * b), self._z0)
        self._low, self._span = low, middle - low
        self._speed = mp.sqrt(beta * (high - low)) / 2
        self._m1 = (high - middle) / (high - low)
        self._jacobi = JacobiFunctions(mp, self._m1)
        m = self._span / (high - low)
        share = (self._z0 - low) / self._span if self._span else mp.zero
        share = min(max(share, mp.zero), mp.one)
        sn, cn = mp.sqrt(share), mp.sqrt(1 - share)
        dn = mp.sqrt(1 - m * share)
        if rate < 0:
            cn = -cn
        u0 = sn * mp.elliprf(cn * cn, dn * dn, mp.one)
        self._u0 = 2 * self._jacobi.quarter_period - u0 if cn < 0 else u0
        # (b - a z) / (1 - z^2) in partial fractions.
        self._poles = [
            ((b - a) / (2 * (1 - low)), self._span / (1 - low)),
            ((b + a) / (2 * (1 + low)), -self._span / (1 + low)),
        ]
        self._quarters = [self._third(mp.one, mp.zero, mp.sqrt(self._m1), n) for _, n in self._poles]
        self._begun = self._thirds(self._jacobi(self._u0))

    def _third(self, sn: Any, cn: Any, dn: Any, n: Any) -> Any:
        """Return n sn^3 RJ / 3, what Legendre's third integral has beyond the first."""
        if not n or not sn:
            return self.setting.mp.zero
        return self._carlson(self._m1, n, (sn, cn, dn))

    def _thirds(self, amplitude: Amplitude) -> list[Any]:
        """Return the same of both poles from u = 0 to an amplitude."""
        sn, cn, dn, half_periods = amplitude
        sign = -1 if half_periods % 2 else 1
        return [
            2 * half_periods * quarter + sign * self._third(sn, cn, dn, n)
            for (_, n), quarter in zip(self._poles, self._quarters, strict=True)
        ]

    @property
    def spin_rad_s(self) -> Any:
        """The spin about the axis, which stays [rad/s]."""
        return self._w3

    @property
    def nutation_s(self) -> Any:
        """The time in which the axis sinks and rises once [s]."""
        return 2 * self._jacobi.quarter_period / self._speed

    @property
    def repeats_s(self) -> float:
        """When the plane's force and the body's height repeat: with the nutation, above a level plane that no point

        reaches at the greatest tilt, whatever the spin; else inf [s].
        """
        setting, height, z = self.setting, float(self._height), float(self._low)
        points = setting.points.astype(float)
        along = -(points @ points[self.points[0]]) / height
        side = np.sqrt(np.maximum((points * points).sum(axis=1) - along**2, 0.0))
        lowest = np.delete((along + height) * z - side * math.sqrt(max(1 - z * z, 0.0)), self.points[0])
        slope = float(length(setting.mp, setting.gravity_along))
        clears = (lowest > CLEAR * float(setting.reach)).all() and slope <= TOUCHING * float(setting.pressing)
        return float(self.nutation_s) if clears else math.inf

    @property
    def greatest_tilt_rad(self) -> Any:
        """The greatest angle of the axis from the vertical [rad]."""
        return self.setting.mp.acos(self._low)

    def precessed_rad(self, time: Any) -> Any:
        """Return the angle by which the axis has turned about the vertical [rad]."""
        return sum(self._integrals(time - self.since)[1])

    def _integrals(self, t: Any) -> tuple[Amplitude, tuple[Any, Any]]:
        """Return the amplitude after t [s], and the integrals of (b - a) / (2 (1 - z)) and (b + a) / (2 (1 + z))."""
        amplitude = self._jacobi(self._u0 + self._speed * t)
        first, second = (
            factor * (t + (now - begun) / self._speed)
            for (factor, _), now, begun in zip(self._poles, self._thirds(amplitude), self._begun, strict=True)
        )
        return amplitude, (first, second)

    def _state(self, time: Any) -> tuple[Numbers, Numbers, Numbers, Any]:
        """Return e3, its rate, the direction along which it turns about the vertical, (3,) each; and the spin's angle

        about e3 from the line of nodes: the integral of w3 - z (b - a z) / (1 - z^2).

        z (b - a z) / (1 - z^2) = a + ((b - a) / (1 - z) - (b + a) / (1 + z)) / 2.
        """
        mp, t = self.setting.mp, time - self.since
        (sn, cn, dn, _), (first, second) = self._integrals(t)
        turned, spun = first + second, (self._w3 - self._a) * t - first + second
        z = self._low + self._span * sn * sn
        z_rate = 2 * self._span * self._speed * sn * cn * dn
        along = mp.sqrt(1 - z * z)
        precession = (self._b - self._a * z) / (1 - z * z)
        cos, sin = mp.cos_sin(turned)
        out = (self._e3 - self._up * self._z0) / mp.sqrt(1 - self._z0**2)
        side = cross(self._up, out)
        way, cross_way = out * cos + side * sin, side * cos - out * sin
        e3 = way * along + self._up * z
        rate = self._up * z_rate - way * (z * z_rate / along) + cross_way * (along * precession)
        return e3, rate, cross_way, spun

    def at(self, time: Any) -> Pose:
        """Return the pose at an instant."""
        e3, rate, side, angle = self._state(time)
        # The body's axes: those of the line of nodes at the start and now, and the spin about e3 between.
        first = self._nodes(self._e3, cross(self._up, (self._e3 - self._up * self._z0)))
        now = self._nodes(e3, side)
        cos, sin = self.setting.mp.cos_sin(angle)
        spun = np.array((now[0] * cos + now[1] * sin, now[1] * cos - now[0] * sin, e3)).T
        axes = spun @ np.array((first[0], first[1], self._e3)) @ self._axes
        w = cross(e3, rate) + e3 * self._w3
        x = self._tip + e3 * self._height
        return Pose(x, axes, cross(w, e3 * self._height), w)

    def _nodes(self, e3: Numbers, side: Numbers) -> tuple[Numbers, Numbers]:
        """Return the line of nodes and what completes it with e3, (3,) each."""
        node = unit(self.setting.mp, side)
        return node, cross(e3, node)

    def force(self, time: Any) -> Numbers:
        """Return the force of the plane on the body [N], (3,)."""
        e3, rate, _, _ = self._state(time)
        L = cross(e3, rate) + e3 * self._a
        bend = cross(cross(self._up, e3) * self._torque, e3) + cross(L, rate)
        return (bend * self._height - self.setting.gravity) * self.setting.mass


def third_integral(mp: Any) -> Callable[[Any, Any, tuple[Any, Any, Any]], Any]:
    """Return n sn^3 RJ(cn^2, dn^2, 1, 1 - n sn^2) / 3 of m1 = 1 - m, n and (sn, cn, dn), for n <= 0 or n >= m.

    By the house's series, three times as fast as mpmath's RJ; of doubles by scipy's, which is faster still.
    """
    if not hasattr(mp, "_set_prec"):
        from scipy.special import elliprj  # slow to load

        def of_doubles(m1: Any, n: Any, functions: tuple[Any, Any, Any]) -> Any:
            sn, cn, dn = functions
            return n / 3 * sn**3 * float(elliprj(cn * cn, dn * dn, 1.0, 1 - n * sn * sn))

        return of_doubles

    def of_any(m1: Any, n: Any, functions: tuple[Any, Any, Any]) -> Any:
        sn, cn, dn = functions
        x, y, p = cn * cn, dn * dn, 1 - n * sn * sn
        square = -n * (1 - n) * (1 - m1 - n)
        if square <= 0:
            # n = m, but for rounding.
            return n / 3 * sn**3 * mp.elliprj(x, y, 1, p)
        root = mp.sqrt(square)
        return n * third_kind_angle(mp, x, y, mp.one, p, root * sn**3) / root

    return of_any


def _roots(mp: Any, cubic: tuple[Any, ...], inside: Any) -> tuple[Any, Any, Any]:
    """Return the roots of c3 z^3 + c2 z^2 + c1 z + c0, rising; inside: a value between the lower two, or one of them.

    They are asked for with twice the digits, half of which a steady precession, two equal roots, takes.
    """
    bits = mp.prec
    try:
        if hasattr(mp, "_set_prec"):
            mp.prec = 2 * bits + 64
        lowered = [coefficient / cubic[0] for coefficient in cubic]
        p2, p1, p0 = lowered[1], lowered[2], lowered[3]
        shift = -p2 / 3
        p = p1 - p2 * p2 / 3
        q = 2 * p2**3 / 27 - p2 * p1 / 3 + p0
        # Three real roots: Viete.
        radius = 2 * mp.sqrt(max(-p / 3, mp.zero))
        if not radius:
            return shift, shift, shift
        cosine = min(max(3 * q / (p * radius), -mp.one), mp.one)
        angle = mp.acos(cosine) / 3
        found = sorted(shift + radius * mp.cos(angle - 2 * mp.pi * k / 3) for k in range(3))
        low, middle, high = found
        return min(low, inside), max(middle, inside), high
    finally:
        if hasattr(mp, "_set_prec"):
            mp.prec = bits
