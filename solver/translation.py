"""How the centre of mass moves: in closed form where nothing but gravity acts, otherwise stepped under the forces."""

import numpy as np
from numpy.typing import NDArray

from tumble.solver.body import Body
from tumble.solver.forces import Forces, gives_torque
from tumble.solver.registry import Method
from tumble.solver.rotation import Rotation

Array = NDArray[np.float64]


class FreeFall:
    """Position and velocity of N throws that only gravity pulls at: the sum of a method's steps, in closed form.

    x = x0 + t v0 + g t (t + lag dt)/2 with t = n dt, where lag is -1 for explicit Euler, +1 for symplectic Euler and 0
    for a method that is exact on a parabola: the same scheme, without its rounding, and for nothing.
    """

    carries_rotation = False
    unsolved = 0

    def __init__(self, method: Method, gravity: Array | None) -> None:
        self._lag, self._gravity = method.lag, gravity

    def begin(self, position: Array, velocity: Array, rotation: Rotation) -> None:
        """Count steps from here."""
        self._position, self._velocity = position, velocity
        self._t, self._dt = 0.0, 0.0

    def step(self, n: int, steps: int, dt: float) -> None:
        """Take n steps of dt [s], after which there are that many since the count began."""
        self._t, self._dt = steps * dt, dt

    def compile(self) -> None:
        """There is nothing to compile."""

    def read(self, part: slice) -> tuple[Array, Array]:
        """Return position [m] and velocity [m/s], each (N, 3)."""
        t, velocity = self._t, self._velocity[part]
        position = self._position[part] + t * velocity
        if self._gravity is None:
            return position, velocity
        return position + t * (t + self._lag * self._dt) / 2.0 * self._gravity, velocity + t * self._gravity


class Stepped:
    """States of N throws under forces, stepped by the method's kernel.

    What no force ties together is not stepped together: where none gives a torque the rotation is that of free flight,
    and position and velocity alone are six numbers.  Raises NotImplementedError for a method that carries no forces.
    """

    def __init__(self, body: Body, name: str, method: Method, forces: Forces) -> None:
        if method.forced is None:
            raise NotImplementedError(f"{name} carries no forces")
        self._kernel, self._method = method.forced, method
        self._tolerance = () if method.tolerance is None else (method.tolerance,)
        self._body, self._forces = body, forces

    def begin(self, position: Array, velocity: Array, rotation: Rotation) -> None:
        """Count steps from here."""
        self.carries_rotation = gives_torque(self._forces, rotation.any_turning)
        here = np.hstack((position, rotation.rows[:, 0:4], velocity, rotation.rows[:, 4:7]))
        self._rows = np.zeros((len(position), self._method.forced_width))
        self._rows[:, 0:13] = here
        if self._method.dense:
            self._rows[:, 13:26] = here

    def step(self, n: int, steps: int, dt: float) -> None:
        """Take n steps of dt [s], after which there are that many since the count began."""
        self._step(self._rows, steps if self._method.dense else n, dt)

    def compile(self) -> None:
        """Compile the method's kernel."""
        self._step(self._rows[:0], 0, 0.0)

    def _step(self, rows: Array, count: int, dt: float) -> None:
        """Step whole states, or what is left of them where the rotation goes its own way."""
        turning = (self._body.inverse_moments, self._body.gyroscopic) if self.carries_rotation else (None, None)
        self._kernel(rows, count, dt, self._body.moments, *turning, self._forces, *self._tolerance)

    def read(self, part: slice) -> tuple[Array, Array]:
        """Return position [m] and velocity [m/s], each (N, 3)."""
        return self._rows[part, 0:3].copy(), self._rows[part, 7:10].copy()

    @property
    def rotation(self) -> Array:
        """Attitude and angular momentum as the kernel left them, (N, 7)."""
        return np.hstack((self._rows[:, 3:7], self._rows[:, 10:13]))

    @property
    def unsolved(self) -> int:
        """How many steps an implicit method did not find since the count began."""
        return int(self._rows[:, 13].sum()) if self._method.counts_unsolved else 0
