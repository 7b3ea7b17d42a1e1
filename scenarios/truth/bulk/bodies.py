"""What all instants and throws of a body share, worked out once: its numbers as they are, and changed by signs."""

from random import Random
from typing import Any

import numpy as np

from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Scene
from tumble.scenarios.truth.bulk.kernel import Bodies
from tumble.scenarios.truth.double_double import pairs
from tumble.scenarios.truth.inertia import Numbers, principal
from tumble.scenarios.truth.rational import Fraction
from tumble.scenarios.truth.resolution import OPPOSITE, PATTERNS, SHARES
from tumble.scenarios.truth.rotation import exact
from tumble.scenarios.truth.throw import Throw, changing, read_throw

Readings = list[list[Throw]]


def readings(scene: Scene, row: int) -> Readings:
    """Return a throw as it is and as `scenarios.truth.resolution` changes it, for each share one of every READINGS."""
    plain = read_throw(scene, row)
    patterns = [*((pattern, 1.0) for pattern in range(PATTERNS)), (0, OPPOSITE)]
    return [
        [plain, *(read_throw(scene, row, changing(Random(pattern), part * share)) for pattern, part in patterns)]
        for share in SHARES
    ]


def bodies(mp: Any, read: Readings, times: Array) -> Bodies:
    """Return the bodies of the readings, and the times by their clocks.

    mp: mpmath context, whose precision is that of the principal axes; times: pairs, (2, R, N or 1) [s].
    """
    values = [[_values(mp, throw) for throw in throws] for throws in read]
    numbers, points = (np.array([[one[part] for one in each] for each in values]) for part in range(2))
    clocks = [[float(throw.times[-1] / read[0][0].times[-1]) for throw in throws] for throws in read]
    # Only the first of each keeps all digits, and needs them.
    return Bodies(numbers, points, np.array(clocks)[..., np.newaxis, np.newaxis, np.newaxis] * times)


def _values(mp: Any, throw: Throw) -> tuple[Array, Array]:
    """Return a body's numbers and its points along its principal axes, as pairs."""
    moments, axes = principal(mp, throw.solid.tensor)
    order = sorted(range(3), key=lambda axis: moments[axis])
    moments, axes = _fractions(moments)[order], _fractions(axes)[:, order]
    if np.cross(axes[:, 0], axes[:, 1]) @ axes[:, 2] < 0:
        axes = axes * [-1, 1, 1]
    first, second, third = moments
    gaps = [second - first, third - first, third - second]
    return pairs([*moments, *gaps, *(throw.state_axes @ axes).T.flat, *throw.gravity]), pairs(throw.points @ axes)


def _fractions(numbers: Numbers) -> Numbers:
    return np.array([Fraction(exact(number)) for number in numbers.flat]).reshape(numbers.shape)
