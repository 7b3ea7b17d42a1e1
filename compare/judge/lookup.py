"""Whether an engine flies what it is given, or looks up what it was told of: its probe, held against the truth.

After a flight the same engine flies two short ones: from the start that the scene tells, and from one next to it that
only `write` gives.  An honest engine answers to the change as physics does, to its own accuracy.
"""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from tumble.compare.run.flight import Probe, Trajectory
from tumble.scenarios.frames import Array, vertices
from tumble.scenarios.scene import Scene, frozen_array
from tumble.scenarios.truth import NoTruth, Truth, truth

# A change moves the body by about as much as it is: by less than a quarter of it, or four times as much, is a question
# for the truth, which takes a while and is not asked without one.
FOLLOWS = 4.0
# So much less accurate from the other start than at any sample of the told one is no chance.
WORSE = 100.0


def looked_up(scene: Scene, flight: Trajectory, true: Truth) -> str:
    """Say so where an engine answers for the start it was told of, and not for the one it was given; else ''."""
    probe = flight.probe
    # What was clamped or reset is said already, and answers to no change as physics does.
    if probe is None or flight.findings or not np.isfinite(probe.ends).all():
        return ""
    own = apart(scene, flight.states[:, 0], true.states[:, 0])
    given, moved = apart(scene, *probe.starts), apart(scene, *probe.ends)
    # What the change of the velocities adds to that of the pose.
    drifted = given + probe.time * swifter(scene, probe)
    if not ((moved < given / FOLLOWS) | (moved > FOLLOWS * drifted + WORSE * own)).any():
        return ""
    try:
        ends = after(scene, probe.starts.tobytes(), probe.time)
    except NoTruth:
        return ""
    due = apart(scene, *ends)
    told, no_progress = (apart(scene, one, end) for one, end in zip(probe.ends, ends, strict=True))
    # What follows no change is wrong where it was right without it; or the answer is worse than any that was asked for.
    wrong = ((moved < due / FOLLOWS) & (no_progress > 2 * told)) | (no_progress > WORSE * own + due / 2)
    if not wrong.any():
        return ""
    part = int(np.argmax(np.where(wrong, no_progress, 0.0)))
    return (
        f"looked up: {no_progress[part]:.2g} m off after {probe.time:.3g} s from a start that it was not told of, "
        f"at the scene's samples at most {own[part]:.2g} m"
    )


def apart(scene: Scene, one: Array, other: Array) -> Array:
    """Return how far states, (..., 13), are apart at most [m], (2,): the centre of mass, and the corners about it."""
    still = np.r_[np.zeros(3), np.ones(10)]
    corners = vertices(one * still, scene.body.points) - vertices(other * still, scene.body.points)
    return np.array([np.linalg.norm(each, axis=-1).max() for each in (one[..., :3] - other[..., :3], corners)])


def swifter(scene: Scene, probe: Probe) -> Array:
    """Return by how much the change of the start moves centre of mass and corners a second [m/s], (2,)."""
    change = probe.starts[1] - probe.starts[0]
    v, w = float(np.linalg.norm(change[7:10])), float(np.linalg.norm(change[10:13]))
    return np.array((v, w * scene.body.reach))


@lru_cache(64)
def after(scene: Scene, starts: bytes, time: float) -> Array:
    """Return where two starts, the bytes of (2, 13), truly lead in that time [s], (2, 13).  Raises NoTruth."""
    start, times = frozen_array(np.frombuffer(starts).reshape(2, 13)), frozen_array([time])
    short = replace(scene, start=start, impulses=(), times=times, duration=time, written=None)
    return truth(short, with_input_error=False).states[-1]
