"""The scene in three dimensions, in viser: the true body solid, every contestant a ghost of its own colour."""

from collections.abc import Callable, Hashable, Mapping, Sequence
from typing import Any

import numpy as np
import viser

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
TRUE, UNPROVEN = (250, 238, 208), (150, 156, 166)
RAY, HIT, BLOW = (90, 90, 90), (220, 38, 38), (220, 38, 38)
APPLICATION, CALCULATED = (16, 120, 60), (150, 40, 150)
GHOST_OPACITY, APART = 0.22, 0.01
FIELD_OF_VIEW = np.deg2rad(45.0)


class Stage:
    """What one browser sees of one scene.  Rays of clicks come in the scene's coordinates, [m].

    Where the view follows the body it is the world that is moved, so that the eye stays the user's own.
    """

    def __init__(
        self, client: viser.ClientHandle, on_click: Callable[[Sequence[float], Sequence[float]], object]
    ) -> None:
        self._client, self._api, self._on_click = client, client.scene, on_click
        self._parts: list[Any] = []
        self._ghosts: dict[Hashable, tuple[Any, Any]] = {}
        self._blows: list[Any] = []
        self._offset = np.zeros(3)
        self._api.configure_default_lights(cast_shadow=False)

    def set_up(self, scene: Scene) -> None:
        """Build the scene anew, its body at the start, and look at it."""
        with self._client.atomic():
            for part in [*self._parts, *self._blows, *(part for pair in self._ghosts.values() for part in pair)]:
                part.remove()
            self._parts, self._blows, self._ghosts = [], [], {}
            self._scene, self._edges, self._faces = scene, outline.edges(scene.body), outline.faces(scene.body)
            self._up = upwards(scene)
            self._radius = float(np.linalg.norm(scene.body.points, axis=1).max())
            self._world = self._keep(self._api.add_frame("/world", show_axes=False))
            self._add_body()
            self._add_ground()
            self._add_tethers()
        self.look()

    def look(self) -> None:
        """Put the eye where the whole body is seen, with room to fly."""
        position, target = eye(self._scene)
        camera = self._client.camera
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
                part.visible = False
                part.remove()
        for number, (contestant, (vertices, colour)) in enumerate(ghosts.items()):
            lines = vertices[self._edges].astype(np.float32)
            if contestant not in self._ghosts:
                name = f"/world/ghost{number}-{abs(hash(contestant))}"
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
        for part in self._blows:
            part.remove()
        self._blows = []
        for number, (impulse, place) in enumerate(blows):
            direction = impulse.value / np.linalg.norm(impulse.value)
            arrow = np.array([[place - 0.9 * self._radius * direction, place]])
            size = 0.022 * self._radius
            self._blows.append(
                self._api.add_arrows(
                    f"/world/blow{number}/arrow",
                    arrow,
                    BLOW,
                    shaft_radius=size,
                    head_radius=3 * size,
                    head_length=7 * size,
                )
            )
            self._blows.append(
                self._api.add_icosphere(f"/world/blow{number}/hit", 1.6 * size, color=HIT, position=tuple(place))
            )
            if impulse.ray is not None:
                line = np.array([[impulse.ray.origin, place]])
                self._blows.append(
                    self._api.add_line_segments(
                        f"/world/blow{number}/ray", line, RAY, thickness=1.0, thickness_units="screen"
                    )
                )

    def show_printed(self, calculated: Array, application: Array) -> None:
        """Mark the printed positions of Table 4.1 [m], (5, 3) each."""
        for name, points, colour in (("calculated", calculated, CALCULATED), ("application", application, APPLICATION)):
            self._keep(
                self._api.add_point_cloud(
                    f"/world/{name}", points, colour, point_size=0.05 * self._radius, point_shape="circle"
                )
            )

    def _keep(self, part: Any) -> Any:
        self._parts.append(part)
        return part

    def _add_body(self) -> None:
        """Add the solid body, which can be clicked where it has a surface."""
        body = self._scene.body
        self._body = self._keep(self._api.add_frame("/world/body", show_axes=False))
        self._solid = None
        if len(self._faces):
            self._solid = self._keep(
                self._api.add_mesh_simple(
                    "/world/body/solid", body.points, self._faces, color=TRUE, flat_shading=True,
                    cast_shadow=False, receive_shadow=False,
                )
            )  # fmt: skip
        self._keep(
            self._api.add_line_segments(
                "/world/body/edges", body.points[self._edges], (70, 70, 70), thickness=1.2, thickness_units="screen"
            )
        )
        if self._solid is not None and len(body.faces):

            @self._solid.on_click
            def _(event: Any) -> None:
                self._on_click((np.array(event.ray_origin) - self._offset).tolist(), event.ray_direction)

        self.show_start()

    def show_start(self) -> None:
        """Put the body where it starts."""
        self._tethers = None
        start = self._scene.start[0]
        self._body.position, self._body.wxyz = tuple(start[0:3]), tuple(start[3:7])

    def _add_ground(self) -> None:
        """Add the floor where there is one, or a faint grid well below the body, for the eye alone."""
        floor, radius = self._scene.floor, self._radius
        centre = self._scene.start[0, 0:3]
        foot = centre - self._up * (centre @ self._up - floor.height if floor else 2.5 * radius)
        cell = 10.0 ** np.floor(np.log10(radius))
        self._keep(
            self._api.add_grid(
                "/world/ground", 60 * cell, 60 * cell, plane="xy", cell_size=cell, section_size=5 * cell,
                cell_color=(200, 204, 210), section_color=(160, 165, 175), shadow_opacity=0.0,
                plane_color=(208, 214, 222), plane_opacity=0.6 if floor else 0.0, fade_distance=40 * cell,
                position=tuple(foot), wxyz=tuple(turned_from_z(floor.normal if floor else self._up)),
            )
        )  # fmt: skip

    def _add_tethers(self) -> None:
        self._tethers = None
        if not self._scene.tethers:
            return
        start = frames.vertices(self._scene.start, self._scene.body.points)[0]
        self._tethers = self._keep(
            self._api.add_line_segments(
                "/world/tethers", self._tether_lines(start), (110, 70, 20), thickness=3.0, thickness_units="screen"
            )
        )
        for number, tether in enumerate(self._scene.tethers):
            self._keep(
                self._api.add_icosphere(
                    f"/world/anchor{number}", 0.05 * self._radius, color=(110, 70, 20), position=tuple(tether.anchor)
                )
            )

    def _tether_lines(self, vertices: Array) -> Array:
        points = self._scene.body.points
        held = [int(np.argmin(np.linalg.norm(points - one.point_body, axis=1))) for one in self._scene.tethers]
        return np.array([[one.anchor, vertices[at]] for one, at in zip(self._scene.tethers, held, strict=True)])


def upwards(scene: Scene) -> Array:
    """Return the unit vector that is up: against gravity, off the floor, or else y."""
    if scene.gravity is not None:
        return -scene.gravity / np.linalg.norm(scene.gravity)
    return np.array(scene.floor.normal) if scene.floor else np.array([0.0, 1.0, 0.0])


def eye(scene: Scene) -> tuple[Array, Array]:
    """Return where the eye is and what it looks at [m]: the body from a little above, two faces beside the top."""
    up = upwards(scene)
    aside = np.array([0.0, 0.0, 1.0]) if abs(up[2]) < 0.9 else np.array([0.0, -1.0, 0.0])
    across = np.cross(up, aside)
    towards = aside + 0.55 * across + 0.45 * up
    radius = float(np.linalg.norm(scene.body.points, axis=1).max())
    centre = scene.start[0, 0:3]
    return centre + 4.2 * radius * towards / np.linalg.norm(towards), centre


def turned_from_z(up: Array) -> Array:
    """Return the quaternion w x y z that turns the z axis to that unit vector."""
    if up[2] < -1 + 1e-12:
        return np.array([0.0, 1.0, 0.0, 0.0])
    q = np.array([1 + up[2], -up[1], up[0], 0.0])
    return q / np.linalg.norm(q)
