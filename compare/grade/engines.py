"""What engines do in a step at their defaults: whole hypotheses, one line an engine, flown before anything is fitted.

Each law was established by a program of its own that reproduces what the engine writes, and is held against fresh
trajectories by `docs/foreign.py`.  A law is data: `laws` turns it into the same mistakes that the search knows.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from compare.grade.account import ALONG_ARCS, Account, Clock, Stroke
from compare.grade.explanation import Mistake, Mistakes
from compare.grade.hypotheses import NEAR, PARTS, Hypothesis, Question
from compare.grade.stepping import (
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
    Scheme,
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
    idle: steps until gravity acts; falls: substeps in which a step moves the centre; lengthens: q is never normalised.
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


HUNDREDTH = -float(np.log(0.99))  # v 0.99^dt
TENTH = -float(np.log(0.9))
CANNON = Damping(HUNDREDTH, HUNDREDTH, damps=BEFORE_FORCES, decays=EXPONENTIALLY)
PHYSX = Damping(0.0, 0.05, damps=BEFORE_FORCES)
HAVOK = Damping(0.0, 0.1, damps=LAST)
JOLT = Damping(0.05, 0.05)

# Where two engines are one scheme, a file of one is a file of the other.
ENGINES = (
    Law("MuJoCo (Euler)", "explicit", "exponential"),
    Law("DART", "explicit", "exponential"),
    Law("PyBullet (multibody) without damping", "explicit", "exponential"),
    Law("PyBullet (multibody)", "explicit", "exponential", Damping(0.04, 0.04, 0.04, AS_FORCE)),
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
    Law("Jolt", "none", "exponential", JOLT),
    Law("Jolt without damping", "none", "exponential"),
    Law("Jolt with its gyroscopic flag", "rescaled", "exponential", JOLT),
    Law("Jolt with its gyroscopic flag, without damping", "rescaled", "exponential"),
    Law("PhysX without its gyroscopic flag", "none", "exponential", PHYSX),
    Law("PhysX, Unity", "rescaled", "exponential", PHYSX),
    Law("PhysX without damping", "rescaled", "exponential"),
    Law("Rapier", "rescaled", "first order"),
    Law("Havok", "none", "exponential", HAVOK, falls=4),
    Law("Havok", "none", "exponential", HAVOK),
    Law("ammo.js, read from the body", "none", "exponential"),
    Law("ammo.js, read through a motion state", "none", "exponential", late=True),
    Law("ammo.js at its own step", "none", "exponential", step=1 / 60, late=True, between=True),
    Law("ODE", "ode", "first order"),
    Law("Godot 3 (Bullet)", "implicit", "exponential", Damping(TENTH, TENTH, decays=EXPONENTIALLY), late=True, idle=1),
    Law("Godot (Godot Physics)", "none", "exponential", Damping(0.1, 0.1)),
    Law("MuJoCo 3.7 to 3.10 (implicitfast)", "midpoint", "exponential"),
    Law("Box3D", "implicit", "first order"),
)

# Ticks that rows are written late, beside what an engine does: logged before the step, after it, or a tick late.
LATE = (0, 1, -1)
STEP, LAG = "symplectic Euler", "log lag"


@dataclass(frozen=True)
class Flown:
    """A law at a step [s], with rows so many ticks late; forced: impulses are forces over a step."""

    law: Law
    step: float
    late: int = 0
    forced: bool = False


def table(question: Question) -> Iterator[Flown]:
    """Yield every engine at one step a row and parts of it, with its rows on time, a tick late and a tick early."""
    yield from _flown(question, ENGINES)


def combinations(question: Question) -> Iterator[Flown]:
    """Yield what no engine of the table does: every scheme, rotation and damping of them with every other."""
    kinds = product(GYROSCOPIC, ROTATION, dict.fromkeys(law.damping for law in ENGINES))
    for flown in _flown(question, [Law("", *kind) for kind in kinds]):
        if flown.late == 0 and not flown.forced:
            yield flown


def _flown(question: Question, laws: Sequence[Law]) -> Iterator[Flown]:
    parts = [step for step, name in question.steps.items() if name in PARTS.values()]
    forced = (False, True) if question.account.impulses else (False,)
    # Between rows that are ticks nothing is interpolated.
    laws = [law for law in laws if not law.between or abs(law.step - question.spacing_s) > NEAR * law.step]
    for law, late, force in product(laws, LATE, forced):
        for step in (law.step,) if law.step else parts:
            yield Flown(law, step, late, force)


class Laws:
    """Turns laws into mistakes of one question: the same law gives the same hypotheses."""

    def __init__(self, question: Question) -> None:
        self._question, self._known = question, dict[tuple, Hypothesis]()
        self._equal = float(np.ptp(question.account.moments)) == 0.0

    def mistakes(self, flown: Flown) -> Mistakes:
        """Return what is said of a program that does this, instead of what is right."""
        law, found = flown.law, []
        if flown.forced:
            found.append(Mistake(self._of(_forced, ()), flown.step))
        if law.idle:
            found.append(Mistake(self._of(_idle, (law.idle,)), flown.step))
        found += [Mistake(self._of(_damping, key), rate) for key, rate in _dampings(law.damping)]
        if law.gyroscopic == "none" and not self._equal:
            found.append(Mistake(self._of(_no_gyroscopic, ())))
        found.append(Mistake(self.step(law.gyroscopic, law.rotation, law.falls, law.lengthens), flown.step))
        spacing = self._question.spacing_s
        late = flown.step if law.step else spacing
        if law.step and not law.between and abs(law.step - spacing) > NEAR * spacing:
            found.append(Mistake(self._of(_own_step, ()), law.step / spacing))
        ticks = law.late + flown.late
        if law.between:
            found.append(Mistake(self._of(_between, (ticks,)), flown.step))
        elif ticks:
            found.append(Mistake(self._of(_late, (1 if ticks > 0 else -1,)), abs(ticks * late)))
        return tuple(found)

    def step(self, gyroscopic: str, rotation: str, falls: int = 1, lengthens: bool = False) -> Hypothesis:
        """Return the hypothesis of a step, where "" stands for what cannot be seen."""
        gyroscopic = "" if self._equal or gyroscopic == "none" else gyroscopic
        return self._of(_step, (gyroscopic, rotation, falls, lengthens, tuple(self._question.steps.items())))

    def _of(self, make: Callable[..., Hypothesis], key: tuple) -> Hypothesis:
        return self._known.setdefault((make, key), make(*key))


def _step(
    gyroscopic: str, rotation: str, falls: int, lengthens: bool, steps: tuple[tuple[float, str], ...]
) -> Hypothesis:
    spin, term = GYROSCOPIC[gyroscopic or "explicit"]
    attitude, turned = ROTATION[rotation or "exponential"]
    more = [term if gyroscopic else "", turned if rotation else "", "never normalised" if lengthens else ""]
    more.append(f"in which the centre takes {falls} substeps" if falls > 1 else "")
    # v changes by a dt / falls in each of the substeps, after which x moves.
    fall = (falls + 1) / (2 * falls)
    return Hypothesis(
        STEP,
        "steps",
        ", ".join(("symplectic Euler with a step of {} s", *filter(None, more))),
        lambda account, step: replace(
            account, scheme=Scheme(step, attitude, spin, True, fall, lengthens, account.scheme.idle)
        ),
        known=dict(steps),
        unit="s",
        details=(
            ("gyroscopic", gyroscopic),
            ("rotation", rotation),
            ("substeps", str(falls) if falls > 1 else ""),
            ("normalised", "never" if lengthens else ""),
        ),
    )


def _no_gyroscopic() -> Hypothesis:
    return Hypothesis(
        "gyroscopic term missing",
        "gyroscopic",
        "gyroscopic term missing: the angular velocity keeps still",
        lambda account, _: replace(account, gyroscopic=0.0),
    )


def _dampings(damping: Damping) -> Iterator[tuple[tuple, float]]:
    """Yield what identifies each damping of a law, and its rate [1/s]."""
    how = damping.damps, damping.decays
    if damping.quadratic:
        yield ("PyBullet", *how), damping.linear
        return
    if damping.linear:
        yield ("linear", *how), damping.linear
    if damping.angular:
        yield ("angular", *how), damping.angular


def _damping(kind: str, damps: int, decays: int) -> Hypothesis:
    where = "" if damps == AS_FORCE else f", {DECAYS[decays]} {PLACES[damps]}"
    details = (("damping law", DECAYS[decays]), ("damps", PLACES[damps]))

    def damped(account: Account, rate: float) -> Account:
        kinds = {"linear": (0,), "angular": (2,), "PyBullet": (0, 1, 2, 3)}[kind]
        rates = tuple(rate if place in kinds else old for place, old in enumerate(account.damping))
        return replace(account, damping=rates, damps=damps, decays=decays)

    if kind == "PyBullet":
        says = "PyBullet's default damping: a = -{} (1 + |v|) v, and the same for w"
        return Hypothesis("damping as PyBullet's default", "linear damping", says, damped, unit="1/s", details=details)
    what = "velocity" if kind == "linear" else "angular velocity"
    name = f"{kind} damping"
    return Hypothesis(name, name, f"{name}: {what} decays at {{}} /s{where}", damped, unit="1/s", details=details)


def _forced() -> Hypothesis:
    return Hypothesis(
        "impulse as force over a step",
        "impulse",
        "impulse used as a force over a first step of {} s",
        lambda account, step: replace(account, stroke=Stroke(lasts=step)),
        unit="s",
    )


def _idle(steps: int) -> Hypothesis:
    return Hypothesis(
        "gravity late",
        "gravity start",
        "gravity acts from the second step on, after {} s",
        lambda account, _: replace(account, scheme=account.scheme._replace(idle=steps)),
        unit="s",
    )


def _late(sign: int) -> Hypothesis:
    return Hypothesis(
        LAG,
        "clock offset",
        f"rows written {{}} s {'late' if sign > 0 else 'early'}",
        lambda account, late: replace(account, clock=account.clock._replace(offset=-sign * late)),
        unit="s",
    )


def _own_step() -> Hypothesis:
    return Hypothesis(
        "clock rate",
        "clock rate",
        "each row is one step of the engine's own, {} times as long as from row to row",
        lambda account, rate: replace(account, clock=account.clock._replace(rate=rate)),
    )


def _between(ticks: int) -> Hypothesis:
    return Hypothesis(
        LAG,
        "clock offset",
        "rows written {} s late, and interpolated between two steps",
        lambda account, tick: replace(account, clock=Clock(tick=tick, lag=float(ticks), between=ALONG_ARCS)),
        unit="s",
    )
