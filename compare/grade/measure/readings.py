"""The readings of a sensor in a file, and their errors against those of the reference motion."""

from dataclasses import dataclass, replace

import numpy as np

from tumble.compare.grade.measure.significance import KERNEL_ERROR
from tumble.compare.grade.model.kinematics import Motion
from tumble.compare.grade.model.sensor_model import ACCELEROMETER, SensorModel
from tumble.compare.grade.read.trajectory import Trajectory
from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Scene

# Rows nearer than this to an impulse, in row intervals, are left out: there the specific force is not defined.
NEAR_IMPULSE = {"accelerometer": 1.5, "gyro": 0.5}
# Of neighbouring rows the intervals differ by less than this share.
EVEN = 0.01
# Rows that a diagnosis uses at most, in this many runs of neighbours.
MOST_ROWS, RUNS = 2400, 8
# Relative error of a number of single precision, after a dozen operations.
SINGLE = 12 * 2.0**-24


@dataclass(frozen=True, eq=False)
class Readings:
    """The readings of one device in some rows.

    times [s], (N,); values: in the file [m/s2 or rad/s], (N, 3); half: half a unit in their last digits, (N, 3); run:
    number of the run of neighbouring rows that a row belongs to, (N,); spacing_s: interval of most rows [s].
    """

    device: str
    times: Array
    values: Array
    half: Array
    run: np.ndarray
    spacing_s: float

    def __len__(self) -> int:
        return len(self.times)

    def some(self, rows: np.ndarray) -> "Readings":
        """Return some of the rows."""
        return Readings(
            self.device, self.times[rows], self.values[rows], self.half[rows], self.run[rows], self.spacing_s
        )

    def sampled(self, most: int, runs: int = RUNS) -> "Readings":
        """Return at most this many rows, in runs of neighbours that are spread evenly."""
        if len(self) <= most:
            return self
        length = most // runs
        first = np.linspace(0, len(self) - length, runs).round().astype(int)
        chosen = self.some((first[:, None] + np.arange(length)).ravel())
        breaks = np.repeat(np.arange(runs), length)
        both = np.stack((chosen.run, breaks))
        changes = (np.diff(both, axis=1) != 0).any(axis=0)
        return Readings(
            self.device, chosen.times, chosen.values, chosen.half, np.append(0, np.cumsum(changes)), self.spacing_s
        )


@dataclass(frozen=True, eq=False)
class MeasuredReadings:
    """The errors of one device's readings.

    Errors are lengths of vectors of three axes, in m/s2 or rad/s.

    Parameters
    ----------
    readings : of the throw with the largest error, without rows at impulses
    true : true readings, (N, 3)
    rows : number of rows in the file
    left_out : number of rows at impulses
    worst : largest error
    worst_t_s : time of the largest error [s]
    rms : root mean square error
    size : root mean square of the true readings, at least gravity for an accelerometer
    half : largest error that the printed digits allow
    throw : number of the throw
    excess : largest error of one axis beyond the digits and the resolution
    resolution : of the reference
    floor : below it, the root mean square residual of one axis is indistinguishable from zero
    single : whether every number is of single precision
    """

    readings: Readings
    true: Array
    rows: int
    left_out: int
    worst: float
    worst_t_s: float
    rms: float
    size: float
    half: float
    throw: int
    excess: float = 0.0
    resolution: float = 0.0
    floor: float = 0.0
    single: bool = False

    @property
    def device(self) -> str:
        """accelerometer or gyro."""
        return self.readings.device

    @property
    def unit(self) -> str:
        """The unit of the errors."""
        return "m/s2" if self.device == ACCELEROMETER else "rad/s"


def read_readings(trajectory: Trajectory) -> dict[int, dict[str, Readings]]:
    """Return the readings of each device of each throw.  Raises BadTrajectory."""
    devices = trajectory.devices
    parts: dict[int, list[tuple[Array, dict[str, tuple[Array, Array]]]]] = {}
    for block in trajectory.blocks():
        for throw in np.unique(block.throws).tolist():
            rows = block.throw(throw)
            found = {
                device: (
                    rows.of(names),
                    np.stack([trajectory.half_digits(name, rows.values[name]) for name in names], axis=1),
                )
                for device, names in devices.items()
            }
            parts.setdefault(throw, []).append((rows.times, found))
    readings: dict[int, dict[str, Readings]] = {}
    for throw, pieces in parts.items():
        times = np.concatenate([piece[0] for piece in pieces])
        spacing_s = float(np.median(np.diff(times))) if len(times) > 1 else 0.0
        gaps = np.abs(np.diff(times) - spacing_s) > EVEN * spacing_s
        readings[throw] = {
            device: Readings(
                device,
                times,
                np.concatenate([piece[1][device][0] for piece in pieces]),
                np.concatenate([piece[1][device][1] for piece in pieces]),
                np.append(0, np.cumsum(gaps)),
                spacing_s,
            )
            for device in devices
        }
    return readings


def measure_readings(
    readings: Readings, model: SensorModel, motion: Motion, scene: Scene, throw: int
) -> MeasuredReadings:
    """Return the errors of one device's readings, as if the reference were exact."""
    kept = _away_from_impulses(readings, scene)
    true = model_readings(model, motion, kept.times)
    distances = np.linalg.norm(kept.values - true, axis=1)
    least = float(np.linalg.norm(motion.gravity)) if kept.device == ACCELEROMETER else 0.0
    worst = int(np.argmax(distances))
    measured = MeasuredReadings(
        readings=kept,
        true=true,
        rows=len(readings),
        left_out=len(readings) - len(kept),
        worst=float(distances[worst]),
        worst_t_s=float(kept.times[worst]),
        rms=float(np.sqrt((distances**2).mean())),
        size=max(float(np.sqrt((true**2).sum(axis=1).mean())), least),
        half=float(np.linalg.norm(kept.half, axis=1).max()),
        throw=throw,
    )
    return certified(measured, 0.0, False)


def certified(measured: MeasuredReadings, truth_error: float, single: bool) -> MeasuredReadings:
    """Return the errors with what follows from the error of the reference, and from single precision."""
    resolution = truth_error + KERNEL_ERROR * measured.size
    room = resolution + (SINGLE * measured.size if single else 0.0)
    half, errors = measured.readings.half, measured.readings.values - measured.true
    in_file = float(np.sqrt((measured.readings.values**2).mean()))
    return replace(
        measured,
        excess=float((np.abs(errors) - half).max()) - room,
        resolution=resolution,
        floor=float(np.sqrt(((half**2).mean() + max(room, KERNEL_ERROR * in_file) ** 2) / 3)),
        single=single,
    )


def model_readings(model: SensorModel, motion: Motion, times: Array) -> Array:
    """Return the readings of a model without a filter and without free values, (N, 3)."""
    return model.columns_at(motion, times)[0]


def _away_from_impulses(readings: Readings, scene: Scene) -> Readings:
    """Return the rows that are not at an impulse; the rows before and after one are in different runs."""
    keep, run = np.ones(len(readings), dtype=bool), readings.run.copy()
    for impulse in scene.impulses:
        away = readings.times - impulse.time
        keep &= np.abs(away) >= NEAR_IMPULSE[readings.device] * readings.spacing_s
        run[away >= 0] += 1
    return Readings(readings.device, readings.times, readings.values, readings.half, run, readings.spacing_s).some(keep)
