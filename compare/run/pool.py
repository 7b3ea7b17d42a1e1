"""Where the processes of engines come from: a new one for every study, unless who runs it has its own pool."""

from contextvars import ContextVar

from tumble.compare.run.engines.registry import EngineInfo
from tumble.compare.run.local import LocalWorker
from tumble.compare.run.status import Failure
from tumble.compare.run.worker import Worker


class Pool:
    """Where the processes of engines come from: a new one for every study."""

    def worker(self, engine: str, time_limit: float, memory_limit: int) -> Worker:
        """Return a process that begins to load the engine."""
        return Worker(engine, time_limit, memory_limit)

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
