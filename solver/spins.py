"""The row of an array in which a throw's rotation waits between two calls: quaternion, then angular momentum, (7,)."""

import numpy as np
from numpy.typing import NDArray

from tumble.solver.compilation import scalar
from tumble.solver.quaternion import Quaternion
from tumble.solver.vectors import Vector


@scalar
def load(spin: NDArray[np.float64]) -> tuple[Quaternion, Vector]:
    """Return the quaternion and the angular momentum [kg m2/s] of a row, (7,)."""
    return (spin[0], spin[1], spin[2], spin[3]), (spin[4], spin[5], spin[6])


@scalar
def store(spin: NDArray[np.float64], q: Quaternion, momentum: Vector) -> None:
    """Write the quaternion and the angular momentum [kg m2/s] into a row, (7,)."""
    spin[0], spin[1], spin[2], spin[3] = q
    spin[4], spin[5], spin[6] = momentum


@scalar
def load_anchor(spin: NDArray[np.float64]) -> tuple[Quaternion, Vector]:
    """Return the quaternion and the angular momentum [kg m2/s] from which the steps are counted, of a row, (14,)."""
    return (spin[7], spin[8], spin[9], spin[10]), (spin[11], spin[12], spin[13])


@scalar
def store_anchor(spin: NDArray[np.float64], q: Quaternion, momentum: Vector) -> None:
    """Write them to where `load_anchor` finds them."""
    spin[7], spin[8], spin[9], spin[10] = q
    spin[11], spin[12], spin[13] = momentum
