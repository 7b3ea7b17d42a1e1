"""Many throws: the lanes against the machine's peak, one thread against all, and both against the scalar kernels.

    python tests/bench/ensembles.py

Every figure is the lower decile of interleaved rounds; one thread by its own clock, all of them by the wall's.
"""

import time
from collections.abc import Callable
from functools import partial

import numba
import numpy as np
from peak import CHAINS, flops, multiply_add

from solver.body import Body
from solver.ensemble.exact import exact
from solver.ensemble.rkmk4 import FLOPS, rkmk4
from solver.integrators.exact import exact as scalar_exact
from solver.integrators.rk4 import rk4

BODY = Body(1.0, (0.58 / 12, 1.09 / 12, 1.49 / 12))
CORES = numba.config.NUMBA_NUM_THREADS
ROUNDS = 30
BODY_STEPS = 1_000_000
DT = 1e-3


def spins(throws: int, width: int) -> np.ndarray:
    """Return throws around the yardstick's, as the kernels keep them, (throws, width)."""
    w_body = np.array([0.8, 2.8, 0.7]) * (1 + 0.1 * np.random.default_rng(1).standard_normal((throws, 3)))
    rows = np.hstack((np.tile([1.0, 0.0, 0.0, 0.0], (throws, 1)), np.array(BODY.moments) * w_body))
    return np.ascontiguousarray(np.hstack((rows, rows))[:, :width])


def timed(task: Callable[[], None], cores: int) -> float:
    """Return what the task takes with that many threads [s]."""
    clock = time.thread_time if cores == 1 else time.perf_counter
    numba.config.NUMBA_NUM_THREADS = cores
    start = clock()
    task()
    return clock() - start


def task(method: Callable, throws: int, steps: int, width: int, repeats: int = 1) -> Callable[[], None]:
    """Return calls of the method, compiled already."""
    call = partial(method, spins(throws, width), steps, DT, BODY.inverse_moments, BODY.gyroscopic)
    call()

    def calls() -> None:
        for _ in range(repeats):
            call()

    return calls


def main() -> None:
    """Print the table."""
    x = np.ones(CHAINS)
    multiply_add(x, 1)
    rows = {"peak": (partial(multiply_add, x, 300_000), 1, flops(300_000))}
    for throws in (100, 1_000, 10_000, 100_000):
        steps = BODY_STEPS // throws
        call = task(rkmk4, throws, steps, 7)
        for cores in sorted({1, CORES}):
            rows[f"rkmk4 {throws} throws, {cores} threads"] = call, cores, throws * steps
    for throws in (1_000, 10_000, 1_000_000):
        repeats = max(1, 20_000 // throws)
        call = task(exact, throws, 10_000, 14, repeats)
        for cores in sorted({1, CORES}):
            rows[f"exact {throws} throws, {cores} threads"] = call, cores, throws * repeats
    rows["scalar rk4"] = task(rk4, 10, 10_000, 7), 1, 100_000
    rows["scalar exact"] = task(scalar_exact, 1_000, 10_000, 14), 1, 1_000

    samples = {name: [] for name in rows}
    for _ in range(ROUNDS):
        for name, (call, cores, _) in rows.items():
            samples[name].append(timed(call, cores))
    ns = {name: np.percentile(samples[name], (10, 50, 90)) / rows[name][2] * 1e9 for name in rows}

    peak = 1 / ns.pop("peak")[0]
    print(f"peak of one core: {peak:.1f} GF/s\n{'':36}{'ns p10':>10}{'median':>10}{'p90':>10}{'GF/s':>8}{'of peak':>9}")
    for name, (low, median, high) in ns.items():
        line = f"{name:36}{low:10.3f}{median:10.3f}{high:10.3f}"
        if name.startswith("rkmk4"):
            share = FLOPS / low / peak / rows[name][1]
            line += f"{FLOPS / low:8.1f}{share:9.1%}"
        print(line)


if __name__ == "__main__":
    main()
