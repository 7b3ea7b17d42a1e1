"""Four numbers in one vector register: the same formula at four instants costs what it costs at one.

As in `tumble.solver.fused` the operations are said outright: the compiler finds no register in code on tuples.
"""

from collections.abc import Callable
from typing import Any, cast

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from tumble.solver.fused import FOUR, REGISTER, multiply_add, packed, spread, unpacked

Four = tuple[float, float, float, float]


@intrinsic
def _all_four(typing_context, number):
    def codegen(context, builder, signature, arguments):
        return unpacked(builder, spread(builder, arguments[0]))

    return FOUR(types.float64), codegen


@intrinsic
def _fused_four(typing_context, a, b, c):
    def codegen(context, builder, signature, arguments):
        return unpacked(builder, multiply_add(builder, REGISTER, *(packed(builder, each) for each in arguments)))

    return FOUR(FOUR, FOUR, FOUR), codegen


def _pairwise(instruction: str) -> Any:
    """Return the code of an instruction between four numbers and four others."""

    def codegen(context: Any, builder: ir.IRBuilder, signature: Any, arguments: Any) -> Any:
        return unpacked(builder, getattr(builder, instruction)(*(packed(builder, each) for each in arguments)))

    return codegen


@intrinsic
def _times_four(typing_context, a, b):
    return FOUR(FOUR, FOUR), _pairwise("fmul")


@intrinsic
def _plus_four(typing_context, a, b):
    return FOUR(FOUR, FOUR), _pairwise("fadd")


@intrinsic
def _minus_four(typing_context, a, b):
    return FOUR(FOUR, FOUR), _pairwise("fsub")


@intrinsic
def _over_four(typing_context, a, b):
    return FOUR(FOUR, FOUR), _pairwise("fdiv")


# The same number four times.
all_four = cast(Callable[[float], Four], _all_four)
# a b + c, with one rounding; a b; a + b; a - b; a / b.
fused_four = cast(Callable[[Four, Four, Four], Four], _fused_four)
times_four = cast(Callable[[Four, Four], Four], _times_four)
plus_four = cast(Callable[[Four, Four], Four], _plus_four)
minus_four = cast(Callable[[Four, Four], Four], _minus_four)
over_four = cast(Callable[[Four, Four], Four], _over_four)
