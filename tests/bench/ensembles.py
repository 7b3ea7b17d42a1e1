"""Many throws: the lanes against the machine's peak, one thread against all, and both against how engines do many.

    python tests/bench/ensembles.py [-o FILE.csv]

All are times of one body's step, or of one throw, from the same rounds: one thread by its own clock, several by the
wall's.  MuJoCo does many throws in two ways of its own, and vectorised numpy is what a user would write.
"""

# MuJoCo's wheel has no type stubs.
# pyright: reportAttributeAccessIssue=false

import tracemalloc
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import mujoco.rollout
import numba
import numpy as np
from figures import Clock, FigureRow, figure, lower_deciles, output_option, show, thread_clock, wall_clock
from peak import CHAINS, flops, multiply_add

from tumble.compare.engines import mujoco as engine
from tumble.scenarios.read import read_scene
from tumble.scenarios.scene import Scene
from tumble.solver.body import Body
from tumble.solver.ensemble.exact import exact
from tumble.solver.ensemble.rkmk4 import FLOPS, WIDTH, rkmk4
from tumble.solver.flight import Flight

CORES = min(2, numba.config.NUMBA_NUM_THREADS)  # pyright: ignore[reportPrivateImportUsage]
PASSES, ROUNDS = 3, 10
DT = 1e-3
THROWS = 1_000
PEAK_STEPS = 300_000
MANY = 1_000_000


class Load(NamedTuple):
    """One call to be timed: what it does, by which clock, and how many steps of a body, or throws, it makes."""

    call: Callable[[], object]
    clock: Clock
    units: int


def ours(method: Callable, body: Body, throws: int, steps: int, width: int, cores: int, repeats: int = 1) -> Load:
    """Return calls of one of our lanes, compiled already, on spins around the yardstick's."""
    w_body = np.array([0.8, 2.8, 0.7]) * (1 + 0.1 * np.random.default_rng(1).standard_normal((throws, 3)))
    rows = np.hstack((np.tile([1.0, 0.0, 0.0, 0.0], (throws, 1)), np.array(body.moments) * w_body))
    # What a method keeps beside q and L begins as the start, or as 0.
    kept = rows if method is exact else np.zeros((throws, width - rows.shape[1]))
    spins = np.ascontiguousarray(np.hstack((rows, kept)))

    def call() -> None:
        numba.config.NUMBA_NUM_THREADS = cores  # pyright: ignore[reportPrivateImportUsage]
        for _ in range(repeats):
            method(spins, steps, DT, body.inverse_moments, body.gyroscopic)

    call()
    # An ensemble flown in one step counts throws, one that is stepped counts steps.
    units = throws * repeats * (1 if method is exact else steps)
    return Load(call, thread_clock if cores == 1 else wall_clock, units)


def rollout(scene: Scene, steps: int, cores: int) -> Load:
    """Return MuJoCo's own batch: one model, a data a thread, every step of every throw recorded."""
    world = engine.build(scene, "euler")
    world.model.opt.timestep = DT
    kind = mujoco.mjtState.mjSTATE_FULLPHYSICS
    first = np.empty(mujoco.mj_stateSize(world.model, kind))
    engine.write(world, scene.start)
    mujoco.mj_getState(world.model, world.data, first, kind)
    starts = np.tile(first, (THROWS, 1))
    datas = [mujoco.MjData(world.model) for _ in range(cores)]
    pool = mujoco.rollout.Rollout(nthread=cores)
    states = np.empty((THROWS, steps, len(first)))
    call = partial(pool.rollout, world.model, datas, starts, nstep=steps, state=states, skip_checks=False)
    call()
    return Load(call, wall_clock, THROWS * steps)


def one_model(scene: Scene, steps: int) -> Load:
    """Return MuJoCo with every throw as a body of one model, which is how our engine file does it."""
    start = np.tile(scene.start, (THROWS // 10, 1))
    world = engine.build(replace(scene, start=start), "euler")
    engine.write(world, start)
    return Load(partial(engine.advance, world, steps, DT), thread_clock, len(start) * steps)


def vectorised(body: Body, throws: int, steps: int) -> Load:
    """Return RK4 on quaternion and body momentum in whole-array numpy, (7, throws)."""
    rng = np.random.default_rng(1)
    moments = np.array(body.moments)[:, None]
    w_body = np.array([0.8, 2.8, 0.7])[:, None] * (1 + 0.1 * rng.standard_normal((3, throws)))
    state = np.vstack((np.ones((1, throws)), np.zeros((3, throws)), moments * w_body))

    def slope(y: np.ndarray) -> np.ndarray:
        w, (qw, qx, qy, qz), L = y[4:] / moments, y[:4], y[4:]
        return np.stack(
            (
                -0.5 * (qx * w[0] + qy * w[1] + qz * w[2]),
                0.5 * (qw * w[0] + qy * w[2] - qz * w[1]),
                0.5 * (qw * w[1] + qz * w[0] - qx * w[2]),
                0.5 * (qw * w[2] + qx * w[1] - qy * w[0]),
                L[1] * w[2] - L[2] * w[1],
                L[2] * w[0] - L[0] * w[2],
                L[0] * w[1] - L[1] * w[0],
            )
        )

    def call() -> None:
        y = state
        for _ in range(steps):
            k1 = slope(y)
            k2 = slope(y + DT / 2 * k1)
            k3 = slope(y + DT / 2 * k2)
            k4 = slope(y + DT * k3)
            y = y + DT / 6 * (k1 + 2 * (k2 + k3) + k4)

    return Load(call, thread_clock, throws * steps)


def bytes_a_throw(body: Body) -> float:
    """Return the most memory that a million throws hold on their way to their final states, a throw.

    Final states are included; the starts, 104 bytes a throw that the caller holds, are not.
    """
    start = np.tile(read_scene("yardstick").start, (MANY, 1))
    tracemalloc.start()
    flight = Flight(body, "exact-lanes")
    flight.write(start)
    flight.advance(1, 10.0)
    flight.read()
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return most / MANY


def main() -> None:
    """Measure, print and write."""
    output = output_option(__doc__.splitlines()[0])
    scene = read_scene("yardstick")
    a, b, c = scene.body.moments.tolist()
    body = Body(scene.body.mass, (a, b, c))
    x = np.ones(CHAINS)
    multiply_add(x, 1)
    peak = "peak"
    loads = {peak: Load(partial(multiply_add, x, PEAK_STEPS), thread_clock, flops(PEAK_STEPS))}
    for cores in sorted({1, CORES}):
        for throws in (100, 1_000, 10_000, 100_000):
            loads[f"rkmk4-lanes x{throws} /{cores}"] = ours(rkmk4, body, throws, 1_000_000 // throws, WIDTH, cores)
        for throws in (1_000, 10_000, MANY):
            repeats = max(1, 20_000 // throws)
            loads[f"exact-lanes x{throws} /{cores}"] = ours(exact, body, throws, 10_000, 14, cores, repeats)
        loads[f"mujoco.rollout /{cores}"] = rollout(scene, 5, cores)
    loads["mujoco, bodies of one model"] = one_model(scene, 20)
    loads["numpy, vectorised RK4"] = vectorised(body, 10_000, 5)

    tasks = {name: (load.call, load.clock) for name, load in loads.items()}
    passes = [lower_deciles(tasks, ROUNDS) for _ in range(PASSES)]
    ns = {name: np.array([found[name] for found in passes]) / load.units * 1e9 for name, load in loads.items()}

    peak_flops = 1 / ns.pop(peak)  # GF/s, in each pass
    rows = [figure("peak of one core", "", "GF/s", None, peak_flops)]
    rows += [figure(name, "", "ns", None, times) for name, times in ns.items()]
    one, two = f"rkmk4-lanes x{THROWS} /1", f"rkmk4-lanes x{THROWS} /{CORES}"

    def times_faster(what: str, peer: str, asked: float) -> FigureRow:
        return figure(what, peer, "x", asked, ns[peer] / ns[what])

    rows += [
        figure(one, "peak of one core", "%", 85, 100 * FLOPS / ns[one] / peak_flops),
        times_faster(two, one, 1.95),
        times_faster(two, f"mujoco.rollout /{CORES}", 900),
        times_faster(one, "mujoco, bodies of one model", 100),
        times_faster(one, "numpy, vectorised RK4", 30),
        figure(f"a million throws /{CORES}", "", "s", 0.018, ns[f"exact-lanes x{MANY} /{CORES}"] * MANY / 1e9),
        figure("memory of a throw", "", "B", 300, [bytes_a_throw(body)]),
    ]
    show(rows, output)


if __name__ == "__main__":
    main()
