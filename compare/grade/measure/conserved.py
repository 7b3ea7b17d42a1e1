"""Conserved quantities of a trajectory: from its velocities if it has them, otherwise from differences of poses."""

import numpy as np

from tumble.compare.grade.read.block import Block, axes_of, principal_attitudes, vertices_of
from tumble.compare.grade.read.columns import CENTRE, SPIN, VELOCITY, Description
from tumble.compare.judge import mechanics
from tumble.scenarios.frames import Array, rotation_matrix, turned_by
from tumble.scenarios.scene import Scene
from tumble.solver.quaternion import from_matrix

# Vertices that determine an attitude: this share of their spread must be across a line.
SPREAD = 1e-6


class Conserved:
    """Energy, momentum and angular momentum of a file's throws, compared with the reference.

    Differences are taken of the reference's poses as well, so that the error of a difference quotient is not reported
    as a drift.
    """

    def __init__(self, scene: Scene, description: Description) -> None:
        self._scene, self._description = scene, description
        points = scene.body.points[list(description.vertices)]
        spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
        self._posed = description.has_centre and (
            description.kind != "vertices" or (len(points) > 2 and spread[1] > SPREAD * spread[0])
        )
        self.by_differences = not description.velocities
        self._scales, self._largest = np.zeros(3), np.zeros(3)
        self._energy, self._any = 0.0, False

    def add(self, rows: Block, true: Array) -> None:
        """Add one throw's rows of a block; true: reference states, (n, 13)."""
        if not self._posed:
            return
        states = poses_of(rows, self._description, self._scene)
        if self.by_differences:
            keep = self._undisturbed(rows.times)
            states, true = _differenced(states, rows.times)[keep], _differenced(true, rows.times)[keep]
        else:
            states = np.hstack((states[:, 0:7], rows.of(VELOCITY), rows.of(SPIN)))
        if len(states):
            self._compare(states, true)

    def drifts(self) -> tuple[float, float, float] | None:
        """Return the largest drift of each, over its largest true value; the energy's with its sign."""
        if not self._any:
            return None
        scales = np.where(self._scales > 0, self._scales, 1.0)
        energy, momentum, angular = self._largest / scales
        return float(np.copysign(energy, self._energy)), float(momentum), float(angular)

    def _compare(self, states: Array, true: Array) -> None:
        body, gravity = self._scene.body, self._scene.gravity
        self._any = True
        apart = mechanics.energy(states, body, gravity) - mechanics.energy(true, body, gravity)
        worst = float(apart[np.argmax(np.abs(apart))])
        if abs(worst) > self._largest[0]:
            self._energy = worst
        sample = (mechanics.momentum, mechanics.angular_momentum)
        values = [np.linalg.norm(of(states, body) - of(true, body), axis=-1).max() for of in sample]
        scales = [np.linalg.norm(of(true, body), axis=-1).max() for of in sample]
        self._largest = np.maximum(self._largest, (abs(worst), *values))
        self._scales = np.maximum(self._scales, (mechanics.kinetic_energy(true, body).max(), *scales))

    def _undisturbed(self, times: Array) -> np.ndarray:
        """Return which central differences span no impulse, (n - 2,)."""
        impulse_times = np.array([impulse.time for impulse in self._scene.impulses])
        begins, ends = times[:-2, None], times[2:, None]
        return np.logical_not(np.any((begins < impulse_times) & (impulse_times <= ends), axis=1))


def poses_of(rows: Block, description: Description, scene: Scene) -> Array:
    """Return x and q of the rows, (n, 7); from vertices, by the best fit."""
    if description.kind == "pose":
        return np.hstack((rows.of(CENTRE), principal_attitudes(rows, scene.body.file_axes)))
    if description.kind == "matrix":
        axes = axes_of(rows, description.kind, scene.body.file_axes)
        return np.hstack((rows.of(CENTRE), from_matrix(axes)))
    return fitted_pose(vertices_of(rows, description, scene), scene.body.points[list(description.vertices)])


def fitted_pose(places: Array, points: Array) -> Array:
    """Return x and q, (n, 7), of the rigid motion that fits points best.

    places: world [m], (n, K, 3); points: body axes [m], (K, 3).
    Source: Kabsch, Acta Cryst. A32 (1976) 922; the rotation by Davenport's q-method,
    `tumble.solver.quaternion.from_matrix`.
    """
    middle = points.mean(axis=0)
    centre = places.mean(axis=1)
    # from_matrix returns the rotation with the largest trace with B, and B^T = sum of p y^T.
    q = from_matrix(np.einsum("nki,kj->nij", places - centre[:, None], points - middle))
    turned = np.einsum("nij,j->ni", rotation_matrix(q), middle)
    return np.hstack((centre - turned, q))


def _differenced(poses: Array, times: Array) -> Array:
    """Return the states, (n - 2, 13), of poses, (n, 7 or more), with v and w by central differences."""
    if len(times) < 3:
        return np.empty((0, 13))
    span = (times[2:] - times[:-2])[:, None]
    units = poses[:, 3:7] / np.linalg.norm(poses[:, 3:7], axis=1)[:, None]
    w = turned_by(units[:-2], units[2:]) / span
    return np.hstack((poses[1:-1, 0:7], (poses[2:, 0:3] - poses[:-2, 0:3]) / span, w))
