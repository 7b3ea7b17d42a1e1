"""One table of force laws: what acts, what is stored, what is lost, what is stiff, all asked of the same entries."""

from dataclasses import dataclass, fields, replace

import numpy as np
import pytest

from tumble.compare.judge.balance import moving_and_stored
from tumble.compare.stability.columns import PARAMETERS
from tumble.scenarios.forces import GRAVITY, LAWS, Law, acting, can_turn, stiffness, stored, takes_energy
from tumble.scenarios.needs import FORCES, needs
from tumble.scenarios.read import catalogue, read_scene
from tumble.scenarios.scene import Drag, Scene
from tumble.scenarios.wrench import wrench

FORCED = [name for name in catalogue() if not read_scene(name).is_free]


def test_every_part_of_a_scene_that_can_pull_has_its_entry():
    parts = {law.part for law in LAWS}
    assert parts <= {item.name for item in fields(Scene)}
    optional = {item.name for item in fields(Scene) if item.default is None or item.default == ()}
    assert optional - parts == {"ensemble", "impulses", "sensors", "written"}


def test_who_asks_asks_the_table():
    assert tuple(law.name for law in LAWS) == FORCES
    numbers = {(law, key) for law in LAWS for key in law.numbers.values()}
    assert {(each.law, each.key) for each in PARAMETERS if each.law} == numbers


@dataclass(frozen=True, eq=False)
class Held(Scene):
    """A scene with a spring of stiffness [N/m] that holds the centre of mass at the origin."""

    hold: Drag | None = None


def test_an_entry_more_is_asked_by_all(monkeypatch):
    law = Law(
        "hold",
        "hold",
        stored=lambda hold, scene, states: hold.linear / 2 * (states[..., 0:3] ** 2).sum(axis=-1),
        takes=lambda hold: bool(hold.angular),
        turns=lambda hold: True,
        stiffness=lambda hold, scene: hold.linear,
        numbers={"hold [N/m]": "linear"},
    )
    monkeypatch.setattr("tumble.scenarios.forces.LAWS", (*LAWS, law))
    fallen = read_scene("die-straight")
    scene = Held(**{item.name: getattr(fallen, item.name) for item in fields(fallen)}, hold=Drag(80.0, 0.0))
    assert not scene.is_free
    assert "rotation" in needs(scene)  # for all that is known, it turns
    assert (takes_energy(scene), can_turn(scene), stiffness(scene)) == (False, True, 80.0)
    assert takes_energy(replace(scene, hold=Drag(80.0, 0.1)))
    away = scene.start + np.eye(13)[0]
    assert moving_and_stored(away, scene) - moving_and_stored(scene.start, scene) == pytest.approx(
        40.0 * (away[0, 0:3] @ away[0, 0:3] - scene.start[0, 0:3] @ scene.start[0, 0:3])
    )
    assert stiffness(law.scaled(scene, 3.0)) == 240.0


@pytest.mark.parametrize("name", catalogue())
def test_a_scene_is_free_where_nothing_but_gravity_acts(name):
    scene = read_scene(name)
    assert [law.name for law in acting(scene)] == [need for need in needs(scene) if need in FORCES]
    assert scene.is_free == (not scene.tethers and scene.drag is None and scene.floor is None)
    bare = replace(scene, tethers=(), drag=None, floor=None)
    assert bare.is_free
    assert not takes_energy(bare)


@pytest.mark.parametrize("name", FORCED)
def test_what_is_stored_pulls_as_the_law_says(name):
    """The force is minus the slope of the energy: differences along each axis, of a body that does not move."""
    scene = read_scene(name)
    lifted = scene.start[:1].copy()
    lifted[:, 7:13] = 0.0
    if scene.floor is not None:
        lifted[:, 0:3] -= scene.floor.normal * (lifted[0, 0:3] @ scene.floor.normal - scene.floor.height)
    step, slope = 1e-6, np.zeros(3)
    for axis in range(3):
        there, here = lifted.copy(), lifted.copy()
        there[0, axis] += step
        here[0, axis] -= step
        slope[axis] = (stored(scene, there, but=GRAVITY) - stored(scene, here, but=GRAVITY))[0] / (2 * step)
    force = wrench(scene)(lifted)[0, 0:3]
    # Of quadratic energies a central difference is exact but for rounding: eps E / step.
    rounding = 1e-15 * max(1.0, float(stored(scene, lifted)[0])) / step
    np.testing.assert_allclose(-slope, force, atol=4 * rounding + 1e-9 * np.abs(force).max(initial=1.0))


def test_height_is_stored_by_gravity():
    scene = read_scene("die-vertex")
    assert GRAVITY in acting(scene)
    states = np.repeat(scene.start[:1], 2, axis=0)
    states[1, 0:3] -= scene.gravity / np.linalg.norm(scene.gravity)
    low, high = stored(scene, states)
    assert high - low == pytest.approx(scene.body.mass * np.linalg.norm(scene.gravity), rel=1e-12)
