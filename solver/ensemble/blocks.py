"""Throws dealt out: rows of an array to the lanes of a block, blocks to the cores."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from itertools import pairwise

import numba
import numpy as np
from numpy.typing import NDArray

from tumble.solver.ensemble.lanes import lane

# A block's numbers, seven to twenty times this many doubles, stay in the nearest cache; fewer lanes fill no pipeline.
LANES = 64
# Work that one thread does sooner than a second one is woken [flops].
LEAST_WORK = 20_000_000


@lane
def load_block(rows: NDArray[np.float64], first: int, last: int, block: NDArray[np.float64]) -> None:
    """Copy the rows first ... last - 1, of (N, n), into lanes: number k of lane i stands at block[k * LANES + i].

    Lanes without a row repeat the last one.
    """
    for i in range(LANES):
        row = min(first + i, last - 1)
        for k in range(rows.shape[1]):
            block[k * LANES + i] = rows[row, k]


@lane
def store_block(rows: NDArray[np.float64], first: int, last: int, block: NDArray[np.float64]) -> None:
    """Copy the lanes back into the rows they came from."""
    for i in range(min(LANES, last - first)):
        for k in range(rows.shape[1]):
            rows[first + i, k] = block[k * LANES + i]


@cache
def _threads() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(numba.config.NUMBA_NUM_THREADS)  # type: ignore[attr-defined]


def share_out(kernel: Callable[..., None], throws: int, flops: float, *arguments: object) -> None:
    """Call kernel(first, last, *arguments) for the throws first ... last - 1 of every core.

    flops: what one throw costs.  Threads of Python, which a kernel without the interpreter's lock runs beside each
    other, and not numba's own: those would compile half a second longer and spin while they wait.
    """
    blocks = -(-throws // LANES)
    cores = min(numba.config.NUMBA_NUM_THREADS, blocks)  # type: ignore[attr-defined]
    if cores < 2 or throws * flops < LEAST_WORK:
        kernel(0, throws, *arguments)
        return
    cuts = [min(blocks * core // cores * LANES, throws) for core in range(cores + 1)]
    running = [_threads().submit(kernel, *cut, *arguments) for cut in pairwise(cuts)]
    for part in running:
        part.result()
