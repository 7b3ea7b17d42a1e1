"""A flight: many throws of one body by one method, free but for gravity, or under forces."""

from collections.abc import Collection

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tumble.solver.body import Body
from tumble.solver.forces import Forces, only_gravity
from tumble.solver.quaternion import turned
from tumble.solver.registry import find
from tumble.solver.rotation import Rotation
from tumble.solver.translation import FreeFall, Stepped

Array = NDArray[np.float64]

# A flight that blew up is full of inf and nan for a judge to see; numpy need not say so as well.
silently = np.errstate(all="ignore")

# Many throws are written and read in parts: what lies between two layouts is never held for all of them.
PART = 1 << 12
ALL = slice(None)


def _parts(throws: int) -> list[slice]:
    return [slice(first, first + PART) for first in range(0, throws, PART)]


class Flight:
    """N throws of one body by one method.

    Attributes: `method`, the method's registry entry, and `dt` [s], the step of the last advance, 0 before the
    first.

    Parameters
    ----------
    body
    method
        a name of `tumble.solver.registry`, or NAME@TOLERANCE
    forces
        what acts; None for nothing
    keep
        terms to compute although they change nothing, so that they can be timed: any of "gyroscopic", "rotation"
        and "translation", which is then stepped instead of taken in closed form

    Raises
    ------
    ValueError
        The method does not exist.
    NotImplementedError
        The method cannot include the forces.
    """

    def __init__(
        self, body: Body, method: str, forces: Forces | None = None, keep: Collection[str] = frozenset()
    ) -> None:
        self.method = find(method)
        forces = forces or Forces(body.mass)
        self._rotation = Rotation(body, self.method, keep)
        self._translation: FreeFall | Stepped
        if only_gravity(forces) and "translation" not in keep:
            gravity = None if forces.gravity is None else np.array(forces.gravity, dtype=float)
            self._translation = FreeFall(self.method, gravity)
        else:
            self._translation = Stepped(body, method, self.method, forces)
        self.write(np.empty((0, 13)))

    @silently
    def write(self, states: ArrayLike) -> None:
        """Start from these states, (N, 13), and forget all that was before.  Raises ValueError for another shape."""
        start = np.asarray(states, dtype=float)
        if start.ndim != 2 or start.shape[1] != 13:
            raise ValueError(f"states must have the shape (N, 13), got {start.shape}")
        self._rotation.write(start, _parts(len(start)))
        self._unsolved = 0
        self._begin(start[:, 0:3].copy(), start[:, 7:10].copy())

    def _begin(self, position: Array, velocity: Array) -> None:
        """Count steps from here."""
        self._rotation.begin()
        self._translation.begin(position, velocity, self._rotation)
        self.dt, self._steps = 0.0, 0

    def advance(self, n: int, dt: float) -> None:
        """Take n steps of dt [s].  Two advances of one dt are one long one to the last bit."""
        n, dt = int(n), float(dt)
        if self._steps and dt != self.dt:
            self._unsolved = self.unsolved
            self._begin(*self._translation.read(ALL))
        self.dt = dt
        self._steps += n
        self._translation.step(n, self._steps, dt)
        if isinstance(self._translation, Stepped) and self._translation.carries_rotation:
            self._rotation.rows[:, 0:7] = self._translation.rotation
        else:
            self._rotation.step(n, self._steps, dt)

    @silently
    def read(self) -> Array:
        """Return the states, (N, 13); of a matrix that is no rotation any more, the nearest rotation's quaternion."""
        states = np.empty((len(self._rotation.rows), 13))
        for part in _parts(len(states)):
            states[part, 0:3], states[part, 7:10] = self._translation.read(part)
            states[part, 3:7], states[part, 10:13] = self._rotation.read(part)
        return states

    @silently
    def matrices(self) -> Array:
        """Return the matrices that turn body axes into world axes, (N, 3, 3), rotations or not."""
        return self._rotation.matrices(ALL)

    @silently
    def vertices(self, points: ArrayLike) -> Array:
        """Return where points of the body are [m], (N, n, 3): p = x + R p0, with R as the method has it.

        points [m], (n, 3), body axes.  Source: CE1051A report, eq. 2.12.
        """
        position, _ = self._translation.read(ALL)
        return position[:, None] + turned(self.matrices()[:, None], np.asarray(points, dtype=float))

    @property
    def unsolved(self) -> int:
        """How many steps of all throws an implicit method did not find since they were written."""
        return self._unsolved + self._translation.unsolved

    def compile(self) -> None:
        """Compile all that the next advance will call, so that it need not wait for it."""
        if not self._translation.carries_rotation:
            self._rotation.compile()
        self._translation.compile()
