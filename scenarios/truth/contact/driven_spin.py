"""Attitude of a body whose angular velocity is known and turns: q' = w q / 2, by Taylor's series."""

from typing import Any

import numpy as np

from tumble.scenarios.truth.contact.setting import Setting
from tumble.scenarios.truth.deadline import current
from tumble.scenarios.truth.inertia import Numbers

# Terms per bit of the working precision.
TERMS_PER_BIT = 0.36


class DrivenSpin:
    """Attitude under w = w0 + a t, world axes: the rolling and slipping of a sphere.

    w0 [rad/s], a [rad/s2], (3,); axes: the body's at t = 0, (3, 3).
    """

    def __init__(self, setting: Setting, axes: Numbers, w_world: Numbers, rate: Numbers) -> None:
        self._mp, self._axes, self._w, self._rate = setting.mp, axes, w_world, rate
        mp = self._mp
        self._order = max(16, int(TERMS_PER_BIT * mp.prec))
        one = np.array([mp.one, mp.zero, mp.zero, mp.zero], dtype=object)
        # Each step: when it starts, how long it is, and its series, (order + 1, 4).
        self._steps = [(mp.zero, *self._series(one, mp.zero))]

    def at(self, t: Any) -> Numbers:
        """Return the body's axes at t [s], (3, 3)."""
        while self._steps[-1][0] + self._steps[-1][1] < t:
            current().check()
            start, duration, series = self._steps[-1]
            then = start + duration
            self._steps.append((then, *self._series(horner(series, duration), then)))
        start, _, series = next(step for step in self._steps if t <= step[0] + step[1])
        return turn_of(horner(series, t - start)) @ self._axes

    def _series(self, q: Numbers, start: Any) -> tuple[Any, list[Numbers]]:
        """Return how long a step from an instant may be and the terms of q."""
        mp = self._mp
        w, terms = self._w + self._rate * start, [q]
        for k in range(self._order):
            growth = spinning(w, terms[k])
            if k:
                growth = growth + spinning(self._rate, terms[k - 1])
            terms.append(growth / (2 * (k + 1)))
        longest = mp.inf
        for power in (self._order - 1, self._order):
            size = max(map(abs, terms[power]))
            if size:
                longest = min(longest, mp.mpf(2) ** (float(-mp.prec - 8 - _log2(mp, size)) / power))
        return longest, terms


def turn_of(q: Numbers) -> Numbers:
    """Return the rotation matrix of a quaternion w x y z of length 1 or nearly so, (3, 3)."""
    w, x, y, z = q
    rows = (
        (w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z),
    )
    return np.array(rows) / (q @ q)


def _log2(mp: Any, value: Any) -> float:
    mantissa, exponent = mp.frexp(value)
    return float(exponent) + float(mp.log(mantissa)) / float(mp.log(2))


def spinning(w: Numbers, q: Numbers) -> Numbers:
    """Return the product of the pure quaternion w, (3,), and q, (4,)."""
    x, y, z = w
    a, b, c, d = q
    return np.array((-x * b - y * c - z * d, x * a + y * d - z * c, y * a + z * b - x * d, z * a + x * c - y * b))


def horner(terms: list[Numbers], t: Any) -> Numbers:
    """Return the value of a series of vectors."""
    total = terms[-1]
    for term in reversed(terms[:-1]):
        total = total * t + term
    return total
