"""Drake: explicit Runge-Kutta methods with a fixed step or error control, and its discrete plant.

Under error control each throw has a simulator of its own: one for all would choose its steps by all of them.

It has none of a scene's forces but gravity: `+held` is given them once a step, and error control, whose steps are its
own, cannot be.  `error-controlled+defaults` is its simulator as it ships.  A floating body's coordinates are its
quaternion w x y z and then its position, its velocities w and then v, all in world axes.
"""

# Its wheel is in an environment of its own.
# pyright: reportMissingImports=false

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import ExternallyAppliedSpatialForce, MultibodyPlant
from pydrake.multibody.tree import SpatialInertia, UnitInertia
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator
from pydrake.systems.sensors import Accelerometer, Gyroscope

from tumble.compare.engines.parts.audits import stood_still
from tumble.compare.engines.parts.held import held_wrench

if TYPE_CHECKING:
    from tumble.scenarios.scene import Scene
    from tumble.scenarios.wrench import Wrench

INTEGRATORS = {"rk3": "runge_kutta3", "rk5": "runge_kutta5"}
ADAPTIVE = {"error-controlled": 1e-9}  # runge_kutta5; as Drake ships it is runge_kutta3 to 1e-4
METHODS = (*INTEGRATORS, "discrete", *ADAPTIVE)
WHOLE = ("error-controlled+defaults",)  # its accuracy is what it is
FORCED = ("rk3+held", "rk5+held", "discrete+held")
ON_REQUEST = ("error-controlled+defaults",)
FEATURES = {"gravity", "tether", "drag", "floor"}
STEP_NS = 20_000
PACKAGES = ("drake",)
PINS = ("drake==1.51.1", "numpy==2.4.6")
APART = True
MEGABYTES = 420
# A force that is held makes a parabola, which the others take without an error.
SCHEMES = {"rk3+held": "held-parabola", "rk5+held": "held-parabola", "discrete+held": "semi-implicit-euler"}
GYROSCOPIC = {"discrete": "explicit"}
ORDERS = {"rk3": 3.0, "rk5": 5.0}
ABOUT = {
    "version": version("drake"),
    "precision": "double",
    "switched_off": [
        "error control, but of error-controlled: the step is the one asked for",
        "geometry",
        "the check of a body's moments",
    ],
    "defaults": [
        "runge_kutta3 with error control at an accuracy of 1e-4 and steps of 0.1 s at most",
        "gravity of 9.81 m/s2 along -z",
    ],
}


# Of a plant's outputs on its bodies, those that its sensors take, in the order of their inputs.
PARTS = ("poses", "spatial_velocities", "spatial_accelerations")


@dataclass(eq=False)
class World:
    """The scene, and a plant with its body once for every throw, in a simulator whose clock began `steps` steps ago.

    accuracy: of error control, None without it, 0 for its own; held: what gives the wrench of a step; dt [s]: the step
    that the simulator is for.
    written: the states as Drake has them, (N, 13).
    """

    scene: "Scene"
    method: str
    plant: Any
    simulator: Any
    accuracy: float | None = None
    held: "Wrench | None" = None
    dt: float = 0.0
    steps: int = 0
    written: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 13)))
    moved: int = 0


@dataclass(eq=False)
class Apart:
    """A world for each throw."""

    worlds: list[World]


def build(scene: "Scene", method: str) -> World | Apart:
    """Return a world with the scene's body once for every throw, or one for every throw."""
    asked, _, accuracy = method.partition("@")
    kind, _, manner = asked.partition("+")
    if kind in ADAPTIVE:
        if not scene.is_free:
            raise NotImplementedError(
                "it has none of these laws itself, and takes no force from outside in steps of its own"
            )
        own = 0.0 if manner else float(accuracy or ADAPTIVE[kind])
        alone = (replace(scene, start=start[np.newaxis]) for start in scene.start)
        return Apart([World(one, kind, plant := plant_of(one, 0.0), Simulator(plant), own) for one in alone])
    held = held_wrench(scene, method)
    plant = plant_of(scene, 0.0)
    return World(scene, kind, plant, Simulator(plant), held=held)


def plant_of(scene: "Scene", time_step: float) -> Any:
    """Return a plant that is continuous for a time step of 0 [s], else discrete with that."""
    plant = MultibodyPlant(time_step)
    body = scene.body
    inertia = SpatialInertia(body.mass, np.zeros(3), UnitInertia(*(body.moments / body.mass)), skip_validity_check=True)
    for number in range(len(scene.start)):
        plant.AddRigidBody(f"throw {number}", inertia)
    plant.mutable_gravity_field().set_gravity_vector(np.zeros(3) if scene.gravity is None else scene.gravity)
    if scene.sensors and time_step:
        # As sampled they have the acceleration of the step before.
        plant.SetUseSampledOutputPorts(False)
    plant.Finalize()
    return plant


def prepare(world: World | Apart, dt: float) -> None:
    """Make a simulator for steps of dt [s] that goes on from the state as it is."""
    if isinstance(world, Apart):
        for one in world.worlds:
            prepare(one, dt)
        return
    if dt == world.dt:
        return
    context = world.simulator.get_context()
    q, v = world.plant.GetPositions(context), world.plant.GetVelocities(context)
    if world.method == "discrete":
        world.plant = plant_of(world.scene, dt)
    world.simulator = Simulator(world.plant)
    world.dt = dt
    restart(world, q, v)


def restart(world: World, q: NDArray[np.float64], v: NDArray[np.float64]) -> None:
    """Set the clock to 0 and the state to these coordinates and velocities."""
    context = world.simulator.get_mutable_context()
    context.SetTime(0.0)
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


def write(world: World | Apart, states: NDArray[np.float64]) -> None:
    """Put the throws into these states, (N, 13)."""
    if isinstance(world, Apart):
        for one, state in zip(world.worlds, states, strict=True):
            write(one, state[np.newaxis])
        return
    q = states[:, 3:7] / np.linalg.norm(states[:, 3:7], axis=1, keepdims=True)
    positions = np.hstack((q, states[:, 0:3])).ravel()
    restart(world, positions, np.hstack((states[:, 10:13], states[:, 7:10])).ravel())
    world.moved = 0
    world.written = read(world)


def advance(world: World | Apart, n: int, dt: float) -> None:
    """Make n steps of dt [s], as prepared for: each to an instant that is counted, so that none is left over."""
    if isinstance(world, Apart):
        for one in world.worlds:
            advance(one, n, dt)
        return
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
    port.FixValue(world.simulator.get_mutable_context(), forces)


def read(world: World | Apart) -> NDArray[np.float64]:
    """Return the states of the throws, (N, 13)."""
    if isinstance(world, Apart):
        return np.vstack([read(one) for one in world.worlds])
    context = world.simulator.get_context()
    positions = world.plant.GetPositions(context).reshape(-1, 7)
    velocities = world.plant.GetVelocities(context).reshape(-1, 6)
    with np.errstate(all="ignore"):  # of a flight that blew up
        q = positions[:, 0:4] / np.linalg.norm(positions[:, 0:4], axis=1, keepdims=True)
    return np.hstack((positions[:, 4:7], q, velocities[:, 3:6], velocities[:, 0:3]))


def sense(world: World | Apart) -> NDArray[np.float64]:
    """Return what its Accelerometers and Gyroscopes read in the state as it is, (N, S, 6)."""
    if isinstance(world, Apart):
        return np.vstack([sense(one) for one in world.worlds])
    if world.held is not None:
        hold(world, world.held)
    plant, context = world.plant, world.simulator.get_context()
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


def audit(world: World | Apart) -> Iterator[tuple[str, str]]:
    """Yield what went wrong without a word since `write`."""
    if isinstance(world, Apart):
        for one in world.worlds:
            yield from audit(one)
        return
    yield from stood_still(world.written, read(world), world.moved)
