"""Where a ray first meets a surface: of triangles, a sphere's, or a disc's."""

from typing import NamedTuple

import numpy as np

from tumble.scenarios.frames import Array

# A ray through an edge belongs to both triangles; the slack keeps rounding from letting it slip between them.
# It is relative to the triangle, or to the body where a distance is meant.
SLACK = 1e-12


class Hit(NamedTuple):
    """distance along the unit direction [m]; index of the face; whether the ray was leaving the body there."""

    distance: float
    face: int
    from_inside: bool


def first_on_sphere(origin: Array, direction: Array, radius: float) -> tuple[float, bool] | None:
    """Return the distance at which a ray meets a sphere about 0 [m], and whether it starts inside it; or None.

    origin [m], (3,); direction: unit, (3,); radius [m].
    """
    # From where the ray passes the middle, as a far origin costs digits.
    nearest = -float(origin @ direction)
    beside = origin + nearest * direction
    square = radius * radius - float(beside @ beside)
    if square < 0:
        return None
    half = float(np.sqrt(square))
    first, slack_m = nearest - half, SLACK * radius
    if first >= -slack_m:
        return first, False
    return None if nearest + half < -slack_m else (nearest + half, True)


def first_on_disc(origin: Array, direction: Array, radius: float, thickness: float) -> tuple[float, bool] | None:
    """Return the distance at which a ray meets a disc about the z axis [m], and whether it starts inside it; or None.

    origin [m], (3,); direction: unit, (3,); radius, thickness [m].  The ray is inside between the later of its entries,
    into the cylinder and between the two faces, and the earlier of its exits.
    """
    # From where the ray passes the middle, as a far origin costs digits.
    nearest = -float(origin @ direction)
    beside = origin + nearest * direction
    begins, ends = -np.inf, np.inf
    square, along = float(direction[:2] @ direction[:2]), float(beside[:2] @ direction[:2])
    rest = radius * radius - float(beside[:2] @ beside[:2])
    if square > 0:
        root = along * along + square * rest
        if root < 0:
            return None
        begins, ends = (-along - np.sqrt(root)) / square, (-along + np.sqrt(root)) / square
    elif rest < 0:
        return None
    if direction[2]:
        faces = sorted((z - beside[2]) / direction[2] for z in (-thickness / 2, thickness / 2))
        begins, ends = max(begins, faces[0]), min(ends, faces[1])
    elif abs(beside[2]) > thickness / 2:
        return None
    slack_m = SLACK * radius
    if begins > ends + slack_m or nearest + ends < -slack_m:
        return None
    first = nearest + float(begins)
    return (first, False) if first >= -slack_m else (nearest + float(ends), True)


def first_hit(origin: Array, direction: Array, points: Array, faces: np.ndarray) -> Hit | None:
    """Return the nearest hit of the ray with the triangles, or None.

    origin [m], (3,); direction: unit, (3,); points [m], (n, 3); faces: (m, 3), counter-clockwise from outside.
    Where the ray meets an edge, the face that looks at it most is the one hit.
    Source: Moller & Trumbore, "Fast, minimum storage ray/triangle intersection" (1997).
    """
    corner = points[faces[:, 0]]
    edge_1 = points[faces[:, 1]] - corner
    edge_2 = points[faces[:, 2]] - corner
    # Measured from where the ray passes the body's middle, a far origin costs no digits.
    middle = points.mean(axis=0)
    nearest = (middle - origin) @ direction
    offset = origin + nearest * direction - corner
    slope = np.cross(direction, edge_2)
    det = np.einsum("ij,ij->i", edge_1, slope)
    # A triangle seen edge-on is nothing but the edges of its neighbours.
    faced = np.abs(det) > SLACK * np.linalg.norm(edge_1, axis=1) * np.linalg.norm(edge_2, axis=1)
    det_or_1 = np.where(faced, det, 1.0)
    across = np.cross(offset, edge_1)
    u = np.einsum("ij,ij->i", offset, slope) / det_or_1
    v = across @ direction / det_or_1
    distance = nearest + np.einsum("ij,ij->i", edge_2, across) / det_or_1
    slack_m = SLACK * float(np.abs(points - middle).max())
    met = faced & (u >= -SLACK) & (v >= -SLACK) & (u + v <= 1 + SLACK) & (distance >= -slack_m)
    if not met.any():
        return None
    first = met & (distance <= distance[met].min() + slack_m)
    face = int(np.argmax(np.where(first, det, -np.inf)))
    return Hit(float(distance[face]), face, bool(det[face] < 0))
