"""PhysX 5 by SAPIEN, on the processor: single precision, the gyroscopic torque taken explicitly and |L| restored.

Its two solvers, `pgs` and `tgs`, are two ways of stepping even where nothing touches: tgs, which ships as the default,
adds some 1e-6 of the energy a step.  It has none of a scene's forces but gravity: `+held` is given them once a step.
Every vector is in world axes; its quaternions are w x y z.
"""

# Its wheel is in an environment of its own.
# pyright: reportMissingImports=false

import importlib.metadata
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tumble.compare.engines.parts.audits import beyond, stood_still
from tumble.compare.engines.parts.cylinder import cylinder
from tumble.compare.engines.parts.held import held_wrench
from tumble.compare.engines.parts.scale import scale_to_one
from tumble.compare.engines.parts.silence import silenced_stderr
from tumble.compare.engines.parts.turn_to import turn_onto

if TYPE_CHECKING:
    from tumble.scenarios.scene import Scene
    from tumble.scenarios.wrench import Wrench

with silenced_stderr():  # it looks for a graphics card
    import sapien
    from sapien import physx

METHODS = ("pgs", "tgs")
FORCED = ("pgs+held", "tgs+held")
ON_REQUEST = ("tgs+defaults",)
FEATURES = {"gravity", "tether", "drag", "floor", "plane"}
STEP_NS = 13_000
PACKAGES = ("sapien",)
PINS = ("sapien==3.0.3", "numpy==2.4.6")
APART = True
MEGABYTES = 430
SCHEMES = dict.fromkeys((*FORCED, *ON_REQUEST), "semi-implicit-euler")
GYROSCOPIC = dict.fromkeys(METHODS, "rescaled")
KNOWN_FAILURES = {"mirror images": {"*": "the two ends of an edge that lands do not get the same impulse"}}
# What it does unless told otherwise.
ANGULAR_DAMPING, LARGEST_SPIN = 0.05, 100.0  # 1/s, rad/s
NO_LIMIT = 1e30
# With a plane: how near a contact is solved, as a share of the body's diameter; iterations on velocities, of which one
# alone leaves the friction of a sliding face askew.
MARGIN = 0.02
VELOCITY_ITERATIONS = 4
ABOUT = {
    "version": importlib.metadata.version("sapien"),
    "precision": "single",
    "switched_off": [
        "angular damping (0.05 a second by default)",
        "the limit of 100 rad/s on an angular velocity",
        "sleeping",
        "collision shapes, without a plane",
        "with a plane, the speed of 2 m/s below which nothing bounces; margins of 1 cm (2 % of the body's diameter); "
        "1 iteration on velocities (4)",
    ],
    "defaults": [
        "tgs",
        "angular damping 0.05",
        "100 rad/s at most",
        "bodies fall asleep",
        "impacts below 2 m/s do not bounce",
    ],
}


@dataclass(eq=False)
class World:
    """A system with one body a throw, and what `audit` needs to know of the flight since `write`.

    Where there is a plane every throw has a system of its own, since tgs rounds bodies together that touch something.

    scale: how many times the scene's masses and forces are what PhysX got; held: what gives the wrench of a step.
    written: the states as PhysX has them, (N, 13); spinning: the largest |w| seen [rad/s].
    """

    scene: "Scene"
    method: str
    systems: list[Any]
    stages: list[Any]  # which own the bodies
    entities: list[Any]
    bodies: list[Any]
    defaults: bool
    scale: float
    held: "Wrench | None"
    written: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 13)))
    steps: int = 0
    elapsed: float = 0.0
    spinning: float = 0.0


def build(scene: "Scene", method: str) -> World:
    """Return a world with the scene's body once for every throw."""
    defaults = method.endswith("+defaults")
    scale = 1.0 if defaults else scale_to_one(scene.body.mass, *scene.body.moments)
    return World(scene, method, *made(scene, method, scale), defaults, scale, held_wrench(scene, method))


def made(scene: "Scene", method: str, scale: float) -> tuple[list[Any], list[Any], list[Any], list[Any]]:
    """Return PhysX's systems, the stages that own the bodies, and every throw's entity and body."""
    solver, _, manner = method.partition("+")
    defaults = manner == "defaults"
    settings = physx.PhysxSceneConfig()
    settings.gravity = [0.0, 0.0, 0.0] if scene.gravity is None else scene.gravity.tolist()
    settings.enable_tgs = solver == "tgs"
    if scene.plane is not None and not defaults:
        settings.bounce_threshold = 0.0
    physx.set_scene_config(settings)  # those of systems made from now on
    systems, stages, entities, bodies = [], [], [], []
    for _ in scene.start:
        if not systems or scene.plane is not None:
            systems.append(physx.PhysxCpuSystem())
            stages.append(sapien.Scene([systems[-1]]))
        entity, body = sapien.Entity(), physx.PhysxRigidDynamicComponent()
        if scene.plane is not None:
            body.attach(with_margin(shape_of(scene.body, material_of(scene.plane)), scene, defaults))
            stages[-1].add_entity(ground(scene, defaults))
        body.set_mass(scale * scene.body.mass)
        body.set_inertia((scale * scene.body.moments).tolist())
        body.set_cmass_local_pose(sapien.Pose())  # else that of the shape attached
        if not defaults:
            body.set_linear_damping(0.0)
            body.set_angular_damping(0.0)
            body.set_max_angular_velocity(NO_LIMIT)
            body.set_sleep_threshold(0.0)
            if scene.plane is not None:
                body.set_solver_velocity_iterations(VELOCITY_ITERATIONS)
        entity.add_component(body)
        stages[-1].add_entity(entity)
        entities.append(entity)
        bodies.append(body)
    return systems, stages, entities, bodies


def ground(scene: "Scene", defaults: bool) -> Any:
    """Return the plane, whose normal is its x axis."""
    plane = scene.plane
    assert plane is not None
    entity, body = sapien.Entity(), physx.PhysxRigidStaticComponent()
    body.attach(with_margin(physx.PhysxCollisionShapePlane(material_of(plane)), scene, defaults))
    entity.add_component(body)
    entity.set_pose(sapien.Pose(plane.point.tolist(), turn_onto(np.array((1.0, 0.0, 0.0)), plane.normal).tolist()))
    return entity


def material_of(plane: Any) -> Any:
    """Return the material of body and plane: PhysX takes the mean of two, so that the pair has the scene's numbers."""
    return physx.PhysxMaterial(plane.friction, plane.friction, plane.restitution)


def with_margin(shape: Any, scene: "Scene", defaults: bool) -> Any:
    """Return a shape with a margin that is a share of the body."""
    if not defaults:
        shape.set_contact_offset(MARGIN * 2 * scene.body.reach)
    return shape


def shape_of(body: Any, material: Any) -> Any:
    """Return the body's shape: a sphere, a cylinder, a box, or the convex hull of the points."""
    if body.radius is not None:
        return physx.PhysxCollisionShapeSphere(body.radius, material)
    if body.disc is not None:
        disc = physx.PhysxCollisionShapeCylinder(*cylinder(body.disc), material)
        disc.set_local_pose(sapien.Pose(q=turn_onto(np.array((1.0, 0.0, 0.0)), np.array((0.0, 0.0, 1.0))).tolist()))
        return disc
    if body.size is not None:
        return physx.PhysxCollisionShapeBox((body.size / 2).astype(np.float32), material)
    return physx.PhysxCollisionShapeConvexMesh(body.points.astype(np.float32), np.ones(3, np.float32), material)


def write(world: World, states: NDArray[np.float64]) -> None:
    """Put the throws into these states, (N, 13); what PhysX keeps of contacts goes with its system."""
    if world.scene.plane is not None and world.steps:
        remade = made(world.scene, world.method, world.scale)
        world.systems, world.stages, world.entities, world.bodies = remade
    for entity, body, state in zip(world.entities, world.bodies, states, strict=True):
        entity.set_pose(sapien.Pose(state[0:3].tolist(), state[3:7].tolist()))
        body.set_linear_velocity(state[7:10].tolist())
        body.set_angular_velocity(state[10:13].tolist())
        body.wake_up()
    world.steps, world.elapsed, world.spinning = 0, 0.0, 0.0
    world.written = read(world)


def advance(world: World, n: int, dt: float) -> None:
    """Make n steps of dt [s]."""
    world.steps += n
    world.elapsed += n * dt
    for system in world.systems:
        system.set_timestep(dt)
    steps = [system.step for system in world.systems]
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
    """Apply the forces of the states as they are; a step uses them up."""
    wrenches = (world.scale * held(read(world))).astype(np.float32)
    for body, total in zip(world.bodies, wrenches, strict=True):
        body.add_force_torque(total[0:3], total[3:6])


def read(world: World) -> NDArray[np.float64]:
    """Return the states of the throws, (N, 13)."""
    states = np.empty((len(world.bodies), 13))
    for state, entity, body in zip(states, world.entities, world.bodies, strict=True):
        pose = entity.get_pose()
        state[0:3], state[3:7] = pose.p, pose.q
        state[7:10], state[10:13] = body.get_linear_velocity(), body.get_angular_velocity()
    world.spinning = max(world.spinning, float(np.linalg.norm(states[:, 10:13], axis=1).max(initial=0.0)))
    return states


def audit(world: World) -> Iterator[tuple[str, str]]:
    """Yield what went wrong without a word since `write`; |w| is known where the state was written or read."""
    states = read(world)
    yield from stood_still(world.written, states, world.steps)
    if world.defaults and world.steps:
        lost = -np.expm1(-ANGULAR_DAMPING * world.elapsed)
        yield "damped", f"damped: its default takes {ANGULAR_DAMPING:g} of w a second, {lost:.2g} of it so far"
        yield from beyond("|w|", "rad/s", world.spinning, LARGEST_SPIN)
