"""Where the processes of engines come from: a new one for every study, unless who runs it has its own pool."""

from collections.abc import Iterable
from contextvars import ContextVar

from tumble.compare.run.engines.registry import EngineInfo
from tumble.compare.run.local import LocalWorker
from tumble.compare.run.status import Failure
from tumble.compare.run.worker import Worker

# Processes that `begin` has begun, by engine and limits.
_begun: dict[tuple[str, float, int], Worker] = {}


class Pool:
    """Where the processes of engines come from: a new one for every study, or one that has begun for it."""

    def worker(self, engine: str, time_limit: float, memory_limit: int) -> Worker:
        """Return a process that begins to load the engine."""
        return _begun.pop((engine, time_limit, memory_limit), None) or Worker(engine, time_limit, memory_limit)

    def release(self, worker: Worker | LocalWorker) -> None:
        """End a process that a study has done with."""
        worker.close()

    def started(self, engine: str, info: EngineInfo | Failure, source: str) -> None:
        """Hear what an engine states, and the digest of a user's file."""

    def releases(self, engine: str) -> list[str]:
        """Return the releases of an engine that are known beside those installed; nothing: there are only those."""
        return []


# The pool of whoever runs a study: a session of `import tumble` puts its own here, for its block alone.
POOL: ContextVar[Pool] = ContextVar("pool of engine processes", default=Pool())  # noqa: B039


def begin(engines: Iterable[str], time_limit: float, memory_limit: int) -> None:
    """Begin to load engines that a study will ask for.

    Parameters
    ----------
    engines : ENGINE[@RELEASE] of each
    time_limit : for each answer of an engine [s]
    memory_limit : for each engine's process [B]
    """
    for engine in engines:
        _begun[engine, time_limit, memory_limit] = Worker(engine, time_limit, memory_limit)


def end_begun() -> None:
    """End the processes that no study has asked for."""
    while _begun:
        _begun.popitem()[1].close()
