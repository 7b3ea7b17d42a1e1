"""DART by dartpy: semi-implicit Euler, the gyroscopic torque taken explicitly.

It has none of a scene's forces but gravity: `+held` is given them once a step.  A free joint's velocities are those of
the body in world axes, the angular one first.  Contacts are found by the ODE that it brings and solved by NSGS, whose
friction cone is round; the solver that it ships with, Dantzig's, has a pyramid in its place.
"""

# Its wheel is in an environment of its own.
# pyright: reportMissingImports=false

from collections.abc import Iterator
from dataclasses import dataclass, field
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

import dartpy
import numpy as np
from numpy.typing import NDArray

from tumble.compare.engines.parts.audits import stood_still
from tumble.compare.engines.parts.cylinder import cylinder
from tumble.compare.engines.parts.held import held_wrench
from tumble.compare.engines.parts.silence import silenced_stderr

if TYPE_CHECKING:
    from tumble.scenarios.scene import Scene
    from tumble.scenarios.wrench import Wrench

METHODS = ("semi-implicit-euler",)
FORCED = ("semi-implicit-euler+held",)
ON_REQUEST = ("semi-implicit-euler+defaults",)  # the same motion without a plane
SHOWN = (*METHODS, *ON_REQUEST)
FEATURES = {"gravity", "tether", "drag", "floor", "plane"}
STEP_NS = 6000
PACKAGES = ("dartpy",)
PINS = ("dartpy==6.20.0", "numpy==2.4.6")
APART = True
MEGABYTES = 165
SCHEMES = dict.fromkeys((*FORCED, *ON_REQUEST), "semi-implicit-euler")
KNOWN_FAILURES = {
    check: {"semi-implicit-euler+defaults": why}
    for check, why in {
        "restitution": "a pair's restitution is the product of both materials'",
        "any direction": "its friction cone is a pyramid: mu N along each of two axes",
        "holds": "the contacts that FCL finds under a face change from step to step",
        "mirror images": "the two ends of an edge that lands do not get the same impulse",
    }.items()
}
GYROSCOPIC = {"semi-implicit-euler": "explicit"}
ABOUT = {
    "version": version("dartpy"),
    "precision": "double",
    "switched_off": [
        "collision shapes, without a plane",
        "with a plane, its solver with a friction pyramid (Dantzig), its detector of collisions (FCL), sleep",
        "nothing else: it has no damping and no limit by default",
    ],
    "defaults": [
        "a step of 1 ms, gravity of 9.81 m/s2 along -z",
        "contacts by FCL and a friction pyramid; bodies in contact fall asleep; a pair's restitution is the product",
    ],
}


@dataclass(eq=False)
class World:
    """Worlds with one skeleton of one body a throw; written: the states as DART has them, (N, 13).

    Where there is a plane every throw has a world of its own, so that throws do not collide.
    """

    scene: "Scene"
    defaults: bool
    worlds: list[Any]
    joints: list[Any]
    bodies: list[Any]
    held: "Wrench | None"
    written: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 13)))
    steps: int = 0


def build(scene: "Scene", method: str) -> World:
    """Return a world with the scene's body once for every throw."""
    defaults = method.endswith("+defaults")
    return World(scene, defaults, *made(scene, defaults), held_wrench(scene, method))


def made(scene: "Scene", defaults: bool) -> tuple[list[Any], list[Any], list[Any]]:
    """Return DART's worlds, and the joint and the body of every throw."""
    worlds, joints, bodies = [], [], []
    inertia = dartpy.dynamics.Inertia(scene.body.mass, np.zeros(3), np.diag(scene.body.moments))
    for number in range(len(scene.start)):
        if not worlds or scene.plane is not None:
            worlds.append(world_of(scene, defaults))
        skeleton = dartpy.dynamics.Skeleton(f"throw {number}")
        joint, body = skeleton.createFreeJointAndBodyNodePair()
        body.setInertia(inertia)
        if scene.plane is not None:
            # A pair's restitution is the product, its friction the smaller.
            touch(body, shape_of(scene.body), scene.plane.restitution, scene.plane.friction)
        worlds[-1].addSkeleton(skeleton)
        joints.append(joint)
        bodies.append(body)
    return worlds, joints, bodies


def world_of(scene: "Scene", defaults: bool) -> Any:
    """Return a world with the scene's gravity and plane."""
    world, plane = dartpy.simulation.World(), scene.plane
    world.setGravity(np.zeros(3) if scene.gravity is None else np.array(scene.gravity))
    if plane is None:
        return world
    if not defaults:
        world.setCollisionDetector(dartpy.collision.OdeCollisionDetector())
        world.getConstraintSolver().setBoxedLcpSolver(dartpy.constraint.NsgsFrictionSolver())
        sleep = world.getDeactivationOptions()
        sleep.mEnabled = False
        world.setDeactivationOptions(sleep)
    ground = dartpy.dynamics.Skeleton("plane")
    _, body = ground.createWeldJointAndBodyNodePair()
    shape = dartpy.dynamics.PlaneShape(np.array(plane.normal), np.array(plane.point))
    touch(body, shape, plane.restitution if defaults else 1.0, plane.friction)
    world.addSkeleton(ground)
    return world


def touch(body: Any, shape: Any, restitution: float, friction: float) -> None:
    """Give a body a shape that touches, and its material."""
    node = body.createShapeNode(shape)
    node.createCollisionAspect()
    material = node.createDynamicsAspect()
    material.setRestitutionCoeff(restitution)
    material.setFrictionCoeff(friction)


def shape_of(body: Any) -> Any:
    """Return the body's shape."""
    if body.radius is not None:
        return dartpy.dynamics.SphereShape(body.radius)
    if body.disc is not None:
        radius, half = cylinder(body.disc)
        return dartpy.dynamics.CylinderShape(radius, 2 * half)
    if body.size is not None:
        return dartpy.dynamics.BoxShape(np.array(body.size))
    raise NotImplementedError("its Python package makes no convex hull of points")


def write(world: World, states: NDArray[np.float64]) -> None:
    """Put the throws into these states, (N, 13); what DART keeps of contacts goes with its worlds."""
    if world.scene.plane is not None and world.steps:
        world.worlds, world.joints, world.bodies = made(world.scene, world.defaults)
    for joint, body, state in zip(world.joints, world.bodies, states, strict=True):
        pose = dartpy.math.Isometry3()
        pose.set_quaternion(dartpy.math.Quaternion(state[3:7] / np.linalg.norm(state[3:7])))
        pose.set_translation(state[0:3])
        joint.setTransform(pose)
        joint.setVelocities(np.concatenate((state[10:13], state[7:10])))
        joint.resetAccelerations()
        body.setExtForce(np.zeros(3))
        body.setExtTorque(np.zeros(3))
    world.steps = 0
    world.written = read(world)


def advance(world: World, n: int, dt: float) -> None:
    """Make n steps of dt [s]."""
    world.steps += n
    for each in world.worlds:
        each.setTimeStep(dt)
    steps = [each.step for each in world.worlds]
    with silenced_stderr():  # of a flight that blew up it would tell every step
        if world.held is None and len(steps) == 1:
            (step,) = steps
            for _ in range(n):
                step()
        else:
            for _ in range(n):
                if world.held is not None:
                    hold(world, world.held)
                for step in steps:
                    step()


def hold(world: World, held: "Wrench") -> None:
    """Apply the forces of the states as they are, in world axes at the centre of mass; a step uses them up."""
    for body, total in zip(world.bodies, held(states_of(world)), strict=True):
        body.setExtForce(total[0:3], np.zeros(3), False, True)
        body.setExtTorque(total[3:6], False)


def read(world: World) -> NDArray[np.float64]:
    """Return the states of the throws, (N, 13)."""
    with silenced_stderr():  # of a pose that is not finite
        return states_of(world)


def states_of(world: World) -> NDArray[np.float64]:
    """Return the same; DART may tell of what is not finite."""
    states = np.empty((len(world.bodies), 13))
    for state, joint, body in zip(states, world.joints, world.bodies, strict=True):
        pose = body.getTransform()
        q, velocities = pose.quaternion(), joint.getVelocities()
        state[0:3], state[3:7] = pose.translation(), (q.w(), q.x(), q.y(), q.z())
        state[7:10], state[10:13] = velocities[3:6], velocities[0:3]
        if not np.isfinite(joint.getPositions()).all():
            state[:] = np.nan  # DART shows the identity in place of a pose that is not finite
    return states


def audit(world: World) -> Iterator[tuple[str, str]]:
    """Yield what went wrong without a word since `write`."""
    yield from stood_still(world.written, read(world), world.steps)
