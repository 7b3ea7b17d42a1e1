"""How a step turns the attitude: q, the turn w dt in world axes [rad] -> q, and whether it needs to be normalised."""

import math
from collections.abc import Callable

from tools.random_programs.algebra import (
    Quaternion,
    Vector,
    about,
    add,
    cross,
    dot,
    matrix,
    minus,
    norm,
    product,
    scale,
    transposed,
)

Turning = Callable[[Quaternion, Vector], Quaternion]


def exponential(q: Quaternion, turn: Vector) -> Quaternion:
    """By the angle |w| dt."""
    return product(about(turn), q)


def first_order(q: Quaternion, turn: Vector) -> Quaternion:
    """q + w q dt / 2; normalised it is a turn by 2 atan(|w| dt / 2), which is Cayley's as well."""
    return product((type(turn[0])(1.0), *scale(0.5, turn)), q)  # type: ignore[arg-type]


def second_order(q: Quaternion, turn: Vector) -> Quaternion:
    """Two terms of the series: 1 - |w dt|^2 / 8, w dt / 2."""
    return product((1 - dot(turn, turn) / 8, *scale(0.5, turn)), q)  # type: ignore[arg-type]


def half_angle(q: Quaternion, turn: Vector) -> Quaternion:
    """sin(a) = a for the vector, and the scalar that makes its length 1: a turn by 2 asin(|w| dt / 2)."""
    size = norm(turn)
    return product(about(turn, 2 * math.asin(min(1.0, size / 2))), q)


def tangent(q: Quaternion, turn: Vector) -> Quaternion:
    """(I + dt [w]) R made a rotation again by its polar decomposition: a turn by atan(|w| dt)."""
    return product(about(turn, math.atan(norm(turn))), q)


def gram_schmidt(q: Quaternion, turn: Vector) -> Quaternion:
    """R + dt [w] R, its columns made orthonormal again, the first first."""
    x, y, z = (add(column, cross(turn, column)) for column in transposed(matrix(q)))
    x = scale(1 / norm(x), x)
    y = minus(y, scale(dot(x, y), x))
    y = scale(1 / norm(y), y)
    z = cross(x, y)
    return _quaternion(x, y, z)


def _quaternion(x: Vector, y: Vector, z: Vector) -> Quaternion:
    """Return the quaternion of a rotation whose columns are x, y, z."""
    trace = x[0] + y[1] + z[2]
    number = type(trace)
    if trace > 0:
        s = number(math.sqrt(trace + 1)) * 2
        return (s / 4, (y[2] - z[1]) / s, (z[0] - x[2]) / s, (x[1] - y[0]) / s)
    if x[0] >= y[1] and x[0] >= z[2]:
        s = number(math.sqrt(1 + x[0] - y[1] - z[2])) * 2
        return ((y[2] - z[1]) / s, s / 4, (y[0] + x[1]) / s, (z[0] + x[2]) / s)
    if y[1] >= z[2]:
        s = number(math.sqrt(1 + y[1] - x[0] - z[2])) * 2
        return ((z[0] - x[2]) / s, (y[0] + x[1]) / s, s / 4, (z[1] + y[2]) / s)
    s = number(math.sqrt(1 + z[2] - x[0] - y[1])) * 2
    return ((x[1] - y[0]) / s, (z[0] + x[2]) / s, (z[1] + y[2]) / s, s / 4)


def axis_by_axis(q: Quaternion, turn: Vector) -> Quaternion:
    """Three turns one after the other, about x, y and z."""
    zero = 0 * turn[0]
    for axis in ((turn[0], zero, zero), (zero, turn[1], zero), (zero, zero, turn[2])):
        q = product(about(axis), q)
    return q


TURNINGS: dict[str, Turning] = {
    "exponential": exponential,
    "first order": first_order,
    "second order": second_order,
    "half angle": half_angle,
    "tangent": tangent,
    "Gram-Schmidt": gram_schmidt,
    "axis by axis": axis_by_axis,
}
