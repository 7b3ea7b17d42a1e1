"""Loops over the residuals of many programs, (V, T, K, 3): what they weigh, and what a translation leaves of them."""

import numpy as np
from numpy.typing import NDArray

from tumble.scenarios.frames import Array
from tumble.solver.compilation import kernel

Integers = NDArray[np.int64]


@kernel
def pose_residuals(
    x: Array, axes: Array, own_x: Array, own_axes: Array, arms: Array, has_centre: bool, trust: Array, found: Array
) -> None:
    """Write what programs with x, (V, T, 3), and axes, (V, T, 3, 3), leave of a file's, (T, 3) and (T, 3, 3).

    found: of the centre, and of three points of the body, (V, T, 4, 3); arms: of these [m], a point a column, (3, 3);
    trust: 1 / floor [1/m], (T, 3).
    """
    for program in range(len(x)):
        for row in range(len(own_x)):
            for axis in range(3):
                off = own_x[row, axis] - x[program, row, axis] if has_centre else 0.0
                found[program, row, 0, axis] = off * trust[row, axis]
                a = own_axes[row, axis, 0] - axes[program, row, axis, 0]
                b = own_axes[row, axis, 1] - axes[program, row, axis, 1]
                c = own_axes[row, axis, 2] - axes[program, row, axis, 2]
                for point in range(3):
                    moved = a * arms[0, point] + b * arms[1, point] + c * arms[2, point]
                    found[program, row, 1 + point, axis] = moved * trust[row, axis]


@kernel
def squares_of(errors: Array, edges: Integers, points: Integers, most: float, found: Array) -> None:
    """Write the mean squares of shells of rows and blocks of points, (V, S, B); that of a row is at most a number.

    edges: the first row of each shell, then the number of rows, (S + 1,); points: the same of blocks, (B + 1,).
    """
    for program in range(errors.shape[0]):
        for shell in range(len(edges) - 1):
            for block in range(len(points) - 1):
                total = 0.0
                for row in range(edges[shell], edges[shell + 1]):
                    square = 0.0
                    for point in range(points[block], points[block + 1]):
                        x, y, z = errors[program, row, point]
                        square += x * x + y * y + z * z
                    square /= 3 * (points[block + 1] - points[block])
                    total += square if square < most else most  # also of a run that diverged
                found[program, shell, block] = total / (edges[shell + 1] - edges[shell])


@kernel
def first_alike(rows: Array, most: float, found: Integers) -> None:
    """Write for each of some rows, (V, N), the number of the first one that it is like: (V,).

    The sum of the squares of their differences is at most a number.
    """
    for number in range(len(rows)):
        found[number] = number
        for other in range(number):
            if found[other] != other:
                continue
            total = 0.0
            for place in range(rows.shape[1]):
                off = rows[number, place] - rows[other, place]
                total += off * off
                if total > most:
                    break
            if total <= most:
                found[number] = other
                break


@kernel
def precisions_of(squares: Array, edges: Integers, points: Integers, found: Array) -> None:
    """Write how precise rows are, (V, T, K), from the mean squares of their shells, (V, S, B), in floors."""
    for program in range(len(squares)):
        for shell in range(len(edges) - 1):
            for block in range(len(points) - 1):
                first, last = points[block], points[block + 1]
                precision = 1.0 / (1.0 + squares[program, shell, block]) / (last - first)
                found[program, edges[shell] : edges[shell + 1], first:last] = precision


@kernel
def translation_equations(
    centres: Array, squares: Array, edges: Integers, powers: Array, trust: Array, normal: Array, right: Array
) -> None:
    """Write the equations, (V, P, P) and (V, P, 3), of the translation that leaves least of the centre's residuals.

    centres: residuals in floors, (V, T, 3), 0 where a run has diverged; squares: mean squares of their shells, (V, S),
    or of others that show how precise rows are, (1, S); powers: of time, (T, P); trust: 1 / floor [1/m], (T, 3).
    """
    count = powers.shape[1]
    mean = trust.sum(axis=1) / 3.0
    normal[:], right[:] = 0.0, 0.0
    for program in range(len(centres)):
        own = squares[min(program, len(squares) - 1)]
        for shell in range(len(edges) - 1):
            for row in range(edges[shell], edges[shell + 1]):
                weight = mean[row] * mean[row] / (1.0 + own[shell])
                for p in range(count):
                    weighted = weight * powers[row, p]
                    for q in range(p + 1):
                        normal[program, p, q] += weighted * powers[row, q]
                    for axis in range(3):
                        off = centres[program, row, axis]
                        if np.isfinite(off):
                            right[program, p, axis] += weighted * off / trust[row, axis]
        for p in range(count):
            for q in range(p):
                normal[program, q, p] = normal[program, p, q]


@kernel
def without_translation(centres: Array, powers: Array, solved: Array, trust: Array, found: Array) -> None:
    """Write what translations, (V, P, 3), leave of the centre's residuals, (V, T, 3), as `translation_equations`."""
    for program in range(len(centres)):
        for row in range(len(powers)):
            for axis in range(3):
                off = centres[program, row, axis]
                moved = 0.0
                for p in range(powers.shape[1]):
                    moved += powers[row, p] * solved[program, p, axis]
                found[program, row, axis] = (off if np.isfinite(off) else 0.0) - moved * trust[row, axis]
