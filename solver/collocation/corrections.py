"""The linear equations of a correction of the slopes, reduced to those of velocity and angular momentum.

In an eigenvector of a method's coefficients a step multiplies slopes by a number h, real in one and complex in the two
others, and the correction k of slopes that miss r is asked (1 - h J) k = r, J the Jacobian of the equations of motion.
Of these x' = v is resolved by hand, and so is q' = q w~/2 but for the turn of the step itself: then kv moves the body
by h^2 kv and kL turns it by h^2 I^-1 kL, and six equations are left, in 1 - h S - h^2 P, where S is what speeds change
and P what places do: `tumble.solver.collocation.changes`, whose columns these are.
Source: Hairer & Wanner, "Solving Ordinary Differential Equations II" (1996), section IV.8, and eq. 8.17.
"""

from typing import NamedTuple

from tumble.solver.collocation.changes import Changes, unit
from tumble.solver.collocation.equations import Eights
from tumble.solver.collocation.scheme import Scheme
from tumble.solver.compilation import inlined
from tumble.solver.eight import Eight, eight, fused_eight, lane, transposed, with_lane
from tumble.solver.vectors import Vector


class Complex(NamedTuple):
    """Eight complex numbers."""

    real: Eight
    imaginary: Eight


RealSix = tuple[Eight, Eight, Eight, Eight, Eight, Eight]
Six = tuple[Complex, Complex, Complex, Complex, Complex, Complex]


class Missed(NamedTuple):
    """What slopes at the stages miss: those of x, of the turn times I, of v and of L."""

    velocities: Vector
    turns: Vector
    accelerations: Vector
    twists: Vector


class Resolved(NamedTuple):
    """The equations of a correction, resolved: the inverse for the real eigenvalue and for one of the pair."""

    changes: Changes
    real: RealSix
    pair: Six


@inlined
def resolved(changes: Changes, dt: float, method: Scheme) -> Resolved:
    """Return the equations of a correction in a step, resolved."""
    return Resolved(changes, real_inverse(changes, dt * method.real_rate), inverse(changes, dt * method.pair_rate))


@inlined
def corrections(found: Resolved, missed: Missed, dt: float, method: Scheme) -> tuple[Vector, Vector]:
    """Return what to add to dv/dt and dL/dt at the stages.

    Source: Hairer & Wanner (1996), eq. IV.8.13.
    """
    places = _by_stage(missed.velocities, missed.turns)
    speeds = _by_stage(missed.accelerations, missed.twists)
    a, b = method.to_real, method.to_pair
    real = _real_correction(found.real, found.changes, dt * method.real_rate, (a[0], a[1], a[2]), places, speeds)
    pair = _correction(found.pair, found.changes, dt * method.pair_rate, (b[0], b[1], b[2]), places, speeds)
    no, c, d = eight(0.0), method.from_real, method.from_pair
    first, second, third = _back(c[0], real, d[0], pair), _back(c[1], real, d[1], pair), _back(c[2], real, d[2], pair)
    by_stage = transposed((first, second, third, no, no, no, no, no))
    return (by_stage[0], by_stage[1], by_stage[2]), (by_stage[4], by_stage[5], by_stage[6])


@inlined
def _by_stage(first: Vector, second: Vector) -> Eights:
    """Return what belongs to x or v, and to a turn or L, at each stage, as columns are."""
    no = eight(0.0)
    a, b, c, _, _, _, _, _ = transposed((*first, no, *second, no))
    return a, b, c


@inlined
def _combined(weights: tuple[complex, complex, complex], stages: Eights) -> Complex:
    """Return the combination of three stages that an eigenvector makes."""
    a, b, c = weights
    return Complex(
        a.real * stages[0] + b.real * stages[1] + c.real * stages[2],
        a.imag * stages[0] + b.imag * stages[1] + c.imag * stages[2],
    )


@inlined
def _back(a: float, real: Eight, b: complex, pair: Complex) -> Eight:
    """Return a stage's part of the eigenvectors: of the conjugate pair twice the real part of one."""
    return a * real + 2.0 * b.real * pair.real - 2.0 * b.imag * pair.imaginary


@inlined
def inverse(changes: Changes, h: complex) -> Six:
    """Return the columns of (1 - h S - h^2 P)^-1: Gauss and Jordan's elimination, in place.

    Without pivoting: what pulls back or damps makes a diagonal above 1, and of a bad pivot only comes a bad correction.
    Source: Golub & Van Loan, "Matrix Computations" (2013), section 3.4.
    """
    six = (
        _column(changes, h, 0),
        _column(changes, h, 1),
        _column(changes, h, 2),
        _column(changes, h, 4),
        _column(changes, h, 5),
        _column(changes, h, 6),
    )
    six = _eliminated(_eliminated(_eliminated(six, 0), 1), 2)
    return _eliminated(_eliminated(_eliminated(six, 3), 4), 5)


@inlined
def real_inverse(changes: Changes, h: float) -> RealSix:
    """Return the same for a real h: a fourth of the arithmetic, and the same numbers."""
    six = (
        _real_column(changes, h, 0),
        _real_column(changes, h, 1),
        _real_column(changes, h, 2),
        _real_column(changes, h, 4),
        _real_column(changes, h, 5),
        _real_column(changes, h, 6),
    )
    six = _real_eliminated(_real_eliminated(_real_eliminated(six, 0), 1), 2)
    return _real_eliminated(_real_eliminated(_real_eliminated(six, 3), 4), 5)


@inlined
def _real_column(changes: Changes, h: float, number: int) -> Eight:
    return unit(number) - (h * changes.by_speed[number] + h * h * changes.by_place[number])


@inlined
def _column(changes: Changes, h: complex, number: int) -> Complex:
    square = h * h
    place, speed = changes.by_place[number], changes.by_speed[number]
    return Complex(
        unit(number) - (h.real * speed + square.real * place),
        -(h.imag * speed + square.imag * place),
    )


@inlined
def _real_eliminated(six: RealSix, number: int) -> RealSix:
    """Return the columns after the elimination by one of them."""
    row = number + number // 3
    a = lane(six[number], row)
    pivot = a * (1.0 / (a * a)) * with_lane(six[number], row, 1.0)
    return (
        _real_less(six[0], pivot, row, number == 0),
        _real_less(six[1], pivot, row, number == 1),
        _real_less(six[2], pivot, row, number == 2),
        _real_less(six[3], pivot, row, number == 3),
        _real_less(six[4], pivot, row, number == 4),
        _real_less(six[5], pivot, row, number == 5),
    )


@inlined
def _real_less(column: Eight, pivot: Eight, row: int, is_pivot: bool) -> Eight:
    """Return a column less what of the pivot's makes its number in a row nothing."""
    if is_pivot:
        return pivot
    return fused_eight(eight(-lane(column, row)), pivot, with_lane(column, row, 0.0))


@inlined
def _eliminated(six: Six, number: int) -> Six:
    """Return the columns after the elimination by one of them."""
    row = number + number // 3
    a, b = lane(six[number].real, row), lane(six[number].imaginary, row)
    per = 1.0 / (a * a + b * b)
    one = Complex(with_lane(six[number].real, row, 1.0), with_lane(six[number].imaginary, row, 0.0))
    pivot = _times(one, a * per, -(b * per))
    return (
        _less(six[0], pivot, row, number == 0),
        _less(six[1], pivot, row, number == 1),
        _less(six[2], pivot, row, number == 2),
        _less(six[3], pivot, row, number == 3),
        _less(six[4], pivot, row, number == 4),
        _less(six[5], pivot, row, number == 5),
    )


@inlined
def _less(column: Complex, pivot: Complex, row: int, is_pivot: bool) -> Complex:
    """Return a column less what of the pivot's makes its number in a row nothing."""
    if is_pivot:
        return pivot
    a, b = lane(column.real, row), lane(column.imaginary, row)
    return _plus_times(Complex(with_lane(column.real, row, 0.0), with_lane(column.imaginary, row, 0.0)), -a, -b, pivot)


@inlined
def _times(column: Complex, a: float, b: float) -> Complex:
    """Return (a + i b) column."""
    return Complex(
        fused_eight(eight(-b), column.imaginary, a * column.real),
        fused_eight(eight(b), column.real, a * column.imaginary),
    )


@inlined
def _plus_times(start: Complex, a: float, b: float, column: Complex) -> Complex:
    """Return start + (a + i b) column."""
    real = fused_eight(eight(a), column.real, start.real)
    imaginary = fused_eight(eight(a), column.imaginary, start.imaginary)
    return Complex(fused_eight(eight(-b), column.imaginary, real), fused_eight(eight(b), column.real, imaginary))


@inlined
def _real_correction(
    six: RealSix, changes: Changes, h: float, weights: Vector, places: Eights, speeds: Eights
) -> Eight:
    """Return k of the real eigenvector, whose weights these are, from what slopes of places and of speeds miss."""
    move = h * _real_combined(weights, places)
    rest = _real_combined(weights, speeds)
    rest = _real_pushed(_real_pushed(_real_pushed(rest, changes, move, 0), changes, move, 1), changes, move, 2)
    rest = _real_pushed(_real_pushed(_real_pushed(rest, changes, move, 4), changes, move, 5), changes, move, 6)
    first = fused_eight(eight(lane(rest, 1)), six[1], lane(rest, 0) * six[0])
    last = fused_eight(eight(lane(rest, 5)), six[4], lane(rest, 4) * six[3])
    return fused_eight(eight(lane(rest, 2)), six[2], first) + fused_eight(eight(lane(rest, 6)), six[5], last)


@inlined
def _real_combined(weights: Vector, stages: Eights) -> Eight:
    return weights[0] * stages[0] + weights[1] * stages[1] + weights[2] * stages[2]


@inlined
def _real_pushed(r: Eight, changes: Changes, move: Eight, number: int) -> Eight:
    """Return r and what a move or a turn along one axis adds to it."""
    return fused_eight(eight(lane(move, number)), changes.by_place[number], r)


@inlined
def _correction(
    six: Six, changes: Changes, h: complex, weights: tuple[complex, complex, complex], places: Eights, speeds: Eights
) -> Complex:
    """Return k of one eigenvector, whose weights these are, from what slopes of places and of speeds miss."""
    move = _times(_combined(weights, places), h.real, h.imag)
    rest = _combined(weights, speeds)
    rest = _pushed(_pushed(_pushed(rest, changes, move, 0), changes, move, 1), changes, move, 2)
    rest = _pushed(_pushed(_pushed(rest, changes, move, 4), changes, move, 5), changes, move, 6)
    first = _plus_times(_plus_times(_times(six[0], *_of(rest, 0)), *_of(rest, 1), six[1]), *_of(rest, 2), six[2])
    last = _plus_times(_plus_times(_times(six[3], *_of(rest, 4)), *_of(rest, 5), six[4]), *_of(rest, 6), six[5])
    return Complex(first.real + last.real, first.imaginary + last.imaginary)


@inlined
def _pushed(r: Complex, changes: Changes, move: Complex, number: int) -> Complex:
    """Return r and what a move or a turn along one axis adds to it."""
    a, b = _of(move, number)
    column = changes.by_place[number]
    return Complex(fused_eight(eight(a), column, r.real), fused_eight(eight(b), column, r.imaginary))


@inlined
def _of(numbers: Complex, number: int) -> tuple[float, float]:
    return lane(numbers.real, number), lane(numbers.imaginary, number)
