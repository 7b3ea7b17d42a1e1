"""What a contestant's sensors read, compared with the true readings."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tumble.compare.run.sensing import FIELD, FORCE, SPIN, SensorReadings, of_kind
from tumble.compare.run.status import Failure, Status
from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Scene, Sensor
from tumble.scenarios.truth.sensors import SensorTruth

# What a sensor reads: name, unit, its columns among the nine of a reading, and its place in the truth's bounds.
QUANTITIES = (
    ("specific force", "m/s2", FORCE, 0),
    ("angular velocity", "rad/s", SPIN, 1),
    ("field direction", "1", FIELD, 3),
)


@dataclass(frozen=True, eq=False)
class SensorRun:
    """One contestant's readings of one scene's sensors, in the first throw.

    Parameters
    ----------
    scene : the scene
    engine : title of the engine
    method : name of the method
    dt : step that was asked for [s]
    answer : the readings, or why there are none
    truths : the true readings of each sensor
    tolerance : as of `tumble.compare.judge.errors.Run`
    """

    scene: Scene
    engine: str
    method: str
    dt: float
    answer: SensorReadings | Failure
    truths: tuple[SensorTruth, ...]
    tolerance: float | None = None

    @property
    def name(self) -> str:
        """ENGINE:METHOD."""
        return f"{self.engine}:{self.method}"

    @property
    def status(self) -> Status:
        """What became of the run."""
        if isinstance(self.answer, Failure):
            return self.answer.status
        if any("diverged" in why for each in self.answer.why for why in each):
            return Status.DIVERGED
        return Status.FLAGGED if self.answer.findings else Status.OK

    @property
    def reason(self) -> str:
        """The reason of a status that is not ok, else empty."""
        if isinstance(self.answer, Failure):
            return self.answer.reason
        return "; ".join(found.text for found in self.answer.findings)

    @cached_property
    def sensors(self) -> "tuple[SensorErrors, ...]":
        """The errors of each sensor; none where there are no readings."""
        if isinstance(self.answer, Failure):
            return ()
        parts = zip(self.scene.sensors, self.truths, self.answer.values, self.answer.why, strict=True)
        return tuple(SensorErrors(*part) for part in parts)


@dataclass(frozen=True, eq=False)
class SensorErrors:
    """One sensor's K readings in a run, (K, 9), the true ones, and why rows lack a reading, (K,)."""

    sensor: Sensor
    truth: SensorTruth
    values: Array
    why_not_read: tuple[str, ...]

    @cached_property
    def true(self) -> Array:
        """The true readings, (K, 9); nan where there is none, or the sensor does not read it."""
        truth = self.truth
        found = np.hstack((truth.specific_force[:, 0], truth.angular_velocity[:, 0], truth.field_direction[:, 0]))
        return np.where(of_kind(self.sensor), found, np.nan)

    @property
    def errors(self) -> Array:
        """Readings less the true ones, (K, 9)."""
        return self.values - self.true

    @cached_property
    def why(self) -> list[str]:
        """Why a row lacks a reading or its true value, (K,)."""
        read = of_kind(self.sensor)
        pairs = zip(self.why_not_read, self.truth.why, self.true[:, read], strict=True)
        return [here or (there if np.isnan(true).any() else "") for here, there, true in pairs]

    def distances(self, columns: slice) -> Array:
        """Return the lengths of the errors of one quantity, (K,); nan where a reading or its truth is missing."""
        with np.errstate(over="ignore", invalid="ignore"):
            return np.linalg.norm(self.errors[:, columns], axis=1)
