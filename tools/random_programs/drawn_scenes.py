"""Scenes drawn at random: boxes and rigid bodies, thrown, perhaps with impulses, a tether or drag."""

from dataclasses import replace

import numpy as np

from tools.random_programs.scene import Impulse, Scene, Tether, box_inertia, corners

# How fast a drawn body turns in its fastest part of a second, and how large it is.
SPINS, SIZES = (0.5, 9.0), (0.02, 4.0)


def drawn(random: np.random.Generator) -> Scene:
    """Return a scene drawn at random: a box or a rigid body, thrown, perhaps with impulses, a tether or drag."""
    reach = float(np.exp(random.uniform(*np.log(SIZES))))
    size = _rounded(reach * _edges(random), 3)
    mass = float(_rounded(np.exp(random.uniform(-1.5, 3.0)), 3))
    scene = Scene(
        "drawn",
        float(random.choice((1.0, 1.5, 2.0, 3.0))),
        mass,
        box_inertia(mass, size),
        corners(size),
        np.zeros(3) if random.random() < 0.25 else _rounded(random.normal(size=3) * (1 + reach), 3),
        np.array((1.0, 0.0, 0.0, 0.0)) if random.random() < 0.25 else _unit(random),
        np.zeros(3) if random.random() < 0.15 else _rounded(random.normal(size=3) * 2.5, 3),
        _rounded(_direction(random) * np.exp(random.uniform(*np.log(SPINS))), 3),
        _gravity(random),
        size,
    )
    if random.random() < 0.35:
        scene = _rigid(scene, random)
    if random.random() < 0.5:
        scene = replace(scene, impulses=_impulses(scene, random))
    if scene.impulses and random.random() < 0.3:
        scene = replace(scene, w=np.zeros(3))
    if random.random() < 0.15:
        scene = replace(scene, tethers=(_tether(scene, random),))
    if random.random() < 0.12:
        rates = np.exp(random.uniform(-2.5, 0.5, size=2))
        angular = rates[1] * float(np.mean(scene.moments))
        scene = replace(scene, drag=(float(_rounded(rates[0] * mass, 3)), float(_rounded(angular, 3))))
    return scene


def _rounded(values: np.ndarray | float, figures: int) -> np.ndarray:
    """Return numbers as somebody would write them."""
    return np.vectorize(lambda value: float(f"{value:.{figures}g}"))(values)


def _edges(random: np.random.Generator) -> np.ndarray:
    """Return the edges of a box whose longest is 1: of all kinds, some of them equal."""
    kind = random.random()
    if kind < 0.12:
        return np.ones(3)
    edges = np.array((1.0, random.uniform(0.15, 0.95), random.uniform(0.15, 0.95)))
    if kind < 0.22:
        edges[2] = edges[1]
    return random.permutation(edges)


def _direction(random: np.random.Generator) -> np.ndarray:
    """Return a direction; sometimes nearly along one axis, as in the Dzhanibekov effect."""
    direction = random.normal(size=3) * (np.array((1.0, 0.01, 0.01)) if random.random() < 0.15 else 1.0)
    return random.permutation(direction / np.linalg.norm(direction))


def _unit(random: np.random.Generator) -> np.ndarray:
    q = random.normal(size=4)
    return q / np.linalg.norm(q)


def _gravity(random: np.random.Generator) -> np.ndarray:
    kind = random.random()
    if kind < 0.2:
        return np.zeros(3)
    size = float(random.choice((9.81, 9.8, 9.80665, 10.0, 1.62, 3.71)))
    return -size * np.eye(3)[2 if kind < 0.45 else 1]


def _rigid(scene: Scene, random: np.random.Generator) -> Scene:
    """Return the scene with a body given by its tensor, perhaps with products of inertia, and by points."""
    assert scene.size is not None
    squares = np.square(scene.size) * random.uniform(0.6, 1.4, size=3)
    tensor = scene.mass / 12 * np.diag(squares.sum() - squares)
    if random.random() < 0.5:
        turn, _ = np.linalg.qr(random.normal(size=(3, 3)))
        tensor = turn @ tensor @ turn.T
        tensor = 0.5 * (tensor + tensor.T)
    count = int(random.integers(4, 10))
    points = _rounded(random.uniform(-0.5, 0.5, size=(count, 3)) * scene.size, 3)
    return replace(scene, size=None, inertia=tensor, points=points)


# Of a tether, as fast as it can make the body swing [rad/s].
SWINGS = (4.0, 15.0)
# Impulses change velocities by about as much as bodies have.
KICK, TIMES = 2.0, (0.2, 0.25, 0.3, 0.5, 0.6, 0.75)


def _impulses(scene: Scene, random: np.random.Generator) -> tuple[Impulse, ...]:
    times = [0.0] if random.random() < 0.5 else []
    later = [time for time in TIMES if time < 0.7 * scene.duration]
    count = int(random.integers(0 if times else 1, 3))
    times += sorted(random.choice(later, size=min(count, len(later)), replace=False).tolist())
    return tuple(_drawn_impulse(scene, time, random) for time in times)


def _drawn_impulse(scene: Scene, time: float, random: np.random.Generator) -> Impulse:
    """Return an impulse that neither stops the body nor makes it spin like a top."""
    vertex = int(random.integers(len(scene.points)))
    at = scene.points[vertex]
    direction = _unit(random)[:3]
    turns = float(np.linalg.norm(np.linalg.solve(scene.inertia, np.cross(at, direction))))
    size = min(KICK * scene.mass * random.uniform(0.3, 1.5), SPINS[1] * random.uniform(0.2, 1.0) / (turns + 1e-12))
    value = _rounded(size * direction, 3)
    kind = random.random()
    if kind < 0.5:
        return Impulse(time, value, vertex=vertex)
    if kind < 0.75 or time > 0:
        return Impulse(time, value, point_body=_rounded(at * random.uniform(0.5, 1.0, size=3), 3))
    axes = np.array(_rotation(scene.q))
    return Impulse(time, value, point=_rounded(scene.x + axes @ at, 4))


def _rotation(q: np.ndarray) -> list[list[float]]:
    w, x, y, z = q
    return [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]


def _tether(scene: Scene, random: np.random.Generator) -> Tether:
    """Return a tether that swings the body, and turns it to and fro, in a second or so."""
    anchor = scene.x + _direction(random) * (1 + 2 * scene.reach)
    stiffness = random.uniform(*SWINGS) ** 2 / (1 / scene.mass + scene.reach**2 / scene.moments[0])
    rest = 0.0 if random.random() < 0.5 else float(_rounded(random.uniform(0.3, 1.0), 2))
    damping = 0.0 if random.random() < 0.4 else float(_rounded(scene.mass * random.uniform(0.1, 0.8), 2))
    vertex = int(random.integers(len(scene.points)))
    return Tether(vertex, _rounded(anchor, 3), float(_rounded(stiffness, 3)), damping, rest)
