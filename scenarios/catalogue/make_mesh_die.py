"""Writes mesh_die.stl: a 16 mm die with its corners cut to different depths, so that no axis of the file is principal.

Run as `python -m tumble.scenarios.catalogue.make_mesh_die`; it gives the same bytes every time.
"""

from itertools import pairwise, product
from pathlib import Path

import numpy as np

EDGE_MM = 16
# The die sits off its file's origin, as meshes from a drawing program do.
LOW_MM = np.array([30, -12, 5])
# How much of the x, y and z edge is cut away at each corner [mm].
CUTS_MM = {
    (0, 0, 0): (10, 6, 8),
    (0, 0, 1): (1, 2, 1),
    (0, 1, 0): (2, 1, 3),
    (0, 1, 1): (1, 1, 2),
    (1, 0, 0): (2, 3, 1),
    (1, 0, 1): (3, 1, 2),
    (1, 1, 0): (1, 2, 2),
    (1, 1, 1): (5, 7, 4),
}


def triangles_mm() -> np.ndarray:
    """Return the surface [mm], (44, 3, 3), counter-clockwise from outside: eight cut corners, six octagons."""
    centre = np.full(3, EDGE_MM / 2)
    corners = [_cut_corner(np.array(corner), cuts) for corner, cuts in CUTS_MM.items()]
    outlines = corners.copy()
    for axis, side in product(range(3), (0, 1)):
        outlines.append([point for corner in corners for point in corner if point[axis] == side * EDGE_MM])
    surface = []
    for outline in outlines:
        first, *rest = _counter_clockwise(np.array(outline), centre)
        surface += [(first, *pair) for pair in pairwise(rest)]
    return np.array(surface) + LOW_MM


def _cut_corner(corner: np.ndarray, cuts: tuple[int, int, int]) -> list[np.ndarray]:
    """Return where the cut meets the corner's three edges [mm]."""
    return list(EDGE_MM * corner + np.diag(cuts * (1 - 2 * corner)))


def _counter_clockwise(outline: np.ndarray, inside: np.ndarray) -> np.ndarray:
    """Return the corners of a flat convex outline in order around it, seen from outside."""
    middle = outline.mean(axis=0)
    right = outline[0] - middle
    normal = np.cross(right, outline[1] - middle)
    normal = normal if normal @ (middle - inside) > 0 else -normal
    up = np.cross(normal / np.linalg.norm(normal), right)
    return outline[np.argsort(np.arctan2((outline - middle) @ up, (outline - middle) @ right))]


def stl(triangles: np.ndarray) -> str:
    """Return ASCII STL text: decimals, where a binary file would round every millimetre to 24 bits."""
    lines = ["solid die"]
    for corners in triangles:
        # Readers take the normal from the order of the corners; zero says so.
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += ["vertex " + " ".join(f"{mm / 1000:g}" for mm in corner) for corner in corners]
        lines += ["endloop", "endfacet"]
    return "\n".join([*lines, "endsolid die", ""])


if __name__ == "__main__":
    Path(__file__).with_name("mesh_die.stl").write_text(stl(triangles_mm()), encoding="ascii", newline="\n")
