"""The motion that the poses in a file describe, right or wrong: what a sensor on that body would measure."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from tumble.compare.grade.measure.conserved import fitted_pose
from tumble.compare.grade.model.kinematics import Kinematics, in_axes
from tumble.compare.grade.read.block import Block, vertices_of
from tumble.compare.grade.read.columns import Description
from tumble.compare.grade.read.trajectory import Trajectory
from tumble.scenarios.frames import Array, quaternion_product, rotation_matrix
from tumble.scenarios.scene import Scene

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

CONJUGATE = (1.0, -1.0, -1.0, -1.0)
# Degree of the splines through the poses, and the fewest rows of a piece without impulses.
DEGREE, FEWEST = 5, 8


class OwnMotion:
    """The motion through the poses of one throw, a spline in each piece between two impulses.

    gravity: of the scene [m/s2], (3,), which an accelerometer does not measure.
    """

    def __init__(self, times: Array, poses: Array, scene: Scene) -> None:
        """Fit the splines; times: [s], (T,); poses: x [m] and q, (T, 7)."""
        self.gravity = np.zeros(3) if scene.gravity is None else np.array(scene.gravity)
        self._times, self._poses, self._scene = times, poses, scene
        cuts = sorted({0.0, *(impulse.time for impulse in scene.impulses)})
        self._pieces: list[tuple[float, float, BSpline | None]] = []
        for begin, end in zip(cuts, [*cuts[1:], np.inf], strict=True):
            rows = (times >= begin) & (times <= end)
            spline = _spline(times[rows], poses[rows]) if rows.sum() >= FEWEST else None
            self._pieces.append((begin, end, spline))

    def at(self, times: Array) -> Kinematics:
        """Return the motion at increasing times [s]; nan in a piece with too few rows."""
        jets = np.full((3, len(times), 7), np.nan)
        for begin, end, spline in self._pieces:
            inside = (times >= begin) & (times < end) if begin > 0 else times < end
            if spline is not None:
                clamped = np.clip(times[inside], spline.t[0], spline.t[-1])
                jets[:, inside] = [spline(clamped, order) for order in range(3)]
        q, rate, bend = (jet[:, 3:7] for jet in jets)
        square = (q * q).sum(axis=1, keepdims=True)
        axes = rotation_matrix(q / np.sqrt(square))
        w = 2 * quaternion_product(rate, q * CONJUGATE)[:, 1:] / square
        alpha = 2 * quaternion_product(bend, q * CONJUGATE)[:, 1:] / square
        alpha -= 2 * w * (q * rate).sum(axis=1, keepdims=True) / square
        return Kinematics(axes, jets[1][:, 0:3], jets[2][:, 0:3], in_axes(axes, w), in_axes(axes, alpha))

    def coarser(self) -> "OwnMotion":
        """Return the motion through every second row, which shows how well the rows determine it."""
        return OwnMotion(self._times[::2], self._poses[::2], self._scene)

    def inner_rows(self, times: Array, spacing_s: float) -> np.ndarray:
        """Whether each of the times is away from the ends of a piece, where a spline's derivatives are poor, (T,)."""
        ends = [end for begin, end, _ in self._pieces[:-1]]
        edges = [self._times[0], *ends, self._times[-1]]
        return np.abs(times[:, None] - np.array(edges)).min(axis=1) > DEGREE * spacing_s


def _spline(times: Array, poses: Array) -> "BSpline":
    from scipy.interpolate import make_interp_spline  # slow to load: only a file with readings pays for it

    return make_interp_spline(times, poses, k=DEGREE)


def own_motion(trajectory: Trajectory, throw: int, scene: Scene) -> OwnMotion | None:
    """Return the motion of one throw's poses; None if the file does not have it whole."""
    description = trajectory.descriptions[0]
    points = scene.body.points[list(description.vertices)]
    if not description.has_centre or np.linalg.matrix_rank(points - points.mean(axis=0)) < 3:
        return None
    rows = [block.throw(throw) for block in trajectory.blocks() if (block.throws == throw).any()]
    times = np.concatenate([block.times for block in rows])
    poses = _continuous(_poses(rows, description, points, scene))
    return OwnMotion(times, poses, scene) if len(times) >= FEWEST else None


def _poses(rows: Sequence[Block], description: Description, points: Array, scene: Scene) -> Array:
    return np.concatenate(
        [fitted_pose(vertices_of(block, description, scene, stretched=False), points) for block in rows]
    )


def _continuous(poses: Array) -> Array:
    """Return poses with quaternions whose signs do not jump."""
    q = poses[:, 3:7]
    flips = np.where((q[1:] * q[:-1]).sum(axis=1) < 0, -1.0, 1.0)
    poses[1:, 3:7] *= np.cumprod(flips)[:, None]
    return poses
