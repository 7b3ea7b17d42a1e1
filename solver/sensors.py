"""What sensors fixed to a body read in a state: specific force and angular velocity, from the equations of motion."""

import numpy as np
from numpy.typing import NDArray

from tumble.solver.body import momentum_rate
from tumble.solver.compilation import inner, kernel
from tumble.solver.forces import NOTHING, Forces, wrench
from tumble.solver.quaternion import rotate_back
from tumble.solver.vectors import Vector, add, cross, dot, scale, times


@kernel
def readings(
    states: NDArray[np.float64],
    inverse_moments: Vector,
    gyroscopic: Vector | None,
    forces: Forces,
    points: NDArray[np.float64],
    axes: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return specific force and angular velocity of each sensor in each state: F/m + alpha x r + w x (w x r), and w.

    Parameters
    ----------
    states : (N, 13)
        unit quaternions
    inverse_moments : (3,), 1/(kg m2)
    gyroscopic : (3,), 1/(kg m2)
        as `tumble.solver.body.Body.gyroscopic`
    forces
        without gravity, which no accelerometer feels
    points : (S, 3), m
        body axes
    axes : (S, 3, 3)
        rows are a sensor's axes, along the body's

    Returns
    -------
    readings : (N, S, 6), m/s2 and rad/s
        along the sensors' axes

    Notes
    -----
    Source: IEEE Std 528 (specific force); Goldstein, "Classical Mechanics" (1980), eqs. 4-107 and 5-39.
    """
    found = np.empty((len(states), len(points), 6))
    for row in range(len(states)):
        x = (states[row, 0], states[row, 1], states[row, 2])
        q = (states[row, 3], states[row, 4], states[row, 5], states[row, 6])
        v = (states[row, 7], states[row, 8], states[row, 9])
        w = rotate_back(q, (states[row, 10], states[row, 11], states[row, 12]))
        force, torque = wrench(x, q, v, w, forces)
        centre = scale(1.0 / forces.mass, rotate_back(q, force))
        momentum = (w[0] / inverse_moments[0], w[1] / inverse_moments[1], w[2] / inverse_moments[2])
        alpha = times(inverse_moments, add(_gyroscopic_torque(momentum, gyroscopic), torque))
        for sensor in range(len(points)):
            r = (points[sensor, 0], points[sensor, 1], points[sensor, 2])
            felt = add(centre, add(cross(alpha, r), cross(w, cross(w, r))))
            for axis in range(3):
                own = (axes[sensor, axis, 0], axes[sensor, axis, 1], axes[sensor, axis, 2])
                found[row, sensor, axis] = dot(own, felt)
                found[row, sensor, 3 + axis] = dot(own, w)
    return found


@inner
def _gyroscopic_torque(momentum: Vector, gyroscopic: Vector | None) -> Vector:
    """Return L x w [N m], body axes: nothing for equal moments."""
    if gyroscopic is None:
        return NOTHING
    return momentum_rate(momentum, gyroscopic)
