"""The model of a simulated sensor: what it reads from a motion, right or with mistakes.

A right accelerometer reads the specific force of its point in its own axes, C^T R^T (a - g + alpha x r + w x (w x r)),
and a right gyro C^T w, with C from its axes to the body's and R from the body's to the world's (IEEE Std 528; Titterton
and Weston, Strapdown Inertial Navigation Technology, 2004, section 3.4).  A mistake replaces some of the fields.
"""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from tumble.compare.grade.model.kinematics import Kinematics, Motion, in_axes, in_world
from tumble.scenarios.frames import Array, rotation_matrix
from tumble.scenarios.scene import Sensor

ACCELEROMETER, GYRO = "accelerometer", "gyro"
# Axes of the readings: the sensor's; or mistakes with the body's attitude, and with the sensor's orientation.
SENSOR, WORLD, ATTITUDE_TRANSPOSED, BODY, ORIENTATION_TRANSPOSED, WORLD_WITHOUT_ORIENTATION = range(6)
# Low-pass filters: none; of the first order at the rows, of the first order in time, or the mean of some rows.
NO_FILTER, ROW_FILTER, TIME_FILTER, MOVING_AVERAGE = range(4)
# Nodes of a mean over a reading's interval (Gauss and Legendre), exact up to order 9.
NODES, NODE_WEIGHTS = np.polynomial.legendre.leggauss(5)


class Terms(NamedTuple):
    """Factors of the terms of the specific force, and in which axes they are formed.

    acceleration: of a; gravity: of -g; tangential: of alpha x r; centripetal: of w x (w x r); transport: of -w x v,
    1 if the velocity is differentiated in the rotating frame; of_point: v is the sensor's, not the centre's;
    gravity_rotated: g is rotated to the body's axes; lever_rotated: r is rotated to the axes of alpha and w.
    """

    acceleration: float = 1.0
    gravity: float = 1.0
    tangential: float = 1.0
    centripetal: float = 1.0
    transport: float = 0.0
    of_point: bool = True
    gravity_rotated: bool = True
    lever_rotated: bool = True


RIGHT_TERMS = Terms()


@dataclass(frozen=True, eq=False)
class SensorModel:
    """One device of a sensor as a program models it.

    device: accelerometer or gyro; point: [m], (3,), and orientation: sensor to body, (3, 3), both in principal axes;
    window_s: length of the mean that a reading is, 0: at one instant; terms: of the specific force; axes: of the
    readings, one of the constants above; output_axes: signed permutation of the readings, (3, 3); factor: on them;
    delay_s: how late they are; difference_s: interval of the difference of velocities that the acceleration is, 0: a
    derivative; cutoff: kind of the low-pass filter; cutoff_value: its coefficient, time constant [s] or number of rows;
    free: names of quantities whose values are fitted: point, bias, gravity, factor.
    """

    device: str
    point: Array
    orientation: Array
    window_s: float = 0.0
    terms: Terms = RIGHT_TERMS
    axes: int = SENSOR
    output_axes: Array = field(default_factory=lambda: np.eye(3))
    factor: float = 1.0
    delay_s: float = 0.0
    difference_s: float = 0.0
    cutoff: int = NO_FILTER
    cutoff_value: float = 0.0
    free: frozenset[str] = frozenset()

    def columns_at(self, motion: Motion, times: Array) -> tuple[Array, Array]:
        """Return `columns` at increasing times [s], late by the delay, or their mean over the window before each."""
        late = times - self.delay_s
        nodes, weights = (NODES.tolist(), NODE_WEIGHTS / 2) if self.window_s else ([1.0], np.ones(1))
        parts = [self._columns_of(motion, late + self.window_s * (node - 1) / 2) for node in nodes]
        known, free = (sum(weight * part[k] for weight, part in zip(weights, parts, strict=True)) for k in (0, 1))
        return np.asarray(known), np.asarray(free)

    def _columns_of(self, motion: Motion, times: Array) -> tuple[Array, Array]:
        before = motion.at(times - self.difference_s) if self.difference_s else None
        return self.columns(motion.at(times), before, motion.gravity)

    def columns(self, motion: Kinematics, before: Kinematics | None, gravity: Array) -> tuple[Array, Array]:
        """Return the readings without a filter, (T, 3), and their change per unit of each free value, (T, 3, n).

        before: the motion by the interval of a difference earlier; None: accelerations are derivatives.
        """
        free = []
        if self.device == GYRO:
            body = motion.w_body
        else:
            point, pull = self.point, self._gravity(motion, gravity)
            body = self.terms.acceleration * self._centre(motion, before)
            if "point" in self.free:
                point = np.zeros(3)
                free += [self._lever(motion, before, axis) for axis in np.eye(3)]
            if point.any():
                body = body + self._lever(motion, before, point)
            if "gravity" in self.free:
                free.append(-pull)
            elif self.terms.gravity:
                body = body - self.terms.gravity * pull
        known = self._output(motion, body)
        columns = [self._output(motion, each) for each in free]
        if "bias" in self.free:
            columns += [np.broadcast_to(axis, known.shape) for axis in np.eye(3)]
        if "factor" in self.free:
            columns.append(known)
            known = np.zeros_like(known)
        return known, np.stack(columns, axis=2) if columns else np.empty((*known.shape, 0))

    def _centre(self, motion: Kinematics, before: Kinematics | None) -> Array:
        """Return the acceleration of the centre of mass, body axes."""
        if before is not None:
            return self._difference(motion, before, motion.v_world, before.v_world)
        body = in_axes(motion.axes, motion.a_world)
        if self.terms.transport:
            body = body - np.cross(motion.w_body, in_axes(motion.axes, motion.v_world))
        return body

    def _lever(self, motion: Kinematics, before: Kinematics | None, lever: Array) -> Array:
        """Return what the lever adds, alpha x r + w x (w x r) with their factors, body axes.

        A lever that is not rotated is of world axes.
        """
        terms, w = self.terms, motion.w_body
        if before is not None and terms.centripetal == terms.tangential:
            now, then = (in_world(each.axes, np.cross(each.w_body, lever)) for each in (motion, before))
            return terms.centripetal * self._difference(motion, before, now, then)
        arm = np.broadcast_to(lever, w.shape)
        if not terms.lever_rotated:
            arm = in_axes(motion.axes, arm)
        toward = np.cross(w, np.cross(w, arm))
        lost = 1.0 if terms.transport and terms.of_point else 0.0
        return terms.tangential * np.cross(motion.alpha_body, arm) + (terms.centripetal - lost) * toward

    def _difference(self, motion: Kinematics, before: Kinematics, v_now: Array, v_before: Array) -> Array:
        """Return the difference of velocities of world axes over its interval, body axes."""
        if self.terms.transport:
            return (in_axes(motion.axes, v_now) - in_axes(before.axes, v_before)) / self.difference_s
        return in_axes(motion.axes, v_now - v_before) / self.difference_s

    def _gravity(self, motion: Kinematics, gravity: Array) -> Array:
        everywhere = np.broadcast_to(gravity, motion.w_body.shape)
        return in_axes(motion.axes, everywhere) if self.terms.gravity_rotated else everywhere

    def _output(self, motion: Kinematics, body: Array) -> Array:
        """Return vectors of the body's axes as the program writes them."""
        if self.axes == BODY:
            vectors = body
        elif self.axes == ORIENTATION_TRANSPOSED:
            vectors = body @ self.orientation.T
        elif self.axes == WORLD_WITHOUT_ORIENTATION:
            vectors = in_world(motion.axes, body)
        else:
            if self.axes == WORLD:
                body = in_world(motion.axes, body)
            elif self.axes == ATTITUDE_TRANSPOSED:
                body = in_world(motion.axes, in_world(motion.axes, body))
            vectors = body @ self.orientation
        return self.factor * vectors @ self.output_axes.T


def right_model(sensor: Sensor, device: str) -> SensorModel:
    """Return the model of a sensor's device without a mistake."""
    return SensorModel(
        device,
        np.array(sensor.point_body),
        rotation_matrix(sensor.orientation),
        1 / sensor.rate if sensor.average else 0.0,
    )
