"""The folder that one shard of a command leaves, and merging such folders into the results of the whole command.

A shard leaves its results (`task_cache`) and, when it is done, shard.json: the command, the versions and the engines.
Merging runs the command again with all results found, in any order of the folders; no engine is started but for run
times, which are measured where the folders are merged: ratios never cross machines.
"""

import logging
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from tumble.compare.run.digest import code_digest, digest
from tumble.compare.run.engines.registry import EngineInfo
from tumble.compare.run.execution import Execution, Incomplete, Shard, executing
from tumble.compare.run.process.message import PREFIX, Malformed, frame, unpacked
from tumble.compare.run.provenance import MACHINE, Machine, machine
from tumble.compare.run.running_engines import POOL, Pool
from tumble.compare.run.status import Failure, Status
from tumble.compare.run.task_cache import TaskCache, apart_from_times, parts, write_whole
from tumble.compare.run.worker import Worker
from tumble.scenarios.files import plain_bytes
from tumble.scenarios.refusal import UserError

FORMAT, FILE, TASKS = "tumble shard 1", "shard.json", "tasks"

log = logging.getLogger(__name__)


class BadShard(UserError):
    """Folders that cannot be merged; the message is the one line for the user."""


@dataclass(frozen=True)
class Recorded:
    """An engine as a shard had it: what it states, and the digest of a user's file."""

    info: EngineInfo | Failure
    source: str


@dataclass(frozen=True)
class Manifest:
    """What a shard is: words of the whole command, number and count, Tumble's code, where it ran, and its engines."""

    format: str
    words: tuple[str, ...]
    number: int
    count: int
    code: str
    machine: Machine
    engines: dict[str, Recorded]


class RecordingPool(Pool):
    """Engine processes whose engines are recorded."""

    def __init__(self) -> None:
        self.engines: dict[str, Recorded] = {}

    def started(self, engine: str, info: EngineInfo | Failure, source: str) -> None:
        """Record an engine."""
        self.engines[engine] = Recorded(info, source)


@contextmanager
def sharing(folder: Path, shard: Shard, words: Sequence[str], caches: Sequence[TaskCache] = ()) -> Iterator[None]:
    """Run the tasks of one shard in the block, and leave their results in a folder.

    An Incomplete block is a finished shard.

    Parameters
    ----------
    folder : of the results
    shard : which part
    words : of the whole command
    caches : where else finished tasks are found and saved

    Yields
    ------
    nothing
    """
    (folder / FILE).unlink(missing_ok=True)
    cache, pool = TaskCache(folder / TASKS), RecordingPool()
    before = POOL.set(pool)
    try:
        with executing(Execution((cache, *caches), shard)):
            yield
    except Incomplete as rest:
        log.info(f"shard {shard} is finished, its results are in {folder}; tasks of other shards: {len(rest.missing)}")
    finally:
        POOL.reset(before)
    found = Manifest(FORMAT, tuple(words), shard.number, shard.count, code_digest(), machine(), pool.engines)
    (data,) = frame(found)
    write_whole(folder / FILE, bytes(data[PREFIX.size :]) + b"\n")


def read_manifest(folder: Path) -> Manifest:
    """Return what a shard is.

    Parameters
    ----------
    folder : of its results

    Returns
    -------
    its number, command, versions and engines

    Raises
    ------
    BadShard : the folder is not that of a finished shard
    """
    path = folder / FILE
    try:
        found = unpacked(Manifest, plain_bytes(path), b"")
    except FileNotFoundError:
        what = "it has no shard.json, which a shard writes when it is finished" if folder.is_dir() else "no such folder"
        raise BadShard(f"{folder}: not the results of a shard: {what}") from None
    except (OSError, Malformed) as error:
        raise BadShard(f"{path}: cannot be read: {error}") from None
    if found.format != FORMAT:
        raise BadShard(f"{path}: format {found.format!r}: this Tumble reads {FORMAT!r}")
    return found


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


class RecordedPool(Pool):
    """Engines as shards recorded them."""

    def __init__(self, engines: dict[str, Recorded]) -> None:
        self._engines = engines

    def worker(self, engine: str, time_limit: float, memory_limit: int) -> Worker:
        """Return a recorded engine, or a process of one that no shard had."""
        if recorded := self._engines.get(engine):
            return RecordedWorker(engine, recorded, time_limit, memory_limit)
        return super().worker(engine, time_limit, memory_limit)

    def releases(self, engine: str) -> list[str]:
        """Return the releases of an engine that the shards ran, as they recorded them."""
        return [name.removeprefix(f"{engine}@") for name in self._engines if name.startswith(f"{engine}@")]


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
    manifests = [read_manifest(folder) for folder in folders]
    first = manifests[0]
    for folder, other in zip(folders[1:], manifests[1:], strict=True):
        refuse_mixed(folders[0], first, folder, other)
    if first.code != code_digest():
        raise BadShard(f"{folders[0]}: another version of Tumble ran this shard: merge with the version that ran it")
    engines = {name: recorded for one in manifests for name, recorded in one.engines.items()}
    merged = Execution((Merged(folders),), is_merge=True)
    with ExitStack() as stack:
        stack.enter_context(executing(merged))
        for variable, value in ((POOL, RecordedPool(engines)), (MACHINE, together([one.machine for one in manifests]))):
            stack.callback(variable.reset, variable.set(value))  # type: ignore[arg-type]
        try:
            yield
        except Incomplete as rest:
            missing = [
                str(Shard(number, first.count))
                for number in range(1, first.count + 1)
                if number not in {one.number for one in manifests}
            ]
            why = f"give {'shard' if len(missing) == 1 else 'shards'} {', '.join(missing)} too"
            if not missing:
                why = "a scene file or an engine file is not the one that the shards ran"
            raise BadShard(f"{rest}: {why}") from None


def refuse_mixed(folder: Path, one: Manifest, other_folder: Path, other: Manifest) -> None:
    """Raise BadShard where two shards are not of one command, of the same versions and engines."""
    if one.words != other.words:
        raise BadShard(f"{other_folder} ran `{' '.join(other.words)}`, but {folder} ran `{' '.join(one.words)}`")
    if one.count != other.count:
        numbers = [Shard(each.number, each.count) for each in (other, one)]
        raise BadShard(f"{other_folder} is shard {numbers[0]}, but {folder} is shard {numbers[1]}")
    pairs: list[tuple[str, Any, Any]] = [("Tumble's code", one.code, other.code)]
    mine, others = ({row.what: row.value for row in each.machine.versions} for each in (one, other))
    pairs += [(what, mine.get(what, "none"), others.get(what, "none")) for what in sorted({**mine, **others})]
    for what, here, there in pairs:
        if here != there:
            raise BadShard(
                f"{other_folder} ran {what} {there}, but {folder} {here}: run all shards with the same versions"
            )
    for name in one.engines.keys() & other.engines.keys():
        if digest(one.engines[name]) != digest(other.engines[name]):
            raise BadShard(f"{other_folder} and {folder} ran different engines under the name {name}")


def together(machines: Sequence[Machine]) -> Machine:
    """Return the machines of all shards as one row each, which are one where they are the same."""

    def joined(values: Iterator[str]) -> str:
        return "; ".join(sorted(set(values)))

    return replace(
        machines[0],
        processor=joined(each.processor for each in machines),
        cores=joined(each.cores for each in machines),
        system=joined(each.system for each in machines),
    )
