"""The equations of motion under forces, once for every method that carries them, and the row in which a throw waits.

A state is x [m], q, v [m/s], L_body [kg m2/s]; x and v in world axes, q of any length.  Of a body that never turns q,
L_body and inverse_moments are None, and the compiler leaves six numbers to integrate.  Slopes of a state are laid out
as the state is, and all of it takes complex numbers.
"""

# Rotation is absent as a whole, which pyright cannot know: where q is not None neither is L or w.
# pyright: reportArgumentType=false

from typing import Any

import numpy as np
from numba import types
from numba.extending import overload
from numpy.typing import NDArray

from tumble.solver.body import momentum_rate
from tumble.solver.compilation import OPTIONS, borrowing, inlined
from tumble.solver.forces import NOTHING, Forces, wrench
from tumble.solver.quaternion import Quaternion, plus, product_vector, stretch
from tumble.solver.vectors import Vector, add, scale, times

State = tuple[Vector, Quaternion | None, Vector, Vector | None]


@inlined
def slope(state: State, inverse_moments: Vector | None, gyroscopic: Vector | None, forces: Forces) -> State:
    """Return dx/dt = v, dq/dt = q w~/2, dv/dt = F/m and dL/dt = L x w + tau, the last in body axes.

    Source: Goldstein, "Classical Mechanics" (1980), eqs. 1-3 and 5-39; Sola, "Quaternion kinematics for the error-state
    Kalman filter" (2017), section 1.5.
    """
    x, q, v, l_body = state
    w_body = spin(l_body, inverse_moments)
    force, torque = wrench(x, q, v, w_body, forces)
    return v, _turning(q, w_body), scale(1.0 / forces.mass, force), _twisting(l_body, gyroscopic, torque)


@inlined
def free_slope(state: State, inverse_moments: Vector | None, gyroscopic: Vector | None) -> State:
    """Return the slope where nothing acts."""
    _, q, v, l_body = state
    return v, _turning(q, spin(l_body, inverse_moments)), NOTHING, _twisting(l_body, gyroscopic, NOTHING)


@borrowing
def plus_times(a: State, factor: float, b: State) -> State:
    """Return a + factor b, of states or of their slopes."""
    return (
        add(a[0], scale(factor, b[0])),
        _plus_times_quaternion(a[1], factor, b[1]),
        add(a[2], scale(factor, b[2])),
        _plus_times_vector(a[3], factor, b[3]),
    )


@borrowing
def times_state(factor: float, a: State) -> State:
    """Return factor a, of a state or of its slopes."""
    return scale(factor, a[0]), _stretched(factor, a[1]), scale(factor, a[2]), _scaled(factor, a[3])


@borrowing
def load(row: NDArray[np.float64], inverse_moments: Vector | None) -> State:
    """Return the state of a row x, q, v, L_body, (13,)."""
    return (
        (row[0], row[1], row[2]),
        _if_turning((row[3], row[4], row[5], row[6]), inverse_moments),
        (row[7], row[8], row[9]),
        _if_turning((row[10], row[11], row[12]), inverse_moments),
    )


@borrowing
def store(row: NDArray[np.float64], state: State) -> None:
    """Write a state into a row, (13,); of a body that never turns its position and velocity alone."""
    x, q, v, l_body = state
    row[0], row[1], row[2] = x
    row[7], row[8], row[9] = v
    _store_rotation(row, q, l_body)


@borrowing
def spin(l_body: Vector | None, inverse_moments: Vector | None) -> Vector | None:
    """Return w = I^-1 L [rad/s], body axes."""
    if l_body is None:
        return l_body
    return times(inverse_moments, l_body)


@borrowing
def _turning(q: Quaternion | None, w_body: Vector | None) -> Quaternion | None:
    """Return dq/dt = q w~/2."""
    if q is None:
        return q
    return product_vector(q, scale(0.5, w_body))


@borrowing
def _twisting(l_body: Vector | None, gyroscopic: Vector | None, torque: Vector) -> Vector | None:
    """Return dL/dt = L x w + tau [N m], body axes."""
    if l_body is None:
        return l_body
    return add(_gyroscopic_torque(l_body, gyroscopic), torque)


@borrowing
def _gyroscopic_torque(l_body: Vector, gyroscopic: Vector | None) -> Vector:
    """Return L x w [N m], body axes: nothing for equal moments."""
    if gyroscopic is None:
        return NOTHING
    return momentum_rate(l_body, gyroscopic)


@borrowing
def _plus_times_vector(a: Vector | None, factor: float, b: Vector | None) -> Vector | None:
    if a is None:
        return a
    return add(a, scale(factor, b))


@borrowing
def _plus_times_quaternion(a: Quaternion | None, factor: float, b: Quaternion | None) -> Quaternion | None:
    if a is None:
        return a
    return plus(a, stretch(factor, b))


@borrowing
def _scaled(factor: float, a: Vector | None) -> Vector | None:
    if a is None:
        return a
    return scale(factor, a)


@borrowing
def _stretched(factor: float, a: Quaternion | None) -> Quaternion | None:
    if a is None:
        return a
    return stretch(factor, a)


@borrowing
def _store_rotation(row: NDArray[np.float64], q: Quaternion | None, l_body: Vector | None) -> None:
    if q is not None and l_body is not None:
        row[3], row[4], row[5], row[6] = q
        row[10], row[11], row[12] = l_body


def _if_turning(value: Any, inverse_moments: Vector | None) -> Any:
    """Return the value, or None for a body that never turns."""
    return None if inverse_moments is None else value


@overload(_if_turning, jit_options=OPTIONS, strict=False)
def _if_turning_by_type(value: types.Type, inverse_moments: types.Type) -> Any:
    """Choose when compiling, by the type: a branch on None would leave a value that may be either."""
    if isinstance(inverse_moments, types.NoneType):
        return lambda value, inverse_moments: None
    return lambda value, inverse_moments: value
