"""Numbers of 32 digits with operators, in compiled code: a formula that is written once runs on these and on doubles.

Either kind is of several throws side by side (`lanes`).  `Long` is a type of numba's, made of the two doubles of
`double_double`.  Every function here is for either kind of number; where it makes one, `kind` is any number of the kind
that is wanted.
"""

import operator
from collections.abc import Callable
from math import factorial
from typing import Any

from mpmath import MPContext
from numba import types
from numba.core import cgutils
from numba.extending import make_attribute_wrapper, models, overload, register_model

from tumble.scenarios.frames import Array
from tumble.scenarios.truth.compilation import inner
from tumble.scenarios.truth.double_double import Pair, add, fast_two_sum, minus, over, pairs, times, two_product
from tumble.scenarios.truth.lanes import (
    LANES,
    below,
    chosen,
    cosine,
    direction,
    instruction,
    lanes,
    load,
    root_of,
    sine,
    whole,
)
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
        super().__init__(manager, kind, [("high", LANES), ("low", LANES)])


make_attribute_wrapper(LongType, "high", "high")
make_attribute_wrapper(LongType, "low", "low")


@instruction
def _long(typing_context: Any, high: Any, low: Any) -> Any:
    """Return the number high + low."""

    def made(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        number = cgutils.create_struct_proxy(LONG)(context, builder)
        number.high, number.low = arguments
        return number._getvalue()

    return LONG(LANES, LANES), made


@inner
def long(high: Any, low: Any) -> Any:
    """Return the number high + low, of lanes or of doubles for all lanes."""
    return _long(lanes(high), lanes(low))


def _give_meaning(symbol: Callable, function: Callable[[Pair, Pair], Pair]) -> None:
    """Let an operator mean a function of pairs where a side is Long; doubles there stand for themselves."""

    @inner
    def made(a: Pair, b: Pair) -> Any:
        high, low = function(a, b)
        return _long(high, low)

    def is_double(a: Any) -> bool:
        return a is LANES or isinstance(a, types.Float)

    @overload(symbol, strict=False)
    def meaning(a: Any, b: Any) -> Any:
        if a is LONG and b is LONG:
            return lambda a, b: made((a.high, a.low), (b.high, b.low))
        if a is LONG and is_double(b):
            return lambda a, b: made((a.high, a.low), (lanes(b), lanes(0.0)))
        if is_double(a) and b is LONG:
            return lambda a, b: made((lanes(a), lanes(0.0)), (b.high, b.low))
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
    return (lambda a: _long(-a.high, -a.low)) if a is LONG else None


def near(a: Any) -> Any:
    """Return the nearest doubles."""
    raise NotImplementedError("compiled only")


@overload(near, strict=False)
def _near(a: Any) -> Any:
    return (lambda a: a.high) if a is LONG else (lambda a: a)


def rest(a: Any) -> Any:
    """Return what the nearest doubles leave."""
    raise NotImplementedError("compiled only")


@overload(rest, strict=False)
def _rest(a: Any) -> Any:
    return (lambda a: a.low) if a is LONG else (lambda a: lanes(0.0))


def number(kind: Any, high: Any, low: Any) -> Any:
    """Return high + low, as doubles high alone."""
    raise NotImplementedError("compiled only")


@overload(number, strict=False)
def _number(kind: Any, high: Any, low: Any) -> Any:
    if kind is LONG:
        return lambda kind, high, low: _long(lanes(high), lanes(low))
    return lambda kind, high, low: lanes(high)


def where(mask: Any, a: Any, b: Any) -> Any:
    """Return a where the mask is true, else b: numbers of one kind, or vectors of them."""
    raise NotImplementedError("compiled only")


@overload(where, strict=False)
def _where(mask: Any, a: Any, b: Any) -> Any:
    if a is LONG:
        return lambda mask, a, b: _long(chosen(mask, a.high, b.high), chosen(mask, a.low, b.low))
    if isinstance(a, types.BaseTuple):
        return lambda mask, a, b: (where(mask, a[0], b[0]), where(mask, a[1], b[1]), where(mask, a[2], b[2]))
    return lambda mask, a, b: chosen(mask, lanes(a), lanes(b))


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
        return lambda a: root_of(a)

    def of_long(a: Any) -> Any:
        # As `double_double.root`.
        first = root_of(a.high)
        rest, _ = minus((a.high, a.low), two_product(first, first))
        high, low = fast_two_sum(first, rest / (2.0 * first))
        none = a.high == 0.0
        return _long(chosen(none, lanes(0.0), high), chosen(none, lanes(0.0), low))

    return of_long


def cos_sin(a: Any) -> Any:
    """Return cosine and sine of an angle [rad]."""
    raise NotImplementedError("compiled only")


@overload(cos_sin, strict=False)
def _cos_sin(a: Any) -> Any:
    return (lambda a: long_cos_sin(a)) if a is LONG else (lambda a: (cosine(a), sine(a)))


@inner
def long_cos_sin(a: Any) -> Any:
    """Return cosine and sine by their series, of what is left when right angles are taken off."""
    turns = whole(a.high / TWO_PI[0])
    left = a - long(TWO_PI[0], TWO_PI[1]) * turns
    corners = whole(left.high / RIGHT_ANGLE[0])
    left = left - long(RIGHT_ANGLE[0], RIGHT_ANGLE[1]) * corners
    square = -(left * left)
    cos, sin = long(0.0, 0.0), long(0.0, 0.0)
    for k in range(TERMS - 2, -1, -2):
        cos = cos * square + long(INVERSE_FACTORIALS[k, 0], INVERSE_FACTORIALS[k, 1])
        sin = sin * square + long(INVERSE_FACTORIALS[k + 1, 0], INVERSE_FACTORIALS[k + 1, 1])
    sin = sin * left
    corner = corners - 4.0 * below(corners / 4.0)
    crossed = (corner == 1.0) | (corner == 3.0)
    cos, sin = where(crossed, sin, cos), where(crossed, cos, sin)
    return where((corner == 1.0) | (corner == 2.0), -cos, cos), where(corner >= 2.0, -sin, sin)


def angle(cos: Any, sin: Any, about: Any) -> Any:
    """Return the angle of a unit vector [rad]; of all such angles the one that is nearest to `about`."""
    raise NotImplementedError("compiled only")


@overload(angle, strict=False)
def _angle(cos: Any, sin: Any, about: Any) -> Any:
    if cos is not LONG:

        def of_doubles(cos: Any, sin: Any, about: Any) -> Any:
            within = direction(sin, cos)
            return within + TWO_PI[0] * whole((about - within) / TWO_PI[0])

        return of_doubles

    def of_longs(cos: Any, sin: Any, about: Any) -> Any:
        within = long(direction(sin.high, cos.high), 0.0)
        cos_within, sin_within = long_cos_sin(within)
        turns = whole((about - within.high) / TWO_PI[0])
        # What is left is 1e-16: its sine is itself.
        within = within + (sin * cos_within - cos * sin_within)
        return within + long(TWO_PI[0], TWO_PI[1]) * turns

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


@inner
def vector_of(kind: Number, numbers: Array, first: int, low: int) -> Vector:
    """Return three numbers of lanes, (2 low, WIDTH), the second halves of which are at `low`."""
    return (
        number(kind, load(numbers, first), load(numbers, low + first)),
        number(kind, load(numbers, first + 1), load(numbers, low + first + 1)),
        number(kind, load(numbers, first + 2), load(numbers, low + first + 2)),
    )
