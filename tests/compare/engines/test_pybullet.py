"""PyBullet flies fairly: each trap is shown with the bare calls of a user's script, and shown to be handled."""

import gc
import math
import subprocess
import sys
import weakref
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from triaxial import GRAVITY, MASS, MOMENTS, THROWS, scene

from tumble.compare.run.flight import simulate
from tumble.scenarios.frames import Array, rotation_matrix
from tumble.scenarios.read import read_scene

engine = pytest.importorskip("tumble.compare.engines.pybullet")
pybullet = engine.pybullet

METHODS = pytest.mark.parametrize("method", engine.METHODS)
EPS = np.finfo(float).eps


class Script:
    """A server with one box in it, by the calls a user's script makes; `dynamics` are its settings."""

    def __init__(self, method: str, **dynamics):
        self.client = pybullet.connect(pybullet.DIRECT)
        weakref.finalize(self, pybullet.disconnect, self.client)
        self.box = self.createCollisionShape(pybullet.GEOM_BOX, halfExtents=(0.5, 0.5, 0.5))
        self.body = self.add(method, **dynamics)

    def __getattr__(self, function: str):
        """Return PyBullet's function, for this server."""
        return partial(getattr(pybullet, function), physicsClientId=self.client)

    def add(self, method: str, **dynamics) -> int:
        body = self.createMultiBody(1.0, self.box, useMaximalCoordinates=method == "rigidbody")
        self.changeDynamics(body, -1, **dynamics)
        return body

    def throw(self, state: Array) -> None:
        x, (w, *xyz), v, spin = np.split(state, (3, 7, 10))
        self.resetBasePositionAndOrientation(self.body, x, [*xyz, w])
        self.resetBaseVelocity(self.body, v, spin)

    def step(self, n: int, dt: float) -> None:
        self.setTimeStep(dt)
        for _ in range(n):
            self.stepSimulation()

    @property
    def state(self) -> Array:
        x, (*xyz, w) = self.getBasePositionAndOrientation(self.body)
        return np.hstack((x, w, xyz, *self.getBaseVelocity(self.body)))


UNDAMPED = {"mass": 1.0, "localInertiaDiagonal": (1, 2, 3), "linearDamping": 0, "angularDamping": 0}


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


@METHODS
@given(n=st.integers(1, 200), dt=st.floats(1e-6, 0.05), heavy=st.booleans())
@settings(derandomize=True, deadline=None, max_examples=25)
def test_every_bit_is_that_of_a_bare_loop(method, n, dt, heavy):
    gravity = GRAVITY if heavy else None
    script = Script(method, **UNDAMPED | {"mass": MASS, "localInertiaDiagonal": list(MOMENTS)})
    script.setGravity(*gravity or (0, 0, 0))
    script.throw(THROWS[0])
    script.step(n, dt)
    world = thrown(method, THROWS[:1], (n, dt), gravity=gravity)
    np.testing.assert_array_equal(engine.read(world)[0], script.state)


@METHODS
def test_substeps_are_not_lost(method):
    script = Script(method, **UNDAMPED)
    script.setPhysicsEngineParameter(fixedTimeStep=0.1, numSubSteps=11)
    assert int(0.1 / (0.1 / 11)) == 10
    script.throw(throw(v=(1.1, 0, 0))[0])
    script.stepSimulation()
    assert script.state[0] == pytest.approx(0.1)  # ten substeps of eleven

    world = thrown(method, throw(v=(1.1, 0, 0)), (11, 0.1 / 11))
    assert engine.read(world)[0, 0] == pytest.approx(0.11)


def test_nothing_is_damped():
    script = Script("multibody")
    script.throw(throw(v=(10, 0, 0))[0])
    script.step(240, 1 / 240)
    assert script.state[7] == pytest.approx(6.90, abs=0.005)

    for method in engine.METHODS:
        states = engine.read(thrown(method, throw(v=(10, 0, 0), w=(0, 0, 5)), (240, 1 / 240)))
        np.testing.assert_allclose(states[0, 7:13], (10, 0, 0, 0, 0, 5), rtol=0, atol=1e-13)


def test_velocity_has_no_limit():
    script = Script("multibody", **UNDAMPED)
    script.throw(throw(v=(150, 0, 0), w=(0, 0, 150))[0])
    script.step(2, 1e-5)
    assert (script.state[[7, 12]] == 100).all()

    for method in engine.METHODS:
        world = thrown(method, throw(v=(1e9, 0, 0), w=(0, 0, 1e4)), (1000, 1e-5))
        np.testing.assert_allclose(engine.read(world)[0, [0, 7, 12]], (1e7, 1e9, 1e4), rtol=1e-12)
        assert engine.audit(world) == []


def test_mass_is_set_with_the_moments():
    script = Script("rigidbody", localInertiaDiagonal=(1, 2, 3))
    assert script.getDynamicsInfo(script.body, -1)[0] != 1.0

    for method in engine.METHODS:
        world = thrown(method, THROWS, (1, 0.01))
        assert engine.audit(world) == []
        pybullet.changeDynamics(world.bodies[1], -1, mass=2 * world.mass, physicsClientId=world.client)
        ((kind, note),) = engine.audit(world)
        assert kind == "another-body"
        assert note.startswith("throw 1 has mass and moments [2. ")


@METHODS
def test_a_torque_meets_the_inertia_of_the_pose_written(method):
    torque = np.array([1.0, 2.0, -1.0])

    def gained(client: int, body: int, mass: float = 1.0) -> Array:
        asked = mass * torque / 1e-3  # the body may have been scaled by its mass
        pybullet.applyExternalTorque(body, -1, asked, pybullet.WORLD_FRAME, physicsClientId=client)
        pybullet.setPhysicsEngineParameter(fixedTimeStep=1e-3, numSubSteps=1, physicsClientId=client)
        pybullet.stepSimulation(physicsClientId=client)
        return np.array(pybullet.getBaseVelocity(body, physicsClientId=client)[1])

    script = Script(method, **UNDAMPED)
    script.throw(throw()[0])
    raw = (6.0 if method == "rigidbody" else 1 / np.array([1, 2, 3])) * torque
    np.testing.assert_allclose(gained(script.client, script.body), raw, rtol=1e-12)

    world = engine.build(scene(mass=1.0, moments=(1.0, 2.0, 3.0)), method)
    for turn in (0, 1, 2):  # the same body in one pose after another
        at_rest = np.roll(THROWS, turn, axis=0)
        at_rest[:, 7:] = 0.0
        engine.write(world, at_rest)
        axes = rotation_matrix(at_rest[0, 3:7])
        expected = axes @ ((axes.T @ torque) / (1, 2, 3))
        got = gained(world.client, world.bodies[0], world.mass)
        np.testing.assert_allclose(got, expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize(("method", "tiny"), [("rigidbody", 1e-6), ("multibody", 1e-17)])
def test_a_tiny_body_tumbles_as_a_large_one(method, tiny):
    tumbling = throw(w=(1.0, 2.0, 0.5))
    script = Script(method, **UNDAMPED | {"localInertiaDiagonal": (tiny, 2 * tiny, 3 * tiny)})
    script.throw(tumbling[0])
    script.step(100, 0.01)
    np.testing.assert_allclose(script.state[10:13], (1.0, 2.0, 0.5), rtol=0, atol=1e-12)  # no gyroscopic torque

    large = engine.read(thrown(method, tumbling, (100, 0.01), mass=1.0, moments=(1.0, 2.0, 3.0)))
    assert abs(large[0, 10] - 1.0) > 0.5
    for scale in (tiny, 1e-30, 1e30):
        moments = (scale, 2 * scale, 3 * scale)
        small = engine.read(thrown(method, tumbling, (100, 0.01), mass=scale, moments=moments))
        np.testing.assert_allclose(small, large, rtol=0, atol=1e-13)


@METHODS
def test_turning_too_little_is_flagged(method):
    """Beyond pi/4 a step turns by less than |w| dt: the note says by how much, and says nothing below."""
    for rate in (0.78, 0.79, 1.0, 2.0):
        world = thrown(method, throw(w=(0, 0, rate)), (1, 1.0))
        state = engine.read(world)[0]
        turned = 2 * math.atan2(state[6], state[3])
        notes = engine.audit(world)
        if rate < math.pi / 4:
            assert turned == pytest.approx(rate, rel=1e-14)
            assert notes == []
        else:
            assert turned < rate
            assert f"= {turned:.3g} rad a step instead of |w|dt = {rate:.3g} rad" in notes[0][1]


@METHODS
def test_the_worst_turn_is_remembered_until_the_next_write(method):
    world = thrown(method, throw(w=(0, 0, 30.0)), (10, 0.05))
    assert len(engine.audit(world)) == 1
    engine.write(world, throw(w=(0, 0, 1.0)))
    engine.advance(world, 10, 0.05)
    assert engine.audit(world) == []


@METHODS
def test_nothing_falls_asleep(method):
    script = Script(method, **UNDAMPED, activationState=pybullet.ACTIVATION_STATE_ENABLE_SLEEPING)
    script.throw(throw(v=(1e-3, 0, 0))[0])
    script.step(100, 0.1)
    assert script.state[0] < 5e-3  # asleep after 2 s

    states = engine.read(thrown(method, throw(v=(1e-3, 0, 0)), (100, 0.1)))
    assert states[0, 0] == pytest.approx(0.01, rel=1e-12)


@METHODS
def test_standing_still_is_flagged(method):
    assert engine.audit(thrown(method, throw(v=(1, 0, 0)))) == []  # has not been asked to move
    assert engine.audit(thrown(method, throw(), (5, 0.01))) == []  # has no velocity
    # At 1e17 m a hundredth of a metre is below an ulp.
    ((kind, note),) = engine.audit(thrown(method, throw(v=(1, 0, 0), x=(1e17, 0, 0)), (5, 0.01)))
    assert kind == "frozen"
    assert note == "throw 0 did not move at all although v = [1. 0. 0.] m/s"


@METHODS
def test_throws_in_one_place_do_not_collide(method):
    script = Script(method, **UNDAMPED)
    script.add(method, **UNDAMPED)
    script.throw(throw(v=(0.1, 0, 0))[0])
    script.step(10, 0.01)
    assert script.state[7] != 0.1

    states = throw(v=(0.1, 0, 0)).repeat(5, axis=0)
    together = engine.read(thrown(method, states, (10, 0.01)))
    assert (together == together[0]).all()
    assert together[0, 7] == 0.1


@METHODS
def test_a_lost_throw_takes_no_other_with_it_and_leaves_no_trace(method):
    wild = THROWS.copy()
    wild[1, 7:13] = 1e160
    world = thrown(method, wild, (100, 0.01))
    states = engine.read(world)
    assert not np.isfinite(states[1]).all()
    np.testing.assert_array_equal(states[0], engine.read(thrown(method, wild[:1], (100, 0.01)))[0])

    engine.write(world, THROWS)
    engine.advance(world, 100, 0.01)
    np.testing.assert_array_equal(engine.read(world), engine.read(thrown(method, THROWS, (100, 0.01))))


@METHODS
def test_gravity_acts_at_every_substep(method):
    """Semi-implicit Euler under constant g: x = x0 + v t + g t (t + dt)/2, exactly."""
    n, dt = 300, 0.01
    t = n * dt
    states = engine.read(thrown(method, THROWS, (n, dt), gravity=GRAVITY))
    expected = THROWS[:, 0:3] + THROWS[:, 7:10] * t + np.array(GRAVITY) * t * (t + dt) / 2
    np.testing.assert_allclose(states[:, 0:3], expected, rtol=0, atol=n * EPS * 100)


def test_worlds_are_emptied_when_dropped():
    world = engine.build(scene(), "multibody")
    client = world.client
    assert pybullet.getNumBodies(physicsClientId=client) == len(world.bodies)
    del world
    gc.collect()
    assert pybullet.getNumBodies(physicsClientId=client) == 0
    assert client in engine.IDLE


def test_importing_it_prints_nothing():
    def printed(module: str) -> str:
        run = subprocess.run([sys.executable, "-c", f"import {module}"], capture_output=True, text=True, check=True)
        return run.stdout + run.stderr

    assert "build time" in printed("pybullet")
    assert printed("tumble.compare.engines.pybullet") == ""


@pytest.mark.parametrize(("method", "twin", "drift"), [("multibody", "euler", 1), ("rigidbody", "implicit", -1)])
def test_agreement_with_mujoco_is_no_evidence(method, twin, drift):
    """Each agrees with its twin in MuJoCo to rounding while both gain, or lose, energy that a free body keeps."""
    mujoco_engine = pytest.importorskip("tumble.compare.engines.mujoco")
    states = engine.read(thrown(method, THROWS, (400, 0.01)))
    world = mujoco_engine.build(scene(), twin)
    mujoco_engine.write(world, THROWS)
    mujoco_engine.advance(world, 400, 0.01)
    theirs = mujoco_engine.read(world)
    theirs[:, 3:7] *= np.sign(np.sum(states[:, 3:7] * theirs[:, 3:7], axis=1, keepdims=True))
    np.testing.assert_allclose(states, theirs, rtol=0, atol=1e-12)
    change = spin_energy(states) / spin_energy(THROWS) - 1
    assert (drift * change > 4e-4).all(), change


def spin_energy(states: Array) -> Array:
    w_body = np.einsum("nij,ni->nj", rotation_matrix(states[:, 3:7]), states[:, 10:13])
    return w_body**2 @ MOMENTS / 2


@pytest.mark.parametrize("name", ["dzhanibekov", "box-slide-22"])
@pytest.mark.parametrize("method", engine.METHODS)
def test_a_server_that_was_reset_is_as_a_new_one(method, name):
    asked = read_scene(name)

    def states() -> Array:
        return simulate(engine, asked, method, asked.step).states

    gc.collect()
    idle = [*engine.IDLE]
    engine.IDLE.clear()
    try:
        new = states()
        gc.collect()
        assert len(engine.IDLE) == 1
        # What another scene has left there: a plane, gravity, and settings of contact that PyBullet ships.
        other = engine.build(read_scene("ball-drop-half"), f"{method}+defaults" if method == "multibody" else method)
        assert engine.IDLE == []
        del other
        gc.collect()
        assert np.array_equal(states(), new)
    finally:
        engine.IDLE.extend(idle)
