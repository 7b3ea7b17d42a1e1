"""A flight: many throws of one body by one method, free but for gravity, or under forces."""

from collections.abc import Collection, Iterator

import numpy as np
from numpy.typing import ArrayLike, NDArray

from solver.body import Body
from solver.forces import Forces, gives_torque
from solver.quaternion import from_matrix, to_matrix
from solver.registry import find

Array = NDArray[np.float64]

# A flight that blew up is full of inf and nan for a judge to see; numpy need not say so as well.
silently = np.errstate(all="ignore")

# Many throws are written and read in parts: what lies between two layouts is never held for all of them.
PART = 1 << 12
ALL = slice(None)


def _parts(throws: int) -> Iterator[slice]:
    return (slice(first, first + PART) for first in range(0, throws, PART))


def _turned(matrices: Array, vectors: Array) -> Array:
    """Return matrix times vector, (..., 3); einsum, for matmul leaves the last bits of a throw to the BLAS."""
    return np.einsum("...ij,...j->...i", matrices, vectors)


def _transposed(matrices: Array) -> Array:
    return np.swapaxes(matrices, -2, -1)


def _normalised(quaternions: Array) -> Array:
    return quaternions / np.sqrt(np.sum(quaternions * quaternions, axis=-1, keepdims=True))


class Flight:
    """N throws of one body by one method, free but for gravity.

    method: a name of `solver.registry`, or NAME@TOLERANCE.  gravity [m/s2], (3,), world axes, or None where there is
    none.  kept: of "gyroscopic" and "rotation", what is computed although it changes nothing, to be timed.
    Raises ValueError for a method that does not exist.
    Its attributes: method, the registry's line, and dt [s], the step of the last advance, 0 before the first.

    The rotation is stepped, or, by a dense method, found at once from where the count of steps began: then nothing
    depends on how often it was asked for.  A throw without spin is left as it is.  The translation is the sum of the
    method's steps in closed form, x = x0 + t v0 + g t (t + lag dt)/2 with t = n dt, where lag is -1 for explicit Euler,
    +1 for symplectic Euler and 0 for a method that is exact on a parabola: the same scheme, without its rounding, and
    for nothing.
    """

    def __init__(
        self, body: Body, method: str, gravity: ArrayLike | None = None, kept: Collection[str] = frozenset()
    ) -> None:
        self.method = find(method)
        self._tolerance = () if self.method.tolerance is None else (self.method.tolerance,)
        self._moments = np.array(body.moments)
        self._inverse_moments = body.inverse_moments
        self._gyroscopic = body.gyroscopic
        if "gyroscopic" in kept and self._gyroscopic is None:
            self._gyroscopic = (0.0, 0.0, 0.0)
        self._always_turning = "rotation" in kept
        self._gravity = None if gravity is None else np.array(gravity, dtype=float)
        self.write(np.empty((0, 13)))

    @silently
    def write(self, states: ArrayLike) -> None:
        """Start from these states, (N, 13), and forget all that was before.  Raises ValueError for another shape."""
        start = np.asarray(states, dtype=float)
        if start.ndim != 2 or start.shape[1] != 13:
            raise ValueError(f"states must have the shape (N, 13), got {start.shape}")
        self._spins = np.empty((len(start), self.method.width))
        for rows in _parts(len(start)):
            spins = self._spins_of(start[rows])
            self._spins[rows, : spins.shape[1]] = spins
        self._turning = start[:, 10:13].any(axis=1) | self._always_turning
        self._all_turning, self._any_turning = bool(self._turning.all()), bool(self._turning.any())
        self._start_counting(start[:, 0:3].copy(), start[:, 7:10].copy())

    def _spins_of(self, states: Array) -> Array:
        """Return attitude and angular momentum as the method keeps them, (N, 7) or (N, 12)."""
        quaternions = _normalised(states[:, 3:7])
        matrices = to_matrix(quaternions)
        momentum_body = self._moments * _turned(_transposed(matrices), states[:, 10:13])
        attitude = quaternions if self.method.attitude == "quaternion" else _transposed(matrices).reshape(-1, 9)
        momentum = momentum_body if self.method.momentum_axes == "body" else _turned(matrices, momentum_body)
        return np.hstack((attitude, momentum))

    def advance(self, n: int, dt: float) -> None:
        """Take n steps of dt [s].  Two advances of one dt are one long one to the last bit."""
        n, dt = int(n), float(dt)
        if self._steps and dt != self.dt:
            self._start_counting(*self._translation())
        self.dt = dt
        self._steps += n
        self._step(self._steps if self.method.dense else n, dt)

    @silently
    def read(self) -> Array:
        """Return the states, (N, 13); of a matrix that is no rotation any more, the nearest rotation's quaternion."""
        states = np.empty((len(self._spins), 13))
        for rows in _parts(len(states)):
            states[rows, 0:3], states[rows, 7:10] = self._translation(rows)
            states[rows, 3:7], states[rows, 10:13] = self._rotation(rows)
        return states

    def _rotation(self, rows: slice) -> tuple[Array, Array]:
        """Return quaternions, (N, 4), and w_world [rad/s], (N, 3), of some throws."""
        spins, matrices = self._spins[rows], self.matrices(rows)
        quaternions = from_matrix(matrices) if self.method.attitude == "matrix" else _normalised(spins[:, :4])
        momentum = spins[:, 9:12] if self.method.attitude == "matrix" else spins[:, 4:7]
        momentum_body = momentum if self.method.momentum_axes == "body" else _turned(_transposed(matrices), momentum)
        return quaternions, _turned(matrices, momentum_body / self._moments)

    @silently
    def matrices(self, rows: slice = ALL) -> Array:
        """Return the matrices that turn body axes into world axes, (N, 3, 3), rotations or not, of some throws."""
        spins = self._spins[rows]
        if self.method.attitude == "matrix":
            return _transposed(spins[:, :9].reshape(-1, 3, 3)).copy()
        return to_matrix(_normalised(spins[:, :4]))

    @silently
    def vertices(self, points: ArrayLike) -> Array:
        """Return where points of the body are [m], (N, n, 3): p = x + R p0, with R as the method has it.

        points [m], (n, 3), body axes.  Source: CE1051A report, eq. 2.12.
        """
        position, _ = self._translation()
        return position[:, None] + _turned(self.matrices()[:, None], np.asarray(points, dtype=float))

    def compile(self) -> None:
        """Compile all that the next advance will call, so that it need not wait for it."""
        if self._any_turning:
            self._turn(self._spins[:0], 0, 0.0)

    def _step(self, count: int, dt: float) -> None:
        """Take the steps, or count them from where the count began, that are not in closed form."""
        if self._all_turning:
            self._turn(self._spins, count, dt)
        elif self._any_turning:
            spins = self._spins[self._turning]
            self._turn(spins, count, dt)
            self._spins[self._turning] = spins

    def _turn(self, spins: Array, count: int, dt: float) -> None:
        """Step the rotation of these rows."""
        self.method.steps(spins, count, dt, self._inverse_moments, self._gyroscopic, *self._tolerance)

    def _start_counting(self, position: Array, velocity: Array) -> None:
        """Count steps from here."""
        if self.method.dense:
            self._spins[:, 7:14], self._spins[:, 14:16] = self._spins[:, 0:7], 0.0
        self._position, self._velocity = position, velocity
        self.dt, self._steps = 0.0, 0

    @silently
    def _translation(self, rows: slice = ALL) -> tuple[Array, Array]:
        """Return position [m] and velocity [m/s] of some throws after the steps counted, each (N, 3)."""
        t, velocity = self._steps * self.dt, self._velocity[rows]
        drift = self._position[rows] + t * velocity
        if self._gravity is None:
            return drift, velocity
        fall = t * (t + self.method.lag * self.dt) / 2.0
        return drift + fall * self._gravity, velocity + t * self._gravity


class ForcedFlight(Flight):
    """N throws of one body by one method, under forces.

    forces: `solver.forces.Forces`, gravity among them.  Raises NotImplementedError for a method that carries none.
    What no force ties together is not stepped together: where none gives a torque the rotation is that of free flight,
    and position and velocity alone are six numbers.
    """

    def __init__(self, body: Body, method: str, forces: Forces, kept: Collection[str] = frozenset()) -> None:
        if find(method).forced is None:
            raise NotImplementedError(f"{method} carries no forces")
        self._body, self._forces = body, forces
        super().__init__(body, method, forces.gravity, kept)

    def write(self, states: ArrayLike) -> None:
        """Start from these states, (N, 13), and forget all that was before.  Raises ValueError for another shape."""
        self._rows = np.zeros((len(np.atleast_1d(states)), self.method.forced_width))
        super().write(states)

    @property
    def unsolved(self) -> int:
        """How many steps of all throws an implicit method did not find since they were written."""
        return int(self._rows[:, 13].sum()) if self.method.counts_unsolved else 0

    def compile(self) -> None:
        """Compile all that the next advance will call, so that it need not wait for it."""
        if not self._tied:
            super().compile()
        self._fly(self._rows[:0], 0, 0.0)

    def _step(self, count: int, dt: float) -> None:
        if not self._tied:
            super()._step(count, dt)
        self._fly(self._rows, count, dt)
        if self._tied:
            self._spins[:, 0:4], self._spins[:, 4:7] = self._rows[:, 3:7], self._rows[:, 10:13]

    def _fly(self, rows: Array, count: int, dt: float) -> None:
        """Step whole states, or what is left of them where the rotation goes its own way."""
        turning = (self._inverse_moments, self._gyroscopic) if self._tied else (None, None)
        assert self.method.forced is not None
        self.method.forced(rows, count, dt, self._body.moments, *turning, self._forces, *self._tolerance)

    def _start_counting(self, position: Array, velocity: Array) -> None:
        """Count steps from here."""
        super()._start_counting(position, velocity)
        self._tied = gives_torque(self._forces, self._any_turning)
        here = np.hstack((position, self._spins[:, 0:4], velocity, self._spins[:, 4:7]))
        self._rows[:, 0:13] = here
        if self.method.dense:
            self._rows[:, 13:26], self._rows[:, 26:28] = here, 0.0

    def _translation(self, rows: slice = ALL) -> tuple[Array, Array]:
        return self._rows[rows, 0:3].copy(), self._rows[rows, 7:10].copy()
