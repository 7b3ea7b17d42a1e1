"""Engines of npm, each a program in its environment: laws, gyroscopic torque, limits, forces held, Table 4.1."""

import json
from dataclasses import replace

import numpy as np
import pytest
from apart import broken_laws, engine, flight, throw

from tumble.compare.judge.errors import Run
from tumble.compare.run.engines import environments, installing
from tumble.compare.run.engines.installing import install
from tumble.compare.run.engines.registry import BadEngine, names, package
from tumble.compare.run.running_engines import launched
from tumble.compare.run.status import Status
from tumble.scenarios.read import read_scene
from tumble.scenarios.truth import truth

ENGINES = [name for name in names() if package(name).installer == "npm"]
MOMENTS = (1.0, 2.0, 3.0)
SPIN = (0.2, 1.0, 0.3)


@pytest.mark.parametrize("name", ENGINES)
def test_it_keeps_the_laws(name):
    assert broken_laws(name) == {}


def test_table_4_1_lands_on_the_column_of_the_application(tumble):
    for name in ENGINES:
        with engine(name):
            pass
    done = tumble("compare", "table-4-1", *(word for name in ENGINES for word in ("-e", name)))
    rows = [line.split() for line in done.stdout.partition("columns printed in Table 4.1")[2].splitlines()]
    off = {row[0].partition(":")[0]: float(row[2]) for row in rows if len(row) == 3 and ":" in row[0]}
    assert {*off} == {*ENGINES}
    assert max(off.values()) <= 0.011, "0.0105 m is what rounding of the printed inputs leaves"


@pytest.mark.parametrize("name", ["rapier-js", "jolt", "ammo"])
def test_its_gyroscopic_torque_is_the_bodys_and_of_first_order(name):
    """A body of other moments, or a torque left out, would be as far off at half the step."""
    whole = replace(read_scene("brick-tumble"), gravity=None)
    scene = replace(whole, duration=2.5, times=whole.times[whole.times <= 2.5])
    true = truth(scene)
    with engine(name) as ours:
        errors = [
            float(
                Run(scene, name, ours.methods[0], dt, ours.simulate(scene, ours.methods[0], dt), true).distances.max()
            )
            for dt in (0.004, 0.002)
        ]
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.05)


@pytest.mark.parametrize(
    "contestant", ["cannon:semi-implicit-euler", "jolt:semi-implicit-euler+defaults", "ammo:rigidbody+defaults"]
)
def test_who_leaves_the_gyroscopic_torque_out_is_told(contestant):
    scene = replace(read_scene("brick-tumble"), gravity=None)
    name, _, method = contestant.partition(":")
    with engine(name, method) as ours:
        run = Run(scene, name, method, 0.002, ours.simulate(scene, method, 0.002), truth(scene))
    assert run.status is Status.FLAGGED
    assert "lost gyroscopic torque" in run.reason or "damped" in run.reason
    assert float(run.distances.max()) > 0.1


@pytest.mark.parametrize(
    ("contestant", "spin", "kept"),
    [
        ("rapier-js:tgs", 60.0, 15 * np.pi),  # pi/4 a step: nobody can lift it from JavaScript
        ("jolt:semi-implicit-euler", 60.0, 60.0),
        ("jolt:semi-implicit-euler+defaults", 60.0, 15 * np.pi * (1 - 0.05 / 60) ** 60),  # cut, and damped
        ("cannon:semi-implicit-euler", 60.0, 60.0),
        ("ammo:rigidbody", 60.0, None),  # Bullet turns the body by less and leaves w as it is
    ],
)
def test_its_limit_of_spin(contestant, spin, kept):
    name, _, method = contestant.partition(":")
    with engine(name, method) as ours:
        found = flight(ours, throw(w=(0.0, 0.0, spin)), 1 / 60, 1.0)
    assert found.states[-1, 0, 12] == pytest.approx(kept or spin, rel=1e-4)
    clamped = "clamped" in [finding.kind for finding in found.findings]
    assert clamped == (kept is not None and kept < spin)


def test_ammos_torque_is_not_cut_to_its_limit():
    """100 N m are reached by these moments at 10 rad/s; scaled, they are as right as a tenth as fast is."""
    ends = []
    with engine("ammo", "rigidbody") as ours:
        for factor in (1.0, 30.0):
            start = throw(w=tuple(factor * each for each in SPIN))
            ends.append(flight(ours, start, 0.001 / factor, 1.0 / factor, moments=MOMENTS, mass=1.0).states[-1, 0])
    np.testing.assert_allclose(ends[1][10:13] / 30.0, ends[0][10:13], rtol=0, atol=2e-5)


@pytest.mark.parametrize(("size", "told"), [(0.999e-6, True), (1.001e-6, False)])
def test_jolts_defaults_fly_another_body_where_moments_are_small_and_say_so(size, told):
    """Its settings have its masses scaled: that these fly alike is a law, which its file broke."""
    moments = tuple(size * np.array(MOMENTS) / np.linalg.norm(MOMENTS))
    with engine("jolt", "semi-implicit-euler+defaults") as shipped:
        found = flight(shipped, throw(w=SPIN), 1e-3, 0.1, mass=1.0, moments=moments)
    assert ("another-body" in [finding.kind for finding in found.findings]) == told


def test_a_small_body_that_should_move_and_does_not_is_frozen():
    with engine("jolt", "semi-implicit-euler") as ours:
        still = flight(ours, throw(v=(0.5, 0.0, 0.0), x=(1e5, 0.0, 0.0)), 1e-3, 0.1)  # 5e-4 m is below an ulp of 1e5
        assert [found.kind for found in still.findings] == ["frozen"]


@pytest.mark.parametrize("name", ENGINES)
def test_a_held_force_is_held_as_mujoco_holds_it(name):
    """All are semi-implicit Euler there, and a cube has no gyroscopic torque."""
    scene = read_scene("tether-undamped")
    true = truth(scene)
    worst = []
    with engine(name) as ours, launched(["mujoco:euler+held"]) as (mujoco,):
        for running_engine, method in ((ours, ours.methods[-1]), (mujoco, "euler+held")):
            assert method.endswith("+held")
            flown = running_engine.simulate(scene, method, scene.step)
            worst.append(float(Run(scene, name, method, scene.step, flown, true).distances.max()))
        assert str(ours.simulate(scene, ours.methods[0], scene.step)).startswith("skipped: it has none of these laws; ")
    assert worst[0] == pytest.approx(worst[1], rel=0.01)


def test_a_release_that_npm_has_not_leaves_nothing(monkeypatch, tmp_path):
    monkeypatch.setenv("TUMBLE_ENVIRONMENTS", str(tmp_path))
    with pytest.raises(BadEngine, match=r"^cannon@99\.0\.0: .*; nothing was kept$") as refused:
        install("cannon@99.0.0")
    assert "\n" not in str(refused.value)
    assert list(tmp_path.iterdir()) == []


def test_without_a_network_npm_leaves_nothing(monkeypatch, tmp_path):
    monkeypatch.setenv("TUMBLE_ENVIRONMENTS", str(tmp_path / "environments"))
    monkeypatch.setenv("npm_config_registry", "http://127.0.0.1:9/")  # nobody listens there
    monkeypatch.setenv("npm_config_cache", str(tmp_path / "cache"))
    with pytest.raises(BadEngine, match=r"cannon@0\.20\.0: .*not reached.*; nothing was kept$") as refused:
        install("cannon")
    assert "\n" not in str(refused.value)
    assert list((tmp_path / "environments").iterdir()) == []


def test_without_node_it_is_one_line(monkeypatch, tmp_path):
    monkeypatch.setenv("TUMBLE_ENVIRONMENTS", str(tmp_path))
    monkeypatch.setattr(installing.shutil, "which", lambda name: None)
    with pytest.raises(BadEngine, match=r"cannon@0\.20\.0: it needs node and npm, which are not here"):
        install("cannon")
    assert list(tmp_path.iterdir()) == []


def test_its_environment_says_what_it_is():
    with engine("cannon") as ours:
        assert ours.info.version == "0.20.0"
    (there,) = [one for one in environments.environments() if one.name == "cannon@0.20.0"]
    assert there.node.split(".")[0].isdigit()
    assert there.packages == ("cannon-es==0.20.0",)
    assert json.loads((environments.folder() / there.name / environments.MARK).read_text())["python"] == ""
