"""Dask workers of this machine for one command, with a scheduler of their own, all on loopback.

A process in a session of its own starts them: Ctrl-C in a terminal reaches the command alone, which then ends them, and
where the command is killed they end with it.
"""

import logging
from collections.abc import Iterator
from concurrent.futures import TimeoutError as Overdue
from contextlib import contextmanager, suppress

from tumble.compare.run.cluster.on_worker import BadCluster
from tumble.compare.run.process.caller import Caller
from tumble.compare.run.process.process import Died

# Dask keeps the last 1,000 messages, for its developers: each may be a batch of 1 MB.
FEW_MESSAGES = {"distributed.admin.low-level-log-length": 10}
# Workers have so long to end by themselves [s]; killed, they leave named semaphores behind until the machine restarts.
TO_END_S = 5.0


@contextmanager
def own_workers(count: int) -> Iterator[str]:
    """Start workers, each with one thread, and end them afterwards.

    Parameters
    ----------
    count : of workers

    Yields
    ------
    the address of their scheduler

    Raises
    ------
    BadCluster : they cannot be started
    """
    host = Caller()
    try:
        try:
            address = host.submit(begin, count).result()
        except (OSError, TimeoutError, ValueError, RuntimeError, Died) as error:
            raise BadCluster(f"--workers {count}: cannot be started: {' '.join(str(error).split())}") from None
        try:
            yield address
        finally:
            with suppress(Overdue, Died, RuntimeError):
                host.submit(end).result(TO_END_S)
    finally:
        host.end()


_begun: list = []


def begin(count: int) -> str:
    """In the process that starts them: return the address of their scheduler."""
    from dask import config
    from distributed import LocalCluster

    logging.disable()  # what Dask tells of itself
    config.set(FEW_MESSAGES)
    cluster = LocalCluster(
        n_workers=count, threads_per_worker=1, memory_limit=0, host="127.0.0.1", dashboard_address="127.0.0.1:0",
        silence_logs=logging.CRITICAL,
    )  # fmt: skip
    _begun.append(cluster)
    return cluster.scheduler_address


def end() -> None:
    """In the process that started them: end them."""
    _begun.pop().close()
