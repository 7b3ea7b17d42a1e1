"""How far a body slides in every direction, and which friction law that is.

Coulomb's friction stops it after the same distance in each.  A pyramid in place of the cone does not, and its two
kinds are wrong the opposite way (f: friction over mu N, along the edges' axes):

    diamond  |f_1| + |f_2| <= 1, against the slip as much as it can: all of it along the axis of the larger component
    square   |f_1| <= 1 and |f_2| <= 1: each component is braked as if it were alone

Both follow from the greatest dissipation within the cone (Moreau's principle).
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tumble.compare.contact.watched import Watched, gravity
from tumble.compare.contact.whole_run import WholeRun, slip_end, turned
from tumble.compare.run.flight import Trajectory
from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Scene

DIRECTIONS = 16
DISTANCE = "distance until it stops"
# How the friction of each law is, for slip components of sizes (1, 0 <= c <= 1) along its axes; see `way_of`.
DIAMOND, SQUARE = "diamond", "square"
# A law must leave at most this share of what a round cone leaves unexplained.
EXPLAINS = 0.1
# Angles of a pyramid's axes that are tried, of a quarter turn.
AXES = 16


@dataclass(frozen=True)
class Slide:
    """One direction [rad], from the plane's first axis: how far the body went [m], and its path's turn [rad]."""

    direction: float
    distance: float
    turn: float


@dataclass(frozen=True)
class Rose:
    """The slides of one contestant at a step, the true distance, and what the step alone may change [m]."""

    dt_s: float
    slides: tuple[Slide, ...]
    true: float
    tolerance: float

    @property
    def ratios(self) -> Array:
        """Distances over the true one, (n,)."""
        return np.array([slide.distance for slide in self.slides]) / self.true

    @property
    def ways(self) -> Array:
        """Where the body stops, along the direction and across, over the true distance, (n, 2)."""
        turns = np.array([slide.turn for slide in self.slides])
        return self.ratios[:, None] * np.stack((np.cos(turns), np.sin(turns)), axis=1)


@dataclass(frozen=True)
class Law:
    """The pyramid that explains a rose: its kind, its axes' angle from the plane's first axis [rad], and the factor.

    factor: of the law's distance, in the direction of the rose where it is most wrong.
    """

    kind: str
    axes: float
    factor: float


def plane_axes(normal: Array) -> tuple[Array, Array]:
    """Return two axes of the plane, (3,) each: those of the world, as far as they lie in it.

    The first is the axis of the world that is nearest to the plane, and of these the first; the second follows so that
    both and the normal are right-handed.
    """
    world = np.eye(3)
    axis = world[int(np.argmin(np.round(abs(normal), 12)))]
    first: Array = axis - (axis @ normal) * normal
    first /= np.linalg.norm(first)
    second: Array = np.cross(normal, first)
    return first, second


def axis_names(normal: Array) -> tuple[str, str]:
    """Return how to name the axes of the plane: x, y or z where they are those, else by their components."""
    return tuple(axis_name(axis) for axis in plane_axes(normal))  # type: ignore[return-value]


def axis_name(axis: Array) -> str:
    """Return the name of an axis."""
    largest = int(np.argmax(abs(axis)))
    if abs(axis[largest]) > 1 - 1e-9:
        return "xyz"[largest]
    return f"({', '.join(f'{part + 0.0:.3g}' for part in axis)})"


def is_turnable(scene: Scene, whole: WholeRun) -> bool:
    """Whether the same throw in another direction is another scene with the same truth.

    A body that slides on a face of a level plane from the start, does not turn, and cannot tip in any direction.
    """
    assert scene.plane is not None
    if DISTANCE not in whole.asked or scene.impulses or len(scene.start) > 1:
        return False
    pull, start, normal = gravity(scene), scene.start[0], scene.plane.normal
    level = np.linalg.norm(pull + np.linalg.norm(pull) * normal) <= 1e-12 * np.linalg.norm(pull)
    _, one = whole.asked[DISTANCE]
    if not level or one.begins_s > 0 or start[10:13].any() or scene.body.radius is not None:
        return False
    return scene.plane.friction < reaches_edge(scene)


def reaches_edge(scene: Scene) -> float:
    """Return the tangent of the tilt at which the body tips over the nearest edge of its face; 0 if it lies on none."""
    from scipy.spatial import ConvexHull  # slow to load

    from tumble.scenarios.frames import vertices

    assert scene.plane is not None
    points, centre = vertices(scene.start[:1], scene.body.points)[0], scene.start[0, 0:3]
    heights = (points - scene.plane.point) @ scene.plane.normal
    face = points[heights <= heights.min() + 1e-9 * scene.body.reach]
    if len(face) < 3:
        return 0.0
    flat = (face - centre) @ np.stack(plane_axes(scene.plane.normal), axis=1)
    nearest = float((-ConvexHull(flat).equations[:, 2]).min())
    return nearest / float((centre - scene.plane.point) @ scene.plane.normal)


def turned_scene(scene: Scene, whole: WholeRun, dt: float, count: int = DIRECTIONS) -> tuple[Array, Scene]:
    """Return directions [rad], (count,), and the scene with one throw for each, whose first velocity is along it."""
    assert scene.plane is not None
    directions = 2 * np.pi * np.arange(count) / count
    speed = float(np.linalg.norm(scene.start[0, 7:10]))
    start = np.repeat(scene.start, count, axis=0)
    along = np.stack((np.cos(directions), np.sin(directions)), axis=1) @ np.stack(plane_axes(scene.plane.normal))
    start[:, 7:10] = speed * along
    return directions, replace(whole.scenes[dt], start=start, written=None)


def read_slides(whole: WholeRun, directions: Array, scene: Scene, run: Trajectory) -> Iterator[Slide]:
    """Yield how far each throw went."""
    _, one = whole.asked[DISTANCE]
    for throw, direction in enumerate(directions.tolist()):
        seen = Watched(scene, run, throw)
        stop = slip_end(one, seen)
        if stop is None:
            yield Slide(direction, math.nan, math.nan)
        else:
            yield Slide(direction, float(np.linalg.norm(seen.along(stop.way))), turned(seen, one.begins_s, stop))


def law_of(rose: Rose) -> Law | None:
    """Return the pyramid that explains a rose, None where a round cone does, or nothing does."""
    ways = rose.ways
    round_cone = largest(ways - mean_way(ways))
    if not np.isfinite(ways).all() or round_cone <= rose.tolerance / rose.true:
        return None
    angles = [slide.direction for slide in rose.slides]
    found = min(candidates(angles), key=lambda one: largest(ways - one[1]))
    if largest(ways - found[1]) > max(EXPLAINS * round_cone, rose.tolerance / rose.true):
        return None
    lengths = np.linalg.norm(found[1], axis=1)
    return Law(*found[0], factor=float(lengths[np.argmax(abs(lengths - 1))]))


def is_round(rose: Rose) -> bool:
    """Whether the body goes equally far in every direction, and straight."""
    return largest(rose.ways - mean_way(rose.ways)) <= rose.tolerance / rose.true


def mean_way(ways: Array) -> Array:
    """Return the way of a round cone with the mean distance, (2,): straight."""
    return np.array([ways[:, 0].mean(), 0.0])


def candidates(angles: Sequence[float]) -> Iterator[tuple[tuple[str, float], Array]]:
    """Yield pyramids, (kind, angle of the axes [rad]), and the ways that they make, (n, 2)."""
    for kind in (DIAMOND, SQUARE):
        for axes in np.pi / 2 * np.arange(AXES) / AXES:
            yield (kind, float(axes)), np.array([way_of(kind, angle - axes) for angle in angles])


def way_of(kind: str, angle: float) -> Array:
    """Return where a body stops whose first velocity has an angle to a pyramid's axis, over v^2 / (2 mu g), (2,).

    Along the first velocity and across.  In the units v = mu g = 1 the speeds along the axes are c >= s >= 0.
    """
    v = np.array([math.cos(angle), math.sin(angle)])
    sign, speed = np.sign(v), abs(v)
    swapped = speed[1] > speed[0]
    c, s = sorted(speed, reverse=True)
    if kind == SQUARE:
        gone = np.array([c * c, s * s]) / 2
    else:  # first along the larger alone, until both are s; then both at half the rate
        gone = np.array([(c * c - s * s) / 2 + s * s, s * (c - s) + s * s])
    place = 2 * sign * (gone[::-1] if swapped else gone)
    return np.array([place @ v, v[0] * place[1] - v[1] * place[0]])


def largest(ways: Array) -> float:
    """Return the largest length, vectors (n, 2)."""
    return float(np.linalg.norm(ways, axis=1).max())
