"""Tethers, drag and floors in the engines: by the laws of tumble.scenarios.scene, to the order of their methods.

The reference is written here in rotation matrices, by the definitions; no engine and no truth of ours has a part in it.
"""

import math
import subprocess
import sys
from dataclasses import replace
from functools import cache
from importlib import import_module
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from triaxial import GRAVITY, MASS, MOMENTS, THROWS, scene

from tumble.compare.run.asked import chosen
from tumble.compare.run.engines.registry import engine_info
from tumble.compare.run.running_engines import RunningEngine
from tumble.compare.run.status import Failure, Status
from tumble.compare.run.worker import Worker
from tumble.scenarios.frames import Array, rotation_matrix, vertices
from tumble.scenarios.mass import BOX_FACES, box_corners
from tumble.scenarios.scene import Body, Drag, Floor, Scene, Tether, frozen_array
from tumble.scenarios.wrench import wrench

T = 0.2  # s
EPS = np.finfo(float).eps
NORMAL = frozen_array((0.0, 0.6, 0.8))


def tether(damping: float, rest_length: float, point=(0.2, 0.075, 0.05)) -> Tether:
    return Tether(frozen_array(point), frozen_array((0.1, -0.5, 0.4)), 80.0, damping, rest_length)


# The floor is 3 m above the body's centre along its normal: every vertex stays below it, and no switch costs an order.
HEIGHT = float(NORMAL @ THROWS[0, 0:3]) + 3.0
FORCES: dict[str, dict] = {
    "spring": {"tethers": (tether(0.0, 0.0),)},
    "damped spring": {"tethers": (tether(4.0, 0.0),)},
    "line": {"tethers": (tether(0.0, 0.5),)},
    "damped line": {"tethers": (tether(4.0, 0.5),)},
    "drag": {"drag": Drag(3.0, 0.05)},
    "floor": {"floor": Floor(HEIGHT, NORMAL, 15.0, 0.0)},
    "damped floor": {"floor": Floor(HEIGHT, NORMAL, 15.0, 0.4)},
    "all": {
        "tethers": (tether(4.0, 0.5), tether(0.6, 0.0, (-0.2, 0.075, -0.05))),
        "drag": Drag(0.3, 0.02),
        "floor": Floor(HEIGHT, NORMAL, 15.0, 0.4),
    },
}


def pulled(name: str, start: Array = THROWS[:1]) -> Scene:
    """Return the triaxial box under gravity and the forces of that name."""
    return replace(scene(start, GRAVITY), **FORCES[name])


def slope(question: Scene, y: Array) -> Array:
    """Return the rates of x (3), R (9), v (3) and w in world axes (3), by the laws as they are defined."""
    body, drag = question.body, question.drag
    axes, v, w = y[3:12].reshape(3, 3), y[12:15], y[15:18]
    force, torque = np.zeros(3), np.zeros(3)
    for rope in question.tethers:
        lever = axes @ rope.point_body
        pull = tether_pull(rope, y[0:3] + lever, v + np.cross(w, lever))
        force, torque = force + pull, torque + np.cross(lever, pull)
    for point in body.points if question.floor else body.points[:0]:
        lever = axes @ point
        push = floor_push(question.floor, y[0:3] + lever, v + np.cross(w, lever))
        force, torque = force + push, torque + np.cross(lever, push)
    if drag:
        force, torque = force - drag.linear * v, torque - axes @ (drag.angular * (axes.T @ w))
    inertia = axes @ np.diag(body.moments) @ axes.T
    gravity = np.zeros(3) if question.gravity is None else question.gravity
    w_dot = np.linalg.solve(inertia, torque - np.cross(w, inertia @ w))
    rates = np.empty(18)
    rates[0:3], rates[3:12] = v, np.cross(w, axes.T).T.ravel()
    rates[12:15], rates[15:18] = gravity + force / body.mass, w_dot
    return rates


def tether_pull(rope: Tether, p: Array, p_dot: Array) -> Array:
    d = p - rope.anchor
    if rope.rest_length == 0:
        return -rope.stiffness * d - rope.damping * p_dot
    u = d / np.linalg.norm(d)
    return -(rope.stiffness * (np.linalg.norm(d) - rope.rest_length) + rope.damping * p_dot @ u) * u


def floor_push(ground: Floor | None, p: Array, p_dot: Array) -> Array:
    assert ground is not None
    y, y_dot = p @ ground.normal - ground.height, p_dot @ ground.normal
    return max(0.0, -ground.stiffness * y - ground.damping * y_dot) * ground.normal if y < 0 else np.zeros(3)


def packed(state: Array) -> Array:
    return np.concatenate((state[0:3], rotation_matrix(state[3:7]).ravel(), state[7:13]))


@cache
def true_vertices(name: str) -> Array:
    """Return where the vertices of the first throw are at T [m], (8, 3)."""
    question = pulled(name)
    y = solve_ivp(lambda t, y: slope(question, y), (0, T), packed(THROWS[0]), "DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    return y[0:3] + question.body.points @ y[3:12].reshape(3, 3).T


def flown(engine: ModuleType, question: Scene, method: str, n: int, dt: float) -> Array:
    """Return the states after n steps of dt [s], in a world of its own."""
    world = engine.build(question, method)
    engine.write(world, question.start.copy())
    engine.advance(world, n, dt)
    return engine.read(world)


def error(engine: ModuleType, name: str, method: str, n: int) -> float:
    """Return the largest distance of a vertex from where it should be after n steps [m]."""
    states = flown(engine, pulled(name), method, n, T / n)
    return float(np.linalg.norm(vertices(states, pulled(name).body.points)[0] - true_vertices(name), axis=-1).max())


def contestants(*names: str):
    """Yield every method of these engines, FORCED ones too, that supports a force."""
    for name in names:
        pytest.importorskip(name)
        engine = import_module(f"tumble.compare.engines.{name}")
        plain = engine.METHODS if name == "mujoco" else ()
        for method in (*plain, *engine.FORCED):
            yield pytest.param(engine, method, id=f"{name}:{method}")


def engine_of(name: str) -> ModuleType:
    pytest.importorskip(name)
    return import_module(f"tumble.compare.engines.{name}")


@pytest.mark.parametrize("name", FORCES)
@pytest.mark.parametrize(("engine", "method"), list(contestants("mujoco", "pybullet")))
def test_order_with_every_law(engine, method, name):
    order = 4 if method == "rk4" else 1
    coarse, fine = (error(engine, name, method, n) for n in ((64, 128) if order == 4 else (512, 1024)))
    assert coarse < 0.02
    assert math.log2(coarse / fine) == pytest.approx(order, abs=0.2), (coarse, fine)


@pytest.mark.parametrize("name", FORCES)
def test_scipy_keeps_its_tolerance_with_every_law(name):
    engine = engine_of("scipy")
    for tolerance in (1e-4, 1e-7, 1e-10):
        # One step is a fraction of a radian; errors add up over the few that 0.2 s are.
        assert error(engine, name, f"dop853@{tolerance:g}", 1) < 10 * tolerance, tolerance


@pytest.mark.parametrize(("name", "method", "within"), [("mujoco", "rk4", 1e-8), ("scipy", "dop853@1e-11", 1e-8)])
def test_drag_that_is_to_the_inertia_as_to_the_mass(name, method, within):
    """Then L falls as exp(-t c/m), whatever the attitude, and v as a parachute's."""
    engine, rate, t = engine_of(name), 0.7, 2.0
    cube = scene(THROWS[:1], GRAVITY, mass=2.0, moments=(0.3, 0.3, 0.3))
    state = flown(engine, replace(cube, drag=Drag(rate * 2.0, rate * 0.3)), method, 400, t / 400)[0]
    fall = np.array(GRAVITY) / rate
    np.testing.assert_allclose(state[7:10], fall + (THROWS[0, 7:10] - fall) * math.exp(-rate * t), rtol=0, atol=within)
    np.testing.assert_allclose(state[10:13], THROWS[0, 10:13] * math.exp(-rate * t), rtol=0, atol=within)


@given(
    x=st.tuples(*[st.floats(-3, 3)] * 3),
    q=st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: np.linalg.norm(q) > 0.1),
    motion=st.tuples(*[st.floats(-20, 20)] * 6),
    name=st.sampled_from(list(FORCES)),
)
@settings(derandomize=True, deadline=None, max_examples=150)
def test_wrench_is_that_of_the_definitions(x, q, motion, name):
    state = np.array([*x, *(np.array(q) / np.linalg.norm(q)), *motion])
    question = replace(pulled(name), gravity=None)
    force, torque = np.split(wrench(question)(state[np.newaxis])[0], 2)
    rates = slope(question, packed(state))
    axes = rotation_matrix(state[3:7])
    inertia = axes @ np.diag(MOMENTS) @ axes.T
    np.testing.assert_allclose(force, MASS * rates[12:15], rtol=0, atol=1e-10)
    gyroscopic = np.cross(state[10:13], inertia @ state[10:13])
    np.testing.assert_allclose(torque, inertia @ rates[15:18] + gyroscopic, rtol=0, atol=1e-10)


def test_wrench_of_a_line_without_length_and_of_a_vertex_above_the_floor_is_none():
    state = np.array([[0.1, -0.5, 0.4, 1, 0, 0, 0, 3.0, 0, 0, 0, 0, 0]])
    at_the_anchor = replace(scene(state), tethers=(tether(4.0, 0.5, (0.0, 0.0, 0.0)),))
    np.testing.assert_array_equal(wrench(at_the_anchor)(state), np.zeros((1, 6)))
    falling = np.array([[0.0, 1.0, 0.0, 1, 0, 0, 0, 0, -100.0, 0, 0, 0, 0]])
    above = replace(scene(falling), floor=Floor(0.0, frozen_array((0.0, 1.0, 0.0)), 1e3, 10.0))
    np.testing.assert_array_equal(wrench(above)(falling), np.zeros((1, 6)))


@pytest.mark.parametrize(
    ("name", "method"), [("mujoco", "euler"), ("pybullet", "multibody"), ("pybullet", "rigidbody")]
)
def test_held_is_one_kick_a_step(name, method):
    """The force at the start of a step is the change of momentum over it: also of the first one, in any attitude.

    For rigidbody it is not by itself: it turns a torque into a spin by the inertia of the attitude before.
    """
    engine, dt = engine_of(name), 1e-3
    at_rest = THROWS.copy()
    at_rest[:, 10:13] = 0.0
    question = replace(pulled("all", at_rest), gravity=None)
    world = engine.build(question, f"{method}+held")
    for turn in range(3):
        start = np.roll(at_rest, turn, axis=0)
        engine.write(world, start)
        engine.advance(world, 1, dt)
        gained = engine.read(world)[:, 7:13] - start[:, 7:13]
        for row, state, kick in zip(gained, start, wrench(question)(start), strict=True):
            axes = rotation_matrix(state[3:7])
            expected = dt * np.concatenate((kick[0:3] / MASS, axes @ ((axes.T @ kick[3:6]) / MOMENTS)))
            np.testing.assert_allclose(row, expected, rtol=0, atol=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("factor", [2.0**-60, 2.0**60])
@pytest.mark.parametrize(("engine", "method"), list(contestants("mujoco", "pybullet")))
def test_a_heavier_body_with_stronger_forces_flies_the_same(engine, method, factor):
    """2e-18 kg and 2e18 kg: the same bits, for masses and forces are scaled together."""
    question = pulled("all")
    body = question.body
    heavy = replace(
        question,
        body=replace(body, mass=factor * body.mass, moments=frozen_array(factor * body.moments)),
        tethers=tuple(
            replace(rope, stiffness=factor * rope.stiffness, damping=factor * rope.damping) for rope in question.tethers
        ),
        drag=Drag(factor * 0.3, factor * 0.02),
        floor=Floor(HEIGHT, NORMAL, factor * 15.0, factor * 0.4),
    )
    np.testing.assert_array_equal(flown(engine, heavy, method, 20, 0.01), flown(engine, question, method, 20, 0.01))


@pytest.mark.parametrize(("engine", "method"), list(contestants("mujoco", "pybullet")))
def test_laws_of_engines_hold_under_forces(engine, method):
    """Steps add up, writing forgets, throws are apart, and so are worlds."""
    near = THROWS.copy()
    near[:, 0:3] = THROWS[0, 0:3]
    question = pulled("all", near)
    world, other = engine.build(question, method), engine.build(pulled("floor", near[::-1]), method)
    engine.write(world, near[::-1])
    engine.write(other, near[::-1])
    engine.advance(world, 7, 0.003)
    engine.write(world, near)
    for n in (3, 1, 16):
        engine.advance(world, n, 0.003)
        engine.advance(other, n, 0.003)
    states = engine.read(world)
    np.testing.assert_array_equal(states, flown(engine, question, method, 20, 0.003))
    # discrete solves for all throws together, each to its tolerance.
    together = 1e-11 if method == "discrete" else 0.0
    for number, start in enumerate(near):
        alone = flown(engine, pulled("all", start[np.newaxis]), method, 20, 0.003)
        np.testing.assert_allclose(states[number], alone[0], rtol=0, atol=together)


SIDE = 1.0
CUBE = Body("box", 1.0, frozen_array([1 / 6] * 3), frozen_array(box_corners(np.full(3, SIDE))), BOX_FACES)


def longest_stable(engine: ModuleType, method: str, damping_ratio: float) -> float:
    """Return the largest w dt at which a unit cube on a stiff tether stays within a thousandfold of its energy.

    2500 steps; a vertex is stretched by 12 mm across its lever, which swings at w = sqrt(5.5 k) rad/s.
    """
    stiffness, across = 1e4, np.array((1.0, -1.0, 0.0)) / math.sqrt(2)
    rate = math.sqrt(5.5 * stiffness)
    corner = CUBE.points[7]
    start = np.array([[*(0.012 * across), 1.0, *[0.0] * 9]])
    rope = Tether(frozen_array(corner), frozen_array(corner), stiffness, 2 * damping_ratio * stiffness / rate, 0.0)
    question = replace(scene(start), body=CUBE, tethers=(rope,))
    world = engine.build(question, method)

    def energy() -> float:
        state = engine.read(world)
        d = vertices(state, corner[np.newaxis])[0, 0] - corner
        return float((state[0, 7:10] @ state[0, 7:10] + state[0, 10:13] @ state[0, 10:13] / 6 + stiffness * d @ d) / 2)

    def stable(turn: float) -> bool:
        engine.write(world, start)
        at_first = energy()
        for _ in range(25):
            engine.advance(world, 100, turn / rate)
            if not energy() < 1e3 * at_first:
                return False
        return True

    low, high = 0.5, 8.0
    while high / low > 1.01:
        middle = math.sqrt(low * high)
        low, high = (middle, high) if stable(middle) else (low, middle)
    return math.sqrt(low * high)


@pytest.mark.parametrize(
    ("name", "method", "damping_ratio", "limit"),
    [
        ("mujoco", "rk4", 0.0, 2.85),
        ("mujoco", "euler", 0.0, 2.0),
        ("mujoco", "implicitfast", 1.0, 4.8),
        ("mujoco", "euler+held", 0.0, 2.0),
        ("mujoco", "rk4+held", 1.0, 1.0),
        ("pybullet", "multibody+held", 0.0, 2.0),
        ("pybullet", "rigidbody+held", 1.0, 0.84),
    ],
)
def test_limits_of_stability(name, method, damping_ratio, limit):
    """As measured with scripts: a force that is a part of the model is stable further than the same one held."""
    assert longest_stable(engine_of(name), method, damping_ratio) == pytest.approx(limit, rel=0.03)


def test_discrete_has_no_limit():
    assert longest_stable(engine_of("mujoco"), "discrete", 0.0) > 7.5


@pytest.mark.parametrize("method", ["multibody", "rigidbody"])
def test_pybullet_says_that_it_has_no_such_laws(method):
    engine = engine_of("pybullet")
    for name in FORCES:
        with pytest.raises(NotImplementedError, match=rf"{method}\+held is given their force once a step"):
            engine.build(pulled(name), method)


def test_forced_methods_take_part_where_a_force_acts():
    def running_engine(*asked: str) -> RunningEngine:
        about = engine_info("pybullet", engine_of("pybullet"))
        methods = chosen("pybullet", list(asked) or [""], about)
        return RunningEngine("pybullet", "pybullet", methods, frozenset(asked), about, None)  # type: ignore[arg-type]

    plain = ("multibody", "rigidbody")
    assert running_engine().methods_for(scene()) == running_engine().methods_for(scene(gravity=GRAVITY)) == plain
    for name in FORCES:
        assert running_engine().methods_for(pulled(name)) == (*plain, "multibody+held", "rigidbody+held")
    named = running_engine("rigidbody+held", "multibody+defaults")
    assert named.methods_for(scene()) == ("rigidbody+held", "multibody+defaults")
    absent = RunningEngine("pybullet", "pybullet", ("",), frozenset(), Failure(Status.MISSING, "no module"), None)  # type: ignore[arg-type]
    assert absent.methods_for(scene()) == ("",)


@pytest.mark.parametrize(("engine", "method"), list(contestants("mujoco", "pybullet")))
def test_without_a_force_held_is_the_method_it_is_named_after(engine, method):
    plain, _, _ = method.partition("+")
    question = scene(gravity=GRAVITY)
    np.testing.assert_array_equal(flown(engine, question, method, 50, 0.01), flown(engine, question, plain, 50, 0.01))


def test_an_answer_under_forces_crosses_from_a_worker():
    with Worker("pybullet", 60.0) as worker:
        worker.describe()
        held = worker.simulate(replace(pulled("all"), times=frozen_array([T]), duration=T), "multibody+held", 1e-3)
        refused = worker.simulate(pulled("drag"), "multibody", 1e-3)
    assert not isinstance(held, Failure)
    assert np.linalg.norm(held.vertices[-1, 0] - true_vertices("all"), axis=-1).max() < 0.02
    assert isinstance(refused, Failure)
    assert str(refused).startswith("skipped: multibody has none of these laws itself")


def audited(name: str, question: Scene, method: str, n: int, dt: float) -> tuple[Array, list[tuple[str, str]]]:
    engine = engine_of(name)
    world = engine.build(question, method)
    engine.write(world, question.start.copy())
    engine.advance(world, n, dt)
    return engine.read(world), engine.audit(world)


def throw(v=(0.0, 0.0, 0.0), w=(0.0, 0.0, 0.0), x=(0.0, 0.0, 0.0)) -> Array:
    return np.array([[*x, 1.0, 0.0, 0.0, 0.0, *v, *w]])


def test_default_damping_and_limit_of_multibody_are_said():
    states, ((kind, note),) = audited("pybullet", scene(throw(v=(10, 0, 0))), "multibody+defaults", 240, 1 / 240)
    assert states[0, 7] == pytest.approx(6.90, abs=0.005)
    assert kind == "damped"
    assert note.startswith("damped: ")
    assert "0.44 at 10 m/s" in note

    states, notes = audited("pybullet", scene(throw(v=(150, 0, 0))), "multibody+defaults", 1, 1e-3)
    assert states[0, 7] == 100.0
    assert notes[1][0] == "clamped"
    assert notes[1][1].startswith("clamped: a velocity component reached 150")
    rope = Tether(frozen_array((0.0, 0.0, 0.0)), frozen_array((0.0, 0.0, 0.0)), 1e6, 0.0, 0.0)
    bound = replace(scene(throw(x=(1.0, 0.0, 0.0))), tethers=(rope,))
    states, notes = audited("pybullet", bound, "multibody+defaults", 50, 0.01)  # w dt = 6.5: a blow-up that is hidden
    assert np.isfinite(states).all()
    assert [note for note in notes if "reached 100;" in note[1]], notes
    wild, _ = audited("pybullet", bound, "multibody+held", 50, 0.01)
    assert abs(wild[0, 7]) > 1e6


def test_defaults_of_rigidbody_lose_the_torque_of_a_small_body():
    tumbling = throw(w=(1.0, 2.0, 0.5))
    small = scene(tumbling, mass=1e-6, moments=(1e-6, 2e-6, 3e-6))
    states, notes = audited("pybullet", small, "rigidbody+defaults", 100, 0.01)
    np.testing.assert_allclose(states[0, 10:13], tumbling[0, 10:13], rtol=0, atol=1e-12)
    assert ("lost-torque", "lost gyroscopic torque: det(I) = 6e-18 kg3 m6 is below 2.2e-16") in notes
    assert audited("pybullet", small, "rigidbody", 100, 0.01)[1] == []
    tiny = scene(tumbling, mass=1e-16, moments=(1e-17, 2e-17, 3e-17))
    said = audited("pybullet", tiny, "multibody+defaults", 1, 0.01)[1]
    assert [note for kind, note in said if kind == "lost-torque" and "its moment of 1e-17" in note]


@pytest.mark.parametrize("method", ["euler+defaults", "rk4+defaults", "implicitfast+defaults"])
def test_default_auto_reset_of_mujoco_is_said(method):
    far = scene(throw(x=(2e10, 0.0, 0.0), v=(1.0, 0.0, 0.0)))
    states, notes = audited("mujoco", far, method, 100, 0.01)
    assert states[0, 0] == 0.0
    assert [note for kind, note in notes if kind == "reset" and "QPOS" in note], notes
    kept, notes = audited("mujoco", far, method.removesuffix("+defaults"), 100, 0.01)
    assert kept[0, 0] == pytest.approx(2e10 + 1, rel=100 * EPS)
    assert not [note for note in notes if note[0] == "reset"]

    usual = scene(gravity=GRAVITY)
    states, notes = audited("mujoco", usual, method, 100, 0.01)
    assert notes == []
    np.testing.assert_allclose(
        states, flown(engine_of("mujoco"), usual, method.removesuffix("+defaults"), 100, 0.01), rtol=0, atol=1e-12
    )


def test_default_mujoco_refuses_a_body_that_its_compiler_does():
    flat = scene(throw(w=(1.0, 2.0, 0.5)), mass=1.0, moments=(1.0, 1.0, 10.0))
    with pytest.raises(NotImplementedError, match=r"MuJoCo refuses the body: .* A \+ B >= C"):
        engine_of("mujoco").build(flat, "rk4+defaults")
    flown(engine_of("mujoco"), flat, "rk4", 1, 0.01)


@pytest.mark.parametrize("name", ["mujoco", "pybullet"])
def test_a_free_flight_brings_no_compiler(name):
    pytest.importorskip(name)
    program = f"""
import sys
sys.path.insert(0, "tests/support")
from triaxial import scene
from tumble.compare.engines import {name} as engine
engine.build(scene(), engine.METHODS[0])
print("numba" in sys.modules)
"""
    run = subprocess.run(
        [sys.executable, "-c", program], cwd=Path(__file__).parents[3], capture_output=True, text=True, check=True
    )
    assert run.stdout.strip() == "False"
