"""The attitude of a plane, for engines that make one across an axis of its own."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def turn_onto(axis: Array, normal: Array) -> Array:
    """Return the quaternion w x y z, (4,), that turns one unit vector, (3,), onto another the shorter way."""
    across = np.cross(axis, normal)
    q = np.array((1.0 + axis @ normal, *across))
    if q[0] < 1e-9:  # they are opposite: half a turn about anything across
        other = np.eye(3)[np.argmin(np.abs(axis))]
        q = np.array((0.0, *np.cross(axis, other)))
    return q / np.linalg.norm(q)
