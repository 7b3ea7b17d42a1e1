"""The rigid plane in engines that have an environment of their own: the pair's coefficients and the friction cone."""

from dataclasses import replace

import numpy as np
import pytest
from apart import engine

from tumble.compare.run.flight import Trajectory
from tumble.scenarios.frames import quaternion_product, rotation_matrix, vertices
from tumble.scenarios.lowest import lowest
from tumble.scenarios.read import read_scene
from tumble.scenarios.scene import Disc, Scene, frozen_array
from tumble.scenarios.truth import truth

DT = 0.001
# No axis of the world is one of the scene.
TURN = np.array([0.7, -0.3, 0.5, 0.4]) / np.linalg.norm([0.7, -0.3, 0.5, 0.4])
ROUND, PYRAMID = 1.0, 2**-0.5


def turned(name: str, duration: float) -> Scene:
    """Return a scene of one throw with the whole world turned, looked at when it ends."""
    scene, axes = read_scene(name), rotation_matrix(TURN)
    start = scene.start[0].copy()
    for part in (slice(0, 3), slice(7, 10), slice(10, 13)):
        start[part] = axes @ start[part]
    start[3:7] = quaternion_product(TURN[None], start[None, 3:7])[0]
    plane = replace(scene.plane, point=frozen_array(axes @ scene.plane.point), normal=frozen_array(axes[:, 1]))
    world = {"gravity": frozen_array(axes @ scene.gravity), "plane": plane, "start": frozen_array([start])}
    return replace(scene, duration=duration, times=frozen_array([duration]), written=None, **world)


def moved(running_engine, scene: Scene) -> np.ndarray:
    """Return how far the body is from its start, and its velocity, both in the axes of the scene file, (2, 3)."""
    found = running_engine.simulate(scene, running_engine.methods[0], DT)
    assert isinstance(found, Trajectory), found
    state, axes = found.states[-1, 0], rotation_matrix(TURN)
    return np.array([axes.T @ (state[0:3] - scene.start[0, 0:3]), axes.T @ state[7:10]])


@pytest.mark.parametrize(
    ("contestant", "restitution", "cone"),
    [
        ("rapier:tgs", 0.5, ROUND),
        ("dart:semi-implicit-euler", 0.5, ROUND),
        ("physx:tgs", 0.5, ROUND),
        ("ode:step", 0.5, PYRAMID),
        ("rapier-js:tgs", 0.5, ROUND),
        ("box3d:semi-implicit-euler", 0.5, ROUND),
        ("havok:semi-implicit-euler", 0.5, ROUND),
        ("cannon:semi-implicit-euler", 0.5, None),
        ("ammo:rigidbody", 0.5, None),
        ("jolt:semi-implicit-euler", 0.5, ROUND),
        ("dart:semi-implicit-euler+defaults", 0.25, None),  # the product of two materials with the pair's number
    ],
)
def test_a_ball_rebounds_and_a_box_stops_by_the_pairs_coefficients_wherever_up_is(contestant, restitution, cone):
    with engine(*contestant.split(":")) as ours:
        fall, up = moved(ours, turned("ball-drop-half", 0.55))
        stop, _ = moved(ours, turned("box-slide-22", 1.0)) if cone else (None, None)
    rebound = np.sqrt(up[1] ** 2 + 2 * 9.81 * (1.0 + fall[1])) / np.sqrt(2 * 9.81)
    # A step early or late is v dt of height: g dt of a speed of e v.  Engines have 1 % besides.
    assert rebound == pytest.approx(restitution, abs=9.81 * DT / (restitution * 4.43) + 0.01 * restitution)
    if cone:
        away = np.array([np.cos(np.pi / 8), 0.0, np.sin(np.pi / 8)]) * 2.0**2 / (2 * 0.4 * 9.81)
        if cone is ROUND:
            assert stop == pytest.approx(away, abs=2.5e-3)  # one step is v dt = 2 mm
        else:  # between the full force along an edge of the pyramid and sqrt 2 of it along a diagonal
            assert PYRAMID * 0.51 - 2.5e-3 < np.hypot(stop[0], stop[2]) < 0.51 - 2.5e-3


@pytest.mark.parametrize(
    ("contestant", "room"),
    [
        ("dart:semi-implicit-euler", 0.002),
        ("ode:step", 0.002),
        ("rapier:tgs", 0.002),
        ("rapier-js:tgs", 0.002),
        ("jolt:semi-implicit-euler", 0.002),
        ("drake:discrete+point", 0.002),
        ("ammo:rigidbody", 0.005),
        ("newton:xpbd", 0.005),
        ("drake:discrete", 0.05),  # soft over a face
        ("havok:semi-implicit-euler", 0.2),  # round at its rims
        ("physx:tgs", 0.1),  # the others are prisms
        ("cannon:semi-implicit-euler", 0.2),
        ("box3d:semi-implicit-euler", 0.2),
    ],
)
def test_a_disc_rolls_on_its_rim_wherever_up_is(contestant, room):
    scene = turned("disc-rolls", 0.2)
    true = truth(scene, False).states[-1, 0]
    with engine(*contestant.split(":")) as ours:
        found = ours.simulate(scene, contestant.split(":")[1], DT)
    assert isinstance(found, Trajectory), found
    off = vertices(found.states[-1], scene.body.points) - vertices(true[None], scene.body.points)
    assert np.linalg.norm(off, axis=-1).max() < room * scene.body.disc.radius
    low = scene.plane.normal @ (found.states[-1, 0, 0:3] - scene.plane.point)
    low += lowest(scene.body, found.states[-1, :, 3:7], scene.plane.normal)[0]
    assert abs(low) < 0.02 * scene.body.disc.radius, "another shape touches the plane"
    thin = replace(scene, body=replace(scene.body, disc=Disc(0.5, 0.0)))
    with engine(*contestant.split(":")) as ours:
        refused = ours.simulate(thin, contestant.split(":")[1], DT)
    assert "no disc without thickness" in str(refused)


@pytest.mark.parametrize("contestant", ["jolt:semi-implicit-euler", "physx:tgs"])
def test_a_hull_has_the_bodys_centre_of_mass_and_not_its_own(contestant):
    """A top of points precesses at m g h / (I w), with its nutation: the hull's own centre is a tenth lower."""
    scene = read_scene("top")
    with engine(*contestant.split(":")) as ours:
        found = ours.simulate(scene, ours.methods[0], DT / 4)
    assert isinstance(found, Trajectory), found
    true = next(one.value for one in truth(scene, False).contacts[0].observables if one.name == "mean precession")
    azimuth = np.unwrap(np.arctan2(-found.states[:, 0, 2], found.states[:, 0, 0]))
    assert (azimuth[-1] - azimuth[0]) / scene.duration == pytest.approx(true, rel=0.03)
