"""PyBullet, set up so that nothing but its integrators is compared.

Its two kinds of body are two integrators: `multibody` (btMultiBody, the default kind) takes the gyroscopic torque
explicitly, `rigidbody` (btRigidBody, "maximal coordinates") implicitly.  It has none of a scene's forces but gravity,
its own damping being another law: `+held` is given them once a step and holds them over it, as scripts do.
`+defaults` leaves every setting as PyBullet ships it, and holds the forces too.

A pair's restitution and friction are products: the body has the scene's, and the plane 1.  A contact counts from
touching on, not 2 cm before it.  No penetration is taken out by a velocity, which would add to a rebound: rigidbody
moves the body out apart from that (split impulse), multibody leaves it where it is (contactERP 0).
`rigidbody+recipe` has the settings of bulletphysics/bullet3#3094, and `+defaults` the scene's numbers on both.

Quaternions are x y z w there; every vector is in world axes.
"""

import importlib.metadata
import math
import sys
import weakref
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tumble.compare.engines.parts.cylinder import cylinder
from tumble.compare.engines.parts.scale import scale_to_one
from tumble.compare.engines.parts.silence import silenced_stderr

if TYPE_CHECKING:
    from tumble.scenarios.scene import Plane, Scene
    from tumble.scenarios.wrench import Wrench


with silenced_stderr():  # it prints its build date
    import pybullet

METHODS = ("multibody", "rigidbody")
FORCED = ("multibody+held", "rigidbody+held")
ON_REQUEST = ("multibody+defaults", "rigidbody+defaults", "rigidbody+recipe")
SHOWN = ("multibody", "multibody+defaults", "rigidbody")
LANDING = METHODS
FEATURES = {"gravity", "tether", "drag", "floor", "plane"}
STEP_NS = 1000
REUSES_WORLD = True
OPTIONAL = ("collision shape",)
PACKAGES = ("pybullet",)
PINS = ("pybullet==3.2.7", "numpy==2.4.6")
PYTHON = "3.11"
# Read in btMultiBody.cpp and btRigidBody.cpp; a force of a script's is held over a step by both.
SCHEMES = dict.fromkeys((*FORCED, *ON_REQUEST), "semi-implicit-euler")
PRODUCT = "a pair's friction and restitution are the products of both materials'"
KNOWN_FAILURES = {
    "mirror images": {"*": "an edge meets a plane with one of its vertices first"},
    "friction": dict.fromkeys(("multibody+defaults", "rigidbody+defaults"), PRODUCT),
    "restitution": {
        **dict.fromkeys(("multibody+defaults", "rigidbody+defaults"), PRODUCT),
        "rigidbody+recipe": "the velocity that takes a penetration out adds to a rebound",
    },
}
GYROSCOPIC = {"multibody": "explicit", "rigidbody": "implicit"}
LARGEST_TURN = math.pi / 4  # rad a step; ANGULAR_MOTION_THRESHOLD in Bullet's btTransformUtil.h
ABOUT = {
    "version": importlib.metadata.version("pybullet"),
    "precision": "double",
    "switched_off": [
        "damping (multibody's default slows 10 m/s to 6.9 m/s in 1 s)",
        "multibody's limit of 100 m/s and 100 rad/s on every velocity component",
        "collision shapes and collision pairs without a plane",
        "contact: no restitution below 0.2 m/s, contact before touching, its slop, penetration taken out by a velocity",
        "the residual at which the solver of contacts stops: it makes all 50 iterations",
    ],
    "defaults": [
        "multibody: linear and angular damping 0.04, velocity components cut at 100",
        "contact: friction and restitution of a pair the products of both, no restitution below 0.2 m/s",
    ],
}

NO_SHAPE = -1
BASE = -1  # PyBullet's link index of the body itself
LEAST_PIVOT = sys.float_info.epsilon  # kg m2, or its cube: SIMD_EPSILON, below which Bullet inverts nothing
# The largest friction of a pair: MAX_FRICTION in btManifoldResult.cpp.
LARGEST_FRICTION = 10.0
# Settings of contact by kind of body; a residual of 0 makes all iterations, so that a throw's are not another's.
TOUCHING = {"restitutionVelocityThreshold": 0.0, "contactSlop": 0.0, "solverResidualThreshold": 0.0}
CONTACT_SETTINGS = {
    "multibody": {**TOUCHING, "contactERP": 0.0, "erp": 0.0},
    "rigidbody": {**TOUCHING, "useSplitImpulse": 1, "splitImpulsePenetrationThreshold": 0.0},
}
RECIPE = {
    "restitutionVelocityThreshold": 0.0,
    "warmStartingFactor": 0.0,
    "useSplitImpulse": 1,
    "contactSlop": 0.0,
    "enableConeFriction": 0,
}
# Groups of collision: a body meets the plane, and no other.
PLANE_GROUP, BODY_GROUP = 1, 2
# So many times its reach a body is above the plane where it touches nothing.
AWAY = 10.0
# Physics servers without a world, reset, which takes a fiftieth of the time that a new one takes.
IDLE: list[int] = []
# What multibody does unless told otherwise.
DAMPING, LIMIT = 0.04, 100.0


@dataclass(eq=False)
class World:
    """A physics server with one body a throw, and what `audit` needs to know of the flight since `write`.

    kind: multibody or rigidbody; defaults: whether its settings are PyBullet's own; scale: how many times the scene's
    masses, and so all forces, are what PyBullet got: mass [kg] and moments [kg m2]; held: what gives the wrench of a
    step, None where there is none; away [m]: with a plane, where nothing touches it; gravity [m/s2].  fastest: largest
    |w| seen [rad/s]; peak: largest component of any v or w seen; longest_step [s].
    """

    client: int
    kind: str
    defaults: bool
    scale: float
    mass: float
    moments: tuple[float, ...]
    held: "Wrench | None" = None
    away: tuple[float, ...] = ()
    gravity: tuple[float, ...] = ()
    bodies: list[int] = field(default_factory=list)
    written: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 13)))
    fastest: float = 0.0
    peak: float = 0.0
    longest_step: float = 0.0


def build(scene: "Scene", method: str, keep: Collection[str] = ()) -> World:
    """Return a world with the scene's body once for every throw, and with those OPTIONAL kept that are asked for."""
    kind, _, manner = method.partition("+")
    if not scene.is_unforced and not manner:
        raise NotImplementedError(f"{kind} has none of these laws itself; {kind}+held is given their force once a step")
    if scene.plane and scene.plane.friction > LARGEST_FRICTION:
        raise NotImplementedError(f"Bullet cuts the friction of a pair at {LARGEST_FRICTION:g}")
    # Multibody ignores a torque about an axis with a moment below 2.2e-16 kg m2, and rigidbody drops the gyroscopic
    # torque where the product of the three is below that.
    scale = 1.0 if manner == "defaults" else scale_to_one(scene.body.mass, *scene.body.moments)
    client = IDLE.pop() if IDLE else pybullet.connect(pybullet.DIRECT)
    mass, moments = scale * scene.body.mass, tuple(scale * scene.body.moments)
    world = World(client, kind, manner == "defaults", scale, mass, moments)
    weakref.finalize(world, put_back, client)
    if scene.gravity is not None:
        pybullet.setGravity(*scene.gravity, physicsClientId=client)
    if not scene.is_unforced:
        from tumble.scenarios.wrench import wrench  # it brings a compiler, which a free flight has no use for

        world.held = wrench(scene)
    if scene.plane:
        world.away = tuple(scene.plane.point + AWAY * scene.body.reach * scene.plane.normal)
        world.gravity = (0.0, 0.0, 0.0) if scene.gravity is None else tuple(scene.gravity.tolist())
        add_plane(world, scene.plane, manner)
    shape = collision_shape(world, scene) if scene.plane or "collision shape" in keep else NO_SHAPE
    world.bodies = [add_body(world, shape) for _ in scene.start]
    if scene.plane:
        for body in world.bodies:
            touch(world, body, scene.plane)
    return world


def put_back(client: int) -> None:
    """Empty a server whose world is gone, for the next world."""
    pybullet.resetSimulation(physicsClientId=client)
    IDLE.append(client)


def collision_shape(world: World, scene: "Scene") -> int:
    """Return PyBullet's number for a sphere, a cylinder, a box or the hull of points; without a plane for a box."""
    body = scene.body
    if scene.plane and body.disc is not None:
        radius, half = cylinder(body.disc)
        return pybullet.createCollisionShape(
            pybullet.GEOM_CYLINDER, radius=radius, height=2 * half, physicsClientId=world.client
        )
    if scene.plane and body.radius is not None:
        return pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=body.radius, physicsClientId=world.client)
    if scene.plane and body.size is None:
        points = body.points.tolist()
        return pybullet.createCollisionShape(pybullet.GEOM_MESH, vertices=points, physicsClientId=world.client)
    half = abs(body.points).max(axis=0).tolist()
    return pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=half, physicsClientId=world.client)


def add_plane(world: World, plane: "Plane", manner: str) -> None:
    """Add the plane, of the same kind as the bodies, and set how contacts are solved."""
    settings = RECIPE if manner == "recipe" else {} if world.defaults else CONTACT_SETTINGS[world.kind]
    pybullet.setPhysicsEngineParameter(**settings, physicsClientId=world.client)
    normal = plane.normal.tolist()
    shape = pybullet.createCollisionShape(pybullet.GEOM_PLANE, planeNormal=normal, physicsClientId=world.client)
    ground = pybullet.createMultiBody(
        0.0,
        shape,
        basePosition=plane.point.tolist(),
        useMaximalCoordinates=world.kind == "rigidbody",
        physicsClientId=world.client,
    )
    naive = (plane.friction, plane.restitution)
    material(world, ground, *(naive if world.defaults else (1.0, 1.0)), group=PLANE_GROUP, mask=BODY_GROUP)


def touch(world: World, body: int, plane: "Plane") -> None:
    """Let a body collide with the plane, and give it the scene's friction and restitution."""
    material(world, body, plane.friction, plane.restitution, group=BODY_GROUP, mask=PLANE_GROUP)


def material(world: World, body: int, friction: float, restitution: float, group: int, mask: int) -> None:
    """Set what a body or the plane brings to a contact; the pair has the products."""
    fair = {} if world.defaults else {"contactProcessingThreshold": 0.0}
    margin = {} if world.defaults or group == PLANE_GROUP else {"collisionMargin": 0.0}
    pybullet.changeDynamics(
        body, BASE, lateralFriction=friction, restitution=restitution, **fair, **margin, physicsClientId=world.client
    )
    pybullet.setCollisionFilterGroupMask(body, BASE, group, mask, physicsClientId=world.client)


def add_body(world: World, shape: int) -> int:
    """Add the body, which can collide with nothing, and return PyBullet's number for it."""
    body = pybullet.createMultiBody(
        world.mass, shape, useMaximalCoordinates=world.kind == "rigidbody", physicsClientId=world.client
    )
    freed = {} if world.defaults else {"linearDamping": 0, "angularDamping": 0, "maxJointVelocity": math.inf}
    # In one call: for rigidbody, moments without the mass leave the mass uninitialised.
    pybullet.changeDynamics(
        body, BASE, mass=world.mass, localInertiaDiagonal=world.moments, **freed, physicsClientId=world.client
    )
    # Even without shapes, throws in one place would be paired off at every step, which doubles its cost.
    pybullet.setCollisionFilterGroupMask(body, BASE, 0, 0, physicsClientId=world.client)
    return body


def write(world: World, states: NDArray[np.float64]) -> None:
    """Put the throws into these states, (N, 13), with no trace of any earlier flight."""
    at_rest = states.copy()
    at_rest[:, 7:] = 0.0
    if world.away:
        # With nothing near, contacts and their impulses are forgotten.
        at_rest[:, 0:3] = world.away
        pybullet.setGravity(0.0, 0.0, 0.0, physicsClientId=world.client)
    place(world, at_rest)
    # Placing leaves rigidbody's world inertia as it was in the pose before; a step makes it anew.
    step(world, 1, 1.0)
    if world.away:
        pybullet.setGravity(*world.gravity, physicsClientId=world.client)
    place(world, states)
    world.written = states.copy()
    world.fastest = world.peak = world.longest_step = 0.0
    read(world)


def place(world: World, states: NDArray[np.float64]) -> None:
    """Set pose and velocity of every body, and nothing else."""
    for body, state in zip(world.bodies, states.tolist(), strict=True):
        x, (w, *xyz), v, spin = state[0:3], state[3:7], state[7:10], state[10:13]
        pybullet.resetBasePositionAndOrientation(body, x, [*xyz, w], physicsClientId=world.client)
        pybullet.resetBaseVelocity(body, v, spin, physicsClientId=world.client)


def advance(world: World, n: int, dt: float) -> None:
    """Make n steps of dt [s]: in C where no force is held."""
    world.longest_step = max(world.longest_step, dt)
    if world.held is None:
        step(world, n, dt)
        return
    for _ in range(n):
        hold(world, world.held)
        step(world, 1, dt)


def step(world: World, n: int, dt: float) -> None:
    """Make n steps of dt [s] as substeps in C, 2^k of them at a time.

    PyBullet divides an interval by the number of substeps and truncates when it counts them.  Only for a power of two
    are both exact; for others the step can be an ulp off and, worse, one substep may be left out.
    """
    for k in range(n.bit_length()):
        substeps = n & (1 << k)
        if substeps:
            pybullet.setPhysicsEngineParameter(
                numSubSteps=substeps, fixedTimeStep=substeps * dt, physicsClientId=world.client
            )
            pybullet.stepSimulation(physicsClientId=world.client)


def hold(world: World, held: "Wrench") -> None:
    """Apply the forces of the states as they are; a step of PyBullet's uses them up."""
    states = read(world)
    wrenches = world.scale * held(states)
    for body, state, total in zip(world.bodies, states.tolist(), wrenches.tolist(), strict=True):
        force, torque, centre = total[0:3], total[3:6], state[0:3]
        pybullet.applyExternalForce(body, BASE, force, centre, pybullet.WORLD_FRAME, world.client)
        pybullet.applyExternalTorque(body, BASE, torque, pybullet.WORLD_FRAME, world.client)


def read(world: World) -> NDArray[np.float64]:
    """Return the states of the throws, (N, 13)."""
    states = []
    for body in world.bodies:
        x, (*xyz, w) = pybullet.getBasePositionAndOrientation(body, physicsClientId=world.client)
        v, spin = pybullet.getBaseVelocity(body, physicsClientId=world.client)
        states.append((*x, w, *xyz, *v, *spin))
        world.fastest = max(world.fastest, math.hypot(*spin))
        world.peak = max(world.peak, *map(abs, v), *map(abs, spin))
    return np.array(states).reshape(-1, 13)


Found = Iterator[tuple[str, str]]


def audit(world: World) -> list[tuple[str, str]]:
    """Return what went wrong without a word since `write`; |w| is known where the state was written or read."""
    states = read(world)
    findings = [*turned_too_little(world), *another_body(world), *stood_still(world, states), *lost_torque(world)]
    return [*findings, *damped_and_clamped(world)] if world.defaults and world.kind == "multibody" else findings


def turned_too_little(world: World) -> Found:
    """Say so where a step was too long for the angular velocity (Bullet, btTransformUtil::integrateTransform)."""
    asked = world.fastest * world.longest_step
    if asked > LARGEST_TURN:
        turned = 2 * math.atan(asked / LARGEST_TURN * math.tan(LARGEST_TURN / 2))
        how = f"turned 2 atan(4 |w|dt/pi tan(pi/8)) = {turned:.3g} rad a step instead of |w|dt = {asked:.3g} rad"
        yield "under-rotated", how


def another_body(world: World) -> Found:
    """Say so where mass or moments are not those asked for."""
    asked = np.array([world.mass, *world.moments])
    for throw, body in enumerate(world.bodies):
        info = pybullet.getDynamicsInfo(body, BASE, physicsClientId=world.client)
        got = np.array([info[0], *info[2]])
        # Bullet keeps inverses, which costs an ulp.
        if not np.allclose(got, asked, rtol=1e-15, atol=0.0):
            yield "another-body", f"throw {throw} has mass and moments {got / asked} times those asked for"


def stood_still(world: World, states: NDArray[np.float64]) -> Found:
    """Say so where a body kept a velocity and went nowhere."""
    if not world.longest_step:
        return
    same = (states == world.written)[:, [0, 1, 2, 7, 8, 9]].all(axis=1)
    moving = world.written[:, 7:10].any(axis=1)
    for throw in np.flatnonzero(same & moving):
        yield "frozen", f"throw {throw} did not move at all although v = {world.written[throw, 7:10]} m/s"


def lost_torque(world: World) -> Found:
    """Say so where the moments are too small for Bullet to invert."""
    if world.kind == "rigidbody" and math.prod(world.moments) < LEAST_PIVOT and len(set(world.moments)) > 1:
        product = math.prod(world.moments)
        yield "lost-torque", f"lost gyroscopic torque: det(I) = {product:.3g} kg3 m6 is below {LEAST_PIVOT:.2g}"
    if world.kind == "multibody" and min(world.moments) < LEAST_PIVOT:
        how = f"lost torque about an axis: its moment of {min(world.moments):.3g} kg m2 is below {LEAST_PIVOT:.2g}"
        yield "lost-torque", how


def damped_and_clamped(world: World) -> Found:
    """Say what multibody's default settings did."""
    if not world.longest_step:
        return
    speed = np.linalg.norm(world.written[:, 7:10], axis=1).max()
    spin = np.linalg.norm(world.written[:, 10:13], axis=1).max()
    yield (
        "damped",
        f"damped: its default takes {DAMPING:g} (1 + |v|) of v and {DAMPING:g} (1 + |w|) of w a second, "
        f"{DAMPING * (1 + speed):.2g} at {speed:.3g} m/s and {DAMPING * (1 + spin):.2g} at {spin:.3g} rad/s",
    )
    if world.peak >= LIMIT:
        how = f"clamped: a velocity component reached {world.peak:.4g}; its default limit is {LIMIT:g} m/s and rad/s"
        yield "clamped", how
