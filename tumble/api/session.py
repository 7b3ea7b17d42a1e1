"""Engine processes that outlive one call."""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

from tumble.compare.run.worker import Worker

_current: ContextVar["Session | None"] = ContextVar("tumble session", default=None)


class Session:
    """Engine processes that stay ready between calls, one for each engine and memory limit."""

    def __init__(self) -> None:
        self._workers: dict[tuple[str, int], Worker] = {}

    def start(self, engine: str, time_limit: float, memory_limit: int) -> Worker:
        """Return a process that has the engine loaded, or begins to load it.

        Parameters
        ----------
        engine : ENGINE[@RELEASE] or the path of an engine file.
        time_limit : of each answer [s].
        memory_limit : of the process [B].

        Returns
        -------
        Worker
        """
        key = engine, memory_limit
        worker = self._workers.get(key)
        if worker is None or not worker.alive:
            worker = self._workers[key] = Worker(engine, time_limit, memory_limit)
        worker.time_limit = time_limit
        return worker

    def close(self) -> None:
        """End every process."""
        for worker in self._workers.values():
            worker.close()
        self._workers.clear()


@contextmanager
def session() -> Iterator[Session]:
    """Keep engine processes ready between the calls inside the block.

    Without a session every call starts the engines that it needs and ends them.  A session belongs to the thread or the
    asynchronous task that opened it.

    Examples
    --------
    >>> import tumble
    >>> with tumble.session():
    ...     slow = tumble.run("two-hits", "tumble:rk4", dt=0.004)
    ...     fine = tumble.run("two-hits", "tumble:rk4", dt=0.002)
    >>> len(slow) == len(fine)
    True
    """
    opened = Session()
    before = _current.set(opened)
    try:
        yield opened
    finally:
        _current.reset(before)
        opened.close()


def current() -> Session | None:
    """Return the session that is open here, or None.

    Returns
    -------
    Session or None
    """
    return _current.get()
