"""One throw's closed form at many instants: the lanes of `solver.ensemble.exact`, over time instead of over throws.

What of a throw does not depend on time is found once, and an instant costs a fifth of a throw.  An instant knows
nothing of the others: alone or among a million, in any lane, on any core, it gets the same bits.
"""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tumble.solver.ensemble.blocks import LANES, share_out
from tumble.solver.ensemble.exact import advanced, throw
from tumble.solver.ensemble.frames import ordered
from tumble.solver.ensemble.lanes import lane, lanes_kernel, widest_vectors
from tumble.solver.integrators.exact import exact
from tumble.solver.vectors import Vector

# An instant's additions and multiplications, a root or a quotient counted as ten.
FLOPS = 300


@lane
def in_body_axes(axes: tuple[int, int, int], a: Vector) -> Vector:
    """Return a vector whose components came in the order of these axes."""
    x = a[0] if axes[0] == 0 else a[1] if axes[1] == 0 else a[2]
    y = a[0] if axes[0] == 1 else a[1] if axes[1] == 1 else a[2]
    z = a[0] if axes[0] == 2 else a[1] if axes[1] == 2 else a[2]
    return (x, y, z)


@lanes_kernel
def _one_by_one(
    first: int,
    last: int,
    found: NDArray[np.float64],
    spin: NDArray[np.float64],
    times: NDArray[np.float64],
    inverse_moments: Vector,
    gyroscopic: Vector | None,
) -> None:
    rows = np.empty((1, 14))
    rows[0, 7:14] = spin
    for row in range(first, last):
        exact(rows, 1, times[row], inverse_moments, gyroscopic)
        found[row] = rows[0, 0:7]


@lanes_kernel
def _poses(
    first: int,
    last: int,
    found: NDArray[np.float64],
    spin: NDArray[np.float64],
    times: NDArray[np.float64],
    axes: tuple[int, int, int],
    handedness: float,
    g: Vector,
    inverse_moments: Vector,
    gyroscopic: Vector,
) -> None:
    widest_vectors()
    x, y, z = axes
    q, momentum = (spin[0], spin[1 + x], spin[1 + y], spin[1 + z]), (spin[4 + x], spin[4 + y], spin[4 + z])
    thrown = throw(q, momentum, inverse_moments[y], g, handedness)
    if thrown.steady or math.isnan(thrown.before_squared):
        _one_by_one(first, last, found, spin, times, inverse_moments, gyroscopic)
        return
    block = np.empty(8 * LANES)
    for begin in range(first, last, LANES):
        for i in range(LANES):
            block[7 * LANES + i] = times[min(begin + i, last - 1)]
        for i in range(LANES):
            (qw, qx, qy, qz), momentum = advanced(thrown, block[7 * LANES + i])
            qx, qy, qz = in_body_axes(axes, (qx, qy, qz))
            block[i], block[LANES + i], block[2 * LANES + i], block[3 * LANES + i] = qw, qx, qy, qz
            momentum = in_body_axes(axes, momentum)
            block[4 * LANES + i], block[5 * LANES + i], block[6 * LANES + i] = momentum
        # Seven, and not as many as `found` is wide: written out, the copy takes half the time.
        for i in range(min(LANES, last - begin)):
            for k in range(7):
                found[begin + i, k] = block[k * LANES + i]


def poses(spin: ArrayLike, times: ArrayLike, inverse_moments: Vector, gyroscopic: Vector | None) -> NDArray[np.float64]:
    """Return where one throw is at each instant: its quaternion, then L in body axes [kg m2/s], (T, 7).

    spin: the same of the throw at time 0, (7,); times [s], (T,), in any order; the body as `tumble.solver.integrators`
    has it.
    Raises ValueError for other shapes.
    """
    spin, times = np.array(spin, dtype=float), np.array(times, dtype=float)
    if spin.shape != (7,) or times.ndim != 1:
        raise ValueError(f"spin must have the shape (7,) and times (T,), got {spin.shape} and {times.shape}")
    found = np.empty((len(times), 7))
    if gyroscopic is None or 0.0 in gyroscopic:
        share_out(_one_by_one, len(times), FLOPS, found, spin, times, inverse_moments, gyroscopic)
        return found
    axes, handedness, g = ordered(inverse_moments, gyroscopic)
    share_out(_poses, len(times), FLOPS, found, spin, times, axes, handedness, g, inverse_moments, gyroscopic)
    return found
