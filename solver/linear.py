"""Linear equations in a kernel: LU factors with partial pivoting, of real and of complex matrices."""

import numpy as np
from numpy.typing import NDArray

from tumble.solver.compilation import borrowing

Matrix = NDArray[np.float64] | NDArray[np.complex128]
Order = NDArray[np.int64]


@borrowing
def factorise(matrix: Matrix, order: Order) -> None:
    """Replace a matrix by its factors L, below the diagonal, and U; the diagonal, of U, is inverted.

    order: the rows that partial pivoting exchanged.
    Source: Golub & Van Loan, "Matrix Computations" (2013), section 3.4.
    """
    n = len(matrix)
    for k in range(n):
        best, size = k, 0.0
        for i in range(k, n):
            candidate = abs(matrix[i, k].real) + abs(matrix[i, k].imag)
            if candidate > size:
                best, size = i, candidate
        order[k] = best
        if best != k:
            for j in range(n):
                matrix[k, j], matrix[best, j] = matrix[best, j], matrix[k, j]
        matrix[k, k] = 1.0 / matrix[k, k]
        for i in range(k + 1, n):
            matrix[i, k] *= matrix[k, k]
            for j in range(k + 1, n):
                matrix[i, j] -= matrix[i, k] * matrix[k, j]


@borrowing
def substitute(matrix: Matrix, order: Order, right: Matrix) -> None:
    """Replace the right-hand side of a linear equation by its solution, given the factors of its matrix."""
    n = len(matrix)
    for k in range(n):
        right[k], right[order[k]] = right[order[k]], right[k]
    for k in range(n):
        for j in range(k):
            right[k] -= matrix[k, j] * right[j]
    for k in range(n - 1, -1, -1):
        for j in range(k + 1, n):
            right[k] -= matrix[k, j] * right[j]
        right[k] *= matrix[k, k]
