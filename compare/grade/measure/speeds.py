"""What rows show of a program by themselves: the speeds that they reach, and when they come to rest."""

import numpy as np

from tumble.compare.grade.measure.conserved import fitted_pose
from tumble.scenarios.frames import Array, turned_by

# The velocity of the centre [m/s], the angular velocity [rad/s], and the largest component of each, world axes.
SPEEDS: tuple[str, ...] = ("velocity", "spin", "velocity component", "spin component")
# Shares of the intervals that are slower than a speed that rows reach: noise makes the fastest one faster.
SLOWER = (1.0, 0.9)
# A speed is of rows so far apart that noise changes it by at most this share, if the body turns by at most so many
# radians between them, and if there are so many intervals.
PRECISE, TURNED, INTERVALS = 0.01, 0.5, 16
# Floors by which rows at rest may differ.
RESTING = 4.0


def speeds_reached(times: Array, vertices: Array, points: Array, floors_m: Array) -> dict[str, list[float]]:
    """Return the speeds that rows reach, each by its name in SPEEDS; none if the points are in a line.

    times [s], (S,); vertices [m], (S, K, 3); points: axes of the body [m], (K, 3); floors_m: of each row's axes,
    (S, 3).  A spin of more than half a turn from row to row seems slower.
    """
    if len(times) < 2 or np.linalg.matrix_rank(points - points.mean(axis=0)) < 2:
        return {name: [] for name in SPEEDS}
    poses = fitted_pose(vertices, points)
    places, attitudes, intervals = poses[:, 0:3], poses[:, 3:7], len(times) - 1
    most_of = (floors_m, places[1:] - places[:-1], turned_by(attitudes[:-1], attitudes[1:]))
    noise_m, moved_m, turned = (float(np.quantile(np.linalg.norm(each, axis=1), SLOWER[-1])) for each in most_of)
    size_m = float(np.ptp(points, axis=0).max())
    most = max(1, intervals // INTERVALS)
    of_v = min(most, _rows_apart(noise_m, moved_m))
    of_w = max(1, min(most, _rows_apart(noise_m / size_m, turned), int(TURNED / turned) if turned else 1))
    v = (places[of_v:] - places[:-of_v]) / (times[of_v:] - times[:-of_v])[:, None]
    w = turned_by(attitudes[:-of_w], attitudes[of_w:]) / (times[of_w:] - times[:-of_w])[:, None]
    return {name: np.quantile(each, SLOWER).tolist() for name, each in _sizes(v, w).items()}


def _rows_apart(noise: float, change: float) -> int:
    """Return how many intervals apart rows are whose change, of so much in one, noise makes little different."""
    return int(np.ceil(noise / (PRECISE * change))) if change > PRECISE * noise else 1


def largest_speeds(v: Array, w: Array) -> dict[str, float]:
    """Return the largest of each of SPEEDS, of velocities [m/s] and spins [rad/s], world axes, (T, 3)."""
    with np.errstate(all="ignore"):  # a run that diverged
        found = {name: float(each.max()) for name, each in _sizes(v, w).items()}
    return {name: float(np.nan_to_num(each, nan=0.0, posinf=0.0)) for name, each in found.items()}


def _sizes(v: Array, w: Array) -> dict[str, Array]:
    """Return how large velocities and spins are, and their largest components, (T,)."""
    sizes = (np.linalg.norm(each, axis=1) for each in (v, w))
    components = (np.abs(each).max(axis=1) for each in (v, w))
    return dict(zip(SPEEDS, (*sizes, *components), strict=True))


def rests_from(times: Array, vertices: Array, floors_m: Array) -> float:
    """Return the time [s] from which rows rest, that of the last one if they do not.

    times [s], (S,); vertices [m], (S, K, 3); floors_m: of each row's axes, (S, 3).
    """
    moved = (np.abs(vertices - vertices[-1]) > RESTING * floors_m[:, None]).any(axis=(1, 2))
    return float(times[int(np.flatnonzero(moved).max(initial=-1)) + 1])
