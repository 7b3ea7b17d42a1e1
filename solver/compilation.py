"""How the solver is compiled.

`scalar` is for the small functions on tuples that kernels are written with: LLVM inlines them, so that a whole step
lives in registers.  `inner` is for those of them that only kernels call, `inlined` for large ones, `borrowing` for
those that take arrays.  `kernel` is for the loops that Python calls: kept on disk, so that a second process compiles
nothing.  numba renews what is on disk when the kernel's own file changes, but not when a scalar function elsewhere
does: so each state of the solver's source has a folder of its own (`tumble.kernel_cache`).

Division by zero gives inf or nan, for a judge to see.  Fast-math is off, and so is contraction to fused multiply-adds,
for the last bits would depend on the processor and on how a loop happened to be compiled: `tumble.solver.fused` says
them.
"""

from collections.abc import Callable
from functools import cached_property, update_wrapper
from pathlib import Path
from typing import Any, TypeVar, cast

from numba import njit, types
from numba.extending import typeof_impl

from tumble.kernel_cache import keep
from tumble.kernel_parts import KernelCompiler, PartCompiler

SOURCE = Path(__file__).parent

F = TypeVar("F", bound=Callable)

# Fast-math is said to be off, not left unsaid: a function first compiled for a lane would inherit the lane's, and its
# last bits would depend on who asked first.  Nobody calls these from C, and the wrapper for it is a seventh of a cold
# start.
OPTIONS: dict[str, Any] = {
    "error_model": "numpy",
    "fastmath": False,
    "no_cfunc_wrapper": True,
    "pipeline_class": KernelCompiler,
}
INNER_OPTIONS: dict[str, Any] = {**OPTIONS, "no_cpython_wrapper": True, "pipeline_class": PartCompiler}
BORROWING_OPTIONS: dict[str, Any] = {**INNER_OPTIONS, "_nrt": False}


class Scalar:
    """A function that is a part of kernels, and that Python can call as well."""

    def __init__(self, function: Callable) -> None:
        update_wrapper(self, function)
        self.py_func = function
        self.part = njit(**INNER_OPTIONS)(function)

    @cached_property
    def whole(self) -> Any:
        """What Python calls, with the wrapper for it."""
        return njit(**OPTIONS)(self.py_func)

    def __call__(self, *arguments: Any) -> Any:
        """Call it from Python."""
        return self.whole(*arguments)


@typeof_impl.register(Scalar)
def _part_of_kernels(function: Scalar, _: Any) -> types.Dispatcher:
    return types.Dispatcher(function.part)


def scalar(function: F) -> F:
    """Compile a function on numbers and tuples of numbers, to be called from kernels.

    Parameters
    ----------
    function
        on numbers and tuples of numbers

    Returns
    -------
    the compiled function
    """
    return cast(F, Scalar(function))


def inner(function: F) -> F:
    """Compile a part of a kernel that Python never calls.

    Parameters
    ----------
    function
        on numbers and tuples of numbers

    Returns
    -------
    compiled function
        without the wrapper for Python, which is a fifth of a cold start
    """
    return cast(F, njit(**INNER_OPTIONS)(function))


def borrowing(function: F) -> F:
    """Compile a part of a kernel that is lent arrays: it makes none, returns none and counts no references to them.

    Counting takes half of the time of a kernel whose small parts pass arrays to each other.  A part that returned an
    array would return one that may be gone.

    Parameters
    ----------
    function
        on numbers, tuples and arrays

    Returns
    -------
    compiled function
    """
    return cast(F, njit(**BORROWING_OPTIONS)(function))


def inlined(function: F) -> F:
    """Compile a part of a kernel into it, so that what of its results the kernel does not use is never computed.

    It borrows arrays too.  Also for a part that is called in every step with a program's whole dynamics: to pass a
    hundred numbers takes longer than most parts compute.

    Parameters
    ----------
    function
        on numbers, tuples and arrays

    Returns
    -------
    compiled function
    """
    return cast(F, njit(**BORROWING_OPTIONS, forceinline=True)(function))


def kernel(function: F) -> F:
    """Compile a loop over the rows of an array, and keep it on disk.

    Parameters
    ----------
    function
        of numbers and arrays

    Returns
    -------
    the same function, compiled
    """
    return kernel_with()(function)


def kernel_with(*folders: Path) -> Callable[[F], F]:
    """Return a decorator that compiles a loop and caches it on disk, for a loop with parts in other folders.

    Parameters
    ----------
    *folders
        folders of source, beside the solver's, that the loop is made of

    Returns
    -------
    decorator
    """
    return lambda function: cast(F, keep(njit(**OPTIONS)(function), SOURCE, folders))
