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
    delay_s: how late they are; cutoff: kind of the low-pass filter; cutoff_value: its coefficient, time constant [s] or
    number of rows; free: names of quantities whose values are fitted: point, bias, gravity.
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
    cutoff: int = NO_FILTER
    cutoff_value: float = 0.0
    free: frozenset[str] = frozenset()

    def columns_at(self, motion: Motion, times: Array) -> tuple[Array, Array]:
        """Return `columns` at increasing times [s], late by the delay, or their mean over the window before each."""
        late = times - self.delay_s
        if not self.window_s:
            return self.columns(motion.at(late), motion.gravity)
        parts = [
            self.columns(motion.at(late + self.window_s * (node - 1) / 2), motion.gravity) for node in NODES.tolist()
        ]
        known, free = (
            sum(weight / 2 * part[k] for weight, part in zip(NODE_WEIGHTS, parts, strict=True)) for k in (0, 1)
        )
        return np.asarray(known), np.asarray(free)

    def columns(self, motion: Kinematics, gravity: Array) -> tuple[Array, Array]:
        """Return the readings without a filter, (T, 3), and their change per unit of each free value, (T, 3, n)."""
        free = []
        if self.device == GYRO:
            body = motion.w_body
        else:
            body = self._force(motion, gravity)
            if "point" in self.free:
                body = body - self._lever_terms(motion, self.point)
                free += [self._lever_terms(motion, axis) for axis in np.eye(3)]
            if "gravity" in self.free:
                pull = self._gravity(motion, gravity)
                body = body + self.terms.gravity * pull
                free.append(-pull)
        known = self._output(motion, body)
        columns = [self._output(motion, each) for each in free]
        if "bias" in self.free:
            columns += [np.broadcast_to(axis, known.shape) for axis in np.eye(3)]
        if "factor" in self.free:
            columns.append(known)
            known = np.zeros_like(known)
        return known, np.stack(columns, axis=2) if columns else np.empty((*known.shape, 0))

    def _force(self, motion: Kinematics, gravity: Array) -> Array:
        terms = self.terms
        body = terms.acceleration * in_axes(motion.axes, motion.a_world)
        if terms.gravity:
            body = body - terms.gravity * self._gravity(motion, gravity)
        if self.point.any():
            body = body + self._lever_terms(motion, self.point)
        if terms.transport:
            v_body = in_axes(motion.axes, motion.v_world)
            if terms.of_point:
                v_body = v_body + np.cross(motion.w_body, self.point)
            body = body - terms.transport * np.cross(motion.w_body, v_body)
        return body

    def _gravity(self, motion: Kinematics, gravity: Array) -> Array:
        everywhere = np.broadcast_to(gravity, motion.w_body.shape)
        return in_axes(motion.axes, everywhere) if self.terms.gravity_rotated else everywhere

    def _lever_terms(self, motion: Kinematics, lever: Array) -> Array:
        """Return alpha x r + w x (w x r) with their factors, body axes; without rotation, r is of world axes."""
        w, alpha = motion.w_body, motion.alpha_body
        arm = np.broadcast_to(lever, w.shape)
        if not self.terms.lever_rotated:
            arm = in_axes(motion.axes, arm)
        return self.terms.tangential * np.cross(alpha, arm) + self.terms.centripetal * np.cross(w, np.cross(w, arm))

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
