"""The rotation of many throws of one body, as one method keeps and steps it."""

from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray

from tumble.solver.body import Body
from tumble.solver.quaternion import from_matrix, to_matrix, turned
from tumble.solver.registry import Method

Array = NDArray[np.float64]


class Rotation:
    """Attitude and angular momentum of N throws, stepped, or, by a dense method, found at once.

    kept: of "gyroscopic" and "rotation", what is computed although it changes nothing, to be timed.
    A throw without spin is left as it is.  A dense method goes to any instant from where the count of steps began: then
    nothing depends on how often it was asked for.
    """

    def __init__(self, body: Body, method: Method, keep: Collection[str]) -> None:
        self._method = method
        self._tolerance = () if method.tolerance is None else (method.tolerance,)
        self._moments, self._inverse_moments = np.array(body.moments), body.inverse_moments
        self._gyroscopic = body.gyroscopic
        if "gyroscopic" in keep and self._gyroscopic is None:
            self._gyroscopic = (0.0, 0.0, 0.0)
        self._always_turning = "rotation" in keep

    def write(self, states: Array, parts: list[slice]) -> None:
        """Start from these states, (N, 13); parts: the rows, some at a time."""
        self.rows = np.empty((len(states), self._method.width))
        for part in parts:
            rows = self._rows_of(states[part])
            self.rows[part, : rows.shape[1]] = rows
        self._turning = states[:, 10:13].any(axis=1) | self._always_turning
        self._all_turning, self.any_turning = bool(self._turning.all()), bool(self._turning.any())

    def _rows_of(self, states: Array) -> Array:
        """Return attitude and angular momentum as the method keeps them, (N, 7) or (N, 12)."""
        quaternions = _normalised(states[:, 3:7])
        matrices = to_matrix(quaternions)
        momentum_body = self._moments * turned(_transposed(matrices), states[:, 10:13])
        attitude = quaternions if self._method.attitude == "quaternion" else _transposed(matrices).reshape(-1, 9)
        momentum = momentum_body if self._method.momentum_axes == "body" else turned(matrices, momentum_body)
        return np.hstack((attitude, momentum))

    def begin(self) -> None:
        """Count steps from here."""
        if self._method.dense:
            self.rows[:, 7:14] = self.rows[:, 0:7]
        self.rows[:, self._method.width - self._method.keeps :] = 0.0

    def step(self, n: int, steps: int, dt: float) -> None:
        """Take n steps of dt [s], after which there are that many since the count began."""
        count = steps if self._method.dense else n
        if self._all_turning:
            self._step(self.rows, count, dt)
        elif self.any_turning:
            rows = self.rows[self._turning]
            self._step(rows, count, dt)
            self.rows[self._turning] = rows

    def compile(self) -> None:
        """Compile the method's kernel."""
        if self.any_turning:
            self._step(self.rows[:0], 0, 0.0)

    def _step(self, rows: Array, count: int, dt: float) -> None:
        self._method.steps(rows, count, dt, self._inverse_moments, self._gyroscopic, *self._tolerance)

    def read(self, part: slice) -> tuple[Array, Array]:
        """Return quaternions, (N, 4), and w_world [rad/s], (N, 3); of a matrix the nearest rotation's quaternion."""
        rows = self.rows[part]
        if self._method.attitude == "matrix":
            matrices, momentum = self.matrices(part), rows[:, 9:12]
            quaternions = from_matrix(matrices)
        else:
            quaternions, momentum = _normalised(rows[:, :4]), rows[:, 4:7]
            matrices = to_matrix(quaternions)
        momentum_body = momentum if self._method.momentum_axes == "body" else turned(_transposed(matrices), momentum)
        return quaternions, turned(matrices, momentum_body / self._moments)

    def matrices(self, part: slice) -> Array:
        """Return the matrices that turn body axes into world axes, (N, 3, 3), rotations or not."""
        rows = self.rows[part]
        if self._method.attitude == "matrix":
            return _transposed(rows[:, :9].reshape(-1, 3, 3)).copy()
        return to_matrix(_normalised(rows[:, :4]))


def _transposed(matrices: Array) -> Array:
    return np.swapaxes(matrices, -2, -1)


def _normalised(quaternions: Array) -> Array:
    return quaternions / np.sqrt(np.add.reduce(quaternions * quaternions, axis=-1, keepdims=True))
