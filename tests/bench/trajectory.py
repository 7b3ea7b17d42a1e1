"""A stored trajectory, 10 001 poses of the yardstick at 1 kHz: the closed form over time, against MuJoCo's Python loop.

    python tests/bench/trajectory.py [-o FILE.csv]

Ours is a call that returns every pose, ten of them a sample, for one is too short to time beside others; MuJoCo's is a
millisecond's step and a copy of qpos, 10 000 times.  A call for the pose at one instant is almost all Python.  Lower
decile of interleaved rounds, by the thread's own clock.  `asked` is what the project set itself to reach on a Zen 5 of
120 GF/s: the peak says what this machine is beside it.
"""

# MuJoCo's wheel has no type stubs.
# pyright: reportAttributeAccessIssue=false

from collections.abc import Callable
from functools import partial

import mujoco
import numpy as np
from figures import figure, lower_deciles, output_option, show, thread_clock
from peak import CHAINS, flops, multiply_add

from tumble.compare.engines import mujoco as engine
from tumble.scenarios.read import read_scene
from tumble.solver.body import Body
from tumble.solver.ensemble.poses import poses

DT = 1e-3
POSES = 10_001
PASSES, ROUNDS = 3, 50
CALLS, SINGLE_CALLS = 10, 1000
PEAK_STEPS = 30_000


def stored(world: engine.World, start: np.ndarray) -> np.ndarray:
    """Fly MuJoCo from the start, a step a millisecond, and return every qpos, (POSES, 7)."""
    engine.write(world, start)
    model, data = world.model, world.data
    model.opt.timestep = DT
    found = np.empty((POSES, 7))
    found[0] = data.qpos
    for row in range(1, POSES):
        mujoco.mj_step(model, data)
        found[row] = data.qpos
    return found


def ours(call: Callable[[], np.ndarray], calls: int) -> None:
    """Make the calls of one sample."""
    for _ in range(calls):
        call()


def main() -> None:
    """Measure, print and write."""
    output = output_option(__doc__.splitlines()[0])
    scene = read_scene("yardstick")
    a, b, c = scene.body.moments.tolist()
    body = Body(scene.body.mass, (a, b, c))
    # The yardstick starts with body and world axes as one.
    spin = np.hstack((scene.start[0, 3:7], scene.body.moments * scene.start[0, 10:13]))
    call = partial(poses, spin, np.arange(POSES) * DT, body.inverse_moments, body.gyroscopic)
    single = partial(poses, spin, np.array([POSES * DT]), body.inverse_moments, body.gyroscopic)
    x = np.ones(CHAINS)
    multiply_add(x, 1)
    calls = {
        "ours": partial(ours, call, CALLS),
        "single": partial(ours, single, SINGLE_CALLS),
        "mujoco": partial(stored, engine.build(scene, "euler"), scene.start),
        "peak": partial(multiply_add, x, PEAK_STEPS),
    }
    for task in calls.values():
        task()
    passes = [
        lower_deciles({name: (task, thread_clock) for name, task in calls.items()}, ROUNDS) for _ in range(PASSES)
    ]
    own = np.array([found["ours"] for found in passes]) / CALLS / POSES * 1e9
    alone = np.array([found["single"] for found in passes]) / SINGLE_CALLS * 1e9
    theirs = np.array([found["mujoco"] for found in passes]) / POSES * 1e9
    peak = flops(PEAK_STEPS) / np.array([found["peak"] for found in passes]) / 1e9
    rows = [
        figure("peak of one core", "", "GF/s", None, peak),
        figure("stored trajectory, a pose", "", "ns", 6, own),
        figure("the pose at one instant, a call", "", "ns", 2000, alone),
        figure("MuJoCo's Python loop, a pose", "", "ns", None, theirs),
        figure("stored trajectory", "MuJoCo's Python loop", "x", 150, theirs / own),
    ]
    show(rows, output)


if __name__ == "__main__":
    main()
