"""The scene in three dimensions, in viser: the true body solid, every contestant a ghost of its own colour."""

from collections.abc import Callable, Hashable, Mapping, Sequence
from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray

from scenarios import frames
from scenarios.frames import Array
from scenarios.scene import Impulse, Scene
from tumble.lab import outline

# Okabe & Ito (2008): tellable apart by all eyes.
PALETTE = (
    (213, 94, 0),
    (0, 114, 178),
    (0, 158, 115),
    (204, 121, 167),
    (230, 159, 0),
    (86, 180, 233),
    (120, 94, 240),
    (0, 0, 0),
)
FOREIGN = (60, 60, 60)  # a trajectory from a file
TRUE, UNPROVEN = (250, 238, 208), (150, 156, 166)
RAY, HIT, BLOW, EDGE, TETHER = (90, 90, 90), (220, 38, 38), (220, 38, 38), (70, 70, 70), (110, 70, 20)
APPLICATION, CALCULATED = (16, 120, 60), (150, 40, 150)
GHOST_OPACITY, APART = 0.22, 0.01
FIELD_OF_VIEW = np.deg2rad(45.0)
NARROW = 0.7  # width over height


class Stage:
    """What one browser sees of one scene.  Rays of clicks come in the scene's coordinates, [m].

    Where the view follows the body it is the world that is moved, so that the eye stays the user's own.
    """

    def __init__(
        self, client: viser.ClientHandle, on_click: Callable[[Sequence[float], Sequence[float]], object]
    ) -> None:
        self._client, self._api, self._on_click = client, client.scene, on_click
        self._world: Any = None
        self._worlds = self._ghosts_made = 0
        self._ghosts: dict[Hashable, tuple[Any, Any]] = {}
        self._blows: list[Any] = []
        self._blows_shown: list[Any] = []
        self._offset = np.zeros(3)
        self._api.configure_default_lights(cast_shadow=False)
        self._api.add_light_ambient("/light", intensity=1.2)

    def set_up(self, scene: Scene) -> None:
        """Build the scene anew, its body at the start, and look at it."""
        with self._client.atomic():
            if self._world is not None:
                self._world.remove()  # and with it all that is in it
            self._blows, self._blows_shown, self._ghosts = [], [], {}
            self._scene, self._edges, self._faces = scene, outline.edges(scene.body), outline.faces(scene.body)
            self._up = upwards(scene)
            self._radius = scene.body.reach
            # Under a name of its own: a browser keeps the place of a name that comes back.
            self._worlds += 1
            self._root = f"/world{self._worlds}"
            self._world = self._api.add_frame(self._root, show_axes=False)
            self._add_body()
            self._add_ground()
            self._add_tethers()
        self.look()

    def look(self) -> None:
        """Put the eye where the whole body is seen, with room to fly."""
        camera = self._client.camera
        position, target = eye(self._scene, is_narrow=camera.image_width < NARROW * camera.image_height)
        with self._client.atomic():
            camera.fov = FIELD_OF_VIEW
            camera.near, camera.far = 0.02 * self._radius, 2000.0 * self._radius
            camera.up_direction = tuple(self._up)
            camera.position = tuple(position)
            camera.look_at = tuple(target)

    def follow(self, centre: Array | None) -> None:
        """Keep a place [m] where the body started, or let the world stand."""
        self._offset = np.zeros(3) if centre is None else self._scene.start[0, 0:3] - centre
        self._world.position = tuple(self._offset)

    def show_body(self, state: Array, vertices: Array, is_true: bool) -> None:
        """Put the solid body into a state, (13,), with its vertices [m], (n, 3)."""
        self._body.position, self._body.wxyz = tuple(state[0:3]), tuple(state[3:7])
        self._vertices = vertices
        colour = TRUE if is_true else UNPROVEN
        if self._solid is not None and tuple(self._solid.color) != colour:
            self._solid.color = colour
        if self._tethers is not None:
            self._tethers.points = self._tether_lines(vertices)

    def show_ghosts(self, ghosts: Mapping[Hashable, tuple[Array, tuple[int, int, int]]]) -> None:
        """Draw everybody there is by vertices [m], (n, 3), in a colour, and nobody else."""
        for gone in set(self._ghosts) - set(ghosts):
            for part in self._ghosts.pop(gone):
                part.remove()
        for contestant, (vertices, colour) in ghosts.items():
            lines = vertices[self._edges].astype(np.float32)
            if contestant not in self._ghosts:
                self._ghosts_made += 1
                name = f"{self._root}/ghost{self._ghosts_made}"
                edges = self._api.add_line_segments(
                    f"{name}/edges", lines, colour, thickness=2.5, thickness_units="screen"
                )
                faces = self._api.add_mesh_simple(
                    f"{name}/faces", vertices, self._faces, color=colour, opacity=GHOST_OPACITY, side="double",
                    flat_shading=True, cast_shadow=False, receive_shadow=False, visible=False,
                )  # fmt: skip
                self._ghosts[contestant] = edges, faces
            else:
                edges, faces = self._ghosts[contestant]
                edges.points, faces.vertices = lines, vertices.astype(np.float32)
            # Faces that lie in those of the solid body would flicker through them.
            apart = float(np.abs(vertices - self._vertices).max()) > APART * self._radius
            if faces.visible != apart:
                faces.visible = apart

    def show_blows(self, blows: Sequence[tuple[Impulse, Array]]) -> None:
        """Draw each impulse as an arrow that ends where it hits [m], (3,), and a click's ray behind it."""
        key = [(impulse, *place) for impulse, place in blows]
        if key == self._blows_shown:
            return
        for part in self._blows:
            part.remove()
        self._blows, self._blows_shown = [], key
        for number, (impulse, place) in enumerate(blows):
            direction = impulse.value / np.linalg.norm(impulse.value)
            arrow = np.array([[place - 0.9 * self._radius * direction, place]])
            size = 0.022 * self._radius
            self._blows.append(
                self._api.add_arrows(
                    f"{self._root}/blow{number}/arrow",
                    arrow,
                    BLOW,
                    shaft_radius=size,
                    head_radius=3 * size,
                    head_length=7 * size,
                )
            )
            self._blows.append(
                self._api.add_icosphere(f"{self._root}/blow{number}/hit", 1.6 * size, color=HIT, position=tuple(place))
            )
            if impulse.ray is not None:
                line = np.array([[impulse.ray.origin, place]])
                self._blows.append(
                    self._api.add_line_segments(
                        f"{self._root}/blow{number}/ray", line, RAY, thickness=1.0, thickness_units="screen"
                    )
                )

    def show_printed(self, calculated: Array, application: Array) -> None:
        """Mark the printed positions of Table 4.1 [m], (5, 3) each."""
        for name, points, colour in (("calculated", calculated, CALCULATED), ("application", application, APPLICATION)):
            self._api.add_point_cloud(
                f"{self._root}/{name}", points, colour, point_size=0.05 * self._radius, point_shape="circle"
            )

    def _add_body(self) -> None:
        """Add the solid body, which can be clicked where it has a surface."""
        body, start = self._scene.body, self._scene.start[0]
        self._body = self._api.add_frame(
            f"{self._root}/body", show_axes=False, position=tuple(start[0:3]), wxyz=tuple(start[3:7])
        )
        self._vertices = frames.vertices(start, body.points)
        self._solid = None
        if len(self._faces):
            self._solid = self._api.add_mesh_simple(
                f"{self._root}/body/solid", body.points, self._faces, color=TRUE, flat_shading=True,
                cast_shadow=False, receive_shadow=False,
            )  # fmt: skip
        edges = body.points[self._edges]
        self._api.add_line_segments(f"{self._root}/body/edges", edges, EDGE, thickness=1.2, thickness_units="screen")
        if self._solid is not None and len(body.faces):

            @self._solid.on_click
            def _(event: Any) -> None:
                self._on_click((np.array(event.ray_origin) - self._offset).tolist(), event.ray_direction)

    def _add_ground(self) -> None:
        """Add the floor where there is one, or a faint grid well below the body, for the eye alone."""
        floor, radius = self._scene.floor, self._radius
        centre = self._scene.start[0, 0:3]
        foot = centre - self._up * (centre @ self._up - floor.height if floor else 2.5 * radius)
        cell = 10.0 ** np.floor(np.log10(radius))
        self._api.add_grid(
            f"{self._root}/ground", 60 * cell, 60 * cell, plane="xy", cell_size=cell, section_size=5 * cell,
            cell_color=(200, 204, 210), section_color=(160, 165, 175), shadow_opacity=0.0,
            plane_color=(208, 214, 222), plane_opacity=0.6 if floor else 0.0, fade_distance=40 * cell,
            position=tuple(foot), wxyz=tuple(turned_from_z(self._up)),
        )  # fmt: skip

    def _add_tethers(self) -> None:
        """Add a line for every tether, and a ball where it is fixed."""
        self._tethers = None
        if self._scene.tethers:
            lines = self._tether_lines(self._vertices)
            self._tethers = self._api.add_line_segments(
                f"{self._root}/tethers", lines, TETHER, thickness=3.0, thickness_units="screen"
            )
        for number, tether in enumerate(self._scene.tethers):
            self._api.add_icosphere(
                f"{self._root}/anchor{number}", 0.05 * self._radius, color=TETHER, position=tuple(tether.anchor)
            )

    def _tether_lines(self, vertices: Array) -> NDArray[np.float32]:
        points = self._scene.body.points
        held = [int(np.argmin(np.linalg.norm(points - one.point_body, axis=1))) for one in self._scene.tethers]
        lines = [[one.anchor, vertices[at]] for one, at in zip(self._scene.tethers, held, strict=True)]
        return np.array(lines, dtype=np.float32)


def upwards(scene: Scene) -> Array:
    """Return the unit vector that is up: off the floor, against gravity, or else y."""
    if scene.floor is not None:
        return np.array(scene.floor.normal)
    if scene.gravity is not None:
        return -scene.gravity / np.linalg.norm(scene.gravity)
    return np.array([0.0, 1.0, 0.0])


def eye(scene: Scene, *, is_narrow: bool = False) -> tuple[Array, Array]:
    """Return where the eye is and what it looks at [m]: the body from a little above, two faces beside the top.

    In a narrow window the controls cover what is below, so that the body is put above the middle.
    """
    up = upwards(scene)
    aside = np.array([0.0, 0.0, 1.0]) if abs(up[2]) < 0.9 else np.array([0.0, -1.0, 0.0])
    across = np.cross(up, aside)
    towards = aside + 0.55 * across + 0.45 * up
    radius = scene.body.reach
    centre = scene.start[0, 0:3] - (radius * up if is_narrow else 0.0)
    return centre + 4.2 * radius * towards / np.linalg.norm(towards), centre


def turned_from_z(up: Array) -> Array:
    """Return the quaternion w x y z that turns the z axis to that unit vector."""
    if up[2] < -1 + 1e-12:
        return np.array([0.0, 1.0, 0.0, 0.0])
    q = np.array([1 + up[2], -up[1], up[0], 0.0])
    return q / np.linalg.norm(q)


def css(colour: tuple[int, int, int]) -> str:
    """Return a colour as a page writes it."""
    return f"rgb({', '.join(map(str, colour))})"
