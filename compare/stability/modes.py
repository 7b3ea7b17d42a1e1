"""The stiffest mode of a scene, and what theory says of how long a step it bears.

A scene is linearised about a state: twelve numbers, the shift x [m] and velocity v [m/s] in world axes, the small turn
phi [rad] and the angular velocity w [rad/s] in body axes,

    x' = v,   phi' = w - w0 x phi,   m v' = F,   I w' = tau + (I w) x w,

with forces and torques differentiated numerically.  The mode with the largest eigenvalue is the one that limits a step.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from scenarios.frames import Array, quaternion_product, rotation_matrix
from scenarios.impulse import jump
from scenarios.scene import Scene

DIFFERENCE = math.sqrt(np.finfo(float).eps)  # of the body's size, of a radian, and of as much in a second
UNLIMITED = math.inf
COARSEST = 1e3
SCANNED = np.geomspace(1e-3, COARSEST, 2000)
ON_THE_CIRCLE = 1e-9  # how far rounding may put an eigenvalue of modulus one, which may be a double one, off it


@dataclass(frozen=True)
class Mode:
    """The stiffest mode, u'' + damping u' + stiffness u = 0 [1/s, 1/s2]; rate [rad/s]: its largest |eigenvalue|."""

    rate: float
    damping: float = 0.0
    stiffness: float = 0.0


def struck_start(scene: Scene) -> Array:
    """Return the state of the first throw after the impulses of t = 0, (1, 13)."""
    states = scene.start[:1]
    for impulse in scene.impulses:
        if impulse.time == 0.0:
            states = jump(impulse, states, scene.body)
    return states


def stiffest_mode(scene: Scene) -> Mode:
    """Return the mode of the largest |eigenvalue| at the start of the first throw, of rate 0 where there is none."""
    matrix = linearised(scene, struck_start(scene)[0])
    eigenvalues, vectors = np.linalg.eig(matrix)
    largest = int(np.argmax(np.abs(eigenvalues)))
    if scene.is_free:
        return Mode(float(abs(eigenvalues[largest])))
    u = vectors[:6, largest]
    weighted = u.conj() * np.repeat((scene.body.mass, *scene.body.moments), (3, 1, 1, 1))
    stiffness, damping = (-weighted @ block @ u / (weighted @ u) for block in (matrix[6:, :6], matrix[6:, 6:]))
    return Mode(float(abs(eigenvalues[largest])), max(0.0, float(damping.real)), max(0.0, float(stiffness.real)))


def linearised(scene: Scene, state: Array) -> Array:
    """Return the matrix A of y' = A y, y = (x, phi, v, w), (12, 12), at one state, (13,)."""
    moments, axes = scene.body.moments, rotation_matrix(state[3:7])
    w_body = axes.T @ state[10:13]
    matrix = np.zeros((12, 12))
    matrix[0:3, 6:9] = matrix[3:6, 9:12] = np.eye(3)
    matrix[3:6, 3:6] = -cross_matrix(w_body)
    matrix[9:12, 9:12] = (cross_matrix(moments * w_body) - cross_matrix(w_body) * moments) / moments[:, None]
    if not scene.is_free:
        matrix[6:12] += pulled(scene, state, axes)
    return matrix


def pulled(scene: Scene, state: Array, axes: Array) -> Array:
    """Return the derivatives of the accelerations that forces give, (6, 12), by central differences."""
    from scenarios.wrench import wrench  # it brings a compiler, which a free scene has no use for

    size = float(np.linalg.norm(scene.body.points, axis=1).max())
    steps = DIFFERENCE * np.repeat((size, 1.0, size, 1.0), 3)
    sides = [np.array([moved(state, axes, sign * change) for change in np.diag(steps)]) for sign in (1.0, -1.0)]
    ahead, behind = map(wrench(scene), sides)
    # A body turned by phi has the axes R exp(phi~), and the torque is wanted in those.
    for wrenches, states in zip((ahead, behind), sides, strict=True):
        wrenches[:, 3:6] = np.einsum("nji,nj->ni", rotation_matrix(states[:, 3:7]), wrenches[:, 3:6])
    inertia = np.repeat((scene.body.mass, *scene.body.moments), (3, 1, 1, 1))
    return ((ahead - behind) / (2 * steps[:, None]) / inertia).T


def moved(state: Array, axes: Array, change: Array) -> Array:
    """Return a state, (13,), moved by small x, phi, v and w, (12,)."""
    turn = np.array((1.0, *(change[3:6] / 2)))
    q = quaternion_product(state[3:7], turn / np.linalg.norm(turn))
    w_body = axes.T @ state[10:13] + change[9:12]
    return np.concatenate((state[0:3] + change[0:3], q, state[7:10] + change[6:9], rotation_matrix(q) @ w_body))


def cross_matrix(a: Array) -> Array:
    """Return the matrix of b -> a x b."""
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


# One step of a scheme on u'' + c u' + s u = 0 as a matrix on (u, u'), with the step h.
Scheme = Callable[[float, float, float], Array]


def semi_implicit_euler(s: float, c: float, h: float) -> Array:
    """First the velocity by the force at the start of the step, then the position by the new velocity."""
    return np.array([[1 - h * h * s, h * (1 - h * c)], [-h * s, 1 - h * c]])


def damping_implicit_euler(s: float, c: float, h: float) -> Array:
    """Semi-implicit Euler with the damper's force at the end of the step."""
    return np.array([[1 - h * h * s / (1 + h * c), h / (1 + h * c)], [-h * s / (1 + h * c), 1 / (1 + h * c)]])


def held_parabola(s: float, c: float, h: float) -> Array:
    """The force at the start of the step held over it, and the motion under that exact, as RK4 makes it."""
    return np.array([[1 - h * h * s / 2, h - h * h * c / 2], [-h * s, 1 - h * c]])


def runge_kutta_4(s: float, c: float, h: float) -> Array:
    """The Taylor polynomial of degree 4, which is the stability function of every RK4."""
    a = h * np.array([[0.0, 1.0], [-s, -c]])
    one = np.eye(2)
    return one + a @ (one + a / 2 @ (one + a / 3 @ (one + a / 4)))


@dataclass(frozen=True)
class Theory:
    """The limit of rate * dt: 0 where every step grows, infinite where none does; and where that is from."""

    w_dt: float
    source: str


STABILITY_FUNCTION = "spectral radius of one step on the stiffest mode (Hairer and Wanner II, IV.2)"
A_STABLE = "A-stable: bounded at every step (Hairer and Wanner II, IV.3 and IV.5)"

# Which scheme a contestant is where forces act, by its name without engine: read in its documentation or source.
SCHEMES: dict[str, tuple[str, Scheme]] = {
    "tumble:rk4": ("RK4", runge_kutta_4),
    "tumble:symplectic-euler": ("semi-implicit Euler", semi_implicit_euler),
    "mujoco:euler": ("semi-implicit Euler", semi_implicit_euler),
    "mujoco:rk4": ("RK4", runge_kutta_4),
    "mujoco:implicit": ("semi-implicit Euler, damping implicit", damping_implicit_euler),
    "mujoco:implicitfast": ("semi-implicit Euler, damping implicit", damping_implicit_euler),
    "mujoco:rk4+held": ("RK4 of a held force", held_parabola),
    "mujoco:rk4+defaults": ("RK4 of a held force", held_parabola),
    **{
        f"{engine}:{method}+{manner}": ("semi-implicit Euler of a held force", semi_implicit_euler)
        for engine, methods in (
            ("pybullet", ("multibody", "rigidbody")),
            ("mujoco", ("euler", "implicit", "implicitfast", "discrete")),
        )
        for method in methods
        for manner in ("held", "defaults")
    },
}
# MuJoCo's Euler takes the damping of joints implicitly ("eulerdamp"), which is what drag is there, and no other.
JOINT_DAMPING = SCHEMES["mujoco:implicit"]
COLLOCATION = ("tumble:gauss6", "tumble:radau5")

# What a step may turn a free body by [rad] before its engine's rotation goes wrong.
EXPLICIT_TORQUE = Theory(0.0, "gyroscopic torque by explicit Euler: |1 + i h lambda| > 1 at every step")
BULLET_TURN = Theory(math.pi / 4, "ANGULAR_MOTION_THRESHOLD in Bullet's btTransformUtil.h: no step turns further")
KEEPS_MOMENTUM = Theory(UNLIMITED, "keeps the angular momentum L at every step, and so 2 T <= L^2/A")
IMPLICIT_TORQUE = Theory(UNLIMITED, "gyroscopic torque by implicit Euler: damps at every step")


def theory(contestant: str, scene: Scene, mode: Mode) -> Theory | None:
    """Return what theory says of ENGINE:METHOD on this scene, None where there is none that we know of."""
    if scene.is_free:
        return free_theory(contestant, scene)
    if contestant in COLLOCATION:
        return Theory(UNLIMITED, A_STABLE)
    if contestant not in SCHEMES:
        return None
    name, scheme = SCHEMES[contestant]
    if contestant == "mujoco:euler" and not (scene.tethers or scene.floor):
        name, scheme = JOINT_DAMPING
    return Theory(limit_of(scheme, mode), f"{name}: {STABILITY_FUNCTION}")


def free_theory(contestant: str, scene: Scene) -> Theory | None:
    """Return what is known of |w| dt for a body that turns freely."""
    engine, _, method = contestant.partition(":")
    kind = method.partition("+")[0]
    if engine == "tumble":
        from solver.registry import METHODS  # with all kernels, which no other engine needs

        claim = METHODS.get(kind.partition("@")[0])
        return KEEPS_MOMENTUM if claim is not None and claim.keeps_momentum else None
    uneven = np.ptp(scene.body.moments) > 0
    known = {
        "pybullet": {"multibody": EXPLICIT_TORQUE if uneven else BULLET_TURN, "rigidbody": BULLET_TURN},
        "mujoco": {"euler": EXPLICIT_TORQUE if uneven else IMPLICIT_TORQUE}
        | dict.fromkeys(("implicit", "implicitfast", "discrete"), IMPLICIT_TORQUE),
    }
    return known.get(engine, {}).get(kind)


def limit_of(scheme: Scheme, mode: Mode) -> float:
    """Return the rate * dt below which no step of the scheme lets the mode grow."""

    def bounded(w_dt: float) -> bool:
        step = scheme(mode.stiffness, mode.damping, w_dt / mode.rate)
        return grows_by(step) <= ON_THE_CIRCLE

    place = next((number for number, w_dt in enumerate(SCANNED) if not bounded(w_dt)), None)
    if place is None:
        return UNLIMITED
    return edge(SCANNED[place - 1], SCANNED[place], bounded, 1e-6) if place else 0.0


def edge(low: float, high: float, holds: Callable[[float], bool], within: float) -> float:
    """Return the last number at which something holds that does at low and not at high, to a relative precision."""
    while high > (1 + within) * low:
        middle = math.sqrt(low * high)
        low, high = (middle, high) if holds(middle) else (low, middle)
    return float(low)


def grows_by(step: Array) -> float:
    """Return by how much a real 2x2 matrix fails Jury's conditions for eigenvalues within the unit circle."""
    trace, det = float(np.trace(step)), float(np.linalg.det(step))
    return max(det - 1.0, abs(trace) - 1.0 - det)
