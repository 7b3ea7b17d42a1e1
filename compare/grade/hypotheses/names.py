"""Names of mistakes: those that several modules use, and those that format 3 of the tables renamed.

A name is lower-case words joined by hyphens.  It is an identifier for scripts and changes only with the format.
"""

BODY_NEVER_MOVES = "body-never-moves"
CLOCK_OFFSET, CLOCK_RATE, LOG_LAG = "clock-offset", "clock-rate", "log-lag"
EXPLICIT_EULER = "explicit-euler"
EXTRAPOLATED_ROWS, INTERPOLATED_ROWS = "extrapolated-rows", "interpolated-rows"
FLOOR_AT_ZERO = "floor-at-zero"
GRAVITY_DELAYED, GRAVITY_SIZE = "gravity-delayed", "gravity-wrong-magnitude"
GYROSCOPIC_TERM_MISSING = "gyroscopic-term-missing"
IMPULSE_OVER_ONE_STEP = "impulse-as-force-over-one-step"
NEVER_NORMALISED, RARELY_NORMALISED = "quaternion-never-normalised", "quaternion-rarely-normalised"
LINEAR_DAMPING, ANGULAR_DAMPING, PYBULLET_DAMPING = "linear-damping", "angular-damping", "pybullet-default-damping"
RUNGE_KUTTA_4 = "runge-kutta-4"
SPIN_CAP = "spin-cap"
SPIN_RECOVERED = "spin-from-attitude-difference"
SYMPLECTIC_EULER = "symplectic-euler"
VELOCITY_IN_BODY_AXES = "velocity-in-body-axes"
# What is written between ticks, of which no digits show single precision.
BETWEEN_TICKS = {INTERPOLATED_ROWS, EXTRAPOLATED_ROWS}

# Name in format 2 -> name in format 3; other names are the same in both.
RENAMED_MISTAKES = {
    "angular-damping-about-the-bodys-x": "angular-damping-about-body-x",
    "angular-damping-about-the-bodys-y": "angular-damping-about-body-y",
    "angular-damping-about-the-bodys-z": "angular-damping-about-body-z",
    "angular-damping-about-x": "angular-damping-about-world-x",
    "angular-damping-about-y": "angular-damping-about-world-y",
    "angular-damping-about-z": "angular-damping-about-world-z",
    "angular-velocity-in-the-wrong-frame": "angular-velocity-in-wrong-frame",
    "another-inertia": "wrong-inertia",
    "another-mass": "wrong-mass",
    "another-point-logged": "wrong-point-logged",
    "another-size": "wrong-body-size",
    "another-size-along-x": "wrong-body-size-along-x",
    "another-size-along-y": "wrong-body-size-along-y",
    "another-size-along-z": "wrong-body-size-along-z",
    "another-start-attitude": "wrong-start-attitude",
    "another-start-position": "wrong-start-position",
    "another-start-velocity": "wrong-start-velocity",
    "another-step-of-x": "wrong-position-update",
    "another-unit-of-length": "wrong-length-unit",
    "conjugate": "attitude-inverted",
    "damping-as-PyBullets-default": PYBULLET_DAMPING,
    "degrees-for-radians": "start-spin-read-as-degrees",
    "edges-in-another-order": "edges-permuted",
    "explicit-Euler": "explicit-euler",
    "gravity-along-another-axis": "gravity-along-wrong-axis",
    "gravity-late": GRAVITY_DELAYED,
    "gravity-of-another-size": "gravity-wrong-magnitude",
    "half-of-q-missing": "quaternion-rate-doubled",
    "half-of-q-twice": "quaternion-rate-halved",
    "Heuns-method": "heun",
    "impulse-as-force-over-a-step": IMPULSE_OVER_ONE_STEP,
    "impulse-as-force-without-end": "impulse-as-permanent-force",
    "impulse-at-another-time": "impulse-at-wrong-time",
    "impulse-at-another-vertex": "impulse-at-wrong-vertex",
    "impulse-at-the-centre": "impulse-at-centre-of-mass",
    "impulse-lever-as-at-the-start": "impulse-lever-from-start-attitude",
    "impulse-lever-not-turned": "impulse-lever-not-rotated",
    "impulse-moves-as-force": "impulse-linear-part-as-force",
    "impulse-of-another-size": "impulse-wrong-magnitude",
    "impulse-only-turns": "impulse-linear-part-missing",
    "impulse-point-from-the-origin": "impulse-lever-from-origin",
    "impulse-point-not-moved": "impulse-lever-from-start-position",
    "impulses-of-unit-length": "impulses-normalised",
    "inertia-frozen-at-the-start": "inertia-frozen-at-start",
    "inertia-frozen-in-the-impulse": "impulse-inertia-frozen-at-start",
    "inertia-never-turned": "inertia-never-rotated",
    "inertia-not-turned-in-the-impulse": "impulse-inertia-not-rotated",
    "inertia-of-a-sphere": "spherical-inertia",
    "inertia-of-permuted-axes": "inertia-axes-permuted",
    "inertia-turned-the-wrong-way": "inertia-rotated-inversely",
    "inertia-turned-the-wrong-way-in-the-impulse": "impulse-inertia-rotated-inversely",
    "inverse-for-inertia": "inertia-inverted",
    "mass-left-out": "mass-missing",
    "matrix-Euler": "matrix-euler",
    "midpoint-method": "midpoint",
    "never-moves": BODY_NEVER_MOVES,
    "normalised-rarely": "quaternion-rarely-normalised",
    "not-normalised": "quaternion-never-normalised",
    "one-impulse-at-another-vertex": "one-impulse-at-wrong-vertex",
    "one-impulse-at-the-centre": "one-impulse-at-centre-of-mass",
    "one-impulse-lever-as-at-the-start": "one-impulse-lever-from-start-attitude",
    "one-impulse-lever-not-turned": "one-impulse-lever-not-rotated",
    "one-impulse-of-another-size": "one-impulse-wrong-magnitude",
    "one-impulse-point-from-the-origin": "one-impulse-lever-from-origin",
    "only-the-attitude-in-other-axes": "attitude-only-in-wrong-axes",
    "only-the-centre-in-other-axes": "position-only-in-wrong-axes",
    "other-axes": "wrong-axes",
    "other-body-axes": "wrong-body-axes",
    "quadratic-spin-drag": "quadratic-angular-drag",
    "quaternion-order": "quaternion-xyzw-read-as-wxyz",
    "quaternion-order-reversed": "quaternion-wxyz-read-as-xyzw",
    "quaternions-vector-mirrored": "quaternion-vector-mirrored",
    "radians-for-degrees": "start-spin-converted-to-degrees",
    "Runge-Kutta-of-order-3": "runge-kutta-3",
    "Runge-Kutta-of-order-4": "runge-kutta-4",
    "start-attitude-in-other-axes": "start-attitude-in-wrong-axes",
    "start-spin-in-other-axes": "start-spin-in-wrong-axes",
    "start-spin-turned-back": "start-spin-rotated-to-body-axes",
    "start-velocity-in-other-axes": "start-velocity-in-wrong-axes",
    "start-velocity-turned-back": "start-velocity-rotated-to-body-axes",
    "starts-spin-in-body-axes": "start-spin-in-body-axes",
    "stops": "body-stops",
    "symplectic-Euler": SYMPLECTIC_EULER,
    "turned-about-the-origin": "rotation-about-origin",
    "turning-axes": "rotating-axes",
    "velocity-Verlet": "velocity-verlet",
}
RENAMED_PARAMETERS = {"damping law": "damping-form", "damps": "damping-place"}
