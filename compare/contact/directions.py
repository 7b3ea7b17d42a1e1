"""How far a body slides in every direction, and which friction law that is.

Coulomb's friction stops it after the same distance in each.  The contact point of a ball that slips goes on like a box
under 7/2 of the friction, until the ball rolls.  A pyramid in place of the cone does not brake alike in all directions,
and its two kinds are wrong the opposite way (f: friction over mu N, along the edges' axes):

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
DISTANCE, ROLLS = "distance until it stops", "distance until it begins to roll"
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

    A body that slides on a level plane from the start: a ball, or a box on a face that does not turn, and cannot tip in
    any direction.
    """
    assert scene.plane is not None
    name = slid(scene)
    if name not in whole.asked or scene.impulses or len(scene.start) > 1:
        return False
    pull, start, normal = gravity(scene), scene.start[0], scene.plane.normal
    level = np.linalg.norm(pull + np.linalg.norm(pull) * normal) <= 1e-12 * np.linalg.norm(pull)
    _, one = whole.asked[name]
    if not level or one.begins_s > 0:
        return False
    return scene.body.radius is not None or (not start[10:13].any() and scene.plane.friction < reaches_edge(scene))


def slid(scene: Scene) -> str:
    """Return the observable that a rose is about."""
    return DISTANCE if scene.body.radius is None else ROLLS


def true_slide(scene: Scene, whole: WholeRun) -> float:
    """Return how far the body truly slides in every direction, of a ball its contact point [m]."""
    if scene.body.radius is None:
        return whole.asked[slid(scene)][0].true
    assert scene.plane is not None
    slip = np.linalg.norm(first_slip(scene))
    return float(slip**2 / (2 * slip_factor(scene) * scene.plane.friction * np.linalg.norm(gravity(scene))))


def slip_factor(scene: Scene) -> float:
    """Return the acceleration of the contact point by friction over that of the centre: 7/2 of a solid ball."""
    body = scene.body
    return 1.0 if body.radius is None else float(1 + body.mass * body.radius**2 / np.mean(body.moments))


def first_slip(scene: Scene) -> Array:
    """Return the velocity of the contact point at the start, along the plane [m/s], (3,)."""
    assert scene.plane is not None
    v, w, normal = scene.start[0, 7:10], scene.start[0, 10:13], scene.plane.normal
    slip: Array = v - (scene.body.radius or 0.0) * np.cross(w, normal)
    return slip - (slip @ normal) * normal


def reaches_edge(scene: Scene) -> float:
    """Return the tangent of the tilt at which the body tips over the nearest edge of its face; 0 if it lies on none."""
    from tumble.scenarios.frames import vertices

    assert scene.plane is not None
    points, centre = vertices(scene.start[:1], scene.body.points)[0], scene.start[0, 0:3]
    heights = (points - scene.plane.point) @ scene.plane.normal
    face = points[heights <= heights.min() + 1e-9 * scene.body.reach]
    if len(face) < 3:
        return 0.0
    flat = (face - centre) @ np.stack(plane_axes(scene.plane.normal), axis=1)
    disc = scene.body.disc
    nearest = edge_distance(flat) if disc is None else disc.radius
    return nearest / float((centre - scene.plane.point) @ scene.plane.normal)


def edge_distance(points: Array) -> float:
    """Return how far the origin is from the nearest edge of the convex hull of points, (n, 2); less than 0 outside.

    Every line through two points that has no point beyond it is an edge's: scipy's hull would take 0.4 s to load.
    """
    along = points - points[:, None]
    lengths = np.linalg.norm(along, axis=2)
    first, second = np.nonzero(lengths > 0)
    normals = np.stack((along[..., 1], -along[..., 0]), axis=2)[first, second] / lengths[first, second, None]
    offsets = np.einsum("ki,ki->k", normals, points[first])
    beyond = normals @ points.T - offsets[:, None]
    is_edge = beyond.max(axis=1) <= 1e-12 * lengths.max()
    return float(offsets[is_edge].min())


def turned_scene(scene: Scene, whole: WholeRun, dt: float, count: int = DIRECTIONS) -> tuple[Array, Scene]:
    """Return directions [rad], (count,), and the scene with one throw for each, whose first slip is along it."""
    assert scene.plane is not None
    directions, normal = 2 * np.pi * np.arange(count) / count, scene.plane.normal
    first, second = plane_axes(normal)
    slip = first_slip(scene)
    by = directions - math.atan2(slip @ second, slip @ first)
    start = np.repeat(scene.start, count, axis=0)
    for columns in (slice(7, 10), slice(10, 13)):
        own = scene.start[0, columns]
        along = (own @ normal) * normal
        start[:, columns] = along + np.outer(np.cos(by), own - along) + np.outer(np.sin(by), np.cross(normal, own))
    return directions, replace(whole.scenes[dt], start=start, written=None)


def read_slides(whole: WholeRun, directions: Array, scene: Scene, run: Trajectory) -> Iterator[Slide]:
    """Yield how far each throw went, of a ball its contact point."""
    _, one = whole.asked[slid(scene)]
    for throw, direction in enumerate(directions.tolist()):
        seen = Watched(scene, run, throw)
        stop = slip_end(one, seen)
        if stop is None:
            yield Slide(direction, math.nan, math.nan)
        elif scene.body.radius is not None:
            slip, rows = seen.slip[: stop.last + 1], seen.times[: stop.last + 1]
            way = np.trapezoid(slip, rows, axis=0) + slip[-1] * (stop.time - rows[-1]) / 2
            turn = math.atan2(np.cross(slip[0], way) @ seen.plane.normal, slip[0] @ way)
            yield Slide(direction, float(np.linalg.norm(way)), turn)
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
