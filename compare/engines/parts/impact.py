"""How long and how fast an impact of a scene is, for engines whose contact is a spring and a damper."""

import math
from typing import TYPE_CHECKING

import numpy as np

from tumble.compare.engines.parts.turn import turned

if TYPE_CHECKING:
    from tumble.scenarios.scene import Scene


# Steps that an impact on a spring lasts at least.
LEAST_STEPS = 10


def impact_duration(scene: "Scene", dt: float) -> float:
    """Return how long an impact on a spring is to last with steps of dt [s].

    It is the root of dt and the time in which the body falls half its reach, or without gravity moves that far: the
    motion meanwhile and the error of its steps are then alike, and both vanish with dt.
    """
    if scene.gravity is not None:
        pace = math.sqrt(scene.body.reach / math.hypot(*scene.gravity))
    else:
        fastest = float(np.linalg.norm(scene.start[:, 7:10], axis=1).max())
        pace = scene.body.reach / fastest if fastest else 1.0
    return max(LEAST_STEPS * dt, math.sqrt(pace * dt))


def approach_speed(scene: "Scene") -> float:
    """Return the normal speed with which the first throw's centre comes to the plane in free flight [m/s]."""
    plane, state = scene.plane, scene.start[:1]
    assert plane is not None
    points = state[:, 0:3] + turned(scene.body.points, np.repeat(state[:, 3:7], len(scene.body.points), axis=0))
    height = float(((points - plane.point) @ plane.normal).min())
    falls = -float(state[0, 7:10] @ plane.normal)
    pressing = 0.0 if scene.gravity is None else -float(scene.gravity @ plane.normal)
    return math.sqrt(max(0.0, falls * abs(falls) + 2 * pressing * max(height, 0.0)))
