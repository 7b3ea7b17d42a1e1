"""What all throws of a body share, worked out once: its numbers as they are, and changed by patterns of signs."""

from fractions import Fraction
from random import Random
from typing import Any

import numpy as np

from scenarios.scene import Scene
from scenarios.truth.bulk.kernel import Bodies
from scenarios.truth.double_double import pairs
from scenarios.truth.inertia import Numbers, principal
from scenarios.truth.limit import OPPOSITE, PATTERNS, SHARES
from scenarios.truth.rotation import exact
from scenarios.truth.throw import Throw, changing, read_throw


def bodies(mp: Any, scene: Scene) -> Bodies:
    """Return the body for every share and pattern of signs: as `scenarios.truth.limit` changes them.

    mp: mpmath context, whose precision is that of the principal axes.
    """
    plain = read_throw(scene, 0)
    told = []
    for share in SHARES:
        patterns = [(pattern, share) for pattern in range(PATTERNS)] + [(0, OPPOSITE * share)]
        changed = [read_throw(scene, 0, changing(Random(pattern), part)) for pattern, part in patterns]
        told.append([_told(mp, throw) for throw in (plain, *changed)])
    numbers, points, times = (np.array([[one[part] for one in each] for each in told]) for part in range(3))
    return Bodies(numbers, points, times)


def _told(mp: Any, throw: Throw) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a body's numbers, its points along its principal axes, and the times, as pairs."""
    moments, axes = principal(mp, throw.solid.tensor)
    order = sorted(range(3), key=lambda axis: moments[axis])
    moments, axes = _fractions(moments)[order], _fractions(axes)[:, order]
    if np.cross(axes[:, 0], axes[:, 1]) @ axes[:, 2] < 0:
        axes = axes * [-1, 1, 1]
    first, second, third = moments
    gaps = [second - first, third - first, third - second]
    numbers = [*moments, *gaps, *(throw.state_axes @ axes).T.flat, *throw.gravity]
    return pairs(numbers), pairs(throw.points @ axes), pairs(list(throw.times))


def _fractions(numbers: Numbers) -> Numbers:
    return np.array([Fraction(exact(number)) for number in numbers.flat]).reshape(numbers.shape)
