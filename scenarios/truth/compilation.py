"""How the integration is compiled, and where what is compiled is kept.

`inlined` is for the lines that are run a million times: left to itself the compiler makes calls of them, which cost
more than they do.  `inner` is for the other parts that only compiled code calls.  `kernel` is for the one loop that
Python calls, kept on disk, so that a second process compiles nothing.  numba renews what is on disk when the kernel's
own file changes, but not when a part elsewhere does: so each state of this package's source has a folder of its own.
Fast-math is off.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

from numba import njit

from tumble.kernel_cache import keep
from tumble.kernel_parts import KernelCompiler, PartCompiler

SOURCE = Path(__file__).parent
OPTIONS: dict[str, Any] = {
    "error_model": "numpy",
    "fastmath": False,
    "no_cfunc_wrapper": True,
    "nogil": True,
    "pipeline_class": KernelCompiler,
}
INNER_OPTIONS: dict[str, Any] = {**OPTIONS, "no_cpython_wrapper": True, "pipeline_class": PartCompiler}

F = TypeVar("F", bound=Callable)


def inlined(function: F) -> F:
    """Compile a part of the kernel into whatever calls it."""
    return cast(F, njit(**INNER_OPTIONS, forceinline=True)(function))


def inner(function: F) -> F:
    """Compile a part of the kernel, which Python never calls."""
    return cast(F, njit(**INNER_OPTIONS)(function))


def kernel(function: F) -> F:
    """Compile a function that Python calls, and keep it on disk."""
    return cast(F, keep(njit(**OPTIONS)(function), SOURCE))
