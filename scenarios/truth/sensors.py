"""The true readings of a scene's sensors.

A sensor fixed at a point r of the body feels the specific force R^T (a - g) + alpha x r + w x (w x r) and turns with w,
both told in its own axes.  Source: IEEE Std 528 (specific force); Goldstein, "Classical Mechanics" (1980), eq. 4-107.
The motion is integrated by the truth's Taylor series (`forced`), in free flight as under forces.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Scene, Sensor
from tumble.scenarios.truth.deadline import PARTS, Late, within
from tumble.scenarios.truth.resolution import TRUSTED

IMPULSE = "an impulse acts at this instant: the specific force is not defined"
PLANE = "rigid contact: the truth has no contact force"
NO_INTERVAL = "no interval before the first reading"
BLURRED = "the last bits of the scene's numbers move the reading by more than a millionth"
# The place of the velocity that impulses add, among the quantities.
JUMP = 4
# Points of the rougher and of the finer rule of a mean, and how near the two must be; how many times as many panels are
# tried next, and how many nodes there may be.
RULES, AGREEMENT = (7, 10), 1e-14
MORE, MOST_NODES = 4, 50_000


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
        wall time for each part of the computation, of the sensors of each rate

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
    for rate, average in dict.fromkeys((sensor.rate, sensor.average) for sensor in scene.sensors):
        alike = tuple(one for one in scene.sensors if (one.rate, one.average) == (rate, average))
        for one in _together(scene, alike, scene.sensor_times(alike[0]), limit_s):
            found[one.sensor.name] = one
    return tuple(found[sensor.name] for sensor in scene.sensors)


def _together(scene: Scene, sensors: tuple[Sensor, ...], times: Array, limit_s: float) -> list[SensorTruth]:
    """Return the readings of sensors that read alike at the same instants."""
    read = _means if sensors[0].average else _values
    columns = read(scene, sensors, times, limit_s) if scene.plane is None else _nothing(scene, sensors, times, PLANE)
    _leave_out_blurred(columns)
    return [
        SensorTruth(
            sensor=sensor,
            times=times,
            specific_force=columns.values[:, :, number, 0],
            angular_velocity=columns.values[:, :, number, 1],
            angular_acceleration=columns.values[:, :, number, 2],
            field_direction=columns.values[:, :, number, 3],
            bound=columns.bound[:, :, number, :4],
            input_error=columns.moved[:, :, number, :4],
            why=tuple(columns.why),
        )
        for number, sensor in enumerate(sensors)
    ]


class _Columns(NamedTuple):
    """values, (K, N, S, quantities, 3); bound and input error, (K, N, S, quantities); why rows have none, (K,)."""

    values: Array
    bound: Array
    moved: Array
    why: np.ndarray


def _nothing(scene: Scene, sensors: tuple[Sensor, ...], times: Array, why: str = "") -> _Columns:
    """Return the columns of readings that are not known."""
    shape = (len(times), len(scene.start), len(sensors), 5)
    return _Columns(
        np.full((*shape, 3), np.nan), np.full(shape, np.inf), np.full(shape, np.inf), np.full(len(times), why, object)
    )


def _values(scene: Scene, sensors: tuple[Sensor, ...], times: Array, limit_s: float) -> _Columns:
    """Return the readings at the instants."""
    found = _at(scene, sensors, times, limit_s)
    struck = np.isin(times, [impulse.time for impulse in scene.impulses])
    # Only accelerations have no value there; the rest is that after the impulse.
    found.values[struck, :, :, 0] = found.values[struck, :, :, 2] = np.nan
    found.why[struck & (found.why == "")] = IMPULSE
    return found


def _at(scene: Scene, sensors: tuple[Sensor, ...], times: Array, limit_s: float) -> _Columns:
    """Return the readings at the instants, just after the impulses of an instant."""
    found, at = _nothing(scene, sensors, times), replace(scene, times=times, sensors=())
    skipped = len(at.rows) - len(times)  # the start, where it is not asked for
    for row in range(len(scene.start)):
        ended = _one_throw(at, row, sensors, limit_s, skipped, *found[:3])
        found.why[np.isnan(found.values[:, row, 0, 0, 0]) & (found.why == "")] = ended
    return found


def _means(scene: Scene, sensors: tuple[Sensor, ...], times: Array, limit_s: float) -> _Columns:
    """Return the means over the intervals between the instants, impulses included, by Gauss's quadrature.

    The intervals are cut at impulses, and into more panels until two rules agree.
    """
    found = _nothing(scene, sensors, times, NO_INTERVAL)
    if len(times) < 2:
        return found
    panels = 1
    while True:
        means, apart = _quadrature(scene, sensors, times, panels, limit_s)
        size = np.linalg.norm(np.nan_to_num(means.values), axis=-1).max(axis=0)
        if not (apart > AGREEMENT * size).any() or len(times) * panels * MORE * sum(RULES) > MOST_NODES:
            break
        panels *= MORE
    for every, own in zip(found, means, strict=True):
        every[1:] = own
    return found


def _quadrature(
    scene: Scene, sensors: tuple[Sensor, ...], times: Array, panels: int, limit_s: float
) -> tuple[_Columns, Array]:
    """Return the means of the intervals by the finer rule, (K - 1, ...), and how far the rougher one's are off."""
    struck = np.array(sorted({impulse.time for impulse in scene.impulses if impulse.time > 0.0}))
    cuts = np.unique(np.concatenate((times, struck[struck < times[-1]])))
    edges = np.unique((cuts[:-1, np.newaxis] + np.diff(cuts)[:, np.newaxis] * np.arange(panels) / panels).ravel())
    edges = np.append(edges, times[-1])
    rules = [np.polynomial.legendre.leggauss(points) for points in RULES]
    nodes = [(edges[:-1, np.newaxis] + np.diff(edges)[:, np.newaxis] * (1 + at) / 2) for at, _ in rules]
    instants = np.unique(np.concatenate([struck, *(each.ravel() for each in nodes)]))
    read = _at(scene, sensors, instants, limit_s)
    owner, spans = np.searchsorted(times, edges[:-1], side="right") - 1, np.diff(times)

    def summed(values: Array, number: int) -> Array:
        """Return the means of values at the instants, (R, ...), by one of the rules."""
        own = values[np.searchsorted(instants, nodes[number])]
        weights = rules[number][1] * np.diff(edges)[:, np.newaxis] / 2
        of_panels = np.einsum("pn,pn...->p...", weights, own)
        total = np.zeros((len(spans), *values.shape[1:]))
        np.add.at(total, owner, of_panels)
        return total / spans.reshape(-1, *[1] * (values.ndim - 1))

    fine, rough = (summed(read.values, number) for number in (1, 0))
    apart = np.linalg.norm(fine - rough, axis=-1)
    bound, moved = (summed(column, 1) for column in (read.bound, read.moved))
    # A node is rounded to a double, which is a change of the clock.
    bound += apart + 2 * moved
    for time in struck[struck <= times[-1]].tolist():
        interval, row = int(np.searchsorted(times, time)) - 1, int(np.searchsorted(instants, time))
        for total, column in ((fine, read.values), (bound, read.bound), (moved, read.moved)):
            total[interval, :, :, 0] += column[row, :, :, JUMP] / spans[interval]
    ended = next((why for why in read.why if why), "")
    why = np.where(np.isnan(fine[:, 0, 0, 0, 0]), ended, "").astype(object)
    return _Columns(fine, bound, moved, why), apart


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


def _leave_out_blurred(columns: _Columns) -> None:
    """Take out, in place, the rows from the first on at which a vector is not known to a millionth of its largest."""
    values = columns.values[..., :JUMP, :]
    resolution = np.maximum(columns.bound, columns.moved)[..., :JUMP]
    size = np.linalg.norm(np.nan_to_num(values), axis=-1).max(axis=(0, 1))
    there = ~np.isnan(values).any(axis=-1)
    blurred = (there & ~(resolution <= TRUSTED * size)).any(axis=(1, 2, 3))
    if blurred.any():
        first = int(np.argmax(blurred))
        columns.values[first:] = np.nan
        late = columns.why[first:]
        late[late == ""] = BLURRED
