"""a b + c with one rounding, as one instruction of the processor: said outright, where a step waits for nothing else.

Left to the compiler, the last bits would depend on the processor and on how a loop happened to be compiled.  Said
outright they are the same everywhere: a processor without the instruction, of before 2013, is slow and no less exact.
A quaternion's four numbers are one vector register, which the compiler does not find by itself in code on tuples.
"""

import math
from collections.abc import Callable
from typing import Any, cast

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from tumble.solver.compilation import inner, scalar
from tumble.solver.quaternion import SERIES_LIMIT, Quaternion, exponential, stretch
from tumble.solver.vectors import Vector

FOUR = types.UniTuple(types.float64, 4)
LANE, REGISTER = ir.IntType(32), ir.VectorType(ir.DoubleType(), 4)
# Where each number of q i, q j and q k comes from in q = (w, x, y, z), and its sign.
UNITS = (
    ((1, 0, 3, 2), (-1.0, 1.0, 1.0, -1.0)),
    ((2, 3, 0, 1), (-1.0, -1.0, 1.0, 1.0)),
    ((3, 2, 1, 0), (-1.0, 1.0, -1.0, 1.0)),
)

# Taylor's series of the cosine, and of the sine over the angle, in squares of angles of a quarter turn at most.
COSINE = tuple((-1) ** k / math.factorial(2 * k) for k in range(11))
SINE_RATIO = tuple((-1) ** k / math.factorial(2 * k + 1) for k in range(11))
# 2 pi in two parts.  Adding and taking off 3 * 2^51 rounds to whole numbers.
TURN_HIGH, TURN_LOW = 2.0 * math.pi, 2.4492935982947064e-16
WHOLE = 3.0 * 2.0**51
# Of an angle [rad], above which its turns would not be rounded to whole numbers so.
MANY_TURNS = 2.0**52


def packed(builder: Any, numbers: Any) -> Any:
    """Return four numbers as one register."""
    register = ir.Constant(REGISTER, ir.Undefined)
    for lane in range(4):
        register = builder.insert_element(register, builder.extract_value(numbers, lane), LANE(lane))
    return register


def unpacked(builder: Any, register: Any) -> Any:
    """Return a register as four numbers."""
    numbers = ir.Constant(ir.ArrayType(ir.DoubleType(), 4), ir.Undefined)
    for lane in range(4):
        numbers = builder.insert_value(numbers, builder.extract_element(register, LANE(lane)), lane)
    return numbers


def _shuffled(builder: Any, register: Any, lanes: tuple[int, ...]) -> Any:
    """Return a register whose lanes come from those lanes of another."""
    return builder.shuffle_vector(
        register, ir.Constant(REGISTER, ir.Undefined), ir.Constant(ir.VectorType(LANE, 4), lanes)
    )


def spread(builder: Any, number: Any) -> Any:
    """Return a register of which all four lanes are one number."""
    alone = builder.insert_element(ir.Constant(REGISTER, ir.Undefined), number, LANE(0))
    return _shuffled(builder, alone, (0, 0, 0, 0))


def multiply_add(builder: Any, kind: ir.Type, a: Any, b: Any, c: Any) -> Any:
    """Return a b + c of numbers or of registers."""
    suffix = "v4f64" if kind is REGISTER else "f64"
    function = builder.module.declare_intrinsic(f"llvm.fma.{suffix}", fnty=ir.FunctionType(kind, [kind] * 3))
    return builder.call(function, [a, b, c])


@intrinsic
def _fused(typing_context, a, b, c):
    def codegen(context, builder, signature, arguments):
        return multiply_add(builder, ir.DoubleType(), *arguments)

    return types.float64(types.float64, types.float64, types.float64), codegen


@intrinsic
def _fused_stretch(typing_context, factor, q, c):
    def codegen(context, builder, signature, arguments):
        factor, q, c = arguments
        factors = spread(builder, factor)
        return unpacked(builder, multiply_add(builder, REGISTER, factors, packed(builder, q), packed(builder, c)))

    return FOUR(types.float64, FOUR, FOUR), codegen


@intrinsic
def _times_units(typing_context, q):
    def codegen(context, builder, signature, arguments):
        register = packed(builder, arguments[0])
        products = [
            unpacked(builder, builder.fmul(_shuffled(builder, register, lanes), ir.Constant(REGISTER, signs)))
            for lanes, signs in UNITS
        ]
        return context.make_tuple(builder, signature.return_type, products)

    return types.UniTuple(FOUR, 3)(FOUR), codegen


# a b + c.
fused = cast(Callable[[float, float, float], float], _fused)
# factor q + c.
fused_stretch = cast(Callable[[float, Quaternion, Quaternion], Quaternion], _fused_stretch)
# q i, q j and q k.
times_units = cast(Callable[[Quaternion], tuple[Quaternion, Quaternion, Quaternion]], _times_units)


@scalar
def fused_scale(factor: float, a: Vector, c: Vector) -> Vector:
    """Return factor a + c."""
    return (fused(factor, a[0], c[0]), fused(factor, a[1], c[1]), fused(factor, a[2], c[2]))


@scalar
def fused_times(diagonal: Vector, a: Vector, c: Vector) -> Vector:
    """Return diag(diagonal) a + c."""
    return (fused(diagonal[0], a[0], c[0]), fused(diagonal[1], a[1], c[1]), fused(diagonal[2], a[2], c[2]))


@scalar
def fused_cross(a: Vector, b: Vector, c: Vector) -> Vector:
    """Return a x b + c."""
    return (
        fused(a[1], b[2], fused(-a[2], b[1], c[0])),
        fused(a[2], b[0], fused(-a[0], b[2], c[1])),
        fused(a[0], b[1], fused(-a[1], b[0], c[2])),
    )


@scalar
def fused_product(p: Quaternion, q: Quaternion) -> Quaternion:
    """Return the Hamilton product p q."""
    i, j, k = times_units(p)
    return fused_stretch(q[3], k, fused_stretch(q[2], j, fused_stretch(q[1], i, stretch(q[0], p))))


@inner
def _of_squares(terms: tuple[float, ...], s: float) -> float:
    """Return a polynomial of eleven terms, in parts that do not wait for each other."""
    s2 = s * s
    s4 = s2 * s2
    low = fused(s2, fused(s, terms[3], terms[2]), fused(s, terms[1], terms[0]))
    middle = fused(s2, fused(s, terms[7], terms[6]), fused(s, terms[5], terms[4]))
    high = fused(s2, terms[10], fused(s, terms[9], terms[8]))
    return fused(s4, fused(s4, high, middle), low)


@inner
def fused_half_turn(angle: float) -> tuple[float, float]:
    """Return the cosine and the sine of half an angle [rad], to rounding.

    Without a call, before which all registers would be emptied, but for an angle beyond MANY_TURNS.
    """
    if not abs(angle) < MANY_TURNS:
        return math.cos(0.5 * angle), math.sin(0.5 * angle)
    turns = (angle * (0.5 / math.pi) + WHOLE) - WHOLE
    odd = fused(-2.0, (0.5 * turns + WHOLE) - WHOLE, turns)
    sign = fused(-2.0 * odd, odd, 1.0)
    half = 0.5 * fused(-turns, TURN_LOW, fused(-turns, TURN_HIGH, angle))
    s = half * half
    return sign * _of_squares(COSINE, s), (sign * half) * _of_squares(SINE_RATIO, s)


@scalar
def fused_exponential(u: Vector) -> Quaternion:
    """Return exp(u~) as `tumble.solver.quaternion.exponential` does.

    Source: Sola, "Quaternion kinematics for the error-state Kalman filter" (2017), section 1.3.4.
    """
    square = fused(u[0], u[0], fused(u[1], u[1], u[2] * u[2]))
    if square < SERIES_LIMIT:
        # Taylor's series, the odd and the even terms apart: half the waiting of Horner's scheme.
        fourth = square * square
        low, high = fused(square, -1 / 2, 1.0), fused(square, -1 / 720, 1 / 24)
        cosine = fused(fourth, fused(fourth, 1 / 40320, high), low)
        low, high = fused(square, -1 / 6, 1.0), fused(square, -1 / 5040, 1 / 120)
        ratio = fused(fourth, fused(fourth, 1 / 362880, high), low)
        return (cosine, ratio * u[0], ratio * u[1], ratio * u[2])
    return exponential(u)
