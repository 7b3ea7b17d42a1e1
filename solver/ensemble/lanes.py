"""How a function of one throw becomes a lane: plain arithmetic that LLVM lays out over a vector of throws.

A call that is left in the loop over lanes keeps it scalar, ten times slower: lane functions are inlined by force, and
there is no sine, exponential or logarithm in them, and no loop.

Unlike the solver's other kernels those of lanes contract a product and a sum to a fused multiply-add, which is a third
faster here.  Every throw meets the same instructions, so its bits depend on nothing but itself and the machine.
"""

from collections.abc import Callable
from typing import TypeVar, cast

from numba import njit, types
from numba.extending import intrinsic

from tumble.kernel_cache import keep
from tumble.solver import quaternion, vectors
from tumble.solver.compilation import OPTIONS, SOURCE

F = TypeVar("F", bound=Callable)

LANE_OPTIONS = {**OPTIONS, "fastmath": {"contract"}}


def lane(function: F) -> F:
    """Compile a function on numbers and tuples, or a scalar function of the solver anew, into whatever calls it."""
    return cast(F, njit(**LANE_OPTIONS, forceinline=True)(getattr(function, "py_func", function)))


def lanes_kernel(function: F) -> F:
    """Compile a loop over lanes, keep it on disk, and let other threads run beside it."""
    return cast(F, keep(njit(**LANE_OPTIONS, nogil=True)(function), SOURCE))


@intrinsic
def _widest_vectors(typing_context):
    def codegen(context, builder, signature, arguments):
        # llvmlite lets through only the attributes it knows itself.
        set.add(builder.function.attributes, '"prefer-vector-width"="512"')
        return context.get_dummy_value()

    return types.void(), codegen


# A kernel that calls this uses 512-bit vectors where the processor has them.  LLVM holds on to 256 bits on Intel's, for
# fear of a lower clock: here that would cost a factor of 1.7.
widest_vectors = cast(Callable[[], None], _widest_vectors)

add = lane(vectors.add)
scale = lane(vectors.scale)
times = lane(vectors.times)
dot = lane(vectors.dot)
cross = lane(vectors.cross)
product = lane(quaternion.product)
