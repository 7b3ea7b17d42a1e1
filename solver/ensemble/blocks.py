"""Throws dealt out: rows of an array to the lanes of a block, blocks to the cores."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from itertools import pairwise

import numba
import numpy as np
from numpy.typing import NDArray

from tumble.solver.ensemble.lanes import lane
from tumble.solver.four import Places, transpose_four

# A block's numbers, seven to twenty times this many doubles, stay in the nearest cache; fewer lanes fill no pipeline.
LANES = 64
# Which number each of a row's seven columns is, where it is that of its own number.
Order = tuple[int, int, int, int, int, int, int]
IN_ORDER = (0, 1, 2, 3, 4, 5, 6)
# Work that one thread does sooner than a second one is woken [flops].
LEAST_WORK = 20_000_000


@lane
def order_of(axes: tuple[int, int, int]) -> Order:
    """Return the order of q and L in body axes where lanes have them in the order of these axes."""
    x = 0 if axes[0] == 0 else 1 if axes[1] == 0 else 2
    y = 0 if axes[0] == 1 else 1 if axes[1] == 1 else 2
    z = 0 if axes[0] == 2 else 1 if axes[1] == 2 else 2
    return (0, 1 + x, 1 + y, 1 + z, 4 + x, 4 + y, 4 + z)


@lane
def load_block(
    rows: NDArray[np.float64], column: int, order: Order, first: int, last: int, block: NDArray[np.float64]
) -> None:
    """Copy seven columns of the rows first ... last - 1 into lanes: number k of lane i stands at block[k * LANES + i].

    column: the first of the seven; order: which number each becomes.  Lanes without a row repeat the last one.
    """
    # Two times four columns are seven; the one between them is copied twice.
    load_columns(rows, column, order[:4], first, last, block)
    load_columns(rows, column + 3, order[3:], first, last, block)


@lane
def store_block(rows: NDArray[np.float64], order: Order, first: int, last: int, block: NDArray[np.float64]) -> None:
    """Copy the lanes into the first seven columns of the rows first ... last - 1; order: as `load_block` has it."""
    store_columns(rows, 0, order[:4], first, last, block)
    store_columns(rows, 3, order[3:], first, last, block)


@lane
def load_columns(
    rows: NDArray[np.float64], column: int, numbers: Places, first: int, last: int, block: NDArray[np.float64]
) -> None:
    """Copy four columns of rows into lanes; numbers: those that they become."""
    width, whole = rows.shape[1], min(LANES, last - first) // 4 * 4
    for i in range(0, whole, 4):
        transpose_four(block, _lanes(numbers, i), rows, _rows(first + i, width, column))
    for i in range(whole, LANES):
        for k in range(4):
            block[numbers[k] * LANES + i] = rows[min(first + i, last - 1), column + k]


@lane
def store_columns(
    rows: NDArray[np.float64], column: int, numbers: Places, first: int, last: int, block: NDArray[np.float64]
) -> None:
    """Copy four numbers of lanes into four columns of rows."""
    width, whole = rows.shape[1], min(LANES, last - first) // 4 * 4
    for i in range(0, whole, 4):
        transpose_four(rows, _rows(first + i, width, column), block, _lanes(numbers, i))
    for i in range(whole, min(LANES, last - first)):
        for k in range(4):
            rows[first + i, column + k] = block[numbers[k] * LANES + i]


@lane
def _lanes(numbers: Places, i: int) -> Places:
    """Return where four lanes from i on have these numbers."""
    a, b, c, d = numbers
    return (a * LANES + i, b * LANES + i, c * LANES + i, d * LANES + i)


@lane
def _rows(row: int, width: int, column: int) -> Places:
    """Return where a column of four rows from one on stands in memory."""
    place = row * width + column
    return (place, place + width, place + 2 * width, place + 3 * width)


@cache
def _threads() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(numba.config.NUMBA_NUM_THREADS)  # type: ignore[attr-defined]


def share_out(kernel: Callable[..., None], throws: int, flops: float, *arguments: object) -> None:
    """Call kernel(first, last, *arguments) for the throws first ... last - 1 of every core.

    flops: what one throw costs.  Threads of Python, which a kernel without the interpreter's lock runs beside each
    other, and not numba's own: those would compile half a second longer and spin while they wait.
    """
    blocks = -(-throws // LANES)
    if throws * flops < LEAST_WORK or (cores := min(numba.config.NUMBA_NUM_THREADS, blocks)) < 2:  # type: ignore[attr-defined]
        kernel(0, throws, *arguments)
        return
    cuts = [min(blocks * core // cores * LANES, throws) for core in range(cores + 1)]
    *others, own = pairwise(cuts)
    running = [_threads().submit(kernel, *cut, *arguments) for cut in others]
    # This thread is awake already.
    kernel(*own, *arguments)
    for part in running:
        part.result()
