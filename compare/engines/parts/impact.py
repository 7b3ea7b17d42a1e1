"""How long and how fast an impact of a scene is, for engines whose contact is a spring and a damper."""

import math
from functools import cache
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


@cache
def damping_ratio(restitution: float) -> float:
    """Return the damping ratio of a spring and damper, which only push, with that restitution, above 0."""
    low, high = 0.0, 1.0
    while rebound(high) > restitution:
        low, high = high, 2.0 * high
    for _ in range(100):
        middle = (low + high) / 2
        low, high = (middle, high) if rebound(middle) > restitution else (low, middle)
    return low


def rebound(ratio: float) -> float:
    """Return the restitution of a spring and damper, which only push, by the damping ratio."""
    if ratio < 1:
        return math.exp(-2 * ratio * math.acos(ratio) / math.sqrt(1 - ratio * ratio))
    return math.exp(-2 * ratio * math.acosh(ratio) / math.sqrt(ratio * ratio - 1)) if ratio > 1 else math.exp(-2)


def of_steps(rate: float, ratio: float, dt: float) -> tuple[float, float]:
    """Return stiffness and damping by which semi-implicit steps of dt [s] make the oscillation of that rate and ratio.

    Of v' = v - (k x + b v) dt, x' = x + v' dt two steps are as z^2 - (2 - b dt - k dt^2) z + (1 - b dt) = 0 has it.
    """
    shrinks = math.exp(-ratio * rate * dt)
    angle = rate * dt * math.sqrt(abs(1.0 - ratio * ratio))
    damping = (1.0 - shrinks * shrinks) / dt
    turned = math.cos(angle) if ratio < 1 else math.cosh(angle)
    return (1.0 + shrinks * shrinks - 2.0 * shrinks * turned) / (dt * dt), damping
