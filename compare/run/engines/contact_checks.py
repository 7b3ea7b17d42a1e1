"""Checks of contact with a rigid plane: the pair's coefficients, and laws that need no truth.

What fails here is an adapter's mistake or the engine's own law.  An engine file states the latter (KNOWN_FAILURES); the
check is made all the same, and what is stated and passes is a failure too.
"""

import math
from dataclasses import replace
from types import ModuleType

import numpy as np

from tumble.compare.run.engines.brick import PLANE, SIZE, Broken, flown_in, over_plane, step
from tumble.scenarios.frames import Array, vertices
from tumble.scenarios.scene import Body, Plane, Scene, frozen_array

DT, FALL = 1 / 2048, 9.81  # s, m/s2
UP, OBLIQUE = np.array([0.0, 1.0, 0.0]), np.array([1.0, 2.0, -2.0]) / 3
RADIUS = 0.1
# Of two coefficients each: a rule that mixes them with another number is not right for both.
FRICTIONS, RESTITUTIONS = (0.2, 0.6), (0.3, 0.8)
# Within this share of mu g t a ball is slowed, of the approach's speed it rebounds; a soft contact takes a few steps.
SLOWED_WITHIN, REBOUND_WITHIN = 0.05, 0.05
# Shares of mu g t by which directions may differ, of the energy that one step of gravity may add, of speeds by which
# mirror images may differ.
DIRECTIONS_WITHIN, ENERGY_WITHIN, MIRRORED_WITHIN = 0.03, 0.01, 1e-3
# Steps by whose way a body may get below a plane, and m/s at which a body that rests may creep: MuJoCo's default, which
# does creep, is at some 2e-3.
STEPS_BELOW, CREEP = 5, 5e-4
AT_REST = (1.0, 0.0, 0.0, 0.0)
FLAT = np.array([0.5, 0.1, 0.4])  # m, of a box that does not tip


def ball(starts: Array, plane: Plane, gravity: Array | None) -> Scene:
    """Return a scene of a ball of 1 kg and RADIUS."""
    ends = RADIUS * np.vstack((np.zeros(3), np.eye(3), -np.eye(3)))
    moments = frozen_array(np.full(3, 0.4 * RADIUS**2))
    body = Body("sphere", 1.0, moments, frozen_array(ends), np.empty((0, 3), int), radius=RADIUS)
    times = frozen_array([1.0])
    field = None if gravity is None else frozen_array(gravity)
    return Scene("ball", "Ball", "", 1.0, times, DT, body, frozen_array(starts), field, plane=plane)


def plane_of(restitution: float, friction: float, normal: Array = UP) -> Plane:
    """Return a plane through a point that is not the origin."""
    return Plane(frozen_array(0.3 * normal), frozen_array(normal), restitution, friction)


def sliding(engine: ModuleType, method: str, friction: float, angles: Array, n: int) -> Array:
    """Return the change of velocity [m/s], (N, 2), of balls that slip at those angles to x: along the slip, across."""
    along = np.stack((np.cos(angles), np.zeros(len(angles)), -np.sin(angles)), axis=1)
    across = np.cross(UP, along)
    starts = np.zeros((len(angles), 13))
    starts[:, 0:3], starts[:, 3:7], starts[:, 7:10] = (0.3 + RADIUS) * UP, AT_REST, 3.0 * along
    states = flown_in(engine, method, ball(starts, plane_of(0.0, friction), -FALL * UP), (n, DT))
    change = states[:, 7:10] - starts[:, 7:10]
    return np.stack(((change * along).sum(axis=1), (change * across).sum(axis=1)), axis=1)


def slides_by_the_pairs_friction(engine: ModuleType, method: str) -> None:
    """A ball that slips along an axis slows at mu g, mu the pair's."""
    for friction in FRICTIONS:
        n = 205
        slowed = -sliding(engine, method, friction, np.array([0.0, math.pi / 2]), n)[:, 0] / (FALL * n * DT)
        worst = float(slowed[np.abs(slowed - friction).argmax()])
        if not abs(worst - friction) <= SLOWED_WITHIN * friction:
            raise Broken(f"a ball slows at {worst:.3g} g where the pair's friction is {friction:g}")


def rebounds_by_the_pairs_restitution(engine: ModuleType, method: str) -> None:
    """A ball rebounds at e times the speed of its approach, e the pair's, wherever in a step it meets the plane."""
    speed, shares = 3.0, np.array([0.0, 0.33, 0.71])
    for restitution in RESTITUTIONS:
        starts = np.zeros((3, 13))
        starts[:, 0:3] = (0.3 + RADIUS + 0.02 + shares[:, np.newaxis] * speed * DT) * OBLIQUE
        starts[:, 3:7], starts[:, 7:10] = AT_REST, -speed * OBLIQUE
        states = flown_in(engine, method, ball(starts, plane_of(restitution, 0.0, OBLIQUE), None), (100, DT))
        rebound = states[:, 7:10] @ OBLIQUE / speed
        worst = float(rebound[np.abs(rebound - restitution).argmax()])
        if not abs(worst - restitution) <= REBOUND_WITHIN:
            raise Broken(
                f"a ball rebounds at {worst:.3g} times its speed where the pair's restitution is {restitution:g}"
            )


# Boxes that come down within a tenth of a second: on a corner, on an edge, and one on a face's edge with a slip.
THROWN = np.zeros((3, 13))
THROWN[:, 0:3] = [[0.0, 0.13, 0.0], [2.0, 0.05, 0.0], [-2.0, 0.05, 1.0]]
THROWN[:, 3:7] = [[0.8, 0.3, -0.2, 0.4], [0.95, 0.0, 0.0, 0.3], [0.98, 0.1, 0.0, 0.05]]
THROWN[:, 7:13] = [[0.5, -2.0, 0.3, 5, 3, -4], [0.2, -2.0, 0.0, 0, 0, 2], [3.0, -1.0, 1.0, 0, 1, 0]]
THROWN[:, 3:7] /= np.linalg.norm(THROWN[:, 3:7], axis=1, keepdims=True)


def thrown(engine: ModuleType, method: str) -> tuple[Scene, Array]:
    """Return the scene of boxes that come down on a plane, and their states on the way, (S, N, 13)."""
    question = over_plane(THROWN)
    world = engine.build(question, method)
    engine.write(world, THROWN.copy())
    states = [THROWN]
    for _ in range(64):
        step(engine, world, (4, DT))
        states.append(np.array(engine.read(world)))
    return question, np.array(states)


def stays_above(engine: ModuleType, method: str) -> None:
    """Nothing gets below the plane by more than a few steps' way."""
    question, states = thrown(engine, method)
    plane, body = question.plane, question.body
    assert plane is not None
    way = STEPS_BELOW * DT * (np.linalg.norm(states[..., 7:10], axis=-1) + body.reach * spin(states)).max()
    depth = -((vertices(states, body.points) - plane.point) @ plane.normal).min()
    if not depth <= way:
        raise Broken(
            f"a box gets {1e3 * depth:.2g} mm below the plane; {STEPS_BELOW} steps' way are {1e3 * way:.2g} mm"
        )


def spin(states: Array) -> Array:
    """Return |w| [rad/s]."""
    return np.linalg.norm(states[..., 10:13], axis=-1)


def adds_no_energy(engine: ModuleType, method: str) -> None:
    """No impact adds energy."""
    question, states = thrown(engine, method)
    found = energy(question, states)
    gained = float(((found - found[0]) / energy(question, states, kinetic_alone=True)[0]).max())
    if not gained <= ENERGY_WITHIN:
        raise Broken(f"a box that comes down on the plane has {100 * gained:.3g} % more energy than it began with")


def energy(question: Scene, states: Array, kinetic_alone: bool = False) -> Array:
    """Return the energy of states (..., 13) [J]: kinetic, and potential in the scene's gravity."""
    body, gravity = question.body, question.gravity
    assert gravity is not None
    moving = body.mass / 2 * (states[..., 7:10] ** 2).sum(axis=-1)
    turn = vertices(np.where(np.arange(13) < 3, 0.0, states), np.eye(3))  # the body's axes, one a row
    turning = (body.moments * np.einsum("...ij,...j->...i", turn, states[..., 10:13]) ** 2).sum(axis=-1) / 2
    return moving + turning - (0.0 if kinetic_alone else body.mass * (states[..., 0:3] @ gravity))


def holds_below_the_critical_angle(engine: ModuleType, method: str) -> None:
    """A box at rest on an incline below the critical angle stays where it is."""
    angle, n = math.radians(20), 256
    question = over_plane(np.array([[0.0, 0.05, 0.0, *AT_REST, *(0.0,) * 6]]))
    pull = frozen_array(FALL * np.array([math.sin(angle), -math.cos(angle), 0.0]))
    flat = replace(
        question.body,
        points=frozen_array(question.body.points * FLAT / np.array(SIZE)),
        size=frozen_array(FLAT),
        moments=frozen_array(question.body.mass / 12 * (FLAT @ FLAT - FLAT**2)),
    )
    held = replace(
        question, body=flat, gravity=pull, plane=Plane(frozen_array(np.zeros(3)), frozen_array(UP), 0.0, 0.8)
    )
    world = engine.build(held, method)
    engine.write(world, held.start.copy())
    step(engine, world, (n, 2 * DT))
    before = np.array(engine.read(world))
    step(engine, world, (n, 2 * DT))
    way = np.array(engine.read(world))[0, 0:3] - before[0, 0:3]
    creep = float(np.linalg.norm(way - way @ UP * UP)) / (n * 2 * DT)
    if not creep <= CREEP:
        raise Broken(f"a box creeps at {1e3 * creep:.3g} mm/s on an incline of 20 degrees where friction 0.8 holds it")


def has_no_direction(engine: ModuleType, method: str) -> None:
    """Friction does not depend on the direction in the plane."""
    degrees, n, friction = np.array([0.0, 22.5, 45.0, 67.5]), 205, 0.4
    slowed = -sliding(engine, method, friction, np.radians(degrees), n) / (friction * FALL * n * DT)
    off = np.abs(slowed - slowed[0])
    worst, part = np.unravel_index(int(np.nan_to_num(off, nan=np.inf).argmax()), off.shape)
    if not off[worst, part] <= DIRECTIONS_WITHIN:
        how = "across the slip" if part else "against it"
        raise Broken(
            f"at {degrees[worst]:g} degrees to x friction is {slowed[worst, part]:.3g} mu N {how}, "
            f"and along x {slowed[0, part]:.3g}"
        )


# Where z is mirrored: position and velocity turn their z, rotations their x and y.
MIRROR = np.array([1, 1, -1, 1, -1, -1, 1, 1, 1, -1, -1, -1, 1.0])


def keeps_mirror_images(engine: ModuleType, method: str) -> None:
    """A throw and its mirror image stay mirror images, and what is its own image stays that."""
    corner, edge = THROWN[0], THROWN[1]
    corner = corner * np.where(np.arange(13) == 2, 0.0, 1.0)
    question = over_plane(np.array([corner, corner * MIRROR, edge * np.where(MIRROR < 0, 0.0, 1.0)]))
    tilted = replace(question, gravity=frozen_array(-FALL * UP))
    plane = replace(PLANE, point=frozen_array(-0.2 * UP))
    states = flown_in(engine, method, replace(tilted, plane=plane), (160, DT))
    size = np.linalg.norm(states[:, 7:13], axis=1).max()
    for one, other, what in ((0, 1, "a box that lands on a corner and its mirror image"), (2, 2, "a box on an edge")):
        image = states[other] * MIRROR
        off = float(np.abs(states[one] - image)[7:13].max())
        if not off <= MIRRORED_WITHIN * size:
            raise Broken(f"{what} differ by {off:.2g} m/s or rad/s from mirror images; speeds are up to {size:.2g}")
