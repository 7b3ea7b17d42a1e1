"""What audits of several engines look for."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def stood_still(written: Array, states: Array, steps: int) -> Iterator[tuple[str, str]]:
    """Say so where a body kept a velocity and went nowhere in all the steps since it was written, (N, 13) both."""
    if not steps:
        return
    same = (states == written)[:, [0, 1, 2, 7, 8, 9]].all(axis=1)
    for throw in np.flatnonzero(same & written[:, 7:10].any(axis=1)):
        yield "frozen", f"throw {throw} did not move at all although v = {written[throw, 7:10]} m/s"


def beyond(what: str, unit: str, largest: float, limit: float) -> Iterator[tuple[str, str]]:
    """Say so where a speed has reached the engine's limit of it."""
    if largest >= limit * (1.0 - 1e-6):
        yield "clamped", f"clamped: {what} reached {largest:.4g} {unit}; the limit is {limit:.4g}"
