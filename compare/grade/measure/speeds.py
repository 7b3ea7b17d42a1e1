"""What rows show of a program by themselves: the speeds that they reach, and when they come to rest."""

import numpy as np

from tumble.compare.grade.measure.conserved import fitted_pose
from tumble.scenarios.frames import Array

# Shares of the intervals that are slower than a speed that rows reach: noise makes the fastest one faster.
SLOWER = (1.0, 0.9)
# Floors by which rows at rest may differ.
RESTING = 4.0


def speeds_reached(times: Array, vertices: Array, points: Array) -> dict[str, list[float]]:
    """Return the velocities of the centre [m/s] and the spins [rad/s] that rows reach; none of points in a line.

    times [s], (S,); vertices [m], (S, K, 3); points: axes of the body [m], (K, 3).  A spin of more than half a turn
    from row to row seems slower.
    """
    if len(times) < 2 or np.linalg.matrix_rank(points - points.mean(axis=0)) < 2:
        return {"velocity": [], "spin": []}
    poses, steps = fitted_pose(vertices, points), np.diff(times)
    v = np.linalg.norm(np.diff(poses[:, 0:3], axis=0), axis=1) / steps
    cosines = np.abs((poses[1:, 3:7] * poses[:-1, 3:7]).sum(axis=1))
    w = 2 * np.arccos(np.minimum(cosines, 1.0)) / steps
    return {name: np.quantile(speeds, SLOWER).tolist() for name, speeds in (("velocity", v), ("spin", w))}


def rests_from(times: Array, vertices: Array, floors_m: Array) -> float:
    """Return the time [s] from which rows rest, that of the last one if they do not.

    times [s], (S,); vertices [m], (S, K, 3); floors_m: of each row's axes, (S, 3).
    """
    moved = (np.abs(vertices - vertices[-1]) > RESTING * floors_m[:, None]).any(axis=(1, 2))
    return float(times[int(np.flatnonzero(moved).max(initial=-1)) + 1])
