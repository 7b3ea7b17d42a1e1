"""What is drawn of a body: the triangles of its surface and the edges between those that do not lie in one plane.

Of a ball, whose points are the ends of its axes, it is a mesh with the three great circles through them; of a disc its
rims, with a cross on each face.
"""

from itertools import combinations
from typing import NamedTuple, Self

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Body

FLAT = 1e-9  # the sine of the angle between two triangles that are one face
HALVINGS = 3  # of an octahedron's edges, for a ball
SIDES = 48  # of a disc's rims


class Outline(NamedTuple):
    """Triangles (m, 3) and edges (e, 2) as indices into the points drawn.

    weights (k, n): of the body's points in each point drawn; None where these are the same.
    """

    faces: np.ndarray
    edges: np.ndarray
    weights: Array | None = None

    @classmethod
    def of(cls, body: Body) -> Self:
        """Return the outline of a body."""
        if body.radius is not None:
            return cls(*ball(body))
        return cls(faces(body), edges(body)) if body.disc is None else cls(*round_disc(body))

    def points(self, points: Array) -> Array:
        """Return the points drawn of a body's points, (n, 3)."""
        return points if self.weights is None else self.weights @ points


def ball(body: Body) -> tuple[np.ndarray, np.ndarray, Array]:
    """Return triangles, great circles and weights of a ball: of an octahedron whose edges are halved."""
    ends = np.concatenate([np.eye(3), -np.eye(3)])
    triangles = np.array([(x, y, z) for x in (0, 3) for y in (1, 4) for z in (2, 5)])
    mirrored = (triangles >= 3).sum(axis=1) % 2 == 1
    triangles[mirrored] = triangles[mirrored][:, ::-1]
    for _ in range(HALVINGS):
        a, b, c = np.moveaxis(ends[triangles], 1, 0)
        corners = np.stack([a, b, c, (a + b) / 2, (b + c) / 2, (c + a) / 2], axis=1)
        halves = corners[:, [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]]].reshape(-1, 3)
        ends, at = np.unique(halves, axis=0, return_inverse=True)
        triangles = at.reshape(-1, 3)
    sides = np.unique(np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)
    circles = sides[(ends[sides] == 0).all(axis=1).any(axis=1)]
    places = body.reach * ends / np.linalg.norm(ends, axis=1, keepdims=True)
    return triangles, circles, weights_of(places, body.points)


def round_disc(body: Body) -> tuple[np.ndarray, np.ndarray, Array]:
    """Return triangles, edges and weights of a disc: two rims, their middles, and a cross on each face."""
    assert body.disc is not None
    angles = 2 * np.pi * np.arange(SIDES) / SIDES
    circle = body.disc.radius * np.column_stack((np.cos(angles), np.sin(angles)))
    rims = [np.column_stack((circle, np.full(SIDES, side * body.disc.thickness / 2))) for side in (-1, 1)]
    middles = np.array([(0.0, 0.0, side * body.disc.thickness / 2) for side in (-1, 1)])
    here, low, high = np.arange(SIDES), 2 * SIDES, 2 * SIDES + 1
    there = np.roll(here, -1)
    triangles = [
        np.column_stack((there, here, np.full(SIDES, low))),
        np.column_stack((here + SIDES, there + SIDES, np.full(SIDES, high))),
        np.column_stack((here, there, there + SIDES)),
        np.column_stack((here, there + SIDES, here + SIDES)),
    ]
    quarters = SIDES // 4 * np.arange(4)
    cross = [np.column_stack((quarters + base, np.full(4, middle))) for base, middle in ((0, low), (SIDES, high))]
    lines = np.concatenate([np.column_stack((here, there)), np.column_stack((here, there)) + SIDES, *cross])
    return np.concatenate(triangles), lines, weights_of(np.concatenate((*rims, middles)), body.points)


def weights_of(places: Array, points: Array) -> Array:
    """Return the weights, (k, n), of points, (n, 3), in each place, (k, 3): an affine map, which goes with the body."""
    with_ones = [np.column_stack([each, np.ones(len(each))]) for each in (places, points)]
    found: Array = with_ones[0] @ np.linalg.pinv(with_ones[1])
    return found


def faces(body: Body) -> np.ndarray:
    """Return the triangles drawn, (m, 3): of a body that has points only their hull, or none where they are flat."""
    if len(body.faces):
        return body.faces
    try:
        hull = ConvexHull(body.points)
    except (QhullError, ValueError):  # points in a plane, or too few
        return np.empty((0, 3), dtype=int)
    inwards = np.einsum("ij,ij->i", normals(body.points, hull.simplices), hull.equations[:, :3]) < 0
    return np.where(inwards[:, None], hull.simplices[:, ::-1], hull.simplices)


def edges(body: Body) -> np.ndarray:
    """Return the edges drawn as pairs of indices into the body's points, (e, 2)."""
    triangles = faces(body)
    if not len(triangles):
        return np.array(list(combinations(range(len(body.points)), 2)), dtype=int).reshape(-1, 2)
    turned = normals(body.points, triangles)
    beside: dict[tuple[int, int], list[int]] = {}
    for face, corners in enumerate(triangles.tolist()):
        for a, b in zip(corners, (*corners[1:], corners[0]), strict=True):
            beside.setdefault((min(a, b), max(a, b)), []).append(face)
    sharp = [
        edge
        for edge, of in beside.items()
        if len(of) != 2 or np.linalg.norm(np.cross(turned[of[0]], turned[of[1]])) > FLAT
    ]
    return np.array(sharp, dtype=int).reshape(-1, 2)


def normals(points: Array, triangles: np.ndarray) -> Array:
    """Return the unit normals of triangles, (m, 3)."""
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    found = np.cross(b - a, c - a)
    return found / np.linalg.norm(found, axis=1, keepdims=True)
