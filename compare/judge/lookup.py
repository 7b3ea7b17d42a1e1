"""Whether an engine computes its answer or looks it up: its probe, compared with the reference solution.

After a run the same engine makes two short ones: from the start of the scene, and from one next to it that only
`write` sets.  An engine that computes follows the change of the start as physics does, to its own accuracy.
"""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from tumble.compare.run.flight import Probe, Trajectory
from tumble.scenarios.frames import Array, vertices
from tumble.scenarios.scene import Scene, frozen_array
from tumble.scenarios.truth import NoTruth, Truth, truth

# A change of the start moves the end by about as much.  Only where it is less than a quarter of it, or more than four
# times as much, the reference solution, which takes a while, is computed.
FOLLOWS = 4.0
# An error from the other start this many times the largest at the scene's samples is no chance.
WORSE = 100.0


def looked_up(scene: Scene, flight: Trajectory, true: Truth) -> str:
    """Return a line if an engine answers for the scene's start whatever start it was given, else ''."""
    probe = flight.probe
    # A state that was clamped or reset is a finding already, and follows no change as physics does.
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
    from_own, from_other = (apart(scene, one, end) for one, end in zip(probe.ends, ends, strict=True))
    # Wrong: it did not follow the change, and is less accurate with it; or it is worse than at any of the samples.
    wrong = ((moved < due / FOLLOWS) & (from_other > 2 * from_own)) | (from_other > WORSE * own + due / 2)
    if not wrong.any():
        return ""
    part = int(np.argmax(np.where(wrong, from_other, 0.0)))
    return (
        f"looked up: error {from_other[part]:.2g} m after {probe.time:.3g} s from a start that is not in the scene, "
        f"at most {own[part]:.2g} m at the scene's samples"
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
