"""Eight numbers in one vector register, to which a formula on numbers applies as it stands.

A force law that takes the numbers of one instant takes those of eight: in a sum, a product or a quotient either side
may be one number, which then counts eight times.  Eight numbers cannot take two ways: what would be a branch on a
number is one of the functions below, which take both.  On a processor without 512-bit vectors they lie in two registers
or four, and are the same to the last bit.
"""

# numba passes options and the context of types where pyright cannot know of them.
# pyright: reportArgumentType=false, reportCallIssue=false

import math
import operator
from collections.abc import Callable, Sequence
from typing import Any, cast

import numpy as np
from llvmlite import ir
from numba import types
from numba.core.imputils import lower_cast
from numba.core.typeconv.castgraph import Conversion
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, models, overload, register_model
from numpy.typing import NDArray

from tumble.solver.compilation import INNER_OPTIONS

Array = NDArray[np.float64]

COUNT = 8
DOUBLE, LANE = ir.DoubleType(), ir.IntType(32)
REGISTER = ir.VectorType(DOUBLE, COUNT)
OPERATIONS = {operator.add: "fadd", operator.sub: "fsub", operator.mul: "fmul", operator.truediv: "fdiv"}

# One number or eight.  Python has only one.
Eight = float


class Several(types.Type):
    """What stands for a number in a formula, and what a number can become."""

    def unify(self, typingctx: Any, other: types.Type) -> types.Type | None:
        """Return what holds both this and a number: this."""
        return self if isinstance(other, types.Float) else None

    def can_convert_from(self, typingctx: Any, other: types.Type) -> Conversion | None:
        """Return how a number becomes this: without loss."""
        return Conversion.safe if isinstance(other, types.Float) else None


class _Eight(Several):
    """Eight numbers."""

    def __init__(self) -> None:
        super().__init__("eight")


EIGHT = _Eight()


@register_model(_Eight)
class _Model(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: types.Type) -> None:
        super().__init__(manager, kind, REGISTER)


def constant(number: float) -> ir.Constant:
    """Return a register of which all lanes are one number."""
    return ir.Constant(REGISTER, [number] * COUNT)


def spread(builder: Any, number: Any) -> Any:
    """Return a register of which all lanes are one number."""
    nothing = ir.Constant(REGISTER, ir.Undefined)
    return _mixed(builder, builder.insert_element(nothing, number, LANE(0)), nothing, [0] * COUNT)


def _mixed(builder: Any, a: Any, b: Any, lanes: Sequence[int]) -> Any:
    """Return the register of these lanes of two, those of the second numbered from eight."""
    return builder.shuffle_vector(a, b, ir.Constant(ir.VectorType(LANE, COUNT), list(lanes)))


def called(builder: Any, name: str, *arguments: Any) -> Any:
    """Return what an instruction of LLVM makes of registers, or of numbers."""
    kind = arguments[0].type
    suffix = f"v{COUNT}f64" if kind == REGISTER else "f64"
    function = ir.FunctionType(kind, [kind] * len(arguments))
    return builder.call(builder.module.declare_intrinsic(f"llvm.{name}.{suffix}", fnty=function), arguments)


def operate(of: Callable, kind: types.Type, lowered: Callable, count: int = 2) -> None:
    """Let an operator take what stands for numbers; lowered: its code, from the operands' types and values."""

    @infer_global(of)  # pyright: ignore[reportOptionalCall]
    class _Typed(AbstractTemplate):
        def generic(self, args: Any, kws: Any) -> Any:
            fit = len(args) == count and kind in args and all(a == kind or isinstance(a, types.Float) for a in args)
            return signature(kind, *args) if fit else None

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return lowered(context, builder, signature.args, arguments)

    for number in range(1, 2**count):
        lower_builtin(of, *(kind if number >> place & 1 else types.Float for place in range(count)))(code)


@lower_cast(types.Float, EIGHT)
def _become_eight(context: Any, builder: Any, from_type: Any, to_type: Any, number: Any) -> Any:
    return spread(builder, context.cast(builder, number, from_type, types.float64))


def _eightfold(instruction: str) -> Callable:
    """Return the code of an instruction."""

    def code(context: Any, builder: Any, kinds: Any, arguments: Any) -> Any:
        eights = [context.cast(builder, each, kind, EIGHT) for kind, each in zip(kinds, arguments, strict=True)]
        return getattr(builder, instruction)(*eights)

    return code


for _of, _instruction in OPERATIONS.items():
    operate(_of, EIGHT, _eightfold(_instruction))
operate(operator.neg, EIGHT, _eightfold("fneg"), count=1)


def pressing(height: Eight, load: Eight) -> Eight:
    """Return a load where it is positive and the height is not, and nothing elsewhere."""
    return load if height < 0.0 and load > 0.0 else 0.0


def root(square: Eight) -> Eight:
    """Return the root of a number."""
    return math.sqrt(square)


def over(number: Eight, length: Eight) -> Eight:
    """Return a number over a length, and nothing over no length."""
    return number / length if length != 0.0 else 0.0


@intrinsic
def _pressing_eight(typing_context, height, load):
    def codegen(context, builder, signature, arguments):
        return builder.select(presses(builder, *arguments), arguments[1], constant(0.0))

    return EIGHT(EIGHT, EIGHT), codegen


def presses(builder: Any, height: Any, load: Any) -> Any:
    """Return where a load is positive and the height is not."""
    nothing = ir.Constant(height.type, [0.0] * COUNT if height.type == REGISTER else 0.0)
    return builder.and_(builder.fcmp_ordered("<", height, nothing), builder.fcmp_ordered(">", load, nothing))


@intrinsic
def _root_eight(typing_context, square):
    def codegen(context, builder, signature, arguments):
        return called(builder, "sqrt", *arguments)

    return EIGHT(EIGHT), codegen


@intrinsic
def _over_eight(typing_context, number, length):
    def codegen(context, builder, signature, arguments):
        is_long = builder.fcmp_unordered("!=", arguments[1], constant(0.0))
        return builder.select(is_long, builder.fdiv(*arguments), constant(0.0))

    return EIGHT(EIGHT, EIGHT), codegen


@overload(pressing, jit_options=INNER_OPTIONS, strict=False)
def _pressing_by_type(height: types.Type, load: types.Type) -> Callable | None:
    if EIGHT in (height, load):
        return lambda height, load: _pressing_eight(height, load)
    return pressing if isinstance(height, types.Float) and isinstance(load, types.Float) else None


@overload(root, jit_options=INNER_OPTIONS, strict=False)
def _root_by_type(square: types.Type) -> Callable | None:
    if square == EIGHT:
        return lambda square: _root_eight(square)
    return root if isinstance(square, types.Float) else None


@overload(over, jit_options=INNER_OPTIONS, strict=False)
def _over_by_type(number: types.Type, length: types.Type) -> Callable | None:
    if EIGHT in (number, length):
        return lambda number, length: _over_eight(number, length)
    return over if isinstance(number, types.Float) and isinstance(length, types.Float) else None


@intrinsic
def _fused_eight(typing_context, a, b, c):
    def codegen(context, builder, signature, arguments):
        return called(builder, "fma", *arguments)

    return EIGHT(EIGHT, EIGHT, EIGHT), codegen


@intrinsic
def _loaded(typing_context, array, row):
    def codegen(context, builder, signature, arguments):
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        begin = builder.mul(arguments[1], ir.Constant(arguments[1].type, COUNT))
        return builder.load(builder.bitcast(builder.gep(data, [begin]), REGISTER.as_pointer()), align=8)

    return EIGHT(array, types.intp), codegen


@intrinsic
def _lane(typing_context, eight, number):
    def codegen(context, builder, signature, arguments):
        return builder.extract_element(*arguments)

    return types.float64(EIGHT, types.intp), codegen


@intrinsic
def _with_lane(typing_context, eight, number, value):
    def codegen(context, builder, signature, arguments):
        eight, number, value = arguments
        return builder.insert_element(eight, value, number)

    return EIGHT(EIGHT, types.intp, types.float64), codegen


@intrinsic
def _eight(typing_context, number):
    def codegen(context, builder, signature, arguments):
        return arguments[0]

    return EIGHT(EIGHT), codegen


@intrinsic
def _transposed(typing_context, rows):
    def codegen(context, builder, signature, arguments):
        columns = [builder.extract_value(arguments[0], number) for number in range(COUNT)]
        # Blocks of 4, of 2 and of 1 change places across the diagonal.
        for size in (4, 2, 1):
            low = [lane if not lane & size else COUNT + lane - size for lane in range(COUNT)]
            high = [lane + size if not lane & size else COUNT + lane for lane in range(COUNT)]
            for first in (number for number in range(COUNT) if not number & size):
                a, b = columns[first], columns[first + size]
                columns[first], columns[first + size] = _mixed(builder, a, b, low), _mixed(builder, a, b, high)
        return context.make_tuple(builder, signature.return_type, columns)

    eights = types.UniTuple(EIGHT, COUNT)
    return eights(eights), codegen


# Eight times the same number, or eight as they are.
eight = cast(Callable[[Eight], Eight], _eight)
# a b + c, with one rounding.
fused_eight = cast(Callable[[Eight, Eight, Eight], Eight], _fused_eight)
# A row of an array, (N, 8), as eight numbers.
loaded = cast(Callable[[Array, int], Eight], _loaded)
# One of eight numbers; eight numbers of which one is another.
lane = cast(Callable[[Eight, int], float], _lane)
with_lane = cast(Callable[[Eight, int, float], Eight], _with_lane)
# Eight times eight numbers, the first of each first.
transposed = cast(Callable[[tuple[Eight, ...]], tuple[Eight, ...]], _transposed)
