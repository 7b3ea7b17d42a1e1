"""How the equations of motion change with the state: the rows of v and L of their Jacobian, by dual numbers.

They are kept as columns, which are eight numbers: three of the force, one of nothing, three of the torque, and again
one of nothing; and so are the columns themselves in order: three of x or v, three of a turn or L.
"""

# Numbers are dual, and states without rotation, which pyright cannot know.
# pyright: reportArgumentType=false

from typing import NamedTuple

from tumble.solver.collocation.equations import Whole
from tumble.solver.compilation import inlined
from tumble.solver.dual import Dual, dual, parts
from tumble.solver.eight import Eight, eight, transposed, with_lane
from tumble.solver.forces import Forces
from tumble.solver.motion import if_turning, slope
from tumble.solver.quaternion import Quaternion, product_vector
from tumble.solver.vectors import Vector

Columns = tuple[Eight, Eight, Eight, Eight, Eight, Eight, Eight, Eight]


class Changes(NamedTuple):
    """How dv/dt and dL/dt change with x and with a turn, and with v and L, in columns.

    A turn is I^-1 times the number of a column, as L is I times a speed.
    """

    by_place: Columns
    by_speed: Columns


@inlined
def changes_at(
    state: Whole, inverse_moments: Vector | None, gyroscopic: Vector | None, forces: Forces
) -> tuple[Vector, Vector, Changes]:
    """Return dv/dt and dL/dt at a state, and how they change."""
    x, q, v, l_body = state
    there = (
        (_place(x[0], 0), _place(x[1], 1), _place(x[2], 2)),
        if_turning(_turning(q, inverse_moments), inverse_moments),
        (_speed(v[0], 0), _speed(v[1], 1), _speed(v[2], 2)),
        if_turning((_speed(l_body[0], 4), _speed(l_body[1], 5), _speed(l_body[2], 6)), inverse_moments),
    )
    _, _, accelerations, twists = slope(there, inverse_moments, gyroscopic, forces)
    a, b, c = parts(accelerations[0]), parts(accelerations[1]), parts(accelerations[2])
    d, e, f = _twist_parts(twists)
    no = eight(0.0)
    changes = Changes(
        transposed((a[1], b[1], c[1], no, d[1], e[1], f[1], no)),
        transposed((a[2], b[2], c[2], no, d[2], e[2], f[2], no)),
    )
    return (a[0], b[0], c[0]), (d[0], e[0], f[0]), changes


@inlined
def unit(number: int) -> Eight:
    """Return eight numbers of which one is 1 and the others are 0."""
    return with_lane(eight(0.0), number, 1.0)


@inlined
def _place(value: float, number: int) -> Dual:
    return dual(value, unit(number), eight(0.0))


@inlined
def _speed(value: float, number: int) -> Dual:
    return dual(value, eight(0.0), unit(number))


@inlined
def _turning(q: Quaternion, inverse_moments: Vector | None) -> Quaternion:
    """Return q, with what turns by I^-1 about the axes of the body make of it."""
    if inverse_moments is None:
        return q
    a = product_vector(q, (0.5 * inverse_moments[0], 0.0, 0.0))
    b = product_vector(q, (0.0, 0.5 * inverse_moments[1], 0.0))
    c = product_vector(q, (0.0, 0.0, 0.5 * inverse_moments[2]))
    return (
        _turning_number(q[0], a[0], b[0], c[0]),
        _turning_number(q[1], a[1], b[1], c[1]),
        _turning_number(q[2], a[2], b[2], c[2]),
        _turning_number(q[3], a[3], b[3], c[3]),
    )


@inlined
def _turning_number(value: float, a: float, b: float, c: float) -> Dual:
    return dual(value, with_lane(with_lane(with_lane(eight(0.0), 4, a), 5, b), 6, c), eight(0.0))


@inlined
def _twist_parts(twists: Vector | None) -> tuple:
    if twists is None:
        nothing = (0.0, eight(0.0), eight(0.0))
        return nothing, nothing, nothing
    return parts(twists[0]), parts(twists[1]), parts(twists[2])
