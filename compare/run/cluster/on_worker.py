"""What runs on a worker of a cluster: tasks of one or more engines, which have processes there as here."""

import pickle
from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from threading import Lock
from time import monotonic

from tumble.compare.run.digest import code_digest, digest
from tumble.compare.run.process.message import frame
from tumble.compare.run.provenance import versions
from tumble.compare.run.running_engines import RunningEngine
from tumble.compare.run.status import Failure
from tumble.compare.run.worker import Worker
from tumble.scenarios.refusal import UserError

# Engine processes of a worker: the least used one makes room.
ENGINES_EACH = 4


class BadCluster(UserError):
    """A cluster that cannot be used; the message is the one line for the user."""


@dataclass(frozen=True)
class Needed:
    """The engine of a task, and the versions that it must have on a worker.

    command: which command needs it, of several that share the workers; identity: of `RunningEngine`, digested
    """

    command: str
    engine: str
    title: str
    methods: tuple[str, ...]
    named: frozenset[str]
    unasked: bool
    time_limit: float
    memory_limit: int
    identity: str
    versions: tuple[tuple[str, str], ...]

    @classmethod
    def of(cls, one: RunningEngine, command: str) -> "Needed":
        """Return what a running engine is."""
        limits = one.worker.time_limit, one.worker.memory_limit
        asked = one.engine, one.title, one.methods, one.named, one.unasked
        return cls(command, *asked, *limits, digest(one.identity), here())


def here() -> tuple[tuple[str, str], ...]:
    """Return the versions of what results depend on, in this process."""
    return (("Tumble's code", code_digest()), *((row.what, row.value) for row in versions()))


# Those of this worker, the one used last at the end.  A worker has one thread, but a user's may have more.
_engines: "OrderedDict[Needed, RunningEngine]" = OrderedDict()
one_at_a_time = Lock()


def answer(asked: Sequence[tuple[bytes, bytes]]) -> tuple[float, list[bytes]]:
    """Return how long tasks took [s], and the result of each as a frame.

    asked: the engine that each needs, and what it asks, pickled.  Raises BadCluster where this worker has other
    versions.
    """
    begun, frames = monotonic(), []
    with one_at_a_time:
        for needed, ask in asked:
            engine = engine_of(known(needed))
            while len(_engines) > ENGINES_EACH:
                _engines.popitem(last=False)[1].worker.close()
            frames.append(b"".join(frame(pickle.loads(ask)(engine))))
    return monotonic() - begun, frames


@lru_cache(maxsize=2 * ENGINES_EACH)
def known(needed: bytes) -> Needed:
    """Return an engine that a task needs; most tasks need the one of the task before."""
    return pickle.loads(needed)


def engine_of(needed: Needed) -> RunningEngine:
    """Return an engine, started if needed.  Raises BadCluster where the worker has other versions."""
    engine = _engines.pop(needed, None) or running(needed)
    _engines[needed] = engine
    return engine


def running(needed: Needed) -> RunningEngine:
    """Start an engine.  Raises BadCluster for another version than at home."""
    from distributed import get_worker

    mine, worker_name = dict(here()), f"worker {get_worker().address}"
    for what, value in needed.versions:
        if mine.get(what, "none") != value:
            raise BadCluster(f"{worker_name} has {what} {mine.get(what, 'none')}, here is {value}")
    worker = Worker(needed.engine, needed.time_limit, needed.memory_limit)
    info = worker.describe()
    engine = RunningEngine(
        needed.engine, needed.title, needed.methods, needed.named, info, worker, unasked=needed.unasked
    )
    if digest(engine.identity) != needed.identity:
        worker.close()
        found = str(info) if isinstance(info, Failure) else f"version {info.version}"
        raise BadCluster(f"{worker_name} has another {needed.title} than here: {found}")
    return engine


def end_engines(command: str | None = None) -> None:
    """End the engines of a command, of all commands where none is given, also one at work, whose task then fails."""
    for needed in [*_engines]:
        if command in (None, needed.command) and (engine := _engines.pop(needed, None)):
            engine.halt(for_good=True)
