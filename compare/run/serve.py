"""The process of an engine: loads it, says what it is, then does what it is asked until nobody asks any more.

Run as a program by any interpreter that has numpy: `serve.py ENGINE MEMORY_LIMIT LINE LIFELINE`.  Its working directory
is no place to import from, and of ours it finds compare, scenarios and solver alone, wherever they lie.
"""

import importlib.machinery
import os
import resource
import socket
import sys
from contextlib import suppress
from importlib.abc import MetaPathFinder
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# In a wheel the rooms lie inside one package; see setup.py.
OURS = ("tumble",) if (ROOT / "__init__.py").exists() else ("compare", "scenarios", "solver", "reports", "tumble")
HOME = str(ROOT.parent if OURS == ("tumble",) else ROOT)


class FindOurs(MetaPathFinder):
    """Finds our top-level packages where this file lies, before any others of their names."""

    def find_spec(self, fullname, path=None, target=None):
        """Return where a package of ours is, None for all else."""
        return importlib.machinery.PathFinder.find_spec(fullname, [HOME]) if fullname in OURS else None


class FindTheirs(MetaPathFinder):
    """Finds what the user calls by one of our names: his own, or nothing."""

    def find_spec(self, fullname, path=None, target=None):
        """Return where it is, None for all other names.  Raises ModuleNotFoundError where the user has none."""
        if fullname not in OURS:
            return None
        spec = importlib.machinery.PathFinder.find_spec(fullname, [place for place in sys.path if place != HOME])
        if spec is None:
            raise ModuleNotFoundError(f"No module named {fullname!r}", name=fullname)
        return spec


def main(engine: str, memory_limit: str, line: str, lifeline: str) -> None:
    """Serve one engine."""
    sys.meta_path.insert(0, FindOurs())
    from compare.run.process import end_with_parent

    end_with_parent(int(lifeline))
    os.dup2(2, 1)  # whatever an engine prints goes to standard error: standard output is for results
    sys.stdout = sys.stderr  # where it is not kept back in a buffer that dies with the process
    limit_memory(int(memory_limit))
    os.set_inheritable(int(line), False)

    from compare.run.questions import answer_all

    if engine.endswith(".py"):
        forget_ours()
    with socket.socket(fileno=int(line)) as connection:
        answer_all(connection, engine, int(memory_limit))


def forget_ours() -> None:
    """Leave our names to the user: what he calls `compare` or `solver` is his own, and ours is none of his business.

    What is loaded goes on working, for it knows its modules without asking for them again.
    """
    sys.meta_path[0] = FindTheirs()
    for name in [*sys.modules]:
        if name.partition(".")[0] in OURS:
            del sys.modules[name]


def limit_memory(most: int) -> None:
    """Let this process, and each that it starts, have so much memory of its own [B]; macOS takes no notice."""
    _, hard = resource.getrlimit(resource.RLIMIT_DATA)
    most = most if hard == resource.RLIM_INFINITY else min(most, hard)
    with suppress(ValueError, OSError):  # of macOS, where more than that may be taken already
        resource.setrlimit(resource.RLIMIT_DATA, (most, most))


if __name__ == "__main__":
    main(*sys.argv[1:])
