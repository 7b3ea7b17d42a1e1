"""The brick that laws of engines are asked of: a triaxial box, thrown three times, and what one engine makes of it.

Once near its middle axis, once near its third, once near none: a cube cannot show a wrong gyroscopic term.  A rounding
is one of the engine's precision.
"""

from dataclasses import replace
from types import ModuleType

import numpy as np

from tumble.compare.run.contestant import MethodName
from tumble.compare.run.timing.timer import PARTS, prepare
from tumble.scenarios.frames import Array
from tumble.scenarios.mass import BOX_FACES, box_corners
from tumble.scenarios.published import table_4_1
from tumble.scenarios.scene import Body, Plane, Scene, frozen_array

SIZE = (0.4, 0.15, 0.1)
MASS = 2.4
MOMENTS = MASS / 12 * np.array([0.15**2 + 0.1**2, 0.4**2 + 0.1**2, 0.4**2 + 0.15**2])
GRAVITY = (0.3, -9.81, 0.1)

# Position, attitude (of unit length below), velocity, angular velocity.
THROWS = np.array(
    [
        [0.3, -1.2, 0.7, 0.8, 0.2, -0.4, 0.4, 0.5, 3.0, -1.0, 0.2, 3.1, 0.4],
        [-7.0, 0.0, 0.1, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0, 0.1, 0.2, -2.0],
        [0.0, 40.0, 2.0, -0.1, 0.7, 0.7, -0.1, -3.0, 1.0, 0.3, 1.5, 1.2, 1.0],
    ]
)
THROWS[:, 3:7] /= np.linalg.norm(THROWS[:, 3:7], axis=1, keepdims=True)


# The same over a plane: one slides on it, one comes down on an edge, one on a corner, within 50 steps of 0.01 s.
PLANE = Plane(frozen_array((0.1, -0.2, 0.3)), frozen_array((0.0, 1.0, 0.0)), 0.5, 0.3)
LANDING = np.array(
    [
        [0.0, -0.15, 0.0, 1.0, 0.0, 0.0, 0.0, 0.6, 0.0, 0.3, 0.0, 0.0, 0.0],
        [2.0, 0.1, 0.0, 0.95, 0.0, 0.0, 0.3, 0.2, 0.0, 0.0, 0.0, 0.0, 0.0],
        [-2.0, 0.2, 1.0, 0.8, 0.3, -0.2, 0.4, 0.0, -0.5, 0.1, 1.0, 2.0, -1.0],
    ]
)
LANDING[:, 3:7] /= np.linalg.norm(LANDING[:, 3:7], axis=1, keepdims=True)


class Broken(Exception):
    """A law that does not hold; the message says how."""


def scene(
    start: Array = THROWS,
    gravity: tuple[float, float, float] | None = None,
    mass: float = MASS,
    moments: Array | tuple[float, float, float] = tuple(MOMENTS),
) -> Scene:
    """Return a scene with no impulse; its times are those of Table 4.1, for the hand calculation flies no others."""
    times = frozen_array(table_4_1().physics_times)
    body = Body("box", mass, frozen_array(moments), frozen_array(box_corners(np.array(SIZE))), BOX_FACES)
    field = None if gravity is None else frozen_array(gravity)
    return Scene("triaxial", "Triaxial box", "", times[-1], times, 0.001, body, frozen_array(start), field)


def over_plane(start: Array) -> Scene:
    """Return a scene in which the box comes down on a plane or lies on it."""
    falling = scene(start, GRAVITY)
    return replace(falling, plane=PLANE, body=replace(falling.body, size=frozen_array(SIZE)))


def step(engine: ModuleType, world: object, *steps: tuple[int, float]) -> None:
    """Make the steps (n, dt)."""
    for n, dt in steps:
        prepare(engine, world, dt)
        engine.advance(world, n, dt)


def flown(
    engine: ModuleType, method: str, states: Array, *steps: tuple[int, float], gravity=None, weight: float = 1.0
) -> Array:
    """Return the states after the steps (n, dt), in a world of its own; weight: that many times the mass."""
    return flown_in(engine, method, scene(states, gravity, weight * MASS, weight * MOMENTS), *steps)


def flown_in(engine: ModuleType, method: str, question: Scene, *steps: tuple[int, float]) -> Array:
    """Return the states that a scene's starts have after the steps (n, dt), in a world of its own."""
    world, states = engine.build(question, method), question.start.copy()
    engine.write(world, states)
    step(engine, world, *steps)
    return np.array(engine.read(world))


def rounding(engine: ModuleType) -> float:
    """Return the spacing of the engine's numbers at one."""
    return float(np.finfo(np.float32 if engine.ABOUT.get("precision") == "single" else np.float64).eps)


def by_other_roundings(engine: ModuleType, method: str) -> float:
    """Return how far a flight of 50 steps may be off where a term that is nothing rounds another way."""
    asked = MethodName.parse(method)
    # Steps of the method's own choice may differ.
    adaptive = str(asked.without_tolerance) in getattr(engine, "ADAPTIVE", ())
    return 100 * float(asked.tolerance or 1e-9) if adaptive else 450 * rounding(engine)


def with_signs_of(reference: Array, states: Array) -> Array:
    """Return the states with q or -q, which are one attitude, whichever is nearer to the reference's."""
    alike = states.copy()
    alike[:, 3:7] *= np.where(np.sum(states[:, 3:7] * reference[:, 3:7], axis=1, keepdims=True) < 0, -1.0, 1.0)
    return alike


def demand(states: Array, expected: Array, within: Array | float, what: str) -> None:
    """Raise Broken where states are not those expected, to `within`; 0 is bit by bit."""
    if states.shape != expected.shape:
        raise Broken(f"{what}: shape {states.shape}, not {expected.shape}")
    off = np.abs(states - expected)
    wrong = ~((off <= within) | (np.isnan(states) & np.isnan(expected)))
    if wrong.any():
        throw, column = np.unravel_index(int(np.argmax(np.where(np.isnan(off), np.inf, off * wrong))), off.shape)
        part = PARTS[column] if off.shape[1] == len(PARTS) else f"component {column}"
        raise Broken(
            f"{what}: {part} of throw {throw} is {states[throw, column]:.17g}, not {expected[throw, column]:.17g}"
        )
