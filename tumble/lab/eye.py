"""The camera: directions of a scene, the first view of it, and what is outside the view."""

from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np
from scipy.spatial.transform import Rotation

from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Scene

FIELD_OF_VIEW = np.deg2rad(45.0)
NARROW = 0.7  # width over height: in such a window the controls lie over the picture
COVERED = 0.53  # of its height, as lab.css has it


class Axes(NamedTuple):
    """Unit vectors of a scene in its first view, (3,) each: to the right, up, and towards the camera."""

    right: Array
    up: Array
    towards: Array


def upwards(scene: Scene) -> Array:
    """Return the unit vector that is up: off the floor, against gravity, off the plane, or else y."""
    if scene.floor is not None:
        return np.array(scene.floor.normal)
    if scene.gravity is not None:
        return -scene.gravity / np.linalg.norm(scene.gravity)
    return np.array([0.0, 1.0, 0.0]) if scene.plane is None else np.array(scene.plane.normal)


def axes(scene: Scene) -> Axes:
    """Return the directions of a scene: of a y that is up, x, y and z."""
    return axes_about(upwards(scene))


def axes_about(up: Array) -> Axes:
    """Return the directions for a unit vector that is up, (3,)."""
    towards = np.array([0.0, 0.0, 1.0]) if abs(up[2]) < 0.9 else np.array([0.0, -1.0, 0.0])
    right = np.cross(up, towards)
    right /= np.linalg.norm(right)
    return Axes(right, up, np.cross(right, up))


def first_view(scene: Scene, *, is_narrow: bool = False) -> tuple[Array, Array]:
    """Return where the eye is and what it looks at [m]: the body from a little above, two faces beside the top.

    In a narrow window the controls cover what is below, so that the body is further away, above the middle.
    """
    right, up, ahead = axes(scene)
    towards = ahead + 0.55 * right + 0.45 * up
    below, away = (1.5, 7.5) if is_narrow else (0.0, 4.4)
    centre = scene.start[0, 0:3] - below * scene.body.reach * up
    return centre + away * scene.body.reach * towards / np.linalg.norm(towards), centre


class Box(NamedTuple):
    """The extent of a text beside a place, in pixels from it: to the left, to the right, below and above."""

    left: float
    right: float
    below: float
    above: float


@dataclass(frozen=True)
class Eye:
    """A pinhole: its place, (3,), its directions, the picture's width and height [pixels], and the height's tangent at
    a distance of 1 from its middle."""

    place: Array
    axes: Axes
    width: float
    height: float
    tangent: float

    @classmethod
    def of(cls, place: Array, target: Array, up: Array, angle: float, width: float, height: float) -> Self:
        """Return the eye at a place that looks at a target, (3,) each; angle [rad] that its picture is high."""
        towards = (place - target) / max(np.linalg.norm(place - target), 1e-12)
        right = np.cross(up, towards)
        right /= max(np.linalg.norm(right), 1e-12)
        turned = Axes(right, np.cross(towards, right), towards)
        return cls(place, turned, max(width, 1.0), max(height, 1.0), max(float(np.tan(angle / 2)), 1e-12))

    @property
    def lowest(self) -> float:
        """Height of the lowest place that no controls cover, above the picture's middle [pixels]."""
        return (COVERED if self.width < NARROW * self.height else 0.0) * self.height - self.height / 2

    def pixels(self, places: Array) -> Array:
        """Return where points, (n, 3), are from the picture's middle to the right and up [pixels], and their depth."""
        away = places - self.place
        depth = -away @ self.axes.towards
        scale = self.height / 2 / self.tangent / np.where(depth > 0, depth, np.nan)
        return np.stack([away @ self.axes.right * scale, away @ self.axes.up * scale, depth], axis=-1)

    def sees(self, places: Array) -> bool:
        """Whether any of these, (n, 3), lies in the picture."""
        across, over, _ = np.abs(self.pixels(places)).T
        return bool(((across <= self.width / 2) & (over <= self.height / 2)).any())

    def covered(self, place: Array, box: Box) -> Array:
        """Return the box that a text beside a place, (3,), covers in the picture: left, right, low and high."""
        across, over, _ = self.pixels(place[None])[0]
        return np.array([across - box.left, across + box.right, over - box.below, over + box.above])

    def upwards(self, place: Array, pixels: float) -> Array:
        """Return the vector, (3,), by which something at a place, (3,), moves up the picture by a number of pixels."""
        depth = (self.place - place) @ self.axes.towards
        return pixels * depth * self.tangent / (self.height / 2) * self.axes.up

    def moved_inside(self, place: Array, box: Box) -> Array:
        """Return the place nearest to one, (3,), at equal depth, whose text lies inside the picture."""
        across, over, depth = self.pixels(place[None])[0]
        if not np.isfinite(across + over):
            return place
        moved = np.array(
            [
                clipped(across, -self.width / 2 + box.left, self.width / 2 - box.right) - across,
                clipped(over, self.lowest + box.below, self.height / 2 - box.above) - over,
            ]
        ) * (depth * self.tangent / (self.height / 2))
        return place + moved[0] * self.axes.right + moved[1] * self.axes.up


def clipped(value: float, low: float, high: float) -> float:
    """Return the value of an interval that is nearest to one; of an empty interval its beginning."""
    return max(min(value, high), low)


def turned_to(turned: Axes) -> Array:
    """Return the quaternion w x y z that turns x, y and z to these directions."""
    return np.roll(Rotation.from_matrix(np.stack(turned, axis=1)).as_quat(), 1)
