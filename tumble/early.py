"""Begins to load the engines of a command while the command itself is imported: both take half a second."""

from argparse import Namespace
from collections.abc import Iterator
from contextlib import contextmanager, suppress

# Commands that start the engines given, or else the usual ones, as the first thing they do.
COMMANDS = ("ablate", "advise", "compare", "report", "stability", "sweep")


@contextmanager
def engines_begun(options: Namespace) -> Iterator[None]:
    """Begin the engines of Tumble that a command will start, and end those that it has not started.

    Parameters
    ----------
    options : of the command

    Yields
    ------
    nothing
    """
    if options.command not in COMMANDS or getattr(options, "sources", None):
        yield
        return
    # Imported in this order: the server of forks begins before anything large is imported here.
    from tumble.compare.run.process import forks

    server = forks.enter()
    try:
        from tumble.compare.run.asked import wanted
        from tumble.compare.run.engines.registry import is_file
        from tumble.compare.run.pool import begin, end_begun
        from tumble.scenarios.refusal import UserError

        with suppress(UserError):  # the command says so
            # Files of a user are run when the command does.
            tumbles = [engine for engine in wanted(options.engine) if not is_file(engine)]
            begin(tumbles, options.time_limit, options.memory_limit)
    finally:
        forks.leave(server)
    try:
        yield
    finally:
        end_begun()
