"""The process of an engine: loads it, says what it is, then does what it is asked until nobody asks any more.

Run as a program by any interpreter that has numpy: `serve.py ENGINE MEMORY_LIMIT LINE LIFELINE`.  Its working directory
is no place to import from, and of ours it finds the package tumble alone, wherever that lies.  `serve.py LINE LIFELINE`
is the fork server (`process/fork_server.py`), whose forks go on here, as if they had been started with their words.
"""

import importlib.util
import logging
import os
import sys
from pathlib import Path

# As it was asked for: in a checkout there is a link on the way, and what it leads to is not in the package.
TUMBLE = Path(__file__).absolute().parents[2]
# The words of every process; and what another makes calls of functions (`process/caller.py`), and no engine.
LINES, CALLS = 2, "calls"


def main(*words: str) -> None:
    """Serve one engine, or calls of functions; without a word of either, fork for each that is asked for."""
    load_tumble()
    if len(words) == LINES:
        from tumble.compare.run.process.fork_server import serve_forks

        words = (*serve_forks(*words),)
    *what, line, lifeline = words
    if what == [CALLS]:
        from tumble.compare.run.process.caller import serve

        serve(line, lifeline)
        return
    from tumble.compare.run.process.start import end_with_parent, open_line
    from tumble.compare.run.process.usage import limit_memory

    connection = open_line(line)
    end_with_parent(lifeline)
    os.dup2(2, 1)  # whatever an engine prints goes to standard error: standard output is for results
    sys.stdout = sys.stderr  # where it is not kept back in a buffer that dies with the process
    logging.basicConfig(format="tumble: %(message)s")
    engine, memory_limit = what
    limit_memory(int(memory_limit))

    from tumble.compare.run.questions import answer_all

    with connection:
        answer_all(connection, engine, int(memory_limit))


def load_tumble() -> None:
    """Load the package from where this file lies, whatever else is called tumble on the path."""
    spec = importlib.util.spec_from_file_location(
        "tumble", TUMBLE / "__init__.py", submodule_search_locations=[str(TUMBLE)]
    )
    assert spec is not None
    assert spec.loader is not None
    sys.modules["tumble"] = package = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(package)
    # A checkout is on the path for the sake of the package; whatever else lies in it is not for engines to import.
    if (TUMBLE / "compare").is_symlink():
        sys.path[:] = [place for place in sys.path if place != str(TUMBLE.parent)]


if __name__ == "__main__":
    main(*sys.argv[1:])
