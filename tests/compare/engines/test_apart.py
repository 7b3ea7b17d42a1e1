"""Engines in environments of their own, together: Table 4.1, forces that are held, and releases of one engine."""

import pytest
from apart import engine

from tumble.compare.judge.errors import Run
from tumble.compare.run.status import Status
from tumble.scenarios.read import read_scene
from tumble.scenarios.truth import truth

STEPS = (0.02, 0.01)  # long enough that no rounding shows
HELD = (
    "physx:pgs+held", "rapier:tgs+held", "dart:semi-implicit-euler+held", "drake:discrete+held", "ode:step+held",
)  # fmt: skip
NAMES = ("physx", "rapier", "drake", "dart", "ode")


@pytest.mark.parametrize("name", NAMES)
def test_table_4_1_lands_on_the_column_of_the_application(tumble, name):
    with engine(name):
        done = tumble("compare", "table-4-1", "-e", name)
    table = done.stdout.partition("columns printed in Table 4.1")[2]
    rows = [line.split() for line in table.splitlines() if line.startswith(f"{name}:")]
    assert rows
    for _, _, application in rows:
        assert float(application) <= 0.011, "0.0105 m is what rounding of the printed inputs leaves"


@pytest.mark.parametrize("method", HELD)
def test_a_held_force_is_held_as_mujoco_holds_it(method):
    """All are semi-implicit Euler there, and a cube has no gyroscopic torque."""
    scene = read_scene("tether-undamped")
    true = truth(scene)
    worst = {}
    for contestant in (method, "mujoco:euler+held"):
        name, _, kind = contestant.partition(":")
        with engine(name, kind) if name != "mujoco" else beside(contestant) as running_engine:
            flight = running_engine.simulate(scene, kind, scene.step)
        worst[contestant] = float(Run(scene, name, kind, scene.step, flight, true).distances.max())
    assert worst[method] == pytest.approx(worst["mujoco:euler+held"], rel=0.01)


def test_a_force_that_drake_holds_over_a_step_is_a_parabola_as_mujocos_is():
    """No step of a constant force is wrong, only the force is: both blow up, and by the same."""
    scene = read_scene("tether-undamped")
    with engine("drake", "rk5+held") as ours, beside("mujoco:rk4+held") as reference:
        found, expected = ours.simulate(scene, "rk5+held", 1e-5), reference.simulate(scene, "rk4+held", 1e-5)
    assert abs(found.vertices - expected.vertices).max() < 1e-9
    assert abs(found.vertices - truth(scene).vertices).max() > 1e-6


def test_drakes_simulator_as_it_ships_and_what_it_cannot_be_told():
    scene, forced = read_scene("brick-tumble"), read_scene("tether-undamped")
    with engine("drake", "error-controlled+defaults", "error-controlled") as ours:
        shipped, ours_error = (
            float(
                Run(scene, "drake", method, 0.0, ours.simulate(scene, method, scene.step), truth(scene)).distances.max()
            )
            for method in ours.methods
        )
        assert ours.simulate(forced, "error-controlled+defaults", 1e-3).status is Status.SKIPPED
    assert 1e-4 < shipped < 1.0, "an accuracy of 1e-4 a step"
    assert ours_error < 1e-6


def beside(contestant: str):
    from contextlib import contextmanager

    from tumble.compare.run.running_engines import launched

    @contextmanager
    def one():
        with launched([contestant], 60.0) as (running_engine,):
            yield running_engine

    return one()


def test_the_attitude_of_mujocos_rk4_went_from_order_two_to_four_in_release_four():
    scene = read_scene("brick-tumble")
    true = truth(scene)
    errors = {}
    for release in ("mujoco@3.10.0", "mujoco"):
        with engine(release, "rk4") if "@" in release else beside("mujoco:rk4") as running_engine:
            for dt in STEPS:
                flight = running_engine.simulate(scene, "rk4", dt)
                errors[release, dt] = float(Run(scene, release, "rk4", dt, flight, true).distances.max())
    gain = {name: errors[name, STEPS[0]] / errors[name, STEPS[1]] for name in ("mujoco@3.10.0", "mujoco")}
    assert gain["mujoco@3.10.0"] == pytest.approx(4, rel=0.1)
    assert gain["mujoco"] == pytest.approx(16, rel=0.1)


def test_an_older_release_has_the_methods_it_had():
    with engine("mujoco@3.10.0") as running_engine:
        assert "discrete" not in running_engine.info.methods
        assert running_engine.info.version == "3.10.0"
        assert running_engine.info.gyroscopic["implicitfast"] == "midpoint"
        assert running_engine.title == "mujoco@3.10.0"
