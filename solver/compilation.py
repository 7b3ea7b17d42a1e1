"""How the solver is compiled.

`scalar` is for the small functions on tuples that kernels are written with: LLVM inlines them, so that a whole step
lives in registers.  `kernel` is for the loops that Python calls: kept on disk, so that a second process compiles
nothing.  What is on disk is renewed when the kernel's own file changes, and only then: after a change to a scalar
function, `__pycache__` must go.

Division by zero gives inf or nan, for a judge to see.  Fast-math is off, and so is contraction to fused multiply-adds:
it buys 5 % here, and the last bits would depend on the processor and on how a loop happened to be compiled.
"""

from collections.abc import Callable
from typing import TypeVar, cast

from numba import njit

F = TypeVar("F", bound=Callable)

# Nobody calls these from C, and the wrapper for it is a seventh of a cold start.
OPTIONS = {"error_model": "numpy", "no_cfunc_wrapper": True}


def scalar(function: F) -> F:
    """Compile a function on numbers and tuples of numbers, to be called from kernels."""
    return cast(F, njit(**OPTIONS)(function))


def kernel(function: F) -> F:
    """Compile a loop over the rows of an array, and keep it on disk."""
    return cast(F, njit(**OPTIONS, cache=True)(function))
