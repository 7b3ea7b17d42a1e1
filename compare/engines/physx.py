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
from tumble.compare.engines.parts.held import held_wrench
from tumble.compare.engines.parts.scale import scale_to_one
from tumble.compare.engines.parts.silence import silenced_stderr

if TYPE_CHECKING:
    from tumble.scenarios.scene import Scene
    from tumble.scenarios.wrench import Wrench

with silenced_stderr():  # it looks for a graphics card
    import sapien
    from sapien import physx

METHODS = ("pgs", "tgs")
FORCED = ("pgs+held", "tgs+held")
ON_REQUEST = ("tgs+defaults",)
FEATURES = {"gravity", "tether", "drag", "floor"}
STEP_NS = 13_000
PACKAGES = ("sapien",)
PINS = ("sapien==3.0.3", "numpy==2.4.6")
APART = True
MEGABYTES = 430
SCHEMES = dict.fromkeys((*FORCED, *ON_REQUEST), "semi-implicit-euler")
GYROSCOPIC = dict.fromkeys(METHODS, "rescaled")
# What it does unless told otherwise.
ANGULAR_DAMPING, LARGEST_SPIN = 0.05, 100.0  # 1/s, rad/s
NO_LIMIT = 1e30
ABOUT = {
    "version": importlib.metadata.version("sapien"),
    "precision": "single",
    "switched_off": [
        "angular damping (0.05 a second by default)",
        "the limit of 100 rad/s on an angular velocity",
        "sleeping",
        "collision shapes",
    ],
    "defaults": ["tgs", "angular damping 0.05", "100 rad/s at most", "bodies fall asleep"],
}


@dataclass(eq=False)
class World:
    """A system with one body a throw, and what `audit` needs to know of the flight since `write`.

    scale: how many times the scene's masses and forces are what PhysX got; held: what gives the wrench of a step.
    written: the states as PhysX has them, (N, 13); spinning: the largest |w| seen [rad/s].
    """

    system: Any
    scene: Any  # which owns the bodies
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
    solver, _, manner = method.partition("+")
    defaults, held = manner == "defaults", held_wrench(scene, method)
    settings = physx.PhysxSceneConfig()
    settings.gravity = [0.0, 0.0, 0.0] if scene.gravity is None else scene.gravity.tolist()
    settings.enable_tgs = solver == "tgs"
    physx.set_scene_config(settings)  # those of systems made from now on
    system = physx.PhysxCpuSystem()
    stage = sapien.Scene([system])
    scale = 1.0 if defaults else scale_to_one(scene.body.mass, *scene.body.moments)
    world = World(system, stage, [], [], defaults, scale, held)
    for _ in scene.start:
        entity, body = sapien.Entity(), physx.PhysxRigidDynamicComponent()
        body.set_mass(scale * scene.body.mass)
        body.set_inertia((scale * scene.body.moments).tolist())
        if not defaults:
            body.set_linear_damping(0.0)
            body.set_angular_damping(0.0)
            body.set_max_angular_velocity(NO_LIMIT)
            body.set_sleep_threshold(0.0)
        entity.add_component(body)
        stage.add_entity(entity)
        world.entities.append(entity)
        world.bodies.append(body)
    return world


def write(world: World, states: NDArray[np.float64]) -> None:
    """Put the throws into these states, (N, 13)."""
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
    world.system.set_timestep(dt)
    step = world.system.step
    if world.held is None:
        for _ in range(n):
            step()
    else:
        for _ in range(n):
            hold(world, world.held)
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
