"""Whether what a file says is the centre of mass is off by constant vectors: of place, of velocity, of acceleration."""

from typing import NamedTuple

import numpy as np

from tumble.compare.grade.measure.conserved import posed
from tumble.compare.grade.measure.errors import Kept
from tumble.scenarios.frames import Array, rotation_matrix

# Of the floor: what such vectors may leave, and how much larger than that they must be.
LEFT, MUCH = 4.0, 20.0
# What the body must turn for the two to be told apart: the least of the six singular values over the largest.
TURNED = 1e-2


class Offset(NamedTuple):
    """By what the centre is off [m], (3,): in body axes, and in world axes."""

    body: Array
    world: Array


def constant_offset(kept: Kept, points: Array, floors_m: Array) -> Offset | None:
    """Return the two vectors that leave nothing of how far the centre is off, by the file's own attitude, if any do.

    points: the vertices seen [m], (K, 3); floors_m: of each row's axes, (S, 3).
    """
    if len(points) < 4 or len(kept) < 3:
        return None
    poses, right = posed(kept.vertices, points), posed(kept.true, points)
    axes = rotation_matrix(poses[:, 3:7])
    off = (poses[:, 0:3] - right[:, 0:3]).ravel()
    floor = float(np.median(floors_m))
    if not np.isfinite(axes).all() or np.abs(off).max() < MUCH * floor:
        return None
    only_body, only_world = axes.reshape(-1, 3), np.tile(np.eye(3), (len(axes), 1))
    for matrix in (only_body, only_world, np.hstack((only_body, only_world))):
        values = np.linalg.svd(matrix, compute_uv=False)
        found = np.asarray(np.linalg.lstsq(matrix, off, rcond=None)[0], dtype=np.float64)
        if values[-1] > TURNED * values[0] and np.sqrt(np.mean((matrix @ found - off) ** 2)) < LEFT * floor:
            nothing = np.zeros(3)
            if matrix is only_body:
                return Offset(found, nothing)
            return Offset(nothing, found) if matrix is only_world else Offset(found[:3], found[3:])
    return None


class Drift(NamedTuple):
    """By what the velocity at the start is off [m/s], (3,), and the acceleration all the time [m/s2], (3,)."""

    velocity: Array
    acceleration: Array


def constant_drift(kept: Kept, points: Array, floors_m: Array) -> Drift | None:
    """Return the velocity or the acceleration, or both, that leave nothing of how far the centre is off, if any do.

    points: the vertices seen [m], (K, 3); floors_m: of each row's axes, (S, 3).
    """
    if len(points) < 4 or len(kept) < 4 or kept.times[0] > 0:
        return None
    off = posed(kept.vertices, points)[:, 0:3] - posed(kept.true, points)[:, 0:3]
    floor, t = float(np.median(floors_m)), kept.times
    off = off - off[0]  # where it starts is another matter
    if np.abs(off).max() < MUCH * floor:
        return None
    nothing = np.zeros(3)
    for columns in ((t,), (t * t / 2,), (t, t * t / 2)):
        matrix = np.stack(columns, axis=1)
        found = np.asarray(np.linalg.lstsq(matrix, off, rcond=None)[0], dtype=np.float64)
        if np.sqrt(np.mean((matrix @ found - off) ** 2)) < LEFT * floor:
            if len(columns) == 2:
                return Drift(found[0], found[1])
            return Drift(found[0], nothing) if columns[0] is t else Drift(nothing, found[0])
    return None
