"""What rows show of a program by themselves: the speeds that they reach, and when they come to rest."""

import numpy as np

from tumble.compare.grade.measure.conserved import fitted_pose
from tumble.scenarios.frames import Array, turned_by

# The velocity of the centre [m/s], the angular velocity [rad/s], and the largest component of each, world axes.
SPEEDS: tuple[str, ...] = ("velocity", "spin", "velocity component", "spin component")
# Shares of the intervals that are slower than a speed that rows reach: noise makes the fastest one faster.
SLOWER = (1.0, 0.9)
# Floors by which rows at rest may differ.
RESTING = 4.0


def speeds_reached(times: Array, vertices: Array, points: Array) -> dict[str, list[float]]:
    """Return the speeds that rows reach, each by its name in SPEEDS; none if the points are in a line.

    times [s], (S,); vertices [m], (S, K, 3); points: axes of the body [m], (K, 3).  A spin of more than half a turn
    from row to row seems slower.
    """
    if len(times) < 2 or np.linalg.matrix_rank(points - points.mean(axis=0)) < 2:
        return {name: [] for name in SPEEDS}
    poses, steps = fitted_pose(vertices, points), np.diff(times)[:, None]
    v, w = np.diff(poses[:, 0:3], axis=0) / steps, turned_by(poses[:-1, 3:7], poses[1:, 3:7]) / steps
    return {name: np.quantile(each, SLOWER).tolist() for name, each in _sizes(v, w).items()}


def largest_speeds(v: Array, w: Array) -> dict[str, float]:
    """Return the largest of each of SPEEDS, of velocities [m/s] and spins [rad/s], world axes, (T, 3)."""
    with np.errstate(all="ignore"):  # a run that diverged
        found = {name: float(each.max()) for name, each in _sizes(v, w).items()}
    return {name: float(np.nan_to_num(each, nan=0.0, posinf=0.0)) for name, each in found.items()}


def _sizes(v: Array, w: Array) -> dict[str, Array]:
    """Return how large velocities and spins are, and their largest components, (T,)."""
    sizes = (np.sqrt(np.square(each).sum(axis=1)) for each in (v, w))
    components = (np.abs(each).max(axis=1) for each in (v, w))
    return dict(zip(SPEEDS, (*sizes, *components), strict=True))


def rests_from(times: Array, vertices: Array, floors_m: Array) -> float:
    """Return the time [s] from which rows rest, that of the last one if they do not.

    times [s], (S,); vertices [m], (S, K, 3); floors_m: of each row's axes, (S, 3).
    """
    moved = (np.abs(vertices - vertices[-1]) > RESTING * floors_m[:, None]).any(axis=(1, 2))
    return float(times[int(np.flatnonzero(moved).max(initial=-1)) + 1])
