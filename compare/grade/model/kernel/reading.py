"""Rows between two ticks of a program: interpolated, or moved on from the last one."""

import math
from pathlib import Path

import numpy as np

from tumble.compare.grade.model.kernel.dynamics import Array
from tumble.compare.grade.model.kernel.stepping import write_matrix
from tumble.solver.compilation import kernel_with
from tumble.solver.quaternion import exponential, product

# Column of a row of `kernel.stepping` at which its quaternion begins.
Q = 18
# The attitude along an arc; q linearly, and normalised; moved on from the last tick at its velocities.
SLERP, LINEAR, EXTRAPOLATED = 1, 2, 3
# Cosine of an angle below which an arc is a line.
STRAIGHT = 1.0 - 1e-14


@kernel_with(Path(__file__).parent)
def instants_of(ticks: Array, instants: Array, first: Array) -> int:
    """Write every tick and the next one once, in order; return their number.

    ticks: whole numbers that do not decrease, (T,); instants: (2 T,); first: the place of each tick in them, (T,).
    """
    count = 0
    for row in range(len(ticks)):
        for tick in (ticks[row], ticks[row] + 1.0):
            if count == 0 or tick > instants[count - 1]:
                instants[count] = tick
                count += 1
        first[row] = count - 2
    return count


@kernel_with(Path(__file__).parent)
def between_ticks(rows: Array, first: Array, fraction: Array, tick: float, kind: int, found: Array) -> None:
    """Write poses between two ticks that follow each other: x, the matrix and q of rows of `kernel.stepping`, (T, 22).

    rows: of the same, at ticks, (N, 22); first: the row of each pose's first tick, (T,); fraction: of a tick
    since then, (T,); tick: [s].
    """
    for number in range(len(first)):
        row, part = int(first[number]), fraction[number]
        before = rows[row]
        q = (before[Q], before[Q + 1], before[Q + 2], before[Q + 3])
        if kind == EXTRAPOLATED:
            for axis in range(3):
                found[number, axis] = before[axis] + part * tick * before[12 + axis]
            half = 0.5 * part * tick
            w, x, y, z = product(exponential((half * before[15], half * before[16], half * before[17])), q)
        else:
            after = rows[row + 1]
            for axis in range(3):
                found[number, axis] = (1.0 - part) * before[axis] + part * after[axis]
            cosine = q[0] * after[Q] + q[1] * after[Q + 1] + q[2] * after[Q + 2] + q[3] * after[Q + 3]
            sign = -1.0 if cosine < 0.0 else 1.0
            one, other = 1.0 - part, part
            if kind == SLERP and sign * cosine < STRAIGHT:
                angle = math.acos(min(1.0, sign * cosine))
                one, other = math.sin(one * angle) / math.sin(angle), math.sin(other * angle) / math.sin(angle)
            w, x = one * q[0] + sign * other * after[Q], one * q[1] + sign * other * after[Q + 1]
            y, z = one * q[2] + sign * other * after[Q + 2], one * q[3] + sign * other * after[Q + 3]
        found[number, Q], found[number, Q + 1], found[number, Q + 2], found[number, Q + 3] = w, x, y, z
        # What is moved on keeps the length of its quaternion, as what is written at a tick does.
        size = 1.0 if kind == EXTRAPOLATED else np.sqrt(w * w + x * x + y * y + z * z)
        write_matrix(found[number], (w / size, x / size, y / size, z / size))
