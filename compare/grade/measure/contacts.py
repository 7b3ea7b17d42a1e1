"""Contacts that the scene does not have, found by jumps of the velocity: time, normal and height."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from tumble.compare.grade.measure.errors import Measured, SampledRows
from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Scene

# A jump of the velocity is this many times the usual change from row to row.
JUMP, MOST_JUMPS = 30.0, 3
# A normal with a component above this is that axis; heights within this share of the body's size are one floor.
ALONG, LEVEL = 0.95, 0.05
# Rows that are needed to find a jump.
FEWEST = 8


class Contact(NamedTuple):
    """Time of a jump [s], change of the velocity [m/s], (3,), its unit vector, and height of the lowest vertex [m]."""

    time: float
    jump: Array
    normal: Array
    height_m: float


def contacts(sample: SampledRows, measured: Measured, scene: Scene, after: float) -> Iterator[str]:
    """Yield a sentence for each jump of the vertices' mean velocity without an impulse; only if no row was left out.

    after: time up to which the velocity jumps for another reason [s].
    """
    if len(sample) < measured.rows / measured.throws or len(sample) < FEWEST:
        return
    found = [contact for contact in _found(sample, measured, scene) if contact.time > after]
    level = LEVEL * float(np.ptp(scene.body.points, axis=0).max())
    same = [contact for contact in found if _is_of_one_floor(contact, found[0], level)]
    if len(same) > 1:
        height = float(np.median([contact.height_m for contact in same]))
        yield (
            f"It hits a floor that the scene does not have: normal {_vector(same[0].normal)}, {height:.3g} m from the "
            f"origin along it, first at t = {same[0].time:.4g} s, {len(same)} times in total."
        )
        found = [contact for contact in found if contact not in same]
    for contact in found[:MOST_JUMPS]:
        yield (
            f"At t = {contact.time:.4g} s its velocity jumps by {np.linalg.norm(contact.jump):.3g} m/s along "
            f"{_vector(contact.normal)}, and the scene has nothing there. It is an impulse at the wrong time, or "
            f"a contact {contact.height_m:.3g} m from the origin along that normal."
        )


def _found(sample: SampledRows, measured: Measured, scene: Scene) -> Iterator[Contact]:
    """Yield jumps; neighbours are one, since a jump between two rows changes two differences."""
    steps = np.diff(sample.times)
    v = np.diff(sample.vertices.mean(axis=1) - sample.true.mean(axis=1), axis=0) / steps[:, None]
    change = np.linalg.norm(np.diff(v, axis=0), axis=1)
    usual = float(np.median(change)) + 4 * measured.half_m / float(np.median(steps))
    rows = np.flatnonzero(change > JUMP * usual)
    for group in np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1):
        if not len(group):
            continue
        before, after = int(group[0]), min(int(group[-1]) + 1, len(v) - 1)
        begin, end = sample.times[before], sample.times[after + 1]
        if not any(begin <= impulse.time <= end for impulse in scene.impulses):
            yield _contact(sample, before, after, v[after] - v[before])


def _contact(sample: SampledRows, before: int, after: int, jump: Array) -> Contact:
    """Return the contact between rows before + 1 and after; heights are extrapolated linearly from both sides."""
    normal = jump / np.linalg.norm(jump)
    axis = int(np.argmax(np.abs(normal)))
    if abs(normal[axis]) > ALONG:
        normal = np.sign(normal[axis]) * np.eye(3)[axis]
    times, heights = sample.times, sample.vertices @ normal
    last, next_ = before + 1, max(after, before + 1)
    lowest = int(np.argmin(heights[[last, next_]].min(axis=0)))
    height = heights[:, lowest]
    falls = (height[last] - height[before]) / (times[last] - times[before])
    rises = (height[next_ + 1] - height[next_]) / (times[next_ + 1] - times[next_])
    time = times[last]
    if rises - falls > 0:
        met = (height[last] - falls * times[last] - height[next_] + rises * times[next_]) / (rises - falls)
        time = float(np.clip(met, times[last], times[next_]))
    return Contact(float(time), jump, normal, float(height[last] + falls * (time - times[last])))


def _is_of_one_floor(contact: Contact, other: Contact, level: float) -> bool:
    return bool(contact.normal @ other.normal > ALONG) and abs(contact.height_m - other.height_m) < level


def _vector(values: Sequence[float] | Array) -> str:
    return "(" + ", ".join(f"{value + 0.0:.3g}" for value in values) + ")"
