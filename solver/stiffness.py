"""How fast the fastest motion is that forces can drive: what decides which method is cheap."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tumble.solver.body import Body
from tumble.solver.forces import Forces

Array = NDArray[np.float64]


class Rates(NamedTuple):
    """Of the stiffest mode: the frequency that its springs give it and the decay that its dampers do [1/s]."""

    frequency: float
    decay: float


def fastest(body: Body, forces: Forces) -> Rates:
    """Return the rates of the stiffest mode of M u'' + C u' + K u = 0, linearised about the body's position.

    u is the displacement of the centre of mass and the small rotation of the body. A tether is taken to pull back
    in all directions, as with a rest length of 0, and one vertex, the most mobile, to touch the floor: an upper
    bound that is reached or nearly so.

    Parameters
    ----------
    body
    forces

    Returns
    -------
    rates : 1/s
        frequency by springs, decay by dampers

    Notes
    -----
    Source: Goldstein, "Classical Mechanics" (1980), section 6-2.
    """
    springs, dampers = np.zeros((6, 6)), np.zeros((6, 6))
    if forces.drag is not None:
        linear, angular = forces.drag
        dampers += np.diag([linear or 0.0] * 3 + [angular or 0.0] * 3)
    if forces.tethers is not None:
        for tether in forces.tethers:
            springs += tether[6] * _at(tether[:3])
            dampers += tether[7] * _at(tether[:3])
    if forces.floor is not None and forces.points is not None:
        *_, stiffness, damping = forces.floor
        corner = max(forces.points, key=lambda point: _largest(body, _at(point)))
        springs += stiffness * _at(corner)
        dampers += damping * _at(corner)
    return Rates(float(np.sqrt(_largest(body, springs))), float(_largest(body, dampers)))


def _at(point: Array) -> Array:
    """Return J^T J of a point's motion J u = dx + dphi x p, (6, 6)."""
    x, y, z = point
    motion = np.hstack((np.eye(3), [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]))
    return motion.T @ motion


def _largest(body: Body, matrix: Array) -> float:
    """Return the largest eigenvalue of M^-1 times a symmetric matrix."""
    root = 1.0 / np.sqrt([body.mass] * 3 + list(body.moments))
    return max(0.0, np.linalg.eigvalsh(root[:, None] * matrix * root)[-1])
