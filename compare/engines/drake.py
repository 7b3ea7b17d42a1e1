"""Drake: explicit Runge-Kutta methods with a fixed step or error control, and its discrete plant.

Under error control each throw has a simulator of its own: one for all would choose its steps by all of them.

It has none of a scene's forces but gravity: `+held` is given them once a step, and error control, whose steps are its
own, cannot be.  `error-controlled+defaults` is its simulator as it ships.

Above a plane bodies are compliant and the plane is rigid.  A sphere has a spring at its deepest point, other bodies
hydroelastic contact; with `+point` they have that spring too, which of a face is one.  It has no restitution, but a
dissipation by which the rebound falls with the speed (Hunt & Crossley): it is set for the scene's at the speed of the
first impact.  Two bodies' friction is 2 a b / (a + b): both have the scene's.

A floating body's coordinates are its quaternion w x y z and then its position, its velocities w and then v, all in
world axes.
"""

# Its wheel is in an environment of its own.
# pyright: reportMissingImports=false

import logging
import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from pydrake.common import MemoryFile
from pydrake.common.eigen_geometry import Quaternion
from pydrake.geometry import (
    AddCompliantHydroelasticProperties,
    AddContactMaterial,
    AddRigidHydroelasticProperties,
    Box,
    CollisionFilterDeclaration,
    Convex,
    Cylinder,
    GeometrySet,
    HalfSpace,
    InMemoryMesh,
    ProximityProperties,
    Sphere,
)
from pydrake.math import RigidTransform
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import (
    AddMultibodyPlantSceneGraph,
    ContactModel,
    CoulombFriction,
    ExternallyAppliedSpatialForce,
    MultibodyPlant,
)
from pydrake.multibody.tree import SpatialInertia, UnitInertia
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.sensors import Accelerometer, Gyroscope

from tumble.compare.engines.parts.apart import Apart, from_each, in_each, of_each, to_each
from tumble.compare.engines.parts.audits import stood_still
from tumble.compare.engines.parts.cylinder import cylinder
from tumble.compare.engines.parts.held import held_wrench
from tumble.compare.engines.parts.impact import approach_speed, impact_duration
from tumble.compare.engines.parts.soft_law import HUNT_CROSSLEY, SoftLaw

if TYPE_CHECKING:
    from tumble.scenarios.scene import Body, Scene
    from tumble.scenarios.wrench import Wrench

logging.getLogger("drake").setLevel(logging.ERROR)  # that a rigid half space meets no deformable body

INTEGRATORS = {"rk3": "runge_kutta3", "rk5": "runge_kutta5"}
ADAPTIVE = {"error-controlled": 1e-9}  # runge_kutta5; as Drake ships it is runge_kutta3 to 1e-4
METHODS = (*INTEGRATORS, "discrete", *ADAPTIVE)
WHOLE = ("error-controlled+defaults",)  # its accuracy is what it is
FORCED = ("rk3+held", "rk5+held", "discrete+held")
CONTACT = ("discrete+point",)
ON_REQUEST = ("error-controlled+defaults",)
FEATURES = {"gravity", "tether", "drag", "floor", "plane"}
STEP_NS = 20_000
PACKAGES = ("drake",)
PINS = ("drake==1.51.1", "numpy==2.4.6")
APART = True
MEGABYTES = 420
# A force that is held makes a parabola, which the others take without an error.
SCHEMES = {"rk3+held": "held-parabola", "rk5+held": "held-parabola", "discrete+held": "semi-implicit-euler"}
ON_SLOPES = "its friction is viscous below a speed, which falls with the step"
FALLS_WITH_STEP = "its implicit step damps the spring of an impact, the less the shorter the step"
KNOWN_FAILURES = {
    "restitution": {"discrete": FALLS_WITH_STEP, "discrete+point": FALLS_WITH_STEP},
    "holds": {"rk3": ON_SLOPES, "rk5": ON_SLOPES},
    "mirror images": {"discrete+point": "an edge meets a plane with one point"},
}
GYROSCOPIC = {"discrete": "explicit"}
ORDERS = {"rk3": 3.0, "rk5": 5.0}
ABOUT = {
    "version": version("drake"),
    "precision": "double",
    "switched_off": [
        "error control, but of error-controlled: the step is the one asked for",
        "geometry without a plane",
        "the check of a body's moments",
    ],
    "defaults": [
        "contact: springs by a penetration of 1 mm, friction viscous below 1 mm/s, no restitution",
        "runge_kutta3 with error control at an accuracy of 1e-4 and steps of 0.1 s at most",
        "gravity of 9.81 m/s2 along -z",
    ],
}

# Of contact: the stiffness of the plane against the body's, the least restitution that the dissipation is set for, the
# modulus [Pa] of who sets none, Drake's advice for stiff bodies, and how many times less than an explicit method's the
# slip is below which the discrete plant's friction is viscous.
RIGID, LEAST_RESTITUTION, SHIPPED_MODULUS, STICTION = 1e9, 0.02, 1e7, 1e-3
# Steps [s] that contact is made for: until one is known, and under error control.
FIRST_STEP, OWN_STEPS = 1e-3, 1e-4
# Of a disc's radius: how finely its rim is cut for a hydroelastic contact.
FINE = 1 / 16


# Of a plant's outputs on its bodies, those that its sensors take, in the order of their inputs.
PARTS = ("poses", "spatial_velocities", "spatial_accelerations")


@dataclass(eq=False)
class World:
    """The scene, and a plant with its body once for every throw, in a simulator whose clock began `steps` steps ago.

    method: without its manner; point: whether contact is a spring at the deepest point; shipped: whether its settings
    are Drake's own.  accuracy: of error control, None without it, 0 for its own; held: what gives the wrench of a step;
    dt [s]: the step that the simulator is for.
    written: the states as Drake has them, (N, 13).
    """

    scene: "Scene"
    method: str
    plant: Any
    simulator: Any
    accuracy: float | None = None
    held: "Wrench | None" = None
    point: bool = False
    shipped: bool = False
    dt: float = 0.0
    steps: int = 0
    written: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 13)))
    moved: int = 0


def build(scene: "Scene", method: str) -> World | Apart:
    """Return a world with the scene's body once for every throw, or one for every throw."""
    asked, _, accuracy = method.partition("@")
    kind, _, manner = asked.partition("+")
    if kind in ADAPTIVE:
        if not scene.is_unforced:
            raise NotImplementedError(
                "it has none of these laws itself, and takes no force from outside in steps of its own"
            )
        if scene.plane and not manner:
            raise NotImplementedError("an explicit method under error control does not get through stiff contact")
        own = 0.0 if manner else float(accuracy or ADAPTIVE[kind])
        alone = (replace(scene, start=start[np.newaxis]) for start in scene.start)
        return Apart([placed(World(one, kind, None, None, own, shipped=bool(manner)), OWN_STEPS) for one in alone])
    if scene.plane and len(scene.start) > 1:
        return Apart([build(replace(scene, start=start[np.newaxis]), method) for start in scene.start])
    held = held_wrench(scene, kind if method in CONTACT else method)
    return placed(World(scene, kind, None, None, held=held, point=method in CONTACT), 0.0)


def placed(world: World, contact_dt: float) -> World:
    """Give the world a plant and a simulator; contact_dt [s]: the step that contact is made for."""
    time_step = world.dt if world.method == "discrete" else 0.0
    if world.scene.plane is None:
        world.plant = plant_of(world.scene, time_step)
        world.simulator = Simulator(world.plant)
    else:
        builder = DiagramBuilder()
        world.plant = plant_of(world.scene, time_step, builder, world, contact_dt or FIRST_STEP)
        world.simulator = Simulator(builder.Build())
    return world


def context_of(world: World) -> Any:
    """Return the plant's context, which can be written."""
    root = world.simulator.get_mutable_context()
    return root if world.scene.plane is None else world.plant.GetMyMutableContextFromRoot(root)


def touch(plant: Any, scene_graph: Any, world: World, contact_dt: float) -> None:
    """Register the plane and a shape for every throw, which meet the plane alone."""
    scene, plane, body = world.scene, world.scene.plane, world.scene.body
    assert plane is not None
    plant.set_contact_model(ContactModel.kPoint if world.point else ContactModel.kHydroelasticWithFallback)
    friction = CoulombFriction(plane.friction, plane.friction)
    of_plane, of_body = ProximityProperties(), ProximityProperties()
    AddRigidHydroelasticProperties(body.reach, of_plane)
    if world.shipped:
        AddContactMaterial(None, None, friction, of_plane)
        AddContactMaterial(None, None, friction, of_body)
        modulus = SHIPPED_MODULUS
    else:
        stiffness, dissipation = spring(scene, contact_dt, world.method)
        AddContactMaterial(0.0, RIGID * stiffness, friction, of_plane)
        AddContactMaterial(dissipation, stiffness, friction, of_body)
        modulus = stiffness / body.reach
        share = STICTION if world.method == "discrete" else 1.0
        plant.set_stiction_tolerance(share * slowest(scene, contact_dt))
    if body.radius is None:  # a sphere's surface would be one of triangles
        grain = body.reach if body.disc is None else FINE * body.disc.radius
        AddCompliantHydroelasticProperties(grain, modulus, of_body)
    half_space = HalfSpace.MakePose(plane.normal, plane.point)
    ids = [plant.RegisterCollisionGeometry(plant.world_body(), half_space, HalfSpace(), "plane", of_plane)]
    for number in range(len(scene.start)):
        of_throw = plant.GetBodyByName(f"throw {number}")
        ids.append(plant.RegisterCollisionGeometry(of_throw, RigidTransform(), shape_of(body), "body", of_body))
    filters = scene_graph.collision_filter_manager()
    filters.Apply(CollisionFilterDeclaration().ExcludeWithin(GeometrySet(ids[1:])))


def shape_of(body: "Body") -> Any:
    """Return a sphere, a cylinder, a box, or the convex hull of the body's points."""
    if body.radius is not None:
        return Sphere(body.radius)
    if body.disc is not None:
        radius, half = cylinder(body.disc)
        return Cylinder(radius, 2 * half)
    if body.size is not None:
        return Box(*body.size)
    points = "".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in body.points.tolist())
    fan = "".join(f"f 1 {n} {n + 1}\n" for n in range(2, len(body.points)))
    return Convex(InMemoryMesh(mesh_file=MemoryFile(points + fan, ".obj", "hull")))


def spring(scene: "Scene", dt: float, method: str) -> tuple[float, float]:
    """Return stiffness [N/m] and dissipation [s/m] of a contact for steps of dt [s].

    The discrete plant's friction goes by the normal force of the step before: an impact has to last some steps.

    Of F = k x (1 + d x'), started with speed v, the restitution e fulfils d v (1 + e) = log((1 + d v) / (1 - d v e)).
    Source: Hunt & Crossley, J. Appl. Mech. 42 (1975) 440, integrated.
    """
    plane = scene.plane
    assert plane is not None
    duration = impact_duration(scene, dt)
    stiffness = scene.body.mass * (math.pi / duration) ** 2
    gravity = 0.0 if scene.gravity is None else math.hypot(*scene.gravity)
    speed = max(approach_speed(scene), gravity * duration)
    lost = dissipation_of(max(plane.restitution, LEAST_RESTITUTION))
    if method in INTEGRATORS:
        lost = min(lost, duration / (math.pi * dt))  # an explicit method is not stable for more
    return stiffness, lost / max(speed, 1e-9)


def soft_law(world: World | Apart) -> SoftLaw | None:
    """Return the law of a contact point, but of Drake's own settings."""
    if isinstance(world, Apart) or world.shipped or not world.dt:
        return None
    return SoftLaw(HUNT_CROSSLEY, *spring(world.scene, world.dt, world.method))


def dissipation_of(restitution: float) -> float:
    """Return d v with that restitution, above 0 and at most 1."""
    if restitution >= 1:
        return 0.0
    low, high = 0.0, 1.0 / restitution
    for _ in range(200):
        middle = (low + high) / 2
        inside = 1 - middle * restitution
        lost = inside > 0 and middle * (1 + restitution) > math.log((1 + middle) / inside)
        low, high = (middle, high) if lost else (low, middle)
    return low


def slowest(scene: "Scene", dt: float) -> float:
    """Return the slip below which friction is viscous [m/s]: such that it stops it in a few steps of dt [s]."""
    assert scene.plane is not None
    gravity = 1.0 if scene.gravity is None else math.hypot(*scene.gravity)
    return 4 * max(scene.plane.friction, 0.01) * gravity * dt


def plant_of(
    scene: "Scene", time_step: float, builder: Any = None, world: World | None = None, contact_dt: float = 0.0
) -> Any:
    """Return a plant that is continuous for a time step of 0 [s], else discrete with that.

    builder: of a diagram with geometry, where the scene has a plane; world, contact_dt: what its contact is made by.
    """
    plant = MultibodyPlant(time_step)
    scene_graph = AddMultibodyPlantSceneGraph(builder, plant)[1] if builder else None
    body = scene.body
    inertia = SpatialInertia(body.mass, np.zeros(3), UnitInertia(*(body.moments / body.mass)), skip_validity_check=True)
    for number in range(len(scene.start)):
        plant.AddRigidBody(f"throw {number}", inertia)
    plant.mutable_gravity_field().set_gravity_vector(np.zeros(3) if scene.gravity is None else scene.gravity)
    if world is not None:
        touch(plant, scene_graph, world, contact_dt)
    if scene.sensors and time_step:
        # As sampled they have the acceleration of the step before.
        plant.SetUseSampledOutputPorts(False)
    plant.Finalize()
    return plant


@in_each
def prepare(world: World, dt: float) -> None:
    """Make a simulator for steps of dt [s] that goes on from the state as it is."""
    if dt == world.dt:
        return
    context = context_of(world)
    q, v = world.plant.GetPositions(context), world.plant.GetVelocities(context)
    world.dt = dt
    if world.method == "discrete" or (world.scene.plane and world.method in INTEGRATORS):
        placed(world, dt)
    else:
        world.simulator = Simulator(world.simulator.get_system())
    restart(world, q, v)


def restart(world: World, q: NDArray[np.float64], v: NDArray[np.float64]) -> None:
    """Set the clock to 0 and the state to these coordinates and velocities."""
    world.simulator.get_mutable_context().SetTime(0.0)
    context = context_of(world)
    world.plant.SetPositions(context, q)
    world.plant.SetVelocities(context, v)
    if world.dt and world.method in INTEGRATORS:
        integrator = ResetIntegratorFromFlags(world.simulator, INTEGRATORS[world.method], world.dt)
        integrator.set_fixed_step_mode(True)
    elif world.dt and world.accuracy:
        # Where it begins with a longer step than a turn it may not come back.
        longest = min(world.dt, 1.0 / max(1e-9, float(np.abs(v).max())))
        integrator = ResetIntegratorFromFlags(world.simulator, "runge_kutta5", longest)
        integrator.set_fixed_step_mode(False)
        integrator.set_target_accuracy(world.accuracy)
    world.simulator.Initialize()
    world.steps = 0


@to_each
def write(world: World, states: NDArray[np.float64]) -> None:
    """Put the throws into these states, (N, 13)."""
    q = states[:, 3:7] / np.linalg.norm(states[:, 3:7], axis=1, keepdims=True)
    positions = np.hstack((q, states[:, 0:3])).ravel()
    restart(world, positions, np.hstack((states[:, 10:13], states[:, 7:10])).ravel())
    world.moved = 0
    world.written = read(world)


@in_each
def advance(world: World, n: int, dt: float) -> None:
    """Make n steps of dt [s], as prepared for: each to an instant that is counted, so that none is left over."""
    first, world.steps = world.steps, world.steps + n
    world.moved += n
    go = world.simulator.AdvanceTo
    if world.method == "discrete" and world.held is None:
        go(world.steps * dt)
        return
    for k in range(first, world.steps):
        if world.held is not None:
            hold(world, world.held)
        go((k + 1) * dt)


def hold(world: World, held: "Wrench") -> None:
    """Apply the forces of the states as they are, in world axes at the centre of mass, until others are."""
    forces = []
    for number, total in enumerate(held(read(world))):
        force = ExternallyAppliedSpatialForce()
        force.body_index = world.plant.GetBodyByName(f"throw {number}").index()
        force.F_Bq_W = SpatialForce(total[3:6], total[0:3])
        forces.append(force)
    port = world.plant.get_applied_spatial_force_input_port()
    port.FixValue(context_of(world), forces)


@from_each
def read(world: World) -> NDArray[np.float64]:
    """Return the states of the throws, (N, 13)."""
    context = context_of(world)
    positions = world.plant.GetPositions(context).reshape(-1, 7)
    velocities = world.plant.GetVelocities(context).reshape(-1, 6)
    with np.errstate(all="ignore"):  # of a flight that blew up
        q = positions[:, 0:4] / np.linalg.norm(positions[:, 0:4], axis=1, keepdims=True)
    return np.hstack((positions[:, 4:7], q, velocities[:, 3:6], velocities[:, 0:3]))


@from_each
def sense(world: World) -> NDArray[np.float64]:
    """Return what its Accelerometers and Gyroscopes read in the state as it is, (N, S, 6)."""
    if world.held is not None:
        hold(world, world.held)
    plant, context = world.plant, context_of(world)
    gravity = plant.gravity_field().gravity_vector()
    ports = [getattr(plant, f"get_body_{part}_output_port")() for part in PARTS]
    found = np.empty((len(world.scene.start), len(world.scene.sensors), 6))
    for throw, number in np.ndindex(found.shape[:2]):
        sensor, body = world.scene.sensors[number], plant.GetBodyByName(f"throw {throw}")
        turn = sensor.orientation / np.linalg.norm(sensor.orientation)
        mounted = RigidTransform(Quaternion(turn), sensor.point_body)
        read = []
        for device in (Accelerometer(body, mounted, gravity), Gyroscope(body, mounted)):
            own = device.CreateDefaultContext()
            # Their inputs are a plant's outputs: poses, velocities and, of the first, accelerations.
            for port in range(device.num_input_ports()):
                device.get_input_port(port).FixValue(own, ports[port].Eval(context))
            read.append(device.get_measurement_output_port().Eval(own))
        found[throw, number] = np.concatenate(read)
    return found


@of_each
def audit(world: World) -> Iterator[tuple[str, str]]:
    """Yield what went wrong without a word since `write`."""
    yield from stood_still(world.written, read(world), world.moved)
