"""The whole command made of the folders that its shards left.

Merging runs the command again with all results found, in any order of the folders; no engine is started but for run
times, which are measured where the folders are merged: ratios never cross machines.
"""

import logging
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

from tumble.compare.run.digest import digest
from tumble.compare.run.engines.registry import EngineInfo
from tumble.compare.run.execution import Execution, Incomplete, executing
from tumble.compare.run.pool import POOL, Pool
from tumble.compare.run.process.message import Malformed
from tumble.compare.run.provenance import MACHINE
from tumble.compare.run.shards.manifest import TASKS, BadShard, Recorded, missing_shards, read_manifests, together
from tumble.compare.run.status import Failure, Status
from tumble.compare.run.task_cache import TaskCache, apart_from_times, parts
from tumble.compare.run.worker import Worker

log = logging.getLogger(__name__)


@contextmanager
def merging(folders: Sequence[Path]) -> Iterator[None]:
    """Find the results of all tasks in the folders of shards, in the block.

    Parameters
    ----------
    folders : of all shards of one command

    Yields
    ------
    nothing

    Raises
    ------
    BadShard : the folders are of different commands, versions or engines, or results are missing
    """
    manifests = read_manifests(folders)
    engines = {name: recorded for one in manifests for name, recorded in one.engines.items()}
    with ExitStack() as stack:
        stack.enter_context(executing(Execution((Merged(folders),), is_merge=True)))
        stack.callback(POOL.reset, POOL.set(RecordedPool(engines)))
        stack.callback(MACHINE.reset, MACHINE.set(together([one.machine for one in manifests])))
        try:
            yield
        except Incomplete as rest:
            why = missing_shards(manifests) or "a scene file or an engine file is not the one that the shards ran"
            raise BadShard(f"{rest}: {why}") from None


class Merged(TaskCache):
    """The results of several shards, none of which is changed.  Raises BadShard where two have different ones."""

    def __init__(self, folders: Sequence[Path]) -> None:
        super().__init__(folders[0])
        self._files: dict[str, Path] = {}
        for folder in folders:
            for file in sorted((folder / TASKS).glob("[!.]*")):
                known = self._files.setdefault(file.name, file)
                # Of results that differ in their times alone, one is taken whatever the order of the folders.
                if known is not file and (data := file.read_bytes()) != (other := known.read_bytes()):
                    refuse_different(known, file)
                    self._files[file.name] = file if data < other else known

    def path(self, task: str) -> Path:
        """Return the file of a task."""
        own = super().path(task)
        return self._files.get(own.name, own)

    def save(self, task: str, key: Sequence[str], result: object) -> None:
        """Save nothing."""


def refuse_different(one: Path, other: Path) -> None:
    """Raise BadShard where two results of one task differ, times apart, or one is damaged."""
    try:
        if apart_from_times(one) == apart_from_times(other):
            return
        name, _, _ = parts(one)
    except Malformed as error:
        raise BadShard(str(error)) from None
    raise BadShard(f"{name}: {one.parents[1]} and {other.parents[1]} have different results of the same task")


class RecordedPool(Pool):
    """Engines as shards recorded them."""

    def __init__(self, engines: Mapping[str, Recorded]) -> None:
        self._engines = engines

    def worker(self, engine: str, time_limit: float, memory_limit: int) -> Worker:
        """Return a recorded engine, or a process of one that no shard had."""
        if recorded := self._engines.get(engine):
            return RecordedWorker(engine, recorded, time_limit, memory_limit)
        return super().worker(engine, time_limit, memory_limit)

    def releases(self, engine: str) -> list[str]:
        """Return the releases of an engine that the shards ran, as they recorded them."""
        return [name.removeprefix(f"{engine}@") for name in self._engines if name.startswith(f"{engine}@")]


class RecordedWorker(Worker):
    """An engine that a shard recorded: it states the same, and is started only when something is asked of it."""

    def __init__(self, engine: str, recorded: Recorded, time_limit: float, memory_limit: int) -> None:
        self.engine, self.time_limit, self.memory_limit = engine, time_limit, memory_limit
        self._recorded, self._process, self._place = recorded, None, None
        self._why_gone = Failure(Status.CRASHED, "it is not started")

    @property
    def source(self) -> str:  # type: ignore[override]
        """The digest of the engine file that the shard ran."""
        return self._recorded.source

    def describe(self) -> EngineInfo | Failure:
        """Return what the engine stated."""
        return self._recorded.info

    def renewed(self) -> Worker:  # type: ignore[override]
        """Start the engine; another version of it is none."""
        log.info(f"{self.engine} is started here: run times are not compared across machines")
        worker = Worker(self.engine, self.time_limit, self.memory_limit)
        if digest([worker.describe(), worker.source]) != digest([self._recorded.info, self._recorded.source]):
            worker.refuse(Failure(Status.MISSING, f"{self.engine} is not here as the shards had it"))
        return worker

    def close(self) -> None:
        """Do nothing: there is no process."""

    def kill(self) -> None:
        """Do nothing: there is no process."""
