"""Mistakes of simulated sensors, as data: how each changes the model of a right sensor."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import permutations, product

import numpy as np

from tumble.compare.grade.hypotheses.hypothesis import NEAR, STEPS
from tumble.compare.grade.model.sensor_model import (
    ACCELEROMETER,
    ATTITUDE_TRANSPOSED,
    BODY,
    MOVING_AVERAGE,
    ORIENTATION_TRANSPOSED,
    ROW_FILTER,
    TIME_FILTER,
    WORLD,
    WORLD_WITHOUT_ORIENTATION,
    SensorModel,
)
from tumble.compare.grade.read.columns import STANDARD_GRAVITY
from tumble.scenarios.frames import Array

Change = Callable[[SensorModel, float], SensorModel]
# Delays in row intervals that are tried first, and those that have a name.
DELAYS = (-2.0, -1.0, -0.5, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 10.0)
NAMED_DELAYS = {1.0: "a sample", 0.5: "half a sample", 2.0: "2 samples", 3.0: "3 samples", -1.0: "a sample early"}
AXES = "xyz"


@dataclass(frozen=True, eq=False)
class SensorHypothesis:
    """A mistake of a simulated sensor.

    name: for tables; part: of the model, which has at most one mistake a part; text: for people, with a place for the
    value; change: makes the mistake; values: tried first, () if there is none; named: value -> its text; fitted: the
    value may be any between the first ones; parameter, unit: of the value; words: text of each value of a choice;
    free: quantity whose values are fitted by least squares; free_names: of these values.
    """

    name: str
    part: str
    text: str
    change: Change
    values: tuple[float, ...] = ()
    named: tuple[tuple[float, str], ...] = ()
    fitted: bool = False
    parameter: str = ""
    unit: str = ""
    words: tuple[str, ...] = ()
    free_names: tuple[str, ...] = ()


def sensor_hypotheses(model: SensorModel, spacing_s: float) -> tuple[SensorHypothesis, ...]:
    """Return the mistakes of one device that have an effect on some motion; spacing_s: interval of rows [s]."""
    of_device = _of_accelerometer(model, spacing_s) if model.device == ACCELEROMETER else _of_gyro()
    return (*of_device, *_of_any(model, spacing_s))


def _terms(**fields: float) -> Change:
    return lambda model, value: replace(model, terms=model.terms._replace(**fields))


def _axes(axes: int) -> Change:
    return lambda model, value: replace(model, axes=axes)


def _free(name: str) -> Change:
    return lambda model, value: replace(model, free=model.free | {name})


def _of_accelerometer(model: SensorModel, spacing_s: float) -> Iterator[SensorHypothesis]:
    """Yield the mistakes of an accelerometer; those of a lever only if there is one."""
    steps = {step: name for step, name in STEPS.items() if step < spacing_s * (1 - NEAR)}
    if model.point.any():
        yield SensorHypothesis(
            "sensor-centripetal-term-missing", "lever", "the term w x (w x r) is missing", _terms(centripetal=0.0)
        )
        yield SensorHypothesis(
            "sensor-tangential-term-missing", "lever", "the term alpha x r is missing", _terms(tangential=0.0)
        )
        yield SensorHypothesis(
            "sensor-lever-arm-missing",
            "lever",
            "the lever arm from the centre of mass to the sensor is left out",
            _terms(centripetal=0.0, tangential=0.0),
        )
        yield SensorHypothesis(
            "sensor-centripetal-term-reversed",
            "lever",
            "the term w x (w x r) has the wrong sign",
            _terms(centripetal=-1.0),
        )
        yield SensorHypothesis(
            "sensor-tangential-term-reversed", "lever", "the term alpha x r has the wrong sign", _terms(tangential=-1.0)
        )
        yield SensorHypothesis(
            "sensor-lever-arm-reversed",
            "lever",
            "the lever arm is reversed, from the sensor to the centre of mass",
            _terms(centripetal=-1.0, tangential=-1.0),
        )
        yield SensorHypothesis(
            "sensor-lever-arm-not-rotated",
            "lever",
            "the lever arm is not rotated to the axes of w and alpha",
            _terms(lever_rotated=False),
        )
    yield SensorHypothesis(
        "sensor-gravity-missing",
        "gravity",
        "gravity is missing: the reading is the acceleration, not the specific force",
        _terms(gravity=0.0),
    )
    yield SensorHypothesis(
        "sensor-gravity-reversed",
        "gravity",
        "gravity has the wrong sign and counts twice: a falling body reads 2 g, not 0",
        _terms(gravity=-1.0),
    )
    yield SensorHypothesis("sensor-gravity-doubled", "gravity", "gravity is subtracted twice", _terms(gravity=2.0))
    yield SensorHypothesis(
        "sensor-gravity-not-rotated",
        "gravity",
        "gravity is not rotated to the axes of the body",
        _terms(gravity_rotated=False),
    )
    yield SensorHypothesis(
        "sensor-gravity-wrong-magnitude",
        "gravity",
        "gravity has another magnitude, by a factor of {}",
        _free("gravity"),
        parameter="factor",
        free_names=("factor",),
    )
    yield SensorHypothesis(
        "sensor-acceleration-missing",
        "acceleration",
        "the acceleration of the centre of mass is missing",
        _terms(acceleration=0.0),
    )
    yield SensorHypothesis(
        "sensor-differentiated-in-rotating-frame",
        "transport",
        "the velocity is differentiated in the rotating frame, so the term w x v is lost",
        _terms(transport=1.0),
    )
    if model.point.any():
        yield SensorHypothesis(
            "sensor-differentiated-in-rotating-frame",
            "transport",
            "the velocity of the centre of mass is differentiated in the rotating frame, so the term w x v is lost",
            _terms(transport=1.0, of_point=False),
        )
    yield SensorHypothesis(
        "sensor-acceleration-by-differences",
        "acceleration",
        "the acceleration is the difference of velocities over {} s",
        lambda model, value: replace(model, difference_s=value),
        values=(*(spacing_s * rows for rows in (1.0, 0.5, 0.25, 0.1, 2.0)), *steps),
        named=((spacing_s, "a row"), *steps.items()),
        fitted=True,
        parameter="time",
        unit="s",
    )
    yield SensorHypothesis(
        "sensor-at-wrong-point",
        "lever",
        "the sensor is at another point of the body, ({}, {}, {}) m from the centre of mass",
        _free("point"),
        parameter="point",
        unit="m",
        free_names=("x", "y", "z"),
    )
    yield from _units(
        {1 / STANDARD_GRAVITY: "the reading is in g, not m/s2", STANDARD_GRAVITY: "the reading is multiplied by g"}, "g"
    )


def _of_gyro() -> Iterator[SensorHypothesis]:
    yield from _units(
        {180 / np.pi: "the reading is in degrees per second", np.pi / 180: "degrees are converted to radians twice"},
        "degrees",
    )
    yield from _units(
        {1 / (2 * np.pi): "the reading is in revolutions per second", 30 / np.pi: "the reading is in rpm"},
        "revolutions",
    )


def _units(texts: dict[float, str], unit: str) -> Iterator[SensorHypothesis]:
    """Yield wrong units, each a factor."""
    for factor, text in texts.items():
        yield SensorHypothesis(
            f"sensor-in-{unit}", "factor", text, lambda model, value, factor=factor: replace(model, factor=factor)
        )


def _of_any(model: SensorModel, spacing_s: float) -> Iterator[SensorHypothesis]:
    """Yield the mistakes of any device."""
    yield SensorHypothesis(
        "sensor-in-world-axes", "axes", "the reading is in world axes, not in the sensor's", _axes(WORLD)
    )
    yield SensorHypothesis(
        "sensor-attitude-transposed",
        "axes",
        "the rotation is transposed: R is applied in place of R^T",
        _axes(ATTITUDE_TRANSPOSED),
    )
    if not np.allclose(model.orientation, np.eye(3)):
        yield SensorHypothesis(
            "sensor-orientation-missing",
            "axes",
            "the reading is in the body's axes: the orientation of the sensor is left out",
            _axes(BODY),
        )
        yield SensorHypothesis(
            "sensor-orientation-transposed",
            "axes",
            "the orientation of the sensor is transposed",
            _axes(ORIENTATION_TRANSPOSED),
        )
        yield SensorHypothesis(
            "sensor-in-world-axes",
            "axes",
            "the reading is in world axes: the orientations of the sensor and of the body are left out",
            _axes(WORLD_WITHOUT_ORIENTATION),
        )
    yield from _signed_permutations()
    yield SensorHypothesis(
        "sensor-wrong-scale",
        "factor",
        "the reading has another scale, by a factor of {}",
        _free("factor"),
        parameter="factor",
        free_names=("factor",),
    )
    yield SensorHypothesis(
        "sensor-biased",
        "bias",
        "the reading has a constant bias of ({}, {}, {}) " + ("m/s2" if model.device == ACCELEROMETER else "rad/s"),
        _free("bias"),
        parameter="bias",
        unit="m/s2" if model.device == ACCELEROMETER else "rad/s",
        free_names=("x", "y", "z"),
    )
    yield SensorHypothesis(
        "sensor-late",
        "delay",
        "the reading is late by {} s",
        lambda model, value: replace(model, delay_s=value),
        values=tuple(spacing_s * rows for rows in DELAYS),
        named=tuple((spacing_s * rows, name) for rows, name in NAMED_DELAYS.items()),
        fitted=True,
        parameter="time",
        unit="s",
    )
    yield SensorHypothesis(
        "sensor-low-pass",
        "filter",
        "the reading has a low-pass filter, of which each row adds a share of {}",
        lambda model, value: replace(model, cutoff=ROW_FILTER, cutoff_value=value),
        values=(0.9, 0.75, 0.5, 0.35, 0.2, 0.1, 0.05, 0.02),
        fitted=True,
        parameter="share",
    )
    yield SensorHypothesis(
        "sensor-low-pass",
        "filter",
        "the reading has a low-pass filter with a time constant of {} s",
        lambda model, value: replace(model, cutoff=TIME_FILTER, cutoff_value=value),
        values=tuple(spacing_s * rows for rows in (0.3, 0.7, 1.5, 3.0, 6.0, 12.0, 25.0, 50.0)),
        fitted=True,
        parameter="time",
        unit="s",
    )
    yield SensorHypothesis(
        "sensor-moving-average",
        "filter",
        "the reading is the mean of {} rows",
        lambda model, value: replace(model, cutoff=MOVING_AVERAGE, cutoff_value=value),
        values=(2.0, 3.0, 4.0, 5.0, 8.0, 10.0, 16.0),
        parameter="rows",
    )


def _signed_permutations() -> Iterator[SensorHypothesis]:
    """Yield the sensor's axes in another order or with other signs: rotated, left-handed, or all reversed."""
    rotated: list[Array] = []
    mirrored: list[Array] = []
    for order, signs in product(permutations(range(3)), product((1.0, -1.0), repeat=3)):
        matrix = np.zeros((3, 3))
        matrix[range(3), order] = signs
        if not (np.array_equal(matrix, np.eye(3)) or np.array_equal(matrix, -np.eye(3))):
            (rotated if np.linalg.det(matrix) > 0 else mirrored).append(matrix)
    yield _choice("sensor-axes-permuted", "the axes are permuted: {} is written as x, y, z", rotated)
    yield _choice("sensor-axes-left-handed", "the axes are left-handed: {} is written as x, y, z", mirrored)
    yield SensorHypothesis(
        "sensor-reversed",
        "output",
        "all components have the wrong sign",
        lambda model, value: replace(model, output_axes=-np.eye(3)),
    )


def _choice(name: str, text: str, matrices: list[Array]) -> SensorHypothesis:
    def change(model: SensorModel, value: float) -> SensorModel:
        return replace(model, output_axes=matrices[int(value)])

    words = tuple(
        ", ".join(("-" if row.sum() < 0 else "") + AXES[int(np.abs(row).argmax())] for row in matrix)
        for matrix in matrices
    )
    return SensorHypothesis(
        name, "output", text, change, tuple(map(float, range(len(words)))), parameter="choice", words=words
    )
