"""Drake: explicit Runge-Kutta methods with a fixed step, and its discrete plant, whose step is fixed when built.

It is given none of a scene's forces but gravity.  A floating body's coordinates are its quaternion w x y z and then its
position, its velocities w and then v, all in world axes.
"""

# Its wheel is in an environment of its own.
# pyright: reportMissingImports=false

from collections.abc import Iterator
from dataclasses import dataclass, field
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import SpatialInertia, UnitInertia
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator

from compare.engines.parts.audits import stood_still

if TYPE_CHECKING:
    from scenarios.scene import Scene

INTEGRATORS = {"rk3": "runge_kutta3", "rk5": "runge_kutta5"}
METHODS = (*INTEGRATORS, "discrete")
FEATURES = {"gravity"}
STEP_NS = 20_000
PACKAGES = ("drake",)
PINS = ("drake==1.51.1", "numpy==2.4.6")
APART = True
MEGABYTES = 420
GYROSCOPIC = {"discrete": "explicit"}
ABOUT = {
    "version": version("drake"),
    "precision": "double",
    "switched_off": [
        "error control: the step is the one asked for",
        "geometry",
        "the check of a body's moments",
    ],
    "defaults": ["runge_kutta3 with error control at an accuracy of 1e-3, gravity of 9.81 m/s2 along -z"],
}


@dataclass(eq=False)
class World:
    """The scene, and a plant with its body once for every throw, in a simulator whose clock began `steps` steps ago.

    dt [s]: the step that the simulator is for.  written: the states as Drake has them, (N, 13).
    """

    scene: "Scene"
    method: str
    plant: Any
    simulator: Any
    dt: float = 0.0
    steps: int = 0
    written: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 13)))
    moved: int = 0


def build(scene: "Scene", method: str) -> World:
    """Return a world with the scene's body once for every throw."""
    plant = plant_of(scene, 0.0)
    return World(scene, method, plant, Simulator(plant))


def plant_of(scene: "Scene", time_step: float) -> Any:
    """Return a plant that is continuous for a time step of 0 [s], else discrete with that."""
    plant = MultibodyPlant(time_step)
    body = scene.body
    inertia = SpatialInertia(body.mass, np.zeros(3), UnitInertia(*(body.moments / body.mass)), skip_validity_check=True)
    for number in range(len(scene.start)):
        plant.AddRigidBody(f"throw {number}", inertia)
    plant.mutable_gravity_field().set_gravity_vector(np.zeros(3) if scene.gravity is None else scene.gravity)
    plant.Finalize()
    return plant


def prepare(world: World, dt: float) -> None:
    """Make a simulator for steps of dt [s] that goes on from the state as it is."""
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
    world.simulator.Initialize()
    world.steps = 0


def write(world: World, states: NDArray[np.float64]) -> None:
    """Put the throws into these states, (N, 13)."""
    q = states[:, 3:7] / np.linalg.norm(states[:, 3:7], axis=1, keepdims=True)
    positions = np.hstack((q, states[:, 0:3])).ravel()
    restart(world, positions, np.hstack((states[:, 10:13], states[:, 7:10])).ravel())
    world.moved = 0
    world.written = read(world)


def advance(world: World, n: int, dt: float) -> None:
    """Make n steps of dt [s], as prepared for: each to an instant that is counted, so that none is left over."""
    first, world.steps = world.steps, world.steps + n
    world.moved += n
    go = world.simulator.AdvanceTo
    if world.method == "discrete":
        go(world.steps * dt)
    else:
        for k in range(first, world.steps):
            go((k + 1) * dt)


def read(world: World) -> NDArray[np.float64]:
    """Return the states of the throws, (N, 13)."""
    context = world.simulator.get_context()
    positions = world.plant.GetPositions(context).reshape(-1, 7)
    velocities = world.plant.GetVelocities(context).reshape(-1, 6)
    q = positions[:, 0:4] / np.linalg.norm(positions[:, 0:4], axis=1, keepdims=True)
    return np.hstack((positions[:, 4:7], q, velocities[:, 3:6], velocities[:, 0:3]))


def audit(world: World) -> Iterator[tuple[str, str]]:
    """Yield what went wrong without a word since `write`."""
    yield from stood_still(world.written, read(world), world.moved)
