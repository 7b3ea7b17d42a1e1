"""What is drawn is where it is: corners of ghosts, however large or far the body; and whose the eye is."""

from types import SimpleNamespace

import numpy as np
import pytest
import viser

from tumble.lab import ground, outline
from tumble.lab.magnify import magnified
from tumble.lab.stage import Ghost, Stage
from tumble.scenarios import frames
from tumble.scenarios.read import read_scene

SCENE = read_scene("two-hits")
INK = (1, 2, 3)
OWN = np.array([7.0, 8.0, 9.0])  # where a person put the eye


class Recorded:
    """A scene of viser's that remembers what was added to it, by name."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene, self.added = scene, {}

    def __getattr__(self, kind: str):
        def add(name, *arguments, **options):
            handle = getattr(self._scene, kind)(name, *arguments, **options)
            self.added[name] = handle
            return handle

        return add if kind.startswith("add_") else getattr(self._scene, kind)


@pytest.fixture(scope="module")
def server():
    server = viser.ViserServer(host="127.0.0.1", port=18280, verbose=False)
    yield server
    server.stop()


@pytest.fixture
def client(server):
    server.scene.reset()
    camera = SimpleNamespace(image_width=1280, image_height=720, position=OWN, look_at=np.zeros(3))
    return SimpleNamespace(scene=Recorded(server.scene), atomic=server.atomic, camera=camera)


@pytest.fixture
def stage(client):
    stage = Stage(client, lambda *_: None)
    stage.set_up(SCENE, look=True)
    return stage


def drawn(client) -> np.ndarray:
    """Return the ends of the ghost's edges where the browser draws them, [m] in the scene."""
    (frame,) = (handle for name, handle in client.scene.added.items() if name.endswith("ghost1"))
    (edges,) = (handle for name, handle in client.scene.added.items() if name.endswith("ghost1/edges"))
    turned = edges.points @ frames.rotation_matrix(np.array(frame.wxyz)).T + np.array(frame.position)
    return turned * SCENE.body.reach + SCENE.start[0, 0:3]


@pytest.fixture
def later():
    """A state of the body some time on."""
    state = SCENE.start[0].copy()
    state[0:3] += 0.3, -0.2, 0.7
    state[3:7] = 0.5, 0.5, -0.5, 0.5
    return state


def test_a_ghost_is_drawn_where_its_corners_are(client, stage, later):
    vertices = frames.vertices(later, SCENE.body.points)
    stage.show_body(later, vertices)
    stage.show_ghosts({"one": Ghost(vertices, INK, "one")})
    assert drawn(client) == pytest.approx(vertices[outline.edges(SCENE.body)], abs=1e-6)


def test_a_ghost_is_where_its_corners_are_though_the_body_is_elsewhere(client, stage, later):
    vertices = frames.vertices(later, SCENE.body.points)
    stage.show_ghosts({"one": Ghost(vertices, INK, "one")})
    assert drawn(client) == pytest.approx(vertices[outline.edges(SCENE.body)], abs=1e-6)


def test_a_ghost_moves_on(client, stage, later):
    for state in (SCENE.start[0], later):
        vertices = frames.vertices(state, SCENE.body.points)
        stage.show_body(state, vertices)
        stage.show_ghosts({"one": Ghost(vertices + 0.01, INK, "one")})
    assert drawn(client) == pytest.approx(vertices[outline.edges(SCENE.body)] + 0.01, abs=1e-6)


def test_an_error_is_drawn_as_many_times_larger():
    true, seen = np.ones((8, 3)), np.ones((8, 3)) + np.array([0.001, 0.0, -0.002])
    assert magnified(true, seen, 10.0) - true == pytest.approx(np.tile([0.01, 0.0, -0.02], (8, 1)))
    assert np.array_equal(magnified(true, true, 1000.0), true)


def test_the_eye_is_put_at_a_scene_that_is_opened_and_left_where_one_is_edited(client, stage):
    assert not np.array_equal(client.camera.position, OWN)
    client.camera.position = OWN
    stage.set_up(SCENE, look=False)
    assert np.array_equal(client.camera.position, OWN)


def test_a_browser_is_given_lengths_of_the_body(client, stage):
    (solid,) = (handle for name, handle in client.scene.added.items() if name.endswith("/solid"))
    assert np.linalg.norm(solid.vertices, axis=1).max() == pytest.approx(1.0)


def names(client) -> list[list[str]]:
    """Return the lines of each label that says whose a body is."""
    labels = (handle for name, handle in client.scene.added.items() if name.endswith("/text"))
    return [label.text.split("\n") for label in labels]


def visible(client) -> list[bool]:
    """Return whether each ghost's edges are seen."""
    return [
        handle.visible for name, handle in client.scene.added.items() if "/ghost" in name and name.endswith("/edges")
    ]


def test_ghosts_that_are_seen_apart_are_named_and_the_others_with_the_body_that_they_are(client, stage, later):
    vertices = frames.vertices(later, SCENE.body.points)
    off = vertices - np.array([0.0, 0.1, 0.0])
    stage.follow(later[0:3])
    stage.show_body(later, vertices)
    stage.show_ghosts(
        {"a": Ghost(vertices + 1e-9, INK, "a"), "b": Ghost(off, INK, "b"), "c": Ghost(off + 1e-9, INK, "c")},
        "error x 10",
    )
    assert names(client) == [["truth", "a"], ["b", "c", "error x 10"]]
    assert visible(client) == [False, True, True]


def test_a_body_that_is_not_the_truth_is_not_called_so(client, stage, later):
    vertices = frames.vertices(later, SCENE.body.points)
    stage.follow(later[0:3])
    stage.show_body(later, vertices, "pybullet:multibody")
    stage.show_ghosts({"b": Ghost(vertices - 0.1, INK, "b")})
    assert names(client)[0] == ["pybullet:multibody, no reference"]


def test_what_falls_goes_past_lines_that_stay_where_they_are(client, stage, later):
    (wall,) = (handle for name, handle in client.scene.added.items() if name.endswith("/wall"))
    section = ground.section(SCENE.body.reach)
    for fallen in (0.0, 0.9, 7.3):
        state = later.copy()
        state[1] -= fallen
        stage.show_body(state, frames.vertices(state, SCENE.body.points))
        place = np.array(wall.position) * SCENE.body.reach + SCENE.start[0, 0:3]
        assert place[1] / section == pytest.approx(round(place[1] / section), abs=1e-9)
        assert abs(place[1] - state[1]) < section
        assert place[2] < state[2] - SCENE.body.reach  # behind the body, whichever way that goes
        heights = [handle.text for name, handle in client.scene.added.items() if "/height" in name]
        assert f"{round(state[1] / section) * section:g} m".replace("-", "\N{MINUS SIGN}") in heights


@pytest.mark.parametrize(("name", "is_walled"), [("two-hits", True), ("table-4-1-ray", False), ("floor-stiff", False)])
def test_only_what_falls_freely_has_a_wall(client, name, is_walled):
    stage = Stage(client, lambda *_: None)
    stage.set_up(read_scene(name), look=True)
    walls = [made for made in client.scene.added if made.endswith("/wall")]
    grounds = [made for made in client.scene.added if made.endswith("/ground")]
    assert (len(walls), len(grounds)) == (int(is_walled), int(not is_walled))


def test_a_click_comes_as_a_ray_in_the_scene_wherever_the_view_follows_the_body(client):
    rays = []
    stage = Stage(client, lambda *ray: rays.append(ray))
    stage.set_up(SCENE, look=True)
    stage.follow(SCENE.start[0, 0:3] + np.array([1.0, -20.0, 3.0]))
    eye = np.array([0.0, 0.0, 4.0])
    for entry in client.scene._scene._scene_pointer_cb:
        entry.callback(SimpleNamespace(ray_origin=tuple(eye), ray_direction=(0.0, 0.0, -1.0)))
    (origin, direction), *_ = rays
    centre = SCENE.start[0, 0:3] + np.array([1.0, -20.0, 3.0])
    assert origin == pytest.approx(centre + eye * SCENE.body.reach)
    assert tuple(direction) == (0.0, 0.0, -1.0)


@pytest.mark.parametrize("name", ["box-incline-slides", "die-thrown"])
def test_the_plane_is_drawn_where_it_is(client, name):
    scene = read_scene(name)
    Stage(client, lambda *_: None).set_up(scene, look=True)
    (grid,) = (handle for name, handle in client.scene.added.items() if name.endswith("/ground"))
    place = np.array(grid.position) * scene.body.reach + scene.start[0, 0:3]
    assert (place - scene.plane.point) @ scene.plane.normal == pytest.approx(0.0, abs=1e-6)
    assert frames.rotation_matrix(np.array(grid.wxyz)) @ (0, 0, 1) == pytest.approx(scene.plane.normal)
