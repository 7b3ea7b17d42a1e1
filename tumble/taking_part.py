"""Who takes part in a command: the engines that its options name, started while progress is reported."""

from argparse import Namespace
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager

from tumble.compare.run.running_engines import RunningEngine, launched
from tumble.notes import progress


@contextmanager
def taking_part(asked: Iterable[str], options: Namespace, **settings: object) -> Iterator[list[RunningEngine]]:
    """Give who takes part, as `launched` does, within the limits of time and memory that the options name.

    asked: ENGINE[:METHOD] ...; settings: the others of `launched`.  Raises BadEngine.
    """
    with ExitStack() as engines:
        with progress(doing="starting engines"):
            begun = launched(asked, options.time_limit, options.memory_limit, **settings)  # type: ignore[arg-type]
            running_engines = engines.enter_context(begun)
        yield running_engines
