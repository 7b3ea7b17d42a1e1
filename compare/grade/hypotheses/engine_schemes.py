"""What engines do in a step at their defaults: whole hypotheses, one line an engine, flown before anything is fitted.

Each law was established by a program of its own that reproduces what the engine writes, and is held against fresh
trajectories by `tools/foreign.py`.  A law is data: `law_hypotheses` turns it into the mistakes that the search
knows.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from tumble.compare.grade.hypotheses.hypothesis import NEAR, Question
from tumble.compare.grade.model.kernel.dynamics import (
    AFTER_FORCES,
    AS_FORCE,
    BACKWARD,
    BEFORE_FORCES,
    EXPLICIT,
    EXPONENTIAL,
    EXPONENTIALLY,
    IMPLICIT,
    IMPLICITLY,
    LAST,
    LINEARLY,
    MIDPOINT,
    QUATERNION,
    RESCALED,
)

# Gyroscopic schemes and rotations: what they are called in tables, and in words.
GYROSCOPIC = {
    "none": (EXPLICIT, ""),
    "explicit": (EXPLICIT, "the gyroscopic term explicit"),
    "implicit": (IMPLICIT, "the gyroscopic term implicit"),
    "rescaled": (RESCALED, "the gyroscopic term explicit, the angular momentum rescaled to its length"),
    "ode": (BACKWARD, "the gyroscopic term as in ODE, (I - dt [L]) w' = L"),
    "midpoint": (MIDPOINT, "the gyroscopic term by the midpoint rule"),
}
ROTATION = {
    "exponential": (EXPONENTIAL, "turned by rotations"),
    "first order": (QUATERNION, "the quaternion to first order"),
}
PLACES = {
    AS_FORCE: "as a force",
    BEFORE_FORCES: "before the forces of a step",
    AFTER_FORCES: "after the forces of a step",
    LAST: "after a step has moved the body",
}
DECAYS = {LINEARLY: "by c dt", EXPONENTIALLY: "by exp(-c dt)", IMPLICITLY: "by 1/(1 + c dt)"}


@dataclass(frozen=True)
class Damping:
    """What v and w lose: linear, angular [1/s]; quadratic: both more by as much for each m/s and rad/s; where, how."""

    linear: float = 0.0
    angular: float = 0.0
    quadratic: float = 0.0
    damps: int = AFTER_FORCES
    decays: int = LINEARLY


@dataclass(frozen=True)
class Law:
    """One line of the table: an engine, its gyroscopic scheme and rotation; what it damps.

    step: its own [s], 0 for one that the row spacing says; late: rows are one tick late; between: and interpolated;
    idle: steps until gravity acts; falls: substeps in which a step moves the centre; lengthens: q is never normalised;
    substeps: equal parts in which it takes all of a step; fastest: no spin is let past [rad/s], or past so much of a
    turn a step [rad], 0 for any.
    """

    engine: str
    gyroscopic: str
    rotation: str
    damping: Damping = Damping()
    step: float = 0.0
    late: bool = False
    between: bool = False
    idle: int = 0
    falls: int = 1
    lengthens: bool = False
    substeps: int = 1
    fastest: float = 0.0
    turns: float = 0.0

    def cap(self, step: float) -> float:
        """Return the spin that a step [s] does not let pass [rad/s], 0 for none."""
        caps = self.fastest, self.turns / (step * self.substeps)
        return min(filter(None, caps), default=0.0)


QUARTER = np.pi / 4
# Jolt's default; PhysX's.
JOLTS, PHYSXS = 15 * np.pi, 100.0
HUNDREDTH = -float(np.log(0.99))  # v 0.99^dt
TENTH = -float(np.log(0.9))
CANNON = Damping(HUNDREDTH, HUNDREDTH, damps=BEFORE_FORCES, decays=EXPONENTIALLY)
PHYSX = Damping(0.0, 0.05, damps=BEFORE_FORCES)
HAVOK = Damping(0.0, 0.1, damps=LAST)
JOLT = Damping(0.05, 0.05)
BULLET = float(np.float32(0.04))  # a number of single precision in Bullet's double build as well

# Where two engines are one scheme, a file of one is a file of the other.
ENGINES = (
    Law("MuJoCo (Euler)", "explicit", "exponential"),
    Law("DART", "explicit", "exponential"),
    Law("PyBullet (multibody) without damping", "explicit", "exponential"),
    Law("PyBullet (multibody)", "explicit", "exponential", Damping(BULLET, BULLET, BULLET, AS_FORCE)),
    Law("PyBullet (rigid body)", "implicit", "exponential"),
    Law("MuJoCo (implicit)", "implicit", "exponential"),
    Law("Bullet (rigid body, Panda3D), read through a motion state", "implicit", "exponential", late=True),
    Law("Drake (discrete)", "explicit", "first order"),
    Law("Drake (discrete), its raw quaternion", "explicit", "first order", lengthens=True),
    Law("Newton (XPBD, Featherstone)", "explicit", "first order"),
    Law("Newton (semi-implicit)", "explicit", "first order", Damping(0.0, 0.05, damps=LAST)),
    Law("cannon-es", "none", "first order", CANNON),
    Law("oimo", "none", "first order"),
    Law("oimo at its own step", "none", "first order", step=0.01666),
    Law("Jolt", "none", "exponential", JOLT, fastest=JOLTS),
    Law("Jolt without damping", "none", "exponential", fastest=JOLTS),
    Law("Jolt with its gyroscopic flag", "rescaled", "exponential", JOLT, fastest=JOLTS),
    Law("Jolt with its gyroscopic flag, without damping", "rescaled", "exponential", fastest=JOLTS),
    Law("PhysX without its gyroscopic flag", "none", "exponential", PHYSX, fastest=PHYSXS),
    Law("PhysX", "rescaled", "exponential", PHYSX, fastest=PHYSXS),
    Law("Unity (PhysX)", "rescaled", "exponential", PHYSX, fastest=7.0),
    Law("PhysX without damping", "rescaled", "exponential"),
    Law("Rapier", "rescaled", "first order", substeps=4, turns=QUARTER),
    Law("Havok", "none", "exponential", HAVOK, falls=4),
    Law("Havok", "none", "exponential", HAVOK),
    Law("ammo.js, read from the body", "none", "exponential", turns=QUARTER),
    Law("ammo.js, read through a motion state", "none", "exponential", late=True, turns=QUARTER),
    Law("ammo.js at its own step", "none", "exponential", step=1 / 60, late=True, between=True),
    Law("ODE", "ode", "first order"),
    Law("Godot 3 (Bullet)", "implicit", "exponential", Damping(TENTH, TENTH, decays=EXPONENTIALLY), late=True, idle=1),
    Law("Godot (Godot Physics)", "none", "exponential", Damping(0.1, 0.1)),
    Law("MuJoCo 3.7 to 3.10 (implicitfast)", "midpoint", "exponential"),
    Law("Box3D", "implicit", "first order"),
)

# Ticks that rows are written late, beside what an engine does: logged before the step, after it, or a tick late.
LATE = (0, 1, -1)


@dataclass(frozen=True)
class Flown:
    """A law at a step [s], with rows so many ticks late; forced: impulses are forces over a step."""

    law: Law
    step: float
    late: int = 0
    forced: bool = False


def is_one(one: Law, other: Law) -> bool:
    """Whether two engines are one scheme, whatever the scene."""
    return replace(one, engine=other.engine) == other


def table(question: Question, laws: Sequence[Law] = ENGINES) -> Iterator[Flown]:
    """Yield every scheme of an engine at steps that go into a row, its rows on time, a tick late and a tick early."""
    yield from _flown(question, laws)


def combinations(question: Question, laws: Sequence[Law] = ENGINES) -> Iterator[Flown]:
    """Yield what no engine of the table does: every scheme, rotation and damping of them with every other."""
    parts = ((law.gyroscopic, law.rotation, law.damping) for law in laws)
    kinds = product(*(dict.fromkeys(part) for part in zip(*parts, strict=True)))
    for flown in _flown(question, [Law("", *kind) for kind in kinds]):
        if flown.late == 0 and not flown.forced:
            yield flown


def _flown(question: Question, laws: Sequence[Law]) -> Iterator[Flown]:
    laws = [law for number, law in enumerate(laws) if not any(is_one(law, other) for other in laws[:number])]
    forced = (False, True) if question.account.impulses else (False,)
    # Between rows that are ticks nothing is interpolated.
    laws = [law for law in laws if not law.between or abs(law.step - question.spacing_s) > NEAR * law.step]
    for law, late, force in product(laws, LATE, forced):
        for step in (law.step,) if law.step else question.parts:
            yield Flown(law, step / law.substeps, late, force)
