"""How low a body reaches along a direction: what of it meets a plane first."""

import numpy as np

from tumble.scenarios.frames import Array, rotation_matrix
from tumble.scenarios.scene import Body


def lowest(body: Body, q: Array, normal: Array) -> Array:
    """Return how far the body's lowest point is above its centre of mass along a direction, below zero.

    Parameters
    ----------
    body
    q : (N, 4)
        quaternions, body to world
    normal : (3,)
        unit vector, world axes

    Returns
    -------
    heights : (N,), m
    """
    if body.radius is not None:
        return np.full(len(q), -body.radius)
    up = np.einsum("nji,j->ni", rotation_matrix(q), normal)
    if body.disc is not None:
        return -body.disc.radius * np.hypot(up[:, 0], up[:, 1]) - body.disc.thickness / 2 * np.abs(up[:, 2])
    heights: Array = (up @ body.points.T).min(axis=1)
    return heights
