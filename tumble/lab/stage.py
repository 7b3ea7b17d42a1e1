"""The scene in three dimensions, in viser: the true body solid, each contestant a ghost in its engine's colour."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import viser
from numpy.typing import NDArray

from tumble.lab.die import pips
from tumble.lab.eye import FIELD_OF_VIEW, NARROW, Eye, axes, first_view
from tumble.lab.ground import Ground
from tumble.lab.labels import labels
from tumble.lab.outline import Outline
from tumble.lab.printed import PrintedTable
from tumble.lab.space import Space
from tumble.scenarios import frames
from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Impulse, Scene

Colour = tuple[int, int, int]

# As on the page: a body of cool grey, dark pips and edges, what acts in its colour of warnings.
TRUE, UNPROVEN, EDGE, PIP = (222, 229, 237), (172, 177, 184), (27, 33, 39), (32, 38, 44)
RAY, ACTS, TETHER = (110, 121, 131), (156, 63, 0), (110, 70, 20)
FOREIGN = (40, 40, 40)  # a trajectory from a file
BACKGROUND = (241, 243, 245)
# The page's light, by how much a face looks at it; of right, up and towards the eye.
LIGHT, SHADE, LIGHT_INTENSITY = (0.3, 1.0, 0.55), (140, 140, 140), 3.6
GHOST_OPACITY, SEEN_THROUGH = 0.2, 0.45
RAISED = 1.003  # edges, so that they do not flicker through their faces
# In radii of the body: a ghost nearer to the true body than this is that body to the eye; faces nearer than this
# flicker through its own; corners nearer than this to those that were sent are those.
SEEN_APART, APART, SAME = 0.004, 0.01, 1e-3
TRUTH = "truth"


class Ghost(NamedTuple):
    """A contestant as it is drawn: vertices [m], (n, 3), colour, and the name on its label."""

    vertices: Array
    colour: Colour
    name: str


@dataclass
class DrawnGhost:
    """What viser has of a ghost: a frame, in it the edges and faces, and their corners as they were sent."""

    frame: Any
    edges: Any
    faces: Any
    shape: NDArray[np.float32]


@dataclass
class DrawnLabel:
    """What viser has of a label, and the line from it to its body."""

    label: Any
    line: Any


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
        self._ghosts: dict[str, DrawnGhost] = {}
        self._labels: dict[tuple[str, ...], DrawnLabel] = {}
        self._acts: list[Any] = []
        self._acts_shown: list[Any] = []
        self._offset = np.zeros(3)
        self._name = TRUTH
        # viser's own lights, its map of surroundings to mirror, and both sides of a ghost cost a browser without a GPU
        # half of its pictures.
        self._api.configure_default_lights(enabled=False, cast_shadow=False)
        self._api.configure_environment_map(None)
        # As on the page a face is as bright as it looks at the light.
        self._light = self._api.add_light_hemisphere(
            "/light", sky_color=(255, 255, 255), ground_color=SHADE, intensity=LIGHT_INTENSITY
        )

    def set_up(self, scene: Scene, *, look: bool) -> None:
        """Build the scene, its body at the start; look: whether to move the camera to where all of it is in view."""
        turned = self._world is None or not np.array_equal(self._axes.up, axes(scene).up)
        with self._client.atomic():
            if self._world is not None:
                self._world.remove()  # and with it all that is in it
            self._acts, self._acts_shown, self._ghosts, self._labels = [], [], {}, {}
            self._scene, self._outline = scene, Outline.of(scene.body)
            self._axes = axes(scene)
            # Under a name of its own: a browser keeps the place of a name that comes back.
            self._worlds += 1
            self._space = Space.of(scene, f"/world{self._worlds}")
            self._world = self._api.add_frame(self._space.root, show_axes=False)
            self._beside = self._api.add_frame(f"{self._space.root}/beside", show_axes=False)
            self._printed: PrintedTable | None = None
            self._add_body()
            self._ground = Ground(self._api, scene, self._space)
            self._add_tethers()
            self._light.position = tuple(10.0 * np.array(LIGHT) @ np.stack(self._axes))
        if self._worlds == 1:  # there is something to click now
            self._api.on_click()(self._clicked)
        if look or turned:
            self._look()

    def _clicked(self, event: Any) -> None:
        place = self._space.meant(np.array(event.ray_origin) - self._offset)
        self._on_click(place.tolist(), event.ray_direction)

    def _look(self) -> None:
        """Put the camera where the whole body is in view, with room to move."""
        camera = self._client.camera
        is_narrow = camera.image_width < NARROW * camera.image_height
        position, target = first_view(self._scene, is_narrow=is_narrow)
        with self._client.atomic():
            camera.fov = FIELD_OF_VIEW
            camera.near, camera.far = 0.02, 2000.0
            camera.up_direction = tuple(self._axes.up)
            camera.position = tuple(self._space.drawn(position))
            camera.look_at = tuple(self._space.drawn(target))

    def follow(self, centre: Array | None) -> None:
        """Keep a place [m] where the body started, or let the world stand still."""
        self._offset = np.zeros(3) if centre is None else -self._space.drawn(centre)
        self._world.position = tuple(self._offset)

    def show_body(self, state: Array, vertices: Array, whose: str = "") -> None:
        """Put the solid body into a state, (13,), vertices [m], (n, 3); whose: its contestant, '' for the truth."""
        self._name = f"{whose}, no reference" if whose else TRUTH
        self._body.position, self._body.wxyz = tuple(self._space.drawn(state[0:3])), tuple(state[3:7])
        self._state, self._vertices = state, vertices
        colour = UNPROVEN if whose else TRUE
        if self._solid is not None and tuple(self._solid.color) != colour:
            self._solid.color = colour
        if self._tethers is not None:
            self._tethers.points = self._tether_lines(state)
        self._ground.follow(state[0:3])

    def show_path(self, centres: Array) -> None:
        """Draw the path of the true centre [m], (n, 3), as far as it is known."""
        self._ground.show_path(centres)

    def show_ghosts(self, ghosts: Mapping[str, Ghost], note: str = "") -> None:
        """Draw these ghosts and no others, with their names where they do not overlap; note: below each name."""
        for gone in set(self._ghosts) - set(ghosts):
            self._ghosts.pop(gone).frame.remove()
        for key, ghost in ghosts.items():
            shape = self._shape(ghost)
            if key not in self._ghosts:
                self._ghosts[key] = self._add_ghost(shape, ghost.colour)
            drawn = self._ghosts[key]
            drawn.frame.position, drawn.frame.wxyz = self._body.position, self._body.wxyz
            if np.abs(shape - drawn.shape).max() > SAME:
                drawn.edges.points, drawn.faces.vertices, drawn.shape = shape[self._outline.edges], shape, shape
            off = float(np.abs(ghost.vertices - self._vertices).max()) / self._space.radius
            for part, is_seen in ((drawn.edges, off > SEEN_APART), (drawn.faces, off > APART)):
                if part.visible != is_seen:
                    part.visible = is_seen
        self._show_labels(ghosts, note)

    def sees(self, vertices: Array) -> bool:
        """Whether any of these vertices [m], (n, 3), is in the picture."""
        return self._eye().sees(self._space.drawn(vertices))

    def _eye(self) -> Eye:
        """Return the browser's camera, in drawn coordinates."""
        camera = self._client.camera
        place, target = camera.position - self._offset, camera.look_at - self._offset
        return Eye.of(place, target, camera.up_direction, camera.fov, camera.image_width, camera.image_height)

    def _shape(self, ghost: Ghost) -> NDArray[np.float32]:
        """Return a ghost's corners as the true body sees them.

        A ghost is drawn in a frame that goes with the true body, which a browser moves at once; new corners cost it a
        frame, and in the body's own axes they change as slowly as the error grows.
        """
        turned = (ghost.vertices - self._state[0:3]) @ frames.rotation_matrix(self._state[3:7])
        return self._outline.points(turned / self._space.radius).astype(np.float32)

    def _add_ghost(self, shape: NDArray[np.float32], colour: Colour) -> DrawnGhost:
        self._ghosts_made += 1
        name = f"{self._space.root}/ghost{self._ghosts_made}"
        frame = self._api.add_frame(name, show_axes=False)
        edges = self._api.add_line_segments(
            f"{name}/edges", shape[self._outline.edges], colour, thickness=2.5, thickness_units="screen", visible=False
        )
        faces = self._api.add_mesh_simple(
            f"{name}/faces", shape, self._outline.faces, color=colour, opacity=GHOST_OPACITY, side="front",
            flat_shading=True, cast_shadow=False, receive_shadow=False, visible=False,
        )  # fmt: skip
        return DrawnGhost(frame, edges, faces, shape)

    def _show_labels(self, ghosts: Mapping[str, Ghost], note: str) -> None:
        """Label the bodies that do not overlap, the truth first."""
        bodies = {self._name: self._vertices, **{ghost.name: ghost.vertices for ghost in ghosts.values()}}
        bodies = {name: self._space.drawn(vertices) for name, vertices in bodies.items()}
        # As ghosts are in the body's axes, labels are beside its centre: they move with it at once.
        centre = self._space.drawn(self._state[0:3])
        self._beside.position = tuple(centre)
        colours = {ghost.name: ghost.colour for ghost in ghosts.values()}
        eye = self._eye()
        near = {name: vertices for name, vertices in bodies.items() if eye.sees(vertices)}
        found = labels(near, APART, eye, self._name, note)
        for gone in set(self._labels) - {one.names for one in found}:
            drawn = self._labels.pop(gone)
            drawn.label.remove()
            drawn.line.remove()
        for one in found:
            if one.names not in self._labels:
                self._labels[one.names] = self._add_label(colours.get(one.names[0], EDGE))
            drawn = self._labels[one.names]
            drawn.label.position = tuple(one.place - centre)
            for name, value in (("text", one.words), ("anchor", one.anchor)):
                if getattr(drawn.label, name) != value:
                    setattr(drawn.label, name, value)
            line = np.array([[one.tip - centre, one.place - centre]], dtype=np.float32)
            if np.abs(line - drawn.line.points).max() > SAME:
                drawn.line.points = line

    def _add_label(self, colour: Colour) -> DrawnLabel:
        self._ghosts_made += 1
        name = f"{self._beside.name}/label{self._ghosts_made}"
        nowhere = np.zeros((1, 2, 3), dtype=np.float32)
        return DrawnLabel(
            self._api.add_label(f"{name}/text", ""),
            self._api.add_line_segments(f"{name}/line", nowhere, colour, thickness=1.5, thickness_units="screen"),
        )

    def show_impulses(self, impulses: Sequence[tuple[Impulse, Array]]) -> None:
        """Draw each impulse as an arrow that ends where it hits [m], (3,), and a click's ray behind it."""
        key = [(impulse, *place) for impulse, place in impulses]
        if key == self._acts_shown:
            return
        for part in self._acts:
            part.remove()
        self._acts, self._acts_shown = [], key
        for number, (impulse, place) in enumerate(impulses):
            direction, hit = impulse.value / np.linalg.norm(impulse.value), self._space.drawn(place)
            name, size = f"{self._space.root}/impulse{number}", 0.022
            arrow = np.array([[hit - 0.9 * direction, hit]])
            self._acts += [
                self._api.add_arrows(
                    f"{name}/arrow", arrow, ACTS, shaft_radius=size, head_radius=3 * size, head_length=7 * size
                ),
                self._api.add_icosphere(f"{name}/hit", 1.6 * size, color=ACTS, position=tuple(hit)),
            ]
            if impulse.ray is not None:
                line = np.array([[self._space.drawn(impulse.ray.origin), hit]])
                ray = self._api.add_line_segments(f"{name}/ray", line, RAY, thickness=1.0, thickness_units="screen")
                self._acts.append(ray)

    def show_printed(self, instants: Array) -> None:
        """Mark the printed positions of Table 4.1 in its throw, seen through the body; instants: of the throw [s]."""
        self._printed = PrintedTable(self._api, self._space, instants)
        if self._solid is not None:
            self._solid.opacity = SEEN_THROUGH

    def show_printed_vertex(self, vertices: Array, true: Array) -> None:
        """Draw the vertex of Table 4.1 where it is, of vertices [m], (n, 3), and its true way, (k, n, 3)."""
        if self._printed is not None:
            self._printed.show(vertices, true)

    def _add_body(self) -> None:
        """Add the solid body."""
        body, start, radius = self._scene.body, self._scene.start[0], self._space.radius
        name = f"{self._space.root}/body"
        self._body = self._api.add_frame(name, show_axes=False, position=(0.0, 0.0, 0.0), wxyz=tuple(start[3:7]))
        self._state, self._vertices = start, frames.vertices(start, body.points)
        points = self._outline.points(body.points / radius)
        flat: Any = {"flat_shading": True, "cast_shadow": False, "receive_shadow": False}
        self._solid: Any = None
        if len(self._outline.faces):
            self._solid = self._api.add_mesh_simple(f"{name}/solid", points, self._outline.faces, color=TRUE, **flat)
        of_pips, triangles = pips(body)
        if len(triangles):
            self._api.add_mesh_simple(f"{name}/pips", of_pips / radius, triangles, color=PIP, **flat)
        edges = RAISED * points[self._outline.edges]
        self._api.add_line_segments(f"{name}/edges", edges, EDGE, thickness=1.4, thickness_units="screen")

    def _add_tethers(self) -> None:
        """Add a line for every tether, and a ball where it is fixed."""
        self._tethers: Any = None
        if self._scene.tethers:
            lines = self._tether_lines(self._scene.start[0])
            self._tethers = self._api.add_line_segments(
                f"{self._space.root}/tethers", lines, TETHER, thickness=3.0, thickness_units="screen"
            )
        for number, tether in enumerate(self._scene.tethers):
            self._api.add_icosphere(
                f"{self._space.root}/anchor{number}",
                0.05,
                color=TETHER,
                position=tuple(self._space.drawn(tether.anchor)),
            )

    def _tether_lines(self, state: Array) -> NDArray[np.float32]:
        """Return from where to where the tethers go at a state, (13,)."""
        held = frames.vertices(state, np.array([one.point_body for one in self._scene.tethers]))
        anchors = np.array([one.anchor for one in self._scene.tethers])
        return self._space.drawn(np.stack([anchors, held], axis=1)).astype(np.float32)
