"""The rigid plane in MuJoCo and PyBullet: the friction cone, the rebound as the step falls, hulls and boxes."""

from dataclasses import replace
from types import ModuleType

import numpy as np
import pytest

from tumble.compare.run.engines import registry
from tumble.scenarios.frames import rotation_matrix
from tumble.scenarios.read import read_scene
from tumble.scenarios.scene import Scene, frozen_array

STOPS_AFTER = 2.0**2 / (2 * 0.4 * 9.81)  # m, of the catalogue's sliding boxes


def flown(engine: ModuleType, method: str, scene: Scene, dt: float, n: int) -> np.ndarray:
    """Return the state of the first throw after n steps of dt [s], (13,)."""
    world = engine.build(scene, method)
    engine.write(world, scene.start.copy())
    if hasattr(engine, "prepare"):
        engine.prepare(world, dt)
    engine.advance(world, n, dt)
    return engine.read(world)[0]


@pytest.mark.parametrize(
    ("contestant", "factor"),
    [
        ("mujoco:euler", np.sqrt(2.0)),
        ("mujoco:euler+elliptic", 1.0),
        ("mujoco:euler+noslip", 1.0),
        ("pybullet:multibody", 1.0),
        ("pybullet:rigidbody", 1.0),
    ],
)
def test_a_box_stops_at_45_degrees_as_its_friction_cone_has_it(contestant, factor):
    """At every step: mu N against the slip, or mu N along each edge of a pyramid."""
    name, _, method = contestant.partition(":")
    for dt in (0.002, 0.0005):
        scene = read_scene("box-slide-45")
        way = flown(registry.load(name), method, scene, dt, round(1 / dt))[0:3] - scene.start[0, 0:3]
        # A step late is v dt; MuJoCo's friction is viscous in the end.
        assert np.hypot(way[0], way[2]) == pytest.approx(factor * STOPS_AFTER, abs=2 * dt + 2e-3)
        assert np.arctan2(way[2], way[0]) == pytest.approx(np.pi / 4, abs=5e-3)  # the box wobbles


@pytest.mark.parametrize("contestant", ["mujoco:euler", "mujoco:rk4", "pybullet:multibody", "pybullet:rigidbody"])
def test_a_rebound_comes_nearer_with_the_step_wherever_in_a_step_it_begins(contestant):
    name, _, method = contestant.partition(":")
    engine, errors = registry.load(name), []
    for dt in (1e-3, 1e-4):
        off = []
        for height in (0.5, 0.77, 1.0, 1.31):
            scene = read_scene("ball-drop-half")
            start = scene.start.copy()
            start[0, 1] = 0.1 + height
            falls = np.sqrt(2 * height / 9.81)
            state = flown(engine, method, replace(scene, start=frozen_array(start)), dt, round(1.2 * falls / dt))
            rise = state[8] ** 2 + 2 * 9.81 * (state[1] - 0.1)  # of the speed with which it left the plane
            off.append(np.sqrt(rise / (2 * 9.81 * height)) - 0.5)
        errors.append(np.abs(off).max())
    assert errors[0] < 0.05
    # A contact that lasts as the root of the step gains a factor of three, one that takes a step ten.
    assert errors[1] < errors[0] / 2.5 + 1e-4


@pytest.mark.parametrize("contestant", ["mujoco:euler+elliptic", "pybullet:multibody", "pybullet:rigidbody"])
def test_the_hull_of_a_boxs_corners_strikes_as_the_box(contestant):
    name, _, method = contestant.partition(":")
    box = read_scene("die-corner-space")
    hull = replace(box, body=replace(box.body, shape="rigid", size=None))
    # 17.2 ms are until its first corner strikes; then another one does.
    one, other = (flown(registry.load(name), method, scene, 2e-6, 8640) for scene in (box, hull))
    assert np.abs(one[7:13] - box.start[0, 7:13])[3:].max() > 1.0, "it has struck"
    np.testing.assert_allclose(other, one, atol=1e-5 * np.abs(one).max())


def test_bullet_cuts_friction_and_says_so():
    scene = read_scene("box-slide-0")
    with pytest.raises(NotImplementedError, match="Bullet cuts the friction of a pair at 10"):
        registry.load("pybullet").build(replace(scene, plane=replace(scene.plane, friction=11.0)), "multibody")


def test_variants_of_contact_take_part_above_a_plane_alone_and_held_forces_where_one_acts():
    info = registry.engine_info("mujoco", registry.load("mujoco"))
    unused = {name: info.without_use(read_scene(name)) for name in ("two-hits", "box-slide-0", "tether-undamped")}
    assert unused["two-hits"] == {*info.forced, *info.contact}
    assert unused["box-slide-0"] == {*info.forced}
    assert unused["tether-undamped"] == {*info.contact}


@pytest.mark.parametrize(
    ("contestant", "keeps"),
    [
        ("pybullet:multibody", True),
        ("pybullet:rigidbody", True),
        ("mujoco:euler+elliptic", False),
        ("tumble:moreau", True),
    ],
)
def test_a_disc_in_steady_precession_keeps_its_tilt_in_bullet_and_stands_up_in_mujoco(contestant, keeps):
    """MuJoCo's rim slips, whatever the step, so that the disc stands up by 12 degrees in a second."""
    name, _, method = contestant.partition(":")
    scene, tilts = read_scene("disc-precesses"), []
    for dt in (5e-4, 2.5e-4):
        state = flown(registry.load(name), method, scene, dt, round(1 / dt))
        tilts.append(np.degrees(np.arccos(rotation_matrix(state[3:7])[1, 2])))
    if keeps:  # with an error that falls with the step
        assert abs(tilts[1] - 60) < 0.6 * abs(tilts[0] - 60) < 0.8
    else:
        assert min(tilts) > 71
        assert tilts[0] == pytest.approx(tilts[1], abs=0.5)
