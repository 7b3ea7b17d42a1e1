"""Numbers of 32 digits as two doubles, high + low, in compiled code.

A number is a pair (high, low) with |low| <= ulp(high) / 2.  Relative rounding errors: a sum and a product are right to
2^-103, a quotient and a root to 2^-100.  Overflow and numbers below 1e-290 lose the second double.
Source: Dekker, "A floating-point technique for extending the available precision", Numer. Math. 18 (1971) 224;
Hida, Li & Bailey, "Algorithms for quad-double precision floating point arithmetic", ARITH-15 (2001).
"""

from typing import Any

import numpy as np
from llvmlite import ir
from numba.extending import intrinsic

from tumble.scenarios.frames import Array
from tumble.scenarios.truth.compilation import inlined, inner
from tumble.scenarios.truth.rational import Fraction

Pair = tuple[float, float]


@intrinsic
def fma(typing_context: Any, a: Any, b: Any, c: Any) -> Any:
    """Return a b + c, rounded once; of doubles, or of vectors of doubles."""

    def made(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        kind = arguments[0].type
        name = f"llvm.fma.v{kind.count}f64" if isinstance(kind, ir.VectorType) else "llvm.fma.f64"
        return builder.call(builder.module.declare_intrinsic(name, fnty=ir.FunctionType(kind, [kind] * 3)), arguments)

    return a(a, a, a), made


@inlined
def two_sum(a: float, b: float) -> Pair:
    """Return a + b and its rounding error (Knuth)."""
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


@inlined
def fast_two_sum(a: float, b: float) -> Pair:
    """Return a + b and its rounding error, for |a| >= |b| (Dekker)."""
    total = a + b
    return total, b - (total - a)


@inlined
def two_product(a: float, b: float) -> Pair:
    """Return a b and its rounding error."""
    product = a * b
    return product, fma(a, b, -product)  # type: ignore[call-arg]


@inlined
def add(a: Pair, b: Pair) -> Pair:
    """Return a + b."""
    high, low = two_sum(a[0], b[0])
    tail, rest = two_sum(a[1], b[1])
    high, low = fast_two_sum(high, low + tail)
    return fast_two_sum(high, low + rest)


@inlined
def minus(a: Pair, b: Pair) -> Pair:
    """Return a - b."""
    return add(a, (-b[0], -b[1]))


@inlined
def times(a: Pair, b: Pair) -> Pair:
    """Return a b."""
    high, low = two_product(a[0], b[0])
    return fast_two_sum(high, low + (a[0] * b[1] + a[1] * b[0]))


@inlined
def scaled(a: Pair, factor: float) -> Pair:
    """Return a times a double."""
    high, low = two_product(a[0], factor)
    return fast_two_sum(high, low + a[1] * factor)


@inner
def over(a: Pair, b: Pair) -> Pair:
    """Return a / b: three digits of a long division."""
    first = a[0] / b[0]
    rest = minus(a, scaled(b, first))
    second = rest[0] / b[0]
    rest = minus(rest, scaled(b, second))
    third = rest[0] / b[0]
    high, low = fast_two_sum(first, second)
    return add((high, low), (third, 0.0))


@inner
def root(a: Pair) -> Pair:
    """Return the square root: one step of Newton's from the double's (Karp & Markstein, ACM TOMS 23 (1997) 561)."""
    if a[0] <= 0.0:
        return (0.0, 0.0) if a[0] == 0.0 else (np.nan, np.nan)
    first = np.sqrt(a[0])
    rest = minus(a, two_product(first, first))
    return fast_two_sum(first, rest[0] / (2.0 * first))


def pairs(numbers: np.ndarray | list) -> Array:
    """Return fractions, (...), as pairs, (2, ...): the nearest double and the nearest to what that leaves."""
    exact = np.asarray(numbers, dtype=object)
    high = np.array([float(number) for number in exact.flat])
    low = np.array([float(Fraction(number) - Fraction(near)) for number, near in zip(exact.flat, high, strict=True)])
    return np.array((high.reshape(exact.shape), low.reshape(exact.shape)))


def fractions_of(numbers: Array) -> np.ndarray:
    """Return pairs, (2, ...), as the fractions they are, (...)."""
    exact = [Fraction(float(high)) + Fraction(float(low)) for high, low in zip(*numbers.reshape(2, -1), strict=True)]
    return np.array(exact, dtype=object).reshape(numbers.shape[1:])
