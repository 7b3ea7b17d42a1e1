"""The scene in three dimensions, in viser: the true body solid, every contestant a ghost of its own colour."""

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

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
RAY, HIT, BLOW, EDGE, TETHER = (90, 90, 90), (220, 38, 38), (165, 0, 0), (70, 70, 70), (110, 70, 20)
APPLICATION, CALCULATED = (16, 120, 60), (150, 40, 150)
GHOST_OPACITY, APART, SAME = 0.22, 0.01, 1e-4
FIELD_OF_VIEW = np.deg2rad(45.0)
NARROW = 0.7  # width over height


Colour = tuple[int, int, int]


class Ghost(NamedTuple):
    """A contestant as it is drawn: vertices [m], (n, 3), and the state, (13,), that has put them there, if one has."""

    vertices: Array
    state: Array | None
    colour: Colour


@dataclass
class DrawnGhost:
    """What viser has of a ghost: a frame, in it the edges and faces, and their corners as they were sent."""

    frame: Any
    edges: Any
    faces: Any
    shape: NDArray[np.float32]


class Stage:
    """What one browser sees of one scene.  Rays of clicks come in the scene's coordinates, [m].

    A browser draws in single precision, walks two lengths a second, and sees nothing nearer than a hundredth: it is
    given lengths in the body's radius, from where the body starts.  Where the view follows the body it is the world
    that is moved, so that the eye stays the user's own.
    """

    def __init__(
        self, client: viser.ClientHandle, on_click: Callable[[Sequence[float], Sequence[float]], object]
    ) -> None:
        self._client, self._api, self._on_click = client, client.scene, on_click
        self._world: Any = None
        self._worlds = self._ghosts_made = 0
        self._ghosts: dict[Hashable, DrawnGhost] = {}
        self._blows: list[Any] = []
        self._blows_shown: list[Any] = []
        self._offset = np.zeros(3)
        self._api.configure_default_lights(cast_shadow=False)
        # A map of surroundings to mirror, and both sides of a ghost, take a browser without a GPU half of its pictures.
        self._api.configure_environment_map(None)
        self._api.add_light_ambient("/light", intensity=1.5)

    def set_up(self, scene: Scene, *, look: bool) -> None:
        """Build the scene anew, its body at the start; look: whether at it, from where all of it is seen."""
        turned = self._world is None or not np.array_equal(self._up, upwards(scene))
        with self._client.atomic():
            if self._world is not None:
                self._world.remove()  # and with it all that is in it
            self._blows, self._blows_shown, self._ghosts = [], [], {}
            self._scene, self._edges, self._faces = scene, outline.edges(scene.body), outline.faces(scene.body)
            self._up = upwards(scene)
            self._radius, self._origin = scene.body.reach, scene.start[0, 0:3]
            # Under a name of its own: a browser keeps the place of a name that comes back.
            self._worlds += 1
            self._root = f"/world{self._worlds}"
            self._world = self._api.add_frame(self._root, show_axes=False)
            self._add_body()
            self._add_ground()
            self._add_tethers()
        if look or turned:
            self._look()

    def _look(self) -> None:
        """Put the eye where the whole body is seen, with room to fly."""
        camera = self._client.camera
        position, target = eye(self._scene, is_narrow=camera.image_width < NARROW * camera.image_height)
        with self._client.atomic():
            camera.fov = FIELD_OF_VIEW
            camera.near, camera.far = 0.02, 2000.0
            camera.up_direction = tuple(self._up)
            camera.position = tuple(self._drawn(position))
            camera.look_at = tuple(self._drawn(target))

    def _drawn(self, places: Array) -> Array:
        """Return where places [m] are drawn in the world that moves."""
        return (places - self._origin) / self._radius

    def follow(self, centre: Array | None) -> None:
        """Keep a place [m] where the body started, or let the world stand."""
        self._offset = np.zeros(3) if centre is None else -self._drawn(centre)
        self._world.position = tuple(self._offset)

    def show_body(self, state: Array, vertices: Array, is_true: bool) -> None:
        """Put the solid body into a state, (13,), with its vertices [m], (n, 3)."""
        self._body.position, self._body.wxyz = tuple(self._drawn(state[0:3])), tuple(state[3:7])
        self._vertices = vertices
        colour = TRUE if is_true else UNPROVEN
        if self._solid is not None and tuple(self._solid.color) != colour:
            self._solid.color = colour
        if self._tethers is not None:
            self._tethers.points = self._tether_lines(state)

    def show_ghosts(self, ghosts: Mapping[Hashable, Ghost]) -> None:
        """Draw everybody there is, and nobody else."""
        for gone in set(self._ghosts) - set(ghosts):
            self._ghosts.pop(gone).frame.remove()
        for key, ghost in ghosts.items():
            shape, place, turn = self._shape(ghost)
            if key not in self._ghosts:
                self._ghosts[key] = self._add_ghost(shape, ghost.colour)
            drawn = self._ghosts[key]
            drawn.frame.position, drawn.frame.wxyz = tuple(place), tuple(turn)
            if not np.array_equal(shape, drawn.shape):
                drawn.edges.points, drawn.faces.vertices, drawn.shape = shape[self._edges], shape, shape
            # Faces that lie in those of the solid body would flicker through them.
            apart = float(np.abs(ghost.vertices - self._vertices).max()) > APART * self._radius
            if drawn.faces.visible != apart:
                drawn.faces.visible = apart

    def _shape(self, ghost: Ghost) -> tuple[NDArray[np.float32], Array, Array]:
        """Return a ghost's corners, where they are put and how they are turned.

        Of a body that keeps its shape only the last two change, which a browser does at once; new corners cost it a
        frame.
        """
        points, state = self._scene.body.points, ghost.state
        if state is not None:
            off = np.abs(frames.vertices(state, points) - ghost.vertices).max()
            if off < SAME * self._radius:
                return (points / self._radius).astype(np.float32), self._drawn(state[0:3]), state[3:7]
        return self._drawn(ghost.vertices).astype(np.float32), np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0])

    def _add_ghost(self, shape: NDArray[np.float32], colour: Colour) -> DrawnGhost:
        self._ghosts_made += 1
        name = f"{self._root}/ghost{self._ghosts_made}"
        frame = self._api.add_frame(name, show_axes=False)
        edges = self._api.add_line_segments(
            f"{name}/edges", shape[self._edges], colour, thickness=2.5, thickness_units="screen"
        )
        faces = self._api.add_mesh_simple(
            f"{name}/faces", shape, self._faces, color=colour, opacity=GHOST_OPACITY, side="front",
            flat_shading=True, cast_shadow=False, receive_shadow=False, visible=False,
        )  # fmt: skip
        return DrawnGhost(frame, edges, faces, shape)

    def show_blows(self, blows: Sequence[tuple[Impulse, Array]]) -> None:
        """Draw each impulse as an arrow that ends where it hits [m], (3,), and a click's ray behind it."""
        key = [(impulse, *place) for impulse, place in blows]
        if key == self._blows_shown:
            return
        for part in self._blows:
            part.remove()
        self._blows, self._blows_shown = [], key
        for number, (impulse, place) in enumerate(blows):
            direction, hit = impulse.value / np.linalg.norm(impulse.value), self._drawn(place)
            name, size = f"{self._root}/blow{number}", 0.022
            arrow = np.array([[hit - 0.9 * direction, hit]])
            self._blows += [
                self._api.add_arrows(
                    f"{name}/arrow", arrow, BLOW, shaft_radius=size, head_radius=3 * size, head_length=7 * size
                ),
                self._api.add_icosphere(f"{name}/hit", 1.6 * size, color=HIT, position=tuple(hit)),
            ]
            if impulse.ray is not None:
                line = np.array([[self._drawn(impulse.ray.origin), hit]])
                ray = self._api.add_line_segments(f"{name}/ray", line, RAY, thickness=1.0, thickness_units="screen")
                self._blows.append(ray)

    def show_printed(self, calculated: Array, application: Array) -> None:
        """Mark the printed positions of Table 4.1 [m], (5, 3) each."""
        for name, points, colour in (("calculated", calculated, CALCULATED), ("application", application, APPLICATION)):
            self._api.add_point_cloud(
                f"{self._root}/{name}", self._drawn(points), colour, point_size=0.05, point_shape="circle"
            )

    def _add_body(self) -> None:
        """Add the solid body, which can be clicked where it has a surface."""
        body, start = self._scene.body, self._scene.start[0]
        self._body = self._api.add_frame(
            f"{self._root}/body", show_axes=False, position=(0.0, 0.0, 0.0), wxyz=tuple(start[3:7])
        )
        self._vertices = frames.vertices(start, body.points)
        points = body.points / self._radius
        self._solid = None
        if len(self._faces):
            self._solid = self._api.add_mesh_simple(
                f"{self._root}/body/solid", points, self._faces, color=TRUE, flat_shading=True,
                cast_shadow=False, receive_shadow=False,
            )  # fmt: skip
        edges = points[self._edges]
        self._api.add_line_segments(f"{self._root}/body/edges", edges, EDGE, thickness=1.2, thickness_units="screen")
        if self._solid is not None and len(body.faces):

            @self._solid.on_click
            def _(event: Any) -> None:
                origin = (np.array(event.ray_origin) - self._offset) * self._radius + self._origin
                self._on_click(origin.tolist(), event.ray_direction)

    def _add_ground(self) -> None:
        """Add the floor where there is one, or a faint grid well below the body, for the eye alone."""
        floor, cell = self._scene.floor, 10.0 ** np.floor(np.log10(self._radius)) / self._radius
        depth = (self._origin @ self._up - floor.height) / self._radius if floor else 2.5
        self._api.add_grid(
            f"{self._root}/ground", 60 * cell, 60 * cell, plane="xy", cell_size=cell, section_size=5 * cell,
            cell_color=(200, 204, 210), section_color=(160, 165, 175), shadow_opacity=0.0,
            plane_color=(150, 162, 180), plane_opacity=0.8 if floor else 0.0, fade_distance=40 * cell,
            position=tuple(-depth * self._up), wxyz=tuple(turned_from_z(self._up)),
        )  # fmt: skip

    def _add_tethers(self) -> None:
        """Add a line for every tether, and a ball where it is fixed."""
        self._tethers = None
        if self._scene.tethers:
            lines = self._tether_lines(self._scene.start[0])
            self._tethers = self._api.add_line_segments(
                f"{self._root}/tethers", lines, TETHER, thickness=3.0, thickness_units="screen"
            )
        for number, tether in enumerate(self._scene.tethers):
            self._api.add_icosphere(
                f"{self._root}/anchor{number}", 0.05, color=TETHER, position=tuple(self._drawn(tether.anchor))
            )

    def _tether_lines(self, state: Array) -> NDArray[np.float32]:
        """Return from where to where the tethers go at a state, (13,)."""
        held = frames.vertices(state, np.array([one.point_body for one in self._scene.tethers]))
        anchors = np.array([one.anchor for one in self._scene.tethers])
        return self._drawn(np.stack([anchors, held], axis=1)).astype(np.float32)


def upwards(scene: Scene) -> Array:
    """Return the unit vector that is up: off the floor, against gravity, or else y."""
    if scene.floor is not None:
        return np.array(scene.floor.normal)
    if scene.gravity is not None:
        return -scene.gravity / np.linalg.norm(scene.gravity)
    return np.array([0.0, 1.0, 0.0])


def eye(scene: Scene, *, is_narrow: bool = False) -> tuple[Array, Array]:
    """Return where the eye is and what it looks at [m]: the body from a little above, two faces beside the top.

    In a narrow window the controls cover what is below, so that the body is further away, above the middle.
    """
    up = upwards(scene)
    aside = np.array([0.0, 0.0, 1.0]) if abs(up[2]) < 0.9 else np.array([0.0, -1.0, 0.0])
    across = np.cross(up, aside)
    towards = aside + 0.55 * across + 0.45 * up
    below, away = (1.5, 7.5) if is_narrow else (0.0, 4.2)
    centre = scene.start[0, 0:3] - below * scene.body.reach * up
    return centre + away * scene.body.reach * towards / np.linalg.norm(towards), centre


def turned_from_z(up: Array) -> Array:
    """Return the quaternion w x y z that turns the z axis to that unit vector."""
    if up[2] < -1 + 1e-12:
        return np.array([0.0, 1.0, 0.0, 0.0])
    q = np.array([1 + up[2], -up[1], up[0], 0.0])
    return q / np.linalg.norm(q)


def css(colour: Colour) -> str:
    """Return a colour as a page writes it."""
    return f"rgb({', '.join(map(str, colour))})"
