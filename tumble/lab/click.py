"""A click: a ray from the eye, the point where it meets the body, and the impulse that it gives there."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from tumble.scenarios.frames import Array
from tumble.scenarios.impulse import RayMissed, strike_point
from tumble.scenarios.scene import Body, Impulse, Ray, frozen_array


def impulse_table(origin: Sequence[float], direction: Sequence[float], magnitude: float, time: float) -> dict[str, Any]:
    """Return the `[[impulse]]` of a click: origin [m] and direction of its ray, world; magnitude [N s]; time [s]."""
    ray = {"origin": [float(x) for x in origin], "direction": [float(x) for x in direction]}
    return {"time": time, "magnitude": magnitude, "ray": ray}


def hit_point(origin: Sequence[float], direction: Sequence[float], state: Array, body: Body) -> Array:
    """Return where a ray meets the body in a state, (13,), [m], (3,).  Raises RayMissed."""
    length = float(np.linalg.norm(direction))
    if not length > 0:
        raise RayMissed("the ray has no direction")
    unit = np.asarray(direction, dtype=float) / length
    ray = Ray(frozen_array(origin), frozen_array(unit))
    return strike_point(Impulse(0.0, frozen_array(unit), ray=ray), state, body)
