"""What a body hits that the scene has not got, by how its velocity jumps: when, along which normal, at what height."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from tumble.compare.grade.measure.errors import Kept, Measured
from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Scene

# A jump of the velocity is so many times as large as velocities change from row to row otherwise.
JUMP, MOST_JUMPS = 30.0, 3
# A normal this near to an axis is the axis; heights this near, of the body's size, are of one floor.
ALONG, LEVEL = 0.95, 0.05
# Rows whose velocities are needed before and after a jump.
FEWEST = 8


class Hit(NamedTuple):
    """When the velocity jumps [s], by what [m/s], (3,), along which unit vector, how high its last vertex was [m]."""

    time: float
    jump: Array
    normal: Array
    height_m: float


def hits(kept: Kept, measured: Measured, scene: Scene) -> Iterator[str]:
    """Yield where the velocity of the vertices' middle jumps and no impulse acts; rows as they are in the file only."""
    if len(kept) < measured.rows / measured.throws or len(kept) < FEWEST:
        return
    found = list(_found(kept, measured, scene))
    level = LEVEL * float(np.ptp(scene.body.points, axis=0).max())
    same = [hit for hit in found if _is_of_one_floor(hit, found[0], level)]
    if len(same) > 1:
        height = float(np.median([hit.height_m for hit in same]))
        yield (
            f"It hits something that the scene has not got: a floor with the normal {_vector(same[0].normal)}, "
            f"{height:.3g} m along it from the origin, first at t = {same[0].time:.4g} s, {len(same)} times in all."
        )
        found = [hit for hit in found if hit not in same]
    for hit in found[:MOST_JUMPS]:
        yield (
            f"At t = {hit.time:.4g} s its velocity jumps by {np.linalg.norm(hit.jump):.3g} m/s along "
            f"{_vector(hit.normal)}, and the scene has nothing there: an impulse at another time, or something that it "
            f"hits with what is then {hit.height_m:.3g} m along that from the origin."
        )


def _found(kept: Kept, measured: Measured, scene: Scene) -> Iterator[Hit]:
    """Yield jumps, neighbours as one: what happens between two rows changes two differences."""
    steps = np.diff(kept.times)
    v = np.diff(kept.vertices.mean(axis=1) - kept.true.mean(axis=1), axis=0) / steps[:, None]
    change = np.linalg.norm(np.diff(v, axis=0), axis=1)
    usual = float(np.median(change)) + 4 * measured.half_m / float(np.median(steps))
    rows = np.flatnonzero(change > JUMP * usual)
    for group in np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1):
        if not len(group):
            continue
        before, after = int(group[0]), min(int(group[-1]) + 1, len(v) - 1)
        begin, end = kept.times[before], kept.times[after + 1]
        if not any(begin <= impulse.time <= end for impulse in scene.impulses):
            yield _hit(kept, before, after, v[after] - v[before])


def _hit(kept: Kept, before: int, after: int, jump: Array) -> Hit:
    """Return a hit between rows before + 1 and after; heights go on from both sides in straight lines, and meet."""
    normal = jump / np.linalg.norm(jump)
    axis = int(np.argmax(np.abs(normal)))
    if abs(normal[axis]) > ALONG:
        normal = np.sign(normal[axis]) * np.eye(3)[axis]
    times, heights = kept.times, kept.vertices @ normal
    last, next_ = before + 1, max(after, before + 1)
    lowest = int(np.argmin(heights[[last, next_]].min(axis=0)))
    height = heights[:, lowest]
    falls = (height[last] - height[before]) / (times[last] - times[before])
    rises = (height[next_ + 1] - height[next_]) / (times[next_ + 1] - times[next_])
    time = times[last]
    if rises - falls > 0:
        met = (height[last] - falls * times[last] - height[next_] + rises * times[next_]) / (rises - falls)
        time = float(np.clip(met, times[last], times[next_]))
    return Hit(float(time), jump, normal, float(height[last] + falls * (time - times[last])))


def _is_of_one_floor(hit: Hit, other: Hit, level: float) -> bool:
    return bool(hit.normal @ other.normal > ALONG) and abs(hit.height_m - other.height_m) < level


def _vector(values: Sequence[float] | Array) -> str:
    return "(" + ", ".join(f"{value + 0.0:.3g}" for value in values) + ")"
