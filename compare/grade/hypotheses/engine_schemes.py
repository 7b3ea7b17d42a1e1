"""The schemes of engines at their defaults: one line an engine, each simulated as a whole before anything is fitted.

Each scheme was established by a replica that reproduces the engine's output, and is tested on fresh trajectories by
`tools/foreign.py`.  A scheme is data: `scheme_hypotheses` converts it to the mistakes that the search knows.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from tumble.compare.grade.hypotheses.hypothesis import NEAR, Context
from tumble.compare.grade.model.kernel.dynamics import (
    AFTER_FORCES,
    ALONG_SCREW,
    AS_FORCE,
    AXIS_BY_AXIS,
    BACKWARD,
    BEFORE_FORCES,
    CONVERGED,
    ENERGY_KEPT,
    EXPLICIT,
    EXPONENTIAL,
    EXPONENTIALLY,
    GRAM_SCHMIDT,
    HALF_ANGLE,
    HEUN_SPIN,
    IMPLICIT,
    IMPLICITLY,
    IN_WORLD_AXES,
    LAST,
    LINEARLY,
    MIDPOINT,
    MIDPOINT_BY_NEW,
    ORDER_4_SPIN,
    QUATERNION,
    RESCALED,
    SECOND_ORDER,
    TANGENT,
)

# Gyroscopic schemes and rotations: name in tables -> constant of the kernel, and text.
GYROSCOPIC = {
    "none": (EXPLICIT, ""),
    "explicit": (EXPLICIT, "explicit gyroscopic term"),
    "implicit": (IMPLICIT, "implicit gyroscopic term"),
    "rescaled": (RESCALED, "explicit gyroscopic term with the angular momentum rescaled to its old length"),
    "backward": (BACKWARD, "gyroscopic term as in ODE, (I - dt [L]) w' = L"),
    "midpoint": (MIDPOINT, "gyroscopic term by the midpoint rule"),
    "momentum": (EXPLICIT, "angular momentum stored"),
    "midpoint, then new": (MIDPOINT_BY_NEW, "gyroscopic term by the midpoint rule, attitude rotated by the new w"),
    "implicit, converged": (CONVERGED, "implicit gyroscopic term, converged"),
    "energy kept": (ENERGY_KEPT, "explicit gyroscopic term with the energy rescaled to its old value"),
    "heun": (HEUN_SPIN, "gyroscopic term by Heun's method"),
    "runge-kutta-4": (ORDER_4_SPIN, "gyroscopic term by the Runge-Kutta method of order 4"),
}
ROTATION = {
    "exponential": (EXPONENTIAL, "attitude updated by exact rotations"),
    "first order": (QUATERNION, "quaternion updated to first order"),
    "second order": (SECOND_ORDER, "quaternion updated to second order"),
    "half angle": (HALF_ANGLE, "attitude rotated by 2 asin(|w| dt/2)"),
    "tangent": (TANGENT, "attitude rotated by atan(|w| dt)"),
    "gram-schmidt": (GRAM_SCHMIDT, "matrix updated to first order and orthonormalised by Gram-Schmidt"),
    "axis by axis": (AXIS_BY_AXIS, "attitude rotated about x, then y, then z"),
}
DAMPING_PLACES = {
    AS_FORCE: "as a force",
    BEFORE_FORCES: "before the forces of a step",
    AFTER_FORCES: "after the forces of a step",
    LAST: "after a step has moved the body",
}
DAMPING_FORMS = {LINEARLY: "by c dt", EXPONENTIALLY: "by exp(-c dt)", IMPLICITLY: "by 1/(1 + c dt)"}


@dataclass(frozen=True)
class Damping:
    """Damping of v and w.

    linear, angular: rates [1/s]; quadratic: rate added for each m/s and each rad/s; place: in the step; form: how a
    rate reduces a velocity; both are constants of the kernel.
    """

    linear: float = 0.0
    angular: float = 0.0
    quadratic: float = 0.0
    place: int = AFTER_FORCES
    form: int = LINEARLY


@dataclass(frozen=True)
class EngineScheme:
    """One line of the table: an engine, its gyroscopic scheme, rotation and damping.

    step: its own step [s], 0 if the row spacing determines it; late: rows are one tick late; interpolated: and are
    interpolated between ticks; idle_steps: steps before gravity acts; position_substeps: substeps that move the centre;
    unnormalised: q is never normalised; substeps: equal parts of a step; max_spin: largest |w| [rad/s]; max_turn:
    largest rotation in a step [rad]; 0 for none; velocity_axes: of the stored velocity of the centre.
    """

    engine: str
    gyroscopic: str
    rotation: str
    damping: Damping = Damping()
    step: float = 0.0
    late: bool = False
    interpolated: bool = False
    idle_steps: int = 0
    position_substeps: int = 1
    unnormalised: bool = False
    substeps: int = 1
    max_spin: float = 0.0
    max_turn: float = 0.0
    velocity_axes: int = IN_WORLD_AXES

    def cap(self, step: float) -> float:
        """Return the largest |w| with a step [s], in rad/s, 0 for none."""
        caps = self.max_spin, self.max_turn / (step * self.substeps)
        return min(filter(None, caps), default=0.0)


QUARTER_TURN = np.pi / 4
JOLT_MAX_SPIN, PHYSX_MAX_SPIN = 15 * np.pi, 100.0
HUNDREDTH = -float(np.log(0.99))  # v 0.99^dt
TENTH = -float(np.log(0.9))
CANNON = Damping(HUNDREDTH, HUNDREDTH, place=BEFORE_FORCES, form=EXPONENTIALLY)
PHYSX = Damping(0.0, 0.05, place=BEFORE_FORCES)
HAVOK = Damping(0.0, 0.1, place=LAST)
JOLT = Damping(0.05, 0.05)
BULLET = float(np.float32(0.04))  # single precision, even in Bullet's double-precision build

# A file cannot distinguish two engines with one scheme.
ENGINES = (
    EngineScheme("MuJoCo (Euler)", "explicit", "exponential"),
    EngineScheme("DART", "explicit", "exponential"),
    EngineScheme("PyBullet (multibody) without damping", "explicit", "exponential"),
    EngineScheme("PyBullet (multibody)", "explicit", "exponential", Damping(BULLET, BULLET, BULLET, AS_FORCE)),
    EngineScheme("PyBullet (rigid body)", "implicit", "exponential"),
    EngineScheme("MuJoCo (implicit)", "implicit", "exponential"),
    EngineScheme("Bullet (rigid body, Panda3D), read through a motion state", "implicit", "exponential", late=True),
    EngineScheme("Drake (discrete)", "explicit", "first order"),
    EngineScheme("Drake (discrete), its raw quaternion", "explicit", "first order", unnormalised=True),
    EngineScheme("Newton (XPBD, Featherstone)", "explicit", "first order"),
    EngineScheme("Newton (semi-implicit)", "explicit", "first order", Damping(0.0, 0.05, place=LAST)),
    EngineScheme("cannon-es", "none", "first order", CANNON),
    EngineScheme("oimo", "none", "first order"),
    EngineScheme("oimo at its own step", "none", "first order", step=0.01666),
    EngineScheme("Jolt", "none", "exponential", JOLT, max_spin=JOLT_MAX_SPIN),
    EngineScheme("Jolt without damping", "none", "exponential", max_spin=JOLT_MAX_SPIN),
    EngineScheme("Jolt with its gyroscopic flag", "rescaled", "exponential", JOLT, max_spin=JOLT_MAX_SPIN),
    EngineScheme("Jolt with its gyroscopic flag, without damping", "rescaled", "exponential", max_spin=JOLT_MAX_SPIN),
    EngineScheme("PhysX without its gyroscopic flag", "none", "exponential", PHYSX, max_spin=PHYSX_MAX_SPIN),
    EngineScheme("PhysX", "rescaled", "exponential", PHYSX, max_spin=PHYSX_MAX_SPIN),
    EngineScheme("Unity (PhysX)", "rescaled", "exponential", PHYSX, max_spin=7.0),
    EngineScheme("PhysX without damping", "rescaled", "exponential"),
    EngineScheme("Rapier", "rescaled", "first order", substeps=4, max_turn=QUARTER_TURN),
    EngineScheme("Havok", "none", "exponential", HAVOK, position_substeps=4),
    EngineScheme("Havok", "none", "exponential", HAVOK),
    EngineScheme("ammo.js, read from the body", "none", "exponential", max_turn=QUARTER_TURN),
    EngineScheme("ammo.js, read through a motion state", "none", "exponential", late=True, max_turn=QUARTER_TURN),
    EngineScheme("ammo.js at its own step", "none", "exponential", step=1 / 60, late=True, interpolated=True),
    EngineScheme("ODE", "backward", "first order"),
    EngineScheme(
        "Godot 3 (Bullet)",
        "implicit",
        "exponential",
        Damping(TENTH, TENTH, form=EXPONENTIALLY),
        late=True,
        idle_steps=1,
    ),
    EngineScheme("Godot (Godot Physics)", "none", "exponential", Damping(0.1, 0.1)),
    EngineScheme("MuJoCo 3.7 to 3.10 (implicitfast)", "midpoint", "exponential"),
    EngineScheme("Box3D", "implicit", "first order"),
    EngineScheme("a loop with Pinocchio's integrate", "explicit", "exponential", velocity_axes=ALONG_SCREW),
)

# Ticks by which rows are late, in addition to what the engine does: on time, a tick late, a tick early.
ROW_SHIFTS = (0, 1, -1)


@dataclass(frozen=True)
class SteppedScheme:
    """A scheme with a step [s] and rows that are `late` ticks late; impulse_as_force: impulses act over a step."""

    scheme: EngineScheme
    step: float
    late: int = 0
    impulse_as_force: bool = False


def is_same(one: EngineScheme, other: EngineScheme) -> bool:
    """Whether two engines are one scheme, whatever the scene."""
    return replace(one, engine=other.engine) == other


def engine_runs(context: Context, schemes: Sequence[EngineScheme] = ENGINES) -> Iterator[SteppedScheme]:
    """Yield every engine's scheme at steps that divide a row interval; rows are on time, a tick late or early."""
    yield from _stepped_schemes(context, schemes)


def _stepped_schemes(context: Context, schemes: Sequence[EngineScheme]) -> Iterator[SteppedScheme]:
    schemes = [
        scheme for number, scheme in enumerate(schemes) if not any(is_same(scheme, other) for other in schemes[:number])
    ]
    impulse_as_force = (False, True) if context.program.impulses else (False,)
    # Rows at every tick are not interpolated.
    schemes = [
        scheme
        for scheme in schemes
        if not scheme.interpolated or abs(scheme.step - context.spacing_s) > NEAR * scheme.step
    ]
    for scheme, late, force in product(schemes, ROW_SHIFTS, impulse_as_force):
        for step in (scheme.step,) if scheme.step else context.parts:
            yield SteppedScheme(scheme, step / scheme.substeps, late, force)
