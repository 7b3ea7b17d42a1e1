"""PyBullet in free flight, set up so that nothing but its integrators is compared.

Its two kinds of body are two integrators: `multibody` (btMultiBody, the default kind) takes the gyroscopic torque
explicitly, `rigidbody` (btRigidBody, "maximal coordinates") implicitly.  Quaternions are x y z w there; every vector
is in world axes.
"""

import importlib.metadata
import math
import os
import sys
import weakref
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from scenarios.scene import Scene


@contextmanager
def silenced_stderr() -> Iterator[None]:
    """Send file descriptor 2 nowhere: PyBullet prints its build date from C, where sys.stderr has no say."""
    sys.stderr.flush()
    kept = os.dup(2)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 2)
    try:
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nowhere)


with silenced_stderr():
    import pybullet

METHODS = ("multibody", "rigidbody")
FEATURES = {"gravity"}
ABOUT = {
    "version": importlib.metadata.version("pybullet"),
    "precision": "double",
    "switched_off": [
        "damping (multibody's default slows 10 m/s to 6.9 m/s in 1 s)",
        "multibody's limit of 100 m/s and 100 rad/s on every velocity component",
        "collision shapes and collision pairs",
    ],
}

BASE = -1  # PyBullet's link index of the body itself
LARGEST_TURN = math.pi / 4  # rad a step; ANGULAR_MOTION_THRESHOLD in Bullet's btTransformUtil.h


@dataclass(eq=False)
class World:
    """A physics server with one body a throw, and what `audit` needs to know of the flight since `write`.

    mass [kg] and moments [kg m2] as PyBullet got them; fastest: largest |w| seen [rad/s]; longest_step [s].
    """

    client: int
    mass: float
    moments: tuple[float, ...]
    bodies: list[int] = field(default_factory=list)
    written: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 13)))
    fastest: float = 0.0
    longest_step: float = 0.0


def build(scene: "Scene", method: str) -> World:
    """Return a world with the scene's body once for every throw."""
    scale = scale_to_one(scene.body.mass, *scene.body.moments)
    client = pybullet.connect(pybullet.DIRECT)
    world = World(client, scale * scene.body.mass, tuple(scale * scene.body.moments))
    weakref.finalize(world, pybullet.disconnect, client)
    if scene.gravity is not None:
        pybullet.setGravity(*scene.gravity, physicsClientId=client)
    world.bodies = [add_body(world, maximal=method == "rigidbody") for _ in scene.start]
    return world


def scale_to_one(*masses_and_moments: float) -> float:
    """Return the power of two that takes the smallest to about one.

    Multibody ignores a torque about an axis with a moment below 2.2e-16 kg m2, and rigidbody drops the gyroscopic
    torque where the product of the three is below that.  Free motion depends on ratios only, and a power of two changes
    no bit of it.
    """
    return math.ldexp(1.0, -math.frexp(min(masses_and_moments))[1])


def add_body(world: World, maximal: bool) -> int:
    """Add the body, which has no shape to collide with, and return PyBullet's number for it."""
    body = pybullet.createMultiBody(world.mass, useMaximalCoordinates=maximal, physicsClientId=world.client)
    # In one call: for rigidbody, moments without the mass leave the mass uninitialised.
    pybullet.changeDynamics(
        body,
        BASE,
        mass=world.mass,
        localInertiaDiagonal=world.moments,
        linearDamping=0,
        angularDamping=0,
        maxJointVelocity=math.inf,
        physicsClientId=world.client,
    )
    # Even without shapes, throws in one place would be paired off at every step, which doubles its cost.
    pybullet.setCollisionFilterGroupMask(body, BASE, 0, 0, physicsClientId=world.client)
    return body


def write(world: World, states: NDArray[np.float64]) -> None:
    """Put the throws into these states, (N, 13), with no trace of any earlier flight."""
    at_rest = states.copy()
    at_rest[:, 7:] = 0.0
    place(world, at_rest)
    # Placing leaves rigidbody's world inertia as it was in the pose before; a step makes it anew.
    advance(world, 1, 1.0)
    place(world, states)
    world.written = states.copy()
    world.fastest = world.longest_step = 0.0
    read(world)


def place(world: World, states: NDArray[np.float64]) -> None:
    """Set pose and velocity of every body, and nothing else."""
    for body, state in zip(world.bodies, states.tolist(), strict=True):
        x, (w, *xyz), v, spin = state[0:3], state[3:7], state[7:10], state[10:13]
        pybullet.resetBasePositionAndOrientation(body, x, [*xyz, w], physicsClientId=world.client)
        pybullet.resetBaseVelocity(body, v, spin, physicsClientId=world.client)


def advance(world: World, n: int, dt: float) -> None:
    """Make n steps of dt [s] as substeps in C, 2^k of them at a time.

    PyBullet divides an interval by the number of substeps and truncates when it counts them.  Only for a power of two
    are both exact; for others the step can be an ulp off and, worse, one substep may be left out.
    """
    world.longest_step = max(world.longest_step, dt)
    for k in range(n.bit_length()):
        substeps = n & (1 << k)
        if substeps:
            pybullet.setPhysicsEngineParameter(
                numSubSteps=substeps, fixedTimeStep=substeps * dt, physicsClientId=world.client
            )
            pybullet.stepSimulation(physicsClientId=world.client)


def read(world: World) -> NDArray[np.float64]:
    """Return the states of the throws, (N, 13)."""
    states = np.empty((len(world.bodies), 13))
    for state, body in zip(states, world.bodies, strict=True):
        x, (*xyz, w) = pybullet.getBasePositionAndOrientation(body, physicsClientId=world.client)
        v, spin = pybullet.getBaseVelocity(body, physicsClientId=world.client)
        state[:] = *x, w, *xyz, *v, *spin
        world.fastest = max(world.fastest, math.hypot(*spin))
    return states


def audit(world: World) -> list[str]:
    """Return what went wrong without a word since `write`; |w| is known where the state was written or read."""
    states = read(world)
    return [*turned_too_little(world), *another_body(world), *stood_still(world, states)]


def turned_too_little(world: World) -> Iterator[str]:
    """Say so where a step was too long for the angular velocity (Bullet, btTransformUtil::integrateTransform)."""
    asked = world.fastest * world.longest_step
    if asked > LARGEST_TURN:
        turned = 2 * math.atan(asked / LARGEST_TURN * math.tan(LARGEST_TURN / 2))
        yield f"turned 2 atan(4 |w|dt/pi tan(pi/8)) = {turned:.3g} rad a step instead of |w|dt = {asked:.3g} rad"


def another_body(world: World) -> Iterator[str]:
    """Say so where mass or moments are not those asked for."""
    asked = np.array([world.mass, *world.moments])
    for throw, body in enumerate(world.bodies):
        info = pybullet.getDynamicsInfo(body, BASE, physicsClientId=world.client)
        got = np.array([info[0], *info[2]])
        # Bullet keeps inverses, which costs an ulp.
        if not np.allclose(got, asked, rtol=1e-15, atol=0.0):
            yield f"throw {throw} has mass and moments {got / asked} times those asked for"


def stood_still(world: World, states: NDArray[np.float64]) -> Iterator[str]:
    """Say so where a body kept a velocity and went nowhere."""
    if not world.longest_step:
        return
    same = (states == world.written)[:, [0, 1, 2, 7, 8, 9]].all(axis=1)
    moving = world.written[:, 7:10].any(axis=1)
    for throw in np.flatnonzero(same & moving):
        yield f"throw {throw} did not move at all although v = {world.written[throw, 7:10]} m/s"
