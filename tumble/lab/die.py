"""The pips of a die, which every box has: as on the page, opposite faces add up to seven."""

import numpy as np

from tumble.compare.motion.results import BOX_FACES
from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Body

# How many pips the faces of BOX_FACES have, and where they lie: in quarters of the face's two edges.
COUNTS = (1, 6, 2, 5, 3, 4)
DIAGONAL, OTHER_DIAGONAL, MIDDLES = [(1, 1), (3, 3)], [(1, 3), (3, 1)], [(1, 2), (3, 2)]
PIPS = {
    1: [(2, 2)],
    2: DIAGONAL,
    3: [*DIAGONAL, (2, 2)],
    4: [*DIAGONAL, *OTHER_DIAGONAL],
    5: [*DIAGONAL, *OTHER_DIAGONAL, (2, 2)],
    6: [*DIAGONAL, *OTHER_DIAGONAL, *MIDDLES],
}
PIP_RADIUS = 0.075  # of the face's edges
CORNERS = 24  # of the polygon that a pip is drawn as
RAISED = 0.002  # of the body's reach, so that a pip does not flicker through its face


def pips(body: Body) -> tuple[Array, np.ndarray]:
    """Return the pips as triangles: points [m], body axes, (p, 3), and indices into them, (t, 3); none but of a box."""
    if body.size is None:
        return np.empty((0, 3)), np.empty((0, 3), dtype=int)
    points, triangles = [], []
    for face, count in zip(BOX_FACES, COUNTS, strict=True):
        corner, across, along = (body.points[face[at]] for at in (0, 1, 3))
        across, along = across - corner, along - corner
        outwards = np.cross(across, along)
        corner = corner + RAISED * body.reach * outwards / np.linalg.norm(outwards)
        for u, v in PIPS[count]:
            first = CORNERS * len(points)
            points.append(corner + polygon(u / 4, v / 4) @ np.array([across, along]))
            triangles += [(first, first + at, first + at + 1) for at in range(1, CORNERS - 1)]
    return np.concatenate(points), np.array(triangles)


def polygon(u: float, v: float) -> Array:
    """Return a pip's outline in shares of a face's two edges, counter-clockwise, (CORNERS, 2)."""
    turn = 2 * np.pi * np.arange(CORNERS) / CORNERS
    return np.array([u, v]) + PIP_RADIUS * np.stack([np.cos(turn), np.sin(turn)], axis=1)
