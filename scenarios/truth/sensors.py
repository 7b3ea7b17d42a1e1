"""The true readings of a scene's sensors.

A sensor fixed at a point r of the body feels the specific force R^T (a - g) + alpha x r + w x (w x r) and turns with w,
both told in its own axes.  Source: IEEE Std 528 (specific force); Goldstein, "Classical Mechanics" (1980), eq. 4-107.
The motion is integrated by the truth's Taylor series (`forced`), in free flight as under forces.
"""

from dataclasses import dataclass, replace

import numpy as np

from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Scene, Sensor
from tumble.scenarios.truth.deadline import PARTS, Late, within
from tumble.scenarios.truth.resolution import TRUSTED

IMPULSE = "an impulse acts at this instant: the specific force is not defined"
PLANE = "rigid contact: the truth has no contact force"
BLURRED = "the last bits of the scene's numbers move the reading by more than a millionth"


@dataclass(frozen=True, eq=False)
class SensorTruth:
    """What a sensor reads at K instants of N throws, in its own axes; rows that could not be computed are nan.

    Parameters
    ----------
    sensor
    times : (K,), s
    specific_force : (K, N, 3), m/s2
    angular_velocity : (K, N, 3), rad/s
    angular_acceleration : (K, N, 3), rad/s2
    field_direction : (K, N, 3)
        unit vector; 0 for a sensor without a field
    bound : (K, N, 4)
        upper bound on the distance of each of these four vectors from the exact one, in its unit
    input_error : (K, N, 4)
        how far each moves when each number of the scene changes by half its last bit
    why : (K,)
        why the row has no specific force; empty if it has
    """

    sensor: Sensor
    times: Array
    specific_force: Array
    angular_velocity: Array
    angular_acceleration: Array
    field_direction: Array
    bound: Array
    input_error: Array
    why: tuple[str, ...]

    @property
    def resolution(self) -> Array:
        """The least error that can be told from none, (K, N, 4)."""
        return np.maximum(self.bound, self.input_error)


def sensor_truth(
    scene: Scene, sensor: Sensor, times: Array | None = None, limit_s: float = float("inf")
) -> SensorTruth:
    """Return the true readings of one sensor, of the scene or a changed one.

    Parameters
    ----------
    scene
    sensor
        need not be among the scene's own
    times : (K,), s
        increasing; the sensor's own if left out
    limit_s : s
        wall time for each part of the computation

    Returns
    -------
    readings

    Raises
    ------
    RayMissed
        An impulse's ray does not hit the body.
    """
    return _together(scene, (sensor,), scene.sensor_times(sensor) if times is None else times, limit_s)[0]


def sensor_truths(scene: Scene, limit_s: float = float("inf")) -> tuple[SensorTruth, ...]:
    """Return the true readings of every sensor of a scene.

    Parameters
    ----------
    scene
    limit_s : s
        wall time for each part of the computation, of each rate

    Returns
    -------
    readings
        in the order of the scene's sensors

    Raises
    ------
    RayMissed
        An impulse's ray does not hit the body.
    """
    found: dict[str, SensorTruth] = {}
    for rate in dict.fromkeys(sensor.rate for sensor in scene.sensors):
        alike = tuple(sensor for sensor in scene.sensors if sensor.rate == rate)
        for one in _together(scene, alike, scene.sensor_times(alike[0]), limit_s):
            found[one.sensor.name] = one
    return tuple(found[sensor.name] for sensor in scene.sensors)


def _together(scene: Scene, sensors: tuple[Sensor, ...], times: Array, limit_s: float) -> list[SensorTruth]:
    """Return the readings of sensors that read at the same instants."""
    shape = (len(times), len(scene.start), len(sensors), 4)
    values, bound, moved = np.full((*shape, 3), np.nan), np.full(shape, np.inf), np.full(shape, np.inf)
    why = np.full(len(times), PLANE if scene.plane else "", dtype=object)
    if scene.plane is None:
        at = replace(scene, times=times, sensors=())
        skipped = len(at.rows) - len(times)  # the start, where it is not asked for
        for row in range(len(scene.start)):
            ended = _one_throw(at, row, sensors, limit_s, skipped, values, bound, moved)
            why[np.isnan(values[:, row, 0, 0, 0]) & (why == "")] = ended
        _leave_out_blurred(values, np.maximum(bound, moved), why)
    struck = np.isin(times, [impulse.time for impulse in scene.impulses])
    # Only the specific force has no value there; the rest is that after the impulse.
    values[struck, :, :, 0] = values[struck, :, :, 2] = np.nan
    why[struck & (why == "")] = IMPULSE
    return [
        SensorTruth(
            sensor,
            times,
            *(values[:, :, number, quantity] for quantity in range(4)),
            bound[:, :, number],
            moved[:, :, number],
            tuple(why),
        )
        for number, sensor in enumerate(sensors)
    ]


def _one_throw(
    scene: Scene, row: int, sensors: tuple[Sensor, ...], limit_s: float, skipped: int, *columns: Array
) -> str:
    """Write one throw's values, bound and input error; return why they end before the last instant."""
    # It is compiled, by a compiler that a scene without sensors need not load.
    from tumble.scenarios.truth.forced.readings import readings

    try:
        with within(limit_s):
            found = readings(scene, row, sensors)
    except Late:
        return f"the reading was not computed within {PARTS * limit_s:g} s (--time-limit)"
    for every, own in zip(columns, found[:3], strict=True):
        every[: max(len(own) - skipped, 0), row] = own[skipped:]
    return found.why


def _leave_out_blurred(values: Array, resolution: Array, why: np.ndarray) -> None:
    """Take out, in place, the rows from the first on at which a vector is not known to a millionth of its largest."""
    size = np.linalg.norm(np.nan_to_num(values), axis=-1).max(axis=(0, 1))
    blurred = (~(resolution <= TRUSTED * size)).any(axis=(1, 2, 3))
    if blurred.any():
        first = int(np.argmax(blurred))
        values[first:] = np.nan
        late = why[first:]
        late[late == ""] = BLURRED
