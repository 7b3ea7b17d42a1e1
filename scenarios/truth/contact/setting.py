"""One throw above a rigid plane, in numbers of the working precision: what every phase of its motion starts from.

The file's numbers are read in fractions, as everywhere in `tumble.scenarios.truth`, and rounded once, to the context's
digits.
"""

from typing import Any, NamedTuple

import numpy as np

from tumble.scenarios.scene import Scene
from tumble.scenarios.truth.flight import Pose, Turning
from tumble.scenarios.truth.inertia import Numbers, Principal, inverse, principal, square_root
from tumble.scenarios.truth.rational import Fraction, cross
from tumble.scenarios.truth.throw import Read, Throw, exact_numbers, read_throw

# The sine of the tilt of a disc's axis from the normal at which it is flat.
FLAT = 2.0**-20
# Of size and distances: a gap or, of speeds, a speed that the rounding of a file's numbers may have made of none.
TOUCHING = 2.0**-46


class PlaneNumbers(NamedTuple):
    """A plane in fractions: point [m] and unit normal, (3,); restitution and friction of the pair."""

    point: Numbers
    normal: Numbers
    restitution: Fraction
    friction: Fraction


def read_plane(scene: Scene, read: Read) -> PlaneNumbers:
    """Return the plane of a scene as its file has it."""
    plane, written = scene.plane, scene.written
    assert plane is not None
    normal = plane.normal
    if written is not None and written.plane_normal is not None and np.array_equal(normal, written.plane_normal):
        assert written.file_plane_normal is not None
        normal = written.file_plane_normal
    line = exact_numbers(normal, read)
    squared: Any = line @ line
    return PlaneNumbers(
        exact_numbers(plane.point, read),
        line / square_root(squared),
        read(float(plane.restitution)),
        read(float(plane.friction)),
    )


class Setting:
    """A throw, its plane and its body in a context's numbers.

    mp: mpmath context at the working precision, or its context of doubles; normal, point, gravity, (3,); restitution,
    friction, mass; tensor and its inverse, file axes, (3, 3); points: of the body that can touch, file axes from the
    centre of mass [m], (n, 3): of a sphere none; radius: of a sphere [m], else None; rim: radius and half the thickness
    of a disc [m], else None; reach [m].
    """

    def __init__(self, mp: Any, throw: Throw, plane: PlaneNumbers, own: Principal) -> None:
        self.mp, self.throw = mp, throw
        self.normal, self.point = self.numbers(plane.normal), self.numbers(plane.point)
        self.restitution, self.friction = mp.mpf(plane.restitution), mp.mpf(plane.friction)
        self.mass, self.gravity = mp.mpf(throw.solid.mass), self.numbers(throw.gravity)
        self.tensor, self.inverse = self.numbers(throw.solid.tensor), self.numbers(inverse(throw.solid.tensor))
        self.radius = None if throw.radius is None else mp.mpf(throw.radius)
        self.rim = None if throw.disc is None else (mp.mpf(throw.disc[0]), mp.mpf(throw.disc[1]) / 2)
        self.points = self.numbers(throw.points)
        self.turning = Turning(mp, throw.solid.tensor, own)
        self.moments = self.numbers(own.moments)
        self.times = [mp.mpf(time) for time in throw.times]
        self.reach = mp.sqrt(max(point @ point for point in self.points))

    def numbers(self, values: Numbers) -> Numbers:
        """Return an array of the context's numbers."""
        return np.array([self.mp.mpf(value) for value in values.flat], dtype=object).reshape(values.shape)

    @property
    def start(self) -> Pose:
        """The pose at t = 0, before any impulse."""
        throw = self.throw
        return Pose(*map(self.numbers, (throw.x, throw.axes, throw.v, throw.w_world)))

    @property
    def pressing(self) -> Any:
        """How fast gravity presses a body at rest on the plane against it [m/s2]."""
        return -(self.gravity @ self.normal)

    @property
    def gravity_along(self) -> Numbers:
        """The part of gravity along the plane [m/s2], (3,)."""
        return self.along(self.gravity)

    def along(self, vector: Numbers) -> Numbers:
        """Return the part of a vector along the plane, (3,)."""
        return vector - self.normal * (vector @ self.normal)

    def levers(self, pose: Pose) -> Numbers:
        """Return where the points that can touch are from the centre of mass, world axes [m], (n, 3).

        Of a sphere its lowest; of a disc the lowest of each rim: of that at z < 0, then of the other if there is one.
        """
        if self.radius is not None:
            return (self.normal * -self.radius)[np.newaxis]
        if self.rim is not None:
            (radius, half), axis = self.rim, pose.axes[:, 2]
            lowest = down(self.mp, self.normal, axis) * radius
            return np.array((lowest - axis * half, lowest + axis * half) if half else (lowest,))
        return self.points @ pose.axes.T

    def point_name(self, point: int) -> str:
        """Return what to call a point that can touch."""
        return f"vertex {point}" if self.rim is None else "a rim"

    def lever(self, pose: Pose, point: int) -> Numbers:
        """Return where one of them is from the centre of mass, world axes [m], (3,)."""
        is_round = self.radius is not None or self.rim is not None
        return self.levers(pose)[point] if is_round else self.points[point] @ pose.axes.T

    def gaps(self, pose: Pose) -> Numbers:
        """Return how far each of them is above the plane [m], (n,)."""
        return (pose.x - self.point) @ self.normal + self.levers(pose) @ self.normal

    def inverse_world(self, pose: Pose) -> Numbers:
        """Return the inverse inertia tensor along world axes [1 / (kg m2)], (3, 3)."""
        return self.inverse if self.radius is not None else pose.axes @ self.inverse @ pose.axes.T

    def momentum_body(self, pose: Pose) -> Numbers:
        """Return the angular momentum along the file's axes [kg m2/s], (3,)."""
        return self.tensor @ (pose.axes.T @ pose.w_world)

    def sine_of_tilt(self, pose: Pose) -> Any:
        """Return the sine of the angle between a disc's axis and the normal."""
        axis = pose.axes[:, 2]
        across = self.normal - axis * (axis @ self.normal)
        return self.mp.sqrt(across @ across)

    def face_points(self, points: tuple[int, ...]) -> Numbers:
        """Return the points that a face lies on, file axes, (k, 3); of a disc the eight of its one rim."""
        if self.rim is None:
            return self.points[list(points)]
        return self.points[1:].reshape(-1, 8, 3)[points[0]]

    def touching_m(self, pose: Pose) -> float:
        """Return the gap that counts as none [m]."""
        far = max(abs(float(value)) for value in (*pose.x, *self.point))
        return TOUCHING * (float(self.reach) + far)

    def speed_m_s(self, pose: Pose) -> Any:
        """Return what no point of the body is faster than [m/s]."""
        return length(self.mp, pose.v) + length(self.mp, pose.w_world) * self.reach


def read_setting(mp: Any, scene: Scene, row: int, read: Read = Fraction) -> Setting:
    """Return one throw of a scene with a plane, at the precision that mp has."""
    throw = read_throw(scene, row, read)
    return Setting(mp, throw, read_plane(scene, read), principal(mp, throw.solid.tensor))


def length(mp: Any, vector: Numbers) -> Any:
    """Return the length of a vector."""
    return mp.sqrt(vector @ vector)


def unit(mp: Any, vector: Numbers) -> Numbers:
    """Return a vector of length 1 along another that is not zero."""
    return vector / length(mp, vector)


def down(mp: Any, normal: Numbers, axis: Numbers) -> Numbers:
    """Return the unit vector across an axis that points most against the normal, (3,); any where all do alike."""
    below = axis * (axis @ normal) - normal
    if not (below @ below):
        return tangents(mp, axis, 0 * axis)[0]
    return unit(mp, below)


def tangents(mp: Any, normal: Numbers, along: Numbers) -> tuple[Numbers, Numbers]:
    """Return two unit vectors along the plane, right-handed with its normal; the first along a vector of the plane,

    where that is not zero.
    """
    if not (along @ along):
        axis = min(range(3), key=lambda axis: abs(normal[axis]))
        ends = np.array([mp.mpf(int(axis == other)) for other in range(3)], dtype=object)
        along = ends - normal * normal[axis]
    first = unit(mp, along)
    return first, cross(normal, first)
