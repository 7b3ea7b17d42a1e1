"""The fused multiply-adds a second that this machine's cores can do: what a vectorised kernel is measured against."""

import numpy as np
from numpy.typing import NDArray

from tumble.solver.ensemble.lanes import lanes_kernel, widest_vectors

# Sixteen vectors of eight: more than the pipelines hold, no more than there are registers.
CHAINS = 128


@lanes_kernel
def multiply_add(x: NDArray[np.float64], n: int) -> None:
    """Take n steps of x = x a + b, all in registers; x: (CHAINS,)."""
    widest_vectors()
    for _ in range(n):
        for i in range(CHAINS):
            x[i] = x[i] * 0.999999 + 1e-9


def flops(n: int) -> int:
    """Return the operations of n steps, a fused one counted as two."""
    return 2 * CHAINS * n
