"""What sensors on a body read along a throw: specific force, angular velocity, angular acceleration and a direction.

The readings are written down as operations on the integrated state, beside the laws that move it, and run in numbers of
32 digits.  How far they can be trusted is asked as of the vertices: a rougher flight, and flights of changed inputs.
"""

from random import Random
from typing import NamedTuple

import numpy as np

from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Scene, Sensor
from tumble.scenarios.truth.compilation import kernel
from tumble.scenarios.truth.double_double import fractions_of, pairs
from tumble.scenarios.truth.flight import lever
from tumble.scenarios.truth.forced.flight import Budget, Integration
from tumble.scenarios.truth.forced.laws import AXES, MOMENTUM, SIZE, V, X, floor_gauges, motion_of, pull
from tumble.scenarios.truth.forced.passage import Accuracy
from tumble.scenarios.truth.forced.resolution import FINE, PLAIN, ROUGH, ROUNDING_PER_STEP, SAFETY
from tumble.scenarios.truth.forced.series import Program, Script, expand
from tumble.scenarios.truth.forced.switches import HEIGHT, THRUST
from tumble.scenarios.truth.inertia import inverse
from tumble.scenarios.truth.rational import cross
from tumble.scenarios.truth.resolution import PATTERNS, PROPORTIONAL, SMALL
from tumble.scenarios.truth.throw import ExactImpulse, Mount, Throw, changing, read_mount, read_throw

# What a sensor reads, three numbers each, in its own axes; the last is what impulses of that instant add to its point's
# velocity.
QUANTITIES = ("specific force", "angular velocity", "angular acceleration", "field direction", "velocity jump")
JUMP = len(QUANTITIES) - 1
# The changes of the inputs that a derivative is taken from, in half last bits; the last is the change itself.
CHANGES = ((PLAIN, 2.0**23), (PLAIN, 2.0**8), (ROUGH, 1.0))


class Readings(NamedTuple):
    """Of R instants, fewer where the flight ended: values, (R, sensors, quantities, 3), in SI units.

    bound: how far a vector may be from the exact one; input_error: how far it moves when each number of the file moves
    by half its last bit, (R, sensors, quantities); why: why there are fewer instants than were asked for.
    """

    values: Array
    bound: Array
    input_error: Array
    why: str


def readings(scene: Scene, row: int, sensors: tuple[Sensor, ...]) -> Readings:
    """Return what the sensors read at a scene's rows in one throw, after the impulses of the instant.

    Raises RayMissed.
    """
    throw = read_throw(scene, row)
    mounts = [read_mount(scene, sensor, throw) for sensor in sensors]
    flights = [Integration(throw, accuracy, Budget()) for accuracy in (FINE, ROUGH)]
    fine, rough = (flight.run() for flight in flights)
    known = min(len(fine.rows), len(rough.rows))
    exact = _read(throw, mounts, fine.rows[:known])
    moved, late = _input_error(scene, row, throw, sensors, known, exact)
    known = len(moved)
    apart = _distance(exact[:, :known], _read(throw, mounts, rough.rows[:known]))
    values = exact[0, :known]
    error = SAFETY * np.maximum.accumulate(apart)
    error += ROUNDING_PER_STEP * max(fine.steps, 1) * np.maximum.accumulate(moved)
    rounding = np.linalg.norm(np.spacing(np.abs(values)) / 2 * (values != 0), axis=-1)
    return Readings(values, error + rounding, moved, fine.why or rough.why or late)


def _input_error(
    scene: Scene, row: int, throw: Throw, sensors: tuple[Sensor, ...], known: int, exact: Array
) -> tuple[Array, str]:
    """Return the largest move over the sign patterns, (R, sensors, quantities), R <= known, and why R is less.

    It is a derivative, of flights in doubles for changes of many half last bits, where the opposite change does the
    same; elsewhere the flights are made with more digits for the changes themselves.
    """
    budget, (sensor_count, quantities) = Budget(), exact.shape[2:4]
    found = np.full((known, sensor_count, quantities), np.nan)
    size = np.linalg.norm(exact[0], axis=-1).max(axis=0)
    for accuracy, share in CHANGES:
        reach = int(np.flatnonzero(np.isnan(found).any(axis=(1, 2)))[-1]) + 1 if np.isnan(found).any() else 0
        if not reach:
            break

        def moved(pattern: int, signed: float, accuracy: Accuracy = accuracy, reach: int = reach) -> Array:
            read = changing(Random(pattern), signed)
            other = read_throw(scene, row, read) if signed else throw
            other = other._replace(times=other.times[:reach])
            mounts = [
                read_mount(scene, sensor, other, read) if signed else read_mount(scene, sensor, other)
                for sensor in sensors
            ]
            return _read(other, mounts, Integration(other, accuracy, budget).run().rows)

        plain = moved(0, 0.0)
        moves = [_distance(moved(pattern, share), plain) / share for pattern in range(PATTERNS)]
        count = min(map(len, moves))
        most = np.maximum.reduce([move[:count] for move in moves])
        if share > 1:
            back = _distance(moved(0, -share), plain)[:count] / share
            there = moves[0][: len(back)]
            count = len(back)
            even = abs(there - back) <= PROPORTIONAL * np.maximum(there, back)
            most = np.where(even & (share * there <= SMALL * size), most[:count], np.nan)
        found[:count] = np.where(np.isnan(found[:count]), most, found[:count])
    unknown = np.isnan(found).any(axis=(1, 2))
    if not unknown.any():
        return found, ""
    return found[: int(np.argmax(unknown))], f"{budget.said} were up for what the last bits of its numbers do"


def _distance(one: Array, other: Array) -> Array:
    """Return how far vectors of pairs are apart, (2, R, ..., 3), at the instants that both have, (R, ...)."""
    count = min(one.shape[1], other.shape[1])
    differ = (one[0, :count] - other[0, :count]) + (one[1, :count] - other[1, :count])
    return np.linalg.norm(differ, axis=-1)


def _read(throw: Throw, mounts: list[Mount], rows: Array) -> Array:
    """Return the readings of states, (R, 2, SIZE), as pairs, (2, R, sensors, quantities, 3)."""
    nothing = np.zeros(len(throw.points), dtype=bool)
    pressing = np.zeros((len(rows), len(throw.points)), dtype=bool)
    if throw.ground is not None:
        program, _, gauges = _program(throw, mounts, nothing)
        at = _outputs(program, rows, gauges.ravel())[0].reshape(len(rows), -1, 2)
        pressing = (at[..., HEIGHT] < 0) & (at[..., THRUST] > 0)
    values = np.empty((2, len(rows), len(mounts), len(QUANTITIES), 3))
    for pattern in np.unique(pressing, axis=0):
        program, wanted, _ = _program(throw, mounts, pattern)
        same = (pressing == pattern).all(axis=1)
        values[:, same, :, :JUMP] = _outputs(program, rows[same], wanted).reshape(2, -1, len(mounts), JUMP, 3)
    values[:, :, :, JUMP] = 0.0
    for row, time in enumerate(throw.times[: len(rows)]):
        if impulses := [impulse for impulse in throw.impulses if impulse.time == time]:
            values[:, row, :, JUMP] = _jumps(throw, mounts, impulses, rows[row])
    return values


def _jumps(throw: Throw, mounts: list[Mount], impulses: list[ExactImpulse], state: Array) -> Array:
    """Return what impulses add to the velocity of each sensor's point, (2, sensors, 3), given the state after them.

    They change neither place nor attitude: J/m + (I^-1 R^T (lever x J)) x r along the body's axes.
    """
    exact = fractions_of(state)
    axes, x = exact[AXES:MOMENTUM].reshape(3, 3), exact[X:V]
    total = sum((impulse.value for impulse in impulses), 0 * x)
    torque = sum((cross(lever(impulse, x, axes, throw), impulse.value) for impulse in impulses), 0 * x)
    push, turn = axes.T @ total / throw.solid.mass, inverse(throw.solid.tensor) @ (axes.T @ torque)
    return pairs([list(mount.axes.T @ (push + cross(turn, mount.point))) for mount in mounts])


def _program(throw: Throw, mounts: list[Mount], pressing: np.ndarray) -> tuple[Program, np.ndarray, np.ndarray]:
    """Return the operations, the series of the readings, (sensors quantities 3,), and of the floor's gauges, (n, 2)."""
    script = Script(SIZE)
    state, inverse_tensor = script.state(), inverse(throw.solid.tensor)
    motion = motion_of(state, inverse_tensor)
    gauges = floor_gauges(throw, motion)
    force, torque = pull(throw, motion, gauges, pressing)
    felt = motion.axes.T @ force / throw.solid.mass
    turn = inverse_tensor @ (cross(motion.L, motion.w) + torque)
    values: list = []
    for mount in mounts:
        r = mount.point
        specific_force = felt + cross(turn, r) + cross(motion.w, cross(motion.w, r))
        for vector in (specific_force, motion.w, turn, motion.axes.T @ mount.field):
            values += list(mount.axes.T @ vector)
    wanted = np.array([script.row(value) for value in values], dtype=np.int64)
    watched = np.array([[script.row(value) for value in gauge] for gauge in gauges], dtype=np.int64).reshape(-1, 2)
    # Nothing is integrated here: the state's own series stand for its rates.
    return script.program(list(state)), wanted, watched


@kernel
def _outputs(program: Program, rows: Array, wanted: np.ndarray) -> Array:
    """Return the values of some series, (2, R, wanted), at states, (R, 2, SIZE)."""
    values = np.empty((2, len(rows), len(wanted)))
    high, low = np.zeros((program.series, 1)), np.zeros((program.series, 1))
    for row in range(len(rows)):
        for number in range(SIZE):
            high[number, 0], low[number, 0] = rows[row, 0, number], rows[row, 1, number]
        expand(program, 1.0, high, low)
        for place in range(len(wanted)):
            values[0, row, place], values[1, row, place] = high[wanted[place], 0], low[wanted[place], 0]
    return values
