"""ODE, by Debian's package of Py3ODE: double precision, semi-implicit Euler, the gyroscopic torque taken implicitly.

(I - h [L]) w' = L in world axes: the momentum at the start of a step stands in for that at its end.  Its own stepper
for scenes with contacts, `quickstep`, is another way to free bodies too.  It has none of a scene's forces but gravity:
`+held` is given them once a step.  Every vector is in world axes; its quaternions are w x y z.
"""

# Its module is in an environment of its own; where it is not, its name is this file's.
# pyright: reportMissingImports=false, reportAttributeAccessIssue=false, reportCallIssue=false

import importlib.metadata
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import ode
from numpy.typing import NDArray

from tumble.compare.engines.parts.audits import stood_still
from tumble.compare.engines.parts.held import held_wrench

if TYPE_CHECKING:
    from tumble.scenarios.scene import Scene
    from tumble.scenarios.wrench import Wrench

METHODS = ("step", "quickstep")
FORCED = ("step+held", "quickstep+held")
ON_REQUEST = ("step+defaults",)
FEATURES = {"gravity", "tether", "drag", "floor"}
STEP_NS = 2000
PACKAGES = ("Py3ODE",)
PINS = ("Py3ODE==1.2.0.dev15", "numpy==2.4.6")
INSTALLER = "apt"
DEBIAN = ("python3-pyode", "libode8", "libccd2")
APART = True
MEGABYTES = 110
SCHEMES = dict.fromkeys((*FORCED, *ON_REQUEST), "semi-implicit-euler")
GYROSCOPIC = dict.fromkeys(METHODS, "implicit")
ABOUT = {
    "version": importlib.metadata.version("Py3ODE"),
    "precision": "double",
    "switched_off": ["rotation to first order in the step: a finite rotation takes the same time"],
    "defaults": ["rotation to first order in the step", "nothing damps, limits or falls asleep"],
}


@dataclass(eq=False)
class World:
    """A world with one body a throw; held: what gives the wrench of a step; written: the states as ODE has them."""

    world: Any
    bodies: list[Any]
    quick: bool
    held: "Wrench | None"
    written: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 13)))
    steps: int = 0


def build(scene: "Scene", method: str) -> World:
    """Return a world with the scene's body once for every throw."""
    kind, _, manner = method.partition("+")
    held = held_wrench(scene, method)
    world = World(ode.World(), [], kind == "quickstep", held)
    world.world.setGravity((0.0, 0.0, 0.0) if scene.gravity is None else tuple(scene.gravity.tolist()))
    mass = ode.Mass()
    mass.setParameters(scene.body.mass, 0.0, 0.0, 0.0, *scene.body.moments.tolist(), 0.0, 0.0, 0.0)
    for _ in scene.start:
        body = ode.Body(world.world)
        body.setMass(mass)
        body.setFiniteRotationMode(manner != "defaults")
        world.bodies.append(body)
    return world


def write(world: World, states: NDArray[np.float64]) -> None:
    """Put the throws into these states, (N, 13)."""
    for body, state in zip(world.bodies, states.tolist(), strict=True):
        body.setPosition(tuple(state[0:3]))
        body.setQuaternion(tuple(state[3:7]))
        body.setLinearVel(tuple(state[7:10]))
        body.setAngularVel(tuple(state[10:13]))
        body.setForce((0.0, 0.0, 0.0))
        body.setTorque((0.0, 0.0, 0.0))
    world.steps = 0
    world.written = read(world)


def advance(world: World, n: int, dt: float) -> None:
    """Make n steps of dt [s]."""
    world.steps += n
    step = world.world.quickStep if world.quick else world.world.step
    if world.held is None:
        for _ in range(n):
            step(dt)
    else:
        for _ in range(n):
            hold(world, world.held)
            step(dt)


def hold(world: World, held: "Wrench") -> None:
    """Apply the forces of the states as they are; a step uses them up."""
    for body, total in zip(world.bodies, held(read(world)).tolist(), strict=True):
        body.addForce(tuple(total[0:3]))
        body.addTorque(tuple(total[3:6]))


def read(world: World) -> NDArray[np.float64]:
    """Return the states of the throws, (N, 13)."""
    states = np.empty((len(world.bodies), 13))
    for state, body in zip(states, world.bodies, strict=True):
        state[:] = (*body.getPosition(), *body.getQuaternion(), *body.getLinearVel(), *body.getAngularVel())
    return states


def audit(world: World) -> Iterator[tuple[str, str]]:
    """Yield what went wrong without a word since `write`."""
    yield from stood_still(world.written, read(world), world.steps)
