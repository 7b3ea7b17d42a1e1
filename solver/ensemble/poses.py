"""One throw's closed form at many instants: the lanes of `solver.ensemble.exact`, over time instead of over throws.

What of a throw does not depend on time is found once, and an instant costs a fifth of a throw.  An instant knows
nothing of the others: alone or among a million, in any lane, on any core, it gets the same bits.
"""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tumble.solver.ensemble.blocks import LANES, order_of, share_out, store_block
from tumble.solver.ensemble.exact import angles, pose, seen, throw
from tumble.solver.ensemble.frames import ordered
from tumble.solver.ensemble.lanes import lanes_kernel, times, widest_vectors
from tumble.solver.integrators.exact import exact
from tumble.solver.vectors import Vector

# An instant's additions and multiplications, a root or a quotient counted as ten.
FLOPS = 300


@lanes_kernel
def _one_by_one(
    first: int,
    last: int,
    found: NDArray[np.float64],
    spin: NDArray[np.float64],
    instants: NDArray[np.float64],
    inverse_moments: Vector,
    gyroscopic: Vector | None,
) -> None:
    rows = np.empty((1, 14))
    rows[0, 7:14] = spin
    for row in range(first, last):
        exact(rows, 1, instants[row], inverse_moments, gyroscopic)
        found[row] = rows[0, 0:7]


@lanes_kernel
def _poses(
    first: int,
    last: int,
    found: NDArray[np.float64],
    spin: NDArray[np.float64],
    instants: NDArray[np.float64],
    inverse_moments: Vector,
    gyroscopic: Vector,
) -> None:
    widest_vectors()
    axes, handedness, g = ordered(inverse_moments, gyroscopic)
    x, y, z = axes
    q, momentum = (spin[0], spin[1 + x], spin[1 + y], spin[1 + z]), (spin[4 + x], spin[4 + y], spin[4 + z])
    thrown = throw(q, momentum, inverse_moments[y], g, handedness)
    if thrown.steady or math.isnan(thrown.before_squared):
        _one_by_one(first, last, found, spin, instants, inverse_moments, gyroscopic)
        return
    order = order_of((z, y, x) if thrown.least else axes)
    # In three loops: each is short enough for the processor to be at several of its vectors at once.
    block = np.empty(8 * LANES)
    for begin in range(first, last, LANES):
        # A view, for in it no index may be below 0, which would make each look-up one of its own.
        here = instants[begin : begin + LANES]
        for i in range(LANES):
            (c, s), (steady_c, steady_s) = angles(thrown, here[i])
            block[i], block[LANES + i] = c, s
            block[6 * LANES + i], block[7 * LANES + i] = steady_c, steady_s
        for i in range(LANES):
            (e1, e2, e3), theta4, (c, s) = seen(thrown, (block[i], block[LANES + i]))
            block[i], block[LANES + i], block[2 * LANES + i] = e1, e2, e3
            block[3 * LANES + i], block[4 * LANES + i], block[5 * LANES + i] = theta4, c, s
        for i in range(LANES):
            along = (block[i], block[LANES + i], block[2 * LANES + i])
            now, steady = (block[4 * LANES + i], block[5 * LANES + i]), (block[6 * LANES + i], block[7 * LANES + i])
            (qw, qx, qy, qz), momentum = pose(thrown, steady, along, block[3 * LANES + i], now)
            block[i] = qw
            block[LANES + i], block[2 * LANES + i], block[3 * LANES + i] = times(thrown.signs, (qx, qy, qz))
            block[4 * LANES + i], block[5 * LANES + i], block[6 * LANES + i] = times(thrown.signs, momentum)
        store_block(found, order, begin, last, block)


def poses(
    spin: ArrayLike, instants: ArrayLike, inverse_moments: Vector, gyroscopic: Vector | None
) -> NDArray[np.float64]:
    """Return where one throw is at each instant: its quaternion, then L in body axes [kg m2/s], (T, 7).

    spin: the same of the throw at time 0, (7,); instants [s], (T,), in any order; the body as
    `tumble.solver.integrators` has it.
    Raises ValueError for other shapes.
    """
    spin, instants = np.ascontiguousarray(spin, dtype=float), np.asarray(instants, dtype=float)
    if spin.shape != (7,) or instants.ndim != 1:
        raise ValueError(f"spin must have the shape (7,) and instants (T,), got {spin.shape} and {instants.shape}")
    count = len(instants)
    found = np.empty((count, 7))
    # Whole blocks of instants, the last of which are of no use.
    padded = np.zeros(-(-count // LANES) * LANES)
    padded[:count] = instants
    kernel = _one_by_one if gyroscopic is None or 0.0 in gyroscopic else _poses
    share_out(kernel, count, FLOPS, found, spin, padded, inverse_moments, gyroscopic)
    return found
