"""Four numbers in one vector register: the same formula at four instants costs what it costs at one.

As in `tumble.solver.fused` the operations are said outright: the compiler finds no register in code on tuples.
"""

from collections.abc import Callable, Sequence
from typing import Any, cast

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic
from numpy.typing import NDArray

from tumble.solver.fused import FOUR, LANE, REGISTER, multiply_add, packed, spread, unpacked

Four = tuple[float, float, float, float]
Array = NDArray[np.float64]
Places = tuple[int, int, int, int]


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


@intrinsic
def _transpose_four(typing_context, to, places_to, source, places):
    def codegen(context, builder, signature, arguments):
        to, places_to, source, places = arguments
        rows = [builder.load(each, align=8) for each in _places(context, builder, signature.args[2], source, places)]
        even = [_mixed(builder, pair, (0, 4, 2, 6)) for pair in (rows[:2], rows[2:])]
        odd = [_mixed(builder, pair, (1, 5, 3, 7)) for pair in (rows[:2], rows[2:])]
        columns = [_mixed(builder, pair, lanes) for lanes in ((0, 1, 4, 5), (2, 3, 6, 7)) for pair in (even, odd)]
        where = _places(context, builder, signature.args[0], to, places_to)
        for column, place in zip(columns, where, strict=True):
            builder.store(column, place, align=8)
        return context.get_dummy_value()

    four_places = types.UniTuple(types.intp, 4)
    return types.void(to, four_places, source, four_places), codegen


def _places(context: Any, builder: ir.IRBuilder, kind: Any, array: Any, places: Any) -> list[Any]:
    """Return where four numbers begin, as registers, from their four indices in the memory of an array."""
    data = context.make_array(kind)(context, builder, array).data
    indices = [builder.extract_value(places, number) for number in range(4)]
    return [builder.bitcast(builder.gep(data, [index]), REGISTER.as_pointer()) for index in indices]


def _mixed(builder: ir.IRBuilder, pair: Sequence[Any], lanes: tuple[int, ...]) -> Any:
    """Return the register of these lanes of two, those of the second numbered from four."""
    one, other = pair
    return builder.shuffle_vector(one, other, ir.Constant(ir.VectorType(LANE, 4), lanes))


# The same number four times.
all_four = cast(Callable[[float], Four], _all_four)
# a b + c, with one rounding; a b; a + b; a - b; a / b.
fused_four = cast(Callable[[Four, Four, Four], Four], _fused_four)
times_four = cast(Callable[[Four, Four], Four], _times_four)
plus_four = cast(Callable[[Four, Four], Four], _plus_four)
minus_four = cast(Callable[[Four, Four], Four], _minus_four)
over_four = cast(Callable[[Four, Four], Four], _over_four)
# transpose_four(to, places_to, source, places): copy four numbers that follow each other at each of four places as the
# columns of four others.  Places are indices in the memory of an array, as if it were flat.
transpose_four = cast(Callable[[Array, Places, Array, Places], None], _transpose_four)
