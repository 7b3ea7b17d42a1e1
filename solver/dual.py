"""A number and how it changes in sixteen directions: a formula on numbers gives its derivatives with its value.

The directions are two times eight: of places and of speeds.  Derivatives are exact to rounding, and each operation
costs a few more of vectors.
Source: Clifford, "Preliminary sketch of biquaternions" (1873); Griewank & Walther, "Evaluating derivatives" (2008),
section 3.1.
"""

# numba passes options and the context of types where pyright cannot know of them.
# pyright: reportArgumentType=false, reportCallIssue=false

import operator
from collections.abc import Callable
from typing import Any, cast

from numba import types
from numba.core.imputils import lower_cast
from numba.extending import intrinsic, models, overload, register_model

from tumble.solver.compilation import INNER_OPTIONS
from tumble.solver.eight import (
    DOUBLE,
    EIGHT,
    Eight,
    Several,
    called,
    constant,
    operate,
    over,
    presses,
    pressing,
    root,
    spread,
)

# A number, or one with its derivatives.  Python has only numbers.
Dual = float


class _Dual(Several):
    """A number, its derivatives by eight places and those by eight speeds."""

    def __init__(self) -> None:
        super().__init__("dual")


DUAL = _Dual()
PARTS = "value", "by_place", "by_speed"


@register_model(_Dual)
class _Model(models.StructModel):
    def __init__(self, manager: Any, kind: types.Type) -> None:
        super().__init__(manager, kind, list(zip(PARTS, (types.float64, EIGHT, EIGHT), strict=True)))


def _packed(builder: Any, context: Any, parts: Any) -> Any:
    """Return a number and its derivatives as one."""
    dual = context.get_constant_undef(DUAL)
    for number, part in enumerate(parts):
        dual = builder.insert_value(dual, part, number)
    return dual


@lower_cast(types.Float, DUAL)
def _become_dual(context: Any, builder: Any, from_type: Any, to_type: Any, number: Any) -> Any:
    value = context.cast(builder, number, from_type, types.float64)
    return _packed(builder, context, (value, constant(0.0), constant(0.0)))


class _Rule:
    """The code of an operation: its value, and the sum of what its operands' derivatives count for."""

    def __init__(self, context: Any, builder: Any, kinds: Any, arguments: Any) -> None:
        self.context, self.builder, self.kinds, self.arguments = context, builder, kinds, arguments
        self.values = [
            builder.extract_value(each, 0) if kind == DUAL else context.cast(builder, each, kind, types.float64)
            for kind, each in zip(kinds, arguments, strict=True)
        ]

    def result(self, value: Any, *factors: Any) -> Any:
        """Return a value with its derivatives; a factor for each operand, None for one."""
        parts = [value]
        for place in (1, 2):
            total = None
            for kind, each, factor in zip(self.kinds, self.arguments, factors, strict=True):
                if kind == DUAL:
                    total = self._plus(total, self.builder.extract_value(each, place), factor)
            parts.append(total)
        return _packed(self.builder, self.context, parts)

    def _plus(self, total: Any, change: Any, factor: Any) -> Any:
        if factor is None:
            return change if total is None else self.builder.fadd(total, change)
        factors = spread(self.builder, factor)
        if total is None:
            return self.builder.fmul(factors, change)
        return called(self.builder, "fma", factors, change, total)


def _sum(context: Any, builder: Any, kinds: Any, arguments: Any) -> Any:
    rule = _Rule(context, builder, kinds, arguments)
    return rule.result(builder.fadd(*rule.values), None, None)


def _difference(context: Any, builder: Any, kinds: Any, arguments: Any) -> Any:
    rule = _Rule(context, builder, kinds, arguments)
    return rule.result(builder.fsub(*rule.values), None, DOUBLE(-1.0))


def _product(context: Any, builder: Any, kinds: Any, arguments: Any) -> Any:
    rule = _Rule(context, builder, kinds, arguments)
    a, b = rule.values
    return rule.result(builder.fmul(a, b), b, a)


def _quotient(context: Any, builder: Any, kinds: Any, arguments: Any) -> Any:
    rule = _Rule(context, builder, kinds, arguments)
    a, b = rule.values
    value, inverse = builder.fdiv(a, b), builder.fdiv(DOUBLE(1.0), b)
    return rule.result(value, inverse, builder.fneg(builder.fmul(value, inverse)))


def _negative(context: Any, builder: Any, kinds: Any, arguments: Any) -> Any:
    rule = _Rule(context, builder, kinds, arguments)
    return rule.result(builder.fneg(rule.values[0]), DOUBLE(-1.0))


for _of, _code in (
    (operator.add, _sum),
    (operator.sub, _difference),
    (operator.mul, _product),
    (operator.truediv, _quotient),
):
    operate(_of, DUAL, _code)
operate(operator.neg, DUAL, _negative, count=1)


def _where(builder: Any, condition: Any, number: Any) -> Any:
    return builder.select(condition, number, DOUBLE(0.0))


@intrinsic
def _pressing_dual(typing_context, height, load):
    def codegen(context, builder, signature, arguments):
        rule = _Rule(context, builder, signature.args, arguments)
        does = presses(builder, *rule.values)
        return rule.result(_where(builder, does, rule.values[1]), DOUBLE(0.0), _where(builder, does, DOUBLE(1.0)))

    return DUAL(DUAL, DUAL), codegen


@intrinsic
def _root_dual(typing_context, square):
    def codegen(context, builder, signature, arguments):
        rule = _Rule(context, builder, signature.args, arguments)
        value = called(builder, "sqrt", rule.values[0])
        is_long = builder.fcmp_unordered("!=", value, DOUBLE(0.0))
        return rule.result(value, _where(builder, is_long, builder.fdiv(DOUBLE(0.5), value)))

    return DUAL(DUAL), codegen


@intrinsic
def _over_dual(typing_context, number, length):
    def codegen(context, builder, signature, arguments):
        rule = _Rule(context, builder, signature.args, arguments)
        a, b = rule.values
        is_long = builder.fcmp_unordered("!=", b, DOUBLE(0.0))
        inverse = _where(builder, is_long, builder.fdiv(DOUBLE(1.0), b))
        value = _where(builder, is_long, builder.fdiv(a, b))
        return rule.result(value, inverse, builder.fneg(builder.fmul(value, inverse)))

    return DUAL(DUAL, DUAL), codegen


@overload(pressing, jit_options=INNER_OPTIONS, strict=False)
def _pressing_by_type(height: types.Type, load: types.Type) -> Callable | None:
    return (lambda height, load: _pressing_dual(height, load)) if DUAL in (height, load) else None


@overload(root, jit_options=INNER_OPTIONS, strict=False)
def _root_by_type(square: types.Type) -> Callable | None:
    return (lambda square: _root_dual(square)) if square == DUAL else None


@overload(over, jit_options=INNER_OPTIONS, strict=False)
def _over_by_type(number: types.Type, length: types.Type) -> Callable | None:
    return (lambda number, length: _over_dual(number, length)) if DUAL in (number, length) else None


@intrinsic
def _dual(typing_context, value, by_place, by_speed):
    def codegen(context, builder, signature, arguments):
        return _packed(builder, context, arguments)

    return DUAL(types.float64, EIGHT, EIGHT), codegen


@intrinsic
def _parts(typing_context, dual):
    def codegen(context, builder, signature, arguments):
        parts = [builder.extract_value(arguments[0], number) for number in range(len(PARTS))]
        return context.make_tuple(builder, signature.return_type, parts)

    return types.Tuple((types.float64, EIGHT, EIGHT))(DUAL), codegen


# A number with its derivatives by places and by speeds; and those three again.
dual = cast(Callable[[float, Eight, Eight], Dual], _dual)
parts = cast(Callable[[Dual], tuple[float, Eight, Eight]], _parts)
