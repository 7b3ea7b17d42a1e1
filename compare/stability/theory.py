"""The largest stable step by theory, from the schemes that an engine states.

Where forces act, one step on the stiffest mode u'' + c u' + s u = 0 is a matrix on (u, u'), and a step is too long
where that has a spectral radius above one.  A free body is limited by how its engine takes the gyroscopic torque.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tumble.compare.run.contestant import MethodName
from tumble.compare.run.engines.registry import OWN_SCHEME
from tumble.compare.run.running_engines import RunningEngine
from tumble.compare.run.status import Failure
from tumble.compare.stability.modes import Mode
from tumble.scenarios.forces import stiffness
from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Scene

UNLIMITED = math.inf
SCANNED = np.geomspace(1e-3, 1e3, 2000)  # of rate times step
ON_THE_CIRCLE = 1e-9  # how far rounding may move an eigenvalue of modulus one, which may be double

# One step of a scheme on u'' + c u' + s u = 0 as a matrix on (u, u'), for steps h, (n,) -> (n, 2, 2).
Scheme = Callable[[float, float, Array], Array]


def semi_implicit_euler(s: float, c: float, h: Array) -> Array:
    """First the velocity by the force at the start of the step, then the position by the new velocity."""
    return matrices(1 - h * h * s, h * (1 - h * c), -h * s, 1 - h * c)


def damping_implicit_euler(s: float, c: float, h: Array) -> Array:
    """Semi-implicit Euler with the damper's force at the end of the step."""
    return matrices(1 - h * h * s / (1 + h * c), h / (1 + h * c), -h * s / (1 + h * c), 1 / (1 + h * c))


def held_parabola(s: float, c: float, h: Array) -> Array:
    """The force at the start of the step held over it, and the motion under that exact, as RK4 makes it."""
    return matrices(1 - h * h * s / 2, h - h * h * c / 2, -h * s, 1 - h * c)


def runge_kutta_4(s: float, c: float, h: Array) -> Array:
    """The Taylor polynomial of degree 4, which is the stability function of every RK4."""
    a = matrices(0 * h, h, -h * s, -h * c)
    one = np.eye(2)
    return one + a @ (one + a / 2 @ (one + a / 3 @ (one + a / 4)))


def matrices(a: Array, b: Array, c: Array, d: Array) -> Array:
    """Return ((a, b), (c, d)) for numbers (n,), as (n, 2, 2)."""
    return np.stack(np.broadcast_arrays(a, b, c, d), axis=-1).reshape(-1, 2, 2)


# By the names of tumble.compare.engines.SCHEME_NAMES, except those that `theory` reads itself.
SCHEMES: dict[str, tuple[str, Scheme]] = {
    "semi-implicit-euler": ("semi-implicit Euler", semi_implicit_euler),
    "damping-implicit-euler": ("semi-implicit Euler, damping implicit", damping_implicit_euler),
    "held-parabola": ("RK4 of a held force", held_parabola),
    "rk4": ("RK4", runge_kutta_4),
}


@dataclass(frozen=True)
class Theory:
    """The limit of rate * dt, 0 if every step is unstable, infinite if none is, and its source."""

    w_dt: float
    source: str


STABILITY_FUNCTION = "spectral radius of one step on the stiffest mode (Hairer and Wanner II, IV.2)"
A_STABLE = Theory(UNLIMITED, "A-stable: bounded at every step (Hairer and Wanner II, IV.3 and IV.5)")

# What a step may turn a free body by [rad], by the names of tumble.compare.engines.GYROSCOPIC_NAMES.
FREE = {
    "none": Theory(UNLIMITED, "no gyroscopic torque: the angular velocity stands still"),
    "explicit": Theory(0.0, "gyroscopic torque by explicit Euler: |1 + i h lambda| > 1 at every step"),
    "implicit": Theory(UNLIMITED, "gyroscopic torque by implicit Euler: damps at every step"),
    "rescaled": Theory(UNLIMITED, "keeps the length of the angular momentum L at every step, and so 2 T <= L^2/A"),
    "keeps-momentum": Theory(UNLIMITED, "keeps the angular momentum L at every step, and so 2 T <= L^2/A"),
    "midpoint": Theory(UNLIMITED, "gyroscopic torque by the implicit midpoint rule: bounded at every step"),
}
NO_TORQUE = Theory(UNLIMITED, "equal moments: there is no gyroscopic torque")


def theory(running_engine: RunningEngine, method: str, scene: Scene, mode: Mode) -> Theory | None:
    """Return the limit of a method on this scene, None if its engine does not state a scheme."""
    if isinstance(running_engine.info, Failure):
        return None
    if scene.is_free:
        gyroscopic, largest_turn = running_engine.info.gyroscopic, running_engine.info.largest_turn
        return free_theory(stated(gyroscopic, method), largest_turn, scene)
    schemes = running_engine.info.schemes
    name = schemes.get(method) or schemes.get(str(MethodName.parse(method).without_tolerance))
    if name is None:
        return None
    if name == "a-stable":
        return A_STABLE
    if name == "drag-implicit-euler":
        name = "semi-implicit-euler" if stiffness(scene) else "damping-implicit-euler"
    if name != OWN_SCHEME:
        title, scheme = SCHEMES[name]
        return Theory(limit_of(scheme, mode), f"{title}: {STABILITY_FUNCTION}")
    return own_theory(running_engine, method, mode)


def own_theory(running_engine: RunningEngine, method: str, mode: Mode) -> Theory | None:
    """Return the limit of a scheme that an engine states as a function, which its process computes."""

    def scheme(s: float, c: float, h: Array) -> Array:
        answer = running_engine.worker.step_matrices(method, s, c, h)
        if isinstance(answer, Failure):
            raise SchemeFailed(str(answer))
        return answer

    try:
        return Theory(limit_of(scheme, mode), f"its own scheme: {STABILITY_FUNCTION}")
    except SchemeFailed:
        return None


class SchemeFailed(Exception):
    """An engine's own scheme raised, or its process ended."""


def stated(of: dict[str, str], method: str) -> str | None:
    """Return what an engine states of METHOD[+VARIANT...][@TOLERANCE], or else of METHOD."""
    asked = MethodName.parse(method)
    return of.get(str(asked.without_tolerance)) or of.get(asked.name)


def free_theory(gyroscopic: str | None, largest_turn: float | None, scene: Scene) -> Theory | None:
    """Return the limit of |w| dt for a body that rotates freely: the smaller of two limits."""
    if gyroscopic is None:
        return None
    of_torque = FREE[gyroscopic]
    if np.ptp(scene.body.moments) == 0 and gyroscopic != "keeps-momentum":
        of_torque = NO_TORQUE
    if largest_turn is None or of_torque.w_dt <= largest_turn:
        return of_torque
    return Theory(largest_turn, f"no step rotates a body by more than {largest_turn:.4g} rad, according to its source")


def limit_of(scheme: Scheme, mode: Mode) -> float:
    """Return the rate * dt below which no step of the scheme lets the mode grow, to a relative 3e-6."""

    def first_growing(w_dts: Array) -> int | None:
        grows = growths(scheme(mode.stiffness, mode.damping, w_dts / mode.rate)) > ON_THE_CIRCLE
        return int(np.argmax(grows)) if grows.any() else None

    place = first_growing(SCANNED)
    if place is None:
        return UNLIMITED
    if place == 0:
        return 0.0
    finer = np.linspace(SCANNED[place - 1], SCANNED[place], len(SCANNED))
    return float(finer[(first_growing(finer) or 1) - 1])


def growths(steps: Array) -> Array:
    """Return by how much 2x2 matrices, (n, 2, 2), violate Jury's conditions for eigenvalues within the unit circle."""
    trace, det = np.trace(steps, axis1=-2, axis2=-1), np.linalg.det(steps)
    return np.maximum(det - 1.0, abs(trace) - 1.0 - det)
