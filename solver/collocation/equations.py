"""What the equations of motion ask of the slopes at the stages of a step, and how that changes with the state."""

# The equations of motion take complex states, and states without rotation, which pyright cannot know.
# pyright: reportArgumentType=false

import numpy as np
from numpy.typing import NDArray

from tumble.solver.collocation.scheme import Scheme
from tumble.solver.compilation import borrowing
from tumble.solver.forces import Forces
from tumble.solver.motion import free_slope, load, slope, store
from tumble.solver.quaternion import Quaternion, conjugate, norm_squared, product, product_vector, stretch
from tumble.solver.vectors import Vector, dot, times

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

# So small that its square is lost in rounding, and with it the error of the derivative.
# Source: Squire & Trapp, "Using complex variables to estimate derivatives of real functions" (1998).
IMAGINARY = 1e-100


@borrowing
def weighted(weights: Array, slopes: Array, a: int) -> float:
    """Return the weighted sum of column a of three rows."""
    return weights[0] * slopes[0, a] + weights[1] * slopes[1, a] + weights[2] * slopes[2, a]


@borrowing
def moves(a: int, inverse_moments: Vector | None) -> bool:
    """Return whether the number a of a state is stepped: of a body that never turns, only those of x and v."""
    return inverse_moments is not None or a < 3 or 7 <= a < 10


@borrowing
def put_jacobian(
    state: Array,
    inverse_moments: Vector | None,
    gyroscopic: Vector | None,
    forces: Forces,
    near: ComplexArray,
    change: ComplexArray,
    jacobian: Array,
) -> None:
    """Put the derivative of dv/dt and dL/dt by the state into jacobian, (3 or 6, 13).

    The derivatives of dx/dt and dq/dt are known: `tumble.solver.collocation.corrections`.
    """
    for a in range(13):
        near[a] = state[a]
    for c in range(13):
        if not moves(c, inverse_moments):
            continue
        near[c] = complex(state[c], IMAGINARY)
        store(change, slope(load(near, inverse_moments), inverse_moments, gyroscopic, forces))
        near[c] = state[c]
        for r in range(len(jacobian)):
            jacobian[r, c] = change[7 + r].imag / IMAGINARY


@borrowing
def put_wanted(
    state: Array,
    slopes: Array,
    stages: Array,
    dt: float,
    method: Scheme,
    inverse_moments: Vector | None,
    gyroscopic: Vector | None,
    forces: Forces,
    here: Array,
    pushes: Array,
    wanted: Array,
) -> float:
    """Put the slopes that the equations of motion ask for at the stages into wanted, (3, 13).

    Returns how rough the power of the forces is [W].
    Velocities are a step's own parabola, positions its integral: so a damper never drives.
    A torque is averaged as what it pushes at q, and a stage turns the mean back: Cohen & Hairer, "Linear
    energy-preserving integrators for Poisson systems" (2011), eq. 3.
    """
    for i in range(3):
        store(wanted[i], free_slope(load(stages[i], inverse_moments), inverse_moments, gyroscopic))
    for i in range(3):
        for a in range(4):
            pushes[i, a] = 0.0
    roughness = 0.0
    for k in range(len(method.means[0])):
        for a in range(7):
            here[a] = state[a] + dt * weighted(method.integrals[k], slopes, a)
        for a in range(7, 13):
            here[a] = weighted(method.values[k], stages, a)
        there = load(here, inverse_moments)
        _, _, acceleration, torque = slope(there, inverse_moments, None, forces)
        for i in range(3):
            for a in range(3):
                wanted[i, 7 + a] += method.means[i, k] * acceleration[a]
        _add_pushes(pushes, method.means, k, there[1], torque)
        power = forces.mass * dot(acceleration, there[2]) + _spin_power(torque, there[3], inverse_moments)
        roughness += method.roughness[k] * power
    _add_torques(wanted, stages, pushes, inverse_moments)
    return roughness


@borrowing
def _spin_power(torque: Vector | None, l_body: Vector | None, inverse_moments: Vector | None) -> float:
    """Return tau . w [W]."""
    if inverse_moments is None:
        return 0.0
    return dot(torque, times(inverse_moments, l_body))


@borrowing
def energy(stages: Array, mass: float, inverse_moments: Vector | None) -> float:
    """Return the mean energy of motion at the stages [J]."""
    mean = 0.0
    for i in range(3):
        _, _, v, l_body = load(stages[i], inverse_moments)
        mean += (mass * dot(v, v) + _spin_power(l_body, l_body, inverse_moments)) / 6.0
    return mean


@borrowing
def _add_pushes(pushes: Array, means: Array, k: int, q: Quaternion | None, torque: Vector | None) -> None:
    """Add a torque at the instant k to what pushes at q, (3, 4): q tau~ / |q|^2."""
    if q is None:
        return
    push = stretch(1.0 / norm_squared(q), product_vector(q, torque))
    for i in range(3):
        for a in range(4):
            pushes[i, a] += means[i, k] * push[a]


@borrowing
def _add_torques(wanted: Array, stages: Array, pushes: Array, inverse_moments: Vector | None) -> None:
    """Add the torque that pushes at the q of a stage to the stage's dL/dt."""
    if inverse_moments is None:
        return
    for i in range(3):
        q, push = (
            (stages[i, 3], stages[i, 4], stages[i, 5], stages[i, 6]),
            (pushes[i, 0], pushes[i, 1], pushes[i, 2], pushes[i, 3]),
        )
        torque = product(conjugate(q), push)
        for a in range(3):
            wanted[i, 10 + a] += torque[1 + a]
