"""Steps longer than the sampling interval of a scene: its errors are measured where those steps end."""

from dataclasses import replace

import numpy as np

from tumble.compare.run.flight import legs
from tumble.scenarios.scene import Scene, frozen_array

MOST_COUNT = 60
# Steps per interval, 1, 2, 3, 4, 6, 8, 12, ...: each differs from the next by a third or a half.
COUNTS = tuple(sorted({2**k for k in range(MOST_COUNT)} | {3 * 2**k for k in range(MOST_COUNT)})[:MOST_COUNT])


def longer_steps(scene: Scene) -> dict[float, Scene]:
    """Return the scene sampled where steps longer than its sampling interval end.

    Parameters
    ----------
    scene : the scene

    Returns
    -------
    scene by step [s], the longest first; impulses still cut the steps; empty if samples are no closer than impulses
    """
    ends = [*sorted({impulse.time for impulse in scene.impulses} - {0.0, scene.duration}), scene.duration]
    sampled = len(legs(scene, scene.duration))
    found = {}
    for count in COUNTS:
        if count * len(ends) >= sampled:
            break
        dt = scene.duration / (count * len(ends))
        found[dt] = replace(scene, times=frozen_array(step_ends(ends, dt)))
    return found


def step_ends(ends: list[float], dt: float) -> list[float]:
    """Return the instants [s] at which equal steps of at most dt end, in each interval between the ends."""
    found: list[float] = []
    for begin, end in zip([0.0, *ends], ends, strict=False):
        steps = int(np.ceil((end - begin) / dt - 1e-9))
        found += [begin + (end - begin) * step / steps for step in range(1, steps)]
        found.append(end)
    return found


def with_all_samples(scene: Scene, longer: dict[float, Scene]) -> Scene:
    """Return the scene sampled at its own instants and at those of all longer steps."""
    times = {*scene.times.tolist(), *(time for each in longer.values() for time in each.times.tolist())}
    return replace(scene, times=frozen_array(sorted(times)))
