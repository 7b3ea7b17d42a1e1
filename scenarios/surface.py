"""A closed surface of triangles, read from a mesh file."""

import io
from pathlib import Path

import numpy as np

from scenarios.files import plain_bytes, why_unread
from scenarios.frames import Array

MESH_FORMATS = ("stl", "ply", "off")


def read_surface(path: Path) -> tuple[Array, np.ndarray]:
    """Return the closed surface in a mesh file: its points [m], (n, 3), as they first appear, and faces, (m, 3).

    Raises ValueError, whose text says what is wrong with the file.
    """
    kind = path.name.rpartition(".")[2].lower()
    if kind not in MESH_FORMATS:
        raise ValueError(f"must end in one of .{', .'.join(MESH_FORMATS)}")
    try:
        data = plain_bytes(path)
    except OSError as error:
        raise ValueError(why_unread(error)) from None
    import trimesh  # slow to import, and needed here only

    try:
        # From bytes, so that a mesh cannot make its reader open further files.
        read = trimesh.load_mesh(io.BytesIO(data), file_type=kind, process=False)
        corners = np.asarray(read.vertices, dtype=float)[read.faces]
    except Exception:  # whatever the parser trips over in a file of anyone's
        raise ValueError("must be a mesh that can be read") from None
    # A triangle with two corners in one is an edge: it bounds nothing.
    corners = corners[(corners != np.roll(corners, 1, axis=1)).any(axis=2).all(axis=1)]
    if not len(corners):
        raise ValueError("must have triangles, and none were found")
    if not np.isfinite(corners).all():
        raise ValueError("must have finite coordinates")
    points, first, index = np.unique(corners.reshape(-1, 3), axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    points, faces = points[order], np.argsort(order)[index].reshape(-1, 3)
    closed = trimesh.Trimesh(points, faces, process=False)
    if not closed.is_watertight:
        raise ValueError("must be closed: every edge in exactly two triangles")
    if not closed.is_winding_consistent:
        raise ValueError("must have all its triangles turn the same way")
    return points, faces
