"""Draws boxes: true vertex positions in, SVG out; a face is shaded by how it meets the light.

Vertices are numbered as everywhere in Tumble, itertools.product((-1, 1), repeat=3): the bits 4, 2, 1 are x, y, z.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup

from scenarios.frames import Array


@dataclass(frozen=True)
class Picture:
    """One small SVG and what stands under it."""

    caption: str
    view_box: str
    drawing: Markup


EDGES = [(vertex, vertex | bit) for vertex in range(8) for bit in (4, 2, 1) if not vertex & bit]
# The corners of each face in order round it.
FACES = [
    (side, side | first, side | first | second, side | second)
    for bit, first, second in ((4, 2, 1), (2, 1, 4), (1, 4, 2))
    for side in (0, bit)
]
# What stands on them: opposite faces of a die add up to seven.
EYES = (1, 6, 2, 5, 3, 4)
# Where the pips of 1 to 6 lie on a face that reaches from 0 to 1.
LOW, MIDDLE, HIGH = 0.25, 0.5, 0.75
DIAGONAL, OTHER_DIAGONAL = [(LOW, LOW), (HIGH, HIGH)], [(LOW, HIGH), (HIGH, LOW)]
PIPS = {
    1: [(MIDDLE, MIDDLE)],
    2: DIAGONAL,
    3: [*DIAGONAL, (MIDDLE, MIDDLE)],
    4: DIAGONAL + OTHER_DIAGONAL,
    5: [*DIAGONAL, *OTHER_DIAGONAL, (MIDDLE, MIDDLE)],
    6: [*DIAGONAL, *OTHER_DIAGONAL, (LOW, MIDDLE), (HIGH, MIDDLE)],
}
PIP_RADIUS = 0.09
PIP_CORNERS = 12


def unit(vector: Sequence[float] | Array) -> Array:
    """Return a vector's direction."""
    return np.asarray(vector, dtype=float) / np.linalg.norm(vector)


# Parallel projection, y up: rows are the picture's right, its up, and the way towards the eye.
TOWARDS_EYE = unit((0.55, 0.5, 1.0))
RIGHT = unit(np.cross((0.0, 1.0, 0.0), TOWARDS_EYE))
VIEW = np.stack((RIGHT, np.cross(TOWARDS_EYE, RIGHT), TOWARDS_EYE))
LIGHT = unit((0.3, 1.0, 0.55))
DARKEST, BRIGHTEST = 42.0, 88.0


def project(points: Array) -> Array:
    """Return points (..., 3) as the picture sees them: right, down (as SVG counts), towards the eye, (..., 3)."""
    return points @ VIEW.T * (1.0, -1.0, 1.0)


def path(points: Array, closed: bool = True) -> str:
    """Return projected points (n, 2 or 3) as the data of an SVG path."""
    return "M" + "L".join(f"{x:.4g},{y:.4g}" for x, y, *_ in points) + "Z" * closed


def box(vertices: Array, pips: bool = False) -> Markup:
    """Return a box, or what a linear map made of one, with vertices (8, 3) [m]: the faces that look towards the eye.

    A parallelepiped is convex, so these hide the others and never each other.
    """
    drawn = []
    for corners, eyes in zip(FACES, EYES, strict=True):
        face = vertices[list(corners)]
        outward = outward_normal(face, vertices.mean(axis=0))
        if outward @ TOWARDS_EYE > 0:
            seen = project(face)
            drawn.append(f'<path class="face" fill="{shade(outward)}" d="{path(seen)}"/>')
            if pips:
                drawn.append(f'<path class="pip" d="{"".join(map(path, pips_on(seen, eyes)))}"/>')
    return Markup("".join(drawn))


def outward_normal(face: Array, centre: Array) -> Array:
    """Return the unit normal of a face (4, 3) that points away from the body's centre; of no area, no direction."""
    normal = np.cross(face[2] - face[0], face[3] - face[1])
    length = np.linalg.norm(normal)
    return normal * math.copysign(1.0 / length, normal @ (face.mean(axis=0) - centre)) if length else normal


def shade(outward: Array) -> str:
    """Return the colour of a face with this outward normal."""
    lit = (1.0 + outward @ LIGHT) / 2.0
    return f"hsl(212 20% {DARKEST + (BRIGHTEST - DARKEST) * lit:.0f}%)"


def pips_on(corners: Array, eyes: int) -> list[Array]:
    """Return the pips of a projected face (4, 3) as polygons: they stretch and shear as the face does."""
    across, along = corners[1] - corners[0], corners[3] - corners[0]
    angles = np.arange(PIP_CORNERS) * (2 * math.pi / PIP_CORNERS)
    return [
        corners[0]
        + np.outer(u + PIP_RADIUS * np.cos(angles), across)
        + np.outer(v + PIP_RADIUS * np.sin(angles), along)
        for u, v in PIPS[eyes]
    ]


def dot(point: Array, kind: str, radius: float) -> Markup:
    """Return a mark at a point (3,) [m]; kind is its class in the page's style."""
    x, y, _ = project(point)
    return Markup(f'<circle class="{kind}" cx="{x:.4g}" cy="{y:.4g}" r="{radius:.3g}"/>')


def line(points: Array, kind: str) -> Markup:
    """Return a line through points (n, 3) [m]; kind is its class in the page's style."""
    return Markup(f'<path class="{kind}" d="{path(project(points), closed=False)}"/>')


def view_box(points: Array, margin: float) -> str:
    """Return the viewBox that holds points (..., 3) [m] with a margin [m] around."""
    seen = project(points).reshape(-1, 3)[:, :2]
    x, y = seen.min(axis=0) - margin
    width, height = np.ptp(seen, axis=0) + 2 * margin
    return f"{x:.4g} {y:.4g} {width:.4g} {height:.4g}"


def edge_lengths(vertices: Array) -> Array:
    """Return the twelve edges of a box with vertices (8, 3) [m], (12,)."""
    begin, end = np.transpose(EDGES)
    return np.linalg.norm(vertices[end] - vertices[begin], axis=-1)


def volume(vertices: Array) -> float:
    """Return the volume [m3] of the parallelepiped with vertices (8, 3) [m]; negative where it is turned inside out."""
    return float(np.linalg.det(vertices[[4, 2, 1]] - vertices[0]))
