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

# Fields of `Forces` that a row of `kernel.parameters` gives. A force after them, registered from outside, has the
# numbers of the forces that are passed beside the rows, or none.
IN_ROW = Forces._fields.index("points") + 1
NO_OTHERS = (None,) * (len(Forces._fields) - IN_ROW)

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
# The quaternion q of a stage of these methods is not of unit length.  R is of q/|q|, but q' of q; both are of q/|q|;
# both are of q, R by the formula 1 - 2(yy + zz) ..., with the inverse of R I R^T; the same, with R I^-1 R^T for it.
ROTATES_BY_UNIT, OF_UNIT, RAW, RAW_INVERSE = 0, 1, 2, 3
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
# Levers in body axes are rotated with the body; not rotated; rotated by the start attitude; of a tether, also from the
# world's origin; none.
AS_THE_BODY, NOT_TURNED, AS_AT_THE_START, FROM_ORIGIN, NO_LEVER = 0, 1, 2, 3, 4
# Place of the damping in a step: with the forces; after them; after the move; before the forces.  Form: v - c dt v,
# v exp(-c dt), or v / (1 + c dt).
AS_FORCE, AFTER_FORCES, LAST, BEFORE_FORCES = 0, 1, 2, 3
LINEARLY, EXPONENTIALLY, IMPLICITLY = 0, 1, 2
# Inertia tensor: R I R^T; I; R0 I R0^T; R^T I R.  Other mistakes of what torques are divided by: the torque is taken in
# body axes, R I^-1 torque; the change of w is, I^-1 R^T torque; it is the torque; it is
# R I R^T torque; it is the torque over the mass, or over the mean moment.
TURNED, NEVER_TURNED, FROZEN, TURNED_BACK, TORQUE_UNTURNED = 0, 1, 2, 3, 4
RESPONSE_UNTURNED, UNDIVIDED, MULTIPLIED, OVER_MASS, OVER_MEAN = 5, 6, 7, 8, 9
# Axes of impulses: the world; the body, R J; the world turned into the body's, R^T J.
AXES_OF_WORLD, AXES_OF_BODY, AXES_TURNED_BACK = 0, 1, 2
# Velocity of the centre that is stored: in world axes; in body axes, with -w x v from the step's start; the same, and x
# moves along the screw of w and v, as on SE(3).
IN_WORLD_AXES, IN_BODY_AXES, ALONG_SCREW = 0, 1, 2
# Where velocities are limited: after the forces of a step; there, and before the forces; only before the forces; after
# a step has moved the body.
CAP_FORCED, CAP_WHEN_SET, CAP_BEFORE, CAP_MOVED = 0, 1, 2, 3
# Where the height of the centre is limited: after a step; before the next one, so that a row has what a step has left.
FLOOR_AFTER, FLOOR_BEFORE = 0, 1
# Precision of the stored state: double; rounded to single, w in world axes; rounded after each half of a step's change,
# as by half kicks, w in body axes; w biased in each component, or in its size, by as much as rounding can be.
DOUBLE, ROUNDED, ROUNDED_TWICE, BIASED, SCALED = 0, 1, 2, 3, 4


class TetherLaw(NamedTuple):
    """How a program computes the tethers of a scene; by default as the scene does.

    lever, torque_lever: of the point in the spring, and in the torque: constants above; damps_centre: the damper takes
    the velocity of the centre of mass; other_damper: along the line if the scene's damper is not, and the reverse;
    pulls_only: no force at less than the rest length; moves: factor on the force that moves the centre.
    """

    lever: int = AS_THE_BODY
    torque_lever: int = AS_THE_BODY
    damps_centre: bool = False
    other_damper: bool = False
    pulls_only: bool = False
    moves: float = 1.0


class Dynamics(NamedTuple):
    """What moves the body in a program.

    moments [kg m2]; forces: of the scene, but for its floor; floor: alone; damping: a = -(d0 + d1 |v|) v and alpha =
    -(d2 + d3 |w|) w - d4 I^-1 w [1/s, 1/m, 1/s, 1, N m s]; drag: a = -(c0 / |v| + c1 |v|^2) v - c2 (|vx| vx, |vy| vy,
    |vz| vz) and alpha = -c3 w / |w| [m/s2, s/m2, 1/m, rad/s2]; other_drag: of the scene, force -e0 |v| v, torque -e1
    |w| w, alpha = -e2 w [N s2/m2, N m s2, 1/s]; tether_law, tethers: rows as in `solver.forces`, that obey it if it is
    another than the scene's; axis_damping: damping along single axes, of v along the world's, of w along the body's and
    the world's [1/s]; swirl: factor c in a = c w x v; gravity_in_body: gravity is in body axes; gyroscopic: factor on
    the gyroscopic term, 1 if right; damping_place, damping_form, frame_mixup, lever_motion, lever_axes, cap_place,
    floor_place: constants above; tensor: of L; inverse_tensor, impulse_tensor: those that torques and impulses are
    divided by; first: q at the start; file_axes: rotation from the scene file's axes of the body, which a program has,
    to the principal ones here; attitude_rate_factor: f in q' = f q w~ / 2; caps: of |v| [m/s] and |w| [rad/s];
    component_caps: of each component, world axes; lever: sign, share of x and a point [m], for a lever sign (r - share
    x - point); impulse_axes: of impulses; impulse_sets: an impulse sets the velocities, and adds nothing to them; up:
    unit vector along which the centre is at no negative height, 0 for no such floor; bounce: share of the velocity
    along it that is left, reversed; thresholds: of |v| [m/s] and |w| [rad/s], below which they are set to 0 after a
    step; is_usual: none of drag, swirl, gravity_in_body, up, other_drag, tether_law and thresholds has an effect;
    is_capped: one of the caps may have one; has_other_tethers: tether_law is another than the scene's; is_pulled: a
    force of the scene acts beside gravity and the floor; has_floor: the scene has one.
    """

    moments: Vector
    forces: Forces
    floor: Forces
    damping: tuple[float, float, float, float, float]
    drag: tuple[float, float, float, float]
    other_drag: tuple[float, float, float]
    tether_law: TetherLaw
    tethers: Array
    axis_damping: tuple[Vector, Vector, Vector]
    swirl: float
    gravity_in_body: bool
    damping_place: int
    damping_form: int
    gyroscopic: float
    frame_mixup: int
    tensor: int
    inverse_tensor: int
    impulse_tensor: int
    first: Quaternion
    file_axes: Quaternion
    attitude_rate_factor: float
    caps: tuple[float, float]
    component_caps: tuple[float, float]
    cap_place: int
    lever: tuple[float, float, float, float, float]
    lever_motion: int
    lever_axes: int
    impulse_axes: int
    impulse_sets: bool
    up: Vector
    bounce: float
    floor_place: int
    thresholds: tuple[float, float]
    is_usual: bool
    is_capped: bool
    has_other_tethers: bool
    is_pulled: bool
    has_floor: bool


class Scheme(NamedTuple):
    """One step: its length [s], or the rotation in a continuous step [rad]; then constants above.

    symplectic: w is stepped first and rotates the attitude; position_weight: of the new velocity in the update of x, 0
    to 1; normalise_every: steps between normalisations of q, 0 for never; is_unit_used: q is normalised where it is
    used; idle_steps: steps before gravity acts; precision: of the stored state; velocity_axes: of the stored velocity
    of the centre; stored: of the rotation; recovers: w is taken from the attitudes before and after a step, as
    position-based dynamics does; stages: of a method that has some, a constant above; rotation: of velocity Verlet, an
    update of the attitude.
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
    is_unit_used: bool = False
    stages: int = ROTATES_BY_UNIT
    rotation: int = EXPONENTIAL


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
