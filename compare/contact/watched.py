"""One run above a plane as its observables need it: heights, slip, and when the plane pushes."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tumble.compare.run.flight import Trajectory
from tumble.scenarios.frames import Array, rotation_matrix, turned_by, vertices
from tumble.scenarios.lowest import lowest as lowest_of
from tumble.scenarios.lowest import lowest_point
from tumble.scenarios.scene import Body, Plane, Scene

# The plane pushes where the normal velocity changes by more than this share of what gravity does, or, without
# gravity, of the largest speed: far above rounding in single precision, far below a body's own weight.
PUSH, ROUNDED = 0.05, 1e-6


@dataclass(frozen=True, eq=False)
class Watched:
    """One throw of a run above a plane, R instants."""

    scene: Scene
    run: Trajectory
    throw: int = 0

    @property
    def times(self) -> Array:
        """Instants [s], (R,)."""
        return self.run.times

    @property
    def states(self) -> Array:
        """States, (R, 13)."""
        return self.run.states[:, self.throw]

    @property
    def plane(self) -> Plane:
        """The plane."""
        assert self.scene.plane is not None
        return self.scene.plane

    @property
    def pull(self) -> Array:
        """Gravity [m/s2], (3,)."""
        return gravity(self.scene)

    @cached_property
    def height(self) -> Array:
        """Height of the centre of mass above the plane [m], (R,)."""
        return (self.states[:, 0:3] - self.plane.point) @ self.plane.normal

    @cached_property
    def lowest(self) -> Array:
        """Height of the body's lowest point above the plane [m], (R,)."""
        return lowest(self.scene, self.states)

    @cached_property
    def pushed(self) -> NDArray[np.bool_]:
        """Whether the plane pushed between an instant and the next, (R - 1,)."""
        took, velocity = np.diff(self.times), self.states[:, 7:10]
        gained = (np.diff(velocity, axis=0) - took[:, None] * self.pull) @ self.plane.normal
        weight = abs(self.pull @ self.plane.normal) * took
        return gained > np.maximum(PUSH * weight, ROUNDED * abs(velocity).max())

    def along(self, vectors: Array) -> Array:
        """Return vectors (..., 3) without their parts along the normal."""
        return vectors - (vectors @ self.plane.normal)[..., None] * self.plane.normal

    @cached_property
    def slip(self) -> Array:
        """Velocity along the plane of a sphere's or a disc's lowest point, else of the centre [m/s], (R, 3)."""
        v, w, body = self.states[:, 7:10], self.states[:, 10:13], self.scene.body
        if body.radius is not None:
            v = v + np.cross(w, -body.radius * self.plane.normal)
        elif body.disc is not None:
            v = v + np.cross(w, lowest_point(body, self.states[:, 3:7], self.plane.normal))
        return self.along(v)

    @cached_property
    def turned(self) -> Array:
        """Angle from the first attitude [rad], (R,)."""
        q = self.states[:, 3:7]
        return np.linalg.norm(turned_by(q[:1], q), axis=1)

    def place(self, point: Array) -> Array:
        """Return where a point of the body, (3,) [m], body axes, is [m], (R, 3)."""
        return vertices(self.states, point[None])[:, 0]

    def at(self, time: float) -> Array:
        """Return the state at an instant [s], (13,), on the line between its neighbours."""
        return np.array([np.interp(time, self.times, column) for column in self.states.T])

    @property
    def deepest(self) -> float:
        """How far the lowest point was below the plane [m]."""
        return max(0.0, -float(self.lowest.min()))

    @property
    def through(self) -> bool:
        """Whether the centre of mass ends below the plane."""
        return bool(self.height[-1] < 0)


def gravity(scene: Scene) -> Array:
    """Return a scene's gravity [m/s2], (3,)."""
    return np.zeros(3) if scene.gravity is None else scene.gravity


def lowest(scene: Scene, states: Array) -> Array:
    """Return the height of the lowest point above the plane [m], (R,); states (R, 13)."""
    plane = scene.plane
    assert plane is not None
    return (states[:, 0:3] - plane.point) @ plane.normal + lowest_of(scene.body, states[:, 3:7], plane.normal)


def angular_momentum(state: Array, body: Body) -> Array:
    """Return R I R^T w [kg m2/s], (3,), world axes."""
    axes = rotation_matrix(state[3:7])
    return axes @ (body.moments * (axes.T @ state[10:13]))


def spin_of(momentum: Array, attitude: Array, body: Body) -> Array:
    """Return the angular velocity [rad/s], (3,), that a body of that attitude (4,) has with an angular momentum."""
    axes = rotation_matrix(attitude)
    return axes @ ((axes.T @ momentum) / body.moments)
