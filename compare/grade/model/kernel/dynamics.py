"""The dynamics of a program with mistakes: what moves the body, what a step does, what acts, and the motion.

The solver's own methods are exact but for their steps.  Here every term has a switch, so that a mistake is a number and
one compiled kernel simulates them all.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tumble.solver.forces import Forces
from tumble.solver.quaternion import Quaternion
from tumble.solver.vectors import Vector

Array = NDArray[np.float64]

# Columns of an event: time [s], kind, linear impulse or force, the same for the rotation, point, whether the point is
# in body axes; then, of a force, its lever and the row in which it began.
EVENT = 16
JUMP, BEGIN, END = 0.0, 1.0, 2.0
# Update of the attitude.  SMOOTH: none, the run is continuous; MATRIX: R to first order, never orthonormalised;
# RUNGE_KUTTA: the whole state is stepped, by the method in `spin`.  The others rotate by a vector t of length a: by the
# angle a; by q + q t~ / 2, an angle of 2 atan(a/2); by two terms of the exponential series; by 2 asin(a/2); by atan(a),
# the polar decomposition of (1 + [t]) R; by Gram-Schmidt from its columns; about x, then y, then z of the world.
SMOOTH, QUATERNION, EXPONENTIAL, MATRIX, RUNGE_KUTTA = 0, 1, 2, 3, 4
SECOND_ORDER, HALF_ANGLE, TANGENT, GRAM_SCHMIDT, AXIS_BY_AXIS = 5, 6, 7, 8, 9
# Methods that evaluate the rates of change several times: the midpoint rule, Kutta's of order 3, the classical one;
# Heun's, velocity Verlet, Ralston's of order 2, Shu and Osher's of order 3, the three-eighths rule.
ORDER_2, ORDER_3, ORDER_4, HEUN, VERLET, RALSTON, SHU_OSHER, THREE_EIGHTHS = 2, 3, 4, 5, 6, 7, 8, 9
# Update of the angular velocity by the gyroscopic term: explicit; one Newton step of implicit Euler; explicit with |L|
# rescaled; (I - dt [L]) w' = L; implicit midpoint rule, with the attitude rotated by the mean of the old w and the new,
# or by the new one; explicit with the energy rescaled; implicit Euler, converged; Heun's; the classical Runge-Kutta.
EXPLICIT, IMPLICIT, RESCALED, BACKWARD, MIDPOINT = 0, 2, 4, 5, 6
MIDPOINT_BY_NEW, ENERGY_KEPT, CONVERGED, HEUN_SPIN, ORDER_4_SPIN = 7, 8, 9, 10, 11
# What a program stores of the rotation: w in body axes, w in world axes, or L, which needs no gyroscopic term.
IN_BODY, IN_WORLD, MOMENTUM = 0, 1, 2
# Angular velocity that rotates the attitude: the right one; the one in world axes taken as in body axes; the one in
# body axes taken as in world axes.
UNMIXED, MIXED_WORLD, MIXED_BODY = 0, 1, 2
# Lever of a lasting force: the torque stays constant; the point moves with the body; the point is fixed in the world.
TORQUE_STAYS, POINT_MOVES, POINT_STAYS = 0, 1, 2
# Levers in body axes are rotated with the body; not rotated; rotated by the start attitude.
AS_THE_BODY, NOT_TURNED, AS_AT_THE_START = 0, 1, 2
# Place of the damping in a step: with the forces; after them; after the move; before the forces.  Form: v - c dt v,
# v exp(-c dt), or v / (1 + c dt).
AS_FORCE, AFTER_FORCES, LAST, BEFORE_FORCES = 0, 1, 2, 3
LINEARLY, EXPONENTIALLY, IMPLICITLY = 0, 1, 2
# Inertia tensor: R I R^T; I; R0 I R0^T; R^T I R.  For impulses also R I, if the torque is taken in body axes.
TURNED, NEVER_TURNED, FROZEN, TURNED_BACK, TORQUE_UNTURNED = 0, 1, 2, 3, 4
# Velocity of the centre that is stored: in world axes; in body axes, with -w x v from the step's start; the same, and x
# moves along the screw of w and v, as on SE(3).
IN_WORLD_AXES, IN_BODY_AXES, ALONG_SCREW = 0, 1, 2
# Precision of the stored state: double; rounded to single; biased by as much as rounding can be.
DOUBLE, ROUNDED, BIASED = 0, 1, 2


class Dynamics(NamedTuple):
    """What moves the body in a program.

    moments [kg m2]; forces: of the scene; damping: a = -(d0 + d1 |v|) v and alpha = -(d2 + d3 |w|) w - d4 I^-1 w [1/s,
    1/m, 1/s, 1, N m s]; axis_damping: the same along single axes, of v along the world's, of w along the body's and the
    world's [1/s]; gyroscopic: factor on the gyroscopic term, 1 if right; damping_place, damping_form, frame_mixup,
    tensor, lever_motion, lever_axes: constants above; impulse_tensor: tensor for impulses; first: q at the start;
    file_axes: rotation from the scene file's axes of the body, which a program has, to the principal ones here;
    attitude_rate_factor: f in q' = f q w~ / 2; caps: of |v| [m/s] and |w| [rad/s]; caps_when_set: velocities are
    limited when they are set, too; lever: sign, share of x and a point [m], for a lever sign (r - share x - point);
    impulse_in_body_axes: impulses are in body axes.
    """

    moments: Vector
    forces: Forces
    damping: tuple[float, float, float, float, float]
    axis_damping: tuple[Vector, Vector, Vector]
    damping_place: int
    damping_form: int
    gyroscopic: float
    frame_mixup: int
    tensor: int
    impulse_tensor: int
    first: Quaternion
    file_axes: Quaternion
    attitude_rate_factor: float
    caps: tuple[float, float]
    caps_when_set: bool
    lever: tuple[float, float, float, float, float]
    lever_motion: int
    lever_axes: int
    impulse_in_body_axes: bool


class Scheme(NamedTuple):
    """One step: its length [s], or the rotation in a continuous step [rad]; then constants above.

    symplectic: w is stepped first and rotates the attitude; position_weight: of the new velocity in the update of x,
    0 to 1; normalise_every: steps between normalisations of q, 0 for never; idle_steps: steps before gravity acts;
    precision: of the stored state; velocity_axes: of the stored velocity of the centre; stored: of the rotation;
    recovers: w is taken from the attitudes before and after a step, as position-based dynamics does.
    """

    step: float
    attitude: int
    spin: int
    symplectic: bool
    position_weight: float
    normalise_every: int = 1
    idle_steps: int = 0
    precision: int = DOUBLE
    velocity_axes: int = IN_WORLD_AXES
    stored: int = IN_BODY
    recovers: bool = False


class Push(NamedTuple):
    """Lasting forces: their number, their sum [N], and their torque [N m] about x, world axes.

    The torque is torque - x x drawn + (R a) x F summed over forces F with a lever a in body axes, of which rows are the
    sums a_k F [N m].
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
