"""Several doubles side by side in one vector of the processor, with operators, in compiled code.

A formula that is written for a number works on `WIDTH` throws at once.  A branch becomes `where`, and a loop goes on
while any lane needs it and leaves the others as they are, so that a lane's bits depend on nothing but itself.
"""

import math
import operator
from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba import types
from numba.core.typing.templates import ConcreteTemplate, infer_global
from numba.extending import intrinsic, lower_builtin, models, register_model

# Two registers of four doubles, or one of eight.
WIDTH = 8
VECTOR, BITS = ir.VectorType(ir.DoubleType(), WIDTH), ir.VectorType(ir.IntType(1), WIDTH)


class LanesType(types.Type):
    """The type of WIDTH doubles."""

    def __init__(self) -> None:
        super().__init__(name="Lanes")


class MaskType(types.Type):
    """The type of WIDTH truth values."""

    def __init__(self) -> None:
        super().__init__(name="Mask")


LANES, MASK = LanesType(), MaskType()


@register_model(LanesType)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, VECTOR)


@register_model(MaskType)
class _MaskModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, BITS)


def _repeated(builder: Any, kind: Any, value: Any) -> Any:
    """Return a double as lanes; what is lanes or a mask as it is."""
    if kind is not types.float64:
        return value
    alone = builder.insert_element(ir.Constant(VECTOR, ir.Undefined), value, ir.IntType(32)(0))
    return builder.shuffle_vector(
        alone, ir.Constant(VECTOR, ir.Undefined), ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [0] * WIDTH)
    )


def instruction(function: Callable) -> Callable[..., Any]:
    """Let compiled code call what a function returns the instructions of."""
    return intrinsic(function)


def _give_meaning(symbol: Callable, found: types.Type, made: Callable[..., Any], *operands: tuple) -> None:
    """Let an operator of these operands mean an instruction."""
    declare: Any = infer_global(symbol)
    declare(type("Meaning", (ConcreteTemplate,), {"cases": [found(*kinds) for kinds in operands]}))

    def lowered(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return made(builder, *(_repeated(builder, *one) for one in zip(signature.args, arguments, strict=True)))

    for kinds in operands:
        lower_builtin(symbol, *kinds)(lowered)


TWO = (LANES, LANES), (LANES, types.float64), (types.float64, LANES)
for _symbol, _instruction in (
    (operator.add, "fadd"), (operator.sub, "fsub"), (operator.mul, "fmul"), (operator.truediv, "fdiv"),
):  # fmt: skip
    _give_meaning(_symbol, LANES, lambda builder, a, b, name=_instruction: getattr(builder, name)(a, b), *TWO)
for _symbol, _words in (
    (operator.lt, "<"), (operator.le, "<="), (operator.gt, ">"), (operator.ge, ">="), (operator.eq, "=="),
):  # fmt: skip
    _give_meaning(_symbol, MASK, lambda builder, a, b, words=_words: builder.fcmp_ordered(words, a, b), *TWO)
_give_meaning(operator.ne, MASK, lambda builder, a, b: builder.fcmp_unordered("!=", a, b), *TWO)
_give_meaning(operator.neg, LANES, lambda builder, a: builder.fneg(a), (LANES,))
_give_meaning(operator.and_, MASK, lambda builder, a, b: builder.and_(a, b), (MASK, MASK))
_give_meaning(operator.or_, MASK, lambda builder, a, b: builder.or_(a, b), (MASK, MASK))
_give_meaning(operator.invert, MASK, lambda builder, a: builder.not_(a), (MASK,))


def _called(name: str, count: int) -> Any:
    """Return an intrinsic of LLVM's that takes lanes and returns lanes."""
    function = ir.FunctionType(VECTOR, [VECTOR] * count)

    def made(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.call(builder.module.declare_intrinsic(f"llvm.{name}.v{WIDTH}f64", fnty=function), arguments)

    return made


@instruction
def root_of(typing_context: Any, a: Any) -> Any:
    """Return the square roots."""
    return LANES(LANES), _called("sqrt", 1)


@instruction
def whole(typing_context: Any, a: Any) -> Any:
    """Return the nearest whole numbers, of two the even one."""
    return LANES(LANES), _called("rint", 1)


@instruction
def below(typing_context: Any, a: Any) -> Any:
    """Return the largest whole numbers that are not above."""
    return LANES(LANES), _called("floor", 1)


@instruction
def size(typing_context: Any, a: Any) -> Any:
    """Return the absolute values."""
    return LANES(LANES), _called("fabs", 1)


@instruction
def lanes(typing_context: Any, a: Any) -> Any:
    """Return a double in every lane."""
    kind = LANES if a is LANES else types.float64
    return LANES(kind), lambda context, builder, signature, arguments: _repeated(builder, kind, arguments[0])


@instruction
def chosen(typing_context: Any, mask: Any, a: Any, b: Any) -> Any:
    """Return a where the mask is true, else b."""
    return LANES(MASK, LANES, LANES), lambda context, builder, signature, arguments: builder.select(*arguments)


@instruction
def any_of(typing_context: Any, mask: Any) -> Any:
    """Return whether a mask is true in any lane."""

    def made(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        bits = builder.bitcast(arguments[0], ir.IntType(WIDTH))
        return builder.icmp_unsigned("!=", bits, ir.IntType(WIDTH)(0))

    return types.boolean(MASK), made


def _place(context: Any, builder: Any, kind: Any, array: Any, place: Any) -> Any:
    """Return the address of lanes in an array, (..., WIDTH)."""
    data = context.make_array(kind)(context, builder, array).data
    return builder.gep(builder.bitcast(data, ir.PointerType(ir.ArrayType(ir.DoubleType(), WIDTH))), [place])


@instruction
def load(typing_context: Any, array: Any, place: Any) -> Any:
    """Return lanes out of an array, (..., WIDTH), by their number in it."""

    def made(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        address = _place(context, builder, signature.args[0], *arguments)
        return builder.load(builder.bitcast(address, ir.PointerType(VECTOR)), align=8)

    return LANES(array, types.intp), made


@instruction
def store(typing_context: Any, array: Any, place: Any, value: Any) -> Any:
    """Write lanes into an array, (..., WIDTH), by their number in it."""

    def made(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        address = _place(context, builder, signature.args[0], *arguments[:2])
        builder.store(arguments[2], builder.bitcast(address, ir.PointerType(VECTOR)), align=8)
        return context.get_dummy_value()

    return types.void(array, types.intp, LANES), made


def _each(function: Callable, count: int) -> Any:
    """Return what calls a function of doubles for each lane."""
    kinds = types.float64(*[types.float64] * count)

    def made(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        context.typing_context.resolve_value_type(function)
        called = context.get_function(function, kinds)
        found = ir.Constant(VECTOR, ir.Undefined)
        for lane in range(WIDTH):
            place = ir.IntType(32)(lane)
            one = called(builder, [builder.extract_element(value, place) for value in arguments])
            found = builder.insert_element(found, one, place)
        return found

    return made


@instruction
def cosine(typing_context: Any, a: Any) -> Any:
    """Return the cosines."""
    return LANES(LANES), _each(math.cos, 1)


@instruction
def sine(typing_context: Any, a: Any) -> Any:
    """Return the sines."""
    return LANES(LANES), _each(math.sin, 1)


@instruction
def arctangent(typing_context: Any, a: Any) -> Any:
    """Return the angles with these tangents."""
    return LANES(LANES), _each(math.atan, 1)


@instruction
def direction(typing_context: Any, y: Any, x: Any) -> Any:
    """Return the angles of the vectors (x, y)."""
    return LANES(LANES, LANES), _each(math.atan2, 2)
