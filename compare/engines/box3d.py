"""Box3D, by the C functions in robox3d's wheel: single precision, the gyroscopic torque taken implicitly.

A step has as many substeps as its caller asks for, and its manual asks for four: here it is one, so that dt is the
step, but four where there is a plane.  It has none of a scene's forces but gravity: `+held` is given them once a step.
Every vector is in world axes; its quaternions are x y z w.
"""

# Its wheel is in an environment of its own.
# pyright: reportMissingImports=false

import importlib.metadata
import math
import weakref
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from robox3d._ffi import ffi, lib, shim

from tumble.compare.engines.parts.audits import beyond, stood_still
from tumble.compare.engines.parts.cylinder import cylinder
from tumble.compare.engines.parts.held import held_wrench
from tumble.compare.engines.parts.scale import scale_to_one
from tumble.compare.engines.parts.substeps import held_over
from tumble.compare.engines.parts.turn_to import turn_onto

if TYPE_CHECKING:
    from tumble.scenarios.scene import Scene
    from tumble.scenarios.wrench import Wrench

METHODS = ("semi-implicit-euler",)
FORCED = ("semi-implicit-euler+held",)
ON_REQUEST = ("semi-implicit-euler+defaults",)
FEATURES = {"gravity", "tether", "drag", "floor", "plane"}
STEP_NS = 2000
PACKAGES = ("robox3d",)
PINS = ("robox3d==0.1.0", "cffi==2.1.1", "numpy==2.4.6")
APART = True
MEGABYTES = 400
KNOWN_FAILURES = {"mirror images": {"*": "the two ends of an edge that lands do not get the same impulse"}}
GYROSCOPIC = {"semi-implicit-euler": "implicit"}
# What it does unless told otherwise; substeps are what its manual asks for.
SUBSTEPS, LARGEST_SPEED, CAPPED_TURN = 4, 400.0, math.pi / 4  # m/s, rad a step
SIDES = 32  # of the prism that stands for a disc: it takes no more corners
NO_LIMIT = 1e30
SCHEMES = {
    "semi-implicit-euler+held": "semi-implicit-euler",
    "semi-implicit-euler+defaults": held_over(SUBSTEPS),
}
ABOUT = {
    "version": importlib.metadata.version("robox3d"),
    "precision": "single",
    "switched_off": [
        "three of four substeps, without a plane: a step is dt",
        "the limit of 400 m/s on a velocity and of pi/4 a step on a rotation",
        "sleeping",
        "shapes, without a plane",
        "with a plane, the speed of 1 m/s below which nothing bounces; margins for lengths of 1 m: they are shares of "
        "the body's diameter",
    ],
    "defaults": [
        "4 substeps a step",
        "400 m/s and pi/4 rad a step at most",
        "bodies fall asleep",
        "impacts below 1 m/s do not bounce",
    ],
}


@dataclass(eq=False)
class World:
    """A world with one body a throw, and what `audit` needs to know of the flight since `write`.

    units: the length that margins are for [m]; scale: how many times the scene's masses and forces are what Box3D got;
    held: what gives the wrench of a step; written: the states as Box3D has them, (N, 13); fastest [m/s] and spinning
    [rad/s]: the largest seen; longest [s].
    """

    scene: "Scene"
    defaults: bool
    substeps: int
    units: float
    scale: float
    held: "Wrench | None"
    id: Any = None
    bodies: Any = None
    written: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 13)))
    steps: int = 0
    longest: float = 0.0
    fastest: float = 0.0
    spinning: float = 0.0
    end: Any = None


def build(scene: "Scene", method: str) -> World:
    """Return a world with the scene's body once for every throw."""
    defaults, held = method.endswith("+defaults"), held_wrench(scene, method)
    scale = 1.0 if defaults else scale_to_one(scene.body.mass, *scene.body.moments)
    touching = scene.plane is not None
    units = 2 * scene.body.reach if touching and not defaults else 1.0
    world = World(scene, defaults, SUBSTEPS if defaults or touching else 1, units, scale, held)
    fill(world)
    return world


def fill(world: World) -> None:
    """Make Box3D's world and bodies anew, with the plane and shapes where the scene has a plane."""
    scene, defaults = world.scene, world.defaults
    if world.end is not None:
        world.end()
    lib.b3SetLengthUnitsPerMeter(world.units)
    about = lib.b3DefaultWorldDef()
    about.gravity = (0.0, 0.0, 0.0) if scene.gravity is None else tuple(scene.gravity.tolist())
    if not defaults:
        about.enableSleep = False
        about.maximumLinearSpeed = NO_LIMIT
        about.restitutionThreshold = 0.0
    world.id = lib.b3CreateWorld(ffi.addressof(about))
    world.end = weakref.finalize(world, lib.b3DestroyWorld, world.id)
    world.bodies = ffi.new("b3BodyId[]", [body_of(world) for _ in scene.start])
    if scene.plane is not None:
        lay(world, scene.plane)


def body_of(world: World) -> Any:
    """Return a body, which has the scene's mass, and its shape if there is a plane for it to touch.

    As it ships it has its shape anyway: Box3D puts a body without one to sleep however it spins.
    """
    body, about = world.scene.body, lib.b3DefaultBodyDef()
    about.type = lib.b3_dynamicBody
    about.allowFastRotation = not world.defaults
    made = lib.b3CreateBody(world.id, ffi.addressof(about))
    if world.scene.plane is not None or world.defaults:
        add_shape(made, world.scene.plane, body)
    mass = ffi.new("b3MassData*")
    mass.mass = world.scale * body.mass
    mass.inertia.cx.x, mass.inertia.cy.y, mass.inertia.cz.z = (world.scale * body.moments).tolist()
    lib.b3Body_SetMassData(made, mass[0])
    return made


# Of collisions: what a shape is, and what it touches.
THROWN, GROUND = (1, 2), (2, 1)


def lay(world: World, plane: Any) -> None:
    """Lay the plane: Box3D has none, so that it is the top of a box that reaches further than any throw can get."""
    scene, about = world.scene, lib.b3DefaultBodyDef()
    time, start = scene.duration, scene.start
    pull = 0.0 if scene.gravity is None else float(np.linalg.norm(scene.gravity))
    kicks = sum(float(np.linalg.norm(impulse.value)) for impulse in scene.impulses) / scene.body.mass
    away = np.linalg.norm(start[:, 0:3] - plane.point, axis=1) + time * np.linalg.norm(start[:, 7:10], axis=1)
    far = float(away.max()) + 4 * scene.body.reach + kicks * time + pull * time**2 / 2
    about.position = tuple(plane.point.tolist())
    w, x, y, z = turn_onto(np.array((0.0, 1.0, 0.0)), plane.normal).tolist()
    about.rotation = ((x, y, z), w)
    hull = ffi.new("b3BoxHull*", lib.b3MakeOffsetBoxHull(far, far, far, (0.0, -far, 0.0)))
    about_shape = of_pair(plane, GROUND)
    body = lib.b3CreateBody(world.id, ffi.addressof(about))
    lib.b3CreateHullShape(body, ffi.addressof(about_shape), ffi.addressof(hull.base))


def of_pair(plane: Any, group: tuple[int, int]) -> Any:
    """Return a shape's description with the pair's coefficients, if there is a plane.

    Of two materials Box3D takes the larger restitution and the geometric mean of the friction.
    """
    about = lib.b3DefaultShapeDef()
    if plane is not None:
        about.baseMaterial.restitution, about.baseMaterial.friction = plane.restitution, plane.friction
    about.filter.categoryBits, about.filter.maskBits = group
    return about


def add_shape(made: Any, plane: Any, body: Any) -> None:
    """Give a body its shape: a sphere, a box, or the convex hull of the points, of a disc that of a prism."""
    about = of_pair(plane, THROWN)
    if body.radius is not None:
        sphere = ffi.new("b3Sphere*", ((0.0, 0.0, 0.0), body.radius))
        lib.b3CreateSphereShape(made, ffi.addressof(about), sphere)
    elif body.size is not None:
        box = ffi.new("b3BoxHull*", lib.b3MakeBoxHull(*(body.size / 2).tolist()))
        lib.b3CreateHullShape(made, ffi.addressof(about), ffi.addressof(box.base))
    else:
        corners = body.points if body.disc is None else prism(*cylinder(body.disc))
        points = ffi.new("b3Vec3[]", [tuple(point) for point in corners.tolist()])
        hull = lib.b3CreateHull(points, len(corners), len(corners))
        if hull == ffi.NULL:
            raise NotImplementedError("it makes no convex hull of these points")
        lib.b3CreateHullShape(made, ffi.addressof(about), hull)
        lib.b3DestroyHull(hull)


def prism(radius: float, half: float) -> NDArray[np.float64]:
    """Return the corners of the prism that stands for a disc about the z axis, (2 SIDES, 3) [m]."""
    angles = 2 * np.pi * np.arange(SIDES) / SIDES
    circle = radius * np.column_stack((np.cos(angles), np.sin(angles)))
    return np.concatenate([np.column_stack((circle, np.full(SIDES, z))) for z in (-half, half)])


def write(world: World, states: NDArray[np.float64]) -> None:
    """Put the throws into these states, (N, 13); what Box3D keeps of contacts goes with its world."""
    if world.scene.plane is not None and world.steps:
        fill(world)
    lib.b3SetLengthUnitsPerMeter(world.units)
    for body, state in zip(world.bodies, states.tolist(), strict=True):
        w, x, y, z = state[3:7]
        lib.b3Body_SetTransform(body, tuple(state[0:3]), ((x, y, z), w))
        lib.b3Body_SetAwake(body, True)
        lib.b3Body_SetLinearVelocity(body, tuple(state[7:10]))
        lib.b3Body_SetAngularVelocity(body, tuple(state[10:13]))
    world.steps, world.longest, world.fastest, world.spinning = 0, 0.0, 0.0, 0.0
    world.written = read(world)


def advance(world: World, n: int, dt: float) -> None:
    """Make n steps of dt [s]."""
    world.steps += n
    world.longest = max(world.longest, dt)
    lib.b3SetLengthUnitsPerMeter(world.units)  # of all worlds of the process
    if world.held is None:
        shim.rxWorldStepN(world.id, dt, world.substeps, n)
    else:
        for _ in range(n):
            hold(world, world.held)
            lib.b3World_Step(world.id, dt, world.substeps)


def hold(world: World, held: "Wrench") -> None:
    """Apply the forces of the states as they are; a step uses them up."""
    for body, total in zip(world.bodies, (world.scale * held(read(world))).tolist(), strict=True):
        lib.b3Body_ApplyForceToCenter(body, tuple(total[0:3]), True)
        lib.b3Body_ApplyTorque(body, tuple(total[3:6]), True)


def read(world: World) -> NDArray[np.float64]:
    """Return the states of the throws, (N, 13)."""
    states = np.empty((len(world.bodies), 13))
    for state, body in zip(states, world.bodies, strict=True):
        x, q = lib.b3Body_GetPosition(body), lib.b3Body_GetRotation(body)
        v, spin = lib.b3Body_GetLinearVelocity(body), lib.b3Body_GetAngularVelocity(body)
        state[:] = x.x, x.y, x.z, q.s, q.v.x, q.v.y, q.v.z, v.x, v.y, v.z, spin.x, spin.y, spin.z
    world.fastest = max(world.fastest, float(np.linalg.norm(states[:, 7:10], axis=1).max(initial=0.0)))
    world.spinning = max(world.spinning, float(np.linalg.norm(states[:, 10:13], axis=1).max(initial=0.0)))
    return states


def audit(world: World) -> Iterator[tuple[str, str]]:
    """Yield what went wrong without a word since `write`; speeds are known where the state was written or read."""
    yield from stood_still(world.written, read(world), world.steps)
    if world.defaults and world.longest:
        yield from beyond("|v|", "m/s", world.fastest, LARGEST_SPEED)
        yield from beyond("|w|", "rad/s", world.spinning, CAPPED_TURN / world.longest)
