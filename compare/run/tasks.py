"""The one runner: a study is a list of tasks, scene x contestant x step, and here is where they are run.

A task is a question put to one contestant: a function of a module, with the values that it is given beside the running
engine that answers: one run, a ladder that stops at its floor, the bisection of a limit.  Every engine has one process
and does its tasks one after the other; engines work side by side, as many as there are cores.  A process that crashed
or hung is replaced for the next run (`RunningEngine.simulate`), each answer has its time limit, and when the command is
interrupted, or a task fails, all processes are killed at once.

`run` finds finished tasks, and runs the share of the others that its `Execution` has; `work` is the embedded runner,
in whose place an `Execution` may have another one, of many machines (`cluster/`).
"""

import logging
import math
import os
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_EXCEPTION, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import islice
from statistics import fmean
from time import monotonic
from typing import Any, Generic, TypeVar, get_type_hints

from tumble.compare.run.digest import NoValue, digest
from tumble.compare.run.execution import EXECUTION, Incomplete, Parts
from tumble.compare.run.progress import ProgressCallback, no_progress
from tumble.compare.run.running_engines import RunningEngine
from tumble.compare.run.truths import Truths

Result = TypeVar("Result", covariant=True)
Key = tuple[str, ...]
# Tasks of a stream that are held at a time.
WINDOW = 1024

log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class Task(Generic[Result]):
    """One question to one contestant.

    key: scene, engine and method, and what else tells it from the study's other tasks; ask: puts the question.  To be
    saved or to run elsewhere, it is a partial call of a module's function with values, which returns values.
    """

    key: Key
    running_engine: RunningEngine
    ask: Callable[[RunningEngine], Result]

    def __str__(self) -> str:
        scene, *contestant = self.key
        return f"{scene} {':'.join(contestant)}"

    @cached_property
    def digest(self) -> str | None:
        """The digest of all that the result depends on; None of a task that is no value."""
        try:
            return digest([self.running_engine.identity, self.ask])
        except NoValue:
            return None

    @property
    def is_waiting(self) -> bool:
        """Whether one of the values that it is given is not known yet."""
        given = self.ask.keywords.values() if isinstance(self.ask, partial) else ()
        return any(isinstance(value, Future) and not value.done() for value in given)

    @property
    def kind(self) -> Any:
        """The type of the result, as the function states it."""
        return get_type_hints(self.ask.func if isinstance(self.ask, partial) else self.ask)["return"]


def by_engine(tasks: Iterable[Task[Result]]) -> dict[RunningEngine, deque[Task[Result]]]:
    """Return the tasks of each engine, in their order."""
    own: dict[RunningEngine, deque[Task[Result]]] = {}
    for task in tasks:
        own.setdefault(task.running_engine, deque()).append(task)
    return own


class Queue(Generic[Result]):
    """The tasks of all engines, of which each does one at a time.

    Next is a task of the engine with most left to do, by how long those that it has done have taken; first are engines
    that have done none, as theirs may take any time.
    """

    def __init__(self, tasks: Iterable[Task[Result]]) -> None:
        self._left = by_engine(tasks)
        self._times_s: dict[RunningEngine, list[float]] = {}
        self._begun: dict[RunningEngine, float] = {}
        self._lock = threading.Lock()

    @property
    def engines(self) -> list[RunningEngine]:
        """The engines of all tasks."""
        return [*self._left]

    def next(self) -> Task[Result] | None:
        """Return a task of an engine that does none; None if no such engine has any left."""
        with self._lock:
            idle = [engine for engine, left in self._left.items() if left and engine not in self._begun]
            if not idle:
                return None
            # The engine with most tasks is what the others are waited for with at the end.
            engine = max(idle, key=lambda each: (self._left_s(each), len(self._left[each])))
            self._begun[engine] = monotonic()
            return self._left[engine].popleft()

    def done(self, task: Task[Result]) -> None:
        """Take note that a task is done, and how long it took."""
        with self._lock:
            begun = self._begun.pop(task.running_engine)
            self._times_s.setdefault(task.running_engine, []).append(monotonic() - begun)

    def _left_s(self, engine: RunningEngine) -> float:
        """Return how long an engine's tasks may still take [s]."""
        times_s = self._times_s.get(engine)
        return fmean(times_s) * len(self._left[engine]) if times_s else math.inf


def run(
    tasks: Sequence[Task[Result]],
    truths: Truths | None = None,
    finished: Callable[[Key, Result], object] = lambda key, result: None,
    on_progress: ProgressCallback = no_progress,
) -> list[Result]:
    """Return the results of all tasks, in the order of the tasks: those that are saved, and the others as they come.

    truths: what tasks wait for, which ends with them; finished: called with each result as it comes, one at a time;
    on_progress: called with each finished task.
    Raises what a task or a truth raises; then, as on Ctrl-C, everything is stopped first.  Raises Incomplete where
    other shards run some of the tasks.
    """
    execution = EXECUTION.get()
    own, waiting = execution.own(len(tasks)), []
    results: dict[Task[Result], Result] = {}

    def record(task: Task[Result], result: Result) -> None:
        results[task] = result
        finished(task.key, result)
        on_progress(str(task))

    def keep(task: Task[Result], result: Result) -> None:
        if execution.caches and task.digest:
            execution.save(task.digest, task.key, result)
        record(task, result)

    for number, task in enumerate(tasks):
        before = execution.find(task.digest, task.key, task.kind) if execution.caches and task.digest else None
        if before is not None:
            record(task, before)
        elif number in own:
            waiting.append(task)
        else:
            on_progress(str(task))  # another shard's
    if results and not execution.is_merge:
        log.info(f"continuing: {len(results)} of {len(tasks)} results were finished before")
    (execution.work or work)(waiting, truths, keep)
    if len(results) < len(tasks):
        raise Incomplete([str(task) for task in tasks if task not in results])
    return [results[task] for task in tasks]


def stream(
    tasks: Iterable[Task[Result]], on_progress: ProgressCallback = no_progress
) -> Iterator[tuple[Task[Result], Result]]:
    """Yield tasks with their results, in the order of the tasks, of which only WINDOW are held at a time; as `run`.

    tasks: made as they are needed, so that they may depend on earlier results.
    Raises Incomplete at the end, where other shards run some of the tasks.
    """
    left = iter(tasks)
    with Parts() as part:
        while some := [*islice(left, WINDOW)]:
            yield from zip(some, part(partial(run, some, on_progress=on_progress)) or (), strict=False)


def work(
    tasks: Sequence[Task[Result]],
    truths: Truths | None = None,
    finished: Callable[[Task[Result], Result], object] = lambda task, result: None,
) -> list[Result]:
    """Return the results of all tasks, run in this process; as `run`, but finished is called with the task."""
    queue, results = Queue(tasks), dict[Task[Result], Result]()
    engines = queue.engines
    one_at_a_time = threading.Lock()

    def take_turns() -> None:
        while (task := queue.next()) is not None:
            result = task.ask(task.running_engine)
            with one_at_a_time:
                # A flight that ended because its process was killed is no answer.
                task.running_engine.refuse_halted()
                results[task] = result
                finished(task, result)
            queue.done(task)

    for running_engine in engines:
        running_engine.resume()
    futures: list[Future] = []
    with ThreadPoolExecutor(max(1, min(len(engines), os.cpu_count() or 1))) as threads:
        try:
            futures += [threads.submit(take_turns) for _ in engines]
            for future in wait([*futures, *(truths.begun if truths else ())], return_when=FIRST_EXCEPTION).done:
                future.result()
        except BaseException:
            for future in futures:
                future.cancel()
            for running_engine in engines:
                running_engine.halt()
            if truths:
                truths.stop()
            raise
    return [results[task] for task in tasks]
