"""What a scene's sensors read in one engine: a run of its own, beside the one whose vertices and time are measured.

An engine with `sense` has sensors, or equations that give what they would read.  Of any other the specific force is
what scripts make of its velocities: that of the sensor's point less the one a step before, over the step.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from types import ModuleType
from typing import NamedTuple

import numpy as np

from tumble.compare.run.engines.registry import DIFFERENCES, Finding, built, findings, how_sensed
from tumble.compare.run.flight import Leg, legs, real, with_impulses
from tumble.compare.run.timing.timer import prepare
from tumble.scenarios.frames import Array, rotation_matrix
from tumble.scenarios.scene import Scene, Sensor

FORCE, SPIN, FIELD = slice(0, 3), slice(3, 6), slice(6, 9)
IMPULSE = "an impulse acts at this instant: the specific force is not defined"
NO_STEP = "no step before the first reading"
NO_INTERVAL = "no interval before the first reading"
LOST = "the run diverged"


@dataclass(frozen=True, eq=False)
class SensorReadings:
    """What the sensors of a scene read in one engine, in its first throw.

    Parameters
    ----------
    values : of each sensor, (K, 9): specific force [m/s2], angular velocity [rad/s], field direction; nan where it has
        no such reading
    why : of each sensor and instant, why it lacks a reading that its kind has; empty if it has all
    how : how specific force is made: sensor, derivatives or differences
    findings : findings of the engine's own audit
    """

    values: tuple[Array, ...]
    why: tuple[tuple[str, ...], ...]
    how: str
    findings: tuple[Finding, ...]


class Look(NamedTuple):
    """A state, (13,), and what every sensor reads there, (S, 9)."""

    state: Array
    values: Array


def sensed(engine: ModuleType, scene: Scene, method: str, dt: float) -> SensorReadings:
    """Run the scene's first throw in one engine with steps of dt [s] at most, and read its sensors.

    Raises whatever the engine raises, and ValueError where read or sense answers what the contract has not.
    """
    scene = replace(scene, start=scene.start[:1])
    run = SensorRun(engine, scene, method)
    for leg in legs(replace(scene, times=instants(scene)), dt):
        if not run.advance(leg):
            break
    columns = [run.column(number) for number in range(len(scene.sensors))]
    return SensorReadings(
        tuple(values for values, _ in columns),
        tuple(why for _, why in columns),
        run.how,
        tuple(dict.fromkeys(run.found)),
    )


def instants(scene: Scene) -> Array:
    """Return every instant at which a sensor of the scene reads [s], (K,), increasing."""
    return np.unique(np.concatenate([scene.sensor_times(sensor) for sensor in scene.sensors]))


class SensorRun:
    """One run, and what its sensors have read so far."""

    def __init__(self, engine: ModuleType, scene: Scene, method: str) -> None:
        self._engine, self._scene = engine, scene
        self._mounted = [rotation_matrix(sensor.orientation) for sensor in scene.sensors]
        self._world = built(engine, scene, method, frozenset())
        self.how = how_sensed(engine, method)
        self.found: list[Finding] = []
        self._averages = any(sensor.average for sensor in scene.sensors)
        self._sums, self._since = np.zeros((len(scene.sensors), 9)), np.zeros(len(scene.sensors))
        self._stops = [{*scene.sensor_times(sensor).tolist()} for sensor in scene.sensors]
        self._write(0.0, scene.start.copy())
        self._rows = {0.0: self._now.values}
        self._means: dict[tuple[int, float], Array] = {}

    def advance(self, leg: Leg) -> bool:
        """Run to the end of a leg and read there; return whether the state is finite still."""
        prepare(self._engine, self._world, leg.dt)
        for n in self._parts(leg.n):
            self._engine.advance(self._world, n, leg.dt)
            self._add(self._look(self._now.state, n * leg.dt), leg.dt)
        if not np.isfinite(self._now.state).all():
            return False
        if any(impulse.time == leg.end for impulse in self._scene.impulses):
            before = self._now.state
            self._audit()
            self._write(leg.end, before[np.newaxis])
            self._sums[:, FORCE] += self._velocities(self._now.state) - self._velocities(before)
        self._rows[leg.end] = self._now.values
        self._close(leg.end)
        return True

    def column(self, number: int) -> tuple[Array, tuple[str, ...]]:
        """Return the readings of one sensor, (K, 9), and why some are missing."""
        sensor, times = self._scene.sensors[number], self._scene.sensor_times(self._scene.sensors[number])
        self._audit()
        nothing = np.full((len(self._scene.sensors), 9), np.nan)
        if sensor.average:
            values = np.array([self._means.get((number, time), nothing[0]) for time in times.tolist()])
        else:
            values = np.array([self._rows.get(time, nothing)[number] for time in times.tolist()])
            values[np.isin(times, [impulse.time for impulse in self._scene.impulses]), FORCE] = np.nan
        read = of_kind(sensor)
        values[:, ~read] = np.nan
        missing = (not np.isfinite(row).all() for row in values[:, read])
        return values, tuple(self._why(sensor, time, gone) for time, gone in zip(times.tolist(), missing, strict=True))

    def _why(self, sensor: Sensor, time: float, missing: bool) -> str:
        if not missing:
            return ""
        if time not in self._rows:
            return LOST
        if sensor.average:
            return NO_INTERVAL if time == 0.0 else LOST
        if any(impulse.time == time for impulse in self._scene.impulses):
            return IMPULSE
        return NO_STEP if time == 0.0 else LOST

    def _parts(self, n: int) -> Iterator[int]:
        """Yield the numbers of steps between two looks: a mean is of every step, a difference over the last one."""
        if self._averages:
            yield from [1] * n
        elif self.how == DIFFERENCES and n > 1:
            yield from (n - 1, 1)
        else:
            yield n

    def _write(self, time: float, states: Array) -> None:
        self._engine.write(self._world, with_impulses(self._scene, time, states, self.found))
        self._now = self._look(None, 0.0)

    def _audit(self) -> None:
        self.found += findings(getattr(self._engine, "audit", lambda world: [])(self._world))

    def _look(self, before: Array | None, h: float) -> Look:
        """Return the state and all readings; before: the state h [s] earlier, where there was one."""
        state = real(self._engine.read(self._world))[0]
        count = len(self._scene.sensors)
        values = np.full((count, 9), np.nan)
        with np.errstate(all="ignore"):  # of a run that diverged
            R = rotation_matrix(state[3:7])
            for number, (sensor, mounted) in enumerate(zip(self._scene.sensors, self._mounted, strict=True)):
                if sensor.field is not None:
                    values[number, FIELD] = mounted.T @ (R.T @ sensor.field)
                if self.how == DIFFERENCES:
                    values[number, SPIN] = mounted.T @ (R.T @ state[10:13])
            if self.how == DIFFERENCES and before is not None:
                values[:, FORCE] = self._differences(before, state, h)
        if self.how != DIFFERENCES:
            read = real(self._engine.sense(self._world))
            if read.shape != (1, count, 6):
                raise ValueError(f"sense() returned shape {read.shape}, not {(1, count, 6)}")
            values[:, :6] = read[0]
        return Look(state, values)

    def _differences(self, before: Array, state: Array, h: float) -> Array:
        """Return (v_p(t) - v_p(t - h)) / h - g of the sensors' points, (S, 3), in the axes that they have at t."""
        R, gravity = rotation_matrix(state[3:7]), self._scene.gravity
        found = np.empty((len(self._scene.sensors), 3))
        for number, (sensor, mounted) in enumerate(zip(self._scene.sensors, self._mounted, strict=True)):
            a = (point_velocity(state, sensor) - point_velocity(before, sensor)) / h
            found[number] = mounted.T @ (R.T @ (a if gravity is None else a - gravity))
        return found

    def _velocities(self, state: Array) -> Array:
        """Return the velocities of the sensors' points in the axes that they have, (S, 3)."""
        R = rotation_matrix(state[3:7])
        pairs = zip(self._scene.sensors, self._mounted, strict=True)
        return np.array([mounted.T @ (R.T @ point_velocity(state, sensor)) for sensor, mounted in pairs])

    def _add(self, now: Look, h: float) -> None:
        """Take the reading at the end of a step of h [s]; a mean is that of the readings at its ends."""
        if self._averages:
            mean = (self._now.values + now.values) / 2
            if self.how == DIFFERENCES:  # which is the mean over the step already
                mean[:, FORCE] = now.values[:, FORCE]
            self._sums += h * mean
        self._now = now

    def _close(self, time: float) -> None:
        """End the interval of every sensor that reads at this instant."""
        for number, sensor in enumerate(self._scene.sensors):
            if sensor.average and time in self._stops[number]:
                self._means[number, time] = self._sums[number] / (time - self._since[number])
                self._sums[number], self._since[number] = 0.0, time


def point_velocity(state: Array, sensor: Sensor) -> Array:
    """Return v + w x R r of a sensor's point [m/s], (3,), world axes."""
    return state[7:10] + np.cross(state[10:13], rotation_matrix(state[3:7]) @ sensor.point_body)


def of_kind(sensor: Sensor) -> np.ndarray:
    """Return which of the nine numbers a sensor reads, (9,)."""
    return np.repeat([sensor.reads_force, sensor.reads_spin, sensor.field is not None], 3)
