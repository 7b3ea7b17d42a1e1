"""Newton by Warp, on the processor: single precision; three solvers of its own, and MuJoCo Warp.

`semi-implicit` and `xpbd` keep bodies by pose and twist, `featherstone` and `mujoco` by the coordinates of their free
joints; the state carries both.  Warp may go on working when a launch returns: `read` waits.  It has none of a scene's
forces but gravity: `+held` is given them once a step.  Every vector is in world axes, the velocity that of the centre
of mass; its quaternions are x y z w.

Above a plane both shapes have the scene's coefficients: a pair has their mean.  `xpbd` has a restitution, which it
takes when asked; `semi-implicit` and `featherstone` have a spring, a damper that works on the approach alone, and
friction that is viscous before it slips: they are set for the scene's restitution and for the step.  `mujoco` has none;
its friction cone is a pyramid, and round with `+elliptic`.

Its IMU needs the accelerations that `mujoco` alone of these solvers gives: `sense` is for that one.

Kernels are compiled where they lie: in the environment, the first time.
"""

# Its wheels are in an environment of its own; where they are not, its name is this file's.
# pyright: reportMissingImports=false, reportAttributeAccessIssue=false, reportCallIssue=false

import math
import os
import sys
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import warp
from numpy.typing import NDArray

from tumble.compare.engines.parts.audits import stood_still
from tumble.compare.engines.parts.cylinder import cylinder
from tumble.compare.engines.parts.held import held_wrench
from tumble.compare.engines.parts.impact import damping_ratio, impact_duration, of_steps
from tumble.compare.engines.parts.scale import scale_to_one
from tumble.compare.engines.parts.silence import silenced_stderr
from tumble.compare.engines.parts.soft_law import APPROACH, SoftLaw

if TYPE_CHECKING:
    from tumble.scenarios.scene import Scene
    from tumble.scenarios.wrench import Wrench

warp.config.log_level = warp.LOG_ERROR  # of devices it has not, and of every kernel that it loads
if os.access(sys.prefix, os.W_OK):
    warp.config.kernel_cache_dir = str(Path(sys.prefix) / "kernels")

with silenced_stderr():  # it looks for a graphics card
    import newton

    warp.init()  # which asks for no other place afterwards

METHODS = ("semi-implicit", "featherstone", "xpbd", "mujoco")
FORCED = ("semi-implicit+held", "featherstone+held", "xpbd+held", "mujoco+held")
CONTACT = ("mujoco+elliptic",)
ON_REQUEST = ("semi-implicit+defaults", "featherstone+defaults", "mujoco+defaults")
DEFAULT = ()  # a user has to choose a solver
FEATURES = {"gravity", "tether", "drag", "floor", "plane"}
STEP_NS = 3_000_000
PACKAGES = ("newton", "warp-lang")
PINS = ("newton==1.8.0", "warp-lang==1.19.0", "mujoco-warp==3.17.0", "mujoco==3.17.0", "numpy==2.4.6")
APART = True
MEGABYTES = 720
SCHEMES = dict.fromkeys((*FORCED, *ON_REQUEST), "semi-implicit-euler")
GYROSCOPIC = {"semi-implicit": "explicit", "featherstone": "explicit", "xpbd": "explicit", "mujoco": "implicit"}
SPRINGS, WARP = ("semi-implicit", "featherstone"), ("mujoco", "mujoco+elliptic")
SENSE = dict.fromkeys((*WARP, "mujoco+held", "mujoco+defaults"), "sensor")
KNOWN_FAILURES = {
    "converges": {"featherstone": "its error of 0.006 rad after a second stays from 512 steps on; no cause was found"},
    "friction": {"xpbd": "friction is a correction of positions, and up to a tenth too strong"},
    "restitution": {
        **dict.fromkeys(SPRINGS, "the damper of its spring works on the approach alone, and in explicit steps"),
        **dict.fromkeys(WARP, "it has no restitution; the spring and damper of its default give 0.13"),
    },
    "stays above": dict.fromkeys(WARP, "its default contact is soft: 20 ms"),
    "holds": {
        **dict.fromkeys(SPRINGS, "its friction is viscous below a speed, which falls with the step"),
        **dict.fromkeys(WARP, "its friction is soft: a body creeps at a speed that does not fall with the step"),
        "xpbd": "a body creeps on an incline",
    },
    "any direction": {"mujoco": "its friction cone is a pyramid with edges along x and y of the contact"},
}
# Of MuJoCo Warp, twice its MJ_MINMU, and of the spring of an impact.
LEAST_FRICTION, LEAST_RESTITUTION = 2e-5, 0.01
NO_TIME = 1e-6  # s, of the step that is thrown away: the accelerations at its start do not depend on it
DAMPING = {"semi-implicit": 0.05, "featherstone": 0.05}  # 1/s, of w, unless told otherwise
ABOUT = {
    "version": version("newton"),
    "precision": "single",
    "switched_off": [
        "angular damping (0.05 a second by default) of semi-implicit and featherstone",
        "mujoco's contacts without a plane",
        "the correction of moments that no body has",
    ],
    "defaults": ["angular damping 0.05 of semi-implicit and featherstone", "mujoco's integrator is implicitfast"],
}


@dataclass(eq=False)
class World:
    """A model with one body a throw, two states that take turns, and what `audit` needs to know since `write`.

    pipeline, contacts: what finds them, where there is a plane and the solver does not itself; springs: whether they
    are to be set for the step; imu, accelerations: its sensors, where the scene has any, and what the solver fills for
    them.  damping [1/s]: of the angular velocity; scale: how many times the scene's masses and
    forces are what Newton got.
    """

    model: Any
    solver: Any
    now: Any
    next: Any
    damping: float
    scale: float
    held: "Wrench | None"
    scene: "Scene"
    pipeline: Any = None
    contacts: Any = None
    springs: bool = False
    imu: Any = None
    accelerations: Any = None
    written: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 13)))
    steps: int = 0
    elapsed: float = 0.0


def build(scene: "Scene", method: str) -> World:
    """Return a model with the scene's body once for every throw, each in a world of its own."""
    kind, _, manner = method.partition("+")
    defaults, held = manner == "defaults", held_wrench(scene, kind if method in CONTACT else method)
    scale = 1.0 if defaults else scale_to_one(scene.body.mass, *scene.body.moments)
    model = model_of(scene, scale, kind)
    damping = DAMPING.get(kind, 0.0) if defaults else 0.0
    solver = mujoco(model, defaults, scene, method) if kind == "mujoco" else SOLVERS[kind](model, defaults)
    world = World(model, solver, model.state(), model.state(), damping, scale, held, scene)
    if scene.plane and kind != "mujoco":
        world.pipeline = newton.CollisionPipeline(model)
        world.contacts = world.pipeline.contacts()
        world.springs = kind != "xpbd" and not defaults
    if scene.sensors and kind == "mujoco":
        world.imu = newton.sensors.SensorIMU(model, "imu *", request_state_attributes=False)
        world.accelerations = solver.observables(kinds=world.imu.solver_observable_kinds)
    return world


def touch(builder: Any, scene: "Scene", kind: str) -> None:
    """Give the last body its shape: a sphere, a cylinder or a box."""
    body, number = scene.body, builder.body_count - 1
    cfg = material(scene, kind)
    if body.radius is not None:
        builder.add_shape_sphere(number, radius=body.radius, cfg=cfg)
    elif body.disc is not None:
        radius, half = cylinder(body.disc)
        builder.add_shape_cylinder(number, radius=radius, half_height=half, cfg=cfg)
    elif body.size is not None:
        hx, hy, hz = (body.size / 2).tolist()
        builder.add_shape_box(number, hx=hx, hy=hy, hz=hz, cfg=cfg)
    else:
        raise NotImplementedError("a convex hull needs faces, which a body of points does not have")


def material(scene: "Scene", kind: str) -> Any:
    """Return the coefficients of either shape; MuJoCo Warp may make NaN of friction below its least."""
    plane = scene.plane
    assert plane is not None
    return newton.ModelBuilder.ShapeConfig(
        density=0.0,
        mu=max(plane.friction, LEAST_FRICTION) if kind == "mujoco" else plane.friction,
        restitution=plane.restitution,
        mu_torsional=0.0,
        mu_rolling=0.0,
    )


def prepare(world: World, dt: float) -> None:
    """Set the springs of contact for steps of dt [s].

    The damper works on the approach alone: with a damping ratio z a body leaves with e^(-z arccos(z) / sqrt(1 - z^2))
    of its speed, which is half the decay of a spring and damper that both work all the time.
    """
    if not world.springs:
        return
    plane, mass = world.scene.plane, world.scale * world.scene.body.mass
    assert plane is not None
    ratio = damping_ratio(max(plane.restitution, LEAST_RESTITUTION) ** 2)
    stiffness, damping = of_steps(math.pi / impact_duration(world.scene, dt), ratio, dt)
    # Explicit steps are stable for less at the corners of a face, of which each moves lightly and all work together.
    share = 1.0 if world.scene.body.radius else 0.1
    model = world.model
    for array, value in (
        (model.shape_material_ke, mass * stiffness),
        (model.shape_material_kd, mass * min(damping, share / dt)),
        (model.shape_material_kf, share / 2 * mass / dt),
    ):
        array.fill_(value)


def soft_law(world: World) -> SoftLaw | None:
    """Return the spring of a contact point, of the methods with one; both shapes have the same."""
    if not world.springs:
        return None
    stiffness, damping = (
        float(array.numpy()[0]) / world.scale
        for array in (world.model.shape_material_ke, world.model.shape_material_kd)
    )
    return SoftLaw(APPROACH, stiffness, damping)


def model_of(scene: "Scene", scale: float, kind: str) -> Any:
    """Return the model; masses and moments are set once more, for its builder mends those that no body has."""
    gravity = (0.0, 0.0, 0.0) if scene.gravity is None else tuple(scene.gravity.tolist())
    mass, moments = scale * scene.body.mass, scale * scene.body.moments
    builder = newton.ModelBuilder(gravity=gravity)
    if scene.plane:
        normal = scene.plane.normal
        equation = (*normal.tolist(), -float(normal @ scene.plane.point))
        builder.add_shape_plane(equation, width=0.0, length=0.0, cfg=material(scene, kind))
    for _ in scene.start:
        builder.begin_world()
        builder.add_body(mass=mass, inertia=warp.mat33(*np.diag(moments).ravel().tolist()), lock_inertia=True)
        if scene.plane:
            touch(builder, scene, kind)
        for sensor in scene.sensors:
            turn = sensor.orientation / np.linalg.norm(sensor.orientation)
            mounted = warp.transform(sensor.point_body.tolist(), warp.quat(*np.roll(turn, -1).tolist()))
            builder.add_site(builder.body_count - 1, xform=mounted, label=f"imu {sensor.name}")
        builder.end_world()
    with warnings.catch_warnings(action="ignore"):  # that it has mended them
        model = builder.finalize(device="cpu")
    throws = len(scene.start)
    model.body_mass.assign(np.full(throws, mass, np.float32))
    model.body_inv_mass.assign(np.full(throws, 1.0 / mass, np.float32))
    model.body_inertia.assign(np.tile(np.diag(moments), (throws, 1, 1)).astype(np.float32))
    model.body_inv_inertia.assign(np.tile(np.diag(1.0 / moments), (throws, 1, 1)).astype(np.float32))
    return model


def semi_implicit(model: Any, defaults: bool) -> Any:
    """Return that solver."""
    return newton.solvers.SolverSemiImplicit(model, **({} if defaults else {"angular_damping": 0.0}))


def featherstone(model: Any, defaults: bool) -> Any:
    """Return that solver."""
    return newton.solvers.SolverFeatherstone(model, **({} if defaults else {"angular_damping": 0.0}))


def xpbd(model: Any, defaults: bool) -> Any:
    """Return that solver, which damps nothing as it ships, and takes a restitution when asked."""
    return newton.solvers.SolverXPBD(model, **({} if defaults else {"enable_restitution": True}))


def mujoco(model: Any, defaults: bool, scene: "Scene", method: str) -> Any:
    """Return MuJoCo Warp's.  Raises NotImplementedError for a body that it refuses.

    Its integrator is implicitfast: rk4, which it has too, takes four times as long and ends on the same floor.
    """
    settings: dict[str, Any] = {} if defaults or scene.plane else {"disable_contacts": True}
    if method in CONTACT or (scene.plane and not scene.plane.friction):  # of no friction its pyramid makes NaN
        settings["cone"] = "elliptic"
    try:
        return newton.solvers.SolverMuJoCo(model, **settings)
    except ValueError as error:
        raise NotImplementedError(f"MuJoCo refuses the body: {error}") from error


SOLVERS: dict[str, Callable[[Any, bool], Any]] = {
    "semi-implicit": semi_implicit,
    "featherstone": featherstone,
    "xpbd": xpbd,
}


def write(world: World, states: NDArray[np.float64]) -> None:
    """Put the throws into these states, (N, 13)."""
    q = states[:, 3:7] / np.linalg.norm(states[:, 3:7], axis=1, keepdims=True)
    poses = np.hstack((states[:, 0:3], q[:, 1:4], q[:, 0:1])).astype(np.float32)
    twists = states[:, 7:13].astype(np.float32)
    # A fresh pair: a solver may keep what it needs of a flight in the state.
    world.now, world.next = world.model.state(), world.model.state()
    world.now.body_q.assign(poses)
    world.now.body_qd.assign(twists)
    world.now.joint_q.assign(poses.ravel())
    world.now.joint_qd.assign(twists.ravel())
    if hasattr(world.solver, "mjw_data"):  # from which the next solution would begin
        world.solver.mjw_data.qacc_warmstart.zero_()
    world.steps, world.elapsed = 0, 0.0
    world.written = read(world)


def advance(world: World, n: int, dt: float) -> None:
    """Make n steps of dt [s]."""
    world.steps += n
    world.elapsed += n * dt
    step = world.solver.step
    for _ in range(n):
        if world.held is not None:
            hold(world, world.held)
        if world.pipeline is not None:
            world.pipeline.collide(world.now, world.contacts)
        step(world.now, world.next, None, world.contacts, dt)
        world.now, world.next = world.next, world.now


def hold(world: World, held: "Wrench") -> None:
    """Tell the state the forces as they are, at the centre of mass."""
    world.now.body_f.assign((world.scale * held(read(world))).astype(np.float32))


def read(world: World) -> NDArray[np.float64]:
    """Return the states of the throws, (N, 13), when all that was launched is done."""
    warp.synchronize_device("cpu")
    poses, twists = world.now.body_q.numpy(), world.now.body_qd.numpy()
    return np.hstack((poses[:, 0:3], poses[:, 6:7], poses[:, 3:6], twists)).astype(float)


def sense(world: World) -> NDArray[np.float64]:
    """Return what its IMUs read in the state as it is, (N, S, 6).

    After a step the solver has the accelerations of its start: a step that is thrown away gives those of the state.
    """
    if world.held is not None:
        hold(world, world.held)
    world.solver.step(world.now, world.next, None, None, NO_TIME, observables=world.accelerations)
    world.imu.update(world.now, observables=world.accelerations)
    warp.synchronize_device("cpu")
    read = np.hstack((world.imu.accelerometer.numpy(), world.imu.gyroscope.numpy())).astype(float)
    return read.reshape(len(world.written), -1, 6)


def audit(world: World) -> Iterator[tuple[str, str]]:
    """Yield what went wrong without a word since `write`."""
    yield from stood_still(world.written, read(world), world.steps)
    if world.damping and world.steps:
        lost = -np.expm1(-world.damping * world.elapsed)
        yield "damped", f"damped: its default takes {world.damping:g} of w a second, {lost:.2g} of it so far"
