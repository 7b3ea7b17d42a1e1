"""A constant offset of a file's centre of mass."""

from typing import NamedTuple

import numpy as np

from tumble.compare.grade.measure.conserved import fitted_pose
from tumble.compare.grade.measure.errors import SampledRows
from tumble.scenarios.frames import Array, rotation_matrix

# Largest residual, and smallest error, in floors.
LEFT, MUCH = 4.0, 20.0
# The body must rotate enough to distinguish the two offsets: the smallest singular value over the largest.
TURNED = 1e-2


class Offset(NamedTuple):
    """Offset of the centre of mass [m], (3,): in body axes, and in world axes."""

    body: Array
    world: Array


def constant_offset(sample: SampledRows, points: Array, floors_m: Array) -> Offset | None:
    """Return the constant offsets that explain the error of the centre, with the file's own attitude, or None.

    points: the vertices in the file [m], (K, 3); floors_m: of each row's axes, (S, 3).
    """
    if len(points) < 4 or len(sample) < 3:
        return None
    poses, right = fitted_pose(sample.vertices, points), fitted_pose(sample.true, points)
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
