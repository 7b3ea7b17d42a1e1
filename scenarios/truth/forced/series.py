"""Equations of motion as a list of operations on power series, and the steps that sum them.

Python writes the operations down once, with coefficients in fractions; compiled code runs them, order by order, on
numbers of 32 digits, or on doubles where there are no low parts.
Source: Jorba & Zou, "A software package for the numerical integration of ODEs by means of high-order Taylor methods",
Experimental Mathematics 14 (2005) 99.
"""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from tumble.scenarios.frames import Array
from tumble.scenarios.truth.compilation import inlined, inner, kernel
from tumble.scenarios.truth.double_double import add, over, pairs, root, times, two_product, two_sum
from tumble.scenarios.truth.rational import Fraction

LINEAR, PRODUCT, QUOTIENT, ROOT = 0, 1, 2, 3


class Program(NamedTuple):
    """operations, (n, 4): kind, left, right, offset, each giving the next series after the state's; rates: the series

    that are the state's rates, (states,); series: how many there are.  A linear operation sums coefficients[left:right]
    times the series terms[left:right], and at order 0 offsets[offset]; the others take the series left and right.
    """

    operations: np.ndarray
    terms: np.ndarray
    coefficients: Array
    coefficients_low: Array
    offsets: Array
    offsets_low: Array
    rates: np.ndarray
    series: int


@dataclass
class Expression:
    """A linear combination of series, which is not worked out before it is multiplied or asked for."""

    script: "Script"
    terms: dict[int, Fraction]
    offset: Fraction = field(default_factory=Fraction)

    def __add__(self, other: "Expression | Fraction") -> "Expression":
        if not isinstance(other, Expression):
            return Expression(self.script, self.terms, self.offset + other)
        terms = dict(self.terms)
        for row, factor in other.terms.items():
            terms[row] = terms.get(row, Fraction(0)) + factor
        return Expression(
            self.script, {row: factor for row, factor in terms.items() if factor}, self.offset + other.offset
        )

    __radd__ = __add__

    def __neg__(self) -> "Expression":
        return self * Fraction(-1)

    def __sub__(self, other: "Expression | Fraction") -> "Expression":
        return self + -other

    def __rsub__(self, other: Fraction) -> "Expression":
        return -self + other

    def __mul__(self, other: "Expression | Fraction") -> "Expression":
        if not isinstance(other, Expression):
            terms = {row: factor * other for row, factor in self.terms.items()} if other else {}
            return Expression(self.script, terms, self.offset * other)
        if not other.terms:
            return self * other.offset
        if not self.terms:
            return other * self.offset
        return self.script.operation(PRODUCT, self, other)

    __rmul__ = __mul__

    def __truediv__(self, other: "Expression") -> "Expression":
        return self.script.operation(QUOTIENT, self, other)

    def sqrt(self) -> "Expression":
        """Return the root."""
        return self.script.operation(ROOT, self, self)


class Script:
    """The operations as they are written down; the first series are the state's."""

    def __init__(self, states: int) -> None:
        self.count = states
        self._operations: list[tuple[int, int, int, int]] = []
        self._terms: list[int] = []
        self._coefficients: list[Fraction] = []
        self._offsets: list[Fraction] = []
        self._known: dict[tuple, int] = {}

    def state(self) -> np.ndarray:
        """Return the state's series, (states,)."""
        return np.array([Expression(self, {row: Fraction(1)}) for row in range(self.count)], dtype=object)

    def row(self, value: "Expression | Fraction | int") -> int:
        """Return the row of the series that an expression's value is."""
        if not isinstance(value, Expression):
            value = Expression(self, {}, Fraction(value))
        if not value.offset and list(value.terms.values()) == [1]:
            return next(iter(value.terms))
        key = (LINEAR, tuple(sorted(value.terms.items())), value.offset)
        if key not in self._known:
            begin = len(self._terms)
            self._terms += value.terms.keys()
            self._coefficients += value.terms.values()
            self._write(key, (LINEAR, begin, len(self._terms), len(self._offsets)))
            self._offsets.append(value.offset)
        return self._known[key]

    def operation(self, kind: int, left: Expression, right: Expression) -> Expression:
        """Return the series that an operation on two others gives."""
        rows = self.row(left), self.row(right)
        key = (kind, *(sorted(rows) if kind == PRODUCT else rows))
        if key not in self._known:
            self._write(key, (kind, *rows, 0))
        return Expression(self, {self._known[key]: Fraction(1)})

    def _write(self, key: tuple, operation: tuple[int, int, int, int]) -> None:
        self._known[key] = self.count
        self._operations.append(operation)
        self.count += 1

    def program(self, rates: list) -> Program:
        """Return all of it, given the state's rates."""
        rows = np.array([self.row(rate) for rate in rates])
        kinds = np.array(self._operations, dtype=np.int64).reshape(-1, 4)
        coefficients, offsets = pairs(self._coefficients), pairs(self._offsets)
        return Program(
            kinds,
            np.array(self._terms, dtype=np.int64),
            coefficients[0],
            coefficients[1],
            offsets[0],
            offsets[1],
            rows,
            self.count,
        )


@kernel
def expand(program: Program, h: float, high: Array, low: Array | None) -> None:
    """Write the series' coefficients, (series, order + 1), in t/h, from the state at order 0."""
    states, order = len(program.rates), high.shape[1] - 1
    for k in range(order + 1):
        for number in range(len(program.operations)):
            operation = program.operations[number]
            kind, left, right, offset = operation[0], operation[1], operation[2], operation[3]
            target = states + number
            if kind == LINEAR:
                combine(program, k, target, left, right, offset, high, low)
                continue
            a, b, first, last = summed(kind, left, right, target, k)
            convolve(high, low, a, b, first, last, k, target)
            if kind == QUOTIENT:
                divide(high, low, left, right, k, target)
            elif kind == ROOT:
                extract(high, low, left, k, target)
        if k < order:
            share = over((h, 0.0), (k + 1.0, 0.0))
            for state in range(states):
                rate = program.rates[state]
                if low is None:
                    high[state, k + 1] = high[rate, k] * share[0]
                else:
                    high[state, k + 1], low[state, k + 1] = times((high[rate, k], low[rate, k]), share)


@inlined
def combine(
    program: Program, k: int, target: int, begin: int, end: int, offset: int, high: Array, low: Array | None
) -> None:
    """Write a linear combination's k-th coefficient."""
    if low is None:
        plain = program.offsets[offset] if k == 0 else 0.0
        for term in range(begin, end):
            plain += program.coefficients[term] * high[program.terms[term], k]
        high[target, k] = plain
    else:
        total, rest = (program.offsets[offset], program.offsets_low[offset]) if k == 0 else (0.0, 0.0)
        for term in range(begin, end):
            row, factor = program.terms[term], program.coefficients[term]
            product, error = two_product(factor, high[row, k])
            total, lost = two_sum(total, product)
            rest += lost + (error + (factor * low[row, k] + program.coefficients_low[term] * high[row, k]))
        high[target, k], low[target, k] = two_sum(total, rest)


@inner
def convolve(high: Array, low: Array | None, a: int, b: int, first: int, last: int, k: int, target: int) -> None:
    """Write the sum of a_j b_(k-j) for j from first to last.

    The highs' products are summed with their errors, which are summed in doubles (Ogita, Rump & Oishi, "Accurate sum
    and dot product", SIAM J. Sci. Comput. 26 (2005) 1955): as good as numbers of 32 digits.
    """
    if low is None:
        plain = 0.0
        for j in range(first, last + 1):
            plain += high[a, j] * high[b, k - j]
        high[target, k] = plain
    else:
        # Two sums at a time keep the processor busy.
        total, rest, other, other_rest = 0.0, 0.0, 0.0, 0.0
        j = first
        while j < last:
            i = k - j
            product, error = two_product(high[a, j], high[b, i])
            total, lost = two_sum(total, product)
            rest += lost + (error + (high[a, j] * low[b, i] + low[a, j] * high[b, i]))
            product, error = two_product(high[a, j + 1], high[b, i - 1])
            other, lost = two_sum(other, product)
            other_rest += lost + (error + (high[a, j + 1] * low[b, i - 1] + low[a, j + 1] * high[b, i - 1]))
            j += 2
        if j == last:
            product, error = two_product(high[a, j], high[b, k - j])
            total, lost = two_sum(total, product)
            rest += lost + (error + (high[a, j] * low[b, k - j] + low[a, j] * high[b, k - j]))
        total, lost = two_sum(total, other)
        high[target, k], low[target, k] = two_sum(total, lost + (rest + other_rest))


@inlined
def summed(kind: int, left: int, right: int, target: int, k: int) -> tuple[int, int, int, int]:
    """Return the series whose products the k-th coefficient of an operation sums, and the first and last of these."""
    if kind == QUOTIENT:
        return right, target, 1, k
    if kind == ROOT:
        return target, target, 1, k - 1
    return left, right, 0, k


@inlined
def divide(high: Array, low: Array | None, a: int, b: int, k: int, target: int) -> None:
    """Write a quotient's k-th coefficient, where the sum is: c_k = (a_k - sum over j >= 1 of b_j c_(k-j)) / b_0."""
    if low is None:
        high[target, k] = (high[a, k] - high[target, k]) / high[b, 0]
    else:
        rest = add((high[a, k], low[a, k]), (-high[target, k], -low[target, k]))
        high[target, k], low[target, k] = over(rest, (high[b, 0], low[b, 0]))


@inlined
def extract(high: Array, low: Array | None, a: int, k: int, target: int) -> None:
    """Write a root's k-th coefficient, where the sum is: r_k = (a_k - sum of r_j r_(k-j), 0 < j < k) / 2 r_0."""
    if k == 0:
        if low is None:
            high[target, 0] = np.sqrt(high[a, 0])
        else:
            high[target, 0], low[target, 0] = root((high[a, 0], low[a, 0]))
        return
    if low is None:
        high[target, k] = (high[a, k] - high[target, k]) / (2.0 * high[target, 0])
    else:
        rest = add((high[a, k], low[a, k]), (-high[target, k], -low[target, k]))
        high[target, k], low[target, k] = over(rest, (2.0 * high[target, 0], 2.0 * low[target, 0]))


@inner
def value_at(high: Array, low: Array | None, row: int, s: tuple[float, float]) -> tuple[float, float]:
    """Return a series' value at t/h = s, by Horner's rule."""
    if low is None:
        plain = 0.0
        for k in range(high.shape[1] - 1, -1, -1):
            plain = plain * s[0] + high[row, k]
        return plain, 0.0
    total = (0.0, 0.0)
    for k in range(high.shape[1] - 1, -1, -1):
        total = add(times(total, s), (high[row, k], low[row, k]))
    return total
