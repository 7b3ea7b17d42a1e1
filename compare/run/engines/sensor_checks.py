"""The check of an engine's sensors: what they read is what a rigid body feels in the state that the engine has.

Free fall reads nothing at the centre of mass, a spin w^2 r towards its axis, lever arms add; and a body that a force
holds against gravity reads +g upwards.  A failure names the mistake that gives the reading.
"""

from collections.abc import Iterator
from dataclasses import replace
from types import ModuleType

import numpy as np

from tumble.compare.run.engines.brick import GRAVITY, MASS, MOMENTS, THROWS, Broken, rounding, scene, step
from tumble.compare.run.engines.free_body import to_body
from tumble.compare.run.engines.registry import DIFFERENCES, how_sensed
from tumble.scenarios.frames import Array, rotation_matrix
from tumble.scenarios.scene import Drag, Scene, Sensor, Tether, frozen_array

# A step so short that the mean over it, which some integrators take for the acceleration, is the value at its end [s].
SHORT = 1e-6
LONG = 0.01  # s, in which every throw moves by far more than a rounding
# A mistake explains a reading if it leaves this much of its error.
EXPLAINED = 0.05
OBLIQUE = np.array([0.5, -0.7, 0.1, 0.5])
POINTS = {"centre": (0.0, 0.0, 0.0), "x": (0.2, 0.0, 0.0), "corner": (0.2, 0.075, -0.05)}
SENSORS = (
    *(Sensor(name, "imu", 10.0, frozen_array(point), frozen_array((1, 0, 0, 0))) for name, point in POINTS.items()),
    Sensor("oblique", "imu", 10.0, frozen_array((-0.1, 0.3, 0.2)), frozen_array(OBLIQUE / np.linalg.norm(OBLIQUE))),
)


def reads_what_a_body_feels(engine: ModuleType, method: str) -> None:
    """Specific force and angular velocity of every sensor are those of the state."""
    if how_sensed(engine, method) == DIFFERENCES:
        raise NotImplementedError("it has no sensors: their readings are differences of its velocities")
    field = GRAVITY if "gravity" in engine.FEATURES else None
    free = replace(scene(gravity=field), sensors=SENSORS)
    world = engine.build(free, method)
    nothing = np.zeros((len(THROWS), 3))
    engine.write(world, THROWS)
    step(engine, world, (1, SHORT))
    demand_readings(engine, world, nothing, "of a free body")
    engine.write(world, THROWS[::-1].copy())
    demand_readings(engine, world, nothing, "of a free body in a state that was just written")
    demand_same_motion(engine, free, method)
    if field is not None:
        for held, states, how in upheld(engine, free):
            try:
                world = engine.build(held, method)
            except NotImplementedError:
                continue
            engine.write(world, states)
            step(engine, world, (1, SHORT))
            lift = np.broadcast_to(-np.array(GRAVITY), (len(states), 3))
            demand_readings(engine, world, lift, f"of a body that {how} holds against gravity")


def demand_same_motion(engine: ModuleType, free: Scene, method: str) -> None:
    """Raise Broken where a run whose sensors are read does not have the same motion."""
    ends = []
    for looks in (False, True):
        world = engine.build(free, method)
        engine.write(world, THROWS)
        for _ in range(2):
            step(engine, world, (1, LONG))
            if looks:
                engine.sense(world)
        ends.append(np.array(engine.read(world)))
    if not np.array_equal(*ends, equal_nan=True):
        raise Broken(f"sense() alters the motion: by {np.abs(ends[1] - ends[0]).max():.2g} after two steps")


def upheld(engine: ModuleType, free: Scene) -> Iterator[tuple[Scene, Array, str]]:
    """Yield scenes in which a force of the engine's is -m g, the states in which it is, and its name."""
    states = THROWS.copy()
    if "drag" in engine.FEATURES:
        falling = states.copy()
        falling[:, 7:10] = np.array(GRAVITY) * MASS / 3.0
        yield replace(free, drag=Drag(3.0, 0.0)), falling, "drag"
    if "tether" in engine.FEATURES:
        hanging = states.copy()
        hanging[:, 0:3] = np.array(GRAVITY) * MASS / 50.0
        anchor, centre = frozen_array((0.0, 0.0, 0.0)), frozen_array((0.0, 0.0, 0.0))
        yield replace(free, tethers=(Tether(centre, anchor, 50.0, 0.0, 0.0),)), hanging, "a tether"


def demand_readings(engine: ModuleType, world: object, lift: Array, what: str) -> None:
    """Raise Broken where the sensors do not read what a body feels; lift: force over mass, world axes, (N, 3)."""
    states, read = np.array(engine.read(world)), np.array(engine.sense(world), dtype=float)
    if read.shape != (len(states), len(SENSORS), 6):
        raise Broken(f"sense() returned shape {read.shape}, not {(len(states), len(SENSORS), 6)}")
    eps, expected = rounding(engine), felt(states, lift)
    spin = float(np.abs(states[:, 10:13]).max())
    scale = float(np.abs(expected[..., :3]).max() + np.abs(GRAVITY).max())
    for part, unit, size in ((slice(0, 3), "m/s2", scale), (slice(3, 6), "rad/s", spin)):
        off = np.linalg.norm(read[..., part] - expected[..., part], axis=-1)
        # As many roundings as turning vectors twice and solving for three accelerations costs; and what a step changes.
        if not (off <= (400 * eps + 10 * SHORT * spin) * size).all():
            throw, number = np.unravel_index(int(np.argmax(np.where(np.isnan(off), np.inf, off))), off.shape)
            raise Broken(
                f"the sensor {SENSORS[number].name!r} {what} reads {np.round(read[throw, number, part], 6).tolist()} "
                f"{unit}, not {np.round(expected[throw, number, part], 6).tolist()}{mistaken(read, states, lift, part)}"
            )


def felt(
    states: Array, lift: Array, euler: float = 1.0, centripetal: float = 1.0, gravity: float = 0.0, sign: float = 1.0
) -> Array:
    """Return F/m + alpha x r + w x (w x r), and w, of every sensor, (N, S, 6), along its axes; the factors are 1,

    and that of gravity 0, in physics.
    """
    w = to_body(states[:, 3:7], states[:, 10:13])
    alpha = np.cross(MOMENTS * w, w) / MOMENTS
    force = to_body(states[:, 3:7], sign * lift + gravity * np.array(GRAVITY))
    found = np.empty((len(states), len(SENSORS), 6))
    for number, sensor in enumerate(SENSORS):
        r, mounted = sensor.point_body, rotation_matrix(sensor.orientation)
        arm = euler * np.cross(alpha, r) + centripetal * np.cross(w, np.cross(w, r))
        found[:, number, :3], found[:, number, 3:] = (force + arm) @ mounted, w @ mounted
    return found


MISTAKES = {
    "gravity is added to it: free fall reads nothing": {"gravity": 1.0},
    "gravity is subtracted from it: free fall reads nothing": {"gravity": -1.0},
    "its force has the wrong sign: a body that is held reads +g upwards": {"sign": -1.0},
    "w x (w x r) is missing": {"centripetal": 0.0},
    "w x (w x r) has the wrong sign": {"centripetal": -1.0},
    "alpha x r is missing": {"euler": 0.0},
    "it is the reading of the centre of mass": {"euler": 0.0, "centripetal": 0.0},
}


def mistaken(read: Array, states: Array, lift: Array, part: slice) -> str:
    """Return the mistake that gives the readings, '' where none of them does."""
    off = np.abs(read - felt(states, lift))[..., part].max()
    for words, factors in MISTAKES.items():
        if np.abs(read - felt(states, lift, **factors))[..., part].max() < EXPLAINED * off:
            return f": {words}"
    if np.abs(to_body_axes(read[..., part], states) - felt(states, lift)[..., part]).max() < EXPLAINED * off:
        return ": it is in world axes, and must be in the sensor's"
    return ""


def to_body_axes(read: Array, states: Array) -> Array:
    """Return vectors of world axes, (N, S, 3), along the axes of the sensors."""
    found = np.empty_like(read)
    for number, sensor in enumerate(SENSORS):
        found[:, number] = to_body(states[:, 3:7], read[:, number]) @ rotation_matrix(sensor.orientation)
    return found
