"""MuJoCo flies fairly: each trap is shown with the bare calls of a user's script, and shown to be handled."""

import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from triaxial import GRAVITY, MASS, MOMENTS, THROWS, scene

from tumble.scenarios.frames import Array, quaternion_product, rotation_matrix

engine = pytest.importorskip("tumble.compare.engines.mujoco")
mujoco = engine.mujoco

METHODS = pytest.mark.parametrize("method", engine.METHODS)
SCRIPT = """
<mujoco>
  <option timestep="{dt!r}" integrator="{integrator}" gravity="{gravity}"/>
  <worldbody> <body> <freejoint/> <inertial pos="0 0 0" mass="{mass!r}" diaginertia="{moments}"/> </body> </worldbody>
</mujoco>
"""


def script(
    integrator="RK4", dt=0.01, gravity=(0.0, 0.0, 0.0), mass=1.0, moments=(1.0, 2.0, 2.5)
) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """Return one free body as a user's script makes it, every setting but the integrator left as it is."""
    model = mujoco.MjModel.from_xml_string(
        SCRIPT.format(
            dt=dt,
            integrator=integrator,
            gravity=" ".join(map(repr, gravity)),
            mass=mass,
            moments=" ".join(map(repr, moments)),
        )
    )
    return model, mujoco.MjData(model)


def thrown(method: str, states: Array, *steps: tuple[int, float], **body):
    """Return a world after the steps (n, dt)."""
    world = engine.build(scene(states, **body), method)
    engine.write(world, states)
    for n, dt in steps:
        engine.advance(world, n, dt)
    return world


def throw(v=(0.0, 0.0, 0.0), w=(0.0, 0.0, 0.0), x=(0.0, 0.0, 0.0)) -> Array:
    """Return one throw with its axes along the world's, (1, 13)."""
    return np.array([[*x, 1.0, 0.0, 0.0, 0.0, *v, *w]])


def top(moments: tuple[float, float, float], state: Array, t: float) -> Array:
    """Return the exact attitude of a free symmetric top (moments A, A, C) after t [s], as a quaternion w x y z.

    It turns about the fixed L by |L| t / A and about its own axis by (1 - C/A) w3 t
    (Landau & Lifshitz, "Mechanics" (1976), section 33).
    """
    a, _, c = moments
    axes = rotation_matrix(state[3:7])
    w_body = axes.T @ state[10:13]
    momentum = axes @ (np.array(moments) * w_body)
    about_axis = np.array([0.0, 0.0, (1 - c / a) * w_body[2]])
    return quaternion_product(quaternion_product(turn(momentum / a * t), state[3:7]), turn(about_axis * t))


def turn(angles: Array) -> Array:
    angle = np.linalg.norm(angles)
    return np.array([math.cos(angle / 2), *(math.sin(angle / 2) * angles / angle)])


def attitude_error(q: Array, true: Array) -> float:
    """Return the angle between two attitudes [rad]; q and -q are one."""
    return 4 * math.asin(min(np.linalg.norm(q - true), np.linalg.norm(q + true)) / 2)


@METHODS
@given(n=st.integers(1, 200), dt=st.floats(1e-6, 0.05), heavy=st.booleans())
@settings(derandomize=True, deadline=None, max_examples=25)
def test_every_bit_is_that_of_a_bare_loop(method, n, dt, heavy):
    gravity = GRAVITY if heavy else None
    model, data = script(engine.INTEGRATORS[method], dt, gravity or (0.0, 0.0, 0.0), MASS, tuple(MOMENTS.tolist()))
    w_body = np.empty(3)
    mujoco.mju_rotVecQuat(w_body, THROWS[0, 10:13], THROWS[0, 3:7] * (1, -1, -1, -1))
    data.qpos[:] = THROWS[0, 0:7]
    data.qvel[:] = [*THROWS[0, 7:10], *w_body]
    for _ in range(n):
        mujoco.mj_step(model, data)
    w_world = np.empty(3)
    mujoco.mju_rotVecQuat(w_world, data.qvel[3:6], data.qpos[3:7])
    world = thrown(method, THROWS[:1], (n, dt), gravity=gravity)
    np.testing.assert_array_equal(engine.read(world)[0], [*data.qpos, *data.qvel[0:3], *w_world])
    assert engine.audit(world) == []


@METHODS
def test_angular_velocity_is_in_world_axes(method):
    """Bodies in different attitudes with one w about a principal axis of a sphere keep it, and turn about it."""
    start = THROWS.copy()
    start[:, 10:13] = w = np.array([0.0, 0.0, 2.0])
    world = thrown(method, start, (100, 0.01), moments=(0.01, 0.01, 0.01))
    assert not np.allclose(world.data.qvel[3:6], w)  # MuJoCo's own are in body axes
    states = engine.read(world)
    np.testing.assert_allclose(states[:, 10:13], start[:, 10:13], rtol=0, atol=1e-12)
    for state, before in zip(states, start, strict=True):
        assert attitude_error(state[3:7], quaternion_product(turn(w * 1.0), before[3:7])) < 1e-12


@pytest.mark.parametrize(("method", "order"), [(method, 4 if method == "rk4" else 1) for method in engine.METHODS])
def test_order_of_the_attitude(method, order):
    """Against the exact symmetric top; 4 for RK4 is new in MuJoCo 4, and the others leave out half of a step."""
    moments = (0.012, 0.012, 0.03)
    errors = []
    for n in (128, 256) if order == 4 else (1024, 2048):
        q = engine.read(thrown(method, THROWS[:1], (n, 2.0 / n), moments=moments))[0, 3:7]
        errors.append(attitude_error(q, top(moments, THROWS[0], 2.0)))
    assert math.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.2), errors


def test_a_state_beyond_1e10_is_not_thrown_away():
    far = throw(x=(2e10, 0.0, 0.0), v=(1.0, 0.0, 0.0))
    model, data = script()
    data.qpos[:], data.qvel[:] = far[0, 0:7], far[0, 7:13]
    mujoco.mj_step(model, data, 100)
    assert data.qpos[0] == 0.0  # back to the model's start, at rest
    assert data.time == pytest.approx(1.0)  # which the time need not show

    for method in engine.METHODS:
        world = thrown(method, far, (100, 0.01))
        np.testing.assert_allclose(engine.read(world)[0, [0, 7]], (2e10 + 1, 1.0), rtol=100 * np.finfo(float).eps)
        assert [text for kind, text in engine.audit(world) if kind == "bad-number" and "QPOS" in text]


@METHODS
def test_a_fast_spin_is_right(method):
    """Its gyroscopic acceleration is beyond 1e10 rad/s2: reported, not reset."""
    moments = (0.012, 0.012, 0.03)
    start = throw(w=(2e6, 1e6, 3e6))
    world = thrown(method, start, (1, 1e-12), moments=moments)
    assert attitude_error(engine.read(world)[0, 3:7], top(moments, start[0], 1e-12)) < 1e-10
    assert [note for note in engine.audit(world) if "QACC" in note[1]]


def test_a_reset_is_flagged():
    world = thrown("euler", THROWS, (100, 0.01))
    assert engine.audit(world) == []
    mujoco.mj_resetData(world.model, world.data)
    engine.advance(world, 10, 0.01)
    ((kind, note),) = engine.audit(world)
    assert kind == "reset"
    assert note.endswith("the state was reset")


def test_time_is_not_called_a_reset_for_its_rounding():
    world = thrown("euler", throw(), (100_000, 0.1))
    assert world.data.time != world.elapsed
    assert engine.audit(world) == []


@pytest.mark.parametrize(
    ("moments", "refusal"),
    [
        ((1.0, 1.0, 10.0), "A \\+ B >= C"),
        ((2e-20, 2e-20, 3e-20), "must be larger than mjMINVAL"),
        ((1e-30, 1e-30, 1e-31), "must be larger than mjMINVAL"),
    ],
)
def test_what_its_compiler_refuses_flies_as_exactly_as_any_other(moments, refusal):
    with pytest.raises(ValueError, match=refusal):
        script(moments=moments)
    start = throw(w=(1.0, 2.0, 0.5))
    world = thrown("rk4", start, (2000, 0.001), mass=moments[0], moments=moments)
    assert attitude_error(engine.read(world)[0, 3:7], top(moments, start[0], 2.0)) < 1e-9
    assert engine.audit(world) == []


def test_moments_set_after_compilation_need_its_constants():
    moments = (2.0, 2.0, 3.0)
    start = throw(w=(1.0, 2.0, 0.5))
    model, data = script(moments=(1.0, 1.0, 1.0))
    model.body_inertia[1] = moments
    data.qvel[3:6] = start[0, 10:13]
    mujoco.mj_step(model, data, 200)
    true = top(moments, start[0], 2.0)
    assert attitude_error(data.qpos[3:7], true) > 0.1

    states = engine.read(thrown("rk4", start, (200, 0.01), moments=moments))
    assert attitude_error(states[0, 3:7], true) < 1e-6


@METHODS
def test_divergence_comes_out_and_leaves_no_trace(method):
    steps = (2000, 0.05)
    wild = THROWS.copy()
    wild[1, 7:10] = np.inf
    world = thrown(method, wild, steps)
    states = engine.read(world)
    assert not np.isfinite(states[1]).all()
    np.testing.assert_array_equal(states[0], engine.read(thrown(method, wild[:1], steps))[0])
    assert engine.audit(world)

    engine.write(world, THROWS)
    assert engine.audit(world) == []
    engine.advance(world, 10, 0.05)
    np.testing.assert_array_equal(engine.read(world), engine.read(thrown(method, THROWS, (10, 0.05))))


def test_warnings_are_not_printed_and_leave_no_file(tmp_path):
    blow_up = """
import mujoco
model = mujoco.MjModel.from_xml_string('<mujoco><worldbody><body><freejoint/>'
    '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body></worldbody></mujoco>')
data = mujoco.MjData(model)
data.qpos[0] = 1e11
mujoco.mj_step(model, data)
"""

    def said(program: str) -> tuple[str, list[str]]:
        words = [sys.executable, "-c", program]
        root = str(Path(__file__).parents[3])
        run = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=True, env={"PYTHONPATH": root})
        return run.stdout + run.stderr, [path.name for path in tmp_path.iterdir()]

    assert said("import tumble.compare.engines.mujoco" + blow_up) == ("", [])
    printed, files = said(blow_up)
    assert "WARNING" in printed
    assert files == ["MUJOCO_LOG.TXT"]


def test_room_reserved_grows_with_the_throws_only():
    many = engine.build(scene(THROWS[:1].repeat(300, axis=0)), "rk4").model
    assert many.nbody == 301
    assert many.narena == 4 << 20
