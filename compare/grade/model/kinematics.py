"""The motion of the body that a sensor measures: attitude, velocities and accelerations at any time."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from tumble.compare.grade.model.reference import Reference
from tumble.scenarios.frames import Array, rotation_matrix
from tumble.scenarios.scene import Scene
from tumble.scenarios.wrench import wrench


@dataclass(frozen=True, eq=False)
class Kinematics:
    """The body's motion at some times.

    axes: principal axes to world, (T, 3, 3); v [m/s] and a [m/s2] of the centre of mass in world axes, w [rad/s] and
    alpha [rad/s2] in principal axes, (T, 3).
    """

    axes: Array
    v_world: Array
    a_world: Array
    w_body: Array
    alpha_body: Array


class Motion(Protocol):
    """A motion; gravity: [m/s2], (3,), world axes."""

    gravity: Array

    def at(self, times: Array) -> Kinematics:
        """Return the motion at increasing times [s], (T,); before the start, that of the start."""
        ...


class TrueMotion:
    """The reference motion of one throw of a scene."""

    def __init__(self, scene: Scene, throw: int) -> None:
        self._reference, self._throw = Reference(scene), throw
        self._mass, self._moments = scene.body.mass, scene.body.moments
        self._wrench = None if scene.is_free else wrench(scene)
        self.gravity = np.zeros(3) if scene.gravity is None else np.array(scene.gravity)

    def at(self, times: Array) -> Kinematics:
        """Return the motion, after the impulses of each instant; accelerations by the Newton-Euler equations."""
        states = self._reference.states(self._throw, np.maximum(times, 0.0))
        axes = rotation_matrix(states[:, 3:7])
        w_body = in_axes(axes, states[:, 10:13])
        pulls = np.zeros((len(times), 6)) if self._wrench is None else self._wrench(states)
        torque = in_axes(axes, pulls[:, 3:6]) - np.cross(w_body, self._moments * w_body)
        return Kinematics(
            axes=axes,
            v_world=states[:, 7:10],
            a_world=self.gravity + pulls[:, 0:3] / self._mass,
            w_body=w_body,
            alpha_body=torque / self._moments,
        )


def in_axes(axes: Array, vectors: Array) -> Array:
    """Return vectors of world axes, (T, 3), in the body's; axes: body to world, (T, 3, 3)."""
    return np.einsum("tji,tj->ti", axes, vectors)


def in_world(axes: Array, vectors: Array) -> Array:
    """Return vectors of the body's axes, (T, 3), in world axes."""
    return np.einsum("tij,tj->ti", axes, vectors)
