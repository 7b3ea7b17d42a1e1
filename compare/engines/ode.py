"""ODE, by Debian's package of Py3ODE: double precision, semi-implicit Euler, the gyroscopic torque taken implicitly.

(I - h [L]) w' = L in world axes: the momentum at the start of a step stands in for that at its end.  Its own stepper
for scenes with contacts, `quickstep`, is another way to free bodies too.  It has none of a scene's forces but gravity:
`+held` is given them once a step.  Every vector is in world axes; its quaternions are w x y z.

Contacts are joints that its user makes before every step, here as its manual does: friction within a pyramid of mu
times the normal force, which `+defaults` has not (without that flag mu is a force).
"""

# Its module is in an environment of its own; where it is not, its name is this file's.
# pyright: reportMissingImports=false, reportAttributeAccessIssue=false, reportCallIssue=false

import ctypes
import importlib.metadata
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import ode
from numpy.typing import NDArray

from tumble.compare.engines.parts.audits import stood_still
from tumble.compare.engines.parts.cylinder import cylinder
from tumble.compare.engines.parts.held import held_wrench

if TYPE_CHECKING:
    from tumble.scenarios.scene import Scene
    from tumble.scenarios.wrench import Wrench

METHODS = ("step", "quickstep")
FORCED = ("step+held", "quickstep+held")
ON_REQUEST = ("step+defaults",)
FEATURES = {"gravity", "tether", "drag", "floor", "plane"}
STEP_NS = 2000
PACKAGES = ("Py3ODE",)
PINS = ("Py3ODE==1.2.0.dev15", "numpy==2.4.6")
INSTALLER = "apt"
DEBIAN = ("python3-pyode", "libode8", "libccd2")
APART = True
MEGABYTES = 110
SCHEMES = dict.fromkeys((*FORCED, *ON_REQUEST), "semi-implicit-euler")
GYROSCOPIC = dict.fromkeys(METHODS, "implicit")
KNOWN_FAILURES = {
    "any direction": {"*": "its friction cone is a pyramid: mu N along each of two axes"},
    "friction": {"step+defaults": "a friction coefficient is the largest force [N]"},
    "holds": {"step+defaults": "a friction coefficient is the largest force [N]"},
}
ABOUT = {
    "version": importlib.metadata.version("Py3ODE"),
    "precision": "double",
    "switched_off": [
        "rotation to first order in the step: a finite rotation takes the same time",
        "with a plane, friction of a constant force (a pyramid of mu times the normal force); quickstep's 20 iterations"
        " (100); pushing out at any speed (a tenth of the body's diameter a second)",
    ],
    "defaults": [
        "rotation to first order in the step",
        "nothing damps, limits or falls asleep",
        "a friction coefficient is the largest force, in N",
    ],
}


# With a plane: quickstep's iterations; how fast a body that is below comes up, in diameters a second; where the random
# numbers are, which ODE's Python module does not show.
ITERATIONS, PUSH_OUT = 100, 0.1
random = ctypes.CDLL("libode.so.8")
random.dRandGetSeed.restype, random.dRandSetSeed.argtypes = ctypes.c_ulong, (ctypes.c_ulong,)


@dataclass(eq=False)
class World:
    """Worlds with one body a throw; held: what gives the wrench of a step; written: the states as ODE has them.

    Where there is a plane every throw has a world of its own, and what touches it: quickstep takes constraints at
    random, from numbers that all worlds share.
    """

    worlds: list[Any]
    bodies: list[Any]
    quick: bool
    touching: "list[Touching]"
    held: "Wrench | None"
    written: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 13)))
    steps: int = 0


def build(scene: "Scene", method: str) -> World:
    """Return a world with the scene's body once for every throw."""
    kind, _, manner = method.partition("+")
    worlds, bodies, touching = [], [], []
    mass = ode.Mass()
    mass.setParameters(scene.body.mass, 0.0, 0.0, 0.0, *scene.body.moments.tolist(), 0.0, 0.0, 0.0)
    for _ in scene.start:
        if not worlds or scene.plane is not None:
            worlds.append(world_of(scene, manner == "defaults"))
        body = ode.Body(worlds[-1])
        body.setMass(mass)
        body.setFiniteRotationMode(manner != "defaults")
        bodies.append(body)
        if scene.plane is not None:
            touching.append(Touching(scene, worlds[-1], body, manner != "defaults"))
    return World(worlds, bodies, kind == "quickstep", touching, held_wrench(scene, method))


def world_of(scene: "Scene", defaults: bool) -> Any:
    """Return a world with the scene's gravity."""
    world = ode.World()
    world.setGravity((0.0, 0.0, 0.0) if scene.gravity is None else tuple(scene.gravity.tolist()))
    if scene.plane is not None and not defaults:
        world.setQuickStepNumIterations(ITERATIONS)
        world.setContactMaxCorrectingVel(PUSH_OUT * 2 * scene.body.reach)
    return world


class Touching:
    """A body's shape, the plane, and the joints of their contacts in a step; seed: where ODE's random numbers are."""

    def __init__(self, scene: "Scene", world: Any, body: Any, cone: bool) -> None:
        plane = scene.plane
        assert plane is not None
        self._shape, self._data = shape_of(scene.body)
        self._shape.setBody(body)
        self._plane = ode.GeomPlane(None, tuple(plane.normal.tolist()), float(plane.normal @ plane.point))
        self._world, self._body, self._joints = world, body, ode.JointGroup()
        self._mode = ode.ContactBounce | (ode.ContactApprox1 if cone else 0)
        self._restitution, self._friction = plane.restitution, plane.friction
        self.seed = 0

    def find(self) -> None:
        """Make a joint of every contact, with the pair's coefficients."""
        random.dRandSetSeed(self.seed)
        self._joints.empty()
        for contact in ode.collide(self._shape, self._plane):
            contact.setMode(self._mode)
            contact.setMu(self._friction)
            contact.setBounce(self._restitution)
            contact.setBounceVel(0.0)
            ode.ContactJoint(self._world, self._joints, contact).attach(self._body, ode.environment)

    def forget(self) -> None:
        """Begin anew."""
        self.seed = 0
        self._joints.empty()


def shape_of(body: Any) -> tuple[Any, Any]:
    """Return the body's shape, and what it refers to; of a mesh its vertices touch a plane, those of its hull alone."""
    if body.radius is not None:
        return ode.GeomSphere(None, body.radius), None
    if body.disc is not None:
        radius, half = cylinder(body.disc)
        return ode.GeomCylinder(None, radius, 2 * half), None
    if body.size is not None:
        return ode.GeomBox(None, tuple(body.size.tolist())), None
    if not len(body.faces):
        raise NotImplementedError("its Python package makes no convex hull of points")
    data = ode.TriMeshData()
    data.build(body.points.tolist(), body.faces.tolist())
    return ode.GeomTriMesh(data, None), data


def write(world: World, states: NDArray[np.float64]) -> None:
    """Put the throws into these states, (N, 13)."""
    for body, state in zip(world.bodies, states.tolist(), strict=True):
        body.setPosition(tuple(state[0:3]))
        body.setQuaternion(tuple(state[3:7]))
        body.setLinearVel(tuple(state[7:10]))
        body.setAngularVel(tuple(state[10:13]))
        body.setForce((0.0, 0.0, 0.0))
        body.setTorque((0.0, 0.0, 0.0))
    for each in world.touching:
        each.forget()
    world.steps = 0
    world.written = read(world)


def advance(world: World, n: int, dt: float) -> None:
    """Make n steps of dt [s]."""
    world.steps += n
    steps = [each.quickStep if world.quick else each.step for each in world.worlds]
    if world.held is None and not world.touching:
        (step,) = steps
        for _ in range(n):
            step(dt)
        return
    for _ in range(n):
        if world.held is not None:
            hold(world, world.held)
        if world.touching:
            for step, touching in zip(steps, world.touching, strict=True):
                touching.find()
                step(dt)
                touching.seed = random.dRandGetSeed()
        else:
            steps[0](dt)


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
