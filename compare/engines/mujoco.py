"""MuJoCo, set up so that nothing but its integrators is compared.

    rk4 ...             the forces as parts of the model, evaluated at every stage of a step
    rk4+held ...        the forces computed once a step and held over it, as most scripts do
    rk4+defaults ...    every flag as MuJoCo ships it, auto-reset among them, and the forces held
    euler+elliptic      above a plane: the elliptic friction cone in place of the pyramid
    euler+noslip        above a plane: the elliptic cone, and friction solved once more without its softness

Drag is joint damping.  A tether with a rest length is a spatial tendon.  One without damps the whole velocity of its
point, where a tendon damps along the line only: it is three actuators, one an axis of the world, that pull the point to
the anchor.  A penalty floor is a force from outside, which the callback for controls sets anew at every stage, for
a contact of MuJoCo's is another law.

A plane is a geom, and a contact pair has the scene's friction: no mixing rule.  MuJoCo has no restitution: where
the scene's is not zero, the pair's `solref` is the spring and damper that give it in a central impact, as its manual
advises ("Restitution" in the chapter on modeling); at zero it is MuJoCo's own.  Friction's damper then stops a slip in
one step, but only the elliptic cone has one apart from the spring's.  `+defaults` sets the friction of both geoms, and
no `solref`.

A free joint's angular velocity is in body axes there, everything else in world axes; its quaternions are w x y z.
"""

# MuJoCo's wheel has no type stubs.
# pyright: reportAttributeAccessIssue=false

import math
import sys
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import mujoco
import numpy as np
from numpy.typing import NDArray

from tumble.compare.engines.parts.apart import Apart, from_each, in_each, of_each, to_each
from tumble.compare.engines.parts.cylinder import cylinder
from tumble.compare.engines.parts.impact import damping_ratio, impact_duration, of_steps
from tumble.compare.engines.parts.scale import scale_to_one
from tumble.compare.engines.parts.soft_law import IMPEDANCE as IMPEDANCE_LAW
from tumble.compare.engines.parts.soft_law import SoftLaw

if TYPE_CHECKING:
    from tumble.scenarios.scene import Body, Plane, Scene
    from tumble.scenarios.wrench import Wrench

# Those that put the whole state back to the model's start where auto-reset is on.
BAD_STATES = (mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQVEL, mujoco.mjtWarning.mjWARN_BADQACC)

RELEASE = tuple(int(part) for part in mujoco.__version__.split(".")[:3])
INTEGRATORS = {  # as a method here: as MuJoCo spells it; `discrete` came with 4.0
    method: spelled
    for method, spelled in (
        ("euler", "Euler"),
        ("rk4", "RK4"),
        ("implicit", "implicit"),
        ("implicitfast", "implicitfast"),
        ("discrete", "discrete"),
    )
    if hasattr(mujoco.mjtIntegrator, f"mjINT_{spelled.upper()}")
}
# None of them moves a bit of a flight that has no use for it, but most cost time, and autoreset throws a state beyond
# 1e10 away.
FLAGS = ("constraint", "contact", "actuation", "sensor", "spring", "damper", "gravity", "autoreset")

METHODS = tuple(INTEGRATORS)
FORCED = tuple(f"{integrator}+held" for integrator in INTEGRATORS)
CONTACT = ("euler+elliptic", "euler+noslip")
ON_REQUEST = ("euler+defaults", "rk4+defaults", "implicitfast+defaults")
DEFAULT = ("euler", "euler+defaults")  # the flags that differ alter a flight only where a state is beyond 1e10
SHOWN = ("euler", "euler+defaults", "rk4", "implicitfast")
LANDING = ("euler", *CONTACT)
FEATURES = {"gravity", "tether", "drag", "floor", "plane"}
STEP_NS = 2000
REUSES_WORLD = True
OPTIONAL = (*FLAGS, "geoms")
PACKAGES = ("mujoco", "mujoco-core")
PINS = ("mujoco==4.0.0",)
# Read in engine_forward.c; Euler takes the damping of joints implicitly ("eulerdamp"), which is what drag is here.
SCHEMES = {
    "euler": "drag-implicit-euler",
    "rk4": "rk4",
    "implicit": "damping-implicit-euler",
    "implicitfast": "damping-implicit-euler",
    **dict.fromkeys((*FORCED, *ON_REQUEST), "semi-implicit-euler"),
    **dict.fromkeys(("rk4+held", "rk4+defaults"), "held-parabola"),
}
PYRAMID = "its friction cone is a pyramid with edges along x and y of the contact"
SOFT = "its friction is soft: a body creeps at a speed that does not fall with the step"
KNOWN_FAILURES = {
    "any direction": dict.fromkeys((*INTEGRATORS, *ON_REQUEST), PYRAMID),
    "holds": dict.fromkeys((*INTEGRATORS, *ON_REQUEST, "euler+elliptic"), SOFT),
    "restitution": {
        "discrete": "its implicit step damps the spring of an impact, the less the shorter the step",
        **dict.fromkeys(ON_REQUEST, "it has no restitution; the spring and damper of its default give 0.13"),
    },
    "stays above": dict.fromkeys(ON_REQUEST, "its default contact is soft: 20 ms"),
}
GYROSCOPIC = {"euler": "explicit"} | {method: "implicit" for method in INTEGRATORS if method not in ("euler", "rk4")}
ORDERS = {"rk4": 4.0}
# As its notes have it, and docs/releases/mujoco shows: `implicitfast` had no derivative of the torque before 3.7; the
# midpoint rule came with 3.7.0, left `implicit` with 3.8.1 and `implicitfast` with 3.11.
if RELEASE < (3, 7):
    GYROSCOPIC["implicitfast"] = "explicit"
elif RELEASE < (3, 11):
    GYROSCOPIC["implicitfast"] = "midpoint"
if (3, 7) <= RELEASE < (3, 8, 1):
    GYROSCOPIC["implicit"] = "midpoint"
ABOUT = {
    "version": mujoco.__version__,
    "precision": "double",
    "switched_off": [
        *(f"flag {flag}" for flag in ("sensor", "autoreset")),
        "flags constraint, contact, gravity, actuation, spring and damper where nothing in the scene needs them",
        "geoms without a plane",
        "the compiler's limits on mass and inertia",
        "errors of discrete's solver: its tolerance is 1e-15 instead of 1e-8, which costs nothing here",
    ],
    "defaults": [
        "integrator Euler",
        "a state beyond 1e10 is put back to the start (auto-reset)",
        "contact: pyramidal friction cone, friction of a pair the larger of both, no restitution",
    ],
}

MODEL = """
<mujoco>
  <size memory="{memory_mb}M"/>
  <option integrator="{integrator}"> <flag {flags}/> </option>
  {assets}
  <worldbody> {anchors} {plane} {bodies} </worldbody>
  {contacts}
  <tendon> {tendons} </tendon>
  <actuator> {actuators} </actuator>
  <sensor> {sensors} </sensor>
</mujoco>
"""
BODY = """
<body> <freejoint/> <inertial pos="0 0 0" mass="{mass!r}" diaginertia="{moments}"/> {parts} </body>
"""
SITE = '<site name="{name}" pos="{place}"/>'
# It can collide with nothing, and inertial says what it weighs.
GEOM = '<geom type="box" size="{half}" contype="0" conaffinity="0"/>'
# Above a plane.  Its size is that of its picture; the normal is its z axis.
PLANE = (
    '<geom name="plane" type="plane" size="0 0 1" pos="{point}" zaxis="{normal}" contype="1" conaffinity="0" {own}/>'
)
SHAPE = '<geom name="body{throw}" {shape} contype="0" conaffinity="1" {own}/>'
HULL = '<asset> <mesh name="hull" vertex="{points}"/> </asset>'
PAIR = '<pair geom1="plane" geom2="body{throw}" {own}/>'
# F = -(k (|d| - l0) + c d'.u) u, with d from the anchor to the point and u = d/|d|.
TENDON = """
<spatial stiffness="{stiffness!r}" damping="{damping!r}" springlength="{rest_length!r}">
  <site site="{anchor}"/> <site site="{point}"/>
</spatial>
"""
# F = -k d - c d' along one axis of the anchor, which are those of the world.
ACTUATOR = """
<general site="{point}" refsite="{anchor}" gear="{axis} 0 0 0"
  gainprm="0" biastype="affine" biasprm="0 {minus_stiffness!r} {minus_damping!r}"/>
"""
# Of an impact with restitution: the largest of MuJoCo's own.
IMPEDANCE = 0.95
# Of the second solver for friction, which is off by default.
NOSLIP_ITERATIONS = 100
# What an accelerometer at a site reads is its acceleration less gravity's, in the site's axes.
MOUNTED = '<site name="{name}" pos="{place}" quat="{turn}"/>'
SENSOR = '<accelerometer site="{name}"/> <gyro site="{name}"/>'
# At its own 1e-8 the throws of one world, which it solves for together, disturb each other.
SOLVER_TOLERANCE = 1e-15
AXES = ("1 0 0", "0 1 0", "0 0 1")
UNIT_MOMENTS = np.ones(3)
# A state with the conjugate of its quaternion.
TURNED_BACK = np.array((1, 1, 1, 1, -1, -1, -1, 1, 1, 1, 1, 1, 1))

# MuJoCo would write its warnings to standard error and to MUJOCO_LOG.TXT in the working directory; they are counted in
# the data all the same, and `audit` tells them.  There is one handler for the whole process.
mujoco.set_mju_user_warning(lambda message: None)


@dataclass(eq=False)
class World:
    """One model with a free body a throw; steps and elapsed [s] are counted here since `write`.

    scale: how many times the scene's masses, and so all forces, are what MuJoCo got.  told: what gives the wrench of
    the forces that are no part of the model, None where there are none; held: whether it is for a whole step, or else
    for every stage of it.  bounces: the scene where its plane has a
    restitution, which spring and damper are to give.  qpos, (N, 7): x, q; qvel, (N, 6): v in world axes, w in body
    axes; pushed, (N, 6): force and torque from outside: views, because to ask MuJoCo for one takes as long as a step.
    """

    model: mujoco.MjModel
    data: mujoco.MjData
    scale: float
    held: bool
    told: "Wrench | None" = None
    bounces: "Scene | None" = None
    steps: int = 0
    elapsed: float = 0.0

    def __post_init__(self) -> None:
        self.qpos, self.qvel = self.data.qpos.reshape(-1, 7), self.data.qvel.reshape(-1, 6)
        self.pushed = self.data.xfrc_applied[1:]  # row 0 is the world itself


def build(scene: "Scene", method: str, keep: Collection[str] = ()) -> World | Apart:
    """Return a world with the scene's body once for every throw, and with those OPTIONAL kept that are asked for.

    Above a plane each throw has a world: MuJoCo solves for all contacts of one together.
    """
    if scene.plane and len(scene.start) > 1:
        return Apart([build(replace(scene, start=start[np.newaxis]), method, keep) for start in scene.start])
    integrator, _, manner = method.partition("+")
    # What the model is made of, and what it must be told from outside.
    holds = bool(manner) and f"{integrator}+{manner}" not in CONTACT
    inside = replace(scene, tethers=(), drag=None, floor=None) if holds else scene
    outside = replace(scene if holds else replace(scene, tethers=(), drag=None), plane=None)
    if manner == "defaults":
        model, scale = as_shipped(inside, integrator), 1.0
    else:
        # MuJoCo takes a pivot below 1e-15 for singular and carries on with another.
        scale = scale_to_one(scene.body.mass, *scene.body.moments)
        model = bare(inside, integrator, scale, keep)
        if manner in ("elliptic", "noslip"):
            model.opt.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
        if manner == "noslip":
            model.opt.noslip_iterations, model.opt.noslip_tolerance = NOSLIP_ITERATIONS, SOLVER_TOLERANCE
    model.opt.gravity[:] = 0.0 if scene.gravity is None else scene.gravity
    world = World(model, mujoco.MjData(model), scale, held=holds)
    if scene.plane and scene.plane.restitution and manner != "defaults":
        world.bounces = scene
    mujoco.mj_setConst(model, world.data)  # the mass matrix of a free body comes from constants derived from its masses
    if not outside.is_free:
        from tumble.scenarios.wrench import wrench  # it brings a compiler, which a free flight has no use for

        world.told = wrench(outside)
    return world


def bare(scene: "Scene", integrator: str, scale: float, keep: Collection[str]) -> mujoco.MjModel:
    """Return a model that has of all OPTIONAL only what the scene needs, and what is to be kept."""
    along = [tether for tether in scene.tethers if tether.rest_length]
    used = {
        "constraint": scene.plane,
        "contact": scene.plane,
        "actuation": scene.floor or len(along) < len(scene.tethers),  # the callback for a floor is a part of it
        "sensor": scene.sensors,
        "spring": along,
        "damper": scene.drag or any(tether.damping for tether in along),
        "gravity": scene.gravity is not None,
    }
    off = [flag for flag in FLAGS if not used.get(flag) and flag not in keep]
    shown = "geoms" in keep and not scene.plane
    geom = GEOM.format(half=words(abs(scene.body.points).max(axis=0))) if shown else ""
    model = compiled(scene, integrator, off, scale, geom=geom)
    # Set after compilation, which refuses A + B < C and anything below 1e-15; row 0 is the world itself.
    model.body_mass[1:] = scale * scene.body.mass
    model.body_inertia[1:] = scale * scene.body.moments
    model.opt.tolerance = SOLVER_TOLERANCE
    if scene.drag:
        damping = model.dof_damping.reshape(-1, 6)
        damping[:, 0:3], damping[:, 3:6] = scale * scene.drag.linear, scale * scene.drag.angular
    return model


def as_shipped(scene: "Scene", integrator: str) -> mujoco.MjModel:
    """Return a model with every setting as it is."""
    try:
        return compiled(scene, integrator, mass=scene.body.mass, moments=scene.body.moments, naive=True)
    except ValueError as refusal:
        raise NotImplementedError(f"MuJoCo refuses the body: {' '.join(str(refusal).split())}") from refusal


def compiled(
    scene: "Scene",
    integrator: str,
    off: Collection[str] = (),
    scale: float = 1.0,
    mass: float = 1.0,
    moments: NDArray[np.float64] = UNIT_MOMENTS,
    geom: str = "",
    naive: bool = False,
) -> mujoco.MjModel:
    """Return a model of the scene's plane, tethers and a body a throw, of that mass and moments, with those flags off.

    naive: whether both geoms have the plane's friction, and no pair.
    """
    numbers = range(len(scene.tethers))
    of_geom, of_pair = friction(scene.plane, naive) if scene.plane else ("", "")
    shape = shape_of(scene.body) if scene.plane else ""
    anchors = [SITE.format(name=f"anchor{t}", place=words(scene.tethers[t].anchor)) for t in numbers]
    bodies, tendons, actuators, sensors = [], [], [], []
    pairs = [PAIR.format(throw=throw, own=of_pair) for throw in range(len(scene.start))]
    for throw in range(len(scene.start)):
        points = [SITE.format(name=f"point{t}-{throw}", place=words(scene.tethers[t].point_body)) for t in numbers]
        for s, sensor in enumerate(scene.sensors):
            name = f"sensor{s}-{throw}"
            points.append(MOUNTED.format(name=name, place=words(sensor.point_body), turn=words(sensor.orientation)))
            sensors.append(SENSOR.format(name=name))
        touching = SHAPE.format(throw=throw, shape=shape, own=of_geom) if scene.plane else ""
        bodies.append(BODY.format(mass=mass, moments=words(moments), parts=" ".join((geom, touching, *points))))
        for t, tether in enumerate(scene.tethers):
            ends = {"anchor": f"anchor{t}", "point": f"point{t}-{throw}"}
            stiffness, damping = scale * tether.stiffness, scale * tether.damping
            if tether.rest_length:
                spring = {"stiffness": stiffness, "damping": damping, "rest_length": tether.rest_length}
                tendons.append(TENDON.format(**ends, **spring))
            else:
                bias = {"minus_stiffness": -stiffness, "minus_damping": -damping}
                actuators += [ACTUATOR.format(**ends, **bias, axis=axis) for axis in AXES]
    return mujoco.MjModel.from_xml_string(
        MODEL.format(
            # Left to itself it reserves room for contacts of all with all: 14 GB for 3000 throws.
            memory_mb=1 + len(scene.start) // (2 if scene.plane else 100),
            integrator=INTEGRATORS[integrator],
            flags=" ".join(f'{flag}="disable"' for flag in off),
            assets=HULL.format(points=words(scene.body.points.ravel())) if 'mesh="hull"' in shape else "",
            anchors=" ".join(anchors),
            plane=plane_of(scene.plane, of_geom) if scene.plane else "",
            contacts=f"<contact> {' '.join(pairs)} </contact>" if of_pair else "",
            bodies=" ".join(bodies),
            tendons=" ".join(tendons),
            actuators=" ".join(actuators),
            sensors=" ".join(sensors),
        )
    )


def plane_of(plane: "Plane", own: str) -> str:
    """Return the plane's geom."""
    return PLANE.format(point=words(plane.point), normal=words(plane.normal), own=own)


def shape_of(body: "Body") -> str:
    """Return the attributes of the body's geom: a sphere, a cylinder, a box, or the convex hull of its points."""
    if body.radius is not None:
        return f'type="sphere" size="{body.radius!r}"'
    if body.disc is not None:
        radius, half = cylinder(body.disc)
        return f'type="cylinder" size="{radius!r} {half!r}"'
    return 'type="mesh" mesh="hull"' if body.size is None else f'type="box" size="{words(body.size / 2)}"'


def friction(plane: "Plane", naive: bool) -> tuple[str, str]:
    """Return the attributes of the geoms and of their pair: the pair's friction, or that number on both geoms.

    Without friction a contact has no other than the normal direction: MuJoCo takes 1e-5 for the least.
    """
    mu = plane.friction
    slides = f'condim="3" friction="{mu!r} 0 0"' if mu else 'condim="1"'
    if naive:
        return slides, ""
    return "", f'condim="3" friction="{mu!r} {mu!r} 0 0 0"' if mu else 'condim="1"'


def words(numbers: NDArray[np.float64]) -> str:
    """Return numbers as an attribute of MJCF, every digit of them."""
    return " ".join(map(repr, numbers.tolist()))


@in_each
def prepare(world: World, dt: float) -> None:
    """Set spring and damper of every pair for the restitution and steps of dt [s].

    In an impact of a body on a spring k and a damper b a unit of mass, force and velocity change sign together: with
    w = sqrt(k) and the damping ratio z = b / 2w it ends where the force does, at e^(-2 z arccos(z) / sqrt(1 - z^2))
    times the speed of the approach (Schwager & Poschel, Granular Matter 9 (2007) 465).
    """
    if world.bounces is None:
        return
    assert world.bounces.plane is not None
    ratio = damping_ratio(world.bounces.plane.restitution)
    rate = math.pi / impact_duration(world.bounces, dt)
    stiffness, damping = rate * rate, 2.0 * ratio * rate
    if world.model.opt.integrator != mujoco.mjtIntegrator.mjINT_RK4:
        stiffness, damping = of_steps(rate, ratio, dt)
    world.model.pair_solref[:] = -stiffness, -damping
    world.model.pair_solreffriction[:] = -stiffness, -1.0 / dt  # a slip that friction can stop stops in one step
    world.model.pair_solimp[:, 0:2] = IMPEDANCE


def soft_law(world: World | Apart) -> SoftLaw | None:
    """Return the spring and damper of the model's contacts, per mass, and their impedance.

    Source: MuJoCo's manual, "Modeling: Solver parameters", on solref, its direct format, and solimp.
    """
    if isinstance(world, Apart):
        return None
    pairs = world.model.npair > 0  # else of a geom: all have the same
    first, second = (world.model.pair_solref if pairs else world.model.geom_solref)[0].tolist()
    impedance = (world.model.pair_solimp if pairs else world.model.geom_solimp)[0].tolist()
    largest = impedance[1]
    if first > 0:  # time constant and damping ratio
        time = max(first, 2 * world.model.opt.timestep)
        stiffness, damping = 1 / (largest * time * second) ** 2, 2 / (largest * time)
    else:
        stiffness, damping = -first / largest**2, -second / largest
    return SoftLaw(IMPEDANCE_LAW, stiffness, damping, tuple(impedance))


@to_each
def write(world: World, states: NDArray[np.float64]) -> None:
    """Put the throws into these states, (N, 13), with no trace of any earlier flight."""
    mujoco.mj_resetData(world.model, world.data)
    world.qpos[:] = states[:, 0:7]
    world.qvel[:, 0:3] = states[:, 7:10]
    for velocity, state in zip(world.qvel, states * TURNED_BACK, strict=True):
        mujoco.mju_rotVecQuat(velocity[3:6], state[10:13], state[3:7])
    world.steps, world.elapsed = 0, 0.0


@in_each
def advance(world: World, n: int, dt: float) -> None:
    """Make n steps of dt [s], in MuJoCo's own loop where no force is held."""
    world.model.opt.timestep = dt
    if world.told is None:
        mujoco.mj_step(world.model, world.data, n)
    elif world.held:
        for _ in range(n):
            tell(world, world.told)
            mujoco.mj_step(world.model, world.data)
    else:
        with telling(world, world.told):
            mujoco.mj_step(world.model, world.data, n)
    world.steps += n
    world.elapsed += n * dt


def tell(world: World, told: "Wrench") -> None:
    """Set the external force on every body, at its centre of mass and in world axes, by the state as it is."""
    np.multiply(told(states_of(world)), world.scale, out=world.pushed)


def states_of(world: World) -> NDArray[np.float64]:
    """Return the states of the throws of one world, (N, 13)."""
    states = np.empty((len(world.qpos), 13))
    states[:, 0:7], states[:, 7:10] = world.qpos, world.qvel[:, 0:3]
    for state, velocity in zip(states, world.qvel, strict=True):
        mujoco.mju_rotVecQuat(state[10:13], velocity[3:6], state[3:7])
    return states


@contextmanager
def telling(world: World, told: "Wrench") -> Iterator[None]:
    """Set the external force anew whenever MuJoCo asks; there is one callback for the whole process."""
    mujoco.set_mjcb_control(lambda model, data: tell(world, told))
    try:
        yield
    finally:
        mujoco.set_mjcb_control(None)


@from_each
def read(world: World) -> NDArray[np.float64]:
    """Return the states of the throws, (N, 13)."""
    return states_of(world)


@from_each
def sense(world: World) -> NDArray[np.float64]:
    """Return what its accelerometers and gyros read in the state as it is, (N, S, 6).

    After a step they have the readings of its start: they are evaluated anew.
    """
    if world.told is None:
        mujoco.mj_forward(world.model, world.data)
    elif world.held:
        tell(world, world.told)
        mujoco.mj_forward(world.model, world.data)
    else:
        with telling(world, world.told):
            mujoco.mj_forward(world.model, world.data)
    return world.data.sensordata.reshape(len(world.data.qpos) // 7, -1, 6).copy()


@of_each
def audit(world: World) -> list[tuple[str, str]]:
    """Return what went wrong without a word since `write`."""
    resets = not world.model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_AUTORESET
    found = []
    # As arrays: an object made of every counter takes longer than a short flight.
    warnings = world.data.warning
    for kind in np.flatnonzero(warnings.number).tolist():
        was_reset = resets and kind in BAD_STATES
        text = f"{warnings.number[kind]} times: {mujoco.mju_warningText(kind, warnings.lastinfo[kind])}"
        found.append(("reset", f"{text} The state was reset.") if was_reset else ("bad-number", text))
    # MuJoCo adds up its time, which costs up to half an ulp of the total a step; anything more is a reset.
    if abs(world.data.time - world.elapsed) > world.steps * sys.float_info.epsilon * world.elapsed:
        how = f"time is {world.data.time:.17g} s after {world.elapsed:.17g} s of steps: the state was reset"
        found.append(("reset", how))
    return found
