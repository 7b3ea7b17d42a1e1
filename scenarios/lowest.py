"""How low a body reaches along a direction: what of it meets a plane first."""

import numpy as np

from tumble.scenarios.frames import Array, rotation_matrix
from tumble.scenarios.scene import Body

# The sine of a disc's tilt below which it lies flat, and has no lowest point.
FLAT = 1e-9


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


def lowest_point(body: Body, q: Array, normal: Array) -> Array:
    """Return where the body's lowest point is from its centre of mass.

    Parameters
    ----------
    body
    q : (N, 4)
        quaternions, body to world
    normal : (3,)
        unit vector, world axes

    Returns
    -------
    places : (N, 3), m
        world axes; of a disc that lies flat, the middle of its face
    """
    if body.radius is not None:
        return np.tile(-body.radius * normal, (len(q), 1))
    axes = rotation_matrix(q)
    if body.disc is None:
        levers = np.einsum("nij,pj->npi", axes, body.points)
        lowest: Array = levers[np.arange(len(q)), (levers @ normal).argmin(axis=1)]
        return lowest
    along = axes[:, :, 2]
    cosine = (along @ normal)[:, None]
    down = along * cosine - normal
    size = np.linalg.norm(down, axis=1, keepdims=True)
    out = np.divide(down, size, out=np.zeros_like(down), where=size > FLAT)
    return body.disc.radius * out - body.disc.thickness / 2 * np.sign(cosine) * along
