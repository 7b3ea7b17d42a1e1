"""What is drawn of a body: the triangles of its surface and the edges between those that do not lie in one plane."""

from itertools import combinations

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Body

FLAT = 1e-9  # the sine of the angle between two triangles that are one face


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
