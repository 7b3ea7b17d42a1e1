"""Signed permutations of axes, and their names."""

from functools import cache
from itertools import permutations, product

import numpy as np

from tumble.scenarios.frames import Array


@cache
def signed_permutations(determinant: int) -> tuple[Array, ...]:
    """Return the signed permutation matrices with a determinant of 1 or -1, without the identity."""
    matrices = [
        np.diag(signs).astype(float)[list(order)]
        for order in permutations(range(3))
        for signs in product((1, -1), repeat=3)
    ]
    return tuple(axes for axes in matrices if round(np.linalg.det(axes)) == determinant and (axes != np.eye(3)).any())


def axis_names(axes: Array) -> str:
    """Return the axes that replace x y z."""
    return " ".join(("-" if row.min() < 0 else "") + "xyz"[int(np.argmax(np.abs(row)))] for row in axes)
