"""A throw's motion at the precisions that it takes, and those of changed numbers: what an answer is made from."""

from random import Random
from typing import Any, NamedTuple

import numpy as np

from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Scene
from tumble.scenarios.truth.contact.setting import Setting, read_setting
from tumble.scenarios.truth.contact.timeline import Timeline, timeline
from tumble.scenarios.truth.deadline import current
from tumble.scenarios.truth.flight import Pose
from tumble.scenarios.truth.rational import Fraction
from tumble.scenarios.truth.resolution import AGREEMENT, PATTERNS, movements
from tumble.scenarios.truth.throw import Read, changing

# Bits of the rougher motion and of the finer, and what follows where they do not agree.
PRECISIONS = (112, 144, 216, 324, 567)
# Changes of the inputs in half last bits: in doubles, beyond what they round; with all digits, as they are.
SHARE_IN_DOUBLES, SHARE = 2.0**20, 1.0
# What a smaller change of the opposite sign must do in proportion, and how unequal that may be.
OPPOSITE, PROPORTIONAL = -0.125, 0.1


class Motion(NamedTuple):
    """A throw's motion at two precisions: the finer is the answer, the rougher says how good it is."""

    setting: Setting
    finer: Timeline
    rougher: Timeline
    bits: int


def motion_of(mp: Any, scene: Scene, row: int) -> Motion:
    """Return the motion of a throw, at precisions that agree, or the last there are.  Raises RayMissed."""
    near = read_setting(_doubles(), scene, row)
    rougher: Timeline | None = None
    for bits in PRECISIONS:
        current().check()
        mp.prec = bits
        setting = read_setting(mp, scene, row)
        finer = timeline(setting, near, None if rougher is None else rougher.choices)
        if rougher is not None and finer.ended < rougher.ended:
            # The rougher motion is too rough to be followed.
            finer = timeline(setting, near)
        if rougher is not None and (bits == PRECISIONS[-1] or _agree(setting, rougher, finer)):
            return Motion(setting, finer, rougher, bits)
        rougher = finer
    raise AssertionError


def _agree(setting: Setting, rougher: Timeline, finer: Timeline) -> bool:
    """Return whether two motions agree at the last instant that is known, to a share that doubles cannot show."""
    last = min(setting.times[-1], finer.ended, rougher.ended)
    rough, fine = (motion.phases[-1].at(last) if motion.phases else setting.start for motion in (rougher, finer))
    size, spin = setting.reach, setting.mp.sqrt(fine.w_world @ fine.w_world)
    moved = max(abs(fine.x - rough.x)) <= AGREEMENT * (size + max(map(abs, fine.x)))
    turned = abs(fine.axes - rough.axes).max() <= AGREEMENT
    return bool(moved and turned and max(abs(fine.w_world - rough.w_world)) <= AGREEMENT * (1 + spin))


class Changed(NamedTuple):
    """The motion of a throw whose numbers are changed, its poses, and by what share of half their last bits."""

    setting: Setting
    timeline: Timeline
    poses: list[Pose]
    share: float


def changed_timelines(mp: Any, scene: Scene, row: int, motion: Motion) -> list[Changed]:
    """Return the motions of PATTERNS changes of each number: in doubles where those are in proportion, else as is."""
    fp = _doubles()
    try:
        plain = _changed(fp, scene, row, motion, Fraction, 0.0)
        there = _changed(fp, scene, row, motion, changing(Random(0), SHARE_IN_DOUBLES), SHARE_IN_DOUBLES)
        back = _changed(
            fp, scene, row, motion, changing(Random(0), OPPOSITE * SHARE_IN_DOUBLES), OPPOSITE * SHARE_IN_DOUBLES
        )
        if _in_proportion(motion, plain, there, back):
            rest = [
                _changed(fp, scene, row, motion, changing(Random(pattern), SHARE_IN_DOUBLES), SHARE_IN_DOUBLES)
                for pattern in range(1, PATTERNS)
            ]
            return [plain, there, *rest]
    except (ArithmeticError, ValueError):
        pass
    mp.prec = PRECISIONS[0]
    plain = _changed(mp, scene, row, motion, Fraction, 0.0)
    return [plain, *(_changed(mp, scene, row, motion, changing(Random(pattern)), SHARE) for pattern in range(PATTERNS))]


def _changed(mp: Any, scene: Scene, row: int, motion: Motion, read: Read, share: float) -> Changed:
    setting = read_setting(mp, scene, row, read)
    followed = timeline(setting, setting, motion.rougher.choices)
    return Changed(setting, followed, poses_of(setting, followed), share)


def _in_proportion(motion: Motion, plain: Changed, there: Changed, back: Changed) -> bool:
    """Return whether the changes' effects at the last known instant are a derivative."""
    first, second = (moves_of(motion, plain, changed)[-1:] for changed in (there, back))
    return bool((abs(first - second) <= PROPORTIONAL * np.maximum(first, second)).all())


def moves_of(motion: Motion, plain: Changed, changed: Changed) -> Array:
    """Return how far a vertex moves at each known instant, for half the last bits [m], (R,)."""
    points = (plain.setting.throw.points, changed.setting.throw.points)
    known = min(len(plain.poses), len(changed.poses))
    return movements(plain.poses[:known], changed.poses[:known], *points)[:, 0] / abs(changed.share)


def poses_of(setting: Setting, motion: Timeline) -> list[Pose]:
    """Return the poses at the throw's instants that are known."""
    return [motion.at(time) for time in setting.times if time < motion.ended]


def _doubles() -> Any:
    from mpmath import fp

    return fp
