"""Engine processes that outlive one call."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from pathlib import Path
from types import MappingProxyType

from tumble.compare.run.engines.registry import is_file
from tumble.compare.run.execution import Shard
from tumble.compare.run.local import LocalWorker
from tumble.compare.run.pool import POOL, Pool
from tumble.compare.run.shards.merging import merging
from tumble.compare.run.shards.sharing import sharing
from tumble.compare.run.worker import Worker
from tumble.scenarios.refusal import UserError
from tumble.shares import IN_PYTHON, caches_of, placed


class Session(Pool):
    """Engine processes that stay ready between calls, one for each engine and memory limit."""

    def __init__(self) -> None:
        self._ready: dict[tuple[str, int], Worker] = {}

    def worker(self, engine: str, time_limit: float, memory_limit: int) -> Worker:
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
        found = self._ready.pop((engine, memory_limit), None)
        if found is None or not found.alive:
            return super().worker(engine, time_limit, memory_limit)
        found.time_limit = time_limit
        return found

    def release(self, worker: Worker | LocalWorker) -> None:
        """Keep a process for the next call; end it where one of its kind waits already, or its file may change.

        Parameters
        ----------
        worker : a process that a call has done with.
        """
        if (
            isinstance(worker, LocalWorker)
            or is_file(worker.engine)
            or not worker.alive
            or self._key(worker) in self._ready
        ):
            worker.close()
        else:
            self._ready[self._key(worker)] = worker

    def close(self) -> None:
        """End every process."""
        while self._ready:
            self._ready.popitem()[1].close()

    @staticmethod
    def _key(worker: Worker) -> tuple[str, int]:
        return worker.engine, worker.memory_limit


@contextmanager
def session(
    *,
    cache: str | Path | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    tls: Mapping[str, str] = MappingProxyType({}),
    insecure_scheduler: bool = False,
    shard: tuple[int, int] | None = None,
    folder: str | Path | None = None,
    merge: Sequence[str | Path] = (),
) -> Iterator[Session]:
    """Keep engine processes ready between the calls inside the block, and say where runs are made and saved.

    Without a session every call starts the engines that it needs and ends them.  A session belongs to the thread or the
    asynchronous task that opened it.

    Parameters
    ----------
    cache : folder where finished runs are saved, and found again.
    workers : run on this many Dask workers of this machine; needs the extra dask.
    scheduler : run on the workers of this Dask scheduler: HOST:PORT or tls://HOST:PORT.
    tls : files of the authority, the certificate and the key for tls://: ca, cert, key.
    insecure_scheduler : allow a scheduler on another machine without TLS.
    shard : run only part I of N of the call in the block, (I, N); the block ends there, without a result.
    folder : of the shard's results; None: shard-I-of-N.
    merge : folders of all shards; the same call in the block finds their results.

    Raises
    ------
    UserError
        For a scheduler that cannot be used, and for folders that are not all shards of one call.

    Examples
    --------
    >>> import tumble
    >>> with tumble.session():
    ...     coarse = tumble.run("two-hits", "tumble:rk4", dt=0.004)
    ...     fine = tumble.run("two-hits", "tumble:rk4", dt=0.002)
    >>> len(coarse) == len(fine)
    True
    """
    opened = Session()
    before = POOL.set(opened)
    try:
        with ExitStack() as stack:
            if shard:
                part = Shard(*shard)
                if workers or scheduler or merge or not 1 <= part.number <= part.count:
                    raise UserError(f"shard = {shard}: must be (I, N) with 1 <= I <= N, without scheduler and workers")
                place = Path(folder or f"shard-{part.number}-of-{part.count}")
                stack.enter_context(sharing(place, part, IN_PYTHON, caches_of(cache)))
            else:
                stack.enter_context(placed(cache, workers, scheduler, tls, insecure_scheduler))
            if merge:
                stack.enter_context(merging([Path(one) for one in merge]))
            yield opened
    finally:
        POOL.reset(before)
        opened.close()


def kept_ready() -> AbstractContextManager[object]:
    """Return a context in which engines stay ready: the session that is open, or one for this call alone.

    Returns
    -------
    contextlib.AbstractContextManager
    """
    return session() if type(POOL.get()) is Pool else nullcontext()
