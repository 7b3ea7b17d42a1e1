"""The one runner: a study is a list of tasks, scene x contestant x step, and here is where they are run.

A task is a question put to one contestant, as a function of the running engine that answers it: one run, a ladder that
stops at its floor, the bisection of a limit.  Every engine has one process and does its tasks one after the other;
engines work side by side, as many as there are cores.  A process that crashed or hung is replaced for the next run
(`RunningEngine.simulate`), each answer has its time limit, and when the command is interrupted, or a task fails, all
processes are killed at once.  Finished tasks can be cached (`TaskCache`), so that a study that is run again continues.

Another executor, of many machines, goes in here and nowhere else: a task holds all that it needs but for the truths
that it waits for, and whoever runs it needs only a participant of that engine to hand to it.
"""

import logging
import os
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_EXCEPTION, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from tumble.compare.run.progress import ProgressCallback, no_progress
from tumble.compare.run.running_engines import RunningEngine
from tumble.compare.run.task_cache import TaskCache
from tumble.compare.run.truths import Truths

Result = TypeVar("Result", covariant=True)
Key = tuple[str, ...]

log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class Task(Generic[Result]):
    """One question to one contestant.

    key: scene, engine and method, and what else tells it from the study's other tasks; ask: puts the question; kind:
    the type of the result, where it is of plain values, arrays and dataclasses, so that it can be cached.
    """

    key: Key
    running_engine: RunningEngine
    ask: Callable[[RunningEngine], Result]
    kind: Any = None

    def __str__(self) -> str:
        scene, *contestant = self.key
        return f"{scene} {':'.join(contestant)}"


def run(
    tasks: Sequence[Task[Result]],
    truths: Truths | None = None,
    finished: Callable[[Key, Result], object] = lambda key, result: None,
    on_progress: ProgressCallback = no_progress,
    cached: TaskCache | None = None,
) -> list[Result]:
    """Return the results of all tasks, in the order of the tasks.

    truths: what tasks wait for, which ends with them; finished: called with each result as it comes, one at a time;
    on_progress: called with each finished task; cached: finished tasks are found and saved there.
    Raises what a task or a truth raises; then, as on Ctrl-C, everything is stopped first.
    """
    own: dict[RunningEngine, list[Task[Result]]] = {}
    results: dict[Task[Result], Result] = {}
    one_at_a_time = threading.Lock()

    def record(task: Task[Result], result: Result) -> None:
        results[task] = result
        finished(task.key, result)
        on_progress(str(task))

    for task in tasks:
        before = cached.find(task.key, task.kind) if cached else None
        if before is None:
            own.setdefault(task.running_engine, []).append(task)
        else:
            record(task, before)
    if results:
        log.info(f"continuing: {len(results)} of {len(tasks)} results were finished before")

    def work_through(mine: Sequence[Task[Result]]) -> None:
        for task in mine:
            result = task.ask(task.running_engine)
            with one_at_a_time:
                # A flight that ended because its process was killed is no answer.
                task.running_engine.refuse_halted()
                if cached:
                    cached.save(task.key, result)
                record(task, result)

    for running_engine in own:
        running_engine.resume()
    futures: list[Future] = []
    with ThreadPoolExecutor(max(1, min(len(own), os.cpu_count() or 1))) as threads:
        try:
            # The engine with most tasks is what the others are waited for with at the end, so it begins.
            futures += [threads.submit(work_through, mine) for mine in sorted(own.values(), key=len, reverse=True)]
            for future in wait([*futures, *(truths.futures if truths else ())], return_when=FIRST_EXCEPTION).done:
                future.result()
        except BaseException:
            for future in futures:
                future.cancel()
            for running_engine in own:
                running_engine.halt()
            if truths:
                truths.stop()
            raise
    return [results[task] for task in tasks]
