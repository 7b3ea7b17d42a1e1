"""What a free body keeps: energy, momentum, angular momentum."""

import numpy as np

from tumble.scenarios.frames import Array, rotation_matrix
from tumble.scenarios.scene import Body


def kinetic_energy(states: Array, body: Body) -> Array:
    """Return m v.v / 2 + w.I w / 2 [J], (...); states (..., 13)."""
    return 0.5 * body.mass * (states[..., 7:10] ** 2).sum(-1) + spin_energy(states, body)


def spin_energy(states: Array, body: Body) -> Array:
    """Return w.I w / 2 [J], (...); states (..., 13)."""
    return 0.5 * (in_body_axes(states, states[..., 10:13]) ** 2 @ body.moments)


def energy(states: Array, body: Body, gravity: Array | None) -> Array:
    """Return kinetic energy and, with gravity [m/s2], its potential -m g.x [J], (...)."""
    kinetic = kinetic_energy(states, body)
    return kinetic if gravity is None else kinetic - body.mass * (states[..., 0:3] @ gravity)


def momentum(states: Array, body: Body) -> Array:
    """Return m v [kg m/s], (..., 3)."""
    return body.mass * states[..., 7:10]


def angular_momentum(states: Array, body: Body) -> Array:
    """Return R I R^T w about the centre of mass [kg m2/s], world axes, (..., 3)."""
    axes = rotation_matrix(states[..., 3:7])
    return np.einsum("...ij,...j->...i", axes, body.moments * in_body_axes(states, states[..., 10:13]))


def in_body_axes(states: Array, vectors_world: Array) -> Array:
    """Return world vectors in body axes, (..., 3)."""
    return np.einsum("...ji,...j->...i", rotation_matrix(states[..., 3:7]), vectors_world)


def drift(values: Array, true_values: Array, scale: float) -> float:
    """Return the largest distance of values from the true ones, over scale where that is not 0.

    values, true_values: (R, N) or (R, N, 3).  A scalar's drift keeps its sign: energy gained is positive.
    """
    apart = values - true_values
    unit = scale or 1.0
    if apart.ndim == 3:
        return float(np.linalg.norm(apart, axis=-1).max()) / unit
    return float(apart.flat[np.argmax(abs(apart))]) / unit
