"""Numbers of 32 digits with operators, in compiled code: a formula that is written once runs on these and on doubles.

`Long` is a type of numba's, made of the two doubles of `double_double`.  Every function here is for either kind of
number; where it makes one, `kind` is any number of the kind that is wanted.
"""

import operator
from collections.abc import Callable
from math import factorial
from typing import Any

import numpy as np
from mpmath import MPContext
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic, make_attribute_wrapper, models, overload, register_model

from tumble.scenarios.frames import Array
from tumble.scenarios.truth import double_double
from tumble.scenarios.truth.compilation import inner
from tumble.scenarios.truth.double_double import Pair, add, minus, over, pairs, times
from tumble.scenarios.truth.rational import Fraction

# 1/k! for the series of cosine and sine up to pi/4; the first that is left out is below 2^-107.
TERMS = 28


def _pair(number: Any) -> Pair:
    high, low = pairs([Fraction(*number.as_integer_ratio())])[:, 0].tolist()
    return high, low


_mp: Any = MPContext()
_mp.prec = 400
TWO_PI, RIGHT_ANGLE = _pair(2 * _mp.pi), _pair(_mp.pi / 2)
INVERSE_FACTORIALS = pairs([Fraction(1, factorial(k)) for k in range(TERMS)]).T


class LongType(types.Type):
    """The type of a number of 32 digits."""

    def __init__(self) -> None:
        super().__init__(name="Long")


LONG = LongType()


@register_model(LongType)
class _LongModel(models.StructModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, [("high", types.float64), ("low", types.float64)])


make_attribute_wrapper(LongType, "high", "high")
make_attribute_wrapper(LongType, "low", "low")


@intrinsic
def long(typing_context: Any, high: Any, low: Any) -> Any:
    """Return the number high + low."""

    def made(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        number = cgutils.create_struct_proxy(LONG)(context, builder)
        number.high, number.low = arguments
        return number._getvalue()

    return LONG(types.float64, types.float64), made


def _give_meaning(symbol: Callable, function: Callable[[Pair, Pair], Pair]) -> None:
    """Let an operator mean a function of pairs where a side is Long; a double there stands for itself."""

    @inner
    def made(a: Pair, b: Pair) -> Any:
        high, low = function(a, b)
        return long(high, low)  # type: ignore[call-arg]

    @overload(symbol, strict=False)
    def meaning(a: Any, b: Any) -> Any:
        if a is LONG and b is LONG:
            return lambda a, b: made((a.high, a.low), (b.high, b.low))
        if a is LONG and isinstance(b, types.Float):
            return lambda a, b: made((a.high, a.low), (b, 0.0))
        if isinstance(a, types.Float) and b is LONG:
            return lambda a, b: made((a, 0.0), (b.high, b.low))
        return None


for _symbol, _function in (
    (operator.add, add),
    (operator.sub, minus),
    (operator.mul, times),
    (operator.truediv, over),
):
    _give_meaning(_symbol, _function)


@overload(operator.neg, strict=False)
def _negative(a: Any) -> Any:
    return (lambda a: long(-a.high, -a.low)) if a is LONG else None  # type: ignore[call-arg]


def near(a: Any) -> float:
    """Return the nearest double."""
    raise NotImplementedError("compiled only")


@overload(near, strict=False)
def _near(a: Any) -> Any:
    return (lambda a: a.high) if a is LONG else (lambda a: a)


def rest(a: Any) -> float:
    """Return what the nearest double leaves."""
    raise NotImplementedError("compiled only")


@overload(rest, strict=False)
def _rest(a: Any) -> Any:
    return (lambda a: a.low) if a is LONG else (lambda a: 0.0)


def number(kind: Any, high: float, low: float) -> Any:
    """Return high + low, as a double high alone."""
    raise NotImplementedError("compiled only")


@overload(number, strict=False)
def _number(kind: Any, high: Any, low: Any) -> Any:
    if kind is LONG:
        return lambda kind, high, low: long(high, low)  # type: ignore[call-arg]
    return lambda kind, high, low: high


def bits(kind: Any) -> int:
    """Return how many bits a number has."""
    raise NotImplementedError("compiled only")


@overload(bits, strict=False)
def _bits(kind: Any) -> Any:
    return (lambda kind: 106) if kind is LONG else (lambda kind: 53)


def root(a: Any) -> Any:
    """Return the square root."""
    raise NotImplementedError("compiled only")


@overload(root, strict=False)
def _root(a: Any) -> Any:
    if a is not LONG:
        return lambda a: np.sqrt(a)
    of_pair = double_double.root

    def of_long(a: Any) -> Any:
        high, low = of_pair((a.high, a.low))
        return long(high, low)  # type: ignore[call-arg]

    return of_long


def cos_sin(a: Any) -> Any:
    """Return cosine and sine of an angle [rad]."""
    raise NotImplementedError("compiled only")


@overload(cos_sin, strict=False)
def _cos_sin(a: Any) -> Any:
    return (lambda a: long_cos_sin(a)) if a is LONG else (lambda a: (np.cos(a), np.sin(a)))


@inner
def long_cos_sin(a: Any) -> Any:
    """Return cosine and sine by their series, of what is left when right angles are taken off."""
    turns = np.rint(a.high / TWO_PI[0])
    left = a - long(TWO_PI[0], TWO_PI[1]) * turns  # type: ignore[call-arg]
    corners = np.rint(left.high / RIGHT_ANGLE[0])
    left = left - long(RIGHT_ANGLE[0], RIGHT_ANGLE[1]) * corners  # type: ignore[call-arg]
    square = -(left * left)
    cos, sin = long(0.0, 0.0), long(0.0, 0.0)  # type: ignore[call-arg]
    for k in range(TERMS - 2, -1, -2):
        cos = cos * square + long(INVERSE_FACTORIALS[k, 0], INVERSE_FACTORIALS[k, 1])  # type: ignore[call-arg]
        sin = sin * square + long(INVERSE_FACTORIALS[k + 1, 0], INVERSE_FACTORIALS[k + 1, 1])  # type: ignore[call-arg]
    sin = sin * left
    corner = int(corners) % 4
    if corner == 0:
        return cos, sin
    if corner == 1:
        return -sin, cos
    return (-cos, -sin) if corner == 2 else (sin, -cos)


def angle(cos: Any, sin: Any, about: float) -> Any:
    """Return the angle of a unit vector [rad]; of all such angles the one that is nearest to `about`."""
    raise NotImplementedError("compiled only")


@overload(angle, strict=False)
def _angle(cos: Any, sin: Any, about: Any) -> Any:
    if cos is not LONG:

        def of_doubles(cos: float, sin: float, about: float) -> float:
            within = np.arctan2(sin, cos)
            return within + TWO_PI[0] * np.rint((about - within) / TWO_PI[0])

        return of_doubles

    def of_longs(cos: Any, sin: Any, about: float) -> Any:
        within = long(np.arctan2(sin.high, cos.high), 0.0)  # type: ignore[call-arg]
        cos_within, sin_within = long_cos_sin(within)
        turns = np.rint((about - within.high) / TWO_PI[0])
        # What is left is 1e-16: its sine is itself.
        within = within + (sin * cos_within - cos * sin_within)
        return within + long(TWO_PI[0], TWO_PI[1]) * turns  # type: ignore[call-arg]

    return of_longs


Number = Any
Vector = tuple[Number, Number, Number]
Columns = tuple[Vector, Vector, Vector]


@inner
def dot(a: Vector, b: Vector) -> Number:
    """Return a.b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inner
def along(columns: Columns, a: Vector) -> Vector:
    """Return a matrix, given by its columns, times a vector."""
    x, y, z = columns
    return (
        x[0] * a[0] + y[0] * a[1] + z[0] * a[2],
        x[1] * a[0] + y[1] * a[1] + z[1] * a[2],
        x[2] * a[0] + y[2] * a[1] + z[2] * a[2],
    )


@inner
def stretched(a: Vector, factor: Number) -> Vector:
    """Return a vector times a number."""
    return a[0] * factor, a[1] * factor, a[2] * factor


@inner
def vector(kind: Number, pairs: Array, first: int) -> Vector:
    """Return three numbers of pairs, (2, n)."""
    return (
        number(kind, pairs[0, first], pairs[1, first]),
        number(kind, pairs[0, first + 1], pairs[1, first + 1]),
        number(kind, pairs[0, first + 2], pairs[1, first + 2]),
    )
