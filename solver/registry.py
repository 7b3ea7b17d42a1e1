"""The solver's methods, each with what it claims: the tests ask for every claim, and deny what is not claimed."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from solver.integrators.matrix_euler import matrix_euler
from solver.integrators.quaternion_euler import quaternion_euler
from solver.integrators.rk4 import rk4
from solver.integrators.symplectic_euler import symplectic_euler


@dataclass(frozen=True)
class Method:
    """How a method steps, how it keeps a rotation between two calls, and what it claims for a body of any moments.

    steps: the kernel, with the signature of `solver.integrators`.
    attitude: what the kernel's rows start with.  momentum_axes: the axes of the angular momentum that follows it.
    lag: how the position's steps use the velocity: -1 with the old one, +1 with the new one, 0 with their mean.
    order: the error of a finished flight falls as dt^order.
    rigid: the attitude stays a rotation.  keeps_momentum, keeps_energy: in free flight, to rounding, at any dt.
    reversible: a flight with v and w turned round comes back to rounding.
    stable_turn: |w| dt [rad] beyond which the rotation can blow up, although every number stays finite for a while.
    """

    steps: Callable
    attitude: Literal["quaternion", "matrix"]
    momentum_axes: Literal["world", "body"]
    lag: int
    order: int
    rigid: bool = True
    keeps_momentum: bool = False
    keeps_energy: bool = False
    reversible: bool = False
    stable_turn: float = math.inf


METHODS = {
    "rk4": Method(rk4, "quaternion", "body", lag=0, order=4, stable_turn=2.0 * math.sqrt(2.0)),
    "symplectic-euler": Method(symplectic_euler, "quaternion", "world", lag=+1, order=1, keeps_momentum=True),
    "quaternion-euler": Method(quaternion_euler, "quaternion", "world", lag=-1, order=1, keeps_momentum=True),
    "matrix-euler": Method(matrix_euler, "matrix", "world", lag=-1, order=1, rigid=False),
}
