"""Where a ray first meets a surface of triangles."""

from typing import NamedTuple

import numpy as np

from scenarios.frames import Array

# A ray through an edge belongs to both triangles; the slack keeps rounding from letting it slip between them.
EDGE_SLACK = 1e-12


class Hit(NamedTuple):
    """distance along the unit direction [m]; index of the face; whether the ray was leaving the body there."""

    distance: float
    face: int
    from_inside: bool


def first_hit(origin: Array, direction: Array, points: Array, faces: np.ndarray) -> Hit | None:
    """Return the nearest hit of the ray with the triangles, or None.

    origin [m], (3,); direction: unit, (3,); points [m], (n, 3); faces: (m, 3), counter-clockwise from outside.
    Source: Moller & Trumbore, "Fast, minimum storage ray/triangle intersection" (1997).
    """
    corner = points[faces[:, 0]]
    edge_1 = points[faces[:, 1]] - corner
    edge_2 = points[faces[:, 2]] - corner
    slope = np.cross(direction, edge_2)
    det = np.einsum("ij,ij->i", edge_1, slope)
    with np.errstate(divide="ignore", invalid="ignore"):
        offset = origin - corner
        u = np.einsum("ij,ij->i", offset, slope) / det
        across = np.cross(offset, edge_1)
        v = across @ direction / det
        distance = np.einsum("ij,ij->i", edge_2, across) / det
        met = (det != 0) & (u >= -EDGE_SLACK) & (v >= -EDGE_SLACK) & (u + v <= 1 + EDGE_SLACK) & (distance >= 0)
    if not met.any():
        return None
    face = int(np.argmin(np.where(met, distance, np.inf)))
    return Hit(float(distance[face]), face, bool(det[face] < 0))
