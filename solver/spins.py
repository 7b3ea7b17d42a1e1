"""The row of an array in which a throw's rotation waits between two calls: quaternion, then angular momentum, (7,)."""

import numpy as np
from numpy.typing import NDArray

from solver.compilation import scalar
from solver.quaternion import Quaternion
from solver.vectors import Vector


@scalar
def load(spin: NDArray[np.float64]) -> tuple[Quaternion, Vector]:
    """Return the quaternion and the angular momentum [kg m2/s] of a row, (7,)."""
    return (spin[0], spin[1], spin[2], spin[3]), (spin[4], spin[5], spin[6])


@scalar
def store(spin: NDArray[np.float64], q: Quaternion, momentum: Vector) -> None:
    """Write the quaternion and the angular momentum [kg m2/s] into a row, (7,)."""
    spin[0], spin[1], spin[2], spin[3] = q
    spin[4], spin[5], spin[6] = momentum
