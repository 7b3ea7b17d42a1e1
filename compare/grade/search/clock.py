"""The clock by which a search stops."""

from time import thread_time

from tumble.kernel_cache import compilation


def search_clock() -> float:
    """Return the processor time of this thread, without that of compiling kernels [s].

    A first answer, for which kernels are compiled, is then that of a second one.
    """
    return thread_time() - compilation.processor_s
