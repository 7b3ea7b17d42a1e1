"""What is drawn is where it is: corners of ghosts, however large or far the body; and whose the eye is."""

from types import SimpleNamespace

import numpy as np
import pytest
import viser

from scenarios import frames
from scenarios.read import read_scene
from tumble.lab import outline
from tumble.lab.magnified import magnified
from tumble.lab.stage import PALETTE, Ghost, Stage

SCENE = read_scene("two-hits")


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
    camera = SimpleNamespace(image_width=1280, image_height=720, position="the user's own")
    return SimpleNamespace(scene=Recorded(server.scene), atomic=server.atomic, camera=camera)


@pytest.fixture
def stage(client):
    stage = Stage(client, lambda *_: None)
    stage.set_up(SCENE, look=True)
    return stage


def drawn(client) -> np.ndarray:
    """Return the ends of a ghost's edges where the browser draws them, [m] in the scene."""
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
    stage.show_ghosts({"one": Ghost(vertices, later, PALETTE[0])})
    assert drawn(client) == pytest.approx(vertices[outline.edges(SCENE.body)], abs=1e-6)


def test_corners_count_where_the_state_is_not_theirs(client, stage, later):
    vertices = frames.vertices(later, SCENE.body.points)
    stage.show_ghosts({"one": Ghost(vertices, SCENE.start[0], PALETTE[0])})
    assert drawn(client) == pytest.approx(vertices[outline.edges(SCENE.body)], abs=1e-6)


def test_a_ghost_moves_on(client, stage, later):
    for state in (SCENE.start[0], later):
        vertices = frames.vertices(state, SCENE.body.points)
        stage.show_ghosts({"one": Ghost(vertices, state, PALETTE[0])})
    assert drawn(client) == pytest.approx(vertices[outline.edges(SCENE.body)], abs=1e-6)


def test_an_error_is_drawn_as_many_times_larger():
    true, seen = np.ones((8, 3)), np.ones((8, 3)) + np.array([0.001, 0.0, -0.002])
    assert magnified(true, seen, 10.0) - true == pytest.approx(np.tile([0.01, 0.0, -0.02], (8, 1)))
    assert np.array_equal(magnified(true, true, 1000.0), true)


def test_the_eye_is_put_at_a_scene_that_is_opened_and_left_where_one_is_edited(client, stage):
    assert client.camera.position != "the user's own"
    client.camera.position = "the user's own"
    stage.set_up(SCENE, look=False)
    assert client.camera.position == "the user's own"


def test_a_browser_is_given_lengths_of_the_body(client, stage):
    (solid,) = (handle for name, handle in client.scene.added.items() if name.endswith("/solid"))
    assert np.linalg.norm(solid.vertices, axis=1).max() == pytest.approx(1.0)
