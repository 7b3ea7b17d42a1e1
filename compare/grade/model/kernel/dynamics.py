"""What a flight with mistakes is made of: the laws that move the body, what is done in a step, what acts and moves.

The solver's own methods are right but for their steps.  Here every term has a switch, so that a mistake is a number and
one compiled kernel flies them all.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tumble.solver.forces import Forces
from tumble.solver.quaternion import Quaternion
from tumble.solver.vectors import Vector

Array = NDArray[np.float64]

# A row of events: its instant [s], what happens, the impulse or force that moves, the one that turns, where it lands,
# whether that is in body axes; then, of a force, its lever arm, and the row in which it began.
EVENT = 16
JUMP, BEGIN, END = 0.0, 1.0, 2.0
# What a step does to the attitude; RUNGE_KUTTA takes all of it in one step, by the method that stands for its spin.
SMOOTH, QUATERNION, EXPONENTIAL, MATRIX, RUNGE_KUTTA = 0, 1, 2, 3, 4
# Runge-Kutta methods by their order, and two more of order 2: Heun's, and velocity Verlet; so much more where w is kept
# in world axes, q' = w q / 2.
ORDER_2, ORDER_3, ORDER_4, HEUN, VERLET, IN_WORLD = 2, 3, 4, 5, 6, 10
# What it does to the angular velocity: the gyroscopic term explicit, in body axes; L kept; by one Newton step of
# implicit Euler; w kept in world axes; explicit with |L| kept; (I - dt [L]) w' = L; by the implicit midpoint rule, with
# the attitude turned by the mean of the old w and the new.
EXPLICIT, MOMENTUM, IMPLICIT, WORLD, RESCALED, BACKWARD, MIDPOINT = 0, 1, 2, 3, 4, 5, 6
# Which angular velocity a program turns the attitude by: the right one; that in world axes as if it were in body axes,
# where it keeps L, or w; that in body axes as if it were in world axes.
UNMIXED, MIXED_MOMENTUM, MIXED_WORLD, MIXED_BODY = 0, 1, 2, 3
# What becomes of the lever arm of a force that lasts: the torque stays as it began; the point moves with the body; the
# point stays where it was in the world.
TORQUE_STAYS, POINT_MOVES, POINT_STAYS = 0, 1, 2
# Lever arms in body axes are turned as the body is; not at all; as it was at the start.
AS_THE_BODY, NOT_TURNED, AS_AT_THE_START = 0, 1, 2
# When a step damps: as a force, with its others; what they have made of the velocities; those, once it has moved; or
# what they were before.  How: v - c dt v, v exp(-c dt), or v / (1 + c dt).
AS_FORCE, AFTER_FORCES, LAST, BEFORE_FORCES = 0, 1, 2, 3
LINEARLY, EXPONENTIALLY, IMPLICITLY = 0, 1, 2
# In which axes the program has the inertia tensor: R I R^T; I; R0 I R0^T; R^T I R.  Of an impulse also: R I, as where
# its torque is taken to be in body axes.
TURNED, NEVER_TURNED, FROZEN, TURNED_BACK, TORQUE_UNTURNED = 0, 1, 2, 3, 4
# What is kept from step to step: as it is, rounded to single precision, or with all of it that rounding can do alike.
AS_IT_IS, ROUNDED, BIASED = 0, 1, 2


class Laws(NamedTuple):
    """What moves the body, as the program has it.

    moments [kg m2]; forces: of the scene; damping: a = -(d0 + d1 |v|) v and alpha = -(d2 + d3 |w|) w - d4 I^-1 w [1/s,
    1/m, 1/s, 1, N m s]; brakes: the same along axes, of v along the world's, of w along the body's and the world's
    [1/s]; gyroscopic: 1 right, 0 left out, -1 of the wrong sign; damps, decays, mixed, tensor, held, levers: of the
    constants above; struck: tensor of impulses; first: q at the start; turning: q' = turning q w~ / 2; caps: of |v|
    [m/s] and |w| [rad/s]; arm: sign, share of x and a point [m], for a lever arm sign (r - share x - point);
    strikes_in_body: impulses are meant in body axes.
    """

    moments: Vector
    forces: Forces
    damping: tuple[float, float, float, float, float]
    brakes: tuple[Vector, Vector, Vector]
    damps: int
    decays: int
    gyroscopic: float
    mixed: int
    tensor: int
    struck: int
    first: Quaternion
    turning: float
    caps: tuple[float, float]
    arm: tuple[float, float, float, float, float]
    held: int
    levers: int
    strikes_in_body: bool


class Scheme(NamedTuple):
    """What is done in a step: its length [s], of a smooth flight the turn in one [rad]; then the constants above.

    semi: the angular velocity first, and the attitude with the new one; fall: positions with the old velocity, 0, the
    new one, 1, or their mean; normalises: q every so many steps, 0 for never; idle: gravity acts from the step after so
    many; keeps: from step to step, of the constants above.
    """

    step: float
    attitude: int
    spin: int
    semi: bool
    fall: float
    normalises: int = 1
    idle: int = 0
    keeps: int = AS_IT_IS


class Push(NamedTuple):
    """Forces that last: how many act, their sum [N], and their torque [N m] about x, world axes.

    It is torque - x x drawn + (R a) x F summed over forces F with an arm a in body axes, of which rows are the sums
    a_k F [N m].
    """

    acting: int
    force: Vector
    torque: Vector
    drawn: Vector
    rows: tuple[Vector, Vector, Vector]


class Motion(NamedTuple):
    """x [m], q, v [m/s], world axes; w [rad/s], body axes."""

    x: Vector
    q: Quaternion
    v: Vector
    w_body: Vector
