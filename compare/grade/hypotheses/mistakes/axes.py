"""Signed permutations of axes, and what they are called."""

from itertools import permutations, product

import numpy as np

from tumble.scenarios.frames import Array


def signed_permutations(determinant: int) -> list[Array]:
    """Return the matrices that rename and reverse axes, but for the one that does nothing."""
    matrices = [
        np.diag(signs).astype(float)[list(order)]
        for order in permutations(range(3))
        for signs in product((1, -1), repeat=3)
    ]
    return [axes for axes in matrices if round(np.linalg.det(axes)) == determinant and (axes != np.eye(3)).any()]


def axis_names(axes: Array) -> str:
    """Return what stands for x y z."""
    return " ".join(("-" if row.min() < 0 else "") + "xyz"[int(np.argmax(np.abs(row)))] for row in axes)
