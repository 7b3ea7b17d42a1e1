"""How the tasks of a command are run: all of them here, or a share; and where finished ones are found and saved.

A command runs under one `Execution` (`EXECUTION`), which the runner (`tasks.run`) and the reference solutions
(`truths.Truths`) ask.  Studies know nothing of it, except that a part of them may be `Incomplete`.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Self, TypeVar

from tumble.compare.run.provenance import circumstances
from tumble.compare.run.task_cache import TaskCache

FOLDER = ".unfinished"
Result = TypeVar("Result")


class Incomplete(Exception):
    """Some tasks belong to other shards, whose results are not here; missing: their names."""

    def __init__(self, missing: Sequence[str]) -> None:
        super().__init__(f"{len(missing)} results are missing, the first of {missing[0]}")
        self.missing = missing


@dataclass(frozen=True)
class Shard:
    """A part of a study.

    Parameters
    ----------
    number : of the part, from 1 on
    count : of all parts
    """

    number: int
    count: int

    def __str__(self) -> str:
        """Return I/N, as on the command line."""
        return f"{self.number}/{self.count}"

    def block(self, length: int) -> range:
        """Return the part of a list that belongs to this shard: neighbours, which often share a reference solution."""
        return range((self.number - 1) * length // self.count, self.number * length // self.count)


@dataclass(frozen=True)
class Execution:
    """How the tasks of a command are run.

    Parameters
    ----------
    caches : where finished tasks are found, each saved in all of them
    shard : which tasks are run; None: all
    is_merge : whether no task is run: all results are in the caches
    work : runs tasks, as `tasks.work`, on other machines; None: here
    times : measures what loads cost, as `timing.costs`, on a machine that does nothing else, or returns None: not there
    """

    caches: tuple[TaskCache, ...] = ()
    shard: Shard | None = None
    is_merge: bool = False
    work: Callable[..., object] | None = None
    times: Callable[..., Any] | None = None

    def own(self, length: int) -> range:
        """Return which tasks of a list are run here, or begun without being waited for."""
        if self.is_merge:
            return range(0)
        return self.shard.block(length) if self.shard else range(length)

    def find(self, task: str, key: Sequence[str], kind: Any) -> Any:
        """Return the saved result of a task, by its digest, or None; found in one cache, it is saved in the others."""
        for cache in self.caches:
            if (found := cache.find(task, kind)) is not None:
                for other in self.caches:
                    if not other.path(task).exists():
                        other.save(task, key, found)
                return found
        return None

    def save(self, task: str, key: Sequence[str], result: object) -> None:
        """Save the result of a task in all caches."""
        for cache in self.caches:
            cache.save(task, key, result)


EXECUTION: ContextVar[Execution] = ContextVar("execution of tasks", default=Execution())  # noqa: B039


@contextmanager
def executing(execution: Execution) -> Iterator[Execution]:
    """Run what is in the block in this way.

    Parameters
    ----------
    execution : how tasks are run

    Yields
    ------
    the same
    """
    before = EXECUTION.set(execution)
    try:
        yield execution
    finally:
        EXECUTION.reset(before)


@contextmanager
def resumable(folder: Path | None) -> Iterator[None]:
    """Save finished tasks in a folder until the block ends, so that the same command continues an interrupted one.

    Parameters
    ----------
    folder : where the study writes its results; None, or another cache: nothing is saved there

    Yields
    ------
    nothing

    Raises
    ------
    KeyboardInterrupt : with the line that says how to continue
    """
    execution = EXECUTION.get()
    if folder is None or execution.caches or execution.is_merge:
        yield
        return
    cache = TaskCache(folder / FOLDER, circumstances())
    try:
        with executing(replace(execution, caches=(cache,))):
            yield
    except KeyboardInterrupt:
        raise interrupted(folder) from None
    cache.remove()


def interrupted(folder: str | Path) -> KeyboardInterrupt:
    """Return the interrupt that says how to continue.

    Parameters
    ----------
    folder : of finished results

    Returns
    -------
    to be raised
    """
    return KeyboardInterrupt(
        f"interrupted; finished results are saved in {folder}; run the same command again to continue"
    )


class Parts:
    """Runs parts of a study that do not need each other's results, also those after a part that is incomplete.

    A context: leaving it raises Incomplete where a part was.
    """

    def __init__(self) -> None:
        self._missing: list[str] = []

    def __call__(self, part: Callable[[], Result]) -> Result:
        """Run a part and return its result; nothing of an incomplete one, which is not to be used in the block."""
        try:
            return part()
        except Incomplete as incomplete:
            self._missing += incomplete.missing
            return None  # type: ignore[return-value]

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is None and self._missing:
            raise Incomplete(self._missing)
