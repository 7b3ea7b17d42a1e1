"""Rapier, by its official Python package: single precision, the gyroscopic torque taken explicitly and |L| restored.

A step of its own defaults is four substeps; here it is one, so that dt is the step, but four where there is a plane.
It has none of a scene's forces but gravity: `+held` is given them once a step.  Every vector is in world axes; its
quaternions are x y z w.
"""

# Its wheel is in an environment of its own.
# pyright: reportMissingImports=false

import importlib.metadata
import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import rapier3d
from numpy.typing import NDArray

from tumble.compare.engines.parts.audits import beyond, stood_still
from tumble.compare.engines.parts.cylinder import cylinder
from tumble.compare.engines.parts.held import held_wrench
from tumble.compare.engines.parts.scale import scale_to_one
from tumble.compare.engines.parts.substeps import held_over

if TYPE_CHECKING:
    from tumble.scenarios.scene import Scene
    from tumble.scenarios.wrench import Wrench

METHODS = ("tgs",)
FORCED = ("tgs+held",)
ON_REQUEST = ("tgs+defaults",)
FEATURES = {"gravity", "tether", "drag", "floor", "plane"}
STEP_NS = 10_000
PACKAGES = ("rapier3d",)
PINS = ("rapier3d==0.36.1", "numpy==2.4.6")
APART = True
MEGABYTES = 110
GYROSCOPIC = {"tgs": "rescaled"}
KNOWN_FAILURES = {"mirror images": {"*": "the two ends of an edge that lands do not get the same impulse"}}
SUBSTEPS = 4  # of a step, unless told otherwise
LARGEST_SPEED = 400.0  # m/s, unless told otherwise
CAPPED_TURN = math.pi / 4  # rad a step, however many substeps it has, unless allow_fast_rotation
SCHEMES = {"tgs+held": "semi-implicit-euler", "tgs+defaults": held_over(SUBSTEPS)}
ABOUT = {
    "version": importlib.metadata.version("rapier3d"),
    "precision": "single",
    "switched_off": [
        "three of four substeps, without a plane: a step is dt",
        "the limit of 400 m/s on a velocity and of pi/4 a step on a rotation",
        "sleeping",
        "colliders, without a plane",
        "with a plane, margins for lengths of 1 m: they are shares of the body's diameter, by which it looks ahead",
    ],
    "defaults": ["4 substeps a step", "400 m/s and pi/4 rad a step at most", "bodies fall asleep"],
}


@dataclass(eq=False)
class World:
    """A world with one body a throw, and what `audit` needs to know of the flight since `write`.

    scale: how many times the scene's masses and forces are what Rapier got; held: what gives the wrench of a step.
    written: the states as Rapier has them, (N, 13); fastest [m/s] and spinning [rad/s]: the largest seen; longest [s].
    """

    scene: "Scene"
    world: Any
    bodies: list[Any]
    defaults: bool
    scale: float
    held: "Wrench | None"
    written: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 13)))
    steps: int = 0
    longest: float = 0.0
    fastest: float = 0.0
    spinning: float = 0.0
    neutralised: int = 0


def build(scene: "Scene", method: str) -> World:
    """Return a world with the scene's body once for every throw."""
    defaults, held = method.endswith("+defaults"), held_wrench(scene, method)
    scale = 1.0 if defaults else scale_to_one(scene.body.mass, *scene.body.moments)
    return World(scene, *made(scene, defaults, scale), defaults, scale, held)


def made(scene: "Scene", defaults: bool, scale: float) -> tuple[Any, list[Any]]:
    """Return Rapier's world and its bodies, with the plane and shapes where the scene has a plane."""
    world = rapier3d.PhysicsWorld(gravity=(0.0, 0.0, 0.0) if scene.gravity is None else tuple(scene.gravity.tolist()))
    if not defaults:
        world.integration_parameters.num_solver_iterations = 1
        world.integration_parameters.normalized_max_linear_velocity = math.inf
    moments = tuple((scale * scene.body.moments).tolist())
    mass = rapier3d.MassProperties((0.0, 0.0, 0.0), scale * scene.body.mass, moments, rapier3d.Rotation3.identity())
    handles = [world.add_body(body_of(mass, defaults)) for _ in scene.start]
    if scene.plane is not None:
        add_shapes(world, handles, scene, defaults)
    return world, [world.rigid_bodies[handle] for handle in handles]


def add_shapes(world: Any, handles: list[Any], scene: "Scene", defaults: bool) -> None:
    """Add the plane, and to each body its shape, which touches the plane alone.

    Rapier takes the mean of two materials: both have the pair's coefficients.  With one substep the friction of an
    impact is off by several times as much: there are as many as it has unless told otherwise.
    """
    plane, diameter = scene.plane, 2 * scene.body.reach
    assert plane is not None
    ground, thrown = rapier3d.Group.GROUP_1, rapier3d.Group.GROUP_2
    floor = rapier3d.Collider.halfspace(tuple(plane.normal.tolist())).translation(tuple(plane.point.tolist()))
    world.add_collider(of_pair(floor, plane).collision_groups(rapier3d.InteractionGroups(ground, thrown)))
    if not defaults:
        world.integration_parameters.num_solver_iterations = SUBSTEPS
        world.integration_parameters.length_unit = diameter  # its margins are shares of it
    for handle in handles:
        if not defaults:
            world.rigid_bodies[handle].soft_ccd_prediction = diameter  # how far ahead it looks for the plane
        shape = of_pair(shape_of(scene.body), plane).density(0.0)
        world.add_collider(shape.collision_groups(rapier3d.InteractionGroups(thrown, ground)), handle)


def of_pair(collider: Any, plane: Any) -> Any:
    """Return a collider with the pair's coefficients."""
    return collider.friction(plane.friction).restitution(plane.restitution)


def shape_of(body: Any) -> Any:
    """Return the body's shape, without a mass of its own: a sphere, a cylinder, a box, or the hull of the points."""
    if body.radius is not None:
        return rapier3d.Collider.ball(body.radius)
    if body.disc is not None:
        radius, half = cylinder(body.disc)
        return rapier3d.Collider.cylinder(half, radius).rotation((np.pi / 2, 0.0, 0.0))  # its axis is y
    if body.size is not None:
        return rapier3d.Collider.cuboid(*(body.size / 2).tolist())
    return rapier3d.Collider.convex_hull(body.points.astype(np.float32))


def body_of(mass: Any, defaults: bool) -> Any:
    """Return a body without a shape, which can collide with nothing."""
    body = rapier3d.RigidBody.dynamic().additional_mass_properties(mass).gyroscopic_forces(True)
    return body if defaults else body.can_sleep(False).allow_fast_rotation(True)


def write(world: World, states: NDArray[np.float64]) -> None:
    """Put the throws into these states, (N, 13); what Rapier keeps of contacts goes with its world."""
    if world.scene.plane is not None and world.steps:
        world.world, world.bodies = made(world.scene, world.defaults, world.scale)
    for body, state in zip(world.bodies, states.tolist(), strict=True):
        w, x, y, z = state[3:7]
        body.position = rapier3d.Isometry3(tuple(state[0:3]), rapier3d.Rotation3(w, x, y, z))
        body.linvel, body.angvel = tuple(state[7:10]), tuple(state[10:13])
        body.reset_forces()
        body.reset_torques()
        body.wake_up()
    world.steps, world.longest, world.fastest, world.spinning, world.neutralised = 0, 0.0, 0.0, 0.0, 0
    world.written = read(world)


def advance(world: World, n: int, dt: float) -> None:
    """Make n steps of dt [s]."""
    world.steps += n
    world.longest = max(world.longest, dt)
    world.world.integration_parameters.dt = dt
    step = world.world.step
    if world.held is None:
        for _ in range(n):
            step()
    else:
        for _ in range(n):
            hold(world, world.held)
            step()
    world.neutralised += len(world.world.quarantine.bodies)


def hold(world: World, held: "Wrench") -> None:
    """Apply the forces of the states as they are."""
    wrenches = world.scale * held(read(world))
    for body, total in zip(world.bodies, wrenches.tolist(), strict=True):
        body.reset_forces()
        body.reset_torques()
        body.add_force(tuple(total[0:3]))
        body.add_torque(tuple(total[3:6]))


def read(world: World) -> NDArray[np.float64]:
    """Return the states of the throws, (N, 13)."""
    states = np.empty((len(world.bodies), 13))
    for state, body in zip(states, world.bodies, strict=True):
        q, x, v, spin = body.rotation, body.translation, body.linvel, body.angvel
        state[:] = x.x, x.y, x.z, q.w, q.i, q.j, q.k, v.x, v.y, v.z, spin.x, spin.y, spin.z
    world.fastest = max(world.fastest, float(np.linalg.norm(states[:, 7:10], axis=1).max(initial=0.0)))
    world.spinning = max(world.spinning, float(np.linalg.norm(states[:, 10:13], axis=1).max(initial=0.0)))
    return states


def audit(world: World) -> Iterator[tuple[str, str]]:
    """Yield what went wrong without a word since `write`; speeds are known where the state was written or read."""
    states = read(world)
    yield from stood_still(world.written, states, world.steps)
    if world.neutralised:
        yield "bad-number", f"{world.neutralised} times a body that was not finite any more was neutralised"
    if world.defaults and world.longest:
        yield from beyond("|v|", "m/s", world.fastest, LARGEST_SPEED)
        yield from beyond("|w|", "rad/s", world.spinning, CAPPED_TURN / world.longest)
