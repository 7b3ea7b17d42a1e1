"""The rigid plane in engines that have an environment of their own: what they keep of a contact, and their laws."""

from dataclasses import replace

import numpy as np
import pytest
from apart import engine

from tumble.compare.run.flight import Trajectory
from tumble.scenarios.read import read_scene
from tumble.scenarios.scene import Impulse, Scene, frozen_array

CONTESTANTS = ["rapier:tgs"]
DT = 1 / 256  # a power of two: parts of a run have the steps of the whole, bit by bit


def looked_at(scene: Scene, *steps: int, start=None) -> Scene:
    """Return the scene with samples after so many steps of DT, and with other starts if there are any."""
    times = frozen_array(np.array(steps) * DT)
    start = scene.start if start is None else frozen_array(start)
    return replace(scene, times=times, duration=float(times[-1]), step=DT, start=start, written=None)


def states(running_engine, scene: Scene) -> np.ndarray:
    """Return the states at the samples, (R, N, 13)."""
    found = running_engine.simulate(scene, running_engine.methods[0], DT)
    assert isinstance(found, Trajectory), found
    return found.states


@pytest.mark.parametrize("contestant", CONTESTANTS)
def test_a_contact_leaves_no_trace_in_parts_of_a_run_after_a_write_or_in_another_throw(contestant):
    """A box that slides, after it fell on its edge: contacts of every kind, bit by bit."""
    scene = read_scene("box-slide-22")
    tilted = scene.start[0].copy()
    tilted[1] += 0.15
    tilted[3:7] = (np.cos(0.2), 0.0, 0.0, np.sin(0.2))
    thrown = np.array([scene.start[0], tilted])
    nothing = (Impulse(20 * DT, frozen_array((0.0, 0.0, 0.0)), point_body=frozen_array((0.0, 0.0, 0.0))),)
    with engine(*contestant.split(":")) as ours:
        whole = states(ours, looked_at(scene, 60, start=thrown))
        parts = states(ours, looked_at(scene, 1, 20, 27, 60, start=thrown))
        assert (parts[-1] == whole[-1]).all(), "steps add up"
        for throw, start in enumerate(thrown):
            assert (states(ours, looked_at(scene, 60, start=start[None]))[-1, 0] == whole[-1, throw]).all(), "apart"
        halted = states(ours, replace(looked_at(scene, 20, 60, start=thrown), impulses=nothing))
        anew = states(ours, looked_at(scene, 40, start=halted[0 if len(halted) == 2 else 1]))
        assert (anew[-1] == halted[-1]).all(), "a write forgets"
    assert whole[-1, 0, 1] == pytest.approx(0.05, abs=2e-3), "it would not touch"
