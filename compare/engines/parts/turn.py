"""Vectors turned by quaternions, for engines whose angular velocities or integrators are in body axes."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def turned(vectors: Array, q: Array) -> Array:
    """Return vectors, (N, 3), turned by unit quaternions w x y z, (N, 4): v + 2 (w n + n x n) x v, n = (x, y, z)."""
    across = 2.0 * np.cross(q[:, 1:4], vectors)
    return vectors + q[:, 0:1] * across + np.cross(q[:, 1:4], across)


def turned_back(vectors: Array, q: Array) -> Array:
    """Return vectors, (N, 3), turned by the inverses of unit quaternions."""
    return turned(vectors, q * (1.0, -1.0, -1.0, -1.0))
