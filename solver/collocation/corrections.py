"""The linear equations of a correction of the slopes, reduced to those of velocity and angular momentum.

In an eigenvector of a method's coefficients a step multiplies slopes by a number h, real in one and complex in the two
others, and the correction k of slopes that miss r is asked (1 - h J) k = r, J the Jacobian of the equations of motion.
Of these x' = v and q' = q w~/2 are resolved by hand,

    kx = rx + h kv,   kq = (rq + h/2 q (I^-1 kL)~) s,   s = (1 - h/2 w~)^-1 = (1 + h/2 w~) / (1 + |h w|^2/4),

and six equations are left, or three of a body that never turns.
Source: Hairer & Wanner, "Solving Ordinary Differential Equations II" (1996), section IV.8; for x' = v already eq. 8.17.
"""

# The pair of eigenvalues is complex, in functions that are written for real numbers.
# pyright: reportArgumentType=false

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tumble.solver.compilation import borrowing
from tumble.solver.linear import factorise, substitute
from tumble.solver.quaternion import Quaternion, plus, product, product_vector
from tumble.solver.vectors import Vector, dot, scale, times

Array = NDArray[np.float64]
Numbers = NDArray[np.float64] | NDArray[np.complex128]
Order = NDArray[np.int64]


class Reduced(NamedTuple):
    """The equations for one h, in their LU factors, (m, m); s, (4,); and room for the two sides, (13,) and (m,)."""

    matrix: Numbers
    order: Order
    s: Numbers
    sides: Numbers
    rest: Numbers


@borrowing
def put_reduced(found: Reduced, h: complex, jacobian: Array, middle: Array, inverse_moments: Vector | None) -> None:
    """Put the equations in their factors; jacobian: the rows of v and L, (m, 13), at the state middle, (13,)."""
    for r in range(len(jacobian)):
        for c in range(3):
            found.matrix[r, c] = -h * (jacobian[r, 7 + c] + h * jacobian[r, c])
    _put_turning(found, h, jacobian, middle, inverse_moments)
    for r in range(len(jacobian)):
        found.matrix[r, r] += 1.0
    factorise(found.matrix, found.order)


@borrowing
def _put_turning(found: Reduced, h: complex, jacobian: Array, middle: Array, inverse_moments: Vector | None) -> None:
    if inverse_moments is None:
        return
    u = scale(0.5 * h, times(inverse_moments, (middle[10], middle[11], middle[12])))
    per = 1.0 / (1.0 + dot(u, u))
    found.s[0], found.s[1], found.s[2], found.s[3] = per, per * u[0], per * u[1], per * u[2]
    for c in range(3):
        unit = (1.0 if c == 0 else 0.0, 1.0 if c == 1 else 0.0, 1.0 if c == 2 else 0.0)
        turn = _turned_by(found, h, middle, times(inverse_moments, unit))
        for r in range(6):
            change = jacobian[r, 10 + c] + jacobian[r, 3] * turn[0]
            change += jacobian[r, 4] * turn[1] + jacobian[r, 5] * turn[2] + jacobian[r, 6] * turn[3]
            found.matrix[r, 3 + c] = -h * change


@borrowing
def _turned_by(found: Reduced, h: complex, middle: Array, spin: Vector) -> Quaternion:
    """Return h/2 q spin~ s."""
    q = (middle[3], middle[4], middle[5], middle[6])
    return product(product_vector(q, scale(0.5 * h, spin)), _s(found))


@borrowing
def _s(found: Reduced) -> Quaternion:
    return found.s[0], found.s[1], found.s[2], found.s[3]


@borrowing
def resolve(found: Reduced, h: complex, jacobian: Array, middle: Array, inverse_moments: Vector | None) -> None:
    """Replace r, in found.sides, by k."""
    sides, rest = found.sides, found.rest
    for r in range(len(jacobian)):
        change = jacobian[r, 0] * sides[0] + jacobian[r, 1] * sides[1] + jacobian[r, 2] * sides[2]
        rest[r] = sides[7 + r] + h * change
    _put_turned_side(found, h, jacobian, inverse_moments)
    substitute(found.matrix, found.order, rest)
    for c in range(3):
        sides[c] += h * rest[c]
        sides[7 + c] = rest[c]
    _put_turns(found, h, middle, inverse_moments)


@borrowing
def _put_turned_side(found: Reduced, h: complex, jacobian: Array, inverse_moments: Vector | None) -> None:
    """Replace rq by rq s, and add what it does to the forces."""
    if inverse_moments is None:
        return
    sides = found.sides
    turned = product((sides[3], sides[4], sides[5], sides[6]), _s(found))
    sides[3], sides[4], sides[5], sides[6] = turned
    for r in range(6):
        change = jacobian[r, 3] * turned[0] + jacobian[r, 4] * turned[1]
        found.rest[r] += h * (change + jacobian[r, 5] * turned[2] + jacobian[r, 6] * turned[3])


@borrowing
def _put_turns(found: Reduced, h: complex, middle: Array, inverse_moments: Vector | None) -> None:
    """Add to rq s what kL makes of it, and put kL."""
    if inverse_moments is None:
        return
    sides, rest = found.sides, found.rest
    turn = _turned_by(found, h, middle, times(inverse_moments, (rest[3], rest[4], rest[5])))
    sides[3], sides[4], sides[5], sides[6] = plus((sides[3], sides[4], sides[5], sides[6]), turn)
    for c in range(3):
        sides[10 + c] = rest[3 + c]
