"""A stored trajectory, 10 001 poses of the yardstick at 1 kHz: the closed form over time, against MuJoCo's Python loop.

    python tests/bench/trajectory.py

Ours is a call that returns every pose, ten of them a sample, for one is too short to time beside others; MuJoCo's is a
millisecond's step and a copy of qpos, 10 000 times.  Lower decile of interleaved rounds, by the thread's own clock; two
passes, of which the spread is printed.  `asked` is what the project set itself to reach on a Zen 5 of 120 GF/s: the
peak says what this machine is beside it.
"""

# MuJoCo's wheel has no type stubs.
# pyright: reportAttributeAccessIssue=false

import time
from collections.abc import Callable
from functools import partial

import mujoco
import numpy as np
from peak import CHAINS, flops, multiply_add

from compare.engines import mujoco as engine
from scenarios.read import read_scene
from solver.body import Body
from solver.ensemble.poses import poses

DT = 1e-3
POSES = 10_001
PASSES, ROUNDS = 2, 80
CALLS = 10
PEAK_STEPS = 30_000
ASKED_NS, ASKED_RATIO = 10.0, 150.0


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


def ours(call: Callable[[], np.ndarray]) -> None:
    """Make the calls of one sample."""
    for _ in range(CALLS):
        call()


def lower_deciles(tasks: dict[str, Callable[[], object]]) -> dict[str, float]:
    """Return what each task takes [s], all of them once a round."""
    samples = {name: [] for name in tasks}
    for _ in range(ROUNDS):
        for name, task in tasks.items():
            start = time.thread_time()
            task()
            samples[name].append(time.thread_time() - start)
    return {name: float(np.percentile(times, 10)) for name, times in samples.items()}


def main() -> None:
    """Print the figures."""
    scene = read_scene("yardstick")
    a, b, c = scene.body.moments.tolist()
    body = Body(scene.body.mass, (a, b, c))
    # The yardstick starts with body and world axes as one.
    spin = np.hstack((scene.start[0, 3:7], scene.body.moments * scene.start[0, 10:13]))
    call = partial(poses, spin, np.arange(POSES) * DT, body.inverse_moments, body.gyroscopic)
    tasks = {"ours": partial(ours, call), "mujoco": partial(stored, engine.build(scene, "euler"), scene.start)}
    for task in tasks.values():
        task()
    passes = [lower_deciles(tasks) for _ in range(PASSES)]
    own = np.array([found["ours"] for found in passes]) / CALLS / POSES * 1e9
    theirs = np.array([found["mujoco"] for found in passes]) / POSES * 1e9

    x = np.ones(CHAINS)
    multiply_add(x, 1)
    peak = flops(PEAK_STEPS) / lower_deciles({"peak": partial(multiply_add, x, PEAK_STEPS)})["peak"] / 1e9
    print(f"peak of one core: {peak:.1f} GF/s\n{'':24}{'mean':>9}{'low':>9}{'high':>9}{'asked':>9}")
    for name, figures, asked in (
        ("ours, ns a pose", own, f"{ASKED_NS:9.0f}"),
        ("MuJoCo, ns a pose", theirs, ""),
        ("ratio", theirs / own, f"{ASKED_RATIO:9.0f}"),
    ):
        print(f"{name:24}{figures.mean():9.1f}{figures.min():9.1f}{figures.max():9.1f}{asked}")


if __name__ == "__main__":
    main()
