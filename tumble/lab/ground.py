"""What stands still while the body moves: floor, plane or grid, a ruled wall where the body falls, and its path."""

from typing import Any

import numpy as np
import viser

from tumble.lab.eye import Axes, axes, axes_about, turned_to
from tumble.lab.space import Space
from tumble.reports.numerals import given
from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Scene

CELL_INK, SECTION_INK, FLOOR_INK, PATH_INK = (219, 224, 229), (176, 185, 194), (228, 233, 238), (110, 121, 131)
FADED = 14.0  # radii of the body: further away a grid is not seen
BELOW, BEHIND, BESIDE = 2.5, 2.2, 2.6  # radii: the grid below a body that does not fall; the wall, and its heights
BEFORE = 0.2  # radii: the heights before the wall, whose lines would flicker through them
CELLS = 5  # of a section of the ground
SECTIONS = 3  # of the wall, to each side of the body, each of two cells: every line costs a browser without a GPU time
HEIGHTS = (-1, 0, 1)  # sections about the body whose heights are written on the wall
DASHES = 120  # of a path, at most


class Ground:
    """The floor or the plane, where the scene has one; a ruled wall, where the body falls; else a grid below it.

    The wall stands behind the body at the same distance, so that the body never goes through it, and its lines at their
    heights: what falls goes past them, whether the view follows it or not.
    """

    def __init__(self, api: viser.SceneApi, scene: Scene, space: Space) -> None:
        self._api, self._space, self._axes = api, space, axes(scene)
        self._section = section(space.radius)
        self._path: Any = None
        self._path_length = 0
        self._wall: Any = None
        self._heights: list[Any] = []
        self._at: int | None = None
        floor, plane = scene.floor, scene.plane
        if floor is not None:
            self._add_floor(float(space.origin @ self._axes.up) - floor.height, self._axes, is_solid=True)
        elif plane is not None:
            depth = float((space.origin - plane.point) @ plane.normal)
            self._add_floor(depth, axes_about(plane.normal), is_solid=True)
        elif scene.gravity is None:
            self._add_floor(BELOW * space.radius, self._axes, is_solid=False)
        else:
            self._add_wall()

    def follow(self, centre: Array) -> None:
        """Keep the wall behind the body, whose centre is there [m], (3,), and the heights written about it."""
        if self._wall is None:
            return
        right, up, towards = self._axes
        behind = float(centre @ towards) - BEHIND * self._space.radius
        # The lines stay at their places, whole sections from the world's zero.
        height, across = (round(float(centre @ way) / self._section) for way in (up, right))
        self._wall.position = self._drawn(across * self._section, height * self._section, behind)
        beside = float(centre @ right) - BESIDE * self._space.radius
        before = behind + BEFORE * self._space.radius
        for label, number in zip(self._heights, HEIGHTS, strict=True):
            label.position = self._drawn(beside, (height + number) * self._section, before)
            if self._at != height:
                label.text = f"{given(round((height + number) * self._section, 12))} m"
        self._at = height

    def show_path(self, centres: Array) -> None:
        """Draw the path of the true centre [m], (n, 3), as far as it is known."""
        if len(centres) == self._path_length:
            return
        self._path_length = len(centres)
        if self._path is not None:
            self._path.remove()
            self._path = None
        lines = dashes(self._space.drawn(centres))
        if len(lines):
            self._path = self._api.add_line_segments(
                f"{self._space.root}/path{len(centres)}", lines, PATH_INK, thickness=1.2, thickness_units="screen"
            )

    def _drawn(self, right: float, up: float, towards: float) -> tuple[float, ...]:
        """Return the drawn place of distances along each axis [m]."""
        return tuple(self._space.drawn(np.array([right, up, towards]) @ np.stack(self._axes)))

    def _add_floor(self, depth: float, along: Axes, *, is_solid: bool) -> None:
        """Add a grid at a depth below the body's start [m], as a floor or only for orientation; along: which way."""
        right, up, towards = along
        self._api.add_grid(
            f"{self._space.root}/ground",
            plane_color=FLOOR_INK, plane_opacity=0.85 if is_solid else 0.0,
            position=tuple(self._space.drawn(self._space.origin - depth * up)),
            wxyz=tuple(turned_to(Axes(right, -towards, up))), **self._ruled(),
        )  # fmt: skip

    def _add_wall(self) -> None:
        """Add a ruled wall, and labels with the heights of its lines."""
        # Lines, and not a grid of viser's, which is worked out for every pixel: without a GPU that takes twice as long.
        size = self._section / self._space.radius
        name = f"{self._space.root}/wall"
        self._wall = self._api.add_frame(name, show_axes=False, wxyz=tuple(turned_to(self._axes)))
        for part, first, ink in (("cells", 0.5, CELL_INK), ("sections", 0.0, SECTION_INK)):
            lines = ruling(size, SECTIONS, first)
            self._api.add_line_segments(f"{name}/{part}", lines, ink, thickness=1.0, thickness_units="screen")
        self._heights = [
            self._api.add_label(
                f"{self._space.root}/height{number}", "", font_screen_scale=0.9, depth_test=True, anchor="bottom-left"
            )
            for number in range(len(HEIGHTS))
        ]
        self.follow(self._space.origin)

    def _ruled(self) -> dict[str, Any]:
        """Return how a grid is ruled."""
        size = self._section / self._space.radius
        return {
            "plane": "xy", "infinite_grid": True, "cell_size": size / CELLS, "section_size": size,
            "cell_color": CELL_INK, "section_color": SECTION_INK, "fade_distance": FADED, "fade_strength": 1.5,
            "shadow_opacity": 0.0,
        }  # fmt: skip


def section(radius: float) -> float:
    """Return a round length [m], 1, 2 or 5 times a power of ten, of about three radii of a body."""
    power = 10.0 ** np.floor(np.log10(3 * radius))
    return float(power * max(step for step in (1, 2, 5) if step * power <= 3 * radius * (1 + 1e-12)))


def ruling(step: float, count: int, first: float) -> np.ndarray:
    """Return the lines of a square about the origin, in the plane of x and y, (n, 2, 3).

    They are a step apart, count of them to each side, of which the first is that share of a step off the origin.
    """
    at = step * (np.arange(-count, count + (first == 0.0)) + first)
    ends, zero = np.full_like(at, step * count), np.zeros_like(at)
    upright = np.stack([np.stack([at, -ends, zero], axis=1), np.stack([at, ends, zero], axis=1)], axis=1)
    return np.concatenate([upright, upright[..., [1, 0, 2]]]).astype(np.float32)


def dashes(points: Array) -> np.ndarray:
    """Return every other part of a way, (n, 3), as lines, (m, 2, 3)."""
    stride = -(-len(points) // (2 * DASHES))
    ends = points[:: max(stride, 1)]
    return np.stack([ends[:-1:2], ends[1::2]], axis=1).astype(np.float32) if len(ends) > 1 else np.empty((0, 2, 3))
