"""Mistakes with inertia, with Euler's equations and with how the angular velocity turns the body."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from tools.random_programs.algebra import (
    Matrix,
    Quaternion,
    Vector,
    cross,
    matrix,
    scale,
    times,
    times_transposed,
    transposed,
)
from tools.random_programs.mistakes.kind import even, has_euler, is_struck, is_turned, mistake, one_of, spins
from tools.random_programs.scene import Scene, box_inertia, corners
from tools.random_programs.scheme import Scheme
from tools.random_programs.simulation import Simulation

ORDERS = {"y z x": (1, 2, 0), "z x y": (2, 0, 1), "y x z": (1, 0, 2), "x z y": (0, 2, 1), "z y x": (2, 1, 0)}


def _triaxial(scene: Scene, scheme: Scheme) -> bool:
    return scene.is_triaxial and (scheme.gyroscopic != "none" or is_struck(scene, scheme))


def _box(scene: Scene, scheme: Scheme) -> bool:
    return scene.size is not None and _triaxial(scene, scheme)


def _skewed(scene: Scene, scheme: Scheme) -> bool:
    """Whether the tensor has products of inertia."""
    return _triaxial(scene, scheme) and bool(np.abs(scene.inertia - np.diag(np.diag(scene.inertia))).max() > 1e-6)


def _rate_matters(scene: Scene, scheme: Scheme) -> bool:
    return (spins(scene, scheme) or is_struck(scene, scheme)) and not scheme.recovers


def _order(random: np.random.Generator, scene: Scene, scheme: Scheme) -> str:
    """Return an order of axes that makes a difference."""
    diagonal = np.diag(scene.inertia)
    different = [name for name, order in ORDERS.items() if not np.allclose(diagonal[list(order)], diagonal, rtol=1e-2)]
    return str(random.choice(different or list(ORDERS)))


# --- inertia --------------------------------------------------------------------------------------------------------


@mistake("inertia", "inertia of a sphere", _triaxial)
def _(sim: Simulation) -> None:
    sim.set_inertia(np.trace(sim.scene.inertia) / 3 * np.eye(3))


@mistake("inertia", "inertia of permuted axes", lambda s, p: _triaxial(s, p) and not _skewed(s, p), order=_order)
def _(sim: Simulation, order: str) -> None:
    sim.set_inertia(np.diag(np.diag(sim.scene.inertia)[list(ORDERS[order])]))


@mistake(
    "inertia",
    "inverse for inertia",
    lambda s, p: _triaxial(s, p) and not is_struck(s, p) and not s.tethers and not s.drag[1],
)
def _(sim: Simulation) -> None:
    sim.set_inertia(np.linalg.inv(sim.scene.inertia))


@mistake("inertia", "another inertia", is_struck, factor=one_of(0.25, 4.0, 0.5, 2.0, 0.6, 12.0, 1.5))
def _(sim: Simulation, factor: float) -> None:
    sim.set_inertia(factor * sim.scene.inertia)


@mistake("inertia", "edges in another order", _box, order=_order)
def _(sim: Simulation, order: str) -> None:
    assert sim.scene.size is not None
    resize(sim, sim.scene.size[list(ORDERS[order])])


@mistake("inertia", "another size along an axis", _box, axis=one_of(0, 1, 2), factor=one_of(0.5, 2.0, 0.8, 1.3))
def _(sim: Simulation, axis: int, factor: float) -> None:
    assert sim.scene.size is not None
    size = sim.scene.size.copy()
    size[axis] *= factor
    resize(sim, size)


@mistake("inertia", "inertia never turned", lambda s, p: has_euler(s, p) and is_turned(s, p))
def _(sim: Simulation) -> None:
    _axes(sim, lambda q: sim.tensor(np.eye(3)))


@mistake("inertia", "inertia frozen at the start", has_euler)
def _(sim: Simulation) -> None:
    first = sim.first
    _axes(sim, lambda q: first)


@mistake("inertia", "inertia turned the wrong way", lambda s, p: has_euler(s, p) and is_turned(s, p))
def _(sim: Simulation) -> None:
    _axes(sim, lambda q: transposed(matrix(q)))


# --- Euler's equations ----------------------------------------------------------------------------------------------


@mistake("gyroscopic", "gyroscopic term missing", has_euler)
def _(sim: Simulation) -> None:
    sim.gyroscopic = sim.number(0.0)


@mistake("gyroscopic", "gyroscopic term reversed", has_euler)
def _(sim: Simulation) -> None:
    sim.gyroscopic = sim.number(-1.0)


@mistake("gyroscopic", "angular velocity in the wrong frame", _rate_matters)
def _(sim: Simulation) -> None:
    """Q w~ for w~ Q, where w is in world axes."""
    sim.turn_rate = lambda q, w: times(matrix(q), w)


@mistake("gyroscopic", "half of q' missing", _rate_matters)
def _(sim: Simulation) -> None:
    sim.turn_rate = lambda q, w: scale(2, w)


@mistake("gyroscopic", "half of q' twice", _rate_matters)
def _(sim: Simulation) -> None:
    sim.turn_rate = lambda q, w: scale(0.5, w)


# --- without a name when this was written ---------------------------------------------------------------------------


@mistake("gyroscopic", "a part of the gyroscopic term", has_euler, share=one_of(0.5, 0.25, 1.5, 2.0))
def _(sim: Simulation, share: float) -> None:
    sim.gyroscopic = sim.number(share)


@mistake("gyroscopic", "inverse inertia in the gyroscopic term", has_euler)
def _(sim: Simulation) -> None:
    """w' = I^-1 (torque - w x I^-1 w), scaled to be as large as the right one could be."""
    size = sim.number(np.linalg.norm(sim.scene.inertia) / np.linalg.norm(np.linalg.inv(sim.scene.inertia)))

    def euler(q: Quaternion, w: Vector, torque: Vector) -> Vector:
        axes = sim.tensor_axes(q)
        wrong = scale(size, times(axes, times(sim.inverse, times_transposed(axes, w))))
        return sim.from_torque(q, tuple(t - c for t, c in zip(torque, cross(w, wrong), strict=True)))  # type: ignore[arg-type]

    sim.euler = euler
    sim.spin = lambda q, w, dt: _stepped(sim, q, w, dt)


@mistake("gyroscopic", "tensor in body axes, its inverse in world axes", lambda s, p: has_euler(s, p))
def _(sim: Simulation) -> None:
    unturned = sim.tensor(np.eye(3))
    sim.tensor_axes = lambda q: unturned


@mistake("gyroscopic", "gyroscopic torque clamped", has_euler, share=even(0.1, 0.6))
def _(sim: Simulation, share: float) -> None:
    """No larger than a share of what it could be at the start, as engines that fear for their stability do."""
    spread = float(np.ptp(sim.scene.moments))
    most = sim.number(share * spread * max(0.3, float(np.linalg.norm(sim.scene.w))) ** 2 / 2)

    def euler(q: Quaternion, w: Vector, torque: Vector) -> Vector:
        term = cross(w, sim.momentum(q, w))
        size = sum(part * part for part in term) ** 0.5
        term = scale(most / size, term) if size > most else term
        return sim.from_torque(q, tuple(t - c for t, c in zip(torque, term, strict=True)))  # type: ignore[arg-type]

    sim.euler = euler
    sim.spin = lambda q, w, dt: _stepped(sim, q, w, dt)


@mistake("inertia", "inertia turned every n-th step only", has_euler, steps=one_of(5, 10, 25))
def _(sim: Simulation, steps: int) -> None:
    kept: list[Matrix] = [sim.first]

    def remember() -> None:
        if sim.count % steps == 0:
            kept[0] = matrix(sim.q)

    sim.before.append(remember)
    _axes(sim, lambda q: kept[0])


@mistake("inertia", "products of inertia left out", _skewed)
def _(sim: Simulation) -> None:
    sim.set_inertia(np.diag(np.diag(sim.scene.inertia)))


@mistake("inertia", "products of inertia of the other sign", _skewed)
def _(sim: Simulation) -> None:
    """As CAD programs of the other convention write them."""
    diagonal = np.diag(np.diag(sim.scene.inertia))
    sim.set_inertia(2 * diagonal - sim.scene.inertia)


@mistake("inertia", "inertia of a hollow box", _box)
def _(sim: Simulation) -> None:
    """Six thin plates."""
    a, b, c = sim.scene.size  # type: ignore[misc]

    def about(x: float, y: float, z: float) -> float:
        """Return the moment about z."""
        plates = y * z * (x * x / 4 + y * y / 12) + x * z * (y * y / 4 + x * x / 12) + x * y * (x * x + y * y) / 12
        return sim.scene.mass * plates / (y * z + x * z + x * y)

    sim.set_inertia(np.diag((about(b, c, a), about(c, a, b), about(a, b, c))))


@mistake("inertia", "inertia about a vertex", _triaxial)
def _(sim: Simulation) -> None:
    """The parallel axis theorem, where the centre of mass is meant."""
    p = sim.points[-1]
    sim.set_inertia(sim.scene.inertia + sim.scene.mass * (p @ p * np.eye(3) - np.outer(p, p)))


@mistake("inertia", "a moment that drifts", has_euler, rate=even(0.02, 0.5))
def _(sim: Simulation, rate: float) -> None:
    largest = np.zeros((3, 3))
    largest[0, 0] = sim.scene.inertia[0, 0]
    sim.before.append(lambda: sim.set_inertia(sim.scene.inertia + rate * sim.now * largest))


@mistake("gyroscopic", "every n-th step turned on the wrong side", _rate_matters, steps=one_of(3, 5, 10))
def _(sim: Simulation, steps: int) -> None:
    sim.turn_rate = lambda q, w: times(matrix(q), w) if sim.count % steps == steps - 1 else w


@mistake("gyroscopic", "Euler angles add up", _rate_matters, order=one_of("xyz", "zyx", "zxy", "yxz"))
def _(sim: Simulation, order: str) -> None:
    """angles += w dt: components of w taken for rates of three angles."""
    angles = Rotation.from_quat(np.array(sim.q, float), scalar_first=True).as_euler(order)

    def turned(q: Quaternion, w: Vector, dt: float) -> Quaternion:
        for place, axis in enumerate(order):
            angles[place] += w["xyz".index(axis)] * dt
        return tuple(map(sim.number, Rotation.from_euler(order, angles).as_quat(scalar_first=True)))  # type: ignore[return-value]

    sim.turned = turned


@mistake("gyroscopic", "attitude in few bits", _rate_matters)
def _(sim: Simulation) -> None:
    """Each step's quaternion is kept in so few bits that the turn of a step is lost in part."""
    step = 2.0**-10
    right = sim.turned

    def turned(q: Quaternion, w: Vector, dt: float) -> Quaternion:
        rounded = np.round(np.array(right(q, w, dt)) / step) * step
        return tuple(map(sim.number, rounded / np.linalg.norm(rounded)))  # type: ignore[return-value]

    sim.turned = turned


@mistake("gyroscopic", "quaternion multiplied by the conjugate turn at w < 0", _rate_matters)
def _(sim: Simulation) -> None:
    """Where the scalar is negative the sign is taken out of it alone, and the body turns back."""
    sim.turn_rate = lambda q, w: w if q[0] >= 0 else scale(-1, w)


@mistake(
    "gyroscopic", "angular velocity carried round with the body", lambda s, p: _rate_matters(s, p) and is_struck(s, p)
)
def _(sim: Simulation) -> None:
    """Impulses change w in world axes, and it is turned with the body from step to step as if it were in body axes."""
    before = [matrix(sim.q)]

    def carry(dt: float) -> None:
        axes = matrix(sim.q)
        sim.w = times(axes, times_transposed(before[0], sim.w))
        before[0] = axes

    sim.after.append(carry)


# --- how ------------------------------------------------------------------------------------------------------------


def _axes(sim: Simulation, axes) -> None:
    """Set the axes of the tensor and of its inverse."""
    sim.tensor_axes = sim.inverse_axes = axes


def resize(sim: Simulation, size: np.ndarray) -> None:
    """Make a box of other edges and the same mass; what strikes a vertex strikes it where it is now."""
    sim.points = corners(size)
    sim.scene = replace(sim.scene, size=size, points=sim.points, inertia=box_inertia(sim.scene.mass, size))
    sim.set_inertia(sim.scene.inertia)


def _stepped(sim: Simulation, q: Quaternion, w: Vector, dt: float) -> Vector:
    """Return w after an explicit step of the program's own equations."""
    rate = sim.euler(q, w, sim.vector((0, 0, 0)))
    return tuple(a + dt * b for a, b in zip(w, rate, strict=True))  # type: ignore[return-value]
