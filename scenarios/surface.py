"""A closed surface of triangles, read from a mesh file."""

import io
import re
from pathlib import Path

import numpy as np

from tumble.scenarios.files import plain_bytes, why_unread
from tumble.scenarios.frames import Array

MESH_FORMATS = ("stl", "ply", "off")
# One triangle of a binary STL file.
FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


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
    try:
        corners = _stl(data) if kind == "stl" else _other(data, kind)
    except Exception:  # whatever a parser trips over in a file of anyone's
        raise ValueError("must be a mesh that can be read") from None
    # A triangle with two corners in one is an edge: it bounds nothing.
    corners = corners[(corners != np.roll(corners, 1, axis=1)).any(axis=2).all(axis=1)]
    if not len(corners):
        raise ValueError("must have triangles, and none were found")
    if not np.isfinite(corners).all():
        raise ValueError("must have finite coordinates")
    points, faces = _joined(corners)
    starts, ends = faces, np.roll(faces, -1, axis=1)
    edges = np.minimum(starts, ends) * len(points) + np.maximum(starts, ends)
    if (np.unique(edges, return_counts=True)[1] != 2).any():
        raise ValueError("must be closed: every edge in exactly two triangles")
    # Two neighbours run along their edge in opposite directions.
    if (np.unique(starts * len(points) + ends, return_counts=True)[1] != 1).any():
        raise ValueError("must have all its triangles turn the same way")
    return points, faces


def _joined(corners: Array) -> tuple[Array, np.ndarray]:
    """Return the points of triangles (m, 3, 3), (n, 3), in the order in which they first appear, and faces, (m, 3)."""
    rows = corners.reshape(-1, 3)
    # One sort of numbers is many times faster than one of rows, and tells of nearly all points which are the same.
    keys = rows[:, 0] / np.e + rows[:, 1] / np.pi + rows[:, 2] / 4
    order, differs = _sorted(rows, np.argsort(keys))
    if (differs & (keys[order[1:]] == keys[order[:-1]])).any():
        order, differs = _sorted(rows, np.lexsort(rows.T))
    opens = np.append(True, differs)
    first = np.minimum.reduceat(order, np.flatnonzero(opens))
    appearing = np.sort(first)
    number, index = np.empty((2, len(rows)), dtype=int)
    number[appearing] = np.arange(len(appearing))
    index[order] = number[first][np.cumsum(opens) - 1]
    return rows.take(appearing, axis=0), index.reshape(-1, 3)


def _sorted(rows: Array, order: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the order and which of the rows, (k, 3), differs in it from the one before, (k - 1,)."""
    ordered = rows.take(order, axis=0)
    return order, (ordered[1:] != ordered[:-1]).any(axis=1)


def _stl(data: bytes) -> Array:
    """Return the triangles of an STL file, binary or text, (m, 3, 3).  Raises ValueError where it cannot be read.

    Source: the StereoLithography Interface Specification, 3D Systems (1988): 80 bytes of anything, a count, and then
    normal, corners and two bytes for each triangle; or, in words, three lines of `vertex x y z` for each.
    """
    if len(data) == 84 + FACET.itemsize * int.from_bytes(data[80:84], "little"):
        return np.frombuffer(data, FACET, offset=84)["corners"].astype(float)
    corners = re.findall(rb"(?mi)^[ \t]*+vertex[ \t]++(\S++[ \t]++\S++[ \t]++\S++)[ \t\r]*+$", data)
    return np.fromstring(b" ".join(corners), sep=" ").reshape(len(corners), 3).reshape(-1, 3, 3)


def _other(data: bytes, kind: str) -> Array:
    """Return the triangles of a file in another format, (m, 3, 3).  Raises whatever its parser does."""
    import trimesh  # slow to import

    # From bytes, so that a mesh cannot make its reader open further files.
    read = trimesh.load_mesh(io.BytesIO(data), file_type=kind, process=False)
    return np.asarray(read.vertices, dtype=float)[read.faces]
