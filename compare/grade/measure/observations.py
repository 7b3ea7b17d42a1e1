"""Observations that need no search: reported first."""

from collections.abc import Iterator

import numpy as np

from tumble.compare.grade.measure.conserved import fitted_pose
from tumble.compare.grade.measure.contacts import contacts
from tumble.compare.grade.measure.errors import Measured, SampledRows
from tumble.compare.grade.measure.lateness import Lateness, lateness
from tumble.compare.grade.measure.offset import Offset
from tumble.compare.grade.read.digits import vector_text
from tumble.scenarios.frames import Array, turned_by
from tumble.scenarios.scene import Scene

# An error is visible above this many times the printed digits and single precision.
SEEN = 4.0
# A file is reported to be right up to a time only if that is at least this share of the duration.
RIGHT_FOR = 0.05
# Points nearer than this share of the body's size are the same.
SAME_POINT = 1e-3
# So many rows that are right, with the same number of wrong ones between them, are no chance.
FEWEST_BETWEEN = 4
# Row intervals that differ by more than this share are uneven.
EVEN = 0.02


def observations(
    measured: Measured, sample: SampledRows, scene: Scene, floors_m: Array, points: Array, offset: Offset | None
) -> Iterator[str]:
    """Yield one sentence for each observation.

    sample: rows that are diagnosed; floors_m: of each row's axes, (S, 3); points: the vertices in the file; offset: of
    the position in every row.
    """
    if len(sample) < 3:
        return
    yield from _clock(measured)
    off = np.linalg.norm(sample.vertices - sample.true, axis=-1).max(axis=1)
    visible_m = SEEN * np.linalg.norm(floors_m, axis=1) + measured.resolution_m
    seen = off > visible_m
    if offset is not None:
        yield from _offset(offset, points)
    late = lateness(sample.times, sample.vertices, sample.true, floors_m)
    is_early = late is not None and late.seconds < 0
    if (offset is None or not offset.body.any()) and not is_early:
        yield from _start(sample, float(visible_m[0]), points)
    yield from _still(sample, measured)
    yield from _right_until(sample, seen, scene)
    yield from _between(sample, seen, measured)
    if late is not None:
        yield _late(late)
    yield from contacts(sample, measured, scene, late.seconds + measured.spacing_s if late is not None else 0.0)


def _clock(measured: Measured) -> Iterator[str]:
    intervals = measured.intervals
    if len(intervals) < 3:
        return
    rows = intervals / measured.spacing_s
    whole = np.round(rows)
    lost = int((whole - 1).clip(min=0).sum())
    uneven = np.abs(rows - np.maximum(whole, 1)).max()
    if uneven > EVEN:
        yield f"Rows are unevenly spaced: {intervals.min():.4g} to {intervals.max():.4g} s apart."
    elif lost:
        yield f"{lost} rows are missing: most rows are {measured.spacing_s:.4g} s apart, some {intervals.max():.4g} s."


def _late(late: Lateness) -> str:
    """Return that rows are late or early, as their first interval shows."""
    if late.seconds > 0:
        return f"Rows are {late.seconds:.4g} s late: the first interval shows less motion than those after it."
    return f"Rows are {-late.seconds:.4g} s early: the first row is where the body is that much after its start."


def _offset(offset: Offset, points: Array) -> Iterator[str]:
    """Yield the constant offset of the position, and the point of the body that was logged."""
    body, world = offset
    if body.any():
        yield f"The centre of mass is off by ({vector_text(body)}) m in body axes, in every row{_of(body, points)}."
    if world.any():
        yield f"The centre of mass is off by ({vector_text(world)}) m in world axes, in every row."


def _of(offset: Array, points: Array) -> str:
    """Return which point of the body an offset is: a vertex, or the centre of a face."""
    near = SAME_POINT * float(np.ptp(points, axis=0).max())
    for number, point in enumerate(points):
        if np.linalg.norm(point - offset) < near:
            return f": vertex {number} was logged"
    for axis, name in enumerate("xyz"):
        for sign, side in ((1.0, "+"), (-1.0, "-")):
            face = points[np.isclose(sign * points[:, axis], (sign * points[:, axis]).max())]
            if len(face) > 2 and np.linalg.norm(face.mean(axis=0) - offset) < near:
                return f": the centre of the face at {side}{name} was logged"
    return ": another point of the body was logged"


def _start(sample: SampledRows, visible_m: float, points: Array) -> Iterator[str]:
    """Yield how the first row differs from the scene's start, as far as its digits show; visible_m: [m]."""
    if sample.times[0] > 0 or len(points) < 4:
        return
    (is_, should) = (fitted_pose(places[:1], points)[0] for places in (sample.vertices, sample.true))
    turned = float(np.linalg.norm(turned_by(should[3:7], is_[3:7])))
    off = is_[:3] - should[:3]
    parts = []
    if np.linalg.norm(off) > visible_m:
        parts.append(f"its position is off by ({vector_text(off)}) m")
    if turned * np.linalg.norm(points, axis=1).max() > visible_m:
        parts.append(f"it is rotated by {np.degrees(turned):.4g} degrees")
    if parts:
        yield f"The first row is not the scene's start: {' and '.join(parts)}."


def _still(sample: SampledRows, measured: Measured) -> Iterator[str]:
    moves = np.linalg.norm(np.diff(sample.vertices, axis=0), axis=-1).max(axis=1) > 2 * measured.half_m
    should = np.linalg.norm(np.diff(sample.true, axis=0), axis=-1).max(axis=1) > 2 * measured.half_m
    if not should.any() or (moves | ~should).all():
        return
    if not moves.any():
        yield "The body never moves."
    elif not moves[1:].any():
        yield f"The body does not move after t = {sample.times[1]:.4g} s, the second row."
    elif not moves[-2:].any() and should[-2:].all():
        yield f"The body does not move after t = {sample.times[int(np.flatnonzero(moves)[-1]) + 1]:.4g} s."


def _between(sample: SampledRows, seen: Array, measured: Measured) -> Iterator[str]:
    rows = np.round((sample.times - sample.times[0]) / measured.spacing_s).astype(int)
    right = np.delete(rows, np.flatnonzero(seen))
    if len(right) < FEWEST_BETWEEN:
        return
    apart = int(np.gcd.reduce(right))
    if apart > 1 and not seen[rows % apart == 0].any():
        yield f"One row in {apart} is right, and none of those between: they may be interpolated."


def _right_until(sample: SampledRows, seen: Array, scene: Scene) -> Iterator[str]:
    first = int(np.argmax(seen))
    if not seen.any() or first < 2 or sample.times[first - 1] < RIGHT_FOR * sample.times[-1]:
        return
    before, after = sample.times[first - 1], sample.times[first]
    acts = [n for n, impulse in enumerate(scene.impulses, 1) if before - 1e-9 <= impulse.time < after]
    when = f", when impulse {acts[0]} acts" if acts else ""
    yield f"The file is right until t = {before:.4g} s{when}."
