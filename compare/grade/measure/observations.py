"""What a trajectory shows before anything is searched: cheap to see, and said first."""

from collections.abc import Iterator

import numpy as np

from tumble.compare.grade.measure.conserved import posed
from tumble.compare.grade.measure.contacts import hits
from tumble.compare.grade.measure.errors import Kept, Measured
from tumble.compare.grade.measure.offset import Offset
from tumble.scenarios.frames import Array, turned_by
from tumble.scenarios.scene import Scene

# An error of so many times what digits and single precision leave is seen.
SEEN = 4.0
# A body that is right for less than this share of the duration is not said to be right until then.
RIGHT_FOR = 0.05
# Of the body's size: points nearer than this are one.
SAME_POINT = 1e-3
# Intervals between rows differ by less than this share of themselves, or are said to be uneven.
EVEN = 0.02


def sightings(measured: Measured, scene: Scene, floors_m: Array, points: Array, offset: Offset | None) -> Iterator[str]:
    """Yield one sentence for each thing seen.

    floors_m: of each row's axes, (S, 3); points: the vertices seen; offset: by which the centre is off in every row.
    """
    kept = measured.kept
    if len(kept) < 3:
        return
    yield from _clock(measured)
    off = np.linalg.norm(kept.vertices - kept.true, axis=-1).max(axis=1)
    seen = off > SEEN * np.linalg.norm(floors_m, axis=1) + measured.resolution_m
    if offset is not None:
        yield from _offset(offset, points)
    if offset is None or not offset.body.any():
        yield from _start(kept, seen, points)
    yield from _still(kept, measured)
    yield from _right_until(kept, seen, scene)
    yield from hits(kept, measured, scene)


def _clock(measured: Measured) -> Iterator[str]:
    intervals = measured.intervals
    if len(intervals) < 3:
        return
    rows = intervals / measured.spacing_s
    whole = np.round(rows)
    lost = int((whole - 1).clip(min=0).sum())
    uneven = np.abs(rows - np.maximum(whole, 1)).max()
    if uneven > EVEN:
        yield f"Rows are uneven: {intervals.min():.4g} to {intervals.max():.4g} s apart."
    elif lost:
        yield f"{lost} rows are missing: most are {measured.spacing_s:.4g} s apart, some {intervals.max():.4g} s."


def _offset(offset: Offset, points: Array) -> Iterator[str]:
    """Yield by which constant vector the centre is off, and which point of the body that is."""
    body, world = offset
    if body.any():
        said = _vector(body)
        yield f"What it calls the centre of mass is off by {said} m in body axes, in every row{_of(body, points)}."
    if world.any():
        yield f"Its centre is off by {_vector(world)} m in world axes, in every row."


def _of(offset: Array, points: Array) -> str:
    """Return which point of the body lies there: a vertex, or the middle of a side."""
    near = SAME_POINT * float(np.ptp(points, axis=0).max())
    for number, point in enumerate(points):
        if np.linalg.norm(point - offset) < near:
            return f": vertex {number}, a corner, was logged"
    for axis, name in enumerate("xyz"):
        for sign, side in ((1.0, "+"), (-1.0, "-")):
            face = points[np.isclose(sign * points[:, axis], (sign * points[:, axis]).max())]
            if len(face) > 2 and np.linalg.norm(face.mean(axis=0) - offset) < near:
                return f": the middle of its side at {side}{name}, a base, was logged"
    return ": another point of the body was logged"


def _vector(values: Array) -> str:
    return "(" + ", ".join(f"{value:.4g}" for value in values) + ")"


def _start(kept: Kept, seen: Array, points: Array) -> Iterator[str]:
    if kept.times[0] > 0 or not seen[0] or len(points) < 4:
        return
    (is_, should) = (posed(places[:1], points)[0] for places in (kept.vertices, kept.true))
    turned = float(np.linalg.norm(turned_by(should[3:7], is_[3:7])))
    off = is_[:3] - should[:3]
    parts = []
    if np.linalg.norm(off) > 1e-9:
        parts.append("its centre is off by (" + ", ".join(f"{value:.4g}" for value in off) + ") m")
    if turned > 1e-9:
        parts.append(f"it is turned by {np.degrees(turned):.4g} degrees")
    if parts:
        yield f"The first row is not the scene's start: {' and '.join(parts)}."


def _still(kept: Kept, measured: Measured) -> Iterator[str]:
    moves = np.linalg.norm(np.diff(kept.vertices, axis=0), axis=-1).max(axis=1) > 2 * measured.half_m
    should = np.linalg.norm(np.diff(kept.true, axis=0), axis=-1).max(axis=1) > 2 * measured.half_m
    if not should.any() or (moves | ~should).all():
        return
    if not moves.any():
        yield "It never moves."
    elif not moves[1:].any():
        yield f"It never moves after its first row: it stays where it is at t = {kept.times[1]:.4g} s."
    elif not moves[-2:].any() and should[-2:].all():
        yield f"It stands still from t = {kept.times[int(np.flatnonzero(moves)[-1]) + 1]:.4g} s on."


def _right_until(kept: Kept, seen: Array, scene: Scene) -> Iterator[str]:
    first = int(np.argmax(seen))
    if not seen.any() or first < 2 or kept.times[first - 1] < RIGHT_FOR * kept.times[-1]:
        return
    before, after = kept.times[first - 1], kept.times[first]
    acts = [n for n, impulse in enumerate(scene.impulses, 1) if before - 1e-9 <= impulse.time < after]
    when = f", when impulse {acts[0]} acts" if acts else ""
    yield f"It is right until t = {before:.4g} s{when}."
