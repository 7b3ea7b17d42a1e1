"""MuJoCo in free flight, set up so that nothing but its integrators is compared.

A free joint's angular velocity is in body axes there, everything else in world axes; its quaternions are w x y z.
"""

# MuJoCo's wheel has no type stubs.
# pyright: reportAttributeAccessIssue=false

import math
import sys
from dataclasses import dataclass
from typing import TYPE_CHECKING

import mujoco
import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from scenarios.scene import Scene

INTEGRATORS = {  # as a method here: as MuJoCo spells it
    "euler": "Euler",
    "rk4": "RK4",
    "implicit": "implicit",
    "implicitfast": "implicitfast",
    "discrete": "discrete",
}
# None of them moves a bit of a free flight, but most cost time, and autoreset throws a state beyond 1e10 away.
FLAGS_OFF = ("constraint", "contact", "actuation", "sensor", "spring", "damper", "autoreset")

METHODS = tuple(INTEGRATORS)
FEATURES = {"gravity"}
ABOUT = {
    "version": mujoco.__version__,
    "precision": "double",
    "switched_off": [*(f"flag {flag}" for flag in FLAGS_OFF), "geoms", "the compiler's limits on mass and inertia"],
}

MODEL = """
<mujoco>
  <size memory="{memory_mb}M"/>
  <option integrator="{integrator}"> <flag {flags}/> </option>
  <worldbody> {bodies} </worldbody>
</mujoco>
"""
BODY = '<body> <freejoint/> <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/> </body>'

# MuJoCo would write its warnings to standard error and to MUJOCO_LOG.TXT in the working directory; they are counted in
# the data all the same, and `audit` tells them.  There is one handler for the whole process.
mujoco.set_mju_user_warning(lambda message: None)


@dataclass(eq=False)
class World:
    """One model with a free body a throw; steps and elapsed [s] are counted here since `write`."""

    model: mujoco.MjModel
    data: mujoco.MjData
    steps: int = 0
    elapsed: float = 0.0


def build(scene: "Scene", method: str) -> World:
    """Return a world with the scene's body once for every throw."""
    model = compiled(len(scene.start), INTEGRATORS[method], gravity=scene.gravity is not None)
    if scene.gravity is not None:
        model.opt.gravity[:] = scene.gravity
    scale = scale_to_one(scene.body.mass, *scene.body.moments)
    # Set after compilation, which refuses A + B < C and anything below 1e-15; row 0 is the world itself.
    model.body_mass[1:] = scale * scene.body.mass
    model.body_inertia[1:] = scale * scene.body.moments
    data = mujoco.MjData(model)
    mujoco.mj_setConst(model, data)  # the mass matrix of a free body comes from constants derived from these
    return World(model, data)


def compiled(throws: int, integrator: str, gravity: bool) -> mujoco.MjModel:
    """Return a model of that many unit bodies with all switched off that they have not got."""
    off = FLAGS_OFF if gravity else (*FLAGS_OFF, "gravity")
    return mujoco.MjModel.from_xml_string(
        MODEL.format(
            # Left to itself it reserves room for contacts of all with all: 14 GB for 3000 throws.
            memory_mb=1 + throws // 100,
            integrator=integrator,
            flags=" ".join(f'{flag}="disable"' for flag in off),
            bodies=BODY * throws,
        )
    )


def scale_to_one(*masses_and_moments: float) -> float:
    """Return the power of two that takes the smallest to about one.

    MuJoCo takes a pivot below 1e-15 for singular and carries on with another.  Free motion depends on ratios only, and
    a power of two changes no bit of it.
    """
    return math.ldexp(1.0, -math.frexp(min(masses_and_moments))[1])


def write(world: World, states: NDArray[np.float64]) -> None:
    """Put the throws into these states, (N, 13), with no trace of any earlier flight."""
    mujoco.mj_resetData(world.model, world.data)
    qpos, qvel = coordinates(world)
    qpos[:] = states[:, 0:7]
    qvel[:, 0:3] = states[:, 7:10]
    qvel[:, 3:6] = turned(states[:, 10:13], states[:, 3:7] * (1, -1, -1, -1))
    world.steps, world.elapsed = 0, 0.0


def advance(world: World, n: int, dt: float) -> None:
    """Make n steps of dt [s] in MuJoCo's own loop."""
    world.model.opt.timestep = dt
    mujoco.mj_step(world.model, world.data, n)
    world.steps += n
    world.elapsed += n * dt


def read(world: World) -> NDArray[np.float64]:
    """Return the states of the throws, (N, 13)."""
    qpos, qvel = coordinates(world)
    return np.hstack((qpos, qvel[:, 0:3], turned(qvel[:, 3:6], qpos[:, 3:7])))


def audit(world: World) -> list[str]:
    """Return what went wrong without a word since `write`."""
    notes = [
        f"{warning.number} times: {mujoco.mju_warningText(kind, warning.lastinfo)}"
        for kind, warning in enumerate(world.data.warning)
        if warning.number
    ]
    # MuJoCo adds up its time, which costs up to half an ulp of the total a step; anything more is a reset.
    if abs(world.data.time - world.elapsed) > world.steps * sys.float_info.epsilon * world.elapsed:
        notes.append(f"time is {world.data.time:.17g} s after {world.elapsed:.17g} s of steps: the state was reset")
    return notes


def coordinates(world: World) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return views of positions, (N, 7): x, q, and velocities, (N, 6): v in world axes, w in body axes."""
    return world.data.qpos.reshape(-1, 7), world.data.qvel.reshape(-1, 6)


def turned(vectors: NDArray[np.float64], q: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return vectors, (N, 3), turned by quaternions w x y z, (N, 4)."""
    result = np.empty((len(vectors), 3))
    for row, vector, turn in zip(result, vectors, q, strict=True):
        mujoco.mju_rotVecQuat(row, vector, turn)
    return result
